//! Sparse Gaussian processes beside matrix products of as many operations.

use anyhow::{Context, Result};
use gp_core::{Posterior, SquaredExponential};
use gp_sparse::{Approximation, Placement, PseudoInputs, SparseGp, SparseOptions, SparseSettings};
use rayon::{ThreadPool, ThreadPoolBuilder};

use super::benchmark::Benchmark;
use super::floor::Floor;
use super::gp::predictions_name;
use super::timing::{Case, Row};
use fixtures::surface::{NOISE_SD, surface};

pub(super) const BENCHMARK: Benchmark = Benchmark {
    name: "gp-sparse",
    about: "FITC of N rows, 2 inputs and M pseudo-inputs beside faer's matrix product with as many \
            operations: 6NM² for the objective with gradient (two triangular solves and two \
            symmetric products of NM², one product of 2NM²), 2M² for a prediction with variance",
    rows: |_| rows(),
};

const N_ROWS: usize = 20_000;
const N_PSEUDO_INPUTS: usize = 100;
const N_PREDICTIONS: usize = 10_000;
const FIT_ROWS: usize = 2000;
const SEED: u64 = 7;

fn rows() -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for threads in [1, 2] {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.with_context(|| format!("cannot start {threads} threads"))?;
        rows.push(objective(&pool)?);
        rows.push(predictions(&pool)?);
        for count in [20, 50] {
            rows.push(fit(&pool, count)?);
        }
    }
    Ok(rows)
}

fn settings(approximation: Approximation) -> SparseSettings {
    SparseSettings { approximation, ..SparseSettings::default() }
}

fn process(n: usize, m: usize) -> Result<SparseGp> {
    let (x, y) = surface(n, SEED);
    let kernel = SquaredExponential::new(&[0.5, 0.7], 0.07)?;
    let settings = settings(Approximation::Fitc);
    let (z, noise_variance) = (x.subrows(0, m), NOISE_SD * NOISE_SD);
    Ok(SparseGp::fit(kernel, x.as_ref(), &y, z, noise_variance, settings)?)
}

fn objective(pool: &ThreadPool) -> Result<Row> {
    let gp = process(N_ROWS, N_PSEUDO_INPUTS)?;
    let (x, y) = surface(N_ROWS, SEED);
    let mut evaluator = gp.evaluator(x.as_ref(), &y)?;
    let threads = pool.current_num_threads();
    let operations = 6.0 * N_ROWS as f64 * (N_PSEUDO_INPUTS as f64).powi(2);
    let mut floor = Floor::new(operations, threads);
    let name = "objective with gradient, M = 100";
    let case = Case { name, size: N_ROWS, threads, rounds: 7, calls: 1 };
    Ok(pool.install(|| case.compare(|| evaluator.evaluate(), || floor.multiply(1))))
}

fn predictions(pool: &ThreadPool) -> Result<Row> {
    let gp = process(FIT_ROWS, N_PSEUDO_INPUTS)?;
    let (x_star, _) = surface(N_PREDICTIONS, SEED + 1);
    gp.predict(x_star.as_ref())?;
    let threads = pool.current_num_threads();
    let operations = 2.0 * N_PREDICTIONS as f64 * (N_PSEUDO_INPUTS as f64).powi(2);
    let mut floor = Floor::new(operations, threads);
    let name = format!("{}, M = 100", predictions_name(&gp.to_model()?)?);
    let case = Case { name: &name, size: FIT_ROWS, threads, rounds: 7, calls: 1 };
    Ok(pool.install(|| case.compare(|| gp.predict(x_star.as_ref()), || floor.multiply(1))))
}

/// Learning pseudo-inputs and hyperparameters, beside as many products as it evaluates the
/// objective; the exact process that it starts from is in its time and not in the reference.
fn fit(pool: &ThreadPool, count: usize) -> Result<Row> {
    let (x, y) = surface(FIT_ROWS, SEED);
    let options = SparseOptions {
        settings: settings(Approximation::Vfe),
        pseudo_inputs: PseudoInputs::Learnt { count, placement: Placement::default() },
        ..SparseOptions::default()
    };
    let learn = || SparseGp::learn(SquaredExponential::unit(2)?, x.as_ref(), &y, &options);
    let (_, report) = learn()?;
    let threads = pool.current_num_threads();
    let operations = 6.0 * FIT_ROWS as f64 * (count as f64).powi(2);
    let mut floor = Floor::new(operations, threads);
    let evaluations = report.best.evaluations;
    let name = format!("VFE fit, M = {count}, {evaluations} evaluations");
    let case = Case { name: &name, size: FIT_ROWS, threads, rounds: 3, calls: 1 };
    Ok(pool.install(|| case.compare(learn, || floor.multiply(evaluations))))
}
