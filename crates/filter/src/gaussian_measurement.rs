//! Measurements of a function of the state, with Gaussian noise.

use std::f64::consts::{PI, TAU};

use nalgebra::{DMatrix, DVector};

use crate::{FilterError, Gaussian, MeasurementModel};

/// A measurement z = h(x) + v that was made of a state x, with Gaussian noise v.
///
/// One that is written once serves all: Gaussians and mixtures of vectors are updated by it, by points
/// ([`Gaussian::updated_by`]) or by its Jacobian ([`DifferentiableMeasurement`]), and particles of any
/// state are weighed, as it is a [`MeasurementModel`].
pub trait GaussianMeasurement: Sync {
    /// What is measured; a `DVector<f64>` for Gaussians.
    type State;

    /// z.
    fn measured(&self) -> &DVector<f64>;

    /// v: what is measured beyond h(x). Its mean is the sensor's bias.
    fn noise(&self) -> &Gaussian;

    /// h(x), of as many coordinates as z.
    ///
    /// # Errors
    /// Where the state is none that can be measured.
    fn expected(&self, state: &Self::State) -> Result<DVector<f64>, FilterError>;

    /// Which coordinates of z are angles in rad, counted from 0.
    fn angles(&self) -> &[usize] {
        &[]
    }

    /// How far one value of z is from another: a − b, of angles in (−π, π].
    fn residual(&self, a: &DVector<f64>, b: &DVector<f64>) -> DVector<f64> {
        let mut off = a - b;
        for k in self.angles().iter().filter(|k| **k < a.len()) {
            let turned = off[*k].rem_euclid(TAU);
            off[*k] = if turned > PI { turned - TAU } else { turned };
        }
        off
    }
}

/// A measurement whose h has a derivative: what the extended Kalman filter needs.
pub trait DifferentiableMeasurement: GaussianMeasurement<State = DVector<f64>> {
    /// The Jacobian of h, with a row for each coordinate of z and a column for each of x.
    ///
    /// # Errors
    /// As [`GaussianMeasurement::expected`].
    fn jacobian(&self, state: &DVector<f64>) -> Result<DMatrix<f64>, FilterError>;
}

/// The log density of the noise that is left, in nats; a model that fails gives NaN, which a filter
/// refuses with the number of the particle.
impl<Z: GaussianMeasurement> MeasurementModel for Z {
    type State = Z::State;

    fn log_likelihood(&self, state: &Self::State) -> f64 {
        let seen = self.measured();
        let expected = self.expected(state).ok().filter(|expected| expected.len() == seen.len());
        let density = |expected| self.noise().log_density(&self.residual(seen, &expected)).ok();
        expected.and_then(density).unwrap_or(f64::NAN)
    }
}

/// A measurement z = H x + v.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearMeasurement {
    measured: DVector<f64>,
    matrix: DMatrix<f64>,
    noise: Gaussian,
    angles: Vec<usize>,
}

impl LinearMeasurement {
    /// A measurement of `matrix` · x with noise.
    ///
    /// # Errors
    /// `ShapeMismatch` if H has another number of rows than z, or the noise another dimension;
    /// `NotFinite` for a number that is none.
    pub fn new(
        measured: DVector<f64>,
        matrix: DMatrix<f64>,
        noise: Gaussian,
    ) -> Result<Self, FilterError> {
        let expected = measured.len();
        for (what, actual) in [
            ("rows of the measurement's matrix", matrix.nrows()),
            ("dimension of the measurement's noise", noise.mean().len()),
        ] {
            if actual != expected {
                return Err(FilterError::ShapeMismatch { what, expected, actual });
            }
        }
        finite("a measured value", &measured)?;
        finite("an entry of the measurement's matrix", &matrix)?;
        Ok(Self { measured, matrix, noise, angles: Vec::new() })
    }

    /// The same, where some coordinates of z are angles in rad: their residuals are in (−π, π].
    ///
    /// # Errors
    /// `OutOfRange` for a coordinate that z has not.
    pub fn with_angles(self, angles: &[usize]) -> Result<Self, FilterError> {
        match angles.iter().find(|k| **k >= self.measured.len()) {
            Some(k) => {
                let (name, expected) = ("coordinate of an angle", "one of the measurement's");
                Err(FilterError::OutOfRange { name, expected, value: *k as f64 })
            }
            None => Ok(Self { angles: angles.to_vec(), ..self }),
        }
    }
}

impl GaussianMeasurement for LinearMeasurement {
    type State = DVector<f64>;

    fn measured(&self) -> &DVector<f64> {
        &self.measured
    }

    fn noise(&self) -> &Gaussian {
        &self.noise
    }

    fn expected(&self, state: &DVector<f64>) -> Result<DVector<f64>, FilterError> {
        Ok(self.jacobian(state)? * state)
    }

    fn angles(&self) -> &[usize] {
        &self.angles
    }
}

impl DifferentiableMeasurement for LinearMeasurement {
    fn jacobian(&self, state: &DVector<f64>) -> Result<DMatrix<f64>, FilterError> {
        let (expected, actual) = (state.len(), self.matrix.ncols());
        if actual != expected {
            let what = "columns of the measurement's matrix";
            return Err(FilterError::ShapeMismatch { what, expected, actual });
        }
        Ok(self.matrix.clone())
    }
}

/// The error of the first number that is none.
pub(crate) fn finite<'a>(
    what: &'static str,
    values: impl IntoIterator<Item = &'a f64>,
) -> Result<(), FilterError> {
    let wrong = values.into_iter().find(|value| !value.is_finite());
    wrong.map_or(Ok(()), |value| Err(FilterError::NotFinite { what, value: *value }))
}
