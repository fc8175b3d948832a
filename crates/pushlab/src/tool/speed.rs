//! A speed as people write it, with its unit.

use std::fmt;
use std::ops::RangeInclusive;
use std::str::FromStr;

/// A speed of the pusher from the command line, in m/s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Speed(pub(crate) f64);

/// What the simulated robot is made for, in m/s.
const SPEEDS: RangeInclusive<f64> = 0.001..=1.0;

/// Units with their number in 1 m/s; the one that ends like another comes first.
const UNITS: [(&str, f64); 2] = [("mm/s", 1e3), ("m/s", 1.0)];

impl FromStr for Speed {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let unit = UNITS.iter().find_map(|unit| Some((text.strip_suffix(unit.0)?, unit.1)));
        let number =
            unit.and_then(|(number, per_unit)| Some(number.trim().parse::<f64>().ok()? / per_unit));
        let Some(speed) = number else {
            return Err("expected a speed in mm/s or m/s, such as 20mm/s or 0.1m/s".to_owned());
        };
        if !SPEEDS.contains(&speed) {
            let (low, high) = SPEEDS.into_inner();
            return Err(format!("{speed} m/s is not within {low} to {high} m/s"));
        }
        Ok(Self(speed))
    }
}

impl fmt::Display for Speed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}m/s", self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::Speed;

    #[test]
    fn speeds_have_units_and_a_range() {
        let speed = |text: &str| text.parse::<Speed>();
        assert_eq!(speed("20mm/s"), Ok(Speed(0.02)));
        assert_eq!(speed("0.1 m/s"), Ok(Speed(0.1)));
        assert_eq!(Speed(0.02).to_string().parse(), Ok(Speed(0.02)));
        for text in ["20", "fast", "mm/s", "20 mm", "1e-2"] {
            assert!(speed(text).unwrap_err().contains("such as 20mm/s"), "{text}");
        }
        for text in ["0m/s", "-20mm/s", "nanm/s", "2m/s"] {
            assert!(speed(text).unwrap_err().contains("is not within 0.001 to 1 m/s"), "{text}");
        }
    }
}
