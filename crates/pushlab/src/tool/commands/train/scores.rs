//! How well a model predicts steps that it has not seen.

use anyhow::Result;
use gp_core::scores::{coverage, nlpd, nmse};
use models::{Noise, OUTPUTS, PushModel, StepObservation};
use serde::Serialize;

/// Scores of an output.
#[derive(Serialize)]
pub(super) struct Score {
    pub(super) name: &'static str,
    /// Mean squared error over the variance of what was observed: 1 for the mean everywhere.
    pub(super) nmse: f64,
    /// The same of the physics of a hybrid alone.
    pub(super) nmse_of_physics: Option<f64>,
    /// Mean negative log predictive density, in nats, the output in m or rad.
    pub(super) nlpd: f64,
    /// The share of the observations within intervals of each of `LEVELS`.
    pub(super) coverage: Vec<Covered>,
}

/// What an interval holds.
#[derive(Serialize)]
pub(super) struct Covered {
    pub(super) level: f64,
    pub(super) share: f64,
}

const LEVELS: [f64; 3] = [0.5, 0.9, 0.95];

/// Scores of each output.
///
/// # Errors
/// If the model refuses a step, or an output never varies.
pub(super) fn scores(
    model: &dyn PushModel,
    steps: &[StepObservation],
    has_physics: bool,
) -> Result<Vec<Score>> {
    let inputs: Vec<_> = steps.iter().map(|step| step.input.clone()).collect();
    let predicted = model.predict(&inputs, Noise::Included)?;
    let parts = model.parts(&inputs)?;
    let score = |k: usize| {
        let observed: Vec<f64> = steps.iter().map(|step| step.outputs[k]).collect();
        let mean: Vec<f64> = predicted.iter().map(|found| found.mean[k]).collect();
        let physics: Vec<f64> = parts.iter().map(|parts| parts.physics[k]).collect();
        let variance: Vec<f64> = predicted.iter().map(|found| found.covariance[(k, k)]).collect();
        let shares = coverage(&observed, &mean, &variance, &LEVELS)?;
        Ok(Score {
            name: OUTPUTS[k],
            nmse: nmse(&observed, &mean)?,
            nmse_of_physics: has_physics.then(|| nmse(&observed, &physics)).transpose()?,
            nlpd: nlpd(&observed, &mean, &variance)?,
            coverage: LEVELS
                .into_iter()
                .zip(shares)
                .map(|(level, share)| Covered { level, share })
                .collect(),
        })
    };
    (0..OUTPUTS.len()).map(score).collect()
}
