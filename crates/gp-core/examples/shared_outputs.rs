//! Do outputs that share a process beat processes of their own? On a table of a planar push:
//! `cargo run --release -p pushlab-gp-core --example shared_outputs -- TABLE.csv RUNS.csv`, with two
//! columns of inputs and three of outputs, and the fold of each row in the third column of the second.

use std::error::Error;

use faer::Mat;
use gp_core::scores::{nlpd, nmse};
use gp_core::{Coregionalization, Gp, LearnOptions, Mean, Posterior, SquaredExponential, White};

const OUTPUTS: [&str; 3] = ["dx", "dy", "dθ"];

/// Rows to learn from or to predict: inputs, and outputs in standard deviations of those to learn from.
struct Rows {
    x: Vec<[f64; 2]>,
    y: [Vec<f64>; 3],
}

fn main() -> Result<(), Box<dyn Error>> {
    let paths: Vec<String> = std::env::args().skip(1).collect();
    let [table, runs] = &paths[..] else {
        return Err("give a table and its runs".into());
    };
    let (table, folds) = (read(table)?, read(runs)?);
    println!("rows  third seen  model        NLPD dx  dy  dθ  NMSE dx  dy  dθ");
    for (n_rows, every) in [(50, 1), (100, 1), (100, 5)] {
        let mut sums = [[0.0; 6]; 3];
        for fold in 0..FOLDS {
            let (train, test) = split(&table, &folds, fold, n_rows);
            let results = [
                alone(&train, &test, every)?,
                together(&train, &test, every, 1)?,
                together(&train, &test, every, 2)?,
            ];
            for (sum, scores) in sums.iter_mut().flatten().zip(results.iter().flatten()) {
                *sum += scores / FOLDS as f64;
            }
        }
        for (model, scores) in ["independent", "ICM", "LMC of 2"].iter().zip(sums) {
            let [nlpd, nmse] = [&scores[..3], &scores[3..]].map(|of| {
                of.iter().map(|score| format!("{score:7.4}")).collect::<Vec<_>>().join(" ")
            });
            println!("{n_rows:4}  1 in {every:4}   {model:11}  {nlpd}  {nmse}");
        }
    }
    Ok(())
}

/// Folds that are tested in turn.
const FOLDS: usize = 3;

fn read(path: &str) -> Result<Vec<Vec<f64>>, Box<dyn Error>> {
    let text = std::fs::read_to_string(path)?;
    let row = |line: &str| line.split(',').map(|cell| cell.trim().parse()).collect();
    let rows: Result<_, std::num::ParseFloatError> = text.lines().skip(1).map(row).collect();
    Ok(rows?)
}

fn split(table: &[Vec<f64>], runs: &[Vec<f64>], fold: usize, n_rows: usize) -> (Rows, Rows) {
    let of = |tested: bool| {
        let rows = table.iter().zip(runs);
        rows.filter(move |(_, run)| (run[2] as usize == fold) == tested).map(|(row, _)| row)
    };
    let stride = of(false).count() / n_rows;
    let train: Vec<&Vec<f64>> = of(false).step_by(stride).take(n_rows).collect();
    let scale = [2, 3, 4].map(|k| {
        let mean = train.iter().map(|row| row[k]).sum::<f64>() / n_rows as f64;
        let variance = train.iter().map(|row| (row[k] - mean).powi(2)).sum::<f64>() / n_rows as f64;
        (mean, variance.sqrt())
    });
    let rows = |rows: Vec<&Vec<f64>>| Rows {
        x: rows.iter().map(|row| [row[0], row[1]]).collect(),
        y: [0, 1, 2]
            .map(|k| rows.iter().map(|row| (row[k + 2] - scale[k].0) / scale[k].1).collect()),
    };
    (rows(train), rows(of(true).collect()))
}

fn options() -> LearnOptions {
    LearnOptions {
        n_starts: 2,
        mean: Mean::Fixed(0.0),
        max_iterations: 500,
        ..LearnOptions::default()
    }
}

fn seen(output: usize, row: usize, every: usize) -> bool {
    output < 2 || row.is_multiple_of(every)
}

/// A process of its own for each output.
fn alone(train: &Rows, test: &Rows, every: usize) -> Result<[f64; 6], Box<dyn Error>> {
    let mut scores = [0.0; 6];
    for k in 0..OUTPUTS.len() {
        let rows: Vec<usize> = (0..train.x.len()).filter(|&i| seen(k, i, every)).collect();
        let x: Vec<[f64; 2]> = rows.iter().map(|&i| train.x[i]).collect();
        let y: Vec<f64> = rows.iter().map(|&i| train.y[k][i]).collect();
        let gp = Gp::builder(SquaredExponential::unit(2)?).options(options()).fit(&x, &y)?;
        let x_test = Mat::from_fn(test.x.len(), 2, |i, d| test.x[i][d]);
        let (mean, variance) = gp.predict_observation(x_test.as_ref())?;
        scores[k] = nlpd(&test.y[k], &mean, &variance)?;
        scores[3 + k] = nmse(&test.y[k], &mean)?;
    }
    Ok(scores)
}

/// One process of all outputs, a sum of `n_terms` that they share, with a noise for each.
fn together(
    train: &Rows,
    test: &Rows,
    every: usize,
    n_terms: usize,
) -> Result<[f64; 6], Box<dyn Error>> {
    let outputs: Vec<Vec<Option<f64>>> = (train.y.iter().enumerate())
        .map(|(k, y)| y.iter().enumerate().map(|(i, y)| seen(k, i, every).then_some(*y)).collect())
        .collect();
    let (x, y) = Coregionalization::stack(&train.x, &outputs)?;
    let shared = || {
        let smooth = SquaredExponential::unit(2)?.active(&[0, 1]);
        Ok::<_, gp_core::GpError>(smooth * Coregionalization::new(3).active(&[2]))
    };
    let mut kernel = Coregionalization::independent(3).active(&[2]) * White::new(1.0) + shared()?;
    if n_terms == 2 {
        kernel = kernel + shared()?;
    }
    let mut builder = Gp::builder(kernel).options(options()).fix("white.variance", 1.0);
    builder = builder.fix("squared_exponential.signal_variance", 1.0).fix("noise_variance", 1e-6);
    if n_terms == 2 {
        builder = builder.fix("squared_exponential_2.signal_variance", 1.0);
        // Two equal terms would move alike: the second begins with a third of the lengthscales.
        builder = builder.start("squared_exponential_2.lengthscale", 0.3);
    }
    let gp = builder.fit(&x, &y)?;
    let mut scores = [0.0; 6];
    for k in 0..OUTPUTS.len() {
        let x_test = Coregionalization::inputs_of(&test.x, k);
        let (mean, variance) = gp.predict_observation(x_test.as_ref())?;
        scores[k] = nlpd(&test.y[k], &mean, &variance)?;
        scores[3 + k] = nmse(&test.y[k], &mean)?;
    }
    Ok(scores)
}
