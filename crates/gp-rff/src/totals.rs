//! Sums over rows as the matrices that regression needs.

use faer::Mat;
use gp_core::kernel::column_mut;

use crate::SufficientStatistics;

impl SufficientStatistics {
    /// ΦᵀWΦ, the lower triangle.
    pub(crate) fn square(&self) -> Mat<f64> {
        let layout = self.layout();
        let m = layout.n_features;
        let mut square = Mat::zeros(m, m);
        for j in 0..m {
            let start = layout.product(j, j);
            for (i, entry) in column_mut(&mut square, j).iter_mut().enumerate().skip(j) {
                *entry = self.total(start + i - j);
            }
        }
        square
    }

    /// ΦᵀWy, and behind it ΦᵀW times each column of H.
    pub(crate) fn of_outputs(&self, n_basis: usize) -> Vec<Vec<f64>> {
        let layout = self.layout();
        let m = layout.n_features;
        let row = |i: usize| (0..m).map(|j| self.total(layout.product(i, j))).collect();
        (m..=m + n_basis).map(row).collect()
    }

    /// (y, H)ᵀW(y, H), the lower triangle.
    pub(crate) fn products(&self, n_basis: usize) -> Mat<f64> {
        let layout = self.layout();
        let m = layout.n_features;
        Mat::from_fn(1 + n_basis, 1 + n_basis, |i, j| match (i, j) {
            _ if i < j => 0.0,
            (1, 1) if !layout.is_extended => self.n_rows() as f64,
            _ => self.total(layout.product(m + i, m + j)),
        })
    }

    /// HᵀH, the lower triangle.
    pub(crate) fn spread(&self, n_basis: usize) -> Mat<f64> {
        let layout = self.layout();
        if !layout.is_extended {
            return Mat::full(1, 1, self.n_rows() as f64);
        }
        let entry = |i: usize, j: usize| self.total(layout.spread(i, j));
        Mat::from_fn(n_basis, n_basis, |i, j| if i < j { 0.0 } else { entry(i, j) })
    }

    /// Σ ln w.
    pub(crate) fn log_weights(&self) -> f64 {
        let layout = self.layout();
        if layout.is_extended { self.total(layout.log_weights()) } else { 0.0 }
    }
}
