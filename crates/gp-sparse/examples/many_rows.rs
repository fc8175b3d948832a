//! Ways to learn a sparse process from many rows of five inputs, where no grid goes: seconds, error of the
//! mean, density of new rows and bound.
//!
//! `cargo run --profile test -p pushlab-gp-sparse --example many_rows -- FUNCTION ROWS PSEUDO_INPUTS [all]`, of
//! `waves` or `friedman`; with `all` on all rows at once as well.

use std::time::Instant;

use faer::Mat;
use gp_core::scores::{nlpd, rmse};
use gp_core::{GpError, Posterior, SquaredExponential};
use gp_sparse::{Batches, Optimizer, Placement, PseudoInputs, SparseGp, SparseOptions};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

type Function = fn([f64; 5]) -> f64;

fn waves([a, b, c, d, e]: [f64; 5]) -> f64 {
    2.0 * (6.0 * a + 2.0 * b).sin() * (4.0 * c).cos() + 3.0 * (5.0 * d * e + a).sin()
}

/// Friedman, Multivariate adaptive regression splines (1991).
fn friedman([a, b, c, d, e]: [f64; 5]) -> f64 {
    10.0 * (std::f64::consts::PI * a * b).sin() + 20.0 * (c - 0.5).powi(2) + 10.0 * d + 5.0 * e
}

/// Inputs in [0, 1], outputs with a noise of standard deviation 1, and without.
fn data(function: Function, n: usize, seed: u64) -> (Mat<f64>, Vec<f64>, Vec<f64>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let x: Mat<f64> = Mat::from_fn(n, 5, |_, _| rng.random_range(0.0..1.0));
    let truth: Vec<f64> = (0..n).map(|i| function([0, 1, 2, 3, 4].map(|d| x[(i, d)]))).collect();
    let y = truth.iter().map(|f| f + rng.sample::<f64, _>(StandardNormal)).collect();
    (x, y, truth)
}

fn kernel() -> Result<SquaredExponential, GpError> {
    SquaredExponential::unit(5)
}

/// Learnt from the first rows, then conditioned on all.
fn from_few(
    rows: usize,
    x: &Mat<f64>,
    y: &[f64],
    options: &SparseOptions,
) -> Result<SparseGp, GpError> {
    let (few, report) = SparseGp::learn(kernel()?, x.subrows(0, rows), &y[..rows], options)?;
    let values = &report.best.parameters;
    let learnt = SquaredExponential::new(&values[..5], values[5])?;
    SparseGp::fit(learnt, x.as_ref(), y, few.pseudo_inputs(), values[6], options.settings)
}

fn main() -> Result<(), GpError> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |i: usize, usual: usize| {
        arguments.get(i).and_then(|text| text.parse().ok()).unwrap_or(usual)
    };
    let is_friedman = arguments.first().is_some_and(|one| one == "friedman");
    let function: Function = if is_friedman { friedman } else { waves };
    let (n, count) = (number(1, 100_000), number(2, 100));
    let (x, y, _) = data(function, n, 1);
    let (x_test, y_test, truth) = data(function, 10_000, 2);
    let pseudo_inputs = PseudoInputs::Learnt { count, placement: Placement::KMeans };
    let options = SparseOptions { pseudo_inputs, ..SparseOptions::default() };
    let tell = |name: &str, make: &dyn Fn() -> Result<SparseGp, GpError>| {
        let from = Instant::now();
        let gp = make()?;
        let seconds = from.elapsed().as_secs_f64();
        let (mean, variance) = gp.predict_observation(x_test.as_ref())?;
        let (error, density) = (rmse(&truth, &mean)?, nlpd(&y_test, &mean, &variance)?);
        let bound = gp.objective() / n as f64;
        println!(
            "{name}: {seconds:.1} s, error {error:.4}, density {density:.4}, bound {bound:.4}"
        );
        Ok(())
    };
    for rows in [2000, 10_000, 20_000].into_iter().filter(|rows| *rows < n) {
        tell(&format!("{rows} rows, then all"), &|| from_few(rows, &x, &y, &options))?;
    }
    for steps in [300, 1000, 3000] {
        let optimizer = Optimizer::Stochastic(Batches { steps, ..Batches::default() });
        let options = SparseOptions { optimizer, ..options.clone() };
        let learn = || Ok(SparseGp::learn(kernel()?, x.as_ref(), &y, &options)?.0);
        tell(&format!("{steps} batches of 960 rows"), &learn)?;
    }
    if arguments.get(3).is_some_and(|one| one == "all") {
        tell("all rows", &|| Ok(SparseGp::learn(kernel()?, x.as_ref(), &y, &options)?.0))?;
    }
    Ok(())
}
