//! Sums over rows as plain data.

use faer::{Mat, MatRef};
use gp_core::checks::{check_count, check_outputs};
use gp_core::{GpError, Monomials};
use serde::{Deserialize, Serialize};

use crate::row_sums::RowSums;

/// What a saved process keeps of its rows beside the precision factor, so that it can take in more.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SparseRows {
    /// How many there were.
    pub count: usize,
    /// Subtracted from all outputs, in their unit.
    pub origin: f64,
    /// (y, H)ᵀD⁻¹(V, y, H), one row after the other: M + 1 + P numbers each.
    pub products: Vec<f64>,
    /// HᵀH, by rows.
    pub spread: Vec<f64>,
    /// ln |D|.
    pub log_determinant: f64,
    /// The sum that the objective penalises.
    pub penalty: f64,
}

impl SparseRows {
    pub(crate) fn new(sums: &RowSums, m: usize) -> Self {
        let (width, p) = (sums.square.nrows(), sums.spread.nrows());
        let entry = |i: usize, j: usize| sums.square[(i.max(j), i.min(j))];
        Self {
            count: sums.n_rows,
            origin: sums.origin,
            products: (m..width).flat_map(|i| (0..width).map(move |j| entry(i, j))).collect(),
            spread: (0..p).flat_map(|i| (0..p).map(move |j| sums.spread[(i, j)])).collect(),
            log_determinant: sums.log_determinant,
            penalty: sums.penalty,
        }
    }

    /// - `root`: R, since VᵀD⁻¹V = R Rᵀ − I.
    pub(crate) fn sums(
        &self,
        monomials: &Monomials,
        root: MatRef<'_, f64>,
    ) -> Result<RowSums, GpError> {
        let (m, p) = (root.nrows(), monomials.count());
        let width = m + 1 + p;
        check_count("products of the rows", (1 + p) * width, self.products.len())?;
        check_outputs("products of the rows", &self.products, self.products.len())?;
        check_outputs("spread of the rows", &self.spread, p * p)?;
        let others = [self.origin, self.log_determinant, self.penalty];
        check_outputs("sums of the rows", &others, others.len())?;
        let precision = root * root.transpose();
        let entry = |i: usize, j: usize| match i.checked_sub(m) {
            Some(row) => self.products[row * width + j],
            None if j < m => precision[(i, j)] - f64::from(u8::from(i == j)),
            None => 0.0,
        };
        Ok(RowSums {
            n_rows: self.count,
            origin: self.origin,
            monomials: monomials.clone(),
            square: Mat::from_fn(width, width, entry),
            spread: Mat::from_fn(p, p, |i, j| self.spread[i * p + j]),
            log_determinant: self.log_determinant,
            penalty: self.penalty,
        })
    }
}
