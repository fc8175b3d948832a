//! Inputs in the forms that users have them in.

use faer::{Mat, MatRef};

/// Inputs, N×D: a `faer` matrix, rows of D numbers, or plain numbers, which are one input each.
#[derive(Clone, Copy, Debug)]
pub struct Inputs<'a>(MatRef<'a, f64>);

impl<'a> Inputs<'a> {
    /// As a matrix, one input a row.
    pub fn matrix(self) -> MatRef<'a, f64> {
        self.0
    }
}

impl<'a> From<MatRef<'a, f64>> for Inputs<'a> {
    fn from(x: MatRef<'a, f64>) -> Self {
        Self(x)
    }
}

impl<'a> From<&'a Mat<f64>> for Inputs<'a> {
    fn from(x: &'a Mat<f64>) -> Self {
        Self(x.as_ref())
    }
}

impl<'a> From<&'a [f64]> for Inputs<'a> {
    fn from(x: &'a [f64]) -> Self {
        Self(MatRef::from_column_major_slice(x, x.len(), 1))
    }
}

impl<'a> From<&'a Vec<f64>> for Inputs<'a> {
    fn from(x: &'a Vec<f64>) -> Self {
        x.as_slice().into()
    }
}

impl<'a, const N: usize> From<&'a [f64; N]> for Inputs<'a> {
    fn from(x: &'a [f64; N]) -> Self {
        x.as_slice().into()
    }
}

impl<'a, const D: usize> From<&'a [[f64; D]]> for Inputs<'a> {
    fn from(x: &'a [[f64; D]]) -> Self {
        Self(MatRef::from_row_major_slice(x.as_flattened(), x.len(), D))
    }
}

impl<'a, const D: usize> From<&'a Vec<[f64; D]>> for Inputs<'a> {
    fn from(x: &'a Vec<[f64; D]>) -> Self {
        x.as_slice().into()
    }
}
