//! The part of the objective that one block of rows contributes.

use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{BlockStructure, matmul as triangular_matmul};
use faer::{Accum, Mat, MatMut, MatRef, Par};
use gp_core::kernel::{column, column_mut};
use gp_core::triangle::{multiply_rows, multiply_rows_transposed, solve_upper};
use gp_core::vector::{add_multiple, add_products, add_square, multiply, subtract_from_multiple};
use gp_core::{Kernel, Monomials};

use crate::Approximation;

/// Rows of a block: with a hundred pseudo-inputs its matrices stay in the second cache. No power of
/// two, so that the columns do not compete for the same places in it.
pub(crate) const BLOCK: usize = 240;

/// Rows of data, and what the second pass needs of the first.
pub(crate) struct Block {
    x: Mat<f64>,
    /// Outputs less the data's origin.
    y: Vec<f64>,
    /// Known noise of the rows beside the common one.
    row_noise: Vec<f64>,
    /// H, what the mean is a sum of; the first column is 1.
    basis: Vec<Vec<f64>>,
    /// K_fu.
    k: Mat<f64>,
    /// A = D^−½ (V, y, H) with V = K_fu L⁻ᵀ, K_uu = L Lᵀ.
    whitened: Mat<f64>,
    /// c, the variance that the pseudo-inputs leave over.
    leftover: Vec<f64>,
    /// D^−½.
    root_precision: Vec<f64>,
}

/// Memory that the blocks of a part use one after the other.
pub(crate) struct Scratch {
    product: Mat<f64>,
    slope: Mat<f64>,
    /// w of each response, one after the other.
    weights: Vec<Vec<f64>>,
    row_slopes: Vec<f64>,
}

/// What the value needs from the rows: sums over them.
pub(crate) struct Sums {
    /// AᵀA, the lower triangle.
    pub(crate) square: Mat<f64>,
    pub(crate) log_determinant: f64,
    /// Σ ln(1 + α c/σₙ²)/α.
    pub(crate) penalty: f64,
}

impl Sums {
    pub(crate) fn new(width: usize) -> Self {
        Self { square: Mat::zeros(width, width), log_determinant: 0.0, penalty: 0.0 }
    }
}

/// What the gradient collects over the rows.
pub(crate) struct Slopes {
    /// GᵀA, the lower triangle; for G see [`Block::differentiate`].
    pub(crate) square: Mat<f64>,
    pub(crate) kernel: Vec<f64>,
    /// By ln σₙ².
    pub(crate) noise: f64,
    /// By the pseudo-inputs, M×D by rows.
    pub(crate) z: Vec<f64>,
}

/// What all blocks share in an evaluation.
pub(crate) struct Shared<'a> {
    pub(crate) kernel: &'a dyn Kernel,
    /// Pseudo-inputs, M×D by rows.
    pub(crate) z: &'a [f64],
    pub(crate) approximation: Approximation,
    pub(crate) noise_variance: f64,
    /// L⁻¹, with zeros above its diagonal.
    pub(crate) factor_inverse: MatRef<'a, f64>,
}

/// What the gradient needs from the merged sums.
pub(crate) struct Solution<'a> {
    /// B⁻¹ with B = I + VᵀD⁻¹V, both triangles.
    pub(crate) inverse: MatRef<'a, f64>,
    pub(crate) responses: &'a [Response],
    pub(crate) has_free_z: bool,
}

/// What the process makes of outputs r = b y − H c: at x it is h(x) c + k(x, Z) u.
#[derive(Clone)]
pub(crate) struct Response {
    /// b: 1 of the mean, and 0 of its deviations.
    pub(crate) of_y: f64,
    /// c.
    pub(crate) coefficients: Vec<f64>,
    /// t = B⁻¹VᵀD⁻¹r.
    pub(crate) whitened: Vec<f64>,
    /// u = L⁻ᵀt.
    pub(crate) weights: Vec<f64>,
}

impl Response {
    /// To b y − H c.
    ///
    /// - `of_y_known`, `of_basis`: R⁻¹VᵀD⁻¹y and R⁻¹VᵀD⁻¹H; - `factors`: R and L.
    pub(crate) fn solve(
        (of_y, coefficients): (f64, Vec<f64>),
        (of_y_known, of_basis): (&[f64], &[Vec<f64>]),
        [root, factor]: [MatRef<'_, f64>; 2],
    ) -> Self {
        let mut whitened: Vec<f64> = of_y_known.iter().map(|y| of_y * y).collect();
        for (coefficient, known) in coefficients.iter().zip(of_basis) {
            add_multiple(&mut whitened, -coefficient, known);
        }
        solve_upper(root, &mut whitened);
        let mut weights = whitened.clone();
        solve_upper(factor, &mut weights);
        Self { of_y, coefficients, whitened, weights }
    }
}

impl Scratch {
    /// - `n_responses`: at most so many.
    pub(crate) fn new(m: usize, n_responses: usize) -> Self {
        let matrix = || Mat::zeros(BLOCK, m);
        let (weights, row_slopes) = (vec![vec![0.0; BLOCK]; n_responses], vec![0.0; BLOCK]);
        Self { product: matrix(), slope: matrix(), weights, row_slopes }
    }
}

impl Block {
    /// - `row_noise`: one a row; - `m`: pseudo-inputs.
    pub(crate) fn new(
        x: MatRef<'_, f64>,
        (y, row_noise): (Vec<f64>, Vec<f64>),
        monomials: &Monomials,
        m: usize,
    ) -> Self {
        let n = y.len();
        Self {
            basis: monomials.columns(x),
            x: x.to_owned(),
            y,
            row_noise,
            k: Mat::zeros(n, m),
            whitened: Mat::zeros(n, m + 1 + monomials.count()),
            leftover: vec![0.0; n],
            root_precision: vec![0.0; n],
        }
    }

    /// The first pass: everything up to the sums over rows; rows × 2M² operations.
    pub(crate) fn sum(&mut self, shared: &Shared<'_>, sums: &mut Sums) {
        let m = self.k.ncols();
        for (a, z) in shared.z.chunks_exact(self.x.ncols()).enumerate() {
            shared.kernel.column(self.x.as_ref(), z, column_mut(&mut self.k, a));
        }
        let v = self.whitened.as_mut().subcols_mut(0, m);
        multiply_rows_transposed(v, self.k.as_ref(), shared.factor_inverse);
        shared.kernel.diagonal(self.x.as_ref(), &mut self.leftover);
        for a in 0..m {
            add_square(&mut self.leftover, -1.0, column(&self.whitened, a));
        }
        self.set_precision(shared, sums);
        for a in 0..m {
            multiply(column_mut(&mut self.whitened, a), &self.root_precision);
        }
        column_mut(&mut self.whitened, m).copy_from_slice(&self.y);
        multiply(column_mut(&mut self.whitened, m), &self.root_precision);
        for (k, basis) in self.basis.iter().enumerate() {
            let whitened = column_mut(&mut self.whitened, m + 1 + k);
            whitened.copy_from_slice(&self.root_precision);
            multiply(whitened, basis);
        }
        let whitened = self.whitened.as_ref();
        add_lower(sums.square.as_mut(), whitened.transpose(), whitened);
    }

    /// D^−½ from the leftover variance, of which rounding below 0 is cut off.
    fn set_precision(&mut self, shared: &Shared<'_>, sums: &mut Sums) {
        let (alpha, common) = (shared.approximation.alpha(), shared.noise_variance);
        let rows = self.leftover.iter_mut().zip(&self.row_noise).zip(&mut self.root_precision);
        for ((leftover, own), root_precision) in rows {
            *leftover = leftover.max(0.0);
            let variance = (common + own) + alpha * *leftover;
            *root_precision = variance.sqrt().recip();
            sums.log_determinant += variance.ln();
        }
        let term = |(leftover, own): (&f64, &f64)| match alpha {
            0.0 => leftover / (common + own),
            _ => (alpha * leftover / (common + own)).ln_1p() / alpha,
        };
        if shared.approximation.has_penalty() && alpha < 1.0 {
            sums.penalty += self.leftover.iter().zip(&self.row_noise).map(term).sum::<f64>();
        }
    }

    /// The second pass: the gradient; rows × 4M² operations.
    ///
    /// With w = (Q + D)⁻¹r of each response and H = ½(Σ wwᵀ − (Q + D)⁻¹) − diag(e), where e is the slope
    /// by the leftover variance: ∂F/∂K_fu = 2HK_fuK_uu⁻¹ = Σ w uᵀ − D^−½ G L⁻¹ with G = AB⁻¹ + 2eDA.
    pub(crate) fn differentiate(
        &self,
        shared: &Shared<'_>,
        solution: &Solution<'_>,
        scratch: &mut Scratch,
        slopes: &mut Slopes,
    ) {
        let (n, m) = (self.y.len(), self.k.ncols());
        let a = self.whitened.as_ref().subcols(0, m);
        let mut product = scratch.product.as_mut().subrows_mut(0, n);
        matmul(product.as_mut(), Accum::Replace, a, solution.inverse, 1.0, Par::Seq);
        for (response, weights) in solution.responses.iter().zip(&mut scratch.weights) {
            self.set_weights(response, &mut weights[..n]);
        }
        self.set_row_slopes(shared, solution, scratch, slopes);
        for j in 0..m {
            let product = &mut column_mut(&mut scratch.product, j)[..n];
            add_products(product, &scratch.row_slopes[..n], column(&self.whitened, j));
        }
        let g = scratch.product.as_ref().subrows(0, n);
        add_lower(slopes.square.as_mut(), g.transpose(), a);
        multiply_rows(scratch.slope.as_mut().subrows_mut(0, n), g, shared.factor_inverse);
        self.contract(shared, solution, scratch, slopes);
    }

    /// w = D^−½ (D^−½ r − D^−½ V t).
    fn set_weights(&self, response: &Response, weights: &mut [f64]) {
        let m = self.k.ncols();
        weights.fill(0.0);
        add_multiple(weights, response.of_y, column(&self.whitened, m));
        for (k, coefficient) in response.coefficients.iter().enumerate() {
            add_multiple(weights, -coefficient, column(&self.whitened, m + 1 + k));
        }
        for (a, t) in response.whitened.iter().enumerate() {
            add_multiple(weights, -t, column(&self.whitened, a));
        }
        multiply(weights, &self.root_precision);
    }

    /// 2eD, and the slopes by the noise and by the prior variance on the way.
    ///
    /// The diagonal of (Q + D)⁻¹ is D⁻¹ (1 − diag(AB⁻¹Aᵀ)); `product` holds AB⁻¹ here.
    fn set_row_slopes(
        &self,
        shared: &Shared<'_>,
        solution: &Solution<'_>,
        scratch: &mut Scratch,
        slopes: &mut Slopes,
    ) {
        let alpha = shared.approximation.alpha();
        let penalty = if shared.approximation.has_penalty() { 0.5 * (1.0 - alpha) } else { 0.0 };
        let n = self.y.len();
        let row_slopes = &mut scratch.row_slopes[..n];
        row_slopes.fill(0.0);
        for a in 0..self.k.ncols() {
            let product = &column(&scratch.product, a)[..n];
            add_products(row_slopes, column(&self.whitened, a), product);
        }
        for (i, slope) in row_slopes.iter_mut().enumerate() {
            let precision = self.root_precision[i] * self.root_precision[i];
            let diagonal = precision * (1.0 - *slope);
            let weights = scratch.weights.iter().take(solution.responses.len());
            let squares: f64 = weights.map(|weights| weights[i].powi(2)).sum();
            let by_variance = 0.5 * (squares - diagonal);
            let by_penalty = penalty * precision;
            let share = shared.noise_variance / (shared.noise_variance + self.row_noise[i]);
            slopes.noise +=
                shared.noise_variance * by_variance + by_penalty * self.leftover[i] * share;
            *slope = alpha * by_variance - by_penalty;
        }
        shared.kernel.diagonal_gradient(self.x.as_ref(), row_slopes, &mut slopes.kernel);
        for (slope, root_precision) in row_slopes.iter_mut().zip(&self.root_precision) {
            *slope *= 2.0 / (root_precision * root_precision);
        }
    }

    /// Takes ∂F/∂K_fu to the kernel's parameters and the pseudo-inputs.
    fn contract(
        &self,
        shared: &Shared<'_>,
        solution: &Solution<'_>,
        scratch: &mut Scratch,
        slopes: &mut Slopes,
    ) {
        let (n, n_inputs) = (self.y.len(), self.x.ncols());
        let rows = shared.z.chunks_exact(n_inputs).zip(slopes.z.chunks_exact_mut(n_inputs));
        for (a, (z, of_z)) in rows.enumerate() {
            let by_k = &mut column_mut(&mut scratch.slope, a)[..n];
            let mut known = solution.responses.iter().zip(&scratch.weights);
            let (response, weights) = known.next().expect("the mean is always there");
            let (own, weights) = (response.weights[a], &weights[..n]);
            subtract_from_multiple(by_k, &self.root_precision, own, weights);
            for (response, weights) in known {
                add_multiple(by_k, response.weights[a], &weights[..n]);
            }
            let of_z = if solution.has_free_z { of_z } else { &mut [] };
            let (x, k) = (self.x.as_ref(), column(&self.k, a));
            shared.kernel.column_gradient(x, z, k, by_k, &mut slopes.kernel, of_z);
        }
    }
}

/// sum ← sum + A B, the lower triangle.
fn add_lower(sum: MatMut<'_, f64>, a: MatRef<'_, f64>, b: MatRef<'_, f64>) {
    let (lower, whole) = (BlockStructure::TriangularLower, BlockStructure::Rectangular);
    triangular_matmul(sum, lower, Accum::Add, a, whole, b, whole, 1.0, Par::Seq);
}
