//! Our own methods, one a process.

use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use faer::MatRef;
use gp_core::scores::{nlpd, rmse};
use gp_core::{Gp, LearnOptions, Posterior, SquaredExponential};
use gp_rff::{FeatureOptions, RffGp, RffOptions};
use gp_sparse::{GridGp, GridOptions, Placement, PseudoInputs, SparseGp, SparseOptions};

use super::Outcome;
use super::data::read;
use crate::diagnosis::peak_memory_mb;

const PSEUDO_INPUTS: usize = 100;
const FEATURES: usize = 200;

/// Learns and predicts once and prints the outcome as JSON.
///
/// # Errors
/// A file that is none; what the method fails by.
pub(crate) fn once(method: &str, file: &Path) -> Result<()> {
    let rows = read(file)?;
    let n = rows.n_training;
    let start = Instant::now();
    let (name, posterior) = learn(method, rows.x.subrows(0, n), &rows.y[..n])?;
    let learn_seconds = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let test = rows.x.subrows(n, rows.y.len() - n);
    let (mean, variance) = posterior.predict_observation(test)?;
    let outcome = Outcome {
        method: name,
        learn_seconds,
        predict_seconds: start.elapsed().as_secs_f64(),
        peak_memory_mb: peak_memory_mb()?,
        nlpd: nlpd(&rows.y[n..], &mean, &variance)?,
        rmse: rmse(&rows.truth[n..], &mean)?,
    };
    println!("{}", serde_json::to_string(&outcome).context("cannot write the outcome")?);
    Ok(())
}

fn learn(method: &str, x: MatRef<'_, f64>, y: &[f64]) -> Result<(String, Box<dyn Posterior>)> {
    let kernel = SquaredExponential::unit(2)?;
    Ok(match method {
        "exact" => {
            let options = LearnOptions { n_starts: 1, ..LearnOptions::default() };
            let gp = Gp::builder(kernel).options(options).fit(x, y)?;
            ("exact (gp-core)".to_owned(), Box::new(gp))
        }
        "sparse" => {
            let count = PSEUDO_INPUTS.min(y.len() / 2);
            let pseudo_inputs = PseudoInputs::Learnt { count, placement: Placement::default() };
            let options = SparseOptions { pseudo_inputs, ..SparseOptions::default() };
            let (gp, _) = SparseGp::learn(kernel, x, y, &options)?;
            (format!("VFE, M = {count} (gp-sparse)"), Box::new(gp))
        }
        "features" => {
            let features = FeatureOptions { n_features: FEATURES, ..FeatureOptions::default() };
            let (gp, _) = RffGp::learn(x, y, &RffOptions { features, ..RffOptions::default() })?;
            (format!("{FEATURES} features (gp-rff)"), Box::new(gp))
        }
        "grid" => {
            let (gp, report) = GridGp::learn(kernel, x, y, &GridOptions::default())?;
            (format!("grid, {} nodes (gp-sparse)", report.n_nodes), Box::new(gp))
        }
        other => bail!("no method `{other}`"),
    })
}
