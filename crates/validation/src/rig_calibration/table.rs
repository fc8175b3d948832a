//! Tables of steps of 0.2 s at 20 mm/s, real and simulated.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use dataset::{
    IngestSettings, ObjectChoice, RecordingSet, StepLength, Table, TableMapping, ingest,
};
use models::{StepObservation, StepSelection};
use plant::{Design, GenerateSettings, Layout, generate};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use super::Rig;
use crate::workspace::workspace_root;

/// Steps in a table: a random part, as of the real one.
const N_STEPS: usize = 3000;
const STEP_TIME: f64 = 0.2;
const SPEED: f64 = 0.02;

/// Steps and the friction of the tip that is claimed.
pub(super) struct Steps {
    pub(super) steps: Vec<StepObservation>,
    pub(super) friction: f64,
}

/// The public table.
pub(super) fn measured(folder: &Path) -> Result<Steps> {
    let mapping = TableMapping::mit_table()?;
    let table = mapping.read_table(&folder.join("table.csv"))?;
    let objects = ObjectChoice::Fixed(Box::new(mapping.object.clone()));
    observed(&table, &objects, mapping.pusher.radius, mapping.pusher.friction)
}

/// A table of the thesis' design, made by a rig.
pub(super) fn simulated(rig: &Rig, seed: u64) -> Result<Steps> {
    let folder = workspace_root().join("target/rig-calibration");
    fs::create_dir_all(&folder)?;
    let (set, truth) = (folder.join("set"), folder.join("set.truth.toml"));
    let clear = || {
        let _ = fs::remove_dir_all(&set);
        let _ = fs::remove_file(&truth);
    };
    clear();
    let speeds = vec![SPEED];
    let settings = GenerateSettings {
        nominal: rig.nominal,
        truth: rig.truth.clone(),
        scatter: rig.scatter,
        sensors: rig.sensors,
        design: Design { layout: Layout::Thesis, n_pushes: 0, speeds, ..Design::default() },
        format: "csv".into(),
        seed,
        ..GenerateSettings::default()
    };
    generate(&settings, &set).with_context(|| format!("cannot simulate with seed {seed}"))?;
    let recordings = RecordingSet::open(&set)?;
    let step = StepLength::Time(STEP_TIME);
    let (table, _) = ingest(&recordings, &IngestSettings { step, ..IngestSettings::default() })?;
    let manifest = recordings.manifest();
    let all = observed(&table, &manifest.object, manifest.pusher.radius, manifest.pusher.friction)?;
    clear();
    let mut steps = all.steps;
    steps.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
    steps.truncate(N_STEPS);
    Ok(Steps { steps, ..all })
}

fn observed(table: &Table, objects: &ObjectChoice, radius: f64, friction: f64) -> Result<Steps> {
    let steps = StepSelection::default().observations(table, objects, radius)?.steps;
    Ok(Steps { steps, friction })
}
