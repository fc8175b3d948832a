//! The covariance of several outputs at the same inputs, B ⊗ K + R ⊗ I, by factors of the size of K.

use faer::diag::Diag;
use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::evd::{ComputeEigenvectors, self_adjoint_evd, self_adjoint_evd_scratch};
use faer::{Mat, MatMut, Par, Spec};

use crate::GpError;
use crate::cholesky::{Cholesky, factorize, invert};
use crate::kernel::{column, column_mut, column_of};
use crate::root::Root;
use crate::triangle::{scratch_rows, solve_lower, solve_upper};
use crate::vector::{add_multiple, dot};

/// W with W R Wᵀ = I and W B Wᵀ = diag(λ): outputs mixed by it share nothing.
#[derive(Clone, Debug)]
pub(crate) struct Mixing {
    pub(crate) mix: Mat<f64>,
    /// W⁻¹.
    back: Mat<f64>,
    /// λ, none negative.
    pub(crate) eigenvalues: Vec<f64>,
    /// ln |R|.
    log_determinant: f64,
}

impl Mixing {
    /// R = C Cᵀ, and C⁻¹ B C⁻ᵀ = U diag(λ) Uᵀ: W = Uᵀ C⁻¹.
    ///
    /// # Errors
    /// `NotPositiveDefinite` for an R that is singular, or a B without eigenvalues.
    pub(crate) fn new(of_outputs: &Mat<f64>, of_noise: &Mat<f64>) -> Result<Self, GpError> {
        let n = of_noise.nrows();
        let root = Cholesky::new(NOISE, of_noise.clone())?;
        let mut white = of_outputs.clone();
        root.solve_lower(white.as_mut());
        let mut white = white.transpose().to_owned();
        root.solve_lower(white.as_mut());
        let (mut eigenvalues, mut turn) = (Diag::<f64>::zeros(n), Mat::<f64>::zeros(n, n));
        // One thread, so that the bits are the same for any number of them.
        let (par, wanted) = (Par::Seq, ComputeEigenvectors::Yes);
        let scratch = self_adjoint_evd_scratch::<f64>(n, wanted, par, Spec::default());
        let mut memory = MemBuffer::new(scratch);
        let stack = MemStack::new(&mut memory);
        let (values, vectors) = (eigenvalues.as_mut(), Some(turn.as_mut()));
        self_adjoint_evd(white.as_ref(), values, vectors, par, stack, Spec::default())
            .map_err(|_| GpError::NotPositiveDefinite { what: OUTPUTS, size: n, pivot: 0 })?;
        let mut mix = turn.clone();
        // W = Uᵀ C⁻¹ = (C⁻ᵀ U)ᵀ, and W⁻¹ = C U.
        (0..n).for_each(|j| solve_upper(root.factor(), column_mut(&mut mix, j)));
        let lower = Mat::from_fn(n, n, |i, j| if j > i { 0.0 } else { root.factor()[(i, j)] });
        let values = eigenvalues.column_vector().iter().map(|value| value.max(0.0));
        Ok(Self {
            mix: mix.transpose().to_owned(),
            back: &lower * &turn,
            eigenvalues: values.collect(),
            log_determinant: root.factor().log_determinant(),
        })
    }

    fn n(&self) -> usize {
        self.eigenvalues.len()
    }
}

const NOISE: &str = "covariance of the outputs' noise";
const OUTPUTS: &str = "covariance of the outputs";

/// Σ = B ⊗ K + R ⊗ I = T Tᵀ, T = (W⁻¹ ⊗ I) diag(Lᵢ) with Lᵢ Lᵢᵀ = λᵢ K + I.
///
/// Vectors have one output after the other. P factors of N rows stand for one of P·N: P² times less work.
///
/// # Source
/// Rakitsch, Lippert, Borgwardt & Stegle, It is all in the noise: efficient multi-task Gaussian process
/// inference with structured residuals (2013), of which the eigenvectors of K are left out: factors of
/// few outputs cost less than they.
#[derive(Clone, Debug)]
pub(crate) struct Kronecker {
    pub(crate) mixing: Mixing,
    /// Lᵢ.
    pub(crate) factors: Vec<Mat<f64>>,
    log_determinant: f64,
}

impl Kronecker {
    /// - `gram`: the lower triangle of K.
    /// - `factors`: matrices to write into; others are made where they are none of this size.
    ///
    /// # Errors
    /// `NotPositiveDefinite`.
    pub(crate) fn new(
        mixing: Mixing,
        gram: &Mat<f64>,
        mut factors: Vec<Mat<f64>>,
    ) -> Result<Self, GpError> {
        let n = gram.nrows();
        factors.retain(|factor| factor.nrows() == n);
        factors.resize_with(mixing.n(), || Mat::zeros(n, n));
        let mut log_determinant = n as f64 * mixing.log_determinant;
        for (factor, eigenvalue) in factors.iter_mut().zip(&mixing.eigenvalues) {
            for j in 0..n {
                let values = column(gram, j)[j..].iter();
                let entries = column_mut(factor, j)[j..].iter_mut();
                entries.zip(values).for_each(|(entry, value)| *entry = eigenvalue * value);
                factor[(j, j)] += 1.0;
            }
            factorize("covariance of mixed outputs", factor.as_mut())?;
            log_determinant += factor.as_ref().log_determinant();
        }
        Ok(Self { mixing, factors, log_determinant })
    }

    fn n_inputs(&self) -> usize {
        self.factors.first().map_or(0, Mat::nrows)
    }

    /// Replaces the blocks of b by Σ_p m_ip b_p.
    fn mixed(&self, matrix: impl Fn(usize, usize) -> f64, vector: &mut [f64]) {
        let (n, whole) = (self.n_inputs(), vector.to_vec());
        vector.fill(0.0);
        for (i, block) in vector.chunks_exact_mut(n).enumerate() {
            for (p, known) in whole.chunks_exact(n).enumerate() {
                add_multiple(block, matrix(i, p), known);
            }
        }
    }

    /// Replaces B by T⁻¹B.
    pub(crate) fn solve_columns(&self, mut rhs: MatMut<'_, f64>) {
        for j in 0..rhs.ncols() {
            self.solve(&mut [column_of(rhs.as_mut(), j)]);
        }
    }

    /// Replaces X by X T⁻ᵀ.
    pub(crate) fn solve_rows(&self, mut rows: MatMut<'_, f64>) {
        let (n, n_outputs, mix) = (self.n_inputs(), self.mixing.n(), &self.mixing.mix);
        let mut whole = vec![vec![0.0; rows.nrows()]; n_outputs];
        for j in 0..n {
            for (p, known) in whole.iter_mut().enumerate() {
                known.copy_from_slice(column_of(rows.as_mut(), p * n + j));
            }
            for i in 0..n_outputs {
                let mixed = column_of(rows.as_mut(), i * n + j);
                mixed.fill(0.0);
                for (p, known) in whole.iter().enumerate() {
                    add_multiple(mixed, mix[(i, p)], known);
                }
            }
        }
        for (i, factor) in self.factors.iter().enumerate() {
            let block = rows.as_mut().subcols_mut(i * n, n);
            crate::triangle::solve_rows(factor.as_ref(), block);
        }
    }

    /// The diagonal of Σ⁻¹; O(P·N³).
    pub(crate) fn inverse_diagonal(&self) -> Vec<f64> {
        let (n, mix) = (self.n_inputs(), &self.mixing.mix);
        let mut diagonal = vec![0.0; n * self.mixing.n()];
        let mut scratch = Mat::zeros(scratch_rows(n), n);
        for (i, factor) in self.factors.iter().enumerate() {
            let mut inverse = factor.clone();
            invert(inverse.as_mut(), scratch.as_mut());
            for (p, block) in diagonal.chunks_exact_mut(n).enumerate() {
                let share = mix[(i, p)] * mix[(i, p)];
                block.iter_mut().enumerate().for_each(|(j, d)| *d += share * inverse[(j, j)]);
            }
        }
        diagonal
    }

    /// Replaces b by Σb.
    pub(crate) fn multiply(&self, vector: &mut [f64]) {
        let (n, back) = (self.n_inputs(), &self.mixing.back);
        // Tᵀ = diag(Lᵢᵀ) (W⁻ᵀ ⊗ I).
        self.mixed(|i, p| back[(p, i)], vector);
        for (factor, block) in self.factors.iter().zip(vector.chunks_exact_mut(n)) {
            let across: Vec<f64> =
                (0..n).map(|j| dot(&column(factor, j)[j..], &block[j..])).collect();
            block.fill(0.0);
            (0..n).for_each(|j| {
                add_multiple(&mut block[j..], across[j], &column(factor, j)[j..]);
            });
        }
        self.mixed(|i, p| back[(i, p)], vector);
    }
}

impl Root for Kronecker {
    fn n_rows(&self) -> usize {
        self.n_inputs() * self.mixing.n()
    }

    fn solve(&self, vectors: &mut [&mut [f64]]) {
        let (n, mix) = (self.n_inputs(), &self.mixing.mix);
        vectors.iter_mut().for_each(|vector| self.mixed(|i, p| mix[(i, p)], vector));
        for (i, factor) in self.factors.iter().enumerate() {
            let blocks = vectors.iter_mut().map(|vector| &mut vector[i * n..][..n]);
            solve_lower(factor.as_ref(), &mut blocks.collect::<Vec<_>>());
        }
    }

    fn solve_transposed(&self, vector: &mut [f64]) {
        let (n, mix) = (self.n_inputs(), &self.mixing.mix);
        for (factor, block) in self.factors.iter().zip(vector.chunks_exact_mut(n)) {
            solve_upper(factor.as_ref(), block);
        }
        self.mixed(|p, i| mix[(i, p)], vector);
    }

    fn log_determinant(&self) -> f64 {
        self.log_determinant
    }
}
