//! Vectors with a covariance of several sources, and how their likelihood depends on each.

use faer::{Mat, MatMut};
use gp_core::triangle::scratch_rows;
use gp_core::vector::{add_multiple, dot};
use gp_core::{GpError, cholesky};
use nalgebra::{DMatrix, DMatrixView, DVector};

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
        let mut inverse = DMatrix::zeros(n, n);
        for (theta, shape) in theta.iter().zip(&block.shapes) {
            add_multiple(inverse.as_mut_slice(), *theta, shape.as_slice());
        }
        let log_determinant = invert(&mut inverse).ok()? * block.vectors.ncols() as f64;
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
        // A column for each source: Kₖ P y of all vectors.
        let mut pulled = DMatrix::zeros(left.len(), n);
        // A push of which nothing was observed has no numbers.
        let height = left.nrows().max(1);
        for (shape, mut pulled) in shapes.iter().zip(pulled.column_iter_mut()) {
            let columns = || shape.as_slice().chunks_exact(height);
            let of_vectors = pulled.as_mut_slice().chunks_exact_mut(height);
            for (left, pulled) in left.column_iter().zip(of_vectors) {
                left.iter()
                    .zip(columns())
                    .for_each(|(left, column)| add_multiple(pulled, *left, column));
            }
        }
        let by_vector = DMatrixView::from_slice(pulled.as_slice(), left.nrows(), left.ncols() * n);
        let solved = &self.inverse * by_vector;
        let solved = DMatrixView::from_slice(solved.as_slice(), left.len(), n);
        // W, once a vector, less W X (1 + Σ Xᵀ W X)⁻¹ Xᵀ W.
        let mut projected = n_vectors * &self.inverse;
        if has_fixed {
            projected -= &self.fixed * &fixed.inverse * self.fixed.transpose();
        }
        let slope = DVector::from_fn(n, |k, _| {
            let (own, shape) = (pulled.column(k), shapes[k].as_slice());
            dot(left.as_slice(), own.as_slice()) - dot(projected.as_slice(), shape)
        });
        let information = pulled.tr_mul(&solved);
        // Fixed columns belong to one vector.
        let of_fixed = match has_fixed {
            true => self.fixed.tr_mul(&pulled),
            false => DMatrix::zeros(0, n),
        };
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

/// Inverts a covariance in its place, and returns the logarithm of its determinant.
fn invert(covariance: &mut DMatrix<f64>) -> Result<f64, GpError> {
    let n = covariance.nrows();
    let mut matrix = MatMut::from_column_major_slice_mut(covariance.as_mut_slice(), n, n);
    cholesky::factorize("a covariance of errors", matrix.as_mut())?;
    let log_determinant = cholesky::log_determinant(matrix.as_ref());
    cholesky::invert(matrix, Mat::zeros(scratch_rows(n), n).as_mut());
    covariance.fill_upper_triangle_with_lower_triangle();
    Ok(log_determinant)
}
