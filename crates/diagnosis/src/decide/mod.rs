//! Screens and fits of a set's parts go in, the verdict comes out: which physical effect a model
//! lacks, how sure that is, and what else it could be.

mod answer;
mod beside_best;
mod both_noises;
mod claims;
mod conclusion;
mod confirmation;
mod constancy;
mod far_off;
mod few_steps;
mod findings;
mod found;
mod leftover;
mod linearised;
mod members;
mod on_points;
mod phase;
mod push_scatter;
mod raised;
mod read;
mod rivals;
mod rules;
mod search;
mod sentence;
mod standing;
mod trials;
mod tried;

use std::borrow::Cow;
use std::sync::Arc;

use effects::Effect;
use models::{Description, Split};

pub use self::answer::{
    Clusters, DataUsed, Diagnosis, EffectFinding, ErrorFall, Grade, Leftover, MadeBy, MadeFrom,
    MotionError, NoiseOrigin, ParameterFinding, Verdict,
};

pub use self::phase::DiagnosePhase;
pub use self::push_scatter::PushScatter;

use self::beside_best::BesideBest;
use self::claims::{Claims, claims};
use self::findings::findings;
use self::found::Found;
use self::leftover::{Left, leftover};
use self::members::members;
use self::search::Search;
use self::sentence::sentence;
use crate::cut_offs::MOST_ALONE;
use crate::data::thinning::thinned;
use crate::noise::widely_differing::At;
use crate::remains::RemainSettings;
use crate::{DiagnosisError, Observations, ScreenSettings, split};

/// How a diagnosis is made.
#[derive(Clone, Debug)]
pub struct DiagnoseSettings {
    /// Effects besides those of the catalogue.
    pub own: Vec<Arc<dyn Effect>>,
    /// The parts of the set, if they are chosen already; else a quarter is held out.
    pub split: Option<Split>,
    /// A second set, whose pushes confirm what is fitted to all of the first; then `split` is not
    /// asked for.
    pub confirm: Option<Observations>,
    /// Seed of that choice.
    pub seed: u64,
    /// Most effects that are added.
    pub most_effects: usize,
    /// Steps above which a part of the pushes is fitted to, and a part of those held out confirms,
    /// chosen evenly over edges and speeds.
    pub most_steps: usize,
    /// How effects are screened.
    pub screen: ScreenSettings,
    /// Pushes of the set that gave no steps: told in the answer.
    pub n_pushes_excluded: usize,
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
            n_pushes_excluded: 0,
        }
    }
}

impl DiagnoseSettings {
    /// How free components are fitted to what a model leaves.
    fn remain(&self) -> RemainSettings<'_> {
        let tolerances = self.screen.tolerances;
        RemainSettings { own: &self.own, tolerances, seed: self.seed }
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
/// A quarter of the clusters is held out. On the others the noise is learnt, every effect is
/// tested by its score with the signs of whole clusters flipped, the best are refitted together
/// with the nominal numbers, and the best one that obeys every rule is added, up to three times. Points on
/// which the object rests are tried in the place of what follows from them when that is added, and at the
/// end; then a tip that is caught at vertices, and what is hardly seen. An effect stays if it
/// predicts the held-out clusters, and the others each by a fit without it, better. It is identified if
/// its size is the same all over the set, and beside more freedom of what it comes from, if no
/// more is left than it explains, and if held-out pushes miss no measured number by more with it, nor with all that
/// is claimed; effective else. What is there and hardly seen is carried along, marked small.
///
/// A push, or a session, on which alone a number rests that every fit leaves open is excluded and told in
/// the warnings: its prediction jumps there, as where an object is caught at a corner.
///
/// # Errors
/// `TooFewPushes`; `OtherKind` for a second set that cannot confirm; `Model` for a learnt model or what an effect refuses; `NotConverged`; `OneCluster` if too many pushes would be excluded.
pub fn diagnose(
    observations: &Observations,
    model: &Description,
    settings: &DiagnoseSettings,
) -> Result<Diagnosed, DiagnosisError> {
    diagnose_with_progress(observations, model, settings, &|_| {})
}

/// The same, and tells an observer what it is at: it takes seconds to minutes. What is found does not depend
/// on who listens.
///
/// # Errors
/// As [`diagnose`].
pub fn diagnose_with_progress(
    observations: &Observations,
    model: &Description,
    settings: &DiagnoseSettings,
    observer: &dyn Fn(DiagnosePhase),
) -> Result<Diagnosed, DiagnosisError> {
    let (mut found, alone) = without_alone(observations, |kept, alone| {
        let mut settings = settings.clone();
        for part in settings.split.iter_mut().flat_map(|split| [&mut split.fit, &mut split.confirm])
        {
            part.retain(|push| !alone.contains(push));
        }
        diagnose_all(kept, model, &settings, observer)
    })?;
    if !alone.is_empty() {
        found.diagnosis.data.pushes_excluded += alone.len();
        found.diagnosis.warnings.push(format!(
            "{} of {} pushes are excluded, since a number of the model would rest on one of them alone: {}",
            alone.len(),
            observations.pushes().len(),
            alone.join(", ")
        ));
    }
    Ok(found)
}

/// What is found of observations without the pushes on which alone a number would rest, and the names of these.
///
/// # Errors
/// What `find` refuses; `OneCluster` if too many pushes would be excluded.
fn without_alone<T>(
    observations: &Observations,
    mut find: impl FnMut(&Observations, &[String]) -> Result<T, DiagnosisError>,
) -> Result<(T, Vec<String>), DiagnosisError> {
    let mut left: Vec<String> = observations.pushes().iter().map(ToString::to_string).collect();
    let most = MOST_ALONE * left.len() as f64;
    let mut alone: Vec<String> = Vec::new();
    let mut kept = Cow::Borrowed(observations);
    loop {
        match find(&kept, &alone) {
            Err(DiagnosisError::OneCluster { pushes, .. })
                if ((alone.len() + pushes.len()) as f64) < most =>
            {
                left.retain(|push| !pushes.contains(push));
                alone.extend(pushes);
                kept = Cow::Owned(observations.part(&left)?);
            }
            found => return Ok((found?, alone)),
        }
    }
}

fn diagnose_all(
    observations: &Observations,
    model: &Description,
    settings: &DiagnoseSettings,
    observer: &dyn Fn(DiagnosePhase),
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
    let search = Search { model, all, fitted, aside, settings, observer, may_expect: true };
    let (found, left) = found_and_left(&search)?;
    let BesideBest { floor, remains, besides, push_to_push } = search.beside_best(&found)?;
    let claims: Claims = claims(&found, (&left, remains.as_ref()), &besides);
    if !claims.groups.is_empty() {
        observer(DiagnosePhase::Rivals);
    }
    let members = members(&found, &claims, fitted, model, settings);
    let effects = findings(&found, (&claims, &members), settings);
    let diagnosis = Diagnosis {
        schema: Diagnosis::SCHEMA.to_owned(),
        made_by: None,
        warnings: Vec::new(),
        verdict: claims.verdict,
        sentence: sentence(
            &claims,
            &effects,
            &found.error,
            (&left, remains.as_ref()),
            &push_to_push,
        ),
        identified: claims.identified.iter().map(|id| (*id).to_owned()).collect(),
        ambiguous: claims
            .groups
            .iter()
            .map(|g| g.iter().map(|id| (*id).to_owned()).collect())
            .collect(),
        effective: claims.effective.iter().map(|(id, _)| (*id).to_owned()).collect(),
        error: ErrorFall { floor_si: floor, ..found.error.clone() },
        effects,
        leftover: left.summary(remains.as_ref()),
        remains,
        noise: NoiseOrigin::of(&found.noise, push_to_push),
        data: data_used(&found, (observations, second), (fitted, aside), settings),
        split: parts,
        suspicions: Vec::new(),
        next: Vec::new(),
    };
    Ok(Diagnosed { diagnosis, description: found.description })
}

/// What a search finds, and what it leaves over.
///
/// What is left in one view of pushes that differ widely, and not in the other, is no fault of the model.
fn found_and_left(search: &Search) -> Result<(Found, Left), DiagnosisError> {
    let beside = |found: Found| {
        (search.observer)(DiagnosePhase::Remains);
        let left = leftover(&found, (search.fitted, search.aside), search.settings)?;
        Ok::<_, DiagnosisError>((found, left))
    };
    let (found, left) = beside(search.run()?)?;
    if found.at == At::Expected && left.is_left() {
        let other = beside(Search { may_expect: false, ..*search }.run()?)?;
        if !other.1.is_left() {
            return Ok(other);
        }
    }
    Ok((found, left))
}

/// What was used of a set and a second one, in the parts that were fitted to and that confirmed.
fn data_used(
    found: &Found,
    (observations, second): (&Observations, Option<&Observations>),
    (fitted, aside): (&Observations, &Observations),
    settings: &DiagnoseSettings,
) -> DataUsed {
    DataUsed {
        pushes_used: observations.pushes().len() + second.map_or(0, |set| set.pushes().len()),
        pushes_excluded: settings.n_pushes_excluded,
        pushes_fitted: fitted.pushes().len(),
        pushes_confirming: aside.pushes().len(),
        steps: observations.n_steps() + second.map_or(0, Observations::n_steps),
        runs: observations.runs,
        clusters_fitted: Some(Clusters::of(fitted)),
        clusters_confirming: Some(Clusters::of(aside)),
        clusters_missing: Some(found.first_screen.calibration.clusters_missing),
    }
}

#[cfg(test)]
mod tests {
    use models::Cluster;

    use super::{DiagnoseSettings, Diagnosis, Verdict, diagnose, without_alone};
    use crate::synthetic::{SessionErrors, recorded, repeated};
    use crate::{DiagnosisError, Observations};

    #[test]
    fn pushes_on_which_alone_a_number_rests_are_left_out_until_they_are_too_many() {
        let (all, _) = recorded(1);
        let n = all.pushes().len();
        // As if a number rested on each of the first so many pushes.
        let without = |n_alone: usize| {
            without_alone(&all, |kept, alone| {
                assert_eq!(kept.pushes().len() + alone.len(), n);
                if alone.len() < n_alone { Err(kept.alone_determines(0)) } else { Ok(()) }
            })
        };
        let first: Vec<String> = all.pushes()[..2].iter().map(ToString::to_string).collect();
        assert_eq!(without(0).unwrap().1, Vec::<String>::new());
        assert_eq!(without(2).unwrap().1, first);
        assert!(matches!(without(n / 8), Err(DiagnosisError::OneCluster { .. })));
    }

    /// Twenty sessions leave fifteen to fit to: flips of fewer than thirteen make no name sure.
    const N_SESSIONS: u32 = 20;
    /// Six pushes a session, which share 6 mm of the friction center's offset.
    const SHARED: [(&str, f64); 1] = [("friction-center-offset", 6e-3)];

    fn diagnosed((observed, seed): (&Observations, u64), sessions: &SessionErrors) -> Diagnosis {
        let settings = DiagnoseSettings { seed, ..DiagnoseSettings::default() };
        diagnose(observed, &sessions.model, &settings).unwrap().diagnosis
    }

    fn names(found: &Diagnosis) -> bool {
        matches!(found.verdict, Verdict::Identified | Verdict::Ambiguous)
    }

    fn claims(found: &Diagnosis) -> bool {
        names(found) || matches!(found.verdict, Verdict::Effective | Verdict::Unexplained)
    }

    /// `PUSHLAB_SESSION_SETS` sets, two of them else.
    #[test]
    fn what_sessions_share_is_no_effect_and_no_structure() {
        let sets = std::env::var("PUSHLAB_SESSION_SETS").ok();
        let n_sets: u64 = sets.map_or(2, |n| n.parse().unwrap());
        let (all, model) = repeated(N_SESSIONS, 2);
        let sessions = SessionErrors::of((all, model), &SHARED);
        let found = |seed: u64| {
            let found = diagnosed((&sessions.observed(seed, 0.0), seed), &sessions);
            assert_eq!(found.data.clusters_fitted.map(|fitted| fitted.n), Some(15));
            assert_eq!(found.data.clusters_missing, Some(0));
            found
        };
        let found: Vec<Diagnosis> = (1..=n_sets).map(found).collect();
        let [named, claimed] =
            [names, claims].map(|is| found.iter().filter(|found| is(found)).count() as u64);
        println!("{named} named, {claimed} named or with structure, of {n_sets}");
        assert!(100 * named <= n_sets && 20 * claimed <= n_sets, "{named}, {claimed} of {n_sets}");
    }

    /// Else the law above says nothing.
    #[test]
    fn pushes_as_clusters_make_structure_of_what_sessions_share() {
        let (all, model) = repeated(N_SESSIONS, 2);
        let sessions = SessionErrors::of((all, model), &SHARED);
        let is_claimed = |seed: u64| {
            let mut observed = sessions.observed(seed, 0.0);
            observed.cluster = Cluster::Push;
            observed.cluster_of.clone_from(&observed.push_of);
            claims(&diagnosed((&observed, seed), &sessions))
        };
        assert!((1..=3).any(is_claimed));
    }

    #[test]
    fn what_all_sessions_share_is_named() {
        let (all, model) = repeated(N_SESSIONS, 1);
        let sessions = SessionErrors::of((all, model), &[("friction-center-offset", 1e-3)]);
        let found = diagnosed((&sessions.observed(1, 6.0), 1), &sessions);
        assert_eq!(found.identified, ["friction-center-offset"], "{}", found.sentence);
    }
}
