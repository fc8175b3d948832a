//! The variational bound of a Gaussian process whose noise is a function of the input.

use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::{Accum, Mat, MatRef, Par};

use crate::cholesky::{factorize, invert, log_determinant};
use crate::factor::COVARIANCE;
use crate::kernel::{column, column_mut, copy_row, fill_lower_gram, mirror_lower};
use crate::mean::{Deviation, Residual};
use crate::triangle::scratch_rows;
use crate::vector::dot;
use crate::{GpError, Kernel, Mean};

pub(crate) const NOISE_PRECISION: &str = "precision of the noise process";

/// A lower bound of ln p(y) where y = f + ε, ε ~ N(0, eᵍ), f ~ GP(m, k_f), g ~ GP(μ₀, k_g); owns its
/// memory.
///
/// The belief about g is N(μ, Σ) with Σ⁻¹ = K_g⁻¹ + Λ and μ = K_gβ + μ₀, β = λ − ½: the best
/// Gaussian has this form, with one positive λ a row. With Rᵢᵢ = exp(μᵢ − Σᵢᵢ/2):
///
/// F = ln N(y | m, K_f + R) − ¼ tr Σ − KL, over a learnt m integrated, in which B = I + Λ^½K_gΛ^½ gives Λ^½ΣΛ^½ = I − B⁻¹ and
/// KL = ½ (tr B⁻¹ + βᵀK_gβ − N + ln |B|).
///
/// # Source
/// Lázaro-Gredilla & Titsias, Variational heteroscedastic Gaussian process regression (2011).
pub(crate) struct NoiseBound<'a> {
    x: MatRef<'a, f64>,
    y: &'a [f64],
    mean: Mean,
    gram: Mat<f64>,
    noise_gram: Mat<f64>,
    /// The Cholesky factors of K_f + R and of B.
    factor: Mat<f64>,
    noise_factor: Mat<f64>,
    inverse: Mat<f64>,
    noise_inverse: Mat<f64>,
    work: Mat<f64>,
    slope: Mat<f64>,
    scratch: Mat<f64>,
    /// The diagonal of R.
    pub(crate) noise: Vec<f64>,
    /// w = (K_f + R)⁻¹(y − m).
    weights: Vec<f64>,
    deviations: Vec<Deviation>,
}

/// What the bound is a function of.
pub(crate) struct NoisePoint<'a> {
    pub(crate) kernel: &'a dyn Kernel,
    pub(crate) noise_kernel: &'a dyn Kernel,
    /// μ₀.
    pub(crate) log_noise_mean: f64,
    /// λ, positive, one a row.
    pub(crate) precisions: &'a [f64],
}

/// Slopes of the bound: by the logarithms of the kernels' parameters and of λ, and by μ₀.
pub(crate) struct NoiseSlopes<'a> {
    pub(crate) kernel: &'a mut [f64],
    pub(crate) noise_kernel: &'a mut [f64],
    pub(crate) log_noise_mean: &'a mut f64,
    pub(crate) precisions: &'a mut [f64],
}

impl<'a> NoiseBound<'a> {
    /// Prepares for data that have been checked.
    pub(crate) fn new(x: MatRef<'a, f64>, y: &'a [f64], mean: Mean) -> Self {
        let n = y.len();
        let square = || Mat::zeros(n, n);
        Self {
            x,
            y,
            mean,
            gram: square(),
            noise_gram: square(),
            factor: square(),
            noise_factor: square(),
            inverse: square(),
            noise_inverse: square(),
            work: square(),
            slope: square(),
            scratch: Mat::zeros(scratch_rows(n), n),
            noise: vec![0.0; n],
            weights: vec![0.0; n],
            deviations: Vec::new(),
        }
    }

    /// F in nats; O(N³).
    ///
    /// # Errors
    /// `NotPositiveDefinite`.
    pub(crate) fn value(&mut self, point: &NoisePoint<'_>) -> Result<f64, GpError> {
        let divergence = self.solve_noise(point)?;
        fill_lower_gram(point.kernel, self.x, &mut self.gram);
        self.factor.copy_from(&self.gram);
        let noise_mean = self.noise_mean(point);
        let mut trace = 0.0;
        for (i, mean) in noise_mean.iter().enumerate() {
            let variance = self.noise_variance(point, i);
            trace += variance;
            self.noise[i] = (mean - 0.5 * variance).exp();
            self.factor[(i, i)] += self.noise[i];
        }
        factorize(COVARIANCE, self.factor.as_mut())?;
        let residual = Residual::solve(&self.factor.as_ref(), self.x, self.y, self.mean)?;
        (self.weights, self.deviations) = (residual.weights, residual.deviations);
        Ok(residual.log_likelihood - 0.25 * trace - divergence)
    }

    /// Fills K_g, the factor of B and B⁻¹; returns the divergence.
    fn solve_noise(&mut self, point: &NoisePoint<'_>) -> Result<f64, GpError> {
        let (n, precisions) = (self.y.len(), point.precisions);
        fill_lower_gram(point.noise_kernel, self.x, &mut self.noise_gram);
        mirror_lower(&mut self.noise_gram);
        for j in 0..n {
            for i in j..n {
                let scale = (precisions[i] * precisions[j]).sqrt();
                self.noise_factor[(i, j)] = scale * self.noise_gram[(i, j)];
            }
            self.noise_factor[(j, j)] += 1.0;
        }
        factorize(NOISE_PRECISION, self.noise_factor.as_mut())?;
        self.noise_inverse.copy_from(&self.noise_factor);
        invert(self.noise_inverse.as_mut(), self.scratch.as_mut());
        mirror_lower(&mut self.noise_inverse);
        let beta = beta(precisions);
        let quadratic: f64 =
            (0..n).map(|j| beta[j] * dot(column(&self.noise_gram, j), &beta)).sum();
        let trace: f64 = (0..n).map(|i| self.noise_inverse[(i, i)]).sum();
        let determinant = log_determinant(self.noise_factor.as_ref());
        Ok(0.5 * (trace + quadratic - n as f64 + determinant))
    }

    /// μ.
    pub(crate) fn noise_mean(&self, point: &NoisePoint<'_>) -> Vec<f64> {
        let beta = beta(point.precisions);
        let mean = |j| point.log_noise_mean + dot(column(&self.noise_gram, j), &beta);
        (0..self.y.len()).map(mean).collect()
    }

    /// Σᵢᵢ.
    fn noise_variance(&self, point: &NoisePoint<'_>, i: usize) -> f64 {
        (1.0 - self.noise_inverse[(i, i)]) / point.precisions[i]
    }

    /// The slopes at the place of the last `value`; O(N³).
    ///
    /// With C = (K_f + R)⁻¹, less what a learnt mean may explain, ρ = ½R(w² − diag C) and τ = −½ρ − ¼:
    /// ∂F/∂K_f = ½(wwᵀ − C), ∂F/∂λ = K_g(ρ − β) − (Σ∘Σ)(τ + ½λ), ∂F/∂μ₀ = Σρ, and
    /// ∂F/∂K_g = ½(ρβᵀ + βρᵀ − ββᵀ) + Λ^½(B⁻¹(τ/λ + ½)B⁻¹ − ½B⁻¹)Λ^½.
    pub(crate) fn differentiate(&mut self, point: &NoisePoint<'_>, slopes: NoiseSlopes<'_>) {
        let n = self.y.len();
        self.inverse.copy_from(&self.factor);
        invert(self.inverse.as_mut(), self.scratch.as_mut());
        Deviation::project(&self.deviations, &mut self.inverse);
        let slope =
            |i: usize| 0.5 * self.noise[i] * (self.weights[i].powi(2) - self.inverse[(i, i)]);
        let by_log_noise: Vec<f64> = (0..n).map(slope).collect();
        *slopes.log_noise_mean = by_log_noise.iter().sum();
        self.differentiate_precisions(point, &by_log_noise, slopes.precisions);
        for j in 0..n {
            let (slope, inverse) = (column_mut(&mut self.slope, j), column(&self.inverse, j));
            for i in j..n {
                slope[i] = 0.5 * (self.weights[i] * self.weights[j] - inverse[i]);
            }
        }
        contract(point.kernel, self.x, &self.gram, &mut self.slope, slopes.kernel);
        self.fill_noise_slope(point, &by_log_noise);
        contract(
            point.noise_kernel,
            self.x,
            &self.noise_gram,
            &mut self.slope,
            slopes.noise_kernel,
        );
    }

    fn differentiate_precisions(
        &self,
        point: &NoisePoint<'_>,
        by_log_noise: &[f64],
        slopes: &mut [f64],
    ) {
        let (n, precisions) = (self.y.len(), point.precisions);
        let beta = beta(precisions);
        let difference: Vec<f64> = by_log_noise.iter().zip(&beta).map(|(a, b)| a - b).collect();
        // (τ + ½λ)/λ, so that squares of Λ^½ΣΛ^½ can be summed.
        let scaled: Vec<f64> = (0..n)
            .map(|i| (0.5 * (precisions[i] - by_log_noise[i]) - 0.25) / precisions[i])
            .collect();
        for (j, slope) in slopes.iter_mut().enumerate() {
            let inverse = column(&self.noise_inverse, j);
            let mut squares: f64 =
                inverse.iter().zip(&scaled).map(|(entry, scaled)| entry * entry * scaled).sum();
            // On the diagonal stands 1 − B⁻¹.
            squares += (1.0 - 2.0 * inverse[j]) * scaled[j];
            *slope = precisions[j] * dot(column(&self.noise_gram, j), &difference) - squares;
        }
    }

    /// ∂F/∂K_g, the lower triangle.
    fn fill_noise_slope(&mut self, point: &NoisePoint<'_>, by_log_noise: &[f64]) {
        let (n, precisions) = (self.y.len(), point.precisions);
        let beta = beta(precisions);
        for j in 0..n {
            let (work, inverse) = (column_mut(&mut self.work, j), column(&self.noise_inverse, j));
            for i in 0..n {
                let factor = (-0.5 * by_log_noise[i] - 0.25) / precisions[i] + 0.5;
                work[i] = factor * inverse[i];
            }
        }
        matmul(
            self.slope.as_mut(),
            BlockStructure::TriangularLower,
            Accum::Replace,
            &self.noise_inverse,
            BlockStructure::Rectangular,
            &self.work,
            BlockStructure::Rectangular,
            1.0,
            Par::Seq,
        );
        for j in 0..n {
            let (slope, inverse) = (column_mut(&mut self.slope, j), column(&self.noise_inverse, j));
            for i in j..n {
                let scale = (precisions[i] * precisions[j]).sqrt();
                let outer =
                    by_log_noise[i] * beta[j] + beta[i] * by_log_noise[j] - beta[i] * beta[j];
                slope[i] = scale * (slope[i] - 0.5 * inverse[i]) + 0.5 * outer;
            }
        }
    }
}

/// β = λ − ½.
fn beta(precisions: &[f64]) -> Vec<f64> {
    precisions.iter().map(|precision| precision - 0.5).collect()
}

/// Σᵢⱼ Wᵢⱼ ∂Kᵢⱼ/∂ ln θ for a symmetric W of which the lower triangle is given and spoilt.
fn contract(
    kernel: &dyn Kernel,
    x: MatRef<'_, f64>,
    gram: &Mat<f64>,
    slope: &mut Mat<f64>,
    gradient: &mut [f64],
) {
    gradient.fill(0.0);
    let mut b = vec![0.0; x.ncols()];
    for j in 0..gram.ncols() {
        let slope = &mut column_mut(slope, j)[j..];
        slope[1..].iter_mut().for_each(|slope| *slope *= 2.0);
        copy_row(x, j, &mut b);
        let rows = x.subrows(j, slope.len());
        kernel.column_gradient(rows, &b, &column(gram, j)[j..], slope, gradient, &mut []);
    }
}

#[cfg(test)]
mod tests {
    use faer::Mat;

    use super::{NoiseBound, NoisePoint, NoiseSlopes};
    use crate::{Gp, Kernel, Matern52, Mean, SquaredExponential};

    fn data() -> (Mat<f64>, Vec<f64>) {
        let x = Mat::from_fn(15, 2, |i, d| (1.3 * (i * (d + 2)) as f64).sin() * 2.0);
        let y = (0..15).map(|i| x[(i, 0)].sin() + 0.3 * (7.0 * i as f64).cos() * x[(i, 1)]);
        let y = y.collect();
        (x, y)
    }

    /// Parameters: 3 of each kernel, then μ₀, then ln λ.
    fn value_and_slopes(values: &[f64]) -> (f64, Vec<f64>) {
        let (x, y) = data();
        let positive = |range: std::ops::Range<usize>| -> Vec<f64> {
            values[range].iter().map(|value| value.exp()).collect()
        };
        let kernel = Matern52::unit(2).unwrap().with_parameters(&positive(0..3)).unwrap();
        let noise_kernel =
            SquaredExponential::unit(2).unwrap().with_parameters(&positive(3..6)).unwrap();
        let precisions = positive(7..22);
        let point = NoisePoint {
            kernel: &*kernel,
            noise_kernel: &*noise_kernel,
            log_noise_mean: values[6],
            precisions: &precisions,
        };
        let mut bound = NoiseBound::new(x.as_ref(), &y, Mean::Estimated);
        let value = bound.value(&point).unwrap();
        let mut slopes = vec![0.0; 22];
        let (of_kernel, rest) = slopes.split_at_mut(3);
        let (of_noise_kernel, rest) = rest.split_at_mut(3);
        let (of_mean, of_precisions) = rest.split_at_mut(1);
        bound.differentiate(
            &point,
            NoiseSlopes {
                kernel: of_kernel,
                noise_kernel: of_noise_kernel,
                log_noise_mean: &mut of_mean[0],
                precisions: of_precisions,
            },
        );
        (value, slopes)
    }

    #[test]
    fn slopes_equal_finite_differences() {
        let values: Vec<f64> = (0..22).map(|i| 0.6 * (1.7 * i as f64).sin() - 0.4).collect();
        let (_, slopes) = value_and_slopes(&values);
        for (index, slope) in slopes.iter().enumerate() {
            let moved = |h: f64| {
                let mut values = values.clone();
                values[index] += h;
                value_and_slopes(&values).0
            };
            let h = 1e-4;
            let (near, far) = (moved(h) - moved(-h), moved(2.0 * h) - moved(-2.0 * h));
            let expected = (8.0 * near - far) / (12.0 * h);
            assert!((slope - expected).abs() < 1e-8 * (1.0 + slope.abs()), "{index} {slope}");
        }
    }

    #[test]
    fn where_the_noise_cannot_vary_it_is_the_exact_likelihood() {
        let (x, y) = data();
        let kernel = Matern52::new(&[1.0, 2.0], 1.5).unwrap();
        let noise_kernel = SquaredExponential::new(&[1.0, 1.0], 1e-12).unwrap();
        let point = NoisePoint {
            kernel: &kernel,
            noise_kernel: &noise_kernel,
            log_noise_mean: 0.2_f64.ln(),
            precisions: &[0.5; 15],
        };
        let value = NoiseBound::new(x.as_ref(), &y, Mean::Estimated).value(&point).unwrap();
        let exact = Gp::builder(kernel).noise_variance(0.2).condition(x.as_ref(), &y).unwrap();
        assert!((value - exact.log_marginal_likelihood()).abs() < 1e-9);
    }
}
