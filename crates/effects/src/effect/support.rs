//! The limit surface of a moment, as a change of a nominal one.

use nalgebra::{Matrix2, Vector2};

use crate::EffectError;
use crate::error::positive;

/// Gathered changes of the friction with the table: effects scale or add to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Support {
    /// Coefficient of friction.
    pub friction: f64,
    /// Characteristic length over its nominal value.
    pub length_ratio: f64,
    /// λ, 0 to 1: 0 for the ellipsoid (or the given surface), 1 for the exact surface of uniform
    /// pressure.
    pub shape: f64,
    /// Center of friction from its nominal place, in m, axes of the outline.
    pub center_o: Vector2<f64>,
    /// How friction depends on direction, axes of the outline.
    pub tensor_o: LogTensor,
}

impl Support {
    pub(crate) fn nominal(friction: f64, shape: f64) -> Self {
        let (center_o, tensor_o) = (Vector2::zeros(), LogTensor::default());
        Self { friction, length_ratio: 1.0, shape, center_o, tensor_o }
    }

    /// The same, if it is a support that there can be.
    ///
    /// # Errors
    /// `InvalidValue`.
    pub(crate) fn checked(self) -> Result<Self, EffectError> {
        positive("the ratio of the characteristic lengths", self.length_ratio, "(dimensionless)")?;
        if (0.0..=1.0).contains(&self.shape) {
            return Ok(self);
        }
        let (name, expected) = ("the shape of the limit surface", "between 0 and 1");
        let (value, unit) = (self.shape, "(dimensionless)");
        Err(EffectError::InvalidValue { name, expected, value, unit })
    }
}

/// The logarithm of a symmetric friction tensor of determinant one: [[a, b], [b, −a]].
///
/// Friction along a unit vector u is |exp(L) u| times the mean; the force of sliding along v is
/// T² v/|T v| with T = exp(L). Sums of logarithms do not depend on their order.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LogTensor {
    /// e cos 2φ.
    pub cosine: f64,
    /// e sin 2φ.
    pub sine: f64,
}

impl LogTensor {
    /// Friction `ratio` times larger along `direction`, in rad, than across it.
    pub fn axis(ratio: f64, direction: f64) -> Self {
        let (e, twice) = (0.5 * ratio.ln(), 2.0 * direction);
        Self { cosine: e * twice.cos(), sine: e * twice.sin() }
    }

    /// Whether friction is the same in all directions.
    pub(crate) fn is_zero(&self) -> bool {
        self.cosine == 0.0 && self.sine == 0.0
    }

    /// exp(`power` L).
    pub(crate) fn exp(&self, power: f64) -> Matrix2<f64> {
        if self.is_zero() {
            return Matrix2::identity();
        }
        let e = self.cosine.hypot(self.sine);
        let (mean, share) = ((power * e).cosh(), (power * e).sinh() / e);
        let (a, b) = (share * self.cosine, share * self.sine);
        Matrix2::new(mean + a, b, b, mean - a)
    }
}

impl std::ops::AddAssign for LogTensor {
    fn add_assign(&mut self, other: Self) {
        self.cosine += other.cosine;
        self.sine += other.sine;
    }
}

#[cfg(test)]
mod tests {
    use super::LogTensor;
    use nalgebra::{Matrix2, Vector2};

    #[test]
    fn the_tensor_has_its_ratio_along_its_direction() {
        let tensor = LogTensor::axis(1.44, 0.6).exp(1.0);
        let along = Vector2::new(0.6_f64.cos(), 0.6_f64.sin());
        assert!((tensor * along - 1.2 * along).norm() < 1e-15);
        assert!((tensor.determinant() - 1.0).abs() < 1e-15);
        let twice = LogTensor::axis(1.44, 0.6).exp(2.0);
        assert!((tensor * tensor - twice).norm() < 1e-15);
    }

    #[test]
    fn no_anisotropy_is_exactly_the_identity() {
        assert_eq!(LogTensor::axis(1.0, 0.6).exp(2.0), Matrix2::identity());
    }
}
