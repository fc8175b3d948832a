//! Gaussian processes on random features beside matrix products of as many operations.

use anyhow::{Context, Result};
use faer::Mat;
use gp_core::{Mean, Posterior};
use gp_rff::{FeatureOptions, RandomFeatures, RffGp, Spectrum, SufficientStatistics};
use rayon::{ThreadPool, ThreadPoolBuilder};

use super::benchmark::Benchmark;
use super::floor::Floor;
use super::gp::predictions_name;
use super::timing::{Case, Row};
use fixtures::surface::{NOISE_SD, surface};

pub(super) const BENCHMARK: Benchmark = Benchmark {
    name: "gp-rff",
    about: "200 random features of N rows with 2 inputs beside faer's matrix product with as many \
            operations: NM² for a fit, 3NM² for the evidence with gradient, M² for a prediction \
            with variance",
    rows: |_| rows(),
};

const N_FEATURES: usize = 200;
const N_ROWS: usize = 20_000;
const N_STREAMED: usize = 1_000_000;
const N_PREDICTIONS: usize = 10_000;
const SIGNAL_VARIANCE: f64 = 0.07;
const SEED: u64 = 7;

fn rows() -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for threads in [1, 2] {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.with_context(|| format!("cannot start {threads} threads"))?;
        rows.push(fit(&pool)?);
        rows.push(evidence(&pool)?);
        rows.push(predictions(&pool)?);
        rows.push(stream(&pool)?);
    }
    Ok(rows)
}

fn features() -> Result<RandomFeatures> {
    let options = FeatureOptions { n_features: N_FEATURES, ..FeatureOptions::default() };
    Ok(RandomFeatures::new(Spectrum::default(), &[0.5, 0.7], options)?)
}

fn floor(factor: f64, n: usize, threads: usize) -> Floor {
    Floor::new(factor * n as f64 * (N_FEATURES as f64).powi(2), threads)
}

fn process(x: &Mat<f64>, y: &[f64]) -> Result<RffGp> {
    Ok(RffGp::fit(features()?, x.as_ref(), y, SIGNAL_VARIANCE, NOISE_SD * NOISE_SD)?)
}

fn fit(pool: &ThreadPool) -> Result<Row> {
    let (x, y) = surface(N_ROWS, SEED);
    process(&x, &y)?;
    let threads = pool.current_num_threads();
    let mut floor = floor(1.0, N_ROWS, threads);
    let case = Case { name: "fit", size: N_ROWS, threads, rounds: 7, calls: 1 };
    Ok(pool.install(|| case.compare(|| process(&x, &y), || floor.multiply(1))))
}

fn evidence(pool: &ThreadPool) -> Result<Row> {
    let (x, y) = surface(N_ROWS, SEED);
    let gp = process(&x, &y)?;
    let mut evaluator = gp.evaluator(x.as_ref(), &y)?;
    evaluator.evaluate()?;
    let threads = pool.current_num_threads();
    let mut floor = floor(3.0, N_ROWS, threads);
    let case = Case { name: "evidence with gradient", size: N_ROWS, threads, rounds: 7, calls: 1 };
    Ok(pool.install(|| case.compare(|| evaluator.evaluate(), || floor.multiply(1))))
}

fn predictions(pool: &ThreadPool) -> Result<Row> {
    let (x, y) = surface(N_ROWS, SEED);
    let gp = process(&x, &y)?;
    let (x_star, _) = surface(N_PREDICTIONS, SEED + 1);
    let threads = pool.current_num_threads();
    let mut floor = floor(1.0, N_PREDICTIONS, threads);
    let name = predictions_name(&gp.to_model())?;
    let case = Case { name: &name, size: N_ROWS, threads, rounds: 7, calls: 1 };
    Ok(pool.install(|| case.compare(|| gp.predict(x_star.as_ref()), || floor.multiply(1))))
}

/// A million rows in batches, as they would come from a file.
fn stream(pool: &ThreadPool) -> Result<Row> {
    let batch = N_STREAMED / 20;
    let (x, y) = surface(batch, SEED);
    let features = features()?;
    let run = || -> Result<RffGp> {
        let mut statistics = SufficientStatistics::new(&features, 0.0)?;
        for _ in 0..20 {
            statistics.update(&features, x.as_ref(), &y)?;
        }
        let noise_variance = NOISE_SD * NOISE_SD;
        let (features, mean) = (features.clone(), Mean::Estimated);
        Ok(RffGp::from_statistics(features, statistics, SIGNAL_VARIANCE, noise_variance, mean)?)
    };
    let threads = pool.current_num_threads();
    let mut floor = floor(1.0, N_STREAMED, threads);
    let case = Case { name: "fit, streamed", size: N_STREAMED, threads, rounds: 1, calls: 1 };
    Ok(pool.install(|| case.compare(run, || floor.multiply(1))))
}
