//! The answer in words.

use effects::{by_id, readable_unit};

use super::claims::Claims;
use super::leftover::Left;
use super::{EffectFinding, ErrorFall, Grade, ParameterFinding, PushScatter, Verdict};
use crate::Remains;
use crate::cut_offs::MOST_OF_NOISE;

/// One or two sentences that say what the verdict says, with sizes in mm, degrees and ms.
pub(super) fn sentence(
    claims: &Claims,
    effects: &[EffectFinding],
    error: &ErrorFall,
    (left, remains): (&Left, Option<&Remains>),
    push_to_push: &[PushScatter],
) -> String {
    let told = |id: &str| told(id, effects);
    let mut text = verdict(claims, effects, error);
    if let Some(where_) = left.told().filter(|_| claims.is_left) {
        let what = match claims.verdict {
            Verdict::Unexplained => "Most of all it",
            _ => "Something is left that no effect explains: the model",
        };
        text += &format!(" {what} {where_}.{}", mostly_from(left, remains));
    }
    if !claims.small.is_empty() {
        let small: Vec<String> = claims.small.iter().map(|(id, ..)| told(id)).collect();
        text += &format!(" There as well, though hardly seen: {}.", small.join("; and "));
    }
    if let Some(most) = push_to_push.first().filter(|one| one.share > MOST_OF_NOISE) {
        text += &format!(" {}", most.told());
    }
    if claims.verdict == Verdict::Inconclusive && left.is_far_off() {
        text += &format!(
            " Some pushes are missed by far more than their noise (error {:.1} times the noise), \
             too few to tell what they share: `pushlab compare` lists the worst.",
            error.after
        );
    }
    text
}

impl PushScatter {
    /// As "Most of what is noise to the model comes from … (friction-center-offset), which differs by
    /// 2.90 mm (2.61 to 3.12) from push to push."
    fn told(&self) -> String {
        let Self { effect, sd, low95, high95, .. } = self;
        let title =
            by_id(effect).map_or(effect.to_lowercase(), |known| known.info().title.to_lowercase());
        let (unit, scale) = unit(&self.unit);
        let [sd, low, high] = [sd, low95, high95].map(|value| rounded(value * scale));
        format!(
            "Most of what is noise to the model comes from {title} ({effect}), which differs by {sd}{unit} \
             ({low} to {high}) from push to push."
        )
    }
}

/// What the verdict says.
fn verdict(claims: &Claims, effects: &[EffectFinding], error: &ErrorFall) -> String {
    let told = |id: &str| told(id, effects);
    let list = |ids: &[&'static str]| ids.iter().map(|id| told(id)).collect::<Vec<_>>();
    match claims.verdict {
        Verdict::Identified => {
            let mut text = format!("Missing: {}", list(&claims.identified).join("; and "));
            for group in &claims.groups {
                text += &format!("; and one of: {}", list(group).join("; "));
            }
            if !claims.effective.is_empty() {
                text += &format!(". {}", lowers(&claims.effective, &told));
            }
            format!("{text}. {}", fall(error))
        }
        Verdict::Ambiguous => {
            let groups: Vec<String> =
                claims.groups.iter().map(|group| list(group).join("; or ")).collect();
            let groups = groups.join(". And one of: ");
            format!(
                "Missing is one of these, and the pushes cannot tell which: {groups}. {}",
                fall(error)
            )
        }
        Verdict::Effective => {
            let what = lowers(&claims.effective, &told);
            format!("{what}. {}", fall(error))
        }
        Verdict::Unexplained => {
            "The model fails in a way that no effect of the library explains.".to_owned()
        }
        Verdict::NoneFound => {
            "Nothing is missing that these pushes could show; the limits of each effect stand \
             below."
                .to_owned()
        }
        Verdict::Inconclusive => {
            let hints = effects.iter().filter(|effect| effect.grade == Grade::Hint);
            let hints: Vec<&str> = hints.map(|effect| effect.id.as_str()).collect();
            let of =
                if hints.is_empty() { String::new() } else { format!(" of {}", hints.join(", ")) };
            format!(
                "There are hints{of}, but nothing that these pushes make sure; more pushes would."
            )
        }
    }
}

/// An effect in words.
fn told(id: &str, effects: &[EffectFinding]) -> String {
    effects.iter().find(|effect| effect.id == id).map_or(id.into(), with_size)
}

/// As "The error falls with …, but its cause may be another one: …".
fn lowers(effective: &[(&'static str, String)], told: &impl Fn(&str) -> String) -> String {
    let all: Vec<String> = effective.iter().map(|(id, _)| told(id)).collect();
    let mut why: Vec<&str> = effective.iter().map(|(_, why)| why.as_str()).collect();
    why.dedup();
    format!(
        "The error falls with {}, but the cause may be another one: {}",
        all.join("; and with "),
        why.join("; ")
    )
}

/// What of the rig most of what is left comes from, if any is sure to.
fn mostly_from(left: &Left, remains: Option<&Remains>) -> String {
    match (left.origin_of_far_off(), remains.and_then(Remains::main)) {
        (Some(origin), _) => format!(" What they share speaks of the {}.", origin.name()),
        (None, Some(main)) => {
            format!(" Of what can be predicted of it most comes from the {}.", main.origin.name())
        }
        (None, None) => left.origin_of_place().map_or_else(String::new, |origin| {
            format!(" Where it shows speaks of the {}.", origin.name())
        }),
    }
}

/// What adding the effects does to the error.
fn fall(error: &ErrorFall) -> String {
    let ErrorFall { before, after, .. } = error;
    match error.gap_closed {
        Some(share) if share <= 0.0 => format!(
            "Held-out pushes are likelier with it, but the error does not fall ({before:.2} before, \
             {after:.2} after, in units of the noise): some of them are missed by far more than the \
             others."
        ),
        Some(share) => format!(
            "On held-out pushes this closes {:.0} % of the gap to the noise floor \
             (error {before:.2} before, {after:.2} after, in units of the noise).",
            100.0 * share
        ),
        None => format!(
            "On held-out pushes the error falls from {before:.2} to {after:.2} times \
             the noise."
        ),
    }
}

const MOST_SIZES: usize = 4;

/// As "friction along a direction of the table (table-anisotropy): ratio 1.34 (1.31 to 1.37), …".
fn with_size(effect: &EffectFinding) -> String {
    let id = &effect.id;
    let title = by_id(id).map_or(String::new(), |known| known.info().title.to_lowercase());
    // Many are no sizes that a person reads in a sentence.
    let few = effect.parameters.iter().filter(|_| effect.parameters.len() <= MOST_SIZES);
    let sizes: Vec<String> = few.filter_map(size).collect();
    let name = if title.is_empty() { id.clone() } else { format!("{title} ({id})") };
    if sizes.is_empty() { name } else { format!("{name}: {}", sizes.join(", ")) }
}

/// As "ratio 1.34 (1.31 to 1.37)"; a speed at which a law sets in may be left open.
fn size(parameter: &ParameterFinding) -> Option<String> {
    let (unit, scale) = unit(&parameter.unit);
    let value = rounded(parameter.estimate? * scale);
    let ends = match parameter.low95.zip(parameter.high95) {
        Some((low, high)) => format!(" ({} to {})", rounded(low * scale), rounded(high * scale)),
        None if parameter.off.is_none() => " (left open)".to_owned(),
        None => String::new(),
    };
    Some(format!("{} {value}{unit}{ends}", parameter.name))
}

/// What stands behind a value for people, and how many of it are one of an SI unit.
fn unit(si: &str) -> (String, f64) {
    let (scale, unit) = readable_unit(si);
    let behind = match unit {
        "" | "°" => unit.to_owned(),
        unit => format!(" {unit}"),
    };
    (behind, scale)
}

/// Three significant digits.
fn rounded(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let digits = 2 - value.abs().log10().floor() as i32;
    format!("{value:.*}", digits.clamp(0, 8) as usize)
}

#[cfg(test)]
mod tests {
    use super::{rounded, size};
    use crate::ParameterFinding;

    #[test]
    fn a_size_is_told_with_its_interval_or_that_it_is_open() {
        let found = |unit: &str, ends: Option<(f64, f64)>, off| ParameterFinding {
            name: "v0".to_owned(),
            unit: unit.to_owned(),
            off,
            estimate: Some(0.00226),
            se: Some(0.003),
            low95: ends.map(|ends| ends.0),
            high95: ends.map(|ends| ends.1),
            detection_limit: None,
        };
        let told = |unit, ends, off| size(&found(unit, ends, off)).unwrap();
        assert_eq!(told("m/s", Some((0.001, 0.01)), None), "v0 2.26 mm/s (1.00 to 10.0)");
        assert_eq!(told("m/s", None, None), "v0 2.26 mm/s (left open)");
        assert_eq!(told("m/s²", None, Some(0.0)), "v0 0.0132°");
    }

    #[test]
    fn sizes_have_three_digits() {
        let cases = [(1.3399, "1.34"), (-0.012345, "-0.0123"), (34.04, "34.0"), (412.7, "413")];
        for (value, text) in cases {
            assert_eq!(rounded(value), text);
        }
    }
}
