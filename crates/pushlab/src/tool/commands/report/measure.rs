//! Numbers of a step in the units of people.

use diagnosis::Covariate;

/// How a number is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Measure {
    /// Number of SI units in one of these.
    pub(super) per: f64,
    /// With a space before it where it needs one.
    pub(super) unit: &'static str,
}

impl Measure {
    /// Of a number with this SI unit.
    pub(super) fn of(unit: &'static str) -> Self {
        match unit {
            "m" => Self { per: 1e3, unit: " mm" },
            "rad" => Self { per: 1.0_f64.to_degrees(), unit: "°" },
            "m/s" => Self { per: 1e3, unit: " mm/s" },
            "N" => Self { per: 1.0, unit: " N" },
            _ => Self { per: 1.0, unit: "" },
        }
    }

    /// Three significant digits, with the unit.
    pub(super) fn text(self, value: f64) -> String {
        let value = self.per * value;
        format!("{value:.*}{}", digits(value), self.unit).replace('-', "−")
    }

    /// The same without the unit, where a head states it.
    pub(super) fn number(self, value: f64) -> String {
        Self { unit: "", ..self }.text(value)
    }

    /// As [`Measure::plus_minus`] without the unit.
    pub(super) fn error(self, value: f64, half: f64) -> String {
        Self { unit: "", ..self }.plus_minus(value, half)
    }

    /// A value with its sign.
    pub(super) fn signed(self, value: f64) -> String {
        let value = self.per * value;
        format!("{value:+.*}{}", digits(value), self.unit).replace('-', "−")
    }

    /// The value with an interval or an error in as many digits as the error has.
    pub(super) fn plus_minus(self, value: f64, half: f64) -> String {
        let (value, half) = (self.per * value, self.per * half);
        let digits = if half > 0.0 { (digits(half) - 1).max(1) } else { digits(value) };
        format!("{value:+.digits$} ± {half:.digits$}{}", self.unit).replace('-', "−")
    }

    /// `in mm`, for labels of axes.
    pub(super) fn label(self, what: &str) -> String {
        match self.unit.trim() {
            "" => what.to_owned(),
            unit => format!("{what} in {unit}"),
        }
    }
}

/// Digits behind the point for three significant ones.
fn digits(value: f64) -> usize {
    if value == 0.0 || !value.is_finite() {
        return 2;
    }
    (2.0 - value.abs().log10().floor()).clamp(0.0, 6.0) as usize
}

/// What a number of a step is called.
pub(super) fn title(name: &str) -> &'static str {
    match name {
        "dx" => "Δx along the push",
        "dy" => "Δy to its left",
        "dtheta" => "turn Δθ",
        "force_normal" => "normal force",
        "force_tangential" => "tangential force",
        "gap_start" => "gap at the start",
        "gap_end" => "gap at the end",
        "drift" => "drift in the model’s sense",
        "turn" => "turn in the model’s sense",
        _ => "another number",
    }
}

/// What links call a covariate.
pub(super) fn key(covariate: Covariate) -> &'static str {
    match covariate {
        Covariate::P => "p",
        Covariate::Beta => "beta",
        Covariate::Speed => "speed",
        Covariate::Orientation => "orientation",
        Covariate::Direction => "direction",
        Covariate::TableX => "table_x",
        Covariate::TableY => "table_y",
        Covariate::Time => "time",
        Covariate::Edge => "edge",
    }
}

/// The range of a cell, in SI units, in those of the covariate's axis; one without width gets one.
pub(super) fn shown_range(over: Covariate, ends: [f64; 2]) -> [f64; 2] {
    let [from, to] = ends.map(|end| Measure::of(over.unit()).per * end);
    if from < to {
        return [from, to];
    }
    let half = (0.02 * from.abs()).max(1e-3);
    [from - half, to + half]
}

/// The same in words; an edge has one number.
pub(super) fn range_text(over: Covariate, ends: [f64; 2]) -> String {
    let [from, to] = shown_range(over, ends);
    // Shares have more digits than mm and degrees.
    let digits = if over.unit() == "1" { 3 } else { 1 };
    let number = |value: f64| {
        let text = format!("{value:.digits$}");
        text.trim_end_matches('0').trim_end_matches('.').replace('-', "−")
    };
    match over {
        Covariate::Edge => format!("{:.0}", 0.5 * (from + to)),
        _ => format!("{} to {}", number(from), number(to)),
    }
}

/// A value in six digits, for files.
pub(super) fn rounded(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

/// What a covariate is called, with the unit that its axis has.
pub(super) fn covariate(covariate: Covariate) -> &'static str {
    match covariate {
        Covariate::P => "place p along the edge",
        Covariate::Beta => "angle β of the push in °",
        Covariate::Speed => "speed of the pusher in mm/s",
        Covariate::Orientation => "yaw of the object in °",
        Covariate::Direction => "direction of the push on the table in °",
        Covariate::TableX => "x on the table in mm",
        Covariate::TableY => "y on the table in mm",
        Covariate::Time => "share of the set",
        Covariate::Edge => "edge",
    }
}

#[cfg(test)]
mod tests {
    use super::{Measure, range_text};
    use diagnosis::Covariate;

    #[test]
    fn ranges_have_the_digits_that_matter() {
        assert_eq!(range_text(Covariate::TableX, [-0.0749671, 0.06]), "−75 to 60");
        assert_eq!(range_text(Covariate::P, [0.0, 0.125]), "0 to 0.125");
        assert_eq!(range_text(Covariate::Edge, [2.5, 3.5]), "3");
    }

    #[test]
    fn numbers_have_the_units_and_digits_of_people() {
        assert_eq!(Measure::of("m").text(1.234e-4), "0.123 mm");
        assert_eq!(Measure::of("rad").text(0.02), "1.15°");
        assert_eq!(Measure::of("N").signed(-2.0512), "−2.05 N");
        assert_eq!(Measure::of("m").plus_minus(-1.234e-4, 2.3e-6), "−0.1234 ± 0.0023 mm");
        assert_eq!(Measure::of("m/s").label("speed"), "speed in mm/s");
        assert_eq!(Measure::of("1").text(0.0), "0.00");
    }
}
