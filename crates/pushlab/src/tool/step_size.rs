//! The length of a step as people write it: a time or a way, with its unit.

use std::fmt;
use std::ops::RangeInclusive;
use std::str::FromStr;

use dataset::StepLength;

/// A step length from the command line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct StepSize(pub(crate) StepLength);

/// Shorter steps hold no samples of any sensor, longer ones no push: in s and in m.
const TIMES: RangeInclusive<f64> = 1e-3..=100.0;
const WAYS: RangeInclusive<f64> = 1e-4..=10.0;

/// Makes a step length of SI units.
type Kind = fn(f64) -> StepLength;

/// Units with their number in an SI unit; those that end like another one come first.
const UNITS: [(&str, f64, Kind); 5] = [
    ("ms", 1e3, StepLength::Time),
    ("s", 1.0, StepLength::Time),
    ("mm", 1e3, StepLength::Distance),
    ("cm", 1e2, StepLength::Distance),
    ("m", 1.0, StepLength::Distance),
];

impl FromStr for StepSize {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let unit = UNITS.iter().find_map(|unit| Some((text.strip_suffix(unit.0)?, unit)));
        let number =
            unit.and_then(|(number, unit)| Some((number.trim().parse::<f64>().ok()?, unit)));
        let Some((number, (_, per_unit, kind))) = number else {
            return Err("expected a time in s or ms, or a way of the pusher in m, cm or mm, \
                        such as 200ms, 0.2s or 4mm"
                .to_owned());
        };
        let step = kind(number / per_unit);
        let (value, range, unit) = match step {
            StepLength::Time(time) => (time, TIMES, "s"),
            StepLength::Distance(way) => (way, WAYS, "m"),
        };
        if !range.contains(&value) {
            let (low, high) = range.into_inner();
            return Err(format!("{value} {unit} is not within {low} to {high} {unit}"));
        }
        Ok(Self(step))
    }
}

impl fmt::Display for StepSize {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            StepLength::Time(time) => write!(f, "{time}s"),
            StepLength::Distance(way) => write!(f, "{way}m"),
        }
    }
}

#[cfg(test)]
mod tests {
    use dataset::StepLength;

    use super::StepSize;

    #[test]
    fn times_and_ways_have_units() {
        let step = |text: &str| text.parse::<StepSize>().unwrap().0;
        assert_eq!(step("200ms"), StepLength::Time(0.2));
        assert_eq!(step("0.2s"), StepLength::Time(0.2));
        assert_eq!(step("0.2 s"), StepLength::Time(0.2));
        assert_eq!(step("4mm"), StepLength::Distance(0.004));
        assert_eq!(step("4e-1cm"), StepLength::Distance(0.004));
        assert_eq!(step("0.004m"), StepLength::Distance(0.004));
        assert_eq!(StepSize(step("70ms")).to_string(), "0.07s");
    }

    #[test]
    fn what_is_no_step_is_refused_with_what_would_be() {
        let error = |text: &str| text.parse::<StepSize>().unwrap_err();
        for text in ["", "200", "ms", "4 inch", "fast", "4mms"] {
            assert!(error(text).contains("such as 200ms, 0.2s or 4mm"), "{text}");
        }
        for text in ["0s", "-1s", "nans", "infm", "1e-9ms", "1e400m", "20m"] {
            assert!(error(text).contains("is not within"), "{text}");
        }
        assert_eq!(error("0.01ms"), "0.00001 s is not within 0.001 to 100 s");
    }
}
