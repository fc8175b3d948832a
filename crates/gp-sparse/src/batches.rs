//! Stochastic optimisation: steps on batches of rows.

use gp_core::GpError;
use gp_core::checks::{check_positive, check_range};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

/// How pseudo-inputs and hyperparameters are moved.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum Optimizer {
    /// By a quasi-Newton method on all rows: the better optimum, for up to some ten thousand rows.
    #[default]
    QuasiNewton,
    /// By steps on batches of rows, each of which costs the same whatever the number of rows is (SVGP).
    Stochastic(Batches),
}

/// Steps on batches of rows; only [`Vfe`](crate::Approximation::Vfe) is a sum over rows.
///
/// The belief about the pseudo-outputs follows by natural gradients, hyperparameters and pseudo-inputs by
/// Adam, whose steps shrink to nothing. In the end one pass over all rows makes the belief the best one.
///
/// # Source
/// Hensman, Fusi & Lawrence, Gaussian processes for big data (2013); Kingma & Ba, Adam: a method for
/// stochastic optimization (2015).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Batches {
    /// Rows of a batch; all where there are not so many.
    pub rows: usize,
    /// How many steps there are.
    pub steps: usize,
    /// About how far the first steps move a logarithm of a hyperparameter, or a pseudo-input over the
    /// spread of the inputs.
    pub step_size: f64,
    /// How far the belief about the pseudo-outputs moves to what a batch says of it, above 0 and at most 1.
    pub natural_step: f64,
}

impl Default for Batches {
    fn default() -> Self {
        Self { rows: 960, steps: 1000, step_size: 0.03, natural_step: 0.05 }
    }
}

impl Batches {
    pub(crate) fn check(&self) -> Result<(), GpError> {
        check_positive("rows of a batch", self.rows as f64)?;
        check_positive("steps", self.steps as f64)?;
        check_positive("step_size", self.step_size)?;
        check_range("natural_step", self.natural_step, f64::MIN_POSITIVE, 1.0)
    }

    /// Moves a point along the slopes that `evaluate(rows, point, gradient)` finds on batch after batch;
    /// where it ends, and the largest component of the slopes' average there.
    ///
    /// # Errors
    /// The function's own.
    pub(crate) fn descend(
        &self,
        n_rows: usize,
        seed: u64,
        mut point: Vec<f64>,
        mut evaluate: impl FnMut(&[usize], &[f64], &mut [f64]) -> Result<(), GpError>,
    ) -> Result<(Vec<f64>, f64), GpError> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut order: Vec<usize> = (0..n_rows).collect();
        let size = self.rows.min(n_rows);
        let mut next = n_rows;
        let mut gradient = vec![0.0; point.len()];
        let mut adam = Adam::new(point.len());
        for step in 0..self.steps {
            if next + size > n_rows {
                order.shuffle(&mut rng);
                next = 0;
            }
            // In the order of memory.
            let mut rows = order[next..next + size].to_vec();
            rows.sort_unstable();
            next += size;
            evaluate(&rows, &point, &mut gradient)?;
            let left = 1.0 - step as f64 / self.steps as f64;
            adam.step(&mut point, &gradient, self.step_size * left);
        }
        Ok((point, adam.slope()))
    }
}

/// Averages of slopes and of their squares.
struct Adam {
    n_steps: i32,
    mean: Vec<f64>,
    square: Vec<f64>,
}

impl Adam {
    fn new(n: usize) -> Self {
        Self { n_steps: 0, mean: vec![0.0; n], square: vec![0.0; n] }
    }

    fn step(&mut self, point: &mut [f64], gradient: &[f64], step_size: f64) {
        self.n_steps += 1;
        let [of_mean, of_square] = [MEAN, SQUARE].map(|decay| 1.0 - decay.powi(self.n_steps));
        let averages = self.mean.iter_mut().zip(&mut self.square);
        for ((x, slope), (mean, square)) in point.iter_mut().zip(gradient).zip(averages) {
            *mean += (1.0 - MEAN) * (slope - *mean);
            *square += (1.0 - SQUARE) * (slope * slope - *square);
            *x -= step_size * (*mean / of_mean) / ((*square / of_square).sqrt() + TINY);
        }
    }

    fn slope(&self) -> f64 {
        self.mean.iter().fold(0.0, |norm, slope| norm.max(slope.abs()))
    }
}

/// Share of the averages that stays in a step.
const MEAN: f64 = 0.9;
const SQUARE: f64 = 0.999;
/// In nats per unit; slopes of a thousand rows are far above it.
const TINY: f64 = 1e-8;
