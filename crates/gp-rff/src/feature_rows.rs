//! Blocks of rows of features, and the products that sums over rows are made of.

use faer::linalg::matmul::matmul as dense;
use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::{Accum, Mat, MatRef, Par};
use gp_core::Monomials;
use gp_core::kernel::{column, column_mut};
use gp_core::vector::multiply;

use crate::{Form, RandomFeatures};

/// A block of rows (Φ, y, H), and memory for their products; H is what the mean is a sum of, 1 first.
pub(crate) struct FeatureRows {
    n: usize,
    monomials: Monomials,
    values: Mat<f64>,
    /// The sine beside each cosine, where features and their slopes do not have it anyway.
    sines: Mat<f64>,
    /// The sum of (Φ, y, H)ᵀ(Φ, y, H) over blocks, the lower triangle.
    pub(crate) square: Mat<f64>,
    /// That of HᵀH where it is wanted for itself.
    pub(crate) spread: Mat<f64>,
}

impl FeatureRows {
    pub(crate) fn new(features: &RandomFeatures, monomials: Monomials, with_sines: bool) -> Self {
        let width = features.n_features() + 1 + monomials.count();
        let has_sines = with_sines && features.form == Form::Cosines;
        let n_sines = if has_sines { features.phases.len() } else { 0 };
        Self {
            n: 0,
            values: Mat::zeros(BLOCK, width),
            sines: Mat::zeros(BLOCK, n_sines),
            square: Mat::zeros(width, width),
            spread: Mat::zeros(monomials.count(), monomials.count()),
            monomials,
        }
    }

    /// Writes at most [`BLOCK`] rows.
    pub(crate) fn fill(
        &mut self,
        features: &RandomFeatures,
        x: MatRef<'_, f64>,
        y: &[f64],
        origin: f64,
    ) {
        let (n, m) = (y.len(), features.n_features());
        self.n = n;
        let sines = (self.sines.ncols() > 0).then(|| self.sines.as_mut().subrows_mut(0, n));
        features.fill(x, self.values.as_mut().subrows_mut(0, n), sines);
        for (value, y) in column_mut(&mut self.values, m).iter_mut().zip(y) {
            *value = y - origin;
        }
        column_mut(&mut self.values, m + 1)[..n].fill(1.0);
        if self.monomials.degree() > 0 {
            for (k, values) in self.monomials.columns(x).iter().enumerate().skip(1) {
                column_mut(&mut self.values, m + 1 + k)[..n].copy_from_slice(values);
            }
        }
    }

    /// Multiplies rows with noise of their own by the roots of their weights w; returns Σ ln w.
    pub(crate) fn weigh(&mut self, common: f64, own: &[f64]) -> f64 {
        let weights = weights(common, own);
        let roots: Vec<f64> = weights.iter().map(|weight| weight.sqrt()).collect();
        for j in 0..self.values.ncols() {
            multiply(&mut column_mut(&mut self.values, j)[..roots.len()], &roots);
        }
        weights.iter().map(|weight| weight.ln()).sum()
    }

    /// (Φ, y, H).
    pub(crate) fn values(&self) -> MatRef<'_, f64> {
        self.values.as_ref().subrows(0, self.n)
    }

    /// Column `j` of (Φ, y, H).
    pub(crate) fn column(&self, j: usize) -> &[f64] {
        &column(&self.values, j)[..self.n]
    }

    /// Cosine number `j` of the rows, and the sine beside it.
    pub(crate) fn pair(&self, j: usize, n_frequencies: usize) -> (&[f64], &[f64]) {
        let sine = match self.sines.ncols() {
            0 => column(&self.values, n_frequencies + j),
            _ => column(&self.sines, j),
        };
        (&column(&self.values, j)[..self.n], &sine[..self.n])
    }

    /// Forgets the sums.
    pub(crate) fn clear(&mut self) {
        self.square.fill(0.0);
        self.spread.fill(0.0);
    }

    /// Adds HᵀH.
    pub(crate) fn add_spread(&mut self) {
        let first = self.values.ncols() - self.monomials.count();
        let (basis, spread) = (self.values.get(..self.n, first..), self.spread.as_mut());
        dense(spread, Accum::Add, basis.transpose(), basis, 1.0, Par::Seq);
    }

    pub(crate) fn add_square(&mut self) {
        let values = self.values.as_ref().subrows(0, self.n);
        let (lower, whole) = (BlockStructure::TriangularLower, BlockStructure::Rectangular);
        let square = self.square.as_mut();
        matmul(square, lower, Accum::Add, values.transpose(), whole, values, whole, 1.0, Par::Seq);
    }
}

/// Rows of a part: parts run in parallel, and what they are follows from the number of rows alone.
pub(crate) fn rows_of_part(n_rows: usize) -> usize {
    n_rows.div_ceil(MOST_PARTS).next_multiple_of(4 * GROUP)
}

/// Rows that one matrix product takes: with two hundred features they stay in the second cache. No
/// power of two, so that the columns do not compete for the same places in it.
pub(crate) const BLOCK: usize = 240;
/// Rows that are summed before a compensated sum takes them.
pub(crate) const GROUP: usize = 4 * BLOCK;
/// Parts that run in parallel.
const MOST_PARTS: usize = 16;

/// σₙ²/(σₙ² + r) of rows with noise r.
pub(crate) fn weights(common: f64, own: &[f64]) -> Vec<f64> {
    own.iter().map(|own| common / (common + own)).collect()
}
