//! Vectors with a covariance of several sources, and how their likelihood depends on each.

use nalgebra::{DMatrix, DVector};

/// Independent vectors y ~ N(X b, Σ θₖ Kₖ) with a common covariance.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    /// A column each.
    pub(crate) vectors: DMatrix<f64>,
    /// Kₖ for each source of error.
    pub(crate) shapes: Vec<DMatrix<f64>>,
    /// X, whose coefficients b ~ N(0, 1) all blocks share; without columns, or for one vector.
    pub(crate) fixed: DMatrix<f64>,
}

/// A block with the inverse W of its covariance.
pub(super) struct Solved<'a> {
    block: &'a Block,
    pub(super) inverse: DMatrix<f64>,
    /// W y and W X.
    vectors: DMatrix<f64>,
    fixed: DMatrix<f64>,
    /// ln det of the covariance, once a vector.
    pub(super) log_determinant: f64,
    /// Σ yᵀ W y.
    pub(super) square: f64,
}

/// The common coefficients b, given the variances.
pub(super) struct Fixed {
    pub(super) coefficients: DVector<f64>,
    /// (1 + Σ Xᵀ W X)⁻¹.
    pub(super) inverse: DMatrix<f64>,
    pub(super) log_determinant: f64,
    /// What they explain of Σ yᵀ W y.
    pub(super) fitted: f64,
}

/// One block's part of slope and information, with respect to θ.
pub(super) struct Derivatives {
    pub(super) slope: DVector<f64>,
    pub(super) information: DMatrix<f64>,
    /// Xᵀ W Kₖ P y.
    pub(super) of_fixed: DMatrix<f64>,
}

impl<'a> Solved<'a> {
    pub(super) fn of(block: &'a Block, theta: &[f64]) -> Option<Self> {
        let n = block.vectors.nrows();
        let mut covariance = DMatrix::zeros(n, n);
        for (theta, shape) in theta.iter().zip(&block.shapes) {
            covariance.zip_apply(shape, |sum: &mut f64, shape| *sum += theta * shape);
        }
        let factor = covariance.cholesky()?;
        let roots = factor.l_dirty().diagonal();
        let n_vectors = block.vectors.ncols() as f64;
        let log_determinant = 2.0 * n_vectors * roots.iter().map(|root| root.ln()).sum::<f64>();
        let inverse = factor.inverse();
        let (vectors, fixed) = (&inverse * &block.vectors, &inverse * &block.fixed);
        let square = block.vectors.dot(&vectors);
        Some(Self { block, inverse, vectors, fixed, log_determinant, square })
    }

    pub(super) fn derivatives(&self, fixed: &Fixed) -> Derivatives {
        let shapes = &self.block.shapes;
        let (n, n_vectors) = (shapes.len(), self.vectors.ncols() as f64);
        let has_fixed = !fixed.coefficients.is_empty();
        let mut left = self.vectors.clone();
        if has_fixed {
            left.set_column(0, &(left.column(0) - &self.fixed * &fixed.coefficients));
        }
        let pulled: Vec<DMatrix<f64>> = shapes.iter().map(|shape| shape * &left).collect();
        let solved: Vec<DMatrix<f64>> =
            pulled.iter().map(|pulled| &self.inverse * pulled).collect();
        // W, once a vector, less W X (1 + Σ Xᵀ W X)⁻¹ Xᵀ W.
        let mut projected = n_vectors * &self.inverse;
        if has_fixed {
            projected -= &self.fixed * &fixed.inverse * self.fixed.transpose();
        }
        let slope = DVector::from_fn(n, |k, _| left.dot(&pulled[k]) - projected.dot(&shapes[k]));
        let information = DMatrix::from_fn(n, n, |k, l| pulled[k].dot(&solved[l]));
        let mut of_fixed = DMatrix::zeros(fixed.coefficients.len(), n);
        if has_fixed {
            for (k, pulled) in pulled.iter().enumerate() {
                of_fixed.set_column(k, &(self.fixed.transpose() * pulled.column(0)));
            }
        }
        Derivatives { slope, information, of_fixed }
    }
}

impl Fixed {
    pub(super) fn of(solved: &[Solved<'_>]) -> Option<Self> {
        let n = solved.first()?.fixed.ncols();
        let mut precision = DMatrix::identity(n, n);
        let mut right = DVector::zeros(n);
        if n > 0 {
            for block in solved {
                precision += block.block.fixed.transpose() * &block.fixed;
                right += block.fixed.transpose() * block.block.vectors.column(0);
            }
        }
        let factor = precision.cholesky()?;
        let log_determinant =
            2.0 * factor.l_dirty().diagonal().iter().map(|root| root.ln()).sum::<f64>();
        let coefficients = factor.solve(&right);
        let fitted = coefficients.dot(&right);
        Some(Self { coefficients, inverse: factor.inverse(), log_determinant, fitted })
    }
}
