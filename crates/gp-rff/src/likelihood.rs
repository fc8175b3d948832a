//! The features' own marginal likelihood as a function of lengthscales, signal and noise.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use gp_core::cholesky::invert;
use gp_core::kernel::{column, column_mut, mirror_lower};
use gp_core::triangle::scratch_rows;
use gp_core::vector::{add_multiple, dot, vectorized};
use gp_core::{GpError, Mean};
use rayon::prelude::{IntoParallelRefMutIterator, ParallelIterator};

use crate::evidence::Evidence;
use crate::statistics::{BLOCK, multiply_transposed};
use crate::{Form, RandomFeatures, SufficientStatistics};

/// ln p(y | X, θ) for one data set, fixed base frequencies and many θ; owns its memory, about
/// 24 N M bytes.
pub(crate) struct Likelihood {
    mean: Mean,
    origin: f64,
    blocks: Vec<Block>,
    inverse: Mat<f64>,
    scratch: Mat<f64>,
}

/// Rows of data with their features.
struct Block {
    x: Mat<f64>,
    y: Vec<f64>,
    phi: Mat<f64>,
    /// The sine beside each cosine.
    sines: Mat<f64>,
    /// ∂ ln p/∂Φ.
    slope: Mat<f64>,
    /// ΦᵀΦ, the lower triangle.
    square: Mat<f64>,
    residual: Vec<f64>,
    of_lengthscales: Vec<f64>,
}

impl Likelihood {
    /// Prepares for data that have been checked.
    pub(crate) fn new(
        features: &RandomFeatures,
        x: MatRef<'_, f64>,
        y: &[f64],
        mean: Mean,
    ) -> Self {
        let (n, m) = (y.len(), features.n_features());
        let origin = y.iter().sum::<f64>() / n as f64;
        let block = |start: usize| {
            let rows = BLOCK.min(n - start);
            Block {
                x: x.subrows(start, rows).to_owned(),
                y: y[start..start + rows].iter().map(|y| y - origin).collect(),
                phi: Mat::zeros(rows, m),
                sines: Mat::zeros(rows, features.phases.len()),
                slope: Mat::zeros(rows, m),
                square: Mat::zeros(m, m),
                residual: vec![0.0; rows],
                of_lengthscales: vec![0.0; features.n_inputs()],
            }
        };
        Self {
            mean,
            origin,
            blocks: (0..n).step_by(BLOCK).map(block).collect(),
            inverse: Mat::zeros(m, m),
            scratch: Mat::zeros(scratch_rows(m), m),
        }
    }

    /// ln p, and its gradient by ln of lengthscales, signal variance and noise variance; 3 N M²
    /// operations.
    ///
    /// With w = Λ⁻¹(y − m) and the features scaled by s, ∂ ln p/∂Φ = w tᵀ − ΦB⁻¹.
    ///
    /// # Errors
    /// `NotPositiveDefinite`.
    pub(crate) fn evaluate(
        &mut self,
        features: &RandomFeatures,
        signal_variance: f64,
        noise_variance: f64,
        gradient: &mut [f64],
    ) -> Result<f64, GpError> {
        self.blocks.par_iter_mut().for_each(|block| {
            features.fill(block.x.as_ref(), &mut block.phi, Some(&mut block.sines));
            multiply_transposed(&block.phi, &mut block.square);
        });
        let mut statistics = SufficientStatistics::new(features, self.origin)?;
        for block in &self.blocks {
            statistics.add_block(&block.phi, &block.square, &block.y);
        }
        let evidence = Evidence::new(&statistics, signal_variance, noise_variance, self.mean)?;
        let trace = self.invert(&evidence.root);
        let (m, n) = (evidence.weights.len() as f64, statistics.n_rows() as f64);
        let (d, t) = (features.n_inputs(), &evidence.weights);
        gradient[d] = 0.5 * (dot(t, t) - m + noise_variance * trace);
        let free = n - m + noise_variance * trace;
        gradient[d + 1] = 0.5 * (evidence.squared_residual / noise_variance - free);
        let (inverse, signal_sd) = (self.inverse.as_ref(), signal_variance.sqrt());
        self.blocks.par_iter_mut().for_each(|block| {
            block.differentiate(features, inverse, &evidence, signal_sd, noise_variance);
        });
        for (d, slope) in gradient[..d].iter_mut().enumerate() {
            *slope = self.blocks.iter().map(|block| block.of_lengthscales[d]).sum();
        }
        Ok(evidence.value)
    }

    /// Fills B⁻¹, both triangles, and returns its trace.
    fn invert(&mut self, root: &Mat<f64>) -> f64 {
        self.inverse.copy_from(root);
        invert(self.inverse.as_mut(), self.scratch.as_mut());
        mirror_lower(&mut self.inverse);
        (0..root.nrows()).map(|j| self.inverse[(j, j)]).sum()
    }
}

impl Block {
    /// The slope by the logarithms of the lengthscales.
    ///
    /// For an angle θ = Σ ω_d x_d/l_d + b: ∂cos θ/∂ ln l_d = sin θ · ω_d x_d/l_d.
    fn differentiate(
        &mut self,
        features: &RandomFeatures,
        inverse: MatRef<'_, f64>,
        evidence: &Evidence,
        signal_sd: f64,
        noise_variance: f64,
    ) {
        let Self { x, y, phi, sines, slope, residual, of_lengthscales, .. } = self;
        matmul(slope.as_mut(), Accum::Replace, &*phi, inverse, -signal_sd, Par::Seq);
        for (residual, y) in residual.iter_mut().zip(y) {
            *residual = *y - evidence.constant;
        }
        for (j, t) in evidence.weights.iter().enumerate() {
            add_multiple(residual, -signal_sd * t, column(phi, j));
        }
        for (j, t) in evidence.weights.iter().enumerate() {
            add_multiple(column_mut(slope, j), t / noise_variance, residual);
        }
        of_lengthscales.fill(0.0);
        let n_frequencies = features.phases.len();
        for (j, frequency) in features.frequencies.chunks_exact(x.ncols()).enumerate() {
            // In place of the sines, which are not needed again: the slope by the angle, negated.
            let of_angle = column_mut(sines, j);
            multiply(of_angle, column(slope, j));
            if features.form == Form::Paired {
                subtract_products(of_angle, column(slope, n_frequencies + j), column(phi, j));
            }
            for (d, of_lengthscale) in of_lengthscales.iter_mut().enumerate() {
                let scale = signal_sd * frequency[d] / features.lengthscales[d];
                *of_lengthscale += scale * dot(of_angle, column(x, d));
            }
        }
    }
}

fn multiply(values: &mut [f64], factors: &[f64]) {
    vectorized(|| {
        for (value, factor) in values.iter_mut().zip(factors) {
            *value *= factor;
        }
    });
}

fn subtract_products(values: &mut [f64], a: &[f64], b: &[f64]) {
    vectorized(|| {
        for ((value, a), b) in values.iter_mut().zip(a).zip(b) {
            *value -= a * b;
        }
    });
}
