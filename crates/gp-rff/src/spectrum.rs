//! The spectrum of a kernel, and how frequencies are chosen from it.

use gp_core::{GpError, Kernel, Matern12, Matern32, Matern52, SquaredExponential};
use serde::{Deserialize, Serialize};

/// How frequencies are chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Sampling {
    /// Independently of each other: the thesis.
    Independent,
    /// In orthogonal sets of D.
    ///
    /// # Source
    /// Yu, Suresh, Choromanski, Holtmann-Rice & Kumar, Orthogonal random features (2016).
    Orthogonal,
    /// A low-discrepancy set mapped to the spectrum.
    ///
    /// # Source
    /// Avron, Sindhwani, Yang & Mahoney, Quasi-Monte Carlo feature maps for shift-invariant kernels
    /// (2016).
    #[default]
    LowDiscrepancy,
}

/// The kernel that is approximated, which is the spectrum that frequencies are drawn from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Spectrum {
    /// The squared exponential: ω ~ N(0, diag(l)⁻²). The thesis prints N(0, 1/l).
    #[default]
    SquaredExponential,
    /// Matérn 1/2: ω follows a Student t with 1 degree of freedom.
    Matern12,
    /// Matérn 3/2: ω follows a Student t with 3 degrees of freedom.
    Matern32,
    /// Matérn 5/2: ω follows a Student t with 5 degrees of freedom.
    Matern52,
}

impl Spectrum {
    /// The kernel of this spectrum.
    ///
    /// # Errors
    /// `Empty` without lengthscales; `NotPositive` for a value that is not positive and finite.
    pub fn kernel(
        self,
        lengthscales: &[f64],
        signal_variance: f64,
    ) -> Result<Box<dyn Kernel>, GpError> {
        Ok(match self {
            Self::SquaredExponential => {
                Box::new(SquaredExponential::new(lengthscales, signal_variance)?)
            }
            Self::Matern12 => Box::new(Matern12::new(lengthscales, signal_variance)?),
            Self::Matern32 => Box::new(Matern32::new(lengthscales, signal_variance)?),
            Self::Matern52 => Box::new(Matern52::new(lengthscales, signal_variance)?),
        })
    }

    /// Degrees of freedom of the Student t; none for the normal distribution.
    pub(crate) fn degrees_of_freedom(self) -> Option<u32> {
        match self {
            Self::SquaredExponential => None,
            Self::Matern12 => Some(1),
            Self::Matern32 => Some(3),
            Self::Matern52 => Some(5),
        }
    }

    /// −ln p(ω) of a frequency for lengthscales of 1, up to a constant; its gradient is added.
    pub(crate) fn penalty(self, frequency: &[f64], gradient: &mut [f64]) -> f64 {
        let square: f64 = frequency.iter().map(|entry| entry * entry).sum();
        let (value, factor) = match self.degrees_of_freedom() {
            None => (0.5 * square, 1.0),
            Some(degrees) => {
                let (nu, d) = (f64::from(degrees), frequency.len() as f64);
                (0.5 * (nu + d) * (square / nu).ln_1p(), (nu + d) / (nu + square))
            }
        };
        gradient.iter_mut().zip(frequency).for_each(|(slope, entry)| *slope += factor * entry);
        value
    }
}
