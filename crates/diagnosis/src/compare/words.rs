//! Sizes and places in words: mm, degrees and N, and where in a set.

use std::f64::consts::{PI, TAU};

use planar::wrap_angle;

use crate::{Condition, Covariate};

/// A size with two significant digits, in the unit for people.
pub(crate) fn size(value: f64, unit: &str) -> String {
    let (value, unit) = match unit {
        "m" => (1e3 * value, " mm"),
        "rad" => (value.to_degrees(), "°"),
        _ => (value, " N"),
    };
    let digits = (1.0 - value.max(1e-9).log10().floor()).clamp(0.0, 4.0) as usize;
    format!("{value:.digits$}{unit}")
}

/// The conditions as they are said: the contact first, edges last.
pub(crate) fn place(conditions: &[Condition]) -> String {
    if conditions.is_empty() {
        return ", everywhere".to_owned();
    }
    let mut ordered: Vec<_> = conditions.iter().collect();
    ordered.sort_by_key(|condition| rank(condition.covariate));
    let (edges, others): (Vec<&Condition>, Vec<&Condition>) =
        ordered.into_iter().partition(|condition| condition.covariate == Covariate::Edge);
    let mut text = String::new();
    for (index, other) in others.iter().enumerate() {
        let at_contact = other.covariate == Covariate::Beta && index > 0;
        let said = condition(other);
        text += &match said.strip_prefix("at ").filter(|_| at_contact) {
            Some(rest) => format!(" with {rest}"),
            None if index == 0 => format!(" {said}"),
            None => format!(", {said}"),
        };
    }
    for edge in edges {
        text += if others.is_empty() { " " } else { ", " };
        text += &condition(edge);
    }
    text
}

fn rank(covariate: Covariate) -> usize {
    Covariate::ALL.iter().position(|known| *known == covariate).unwrap_or_default()
}

fn condition(condition: &Condition) -> String {
    let Condition { covariate, from, to } = *condition;
    match covariate {
        Covariate::P => range("at p", (from, to), 1.0, 2, ""),
        Covariate::Beta => range("at β", (from, to), 1.0_f64.to_degrees(), 0, "°"),
        Covariate::Speed => range("at speed", (from, to), 1e3, 0, " mm/s"),
        Covariate::TableX => range("at table x", (from, to), 1e3, 0, " mm"),
        Covariate::TableY => range("at table y", (from, to), 1e3, 0, " mm"),
        Covariate::Orientation => turned("with the object turned", (from, to)),
        Covariate::Direction => turned("when pushed towards", (from, to)),
        Covariate::Time => match (from, to) {
            (None, Some(to)) => format!("in the first {:.0} % of the set", 100.0 * to),
            (Some(from), None) => format!("in the last {:.0} % of the set", 100.0 * (1.0 - from)),
            _ => range("at share", (from, to), 100.0, 0, " % of the set"),
        },
        Covariate::Edge => {
            let (from, to) = (from.unwrap_or_default(), to.unwrap_or_default());
            if to - from < 0.5 {
                format!("on edge {from:.0} only")
            } else {
                format!("on edges {from:.0} to {to:.0}")
            }
        }
    }
}

/// `at p < 0.20`, `at β > 20°`, `at speed from 20 to 50 mm/s`.
fn range(
    what: &str,
    (from, to): (Option<f64>, Option<f64>),
    per: f64,
    digits: usize,
    unit: &str,
) -> String {
    let number = |value: f64| {
        let text = format!("{:.digits$}", per * value);
        let text = if text.contains('.') { text.trim_end_matches('0') } else { &text };
        text.trim_end_matches('.').replace('-', "−")
    };
    match (from, to) {
        (None, Some(to)) => format!("{what} < {}{unit}", number(to)),
        (Some(from), None) => format!("{what} > {}{unit}", number(from)),
        (Some(from), Some(to)) => format!("{what} from {} to {}{unit}", number(from), number(to)),
        (None, None) => String::new(),
    }
}

/// Angles on the circle, their middle within ± 180°.
fn turned(what: &str, (from, to): (Option<f64>, Option<f64>)) -> String {
    let (from, to) = (from.unwrap_or_default(), to.unwrap_or_default());
    let (low, width) = (wrap_angle(from), to - from);
    // A middle that rounding puts beyond stays.
    let low = if low + 0.5 * width > PI + 1e-6 { low - TAU } else { low };
    range(what, (Some(low), Some(low + width)), 1.0_f64.to_degrees(), 0, "°")
}

#[cfg(test)]
mod tests {
    use super::turned;

    #[test]
    fn angles_are_told_about_a_middle_within_half_a_turn() {
        let told =
            |from: f64, to: f64| turned("at", (Some(from.to_radians()), Some(to.to_radians())));
        assert_eq!(told(150.0, 210.0), "at from 150 to 210°");
        assert_eq!(told(180.0, 450.0), "at from −180 to 90°");
        assert_eq!(told(-30.0, 30.0), "at from −30 to 30°");
    }
}
