//! The public measurements, with what the models say of them.

use std::path::Path;

use anyhow::{Context, Result};
use dataset::{
    IngestSettings, ObjectChoice, Preset, RecordingSet, StepLength, Table, TableMapping, ingest,
};
use diagnosis::{
    Comparison, MapSettings, Observations, Predictions, PushEnds, RepeatTolerance, compare,
    noise_floor, push_ends, roll_out,
};
use models::{
    Analytical, CharacteristicLength, Description, PushModel, StepObservation, StepSelection,
};

/// Length of a step of the raw pushes, in s: the shortest that holds enough samples.
const STEP: f64 = 0.05;

/// One set with the nominal model on it.
pub(super) struct Compared {
    pub(super) observations: Observations,
    pub(super) predictions: Predictions,
    pub(super) nominal: Comparison,
    pub(super) pusher_friction: f64,
    /// The model fitted to every second step, compared on the others.
    pub(super) fitted: Option<Fitted>,
    pub(super) ends: Option<PushEnds>,
}

/// A model fitted to one half of the steps.
pub(super) struct Fitted {
    pub(super) comparison: Comparison,
    /// μp, and c in m, each with its standard error.
    pub(super) parameters: [[f64; 2]; 2],
}

/// The one-step pushes, as the preset `mit-table` reads them.
pub(super) fn one_step_table(path: &Path) -> Result<Compared> {
    let mapping = TableMapping::mit_table()?;
    let table = mapping.read_table(path)?;
    let observations = Observations::of_mapped(&table, &mapping)?;
    let nominal = Analytical::nominal(mapping.pusher.friction)?;
    let (train, test) = halves(&steps_of(&table, &mapping)?);
    let fit = nominal.fit(&train)?.model;
    let rows = Observations::of_rows(&table, &mapping)?;
    let names: Vec<String> = test.iter().map(|index| rows.pushes()[*index].to_string()).collect();
    let held_out = rows.part(&names)?;
    let CharacteristicLength::Given(length) = fit.length().clone() else {
        anyhow::bail!("the fit has left c as it was");
    };
    let friction = fit.pusher_friction().clone();
    let fitted = Fitted {
        comparison: compared(&fit.describe()?, &held_out)?.1,
        parameters: [[friction.value, friction.se], [length.value, length.se]],
    };
    let (predictions, comparison) = compared(&nominal.describe()?, &observations)?;
    let pusher_friction = mapping.pusher.friction;
    let (nominal, fitted, ends) = (comparison, Some(fitted), None);
    Ok(Compared { observations, predictions, nominal, pusher_friction, fitted, ends })
}

/// The same as steps to learn from, and the pusher's nominal friction.
pub(super) fn one_step_pushes(path: &Path) -> Result<(Vec<StepObservation>, f64)> {
    let mapping = TableMapping::mit_table()?;
    Ok((steps_of(&mapping.read_table(path)?, &mapping)?, mapping.pusher.friction))
}

fn steps_of(table: &Table, mapping: &TableMapping) -> Result<Vec<StepObservation>> {
    let objects = ObjectChoice::Fixed(Box::new(mapping.object.clone()));
    Ok(StepSelection::default().observations(table, &objects, mapping.pusher.radius)?.steps)
}

/// The raw pushes, as the preset `mit-push` reads them, in steps of [`STEP`].
pub(super) fn raw_pushes(dir: &Path) -> Result<Compared> {
    let set = RecordingSet::open_with_preset(dir, Preset::MitPush)?;
    let step = StepLength::Time(STEP);
    let (table, _) = ingest(&set, &IngestSettings { step, ..IngestSettings::default() })
        .with_context(|| format!("cannot ingest {}", dir.display()))?;
    let observations = Observations::of(&table, set.manifest())?;
    let pusher_friction = set.manifest().pusher.friction;
    let model = Analytical::nominal(pusher_friction)?.describe()?;
    let (predictions, nominal) = compared(&model, &observations)?;
    let ends = push_ends(&roll_out(&model, &[], &observations)?);
    Ok(Compared { observations, predictions, nominal, pusher_friction, fitted: None, ends })
}

fn compared(model: &Description, observations: &Observations) -> Result<(Predictions, Comparison)> {
    let predictions = Predictions::of(model, &[], observations)?;
    let floor = noise_floor(observations, &predictions, &RepeatTolerance::default())?;
    let found = compare(observations, &predictions, &floor, &MapSettings::default())?;
    Ok((predictions, found))
}

/// Every second step to fit to, and the places of the others.
fn halves(steps: &[StepObservation]) -> (Vec<StepObservation>, Vec<usize>) {
    let train = steps.iter().step_by(2).cloned().collect();
    (train, (0..steps.len()).skip(1).step_by(2).collect())
}
