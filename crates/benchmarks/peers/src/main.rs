//! Gaussian processes of other crates on a file that `cargo xtask bench gp --peers` wrote.
//!
//! `peers FILE egobox-sparse|egobox|friedrich` prints JSON objects, one a line: peer, task, size,
//! seconds of the median of some runs, and the mean negative log density of the file's test rows;
//! first with null seconds when it begins.

use std::time::Instant;

use anyhow::{Context, Result, bail, ensure};
use egobox_gp::correlation_models::SquaredExponentialCorr;
use egobox_gp::mean_models::ConstantMean;
use egobox_gp::{GaussianProcess, Inducings, ParamTuning, SparseGaussianProcess, SparseMethod};
use friedrich::gaussian_process::GaussianProcess as Friedrich;
use friedrich::kernel::Gaussian;
use friedrich::prior::ConstantPrior;
use linfa::Dataset;
use linfa::prelude::Fit;
use ndarray::{Array1, Array2};
use serde_json::json;

/// The noise of the data, which a peer that cannot learn it is given.
const NOISE_VARIANCE: f64 = 4e-4;
/// About the variance of the surface, of which a nugget is a part.
const SIGNAL_VARIANCE: f64 = 0.07;
const VERSIONS: [(&str, &str); 2] = [("egobox-gp", "0.37.1"), ("friedrich", "0.6.0")];

fn main() -> Result<()> {
    let path = std::env::args().nth(1).context("give the file of the data")?;
    let task = std::env::args().nth(2).context("give the task")?;
    let (train, test) = read(&path)?;
    match task.as_str() {
        "egobox-sparse" => [20, 50].into_iter().try_for_each(|count| sparse(&train, &test, count)),
        "egobox" => exact(&train, &test),
        "friedrich" => gradient_descent(&train, &test),
        other => bail!("no task `{other}`"),
    }
}

struct Rows {
    x: Array2<f64>,
    y: Array1<f64>,
}

/// Columns x0, x1, y and split, which is 0 for training and 1 for test rows.
fn read(path: &str) -> Result<(Rows, Rows)> {
    let mut reader = csv::Reader::from_path(path).with_context(|| format!("cannot read {path}"))?;
    let rows: Vec<(f64, f64, f64, u8)> = reader.deserialize().collect::<Result<_, _>>()?;
    ensure!(!rows.is_empty(), "{path} has no rows");
    let part = |split: u8| {
        let rows: Vec<_> = rows.iter().filter(|row| row.3 == split).collect();
        Rows {
            x: Array2::from_shape_fn((rows.len(), 2), |(i, d)| [rows[i].0, rows[i].1][d]),
            y: rows.iter().map(|row| row.2).collect(),
        }
    };
    Ok((part(0), part(1)))
}

/// Randomly placed pseudo-inputs, the library's default method and optimiser.
fn sparse(train: &Rows, test: &Rows, pseudo_inputs: usize) -> Result<()> {
    let fit = || {
        let data = Dataset::new(train.x.clone(), train.y.clone());
        SparseGaussianProcess::<f64, SquaredExponentialCorr>::params(
            SquaredExponentialCorr::default(),
            Inducings::Randomized(pseudo_inputs),
        )
        .sparse_method(SparseMethod::Fitc)
        .noise_variance(ParamTuning::Optimized { init: 1e-2, bounds: (1e-10, 1.0) })
        .seed(Some(7))
        .fit(&data)
    };
    let task = format!("sparse fit, M = {pseudo_inputs}");
    begin(VERSIONS[0], &task, train);
    let (seconds, gp) = median(5, fit);
    let gp = gp?;
    let mean = gp.predict(&test.x)?;
    let variance = gp.predict_var(&test.x)?;
    print(VERSIONS[0], &task, train, seconds, nlpd(&test.y, &mean, &variance));
    Ok(())
}

/// Its exact process knows a nugget, which is given, and learns lengthscales.
fn exact(train: &Rows, test: &Rows) -> Result<()> {
    let fit = || {
        let data = Dataset::new(train.x.clone(), train.y.clone());
        GaussianProcess::<f64, ConstantMean, SquaredExponentialCorr>::params(
            ConstantMean::default(),
            SquaredExponentialCorr::default(),
        )
        .nugget(NOISE_VARIANCE / SIGNAL_VARIANCE)
        .fit(&data)
    };
    let task = "full fit, noise given";
    begin(VERSIONS[0], task, train);
    let (seconds, gp) = median(1, fit);
    let gp = gp?;
    let mean = gp.predict(&test.x)?;
    let variance = gp.predict_var(&test.x)? + NOISE_VARIANCE;
    print(VERSIONS[0], task, train, seconds, nlpd(&test.y, &mean, &variance));
    Ok(())
}

/// One lengthscale for all inputs, at most a hundred steps of gradient descent.
fn gradient_descent(train: &Rows, test: &Rows) -> Result<()> {
    let rows =
        |x: &Array2<f64>| -> Vec<Vec<f64>> { x.rows().into_iter().map(|r| r.to_vec()).collect() };
    let (x, x_test) = (rows(&train.x), rows(&test.x));
    let fit = || {
        Friedrich::builder(x.clone(), train.y.to_vec())
            .set_kernel(Gaussian::new(1.0, SIGNAL_VARIANCE.sqrt()))
            .set_prior(ConstantPrior::new(0.0))
            .set_noise(0.1)
            .fit_kernel()
            .fit_prior()
            .train()
    };
    begin(VERSIONS[1], "full fit", train);
    let (seconds, gp) = median(1, fit);
    let (mean, variance) = gp.predict_mean_variance(&x_test);
    let noise = gp.noise * gp.noise;
    let variance: Array1<f64> = variance.iter().map(|variance| variance + noise).collect();
    let loss = nlpd(&test.y, &Array1::from_vec(mean), &variance);
    print(VERSIONS[1], "full fit", train, seconds, loss);
    Ok(())
}

/// The median time of some runs in s, and what the last one made.
fn median<T>(runs: usize, mut run: impl FnMut() -> T) -> (f64, T) {
    let mut timed = || {
        let start = Instant::now();
        let made = run();
        (start.elapsed().as_secs_f64(), made)
    };
    let mut times = Vec::new();
    let last = loop {
        let (time, made) = timed();
        times.push(time);
        if times.len() == runs {
            break made;
        }
    };
    times.sort_by(f64::total_cmp);
    (times[runs / 2], last)
}

fn nlpd(y: &Array1<f64>, mean: &Array1<f64>, variance: &Array1<f64>) -> f64 {
    let loss = |((y, mean), variance): ((&f64, &f64), &f64)| {
        0.5 * ((y - mean).powi(2) / variance + (std::f64::consts::TAU * variance).ln())
    };
    y.iter().zip(mean).zip(variance).map(loss).sum::<f64>() / y.len() as f64
}

fn print(of: (&str, &str), task: &str, train: &Rows, seconds: f64, nlpd: f64) {
    print_row(of, task, train, Some(seconds), Some(nlpd));
}

fn begin(of: (&str, &str), task: &str, train: &Rows) {
    print_row(of, task, train, None, None);
}

fn print_row(
    (name, version): (&str, &str),
    task: &str,
    train: &Rows,
    seconds: Option<f64>,
    nlpd: Option<f64>,
) {
    let peer = format!("{name} {version}");
    let size = train.y.len();
    println!(
        "{}",
        json!({"peer": peer, "task": task, "size": size, "seconds": seconds, "nlpd": nlpd})
    );
}
