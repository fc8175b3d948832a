//! The features' own marginal likelihood as a function of lengthscales, signal and noise.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use gp_core::cholesky::invert;
use gp_core::kernel::{column, column_of};
use gp_core::triangle::scratch_rows;
use gp_core::vector::{add_multiple, add_products, dot, multiply, subtract_products};
use gp_core::{GpError, Mean};
use rayon::prelude::{IntoParallelRefMutIterator, ParallelIterator};

use crate::evidence::{Evidence, Response};
use crate::feature_rows::{BLOCK, FeatureRows, rows_of_part, weights};
use crate::{Form, RandomFeatures, SufficientStatistics};

/// ln p(y | X, θ) for one data set, fixed base frequencies and many θ.
///
/// Features are computed twice and not kept, which costs less than the way to memory and back.
pub(crate) struct Likelihood {
    mean: Mean,
    statistics: SufficientStatistics,
    has_row_noise: bool,
    parts: Vec<Part>,
    /// B⁻¹, then what the features are multiplied by for the slope.
    inverse: Mat<f64>,
    scratch: Mat<f64>,
    slope_factor: Mat<f64>,
}

/// Some of the rows, and all that one thread needs for them.
struct Part {
    x: Mat<f64>,
    y: Vec<f64>,
    /// Known noise of the rows beside the common one, or none.
    row_noise: Vec<f64>,
    statistics: SufficientStatistics,
    rows: FeatureRows,
    /// ∂ ln p/∂Φ.
    slope: Mat<f64>,
    /// By ln σₙ², where rows have noise of their own.
    of_noise: f64,
    of_lengthscales: Vec<f64>,
    /// The slope by the frequencies, over −s/l_d.
    of_frequencies: Vec<f64>,
}

impl Likelihood {
    /// Prepares for data that have been checked; `row_noise` is one a row, or none.
    pub(crate) fn new(
        features: &RandomFeatures,
        (x, y, row_noise): (MatRef<'_, f64>, &[f64], &[f64]),
        mean: Mean,
    ) -> Result<Self, GpError> {
        let m = features.n_features();
        let has_row_noise = !row_noise.is_empty();
        let statistics = empty_statistics(features, x, y, mean)?;
        let statistics = if has_row_noise { statistics.with_row_noise(1.0)? } else { statistics };
        let monomials = statistics.monomials(features.n_inputs());
        let per_part = rows_of_part(y.len());
        let part = |(part, y): (usize, &[f64])| {
            let rows = part * per_part..part * per_part + y.len();
            Part {
                x: x.subrows(rows.start, y.len()).to_owned(),
                y: y.to_vec(),
                row_noise: row_noise.get(rows).unwrap_or(&[]).to_vec(),
                statistics: statistics.clone(),
                rows: FeatureRows::new(features, monomials.clone(), true),
                slope: Mat::zeros(BLOCK, m),
                of_noise: 0.0,
                of_lengthscales: vec![0.0; features.n_inputs()],
                of_frequencies: vec![0.0; features.frequencies.len()],
            }
        };
        Ok(Self {
            mean,
            has_row_noise,
            parts: y.chunks(per_part).enumerate().map(part).collect(),
            statistics,
            inverse: Mat::zeros(m, m),
            scratch: Mat::zeros(scratch_rows(m), m),
            slope_factor: Mat::zeros(m + 1 + monomials.count(), m),
        })
    }

    /// ln p, and its gradient by ln of lengthscales, signal variance and noise variance, and if
    /// `gradient` has room by the frequencies; 3 N M² operations.
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
        self.parts.par_iter_mut().for_each(|part| part.sum(features, noise_variance));
        self.statistics.clear(features, noise_variance);
        for part in &self.parts {
            self.statistics.merge(&part.statistics)?;
        }
        let mean = (self.mean, features.n_inputs());
        let evidence = Evidence::new(&self.statistics, signal_variance, noise_variance, mean)?;
        let trace = self.invert(&evidence, signal_variance.sqrt(), noise_variance);
        let (m, n) = (features.n_features() as f64, self.statistics.n_rows() as f64);
        let d = features.n_inputs();
        let squares: f64 = evidence.responses().map(|one| dot(&one.weights, &one.weights)).sum();
        gradient[d] = 0.5 * (squares - m + noise_variance * trace);
        let free = n - m + noise_variance * trace;
        let residuals: f64 = evidence.responses().map(|one| one.squared_residual).sum();
        gradient[d + 1] = 0.5 * (residuals / noise_variance - free);
        let slope_factor = self.slope_factor.as_ref();
        let (evidence, signal_sd) = (&evidence, signal_variance.sqrt());
        let shared = Shared { evidence, signal_sd, noise_variance, slope_factor };
        self.parts.par_iter_mut().for_each(|part| part.differentiate(features, &shared));
        if self.has_row_noise {
            gradient[d + 1] = self.parts.iter().map(|part| part.of_noise).sum();
        }
        let of_frequencies = gradient[d + 2..].chunks_exact_mut(d).enumerate();
        for (j, slopes) in of_frequencies {
            for (c, (slope, lengthscale)) in
                slopes.iter_mut().zip(features.lengthscales()).enumerate()
            {
                let sum = self.parts.iter().map(|part| part.of_frequencies[j * d + c]).sum::<f64>();
                *slope = -sum * signal_variance.sqrt() / lengthscale;
            }
        }
        for (d, slope) in gradient[..d].iter_mut().enumerate() {
            *slope = self.parts.iter().map(|part| part.of_lengthscales[d]).sum();
        }
        for (slope, lengthscale) in gradient[..d].iter_mut().zip(features.lengthscales()) {
            *slope *= signal_variance.sqrt() / lengthscale;
        }
        Ok(evidence.value)
    }

    /// Fills what (Φ, y, H) is multiplied by for the slope, and returns the trace of B⁻¹.
    ///
    /// With the features scaled by s, ∂ ln p/∂Φ = Σ (r − sΦt) tᵀ/σₙ² − sΦB⁻¹ over the responses.
    fn invert(&mut self, evidence: &Evidence, signal_sd: f64, noise_variance: f64) -> f64 {
        self.inverse.copy_from(&evidence.root);
        invert(self.inverse.as_mut(), self.scratch.as_mut());
        let m = self.inverse.ncols();
        for j in 0..m {
            let factors = column_of(self.slope_factor.as_mut(), j);
            for (i, factor) in factors[..m].iter_mut().enumerate() {
                *factor = -signal_sd * self.inverse[(i.max(j), i.min(j))];
            }
            factors[m..].fill(0.0);
            for Response { of_y, coefficients, weights, .. } in evidence.responses() {
                let of_residual = weights[j] / noise_variance;
                add_multiple(&mut factors[..m], -signal_sd * of_residual, weights);
                factors[m] += of_y * of_residual;
                for (factor, coefficient) in factors[m + 1..].iter_mut().zip(coefficients) {
                    *factor -= coefficient * of_residual;
                }
            }
        }
        (0..m).map(|j| self.inverse[(j, j)]).sum()
    }
}

/// No rows yet, about the means of outputs and inputs.
pub(crate) fn empty_statistics(
    features: &RandomFeatures,
    x: MatRef<'_, f64>,
    y: &[f64],
    mean: Mean,
) -> Result<SufficientStatistics, GpError> {
    let center: Vec<f64> =
        x.col_iter().map(|column| column.iter().sum::<f64>() / x.nrows() as f64).collect();
    let origin = y.iter().sum::<f64>() / y.len() as f64;
    SufficientStatistics::new(features, origin)?.with_mean(features, mean, &center)
}

/// What all parts need of an evaluation.
struct Shared<'a> {
    evidence: &'a Evidence,
    signal_sd: f64,
    noise_variance: f64,
    slope_factor: MatRef<'a, f64>,
}

impl Part {
    fn sum(&mut self, features: &RandomFeatures, noise_variance: f64) {
        self.statistics.clear(features, noise_variance);
        let data = (self.x.as_ref(), &*self.y, &*self.row_noise);
        self.statistics.add_rows(features, data, &mut self.rows);
    }

    /// The slope by the logarithms of the lengthscales, over s/l_d.
    ///
    /// For an angle θ = Σ ω_d x_d/l_d + b: ∂cos θ/∂ ln l_d = sin θ · ω_d x_d/l_d.
    fn differentiate(&mut self, features: &RandomFeatures, shared: &Shared<'_>) {
        self.of_lengthscales.fill(0.0);
        self.of_frequencies.fill(0.0);
        self.of_noise = 0.0;
        let d = self.x.ncols();
        for (block, y) in self.y.chunks(BLOCK).enumerate() {
            let (start, n) = (block * BLOCK, y.len());
            let x = self.x.as_ref().subrows(start, n);
            self.rows.fill(features, x, y, self.statistics.origin());
            let (slope, factor) = (self.slope.as_mut().subrows_mut(0, n), shared.slope_factor);
            matmul(slope, Accum::Replace, self.rows.values(), factor, 1.0, Par::Seq);
            let own = self.row_noise.get(start..start + n).unwrap_or(&[]);
            let weights = weights(shared.noise_variance, own);
            self.of_noise += self.slope_by_noise(shared, &weights);
            let Self { x, rows, slope, of_lengthscales, of_frequencies, .. } = self;
            let n_frequencies = features.phases.len();
            for (j, frequency) in features.frequencies.chunks_exact(d).enumerate() {
                let (mut by_cosine, by_sine) = slope.as_mut().split_at_col_mut(n_frequencies);
                let (cosine, sine) = rows.pair(j, n_frequencies);
                // In place of the slope by the cosine: that by the angle, negated.
                let of_angle = &mut column_of(by_cosine.as_mut(), j)[..n];
                multiply(of_angle, sine);
                if features.form == Form::Paired {
                    subtract_products(of_angle, &column_of(by_sine, j)[..n], cosine);
                }
                if !weights.is_empty() {
                    multiply(of_angle, &weights);
                }
                for (c, of_lengthscale) in of_lengthscales.iter_mut().enumerate() {
                    let x = &column(x, c)[start..start + n];
                    let with_input = dot(of_angle, x);
                    *of_lengthscale += frequency[c] * with_input;
                    of_frequencies[j * d + c] += with_input;
                }
            }
        }
    }

    /// ½ Σ (w²e²/σₙ² − w + s²w²φᵀB⁻¹φ) over the rows of a block with noise of their own, and over the e of
    /// all responses; `slope` holds et/σₙ² − sB⁻¹φ.
    fn slope_by_noise(&self, shared: &Shared<'_>, weights: &[f64]) -> f64 {
        let (n, signal_sd, noise_variance) =
            (weights.len(), shared.signal_sd, shared.noise_variance);
        if n == 0 {
            return 0.0;
        }
        let m = self.slope.ncols();
        let value = |j: usize| self.rows.column(j);
        let mut with_slope = vec![0.0; n];
        for j in 0..m {
            add_products(&mut with_slope, value(j), &column(&self.slope, j)[..n]);
        }
        // Σ e² and Σ e sφᵀt over the responses.
        let (mut squares, mut mixed) = (vec![0.0; n], vec![0.0; n]);
        for Response { of_y, coefficients, weights: t, .. } in shared.evidence.responses() {
            let mut fitted = vec![0.0; n];
            t.iter()
                .enumerate()
                .for_each(|(j, t)| add_multiple(&mut fitted, signal_sd * t, value(j)));
            let mut residual = vec![0.0; n];
            add_multiple(&mut residual, *of_y, value(m));
            for (k, coefficient) in coefficients.iter().enumerate() {
                add_multiple(&mut residual, -coefficient, value(m + 1 + k));
            }
            add_multiple(&mut residual, -1.0, &fitted);
            add_products(&mut squares, &residual, &residual);
            add_products(&mut mixed, &residual, &fitted);
        }
        let term = |i: usize| {
            let quadratic = mixed[i] / noise_variance - signal_sd * with_slope[i];
            let w = weights[i];
            0.5 * w * (w * (squares[i] / noise_variance + quadratic) - 1.0)
        };
        (0..n).map(term).sum()
    }
}

#[cfg(test)]
mod tests {
    use faer::Mat;
    use gp_core::Mean;

    use super::Likelihood;
    use crate::{FeatureOptions, Form, RandomFeatures, Sampling, Spectrum};

    #[test]
    fn the_gradient_by_frequencies_is_that_of_differences() {
        let x = Mat::from_fn(50, 2, |i, d| (1.7 * (3 * i + d) as f64 + (i * i) as f64).sin());
        let y: Vec<f64> = (0..50).map(|i| (3.0 * x[(i, 0)]).sin() + x[(i, 1)]).collect();
        for form in [Form::Cosines, Form::Paired] {
            let options =
                FeatureOptions { n_features: 6, form, sampling: Sampling::Independent, seed: 3 };
            let features = RandomFeatures::new(Spectrum::Matern32, &[0.7, 1.2], options).unwrap();
            let mut likelihood =
                Likelihood::new(&features, (x.as_ref(), &y, &[]), Mean::Estimated).unwrap();
            let n = features.frequencies.len();
            let mut gradient = vec![0.0; 4 + n];
            likelihood.evaluate(&features, 0.8, 0.05, &mut gradient).unwrap();
            let mut unused = vec![0.0; 4];
            for k in 0..n {
                let mut at = |step: f64| {
                    let mut moved = features.clone();
                    moved.frequencies[k] += step;
                    likelihood.evaluate(&moved, 0.8, 0.05, &mut unused).unwrap()
                };
                let numeric = (at(1e-6) - at(-1e-6)) / 2e-6;
                let apart = (gradient[4 + k] - numeric).abs();
                assert!(
                    apart < 1e-5 * (1.0 + numeric.abs()),
                    "{form:?} {k} {numeric} {gradient:?}"
                );
            }
        }
    }
}
