//! The variational bound of a Gaussian process whose noise has heavy tails.

use std::f64::consts::PI;

use faer::MatRef;

use crate::likelihood::Likelihood;
use crate::mean::Residual;
use crate::noise::Noise;
use crate::{GpError, Kernel, Mean};

/// A lower bound of ln p(y) where y = f + ε, ε of a Student t, f ~ GP(m, k); owns its memory.
///
/// A Student t is a normal distribution of random precision. With beliefs about f and about every
/// row's precision that do not depend on each other, f has the posterior of Gaussian noise rᵢ a row,
/// and with sᵢ = E((yᵢ − fᵢ)²), w = (K + R)⁻¹(y − m) and C = (K + R)⁻¹, less what a learnt mean may
/// explain:
///
/// F = ln N(y | m, K + R) + Σᵢ (½ ln 2πrᵢ + sᵢ/2rᵢ + ln t(√sᵢ)), sᵢ = rᵢ + rᵢ²(wᵢ² − Cᵢᵢ).
///
/// It is stationary in R at rᵢ = (νσ² + sᵢ)/(ν + 1), whence its slopes by all else are those at a
/// fixed belief: ∂F/∂K = ½(wwᵀ − C).
///
/// # Source
/// Tipping & Lawrence, Variational inference for Student-t models (2005).
pub(crate) struct StudentTBound<'a> {
    likelihood: Likelihood<'a>,
    /// ln r, one a row.
    log_noise: Vec<f64>,
}

/// The Student t of the noise.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tails {
    /// σ², in the squared unit of the output.
    pub(crate) scale_variance: f64,
    /// ν.
    pub(crate) degrees: f64,
}

impl Tails {
    /// ln t at the root of a squared residual.
    pub(crate) fn log_density(self, square: f64) -> f64 {
        let Self { scale_variance, degrees } = self;
        log_gamma_step(0.5 * degrees)
            - 0.5 * (degrees * PI * scale_variance).ln()
            - 0.5 * (degrees + 1.0) * (square / (degrees * scale_variance)).ln_1p()
    }

    /// The slopes of `log_density` by ln σ² and by ν.
    fn slopes(self, square: f64) -> (f64, f64) {
        let Self { scale_variance, degrees } = self;
        let weight = (degrees + 1.0) * square / (degrees * scale_variance + square);
        let by_degrees = digamma(0.5 * (degrees + 1.0))
            - digamma(0.5 * degrees)
            - degrees.recip()
            - (square / (degrees * scale_variance)).ln_1p()
            + weight / degrees;
        (0.5 * (weight - 1.0), 0.5 * by_degrees)
    }
}

/// F at some noise of the rows, their sᵢ, and where the noise would go from there.
struct Visit {
    value: f64,
    squares: Vec<f64>,
    next: Vec<f64>,
}

impl<'a> StudentTBound<'a> {
    /// Prepares for data that have been checked.
    pub(crate) fn new(x: MatRef<'a, f64>, y: &'a [f64], mean: Mean) -> Self {
        Self { likelihood: Likelihood::new(x, y, mean), log_noise: Vec::new() }
    }

    /// The noise rᵢ that `evaluate` found.
    pub(crate) fn noise(&self) -> Vec<f64> {
        self.log_noise.iter().map(|value| value.exp()).collect()
    }

    /// F in nats at its best noise of the rows, and its slopes by the logarithms of the kernel's
    /// parameters and of σ² and, last, by ν; O(N³) a visit, some ten of them.
    ///
    /// # Errors
    /// `NotPositiveDefinite`; `NotConverged` if the noise of the rows does not settle.
    pub(crate) fn evaluate(
        &mut self,
        kernel: &dyn Kernel,
        tails: Tails,
        gradient: &mut [f64],
    ) -> Result<f64, GpError> {
        if self.log_noise.is_empty() {
            self.log_noise = vec![tails.scale_variance.ln(); self.likelihood.n_rows()];
        }
        self.likelihood.fill_gram(kernel);
        let (visit, residual) = self.settle(tails)?;
        let (of_kernel, of_tails) = gradient.split_at_mut(gradient.len() - 2);
        of_tails.fill(0.0);
        for square in &visit.squares {
            let (by_scale, by_degrees) = tails.slopes(*square);
            of_tails[0] += by_scale;
            of_tails[1] += by_degrees;
        }
        // The slope by a common noise, which there is none of, has its place behind the kernel's.
        let mut slopes = vec![0.0; of_kernel.len() + 1];
        self.likelihood.contract(kernel, 0.0, &residual.weights, &mut slopes);
        of_kernel.copy_from_slice(&slopes[..of_kernel.len()]);
        Ok(visit.value)
    }

    /// Repeats visits until the noise stays, with steps longer than those to `next` where these
    /// shrink slowly; F never falls.
    ///
    /// # Source
    /// Varadhan & Roland, Simple and globally convergent methods for accelerating the convergence
    /// of any EM algorithm (2008).
    fn settle(&mut self, tails: Tails) -> Result<(Visit, Residual), GpError> {
        let (mut here, _) = self.visit(tails)?;
        let mut distance = f64::INFINITY;
        for _ in 0..MOST_ROUNDS {
            let start = std::mem::replace(&mut self.log_noise, here.next.clone());
            let first = difference(&self.log_noise, &start);
            let (visit, residual) = self.visit(tails)?;
            let second = difference(&visit.next, &self.log_noise);
            distance = largest(&second);
            if distance < SETTLED {
                return Ok((visit, residual));
            }
            here = visit;
            let bend = difference(&second, &first);
            let length = (largest(&first) / largest(&bend)).clamp(1.0, LONGEST);
            let plain = std::mem::replace(&mut self.log_noise, start);
            for ((value, first), bend) in self.log_noise.iter_mut().zip(&first).zip(&bend) {
                *value += length * (2.0 * first + length * bend);
            }
            match self.visit(tails) {
                Ok((far, _)) if far.value >= here.value => here = far,
                _ => self.log_noise = plain,
            }
        }
        Err(GpError::NotConverged {
            n_starts: 1,
            iterations: 3 * MOST_ROUNDS,
            gradient_norm: distance,
        })
    }

    /// Leaves C in the likelihood.
    fn visit(&mut self, tails: Tails) -> Result<(Visit, Residual), GpError> {
        let noise = self.noise();
        self.likelihood.cover(Noise { common: 0.0, of_rows: &noise });
        let residual = self.likelihood.solve()?;
        let (mut value, mut squares) = (residual.log_likelihood, Vec::new());
        for (i, (noise, weight)) in noise.iter().zip(&residual.weights).enumerate() {
            let excess = weight * weight - self.likelihood.inverse_entry(i);
            // Rounding alone can make the part of the variance negative.
            let square = (noise + noise * noise * excess).max(0.0);
            value += 0.5 * ((2.0 * PI * noise).ln() + square / noise) + tails.log_density(square);
            squares.push(square);
        }
        let Tails { scale_variance, degrees } = tails;
        let next = |square: &f64| ((degrees * scale_variance + square) / (degrees + 1.0)).ln();
        let next = squares.iter().map(next).collect();
        Ok((Visit { value, squares, next }, residual))
    }
}

/// The noise has settled where no logarithm moves further than this.
const SETTLED: f64 = 1e-8;
const MOST_ROUNDS: usize = 200;
/// The longest step, in plain ones.
const LONGEST: f64 = 32.0;

fn difference(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |largest, value| largest.max(value.abs()))
}

/// ln Γ(x + ½) − ln Γ(x), whose digits two large values would not leave over.
fn log_gamma_step(x: f64) -> f64 {
    if x < 100.0 {
        return libm::lgamma(x + 0.5) - libm::lgamma(x);
    }
    let inverse = x.recip();
    let square = inverse * inverse;
    0.5 * x.ln() - inverse * (1.0 / 8.0 - square * (1.0 / 192.0 - square / 640.0))
}

/// The slope of ln Γ, for x > 0, by its asymptotic series beyond 10.
fn digamma(x: f64) -> f64 {
    let (mut x, mut sum) = (x, 0.0);
    while x < 10.0 {
        sum -= x.recip();
        x += 1.0;
    }
    let square = (x * x).recip();
    let series =
        [1.0 / 12.0, -1.0 / 120.0, 1.0 / 252.0, -1.0 / 240.0, 1.0 / 132.0, -691.0 / 32_760.0];
    let tail = series.iter().rev().fold(0.0, |tail, term| square * (term + tail));
    sum + x.ln() - 0.5 / x - tail
}

#[cfg(test)]
mod tests {
    use faer::Mat;

    use super::{StudentTBound, Tails, digamma, log_gamma_step};
    use crate::{Gp, Kernel, Matern52, Mean, SquaredExponential};

    fn data() -> (Mat<f64>, Vec<f64>) {
        let x = Mat::from_fn(20, 2, |i, d| (1.3 * (i * (d + 2)) as f64).sin() * 2.0);
        let y = (0..20).map(|i| x[(i, 0)].sin() + if i % 7 == 3 { 4.0 } else { 0.1 * i as f64 });
        let y = y.collect();
        (x, y)
    }

    /// Parameters: ln of 3 of the kernel and of σ², then ν.
    fn value_and_slopes(values: &[f64]) -> (f64, Vec<f64>) {
        let (x, y) = data();
        let parameters: Vec<f64> = values[..3].iter().map(|value| value.exp()).collect();
        let kernel = Matern52::unit(2).unwrap().with_parameters(&parameters).unwrap();
        let tails = Tails { scale_variance: values[3].exp(), degrees: values[4] };
        let mut slopes = vec![0.0; 5];
        let mut bound = StudentTBound::new(x.as_ref(), &y, Mean::Estimated);
        (bound.evaluate(&*kernel, tails, &mut slopes).unwrap(), slopes)
    }

    #[test]
    fn slopes_equal_finite_differences() {
        let values = [0.1, -0.2, 0.3, -1.5, 3.5];
        let (_, slopes) = value_and_slopes(&values);
        for (index, slope) in slopes.iter().enumerate() {
            let moved = |h: f64| {
                let mut values = values;
                values[index] += h;
                value_and_slopes(&values).0
            };
            let h = 1e-4;
            let (near, far) = (moved(h) - moved(-h), moved(2.0 * h) - moved(-2.0 * h));
            let expected = (8.0 * near - far) / (12.0 * h);
            assert!((slope - expected).abs() < 1e-7 * (1.0 + slope.abs()), "{index} {slope}");
        }
    }

    #[test]
    fn with_endless_degrees_it_is_the_gaussian_likelihood() {
        let (x, y) = data();
        let kernel = SquaredExponential::new(&[1.0, 2.0], 1.5).unwrap();
        let tails = Tails { scale_variance: 0.2, degrees: 1e9 };
        let mut slopes = vec![0.0; 5];
        let mut bound = StudentTBound::new(x.as_ref(), &y, Mean::Estimated);
        let value = bound.evaluate(&kernel, tails, &mut slopes).unwrap();
        let exact = Gp::builder(kernel).noise_variance(0.2).condition(x.as_ref(), &y).unwrap();
        assert!((value - exact.log_marginal_likelihood()).abs() < 1e-5);
        let gradient = exact.log_marginal_likelihood_gradient().unwrap();
        assert!(slopes[..4].iter().zip(&gradient).all(|(a, b)| (a - b).abs() < 1e-5));
    }

    #[test]
    fn the_step_of_the_gamma_function_has_no_seam() {
        let (below, above) = (log_gamma_step(99.999_999_999), log_gamma_step(100.000_000_001));
        assert!((above - below - 2e-9 * 0.005).abs() < 1e-12, "{below} {above}");
        assert!((log_gamma_step(2.0) - (0.75 * std::f64::consts::PI.sqrt()).ln()).abs() < 1e-14);
    }

    #[test]
    fn digamma_known_from_tables() {
        assert!((digamma(1.0) + 0.577_215_664_901_532_9).abs() < 1e-14);
        assert!((digamma(0.5) + 1.963_510_026_021_423_5).abs() < 1e-14);
        assert!((digamma(20.0) - 2.970_523_992_242_149).abs() < 1e-14);
    }
}
