//! A model against observations.

use serde::Serialize;

use crate::errors::channel_errors;
use crate::finding::findings;
use crate::residual_map::residual_maps;
use crate::structure::Structure;
use crate::worst::worst_pushes;
use crate::{
    ChannelError, DiagnosisError, Finding, MapSettings, NoiseFloor, Observations, Predictions, ResidualMap,
    WorstPush,
};

/// How wrong a model is, where, and how wrong it may be at best; in SI units.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Pushes compared.
    pub n_pushes: usize,
    /// Steps compared.
    pub n_steps: usize,
    /// Rows of the table that are not compared.
    pub n_set_aside: usize,
    /// The same by reason, in words.
    pub set_aside: String,
    /// Errors of each number of a step.
    pub channels: Vec<ChannelError>,
    /// What the floors were learnt from.
    pub floor: NoiseFloor,
    /// The pushes with the largest errors of motion.
    pub worst: Vec<WorstPush>,
    /// Where the model fails, in words: the regions that hold most of the error first.
    pub findings: Vec<Finding>,
    /// Mean residuals over covariates and pairs of them, the surest structure first.
    pub maps: Vec<ResidualMap>,
}

const N_WORST: usize = 10;

/// Compares predictions with what was observed.
///
/// # Errors
/// `OtherSteps` if the predictions are of other observations.
pub fn compare(
    observations: &Observations,
    predictions: &Predictions,
    floor: &NoiseFloor,
    settings: &MapSettings,
) -> Result<Comparison, DiagnosisError> {
    let residuals = predictions.residuals(observations)?;
    let structure = Structure::of(&residuals, observations, predictions, floor, settings);
    let channels = channel_errors(&residuals, observations, floor);
    Ok(Comparison {
        n_pushes: observations.pushes().len(),
        n_steps: observations.n_steps(),
        n_set_aside: observations.set_aside().n_rows(),
        set_aside: observations.set_aside().to_string(),
        worst: worst_pushes(&residuals, observations, &channels, N_WORST),
        channels,
        floor: floor.clone(),
        findings: findings(&structure),
        maps: residual_maps(&structure),
    })
}
