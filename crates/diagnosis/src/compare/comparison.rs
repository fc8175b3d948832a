//! A model against observations.

use effects::Channels;
use models::Cluster;
use serde::Serialize;

use crate::compare::axis::Axis;
use crate::compare::calibration::calibrations;
use crate::compare::concentration::concentrations;
use crate::compare::errors::channel_errors;
use crate::compare::finding::findings;
use crate::compare::residual_map::residual_maps;
use crate::compare::structure::Structure;
use crate::compare::worst::worst_pushes;
use crate::{
    ChannelError, Concentration, Covariate, DiagnosisError, DoubtfulSteps, Finding,
    IntervalCalibration, MapSettings, NoiseFloor, Observations, Predictions, ResidualMap, Runs,
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
    pub n_excluded: usize,
    /// The same by reason, in words.
    pub excluded: String,
    /// What the standard errors, intervals and tests take for independent.
    pub cluster: Cluster,
    /// Which rows are taken for steps of one push, where rows have no ids.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub runs: Option<Runs>,
    /// What these data or this model cannot tell, in words.
    pub not_asked: Vec<String>,
    /// Errors of each number of a step.
    pub channels: Vec<ChannelError>,
    /// What the floors were learnt from.
    pub floor: NoiseFloor,
    /// How honest the model's own intervals are, for each number with a variance.
    pub calibration: Vec<IntervalCalibration>,
    /// The pushes with the largest errors of motion.
    pub worst: Vec<WorstPush>,
    /// Where the model fails, in words: the regions that hold most of the error first.
    pub findings: Vec<Finding>,
    /// Steps whose motion is hardly one of a push, by kind.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub doubtful: Vec<DoubtfulSteps>,
    /// Where squared error gathers, whether or not it has a sign.
    pub concentrations: Vec<Concentration>,
    /// Mean residuals over covariates and pairs of them, the surest structure first.
    pub maps: Vec<ResidualMap>,
}

const N_WORST: usize = 10;

/// Compares predictions with what was observed.
///
/// # Errors
/// `OtherSteps` if the predictions are of other observations; `Scores` for intervals without end.
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
        n_excluded: observations.excluded().n_rows(),
        excluded: observations.excluded().to_string(),
        cluster: observations.cluster,
        runs: observations.runs,
        not_asked: not_asked(observations, &channels),
        doubtful: observations.doubtful(&residuals),
        calibration: calibrations(observations, predictions)?,
        worst: worst_pushes(&residuals, observations, &channels, N_WORST),
        channels,
        floor: floor.clone(),
        findings: findings(&structure),
        concentrations: concentrations(&structure),
        maps: residual_maps(&structure),
    })
}

/// What is not answered, for it was not measured or does not vary.
fn not_asked(observations: &Observations, channels: &[ChannelError]) -> Vec<String> {
    let axes = Axis::all(observations);
    let list = |which: &dyn Fn(Covariate) -> bool| {
        let names: Vec<_> =
            Covariate::ALL.into_iter().filter(|known| which(*known)).map(Covariate::name).collect();
        names.join(", ")
    };
    let is_axis = |covariate| axes.iter().any(|axis| axis.covariate == covariate);
    let unknown = list(&|covariate| !observations.knows(covariate));
    let constant = list(&|covariate| observations.knows(covariate) && !is_axis(covariate));
    let missing: Vec<_> = Channels::NAMES
        .into_iter()
        .filter(|name| !channels.iter().any(|c| c.name == *name))
        .collect();
    let mut said = Vec::new();
    let mut say = |what: &str, list: String| {
        if !list.is_empty() {
            said.push(format!("{what}: {list}"));
        }
    };
    say("not measured or not predicted", missing.join(", "));
    say("not known of a step", unknown);
    say("the same in every step", constant);
    if observations.runs.is_some() {
        said.push("no roll-outs: which step of a run follows which is not known".to_owned());
    } else if observations.n_steps() == observations.pushes().len() {
        said.push("no roll-outs: every push is one step".to_owned());
    }
    said
}
