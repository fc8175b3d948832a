//! Weighted residuals and their derivatives, as a function of what a fit moves.

use nalgebra::{DMatrix, DVector};

use super::free_spread::FreeSpread;
use super::robust::Robust;
use super::space::Space;
use crate::{DiagnosisError, Whitening};

/// What is minimised, over some of the numbers of a space.
#[derive(Clone, Debug)]
pub(super) struct Problem<'a> {
    pub(super) space: Space<'a>,
    pub(super) whitening: &'a Whitening,
    pub(super) robust: Robust,
    /// The numbers that stay where they are.
    pub(super) frozen: Vec<bool>,
    /// The numbers that may be at an end of their range and are known there as within it.
    pub(super) shares: Vec<bool>,
    pub(super) ranges: Vec<(f64, f64)>,
    pub(super) secants: Vec<f64>,
}

/// Where one stands: a place, the residuals there with the priors' strains below, and their sum.
#[derive(Clone, Debug)]
pub(super) struct Evaluation {
    pub(super) x: Vec<f64>,
    pub(super) z: DVector<f64>,
    pub(super) value: f64,
}

impl<'a> Problem<'a> {
    pub(super) fn new(space: Space<'a>, whitening: &'a Whitening, robust: Robust) -> Self {
        Self {
            frozen: space.of_each(|member| member.frozen(), |_| false),
            shares: space.of_each(|member| member.shares(), |_| false),
            ranges: space.of_each(|member| member.ranges(), FreeSpread::range),
            secants: space.of_each(|member| member.secants(), FreeSpread::secant),
            space,
            whitening,
            robust,
        }
    }

    /// The numbers that are moved.
    pub(super) fn moved(&self) -> Vec<usize> {
        (0..self.frozen.len()).filter(|k| !self.frozen[*k]).collect()
    }

    /// Whitened residuals of the data, then the strains of the priors.
    ///
    /// # Errors
    /// What a prediction refuses.
    pub(super) fn residuals(&self, x: &[f64]) -> Result<DVector<f64>, DiagnosisError> {
        let data = self.whitening.whiten_residuals(&self.space.residuals(x)?);
        let strains = self.space.strains(x);
        Ok(DVector::from_iterator(data.len() + strains.len(), data.iter().copied().chain(strains)))
    }

    /// # Errors
    /// What a prediction refuses.
    pub(super) fn stand(&self, x: Vec<f64>) -> Result<Evaluation, DiagnosisError> {
        let z = self.residuals(&x)?;
        let value = self.robust.value(&z);
        Ok(Evaluation { x, z, value })
    }

    /// −∂z/∂x of the moved numbers, by secants of half-widths `widths` that stay within the ranges.
    ///
    /// A side that the mechanics refuse is left out.
    ///
    /// # Errors
    /// What a prediction refuses on both sides.
    pub(super) fn slopes(
        &self,
        at: &Evaluation,
        widths: &[f64],
    ) -> Result<DMatrix<f64>, DiagnosisError> {
        let moved = self.moved();
        let mut slopes = DMatrix::zeros(at.z.len(), moved.len());
        for (column, &k) in moved.iter().enumerate() {
            let (low, high) = self.ranges[k];
            let side = |width: f64| {
                let mut x = at.x.clone();
                x[k] = (x[k] + width).clamp(low, high);
                let moved = x[k];
                (moved != at.x[k]).then(|| Ok((moved, self.residuals(&x)?)))
            };
            let sides = [side(-widths[k]), side(widths[k])];
            let mut ends: Vec<(f64, DVector<f64>)> = Vec::new();
            let mut refused = None;
            for end in sides.into_iter().flatten() {
                match end {
                    Ok(end) => ends.push(end),
                    Err(error) => refused = Some(error),
                }
            }
            match (ends.as_slice(), refused) {
                ([], None) => {}
                ([], Some(error)) => return Err(error),
                ([end], _) => slopes.set_column(column, &((&at.z - &end.1) / (end.0 - at.x[k]))),
                ([low, high, ..], _) => {
                    slopes.set_column(column, &((&low.1 - &high.1) / (high.0 - low.0)));
                }
            }
        }
        Ok(slopes)
    }
}
