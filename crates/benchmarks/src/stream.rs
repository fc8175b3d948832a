//! Sums over so many rows that no memory holds them, beside matrix products of as many operations.

use anyhow::{Context, Result, ensure};
use faer::Mat;
use fixtures::surface::surface;
use gp_core::{LinearStatistics, Parts};
use gp_rff::{FeatureOptions, RandomFeatures, Spectrum, SufficientStatistics};
use rayon::{ThreadPool, ThreadPoolBuilder};

use super::benchmark::Benchmark;
use super::floor::Floor;
use super::ingest::peak_memory;
use super::timing::{Case, Row};

pub(super) const BENCHMARK: Benchmark = Benchmark {
    name: "stream",
    about: "Statistics of N rows in batches, merged as 16 parts, beside faer's matrix product with as many \
            operations, NM²: of 20 given features for linear regression, of 50 random features of 2 inputs",
    rows: |_| rows(),
};

const N_ROWS: [usize; 2] = [10_000_000, 100_000_000];
const BATCH: usize = 100_000;
const N_PARTS: usize = 16;
/// Products of the floor, so that its matrices do not take the memory that is told.
const N_PRODUCTS: usize = 100;
const N_GIVEN: usize = 20;
const N_RANDOM: usize = 50;
const SEED: u64 = 9;

fn rows() -> Result<Vec<Row>> {
    let threads = 2;
    let pool =
        ThreadPoolBuilder::new().num_threads(threads).build().context("cannot start threads")?;
    let mut rows = Vec::new();
    // From few to many: the peak of a process never falls.
    for n in N_ROWS {
        rows.push(given(&pool, n)?);
        rows.push(random(&pool, n)?);
        if let Some(peak) = peak_memory() {
            println!("peak memory after {n} rows: {:.1} MB", peak as f64 / 1e6);
        }
    }
    Ok(rows)
}

/// Batches of a part.
fn batches(n: usize, part: usize) -> usize {
    let until = |part: usize| n / BATCH * part / N_PARTS;
    until(part + 1) - until(part)
}

fn given(pool: &ThreadPool, n: usize) -> Result<Row> {
    let features =
        Mat::from_fn(BATCH, N_GIVEN, |i, j| ((i + 1) as f64 * (0.7 + 0.1 * j as f64)).sin());
    let y: Vec<f64> = (0..BATCH).map(|i| (0.3 * i as f64).cos()).collect();
    let run = || -> Result<u64> {
        let mut parts = Parts::new(N_PARTS as u64);
        for part in 0..N_PARTS {
            let mut own = LinearStatistics::new(N_GIVEN)?;
            for _ in 0..batches(n, part) {
                own.update(features.as_ref(), &y)?;
            }
            parts.add(part as u64, own)?;
        }
        Ok(parts.finish()?.n_rows())
    };
    let name = "20 given features";
    timed(pool, name, n, (N_GIVEN, N_GIVEN + 1), run)
}

fn random(pool: &ThreadPool, n: usize) -> Result<Row> {
    let (x, y) = surface(BATCH, SEED);
    let options = FeatureOptions { n_features: N_RANDOM, ..FeatureOptions::default() };
    let features = RandomFeatures::new(Spectrum::default(), &[0.5, 0.7], options)?;
    let run = || -> Result<u64> {
        let mut parts = Parts::new(N_PARTS as u64);
        for part in 0..N_PARTS {
            let mut own = SufficientStatistics::new(&features, 0.0)?;
            for _ in 0..batches(n, part) {
                own.update(&features, x.as_ref(), &y)?;
            }
            parts.add(part as u64, own)?;
        }
        Ok(parts.finish()?.n_rows())
    };
    let name = "50 random features";
    timed(pool, name, n, (N_RANDOM, x.ncols() + 1), run)
}

/// Once, of so many features and numbers a row.
fn timed(
    pool: &ThreadPool,
    name: &str,
    n: usize,
    (n_features, n_numbers): (usize, usize),
    run: impl Fn() -> Result<u64> + Sync,
) -> Result<Row> {
    let threads = pool.current_num_threads();
    let mut floor = Floor::new(n as f64 * (n_features as f64).powi(2) / N_PRODUCTS as f64, threads);
    let case = Case { name, size: n, threads, rounds: 1, calls: 1 };
    let mut seen = Ok(0);
    let row = pool.install(|| case.compare(|| seen = run(), || floor.multiply(N_PRODUCTS)));
    ensure!(seen? == n as u64, "rows were lost");
    let rate = n as f64 / row.median_seconds;
    println!(
        "{name}: {:.2} million rows/s, {:.0} MB/s",
        1e-6 * rate,
        1e-6 * rate * (8 * n_numbers) as f64
    );
    Ok(row)
}

#[cfg(test)]
mod tests {
    use super::{BATCH, N_PARTS, batches, given, random};
    use rayon::ThreadPoolBuilder;

    #[test]
    fn parts_hold_all_batches_and_rows_are_counted() {
        let n = 37 * BATCH;
        assert_eq!((0..N_PARTS).map(|part| batches(n, part)).sum::<usize>(), 37);
        let pool = ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        for row in [given(&pool, BATCH).unwrap(), random(&pool, BATCH).unwrap()] {
            assert_eq!((row.size, row.threads), (BATCH, 1));
        }
    }
}
