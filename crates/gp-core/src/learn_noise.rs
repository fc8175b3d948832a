//! Learning a process whose noise is a function of the input.

use std::sync::Arc;

use faer::MatRef;
use rayon::prelude::{IntoParallelIterator, ParallelIterator};

use crate::bfgs::{Limits, Minimum, best_of, minimize};
use crate::checks::{check_outputs, check_range};
use crate::noise_bound::{NoiseBound, NoisePoint, NoiseSlopes};
use crate::{
    Gp, GpError, HeteroscedasticGp, Kernel, LearnOptions, SearchSpace, StopReason, check_learnable,
};

/// What the optimiser did.
#[derive(Clone, Debug, PartialEq)]
pub struct HeteroscedasticReport {
    /// Parameters of the kernel of f, in the user's units.
    pub kernel: Vec<f64>,
    /// Parameters of the kernel of g; its variance is in squared nats.
    pub noise_kernel: Vec<f64>,
    /// The bound of ln p(y | X), in nats.
    pub bound: f64,
    /// ln p(y | X) of the process with the same noise everywhere, from which it started, in nats.
    pub homoscedastic: f64,
    /// Quasi-Newton iterations.
    pub iterations: usize,
    /// Evaluations of the bound with its gradient.
    pub evaluations: usize,
    /// Why it stopped.
    pub stop: StopReason,
}

impl HeteroscedasticGp {
    /// Learns both kernels, the mean of the log noise, and the belief about it by maximising the
    /// bound; O(N³) a step, and N² numbers for the optimiser.
    ///
    /// It starts from the process with the same noise everywhere ([`GpBuilder::fit`](crate::GpBuilder::fit) with `options`),
    /// and from two lengthscales of the noise; walls and scales are as there.
    ///
    /// # Errors
    /// As [`GpBuilder::fit`](crate::GpBuilder::fit); and of the noise kernel as of the other.
    ///
    /// # Source
    /// Lázaro-Gredilla & Titsias, Variational heteroscedastic Gaussian process regression (2011).
    pub fn learn(
        kernel: impl Kernel + 'static,
        noise_kernel: impl Kernel + 'static,
        x: MatRef<'_, f64>,
        y: &[f64],
        options: &LearnOptions,
    ) -> Result<(Self, HeteroscedasticReport), GpError> {
        check_learnable(&kernel, x, y, options)?;
        options.mean.check_constant()?;
        noise_kernel.check(x.ncols())?;
        let values: Vec<f64> = kernel.parameters().iter().map(|p| p.value).collect();
        let gp =
            Gp::builder(kernel.with_parameters(&values)?).options(options.clone()).fit(x, y)?;
        // The log noise has the unit of nats whatever the outputs are.
        let unit: Vec<f64> = (0..y.len()).map(|i| if i % 2 == 0 { 1.0 } else { -1.0 }).collect();
        let search = Search {
            space: SearchSpace::new(&kernel, x, y, options.prior),
            noise_space: SearchSpace::new(&noise_kernel, x, &unit, options.prior),
            kernel: &kernel,
            noise_kernel: &noise_kernel,
            x,
            y,
            options,
        };
        let ends: Vec<_> =
            [0.0, 1.0].into_par_iter().map(|shrink| search.run(&gp, shrink)).collect();
        let (_, best) = best_of(&ends)?;
        let (kernel, noise_kernel) = search.kernels(&best.point)?;
        let (n_kernel, n_noise) = search.counts();
        let log_noise_mean = best.point[n_kernel + n_noise];
        let precisions: Vec<f64> =
            best.point[n_kernel + n_noise + 1..].iter().map(|value| value.exp()).collect();
        let values = |kernel: &dyn Kernel| kernel.parameters().iter().map(|p| p.value).collect();
        let mut report = HeteroscedasticReport {
            kernel: values(&*kernel),
            noise_kernel: values(&*noise_kernel),
            bound: 0.0,
            homoscedastic: gp.log_marginal_likelihood(),
            iterations: best.iterations,
            evaluations: best.evaluations,
            stop: best.stop,
        };
        let (kernel, noise_kernel) = (Arc::from(kernel), Arc::from(noise_kernel));
        let learnt =
            Self::condition(kernel, noise_kernel, x, y, options.mean, log_noise_mean, precisions)?;
        report.bound = learnt.bound();
        Ok((learnt, report))
    }
}

/// One optimisation problem; a point holds the standardised parameters of both kernels, μ₀, and
/// ln λ of every row.
struct Search<'a> {
    space: SearchSpace,
    noise_space: SearchSpace,
    kernel: &'a dyn Kernel,
    noise_kernel: &'a dyn Kernel,
    x: MatRef<'a, f64>,
    y: &'a [f64],
    options: &'a LearnOptions,
}

impl Search<'_> {
    fn counts(&self) -> (usize, usize) {
        (self.kernel.parameters().len(), self.noise_kernel.parameters().len())
    }

    /// From the homoscedastic process, with lengthscales of the noise e^−shrink times the usual.
    fn run(&self, gp: &Gp, shrink: f64) -> Result<Minimum, GpError> {
        let (n_kernel, n_noise) = self.counts();
        let mut known: Vec<f64> = gp.kernel().parameters().iter().map(|p| p.value).collect();
        known.push(gp.noise_variance());
        let mut start = self.space.point(&known);
        start.truncate(n_kernel);
        let noise_start = self.noise_space.start(0, self.options.seed);
        start.extend(noise_start[..n_noise].iter().map(|value| value - shrink));
        start.push(gp.noise_variance().ln());
        start.extend(vec![0.5_f64.ln(); self.y.len()]);
        let mut bound = NoiseBound::new(self.x, self.y, self.options.mean);
        let limits = Limits {
            max_iterations: self.options.max_iterations.max(500),
            gradient_tolerance: self.options.gradient_tolerance,
            progress: Some((10, 1e-3)),
        };
        minimize(|point, gradient| self.evaluate(&mut bound, point, gradient), &start, limits)
    }

    fn evaluate(
        &self,
        bound: &mut NoiseBound<'_>,
        point: &[f64],
        gradient: &mut [f64],
    ) -> Result<f64, GpError> {
        let (n_kernel, n_noise) = self.counts();
        let (kernel, noise_kernel) = self.kernels(point)?;
        let logs = &point[n_kernel + n_noise + 1..];
        for value in logs {
            check_range("logarithm of a row's precision", *value, -FARTHEST, FARTHEST)?;
        }
        let precisions: Vec<f64> = logs.iter().map(|value| value.exp()).collect();
        let at = NoisePoint {
            kernel: &*kernel,
            noise_kernel: &*noise_kernel,
            log_noise_mean: point[n_kernel + n_noise],
            precisions: &precisions,
        };
        let value = bound.value(&at)?;
        let (of_kernel, rest) = gradient.split_at_mut(n_kernel);
        let (of_noise, rest) = rest.split_at_mut(n_noise);
        let (of_mean, of_precisions) = rest.split_at_mut(1);
        let slopes = NoiseSlopes {
            kernel: of_kernel,
            noise_kernel: of_noise,
            log_noise_mean: &mut of_mean[0],
            precisions: of_precisions,
        };
        bound.differentiate(&at, slopes);
        gradient.iter_mut().for_each(|slope| *slope = -*slope);
        let (of_kernel, rest) = gradient.split_at_mut(n_kernel);
        let penalty = self.space.penalty(&point[..n_kernel], of_kernel)
            + self.noise_space.penalty(&point[n_kernel..n_kernel + n_noise], &mut rest[..n_noise]);
        let total = penalty - value;
        check_outputs("bound", &[total], 1)?;
        check_outputs("gradient of the bound", gradient, point.len())?;
        Ok(total)
    }

    /// The kernels of f and g at a point.
    fn kernels(&self, point: &[f64]) -> Result<Kernels, GpError> {
        let (n_kernel, n_noise) = self.counts();
        let of_kernel = self.space.parameters(&point[..n_kernel]);
        let of_noise = self.noise_space.parameters(&point[n_kernel..n_kernel + n_noise]);
        Ok((
            self.kernel.with_parameters(&of_kernel)?,
            self.noise_kernel.with_parameters(&of_noise)?,
        ))
    }
}

/// The kernels of f and of g.
type Kernels = (Box<dyn Kernel>, Box<dyn Kernel>);

/// A step that takes a ln λ further is refused: beyond it (1 − B⁻¹)/λ has no digits.
const FARTHEST: f64 = 14.0;
