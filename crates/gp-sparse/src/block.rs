//! The part of the objective that one block of rows contributes.
//!
//! A block owns all its memory, so that an evaluation allocates nothing and blocks run in parallel;
//! sums over blocks are made in their order, whoever computed them.

use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular::{BlockStructure, matmul as triangular_matmul};
use faer::{Accum, Mat, MatRef, Par};
use gp_core::Kernel;
use gp_core::kernel::{column, column_mut};
use gp_core::vector::{add_multiple, add_square, dot, vectorized};

use crate::Approximation;

/// Rows of a block: with a hundred pseudo-inputs its three matrices stay in the second cache.
pub(crate) const BLOCK: usize = 256;

/// Rows of data and what an evaluation writes beside them; K and V are rows×M.
pub(crate) struct Block {
    pub(crate) x: Mat<f64>,
    /// Outputs less the data's origin.
    y: Vec<f64>,
    /// K_fu.
    k: Mat<f64>,
    /// V = K_fu L⁻ᵀ, with K_uu = L Lᵀ; later the gradient by K_fu.
    v: Mat<f64>,
    /// First D⁻¹V, later the gradient by V.
    work: Mat<f64>,
    /// c, the variance that the pseudo-inputs leave over.
    leftover: Vec<f64>,
    /// D⁻¹.
    precision: Vec<f64>,
    weights: Vec<f64>,
    /// e, the slope by the leftover variance.
    leftover_slope: Vec<f64>,
    pub(crate) sums: Sums,
    pub(crate) slopes: Slopes,
}

/// What the value needs from the rows: sums over them.
pub(crate) struct Sums {
    /// VᵀD⁻¹V, the lower triangle; in the second pass the same of the gradient.
    pub(crate) square: Mat<f64>,
    /// VᵀD⁻¹y and VᵀD⁻¹1.
    pub(crate) v_y: Vec<f64>,
    pub(crate) v_one: Vec<f64>,
    /// yᵀD⁻¹y, 1ᵀD⁻¹y and 1ᵀD⁻¹1.
    pub(crate) y_y: f64,
    pub(crate) one_y: f64,
    pub(crate) one_one: f64,
    pub(crate) log_determinant: f64,
    /// Σ ln(1 + α c/σₙ²)/α.
    pub(crate) penalty: f64,
}

/// What the gradient collects over the rows.
pub(crate) struct Slopes {
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
    /// L⁻¹, of which the lower triangle counts.
    pub(crate) factor_inverse: MatRef<'a, f64>,
}

/// What the gradient needs from the merged sums.
pub(crate) struct Solution<'a> {
    /// B⁻¹ with B = I + VᵀD⁻¹V, both triangles.
    pub(crate) inverse: MatRef<'a, f64>,
    /// t = B⁻¹VᵀD⁻¹(y − m).
    pub(crate) whitened: &'a [f64],
    /// u = L⁻ᵀt.
    pub(crate) weights: &'a [f64],
    /// m less the data's origin.
    pub(crate) constant: f64,
    pub(crate) has_free_z: bool,
}

impl Block {
    pub(crate) fn new(x: MatRef<'_, f64>, y: Vec<f64>, m: usize, n_parameters: usize) -> Self {
        let n = y.len();
        Self {
            x: x.to_owned(),
            y,
            k: Mat::zeros(n, m),
            v: Mat::zeros(n, m),
            work: Mat::zeros(n, m),
            leftover: vec![0.0; n],
            precision: vec![0.0; n],
            weights: vec![0.0; n],
            leftover_slope: vec![0.0; n],
            sums: Sums {
                square: Mat::zeros(m, m),
                v_y: vec![0.0; m],
                v_one: vec![0.0; m],
                y_y: 0.0,
                one_y: 0.0,
                one_one: 0.0,
                log_determinant: 0.0,
                penalty: 0.0,
            },
            slopes: Slopes {
                kernel: vec![0.0; n_parameters],
                noise: 0.0,
                z: vec![0.0; m * x.ncols()],
            },
        }
    }

    /// The first pass: everything up to the sums over rows; rows × M² operations.
    pub(crate) fn sum(&mut self, shared: &Shared<'_>) {
        let m = self.k.ncols();
        for (a, z) in shared.z.chunks_exact(self.x.ncols()).enumerate() {
            shared.kernel.column(self.x.as_ref(), z, column_mut(&mut self.k, a));
        }
        triangular_matmul(
            self.v.as_mut(),
            BlockStructure::Rectangular,
            Accum::Replace,
            &self.k,
            BlockStructure::Rectangular,
            shared.factor_inverse.transpose(),
            BlockStructure::TriangularUpper,
            1.0,
            Par::Seq,
        );
        shared.kernel.diagonal(self.x.as_ref(), &mut self.leftover);
        for a in 0..m {
            add_square(&mut self.leftover, -1.0, column(&self.v, a));
        }
        self.set_precision(shared);
        self.sum_rows(shared);
        for a in 0..m {
            let (v, work) = (column(&self.v, a), column_mut(&mut self.work, a));
            multiply(work, v, &self.precision);
            self.sums.v_y[a] = dot(work, &self.y);
            self.sums.v_one[a] = dot(v, &self.precision);
        }
        triangular_matmul(
            self.sums.square.as_mut(),
            BlockStructure::TriangularLower,
            Accum::Replace,
            self.work.transpose(),
            BlockStructure::Rectangular,
            &self.v,
            BlockStructure::Rectangular,
            1.0,
            Par::Seq,
        );
    }

    /// D⁻¹ from the leftover variance, of which rounding below 0 is cut off.
    fn set_precision(&mut self, shared: &Shared<'_>) {
        let (alpha, noise) = (shared.approximation.alpha(), shared.noise_variance);
        for (leftover, precision) in self.leftover.iter_mut().zip(&mut self.precision) {
            *leftover = leftover.max(0.0);
            *precision = (noise + alpha * *leftover).recip();
        }
    }

    fn sum_rows(&mut self, shared: &Shared<'_>) {
        let (y, precision) = (&self.y, &self.precision);
        let n = y.len();
        self.sums.y_y = (0..n).map(|i| y[i] * y[i] * precision[i]).sum();
        self.sums.one_y = dot(y, precision);
        self.sums.one_one = precision.iter().sum();
        self.sums.log_determinant = -precision.iter().map(|p| p.ln()).sum::<f64>();
        let (alpha, noise) = (shared.approximation.alpha(), shared.noise_variance);
        let term = |leftover: &f64| match alpha {
            0.0 => leftover / noise,
            _ => (alpha * leftover / noise).ln_1p() / alpha,
        };
        self.sums.penalty = match shared.approximation {
            Approximation::Fitc | Approximation::Dtc => 0.0,
            _ => self.leftover.iter().map(term).sum(),
        };
    }

    /// The second pass: the gradient; 4 × rows × M² operations.
    ///
    /// With r = y − m, w = (Q + D)⁻¹r and H = ½(wwᵀ − (Q + D)⁻¹) − diag(e), where e is the slope by
    /// the leftover variance: ∂F/∂K_fu = 2HK_fuK_uu⁻¹ = w uᵀ − (D⁻¹VB⁻¹ + 2eV)L⁻¹, and
    /// `sums.square` becomes the lower triangle of −(D⁻¹VB⁻¹ + 2eV)ᵀV.
    pub(crate) fn differentiate(&mut self, shared: &Shared<'_>, solution: &Solution<'_>) {
        let m = self.k.ncols();
        let inverse = solution.inverse;
        matmul(self.work.as_mut(), Accum::Replace, &self.v, inverse, 1.0, Par::Seq);
        self.set_weights(solution);
        self.set_leftover_slope(shared);
        for a in 0..m {
            let (v, work) = (column(&self.v, a), column_mut(&mut self.work, a));
            combine(work, &self.precision, &self.leftover_slope, v);
        }
        triangular_matmul(
            self.sums.square.as_mut(),
            BlockStructure::TriangularLower,
            Accum::Replace,
            self.work.transpose(),
            BlockStructure::Rectangular,
            &self.v,
            BlockStructure::Rectangular,
            1.0,
            Par::Seq,
        );
        // V has done its work and makes room.
        triangular_matmul(
            self.v.as_mut(),
            BlockStructure::Rectangular,
            Accum::Replace,
            &self.work,
            BlockStructure::Rectangular,
            shared.factor_inverse,
            BlockStructure::TriangularLower,
            1.0,
            Par::Seq,
        );
        self.contract(shared, solution);
    }

    /// w = D⁻¹(r − Vt).
    fn set_weights(&mut self, solution: &Solution<'_>) {
        for (weight, y) in self.weights.iter_mut().zip(&self.y) {
            *weight = y - solution.constant;
        }
        for (a, t) in solution.whitened.iter().enumerate() {
            add_multiple(&mut self.weights, -t, column(&self.v, a));
        }
        for (weight, precision) in self.weights.iter_mut().zip(&self.precision) {
            *weight *= precision;
        }
    }

    /// e, and the slope by the noise on the way.
    ///
    /// The diagonal of (Q + D)⁻¹ is D⁻¹ − D⁻²diag(VB⁻¹Vᵀ); `work` holds VB⁻¹ here.
    fn set_leftover_slope(&mut self, shared: &Shared<'_>) {
        let alpha = shared.approximation.alpha();
        let penalty = if shared.approximation.has_penalty() { 0.5 * (1.0 - alpha) } else { 0.0 };
        let slopes = &mut self.leftover_slope;
        slopes.fill(0.0);
        for a in 0..self.v.ncols() {
            add_products(slopes, column(&self.v, a), column(&self.work, a));
        }
        self.slopes.noise = 0.0;
        for (i, slope) in slopes.iter_mut().enumerate() {
            let precision = self.precision[i];
            let diagonal = precision * (1.0 - precision * *slope);
            let by_variance = 0.5 * (self.weights[i].powi(2) - diagonal);
            let by_penalty = penalty * precision;
            self.slopes.noise +=
                shared.noise_variance * by_variance + by_penalty * self.leftover[i];
            *slope = alpha * by_variance - by_penalty;
        }
    }

    /// Takes ∂F/∂K_fu and ∂F/∂c to the kernel's parameters and the pseudo-inputs.
    fn contract(&mut self, shared: &Shared<'_>, solution: &Solution<'_>) {
        let n_inputs = self.x.ncols();
        let Self { x, k, v: slope_by_k, weights, leftover_slope, slopes, .. } = self;
        slopes.kernel.fill(0.0);
        slopes.z.fill(0.0);
        shared.kernel.diagonal_gradient(x.as_ref(), leftover_slope, &mut slopes.kernel);
        let rows = shared.z.chunks_exact(n_inputs).zip(slopes.z.chunks_exact_mut(n_inputs));
        for (a, (z, slope)) in rows.enumerate() {
            let by_k = column_mut(slope_by_k, a);
            add_multiple(by_k, solution.weights[a], weights);
            let k = column(k, a);
            let of_kernel = &mut slopes.kernel;
            if solution.has_free_z {
                shared.kernel.column_gradients(x.as_ref(), z, k, by_k, of_kernel, slope);
            } else {
                shared.kernel.column_gradient(x.as_ref(), z, k, by_k, of_kernel);
            }
        }
    }
}

fn multiply(product: &mut [f64], a: &[f64], b: &[f64]) {
    vectorized(|| {
        for ((product, a), b) in product.iter_mut().zip(a).zip(b) {
            *product = a * b;
        }
    });
}

fn add_products(sums: &mut [f64], a: &[f64], b: &[f64]) {
    vectorized(|| {
        for ((sum, a), b) in sums.iter_mut().zip(a).zip(b) {
            *sum += a * b;
        }
    });
}

/// work ← −(precision·work + 2·slope·v).
fn combine(work: &mut [f64], precision: &[f64], slope: &[f64], v: &[f64]) {
    vectorized(|| {
        for (((work, precision), slope), v) in work.iter_mut().zip(precision).zip(slope).zip(v) {
            *work = -(precision * *work + 2.0 * slope * v);
        }
    });
}
