//! The exact Gaussian process beside matrix products of as many operations.

use anyhow::{Context, Result};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use gp_core::{Gp, LearnOptions, Posterior, SquaredExponential};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use rayon::{ThreadPool, ThreadPoolBuilder};

use super::Benchmark;
use super::timing::{Case, Row};

pub(super) const BENCHMARK: Benchmark = Benchmark {
    name: "gp",
    about: "exact GP of N rows and 2 inputs beside faer's matrix product with as many operations: \
            N³ for the likelihood with gradient, N² for a prediction with variance",
    rows,
};

const LIKELIHOOD_SIZES: [usize; 3] = [500, 1000, 2000];
const FIT_SIZE: usize = 500;
const N_PREDICTIONS: usize = 10_000;
const SEED: u64 = 7;

fn rows() -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for threads in [1, 2] {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.with_context(|| format!("cannot start {threads} threads"))?;
        for n in LIKELIHOOD_SIZES {
            rows.push(likelihood(&pool, n)?);
        }
        rows.push(fit(&pool)?);
        rows.push(predictions(&pool)?);
    }
    Ok(rows)
}

/// The likelihood with its gradient; one evaluation runs on one thread, so that its bits do not
/// depend on their number: its reference has one thread, too.
fn likelihood(pool: &ThreadPool, n: usize) -> Result<Row> {
    let gp = process(n)?;
    let threads = pool.current_num_threads();
    let case = Case { name: "likelihood with gradient", size: n, threads, rounds: 5, calls: 1 };
    let mut floor = Floor::new(n, n, Par::Seq);
    let row = pool
        .install(|| case.compare(|| gp.log_marginal_likelihood_gradient(), || floor.multiply(1)));
    gp.log_marginal_likelihood_gradient()?;
    Ok(row)
}

/// Learning from four starts, beside as many products as it evaluates the likelihood.
fn fit(pool: &ThreadPool) -> Result<Row> {
    let (x, y) = surface(FIT_SIZE);
    let learn = || {
        let kernel = SquaredExponential::unit(2)?;
        Gp::learn(kernel, x.as_ref(), &y, &LearnOptions::default())
    };
    let (_, report) = learn()?;
    let n_evaluations = report.starts.iter().flatten().map(|start| start.evaluations).sum();
    let threads = pool.current_num_threads();
    let case = Case { name: "fit from 4 starts", size: FIT_SIZE, threads, rounds: 3, calls: 1 };
    let mut floor = Floor::new(FIT_SIZE, FIT_SIZE, parallelism(threads));
    Ok(pool.install(|| case.compare(learn, || floor.multiply(n_evaluations))))
}

fn predictions(pool: &ThreadPool) -> Result<Row> {
    let gp = process(FIT_SIZE)?;
    let (x_star, _) = surface(N_PREDICTIONS);
    gp.predict(x_star.as_ref())?;
    let threads = pool.current_num_threads();
    let name = "10⁴ predictions with variance";
    let case = Case { name, size: FIT_SIZE, threads, rounds: 5, calls: 1 };
    let mut floor = Floor::new(FIT_SIZE, N_PREDICTIONS, parallelism(threads));
    Ok(pool.install(|| case.compare(|| gp.predict(x_star.as_ref()), || floor.multiply(1))))
}

fn parallelism(threads: usize) -> Par {
    if threads == 1 { Par::Seq } else { Par::rayon(threads) }
}

/// A product of N×(N/2) and (N/2)×M matrices: N²M operations, half of them multiplications.
struct Floor {
    left: Mat<f64>,
    right: Mat<f64>,
    product: Mat<f64>,
    parallelism: Par,
}

impl Floor {
    fn new(n: usize, m: usize, parallelism: Par) -> Self {
        let value = |i: usize, j: usize| 1.0 / (1.0 + (i + 2 * j) as f64);
        let (left, right) = (Mat::from_fn(n, n / 2, value), Mat::from_fn(n / 2, m, value));
        Self { left, right, product: Mat::zeros(n, m), parallelism }
    }

    /// Multiplies so many times; returns one entry, so that the work is not left out.
    fn multiply(&mut self, times: usize) -> f64 {
        for _ in 0..times {
            let Self { left, right, product, parallelism } = self;
            matmul(product.as_mut(), Accum::Replace, &*left, &*right, 1.0, *parallelism);
        }
        self.product[(0, 0)]
    }
}

fn process(n: usize) -> Result<Gp> {
    let (x, y) = surface(n);
    Ok(Gp::fit(SquaredExponential::new(&[0.5, 0.7], 0.2)?, x.as_ref(), &y, 0.02 * 0.02)?)
}

/// Points in [−1, 1]² and a surface like the turn of a pushed slider, with noise of sd 0.02.
fn surface(n: usize) -> (Mat<f64>, Vec<f64>) {
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let x: Mat<f64> = Mat::from_fn(n, 2, |_, _| rng.random_range(-1.0..1.0));
    let y = (0..n).map(|i| {
        let (p, beta) = (x[(i, 0)], x[(i, 1)]);
        let noise: f64 = rng.sample(StandardNormal);
        0.6 * (2.2 * (p * beta.cos() - 0.4 * beta.sin())).tanh() + 0.02 * noise
    });
    let y = y.collect();
    (x, y)
}

#[cfg(test)]
mod tests {
    use super::{Floor, process};
    use faer::Par;
    use gp_core::Posterior;

    #[test]
    fn the_floor_multiplies() {
        let mut floor = Floor::new(4, 3, Par::Seq);
        let expected = 1.0 + 1.0 / 3.0 * 0.5;
        assert!((floor.multiply(2) - expected).abs() < 1e-15);
    }

    #[test]
    fn the_timed_process_has_learned_its_surface() {
        let gp = process(200).unwrap();
        let mean = gp.predict_mean(gp.inputs()).unwrap();
        let rms = gp.outputs().iter().zip(&mean).map(|(y, m)| (y - m).powi(2)).sum::<f64>() / 200.0;
        assert!(rms.sqrt() < 0.02, "{}", rms.sqrt());
    }
}
