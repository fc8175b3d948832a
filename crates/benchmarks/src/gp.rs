//! The exact Gaussian process beside matrix products of as many operations.

use anyhow::{Context, Result};
use faer::Mat;
use gp_core::{Coregionalization, Gp, SquaredExponential};
use rayon::{ThreadPool, ThreadPoolBuilder};
use serde::Serialize;

use super::benchmark::Benchmark;
use super::floor::Floor;
use super::timing::{Case, Row};
use fixtures::surface::{NOISE_SD, surface};

pub(super) const BENCHMARK: Benchmark = Benchmark {
    name: "gp",
    about: "exact GP of N rows and 2 inputs beside faer's matrix product with as many operations: \
            N³ for the likelihood with gradient, N² for a prediction with variance; the likelihood of \
            three outputs at N inputs beside that of the same rows in another order",
    rows: |_| rows(),
};

/// Sizes and rounds: enough of them where one is short.
const LIKELIHOODS: [(usize, usize); 3] = [(500, 51), (2000, 9), (5000, 3)];
const FIT_SIZE: usize = 500;
const OUTPUTS_SIZE: usize = 500;
const N_OUTPUTS: usize = 3;
const PREDICTION_SIZES: [usize; 2] = [500, 2000];
const N_PREDICTIONS: usize = 10_000;
const SEED: u64 = 7;

fn rows() -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for threads in [1, 2] {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.with_context(|| format!("cannot start {threads} threads"))?;
        for (n, rounds) in LIKELIHOODS {
            rows.push(likelihood(&pool, n, rounds)?);
        }
        rows.push(fit(&pool)?);
        rows.push(outputs(&pool)?);
        for n in PREDICTION_SIZES {
            rows.push(predictions(&pool, n)?);
        }
    }
    Ok(rows)
}

/// The likelihood with its gradient in memory that is there, as while learning.
fn likelihood(pool: &ThreadPool, n: usize, rounds: usize) -> Result<Row> {
    let gp = process(n)?;
    let mut evaluator = gp.evaluator()?;
    evaluator.evaluate()?;
    let threads = pool.current_num_threads();
    let case = Case { name: "likelihood with gradient", size: n, threads, rounds, calls: 1 };
    let mut floor = Floor::new((n as f64).powi(3), threads);
    Ok(pool.install(|| case.compare(|| evaluator.evaluate(), || floor.multiply(1))))
}

/// Learning from four starts, beside as many products as it evaluates the likelihood.
fn fit(pool: &ThreadPool) -> Result<Row> {
    let (x, y) = surface(FIT_SIZE, SEED);
    let learn = || {
        let kernel = SquaredExponential::unit(2)?;
        Gp::builder(kernel).fit(x.as_ref(), &y)
    };
    let gp = learn()?;
    let starts = gp.report().into_iter().flat_map(|report| report.starts.iter().flatten());
    let n_evaluations = starts.map(|start| start.evaluations).sum();
    let threads = pool.current_num_threads();
    let case = Case { name: "fit from 4 starts", size: FIT_SIZE, threads, rounds: 3, calls: 1 };
    let mut floor = Floor::new((FIT_SIZE as f64).powi(3), threads);
    Ok(pool.install(|| case.compare(learn, || floor.multiply(n_evaluations))))
}

/// The likelihood of outputs at the same inputs, in two factors; those of an input together have none.
fn outputs(pool: &ThreadPool) -> Result<Row> {
    let (x, y) = surface(OUTPUTS_SIZE, SEED);
    let rows = |is_together: bool| -> Result<Gp> {
        let row = |k: usize| match is_together {
            true => (k / N_OUTPUTS, k % N_OUTPUTS),
            false => (k % OUTPUTS_SIZE, k / OUTPUTS_SIZE),
        };
        let n = N_OUTPUTS * OUTPUTS_SIZE;
        let entry = |k: usize, d: usize| if d == 2 { row(k).1 as f64 } else { x[(row(k).0, d)] };
        let value = |k: usize| y[row(k).0] * (1.0 + row(k).1 as f64);
        let values: Vec<f64> = (0..n).map(value).collect();
        let smooth = SquaredExponential::new(&[0.5, 0.7], 0.2)?.active(&[0, 1]);
        let kernel = smooth * Coregionalization::new(N_OUTPUTS).active(&[2]);
        let gp = Gp::builder(kernel).noise_variance(NOISE_SD * NOISE_SD);
        Ok(gp.condition(&Mat::from_fn(n, 3, entry), &values)?)
    };
    let (apart, together) = (rows(false)?, rows(true)?);
    let (mut candidate, mut reference) = (apart.evaluator()?, together.evaluator()?);
    candidate.evaluate()?;
    reference.evaluate()?;
    let threads = pool.current_num_threads();
    let name = format!("likelihood with gradient, {N_OUTPUTS} outputs");
    let case = Case { name: &name, size: OUTPUTS_SIZE, threads, rounds: 5, calls: 1 };
    Ok(pool.install(|| case.compare(|| candidate.evaluate(), || reference.evaluate())))
}

fn predictions(pool: &ThreadPool, n: usize) -> Result<Row> {
    let gp = process(n)?;
    let (x_star, _) = surface(N_PREDICTIONS, SEED + 1);
    gp.predict(x_star.as_ref())?;
    let threads = pool.current_num_threads();
    let name = predictions_name(&gp.to_model()?)?;
    let case = Case { name: &name, size: n, threads, rounds: 5, calls: 1 };
    let mut floor = Floor::new((n as f64).powi(2) * N_PREDICTIONS as f64, threads);
    Ok(pool.install(|| case.compare(|| gp.predict(x_star.as_ref()), || floor.multiply(1))))
}

/// Tells the size of the model that predicts, saved as JSON.
pub(super) fn predictions_name(model: &impl Serialize) -> Result<String> {
    let bytes = serde_json::to_vec(model).context("a model cannot be written")?.len();
    Ok(format!("10⁴ predictions with variance, model of {} kB", bytes.div_ceil(1000)))
}

fn process(n: usize) -> Result<Gp> {
    let (x, y) = surface(n, SEED);
    Ok(Gp::builder(SquaredExponential::new(&[0.5, 0.7], 0.2)?)
        .noise_variance(NOISE_SD * NOISE_SD)
        .condition(x.as_ref(), &y)?)
}

#[cfg(test)]
mod tests {
    use gp_core::Posterior;

    use super::process;

    #[test]
    fn the_timed_process_has_learned_its_surface() {
        let gp = process(200).unwrap();
        let mean = gp.predict_mean(gp.inputs()).unwrap();
        let rms = gp.outputs().iter().zip(&mean).map(|(y, m)| (y - m).powi(2)).sum::<f64>() / 200.0;
        assert!(rms.sqrt() < 0.02, "{}", rms.sqrt());
    }
}
