//! A diagnosed set of pushes: the nominal model, and the same with each effect that is identified.

use std::path::PathBuf;
use std::sync::Mutex;

use anyhow::Result;
use diagnosis::{
    DiagnoseSettings, Fit, FitSettings, NoiseFloor, NoiseModel, Observations, Predictions,
    RepeatTolerance, ScreenSettings, ScreenedEffect, diagnose, fit_with_noise, noise_floor, screen,
};
use effects::by_id;
use models::{Analytical, Description, PushModel};
use plant::{Design, GenerateSettings, Hidden, generate};

use fixtures::made_once::{key, made_once};
use fixtures::quiet_rig;
use fixtures::workspace_root;

/// Where the set with hidden effects is kept, below `target/`.
const FOLDER: &str = "hidden-effects";
/// With fewer, a diagnosis is not sure enough to name all that is hidden; quickly, a part of it is enough.
const N_PUSHES: [usize; 2] = [60, 24];
const SEED: u64 = 41;
/// What it hides besides that its object stands on its whole face, which no ellipsoid describes.
const HIDDEN: [&str; 2] =
    ["table-anisotropy: ratio=1.25, direction_deg=60", "table-tilt: x_m_s2=0.2, y_m_s2=0.1"];

/// A set with its diagnosis.
pub(crate) struct Study {
    pub(super) observations: Observations,
    /// The held-out part.
    pub(super) aside: Observations,
    /// The nominal model, and with one more effect each.
    pub(super) stages: Vec<Stage>,
    /// Of all pushes, about the last model.
    pub(super) floor: NoiseFloor,
    /// The answer in words.
    pub(super) sentence: String,
}

/// A model on the path from the nominal one to the one with all that is identified.
pub(super) struct Stage {
    /// What it has more than the one before.
    pub(super) added: Option<String>,
    /// With the nominal values as fitted, like the model of every other stage.
    pub(super) model: Description,
    /// The noise as it is learnt beside this model.
    pub(super) noise: NoiseModel,
    /// Tests of every effect that it does not have; none beside the last model.
    pub(super) screen: Vec<ScreenedEffect>,
}

impl Study {
    /// Of pushes, from a pusher of this nominal friction; none if nothing is named there.
    ///
    /// # Errors
    /// A fit that fails.
    pub(crate) fn of(observations: Observations, friction: f64) -> Result<Option<Self>> {
        let nominal = Analytical::nominal(friction)?.describe()?;
        let found = diagnose(&observations, &nominal, &DiagnoseSettings::default())?.diagnosis;
        if found.identified.is_empty() {
            return Ok(None);
        }
        let fitted = observations.part(&found.split.fit)?;
        let aside = observations.part(&found.split.confirm)?;
        let stages = stages(&fitted, &nominal, &found.identified)?;
        let best = &stages[found.identified.len()];
        let predictions = Predictions::of(&best.model, &[], &observations)?;
        let floor = noise_floor(&observations, &predictions, &RepeatTolerance::default())?;
        Ok(Some(Self { aside, stages, floor, sentence: found.sentence, observations }))
    }
}

/// The nominal model, and the same with one identified effect more each, fitted to a part.
fn stages(fitted: &Observations, nominal: &Description, named: &[String]) -> Result<Vec<Stage>> {
    let first = NoiseModel::learn(nominal, &[], fitted)?;
    let free: Vec<&str> = named.iter().map(String::as_str).collect();
    let stage = |n: usize| {
        let settings = FitSettings { resemblances: false, ..FitSettings::default() };
        let fit = fit_with_noise(fitted, nominal, &free[..n], &first, &settings)?;
        let Fit { description, with_nuisances: model, .. } = fit;
        let noise = NoiseModel::learn(&model, &[], fitted)?;
        let screen = match n < free.len() {
            true => screen(&description, &[], fitted, &noise, &ScreenSettings::default())?.effects,
            false => Vec::new(),
        };
        Ok(Stage { added: n.checked_sub(1).map(|last| named[last].clone()), model, noise, screen })
    };
    (0..=named.len()).map(stage).collect()
}

impl Stage {
    /// What it adds, for people.
    pub(super) fn title(&self) -> Option<String> {
        Some(by_id(self.added.as_deref()?).ok()?.info().title.to_lowercase())
    }
}

/// The recording set with hidden effects: the kept one, or a new one.
///
/// # Errors
/// Pushes that cannot be made.
pub(crate) fn hidden_effects(quick: bool) -> Result<PathBuf> {
    /// Figures are drawn side by side.
    static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());
    let _alone = ONE_AT_A_TIME.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let hidden = HIDDEN.iter().map(|text| text.parse::<Hidden>());
    let n_pushes = N_PUSHES[usize::from(quick)];
    let settings = GenerateSettings {
        name: format!("{n_pushes} simulated pushes with hidden effects"),
        design: Design { n_pushes, ..Design::default() },
        hidden: hidden.collect::<Result<_, _>>()?,
        seed: SEED,
        ..quiet_rig()
    };
    let folder = workspace_root().join("target").join(format!("{FOLDER}-{n_pushes}"));
    made_once(&folder, &key(std::slice::from_ref(&settings))?, |folder| {
        generate(&settings, &folder.join("set"))?;
        Ok(())
    })?;
    Ok(folder.join("set"))
}
