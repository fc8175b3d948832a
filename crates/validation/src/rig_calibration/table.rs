//! Tables of steps of 0.2 s at 20 mm/s, real and simulated.

use std::path::Path;

use anyhow::{Context, Result};
use dataset::{
    IngestSettings, ObjectChoice, RecordingSet, StepLength, Table, TableMapping, ingest,
};
use models::{StepInput, StepObservation, StepSelection, TableSteps};
use plant::{Design, GenerateSettings, Layout, generate};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use super::Rig;

/// Steps in a table: a random part, as of the real one.
const N_STEPS: usize = 3000;
const STEP_TIME: f64 = 0.2;
/// Pushes and their steepest angle to the normal, in °, as in the public data set.
const N_PUSHES: usize = 396;
const STEEPEST: f64 = 80.0;
const SPEED: f64 = 0.02;

/// Steps and the friction of the tip that is claimed.
pub(super) struct Steps {
    pub(super) steps: Vec<StepObservation>,
    /// Push of each step, where it is known.
    pub(super) pushes: Option<Vec<usize>>,
    pub(super) friction: f64,
}

/// The public table.
pub(super) fn measured(folder: &Path) -> Result<Steps> {
    let mapping = TableMapping::mit_table()?;
    let table = mapping.read_table(&folder.join("table.csv"))?;
    let objects = ObjectChoice::Fixed(Box::new(mapping.object.clone()));
    let steps = observed(&table, &objects, mapping.pusher.radius)?.steps;
    Ok(Steps { steps, pushes: None, friction: mapping.pusher.friction })
}

/// A table of the thesis' design, made by a rig.
pub(super) fn simulated(rig: &Rig, seed: u64) -> Result<Steps> {
    let folder = tempfile::tempdir().context("cannot make a folder for the simulated set")?;
    let set = folder.path().join("set");
    let speeds = vec![SPEED];
    let settings = GenerateSettings {
        nominal: rig.nominal,
        truth: rig.truth.clone(),
        scatter: rig.scatter,
        sensors: rig.sensors,
        design: Design {
            layout: Layout::Rich,
            n_pushes: N_PUSHES,
            repeat_share: 0.0,
            steepest: STEEPEST.to_radians(),
            speeds,
            ..Design::default()
        },
        format: "csv".into(),
        seed,
        ..GenerateSettings::default()
    };
    generate(&settings, &set).with_context(|| format!("cannot simulate with seed {seed}"))?;
    let recordings = RecordingSet::open(&set)?;
    let step = StepLength::Time(STEP_TIME);
    let (table, _) = ingest(&recordings, &IngestSettings { step, ..IngestSettings::default() })?;
    let manifest = recordings.manifest();
    let found = observed(&table, &manifest.object, manifest.pusher.radius)?;
    let mut names: Vec<_> = table.rows.iter().map(|row| row.recording.clone()).collect();
    names.sort();
    names.dedup();
    let mut order: Vec<usize> = (0..found.steps.len()).collect();
    order.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
    let (mut steps, mut pushes) = (Vec::new(), Vec::new());
    for index in order.into_iter().take(N_STEPS) {
        let own = &found.steps[index];
        let (shape, radius) = (own.input.shared_shape().clone(), own.input.pusher_radius());
        // The public table tells of a step at a corner, too, where it is along the edge.
        let (edge, p, beta) = (own.input.edge(), own.input.p(), own.input.beta());
        let input = StepInput::on_edge(shape, radius, edge, p, beta, own.input.distance())?;
        steps.push(StepObservation { input, outputs: own.outputs });
        let name = &table.rows[found.rows[index]].recording;
        // Every row's recording is among them.
        pushes.push(names.partition_point(|other| other < name));
    }
    Ok(Steps { steps, pushes: Some(pushes), friction: manifest.pusher.friction })
}

fn observed(table: &Table, objects: &ObjectChoice, radius: f64) -> Result<TableSteps> {
    Ok(StepSelection::default().observations(table, objects, radius)?)
}
