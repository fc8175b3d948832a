//! A positive number of each input, or one that they share.

use serde::{Deserialize, Serialize};

use super::{Parameter, Role};
use crate::GpError;
use crate::checks::check_count;

/// A parameter of a kernel that belongs to its inputs: saved as a number or as a list.
///
/// Kernels with one number for all inputs take inputs with any number of coordinates.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum PerInput {
    /// The same for all inputs: isotropic.
    Shared(f64),
    /// One an input.
    Each(Vec<f64>),
}

impl PerInput {
    /// The number of input `d`.
    pub fn of(&self, d: usize) -> f64 {
        self.as_slice()[self.slot(d)]
    }

    /// All numbers: one, or one an input.
    pub fn as_slice(&self) -> &[f64] {
        match self {
            Self::Shared(value) => std::slice::from_ref(value),
            Self::Each(values) => values,
        }
    }

    /// The place of input `d` in the slice.
    pub fn slot(&self, d: usize) -> usize {
        if matches!(self, Self::Shared(_)) { 0 } else { d }
    }

    /// How many parameters these are.
    pub fn n_parameters(&self) -> usize {
        self.as_slice().len()
    }

    /// The same kind with other values, of which there are as many.
    #[must_use]
    pub fn with_values(&self, values: &[f64]) -> Self {
        match self {
            Self::Shared(_) => Self::Shared(values[0]),
            Self::Each(_) => Self::Each(values.to_vec()),
        }
    }

    /// Checks that there is a number for each of `n_inputs` inputs.
    ///
    /// # Errors
    /// `Empty` without numbers; `ShapeMismatch`.
    pub fn check(&self, n_inputs: usize) -> Result<(), GpError> {
        match self {
            Self::Shared(_) => Ok(()),
            Self::Each(values) if values.is_empty() => {
                Err(GpError::Empty { what: "parameters of a kernel" })
            }
            Self::Each(values) => check_count("columns of the inputs", values.len(), n_inputs),
        }
    }

    /// One parameter a number: `name`, or `name[0]`, `name[1]` and so on.
    ///
    /// - `role`: from the inputs that it belongs to; none are all.
    pub fn parameters(&self, name: &str, role: impl Fn(Vec<usize>) -> Role) -> Vec<Parameter> {
        match self {
            Self::Shared(value) => vec![Parameter::new(name, *value, role(Vec::new()))],
            Self::Each(values) => (values.iter().enumerate())
                .map(|(d, value)| Parameter::new(format!("{name}[{d}]"), *value, role(vec![d])))
                .collect(),
        }
    }

    /// Σ_d ((a_d − b_d)/l_d)².
    pub(super) fn squared_distance(&self, a: &[f64], b: &[f64]) -> f64 {
        a.iter().zip(b).enumerate().fold(0.0, |sum, (d, (a, b))| {
            let scaled = (a - b) * self.of(d).recip();
            sum + scaled * scaled
        })
    }
}

impl From<&[f64]> for PerInput {
    fn from(values: &[f64]) -> Self {
        Self::Each(values.to_vec())
    }
}
