//! Screens and fits of a set's parts go in, the verdict comes out: which physical effect a model
//! lacks, how sure that is, and what else it could be.

mod answer;
mod claims;
mod conclusion;
mod confirmation;
mod far_off;
mod findings;
mod found;
mod leftover;
mod members;
mod read;
mod rivals;
mod rules;
mod scatter;
mod search;
mod sentence;

use effects::Effect;
use models::{Description, Split};

pub use self::answer::{
    Clusters, DataUsed, Diagnosis, EffectFinding, ErrorFall, Gain, Leftover, MadeBy, MadeFrom,
    MotionError, NoiseOrigin, ParameterFinding, Status, Verdict,
};

use self::claims::{Claims, claims};
use self::findings::findings;
use self::leftover::leftover;
use self::members::members;
use self::search::Search;
use self::sentence::sentence;
use crate::data::thinning::thinned;
use crate::{DiagnosisError, Observations, ScreenSettings, split};

/// How a diagnosis is made.
#[derive(Clone, Debug)]
pub struct DiagnoseSettings {
    /// Effects besides those of the catalogue.
    pub own: Vec<&'static dyn Effect>,
    /// The parts of the set, if they are chosen already; else a quarter is set aside.
    pub split: Option<Split>,
    /// A second set, whose pushes confirm what is fitted to all of the first; then `split` is not
    /// asked for.
    pub confirm: Option<Observations>,
    /// Seed of that choice.
    pub seed: u64,
    /// Most effects that are added.
    pub most_effects: usize,
    /// Steps above which a part of the pushes is fitted to, and a part of those set aside confirms,
    /// chosen evenly over edges and speeds.
    pub most_steps: usize,
    /// How effects are screened.
    pub screen: ScreenSettings,
    /// Pushes of the set that gave no steps: told in the answer.
    pub n_pushes_set_aside: usize,
}

impl Default for DiagnoseSettings {
    fn default() -> Self {
        Self {
            own: Vec::new(),
            split: None,
            confirm: None,
            seed: 7,
            most_effects: 3,
            most_steps: 5000,
            screen: ScreenSettings::default(),
            n_pushes_set_aside: 0,
        }
    }
}

/// What a diagnosis found, and the model with what it claims.
#[derive(Clone, Debug)]
pub struct Diagnosed {
    /// The answer.
    pub diagnosis: Diagnosis,
    /// The model with the claimed effects at their estimates; of a group that cannot be told apart
    /// the best one.
    pub description: Description,
}

/// Finds the effects of the catalogue, and of `settings.own`, that a model lacks on observed steps.
///
/// A quarter of the clusters is set aside. On the others the noise is learnt, every effect is
/// tested by its score with the signs of whole clusters flipped, the best are refitted together
/// with the nominal numbers, and the best one that obeys every rule is added, up to three times.
/// What is claimed has to predict the clusters set aside better.
///
/// # Errors
/// `TooFewPushes`; `OtherKind` for a second set that cannot confirm; `Model` for a learnt model or what an effect refuses; `NotConverged`.
pub fn diagnose(
    observations: &Observations,
    model: &Description,
    settings: &DiagnoseSettings,
) -> Result<Diagnosed, DiagnosisError> {
    let parts = match (&settings.confirm, &settings.split) {
        (Some(second), _) => observations.confirmed_by(second)?,
        (None, Some(split)) => split.clone(),
        (None, None) => split(observations, settings.seed)?,
    };
    let whole = observations.part(&parts.fit)?;
    let aside = match &settings.confirm {
        Some(second) => second.clone(),
        None => observations.part(&parts.confirm)?,
    };
    let fitted = &*thinned(&whole, settings.most_steps)?;
    let aside = &*thinned(&aside, settings.most_steps)?;
    let all = &*thinned(observations, settings.most_steps)?;
    let second = settings.confirm.as_ref();
    let search = Search { model, all, fitted, aside, settings };
    let found = search.run()?;
    let left = leftover(&found, (fitted, aside), settings)?;
    let claims: Claims = claims(&found, &left);
    let members = members(&found, &claims, fitted, model, settings);
    let effects = findings(&found, (&claims, &members), settings);
    let diagnosis = Diagnosis {
        schema: Diagnosis::SCHEMA.to_owned(),
        verdict: claims.verdict,
        sentence: sentence(&claims, &effects, &found.error, &left),
        named: claims.named.iter().map(|id| (*id).to_owned()).collect(),
        one_of: claims
            .groups
            .iter()
            .map(|g| g.iter().map(|id| (*id).to_owned()).collect())
            .collect(),
        error: found.error.clone(),
        effects,
        leftover: left.summary(),
        noise: NoiseOrigin::of(&found.noise),
        data: DataUsed {
            pushes_used: observations.pushes().len() + second.map_or(0, |set| set.pushes().len()),
            pushes_set_aside: settings.n_pushes_set_aside,
            pushes_fitted: fitted.pushes().len(),
            pushes_confirming: aside.pushes().len(),
            steps: observations.n_steps() + second.map_or(0, Observations::n_steps),
            clusters_fitted: Some(Clusters::of(fitted)),
            clusters_confirming: Some(Clusters::of(aside)),
            clusters_missing: Some(found.first_screen.calibration.clusters_missing),
        },
        split: parts,
        suspicions: Vec::new(),
        made_by: None,
    };
    Ok(Diagnosed { diagnosis, description: found.description })
}
