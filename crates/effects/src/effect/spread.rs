//! Parameters that differ from push to push or from place to place.

use serde::{Deserialize, Serialize};

use crate::{EffectError, Parameter};

/// How a parameter is distributed over pushes, or over places of the table.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Spread {
    /// Normally about its value, with this standard deviation in its unit.
    Sd(f64),
    /// Its logarithm normally about that of its value, with this standard deviation.
    RelativeSd(f64),
}

impl Spread {
    /// Largest standard deviation of a logarithm: beyond it a mean says little.
    pub const LARGEST_RELATIVE: f64 = 2.0;

    /// Whether the parameter is the same in all pushes.
    pub fn is_none(self) -> bool {
        let (Self::Sd(sd) | Self::RelativeSd(sd)) = self;
        sd == 0.0
    }

    /// Whether both are of the value, or of its logarithm.
    pub fn is_like(self, other: Self) -> bool {
        matches!(
            (self, other),
            (Self::Sd(_), Self::Sd(_)) | (Self::RelativeSd(_), Self::RelativeSd(_))
        )
    }

    /// With another one like it that is independent of it: the spread of both.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        let (Self::Sd(two) | Self::RelativeSd(two)) = other;
        match self {
            Self::Sd(one) => Self::Sd(one.hypot(two)),
            Self::RelativeSd(one) => Self::RelativeSd(one.hypot(two)),
        }
    }

    /// The share of its variance in that of a spread of which it is a part.
    pub(crate) fn share_of(self, whole: Self) -> f64 {
        let (Self::Sd(part) | Self::RelativeSd(part)) = self;
        let (Self::Sd(whole) | Self::RelativeSd(whole)) = whole;
        (part / whole).powi(2)
    }

    /// The parameter so many standard deviations from its value, within a range; all in its unit.
    pub fn at(self, value: f64, deviations: f64, (low, high): (f64, f64)) -> f64 {
        let moved = match self {
            Self::Sd(sd) => value + sd * deviations,
            Self::RelativeSd(sd) => value * (sd * deviations).exp(),
        };
        moved.max(low).min(high)
    }

    /// Refuses what is no standard deviation of a parameter.
    ///
    /// # Errors
    /// `InvalidValue`.
    pub fn check(self, parameter: &Parameter) -> Result<(), EffectError> {
        let width = parameter.range.1 - parameter.range.0;
        let (name, value, largest, unit) = match self {
            Self::Sd(sd) => ("a parameter's standard deviation", sd, width, parameter.unit),
            Self::RelativeSd(sd) => (
                "the standard deviation of a parameter's logarithm",
                sd,
                Self::LARGEST_RELATIVE,
                "1",
            ),
        };
        if (0.0..=largest).contains(&value) {
            return Ok(());
        }
        let expected = "from 0 to the width of its range (2 for a logarithm)";
        Err(EffectError::InvalidValue { name, expected, value, unit })
    }
}

/// Deviations of `n` independent standard normal numbers with weights that are together 1: means over
/// them of smooth functions are those over the numbers, such as what pushes draw
/// ([`crate::PushPhysics::drawn`]).
///
/// No number has one place, one has five (exact for polynomials of degree nine), more have two on each axis (degree
/// three, five on the axes).
///
/// # Source
/// Abramowitz & Stegun (1964), Handbook of mathematical functions, table 25.10; Julier & Uhlmann (2004),
/// Unscented filtering and nonlinear estimation, Proceedings of the IEEE 92.
pub fn deviations(n: usize) -> Vec<(f64, Vec<f64>)> {
    if n == 0 {
        return vec![(1.0, Vec::new())];
    }
    if n == 1 {
        let five = [
            (-2.856_970_013_872_806, 0.011_257_411_327_720_69),
            (-1.355_626_179_974_266, 0.222_075_922_005_612_6),
            (0.0, 0.533_333_333_333_333_3),
            (1.355_626_179_974_266, 0.222_075_922_005_612_6),
            (2.856_970_013_872_806, 0.011_257_411_327_720_69),
        ];
        return five.map(|(place, weight)| (weight, vec![place])).to_vec();
    }
    let spread = (n as f64).max(3.0);
    let on_axis = |axis: usize, side: f64| {
        let mut place = vec![0.0; n];
        place[axis] = side * spread.sqrt();
        (0.5 / spread, place)
    };
    let middle = (1.0 - n as f64 / spread, vec![0.0; n]);
    let axes = (0..n).flat_map(|axis| [on_axis(axis, -1.0), on_axis(axis, 1.0)]);
    std::iter::once(middle).filter(|(weight, _)| *weight > 0.0).chain(axes).collect()
}

#[cfg(test)]
mod tests {
    use super::deviations;

    #[test]
    fn moments_are_those_of_normal_numbers() {
        for n in 1..=6 {
            let places = deviations(n);
            let mean = |of: &dyn Fn(&[f64]) -> f64| -> f64 {
                places.iter().map(|(weight, place)| weight * of(place)).sum()
            };
            assert!((mean(&|_| 1.0) - 1.0).abs() < 1e-14, "{n}");
            for axis in 0..n {
                assert!(mean(&|z| z[axis]).abs() < 1e-14);
                assert!((mean(&|z| z[axis].powi(2)) - 1.0).abs() < 1e-13, "{n}");
                assert!(mean(&|z| z[axis] * z[(axis + 1) % n]).abs() < 1e-13 || n == 1);
                if n <= 3 {
                    assert!((mean(&|z| z[axis].powi(4)) - 3.0).abs() < 1e-12, "{n}");
                }
            }
        }
        let sixth: f64 = deviations(1).iter().map(|(weight, z)| weight * z[0].powi(6)).sum();
        assert!((sixth - 15.0).abs() < 1e-11);
    }
}
