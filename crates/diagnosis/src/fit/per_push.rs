//! How much a parameter differs from push to push, from session to session, and from place to place.

use std::collections::BTreeMap;

use effects::{Effect, EffectInfo, Parameter, PusherFriction, Role, Setting, Spread, by_id_with};
use models::{Base, Description, ModelEffect};

use super::descent::{Exactness, Minimum};
use super::estimates::estimates;
use super::free_spread::{FreeSpread, sized};
use super::member::Member;
use super::motion_errors::{Missed, missed};
use super::problem::Problem;
use super::robust::Robust;
use super::search::Found;
use super::session_share::session_share;
use super::space::Space;
use super::{Fit, FitSettings, MotionErrors};
use crate::predict::candidates::follow_from_points;
use crate::{DiagnosisError, NoiseModel, Observations};

/// A spread that was fitted, with the values that go with it.
#[derive(Clone, Debug)]
pub struct SpreadFit {
    /// The model with it, and its values.
    pub fit: Fit,
    /// Names of the parameters that have it.
    pub parameters: Vec<&'static str>,
    /// How much they differ from push to push of a session.
    pub per_push: Spread,
    /// How much they differ from session to session, beside that; none where fewer than four sessions, or no
    /// sure difference, were seen.
    pub per_session: Option<Spread>,
    /// How much they differ from place to place, faster than a step is long.
    pub per_place: Spread,
    /// Mean gain of log density of a cluster over no spread, in nats, and its standard error.
    pub gain: [f64; 2],
    /// What else scatters motions.
    pub errors: MotionErrors,
}

const NOT_THERE: &str = "the model does not carry it; add it first";
/// Sizes tried, in the typical size of the effect; logarithms as they are.
const TRIED: [f64; 9] = [0.0, 0.1, 0.2, 0.35, 0.5, 0.7, 1.0, 1.4, 2.0];
/// Shares of the variance that a push keeps.
const SHARES: [f64; 9] = [0.0, 0.05, 0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 1.0];
/// Of real tails, in degrees of freedom of Student's t.
const TAILS: f64 = 4.0;
/// Times that the gaps beside the best one are halved.
const HALVINGS: usize = 2;
/// Times that the largest size grows while it is the likeliest.
const WIDENINGS: usize = 6;
/// Fits of all values, each under the errors of the last.
const ROUNDS: usize = 2;

/// Fits by how much an effect of the model differs from push to push and from place to place, with the values
/// of the effect and of all that the model carries with a standard error.
///
/// Where a number differs within the way of a step, the step moves as expected over it, and the expectation is
/// not the motion at the mean: that tells the whole spread. What a push keeps of it moves all of its steps
/// alike: that tells the share from push to push. Other errors, of each step and of the push, have
/// Student's t with four degrees. A friction differs by its logarithm, other parameters by their unit; the
/// components of a vector alike. A center of friction beside points that say where the object rests keeps its
/// value.
///
/// # Errors
/// `NotPerPush` for an effect that the model lacks, or whose parameters are no plain numbers or vectors;
/// `Model` for what a prediction refuses; as [`super::fit`].
pub fn fit_per_push(
    observations: &Observations,
    model: &Description,
    effect: &str,
    settings: &FitSettings,
) -> Result<SpreadFit, DiagnosisError> {
    let effect = by_id_with(effect, &settings.own).map_err(models::ModelError::from)?;
    let about = effect.info();
    let refuse = |why| Err(DiagnosisError::NotPerPush { effect: about.id, why });
    let is_plain = |parameter: &Parameter| {
        matches!(parameter.role, Role::Even | Role::Odd | Role::Share | Role::X(_) | Role::Y(_))
    };
    if !about.parameters.iter().all(is_plain) {
        return refuse("its parameters are no plain numbers; choose an effect that has such alone");
    }
    let settings = &FitSettings { resemblances: false, ..settings.clone() };
    let fitting = Fitting { observations, about, unit: unit(about), settings };
    let none = fitting.at(carrying(model, about)?, 0.0)?;
    let mut best = fitting.likeliest_size(none.clone())?;
    let mut fit = fitting.values(&best)?;
    for _ in 1..ROUNDS {
        best = fitting.likeliest_share(fit)?;
        fit = fitting.values(&best)?;
    }
    let (fit, whole) = fit;
    let best = fitting.likeliest_share((fit.clone(), whole))?;
    let gain = gain(&best.densities, &none.densities, observations);
    let parameters = about.parameters.iter().map(|parameter| parameter.name).collect();
    let [of_pushes, per_place] = fitting.parts(&best);
    let missed = missed(observations, &best.model, &settings.own)?;
    let share = session_share(observations, &missed, &best.errors)?;
    let part = |share: f64| sized(of_pushes, share.sqrt());
    let (per_push, per_session) = (part(1.0 - share.unwrap_or_default()), share.map(part));
    let spread = |mut model: Description| {
        fitting.spread(&mut model, [per_push, per_place]);
        for carried in model.effects.iter_mut().filter(|carried| carried.id == about.id) {
            let names = about.parameters.iter().map(|one| one.name.to_owned());
            carried.per_session = names.zip(per_session.into_iter().cycle()).collect();
        }
        model
    };
    let (description, with_nuisances) = (spread(fit.description), spread(fit.with_nuisances));
    let fit = Fit { description, with_nuisances, ..fit };
    let errors = best.errors;
    Ok(SpreadFit { fit, parameters, per_push, per_session, per_place, gain, errors })
}

/// The spread of size 1 of an effect's parameters: of one positive number that is never off relative.
fn unit(about: &EffectInfo) -> Spread {
    match about.parameters {
        [one] if one.range.0 >= 0.0 && one.off != effects::Off::At(0.0) => Spread::RelativeSd(1.0),
        all => Spread::Sd(all.iter().map(|one| one.typical.abs()).fold(0.0, f64::max)),
    }
}

struct Fitting<'a> {
    observations: &'a Observations,
    about: &'a EffectInfo,
    unit: Spread,
    settings: &'a FitSettings,
}

/// A size that was tried.
#[derive(Clone)]
struct Tried {
    model: Description,
    /// Of the spread over pushes and places together.
    size: f64,
    /// Of its variance, what a push keeps.
    share: f64,
    errors: MotionErrors,
    /// Log density of each push.
    densities: Vec<f64>,
}

impl Tried {
    fn sum(&self) -> f64 {
        self.densities.iter().sum()
    }
}

impl Fitting<'_> {
    /// A model in which all of a spread is from push to push.
    fn at(&self, mut model: Description, size: f64) -> Result<Tried, DiagnosisError> {
        self.spread(&mut model, [sized(self.unit, size), sized(self.unit, 0.0)]);
        let missed = missed(self.observations, &model, &self.settings.own)?;
        let errors = MotionErrors::of_missed(&missed, Some(TAILS))?;
        let densities = errors.of_each(&missed)?;
        Ok(Tried { model, size, share: 1.0, errors, densities })
    }

    /// Puts spreads over pushes and over places into a model.
    fn spread(&self, model: &mut Description, [per_push, per_place]: [Spread; 2]) {
        let of = |spread: Spread| -> BTreeMap<String, Spread> {
            let names = self.about.parameters.iter().map(|one| (one.name.to_owned(), spread));
            if spread.is_none() { BTreeMap::new() } else { names.collect() }
        };
        for carried in model.effects.iter_mut().filter(|carried| carried.id == self.about.id) {
            (carried.per_push, carried.per_place) = (of(per_push), of(per_place));
            // What an earlier fit gave to sessions is told anew with the rest.
            carried.per_session.clear();
        }
    }

    fn parts(&self, tried: &Tried) -> [Spread; 2] {
        [tried.share, 1.0 - tried.share].map(|share| sized(self.unit, tried.size * share.sqrt()))
    }

    /// The likeliest size with the values of the model, all of it from push to push.
    fn likeliest_size(&self, none: Tried) -> Result<Tried, DiagnosisError> {
        let model = none.model.clone();
        let tried = |size: f64| self.at(model.clone(), size);
        let mut all = vec![none];
        all.extend(TRIED.into_iter().skip(1).map(tried).collect::<Result<Vec<Tried>, _>>()?);
        // The likeliest may be beyond sizes that are met.
        for _ in 0..WIDENINGS {
            let [.., before, last] = all.as_slice() else { break };
            let size = 1.5 * last.size;
            let is_allowed = |one: &Parameter| sized(self.unit, size).check(one).is_ok();
            if last.sum() <= before.sum() || !self.about.parameters.iter().all(is_allowed) {
                break;
            }
            all.push(tried(size)?);
        }
        likeliest(all, |one, other| tried(0.5 * (one.size + other.size)))
    }

    /// The likeliest share of a spread that was fitted.
    fn likeliest_share(&self, (fit, size): (Fit, f64)) -> Result<Tried, DiagnosisError> {
        let mut model = fit.description;
        self.spread(&mut model, [sized(self.unit, size), sized(self.unit, 0.0)]);
        let missed = missed(self.observations, &model, &self.settings.own)?;
        let tried = |share: f64| {
            let part = |of: &Missed| of.keeping(share);
            let missed: Vec<Missed> = missed.iter().map(part).collect();
            let errors = MotionErrors::of_missed(&missed, Some(TAILS))?;
            let densities = errors.of_each(&missed)?;
            let mut tried = Tried { model: model.clone(), size, share, errors, densities };
            let parts = self.parts(&tried);
            self.spread(&mut tried.model, parts);
            Ok(tried)
        };
        let all = SHARES.into_iter().map(tried).collect::<Result<Vec<Tried>, _>>()?;
        likeliest(all, |one, other| tried(0.5 * (one.share + other.share)))
    }

    /// The values, and the size of the whole spread, by the expected motions under errors that are known.
    fn values(&self, under: &Tried) -> Result<(Fit, f64), DiagnosisError> {
        let Self { observations, about, settings, .. } = *self;
        // What is being fitted is not known beforehand.
        let mut typical = under.model.clone();
        self.spread(&mut typical, [sized(self.unit, 0.0); 2]);
        let noise = NoiseModel::learn(&typical, &settings.own, observations)?;
        let noise = noise.whitening(&typical, &settings.own, observations)?;
        let whitening =
            under.errors.whitening(&noise, observations, &under.model, &settings.own)?;
        let asked = if self.follows(&under.model) { vec![] } else { vec![about.id] };
        let mut space = Space::new(observations, &under.model, &asked, settings, None)?;
        let spread = FreeSpread::new(about.id, about.parameters, self.unit, under.size);
        let mut start = space.place(|member| member.start.clone());
        start.push(spread.start());
        space.spread = Some(spread);
        let has_mixture = space.members.iter().any(Member::is_moved_mixture);
        let exactness = if has_mixture { Exactness::Mixture } else { Exactness::Estimates };
        let robust =
            Robust::at(&whitening.rows(), &whitening.whiten_residuals(&space.residuals(&start)?));
        let mut problem = Problem::new(space, &whitening, robust);
        let after = problem.settle(start.clone(), None, exactness)?;
        let before = Minimum { at: problem.stand(start)?, ..after.clone() };
        let size = problem.space.spread_at(&after.at.x).unwrap_or_default().max(0.0).sqrt();
        let found = Found { before, after };
        Ok((estimates(&problem, &found, observations, &under.model, settings)?, size))
    }

    /// Whether its value follows from where a model says that the object rests.
    fn follows(&self, model: &Description) -> bool {
        let says_where = |carried: &ModelEffect| {
            by_id_with(&carried.id, &self.settings.own)
                .is_ok_and(|effect| effect.info().stages.contains(&effects::Stage::Pressure))
        };
        follow_from_points().contains(&self.about.id) && model.effects.iter().any(says_where)
    }
}

/// The likeliest of ordered trials, after some between it and its neighbors.
fn likeliest(
    mut all: Vec<Tried>,
    between: impl Fn(&Tried, &Tried) -> Result<Tried, DiagnosisError>,
) -> Result<Tried, DiagnosisError> {
    let best = |all: &[Tried]| {
        let sums = all.iter().map(Tried::sum).enumerate();
        sums.reduce(|best, next| if next.1 > best.1 { next } else { best }).map_or(0, |best| best.0)
    };
    for _ in 0..HALVINGS {
        let best = best(&all);
        for right in [best + 1, best] {
            if (1..all.len()).contains(&right) {
                all.insert(right, between(&all[right - 1], &all[right])?);
            }
        }
    }
    let best = best(&all);
    Ok(all.swap_remove(best))
}

/// The model with the effect, which may be the base's friction.
fn carrying(model: &Description, about: &EffectInfo) -> Result<Description, DiagnosisError> {
    let mut model = model.clone();
    if !model.effects.iter().any(|carried| carried.id == about.id) {
        let friction = match &model.base {
            Base::Analytical(base) if about.id == PusherFriction.info().id => {
                base.pusher_friction().value
            }
            _ => return Err(DiagnosisError::NotPerPush { effect: about.id, why: NOT_THERE }),
        };
        // The base has one number for all pushes.
        model.effects.push(ModelEffect::from(Setting::new(about, &[friction])));
    }
    Ok(model)
}

/// Mean gain of a cluster, and its standard error.
fn gain(with: &[f64], without: &[f64], observations: &Observations) -> [f64; 2] {
    let of_push = |push: &usize| with[*push] - without[*push];
    let clusters = observations.pushes_of_clusters();
    let gains: Vec<f64> = clusters.iter().map(|pushes| pushes.iter().map(of_push).sum()).collect();
    let n = gains.len();
    let mean = gains.iter().sum::<f64>() / n as f64;
    let square: f64 = gains.iter().map(|gain| (gain - mean).powi(2)).sum();
    [mean, (square / (n * n.saturating_sub(1).max(1)) as f64).sqrt()]
}

#[cfg(test)]
mod tests {
    use effects::{Spread, by_id};
    use models::{ChannelModel, ModelEffect};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::fit_per_push;
    use crate::FitSettings;
    use crate::synthetic::{NOISE, normal, recorded};

    /// The spreads from push to push and from place to place, and the gain, that are found of a pusher friction
    /// whose logarithm has a standard deviation of a push, and one within a step, which moves as expected over it.
    fn found(of_push: f64, of_place: f64) -> ([f64; 2], [f64; 2]) {
        let (spreads, gain, of_session) = found_in(of_push, of_place, None);
        assert_eq!(of_session, None);
        (spreads, gain)
    }

    /// The same, and the spread from session to session, where so many pushes in a row are of one.
    fn found_in(
        of_push: f64,
        of_place: f64,
        n_of_session: Option<usize>,
    ) -> ([f64; 2], [f64; 2], Option<f64>) {
        let (mut observations, model) = recorded(1);
        let about = by_id("pusher-friction").unwrap().info();
        let with = |friction: f64| ModelEffect::from(effects::Setting::new(about, &[friction]));
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let n = observations.pushes.len();
        let drawn: Vec<f64> = (0..n).map(|_| of_push * normal(&mut rng)).collect();
        let of_pushes: Vec<f64> =
            (0..n).map(|push| drawn[push - push % n_of_session.unwrap_or(1)]).collect();
        let push_of = observations.push_of.clone();
        for (step, push) in push_of.into_iter().enumerate() {
            if let Some(n) = n_of_session {
                observations.steps[step].input.session = u32::try_from(push / n).unwrap();
            }
            let mut one = model.clone();
            let mut effect = with(0.25 * of_pushes[push].exp());
            effect.per_place.insert("friction".to_owned(), Spread::RelativeSd(of_place));
            one.effects.push(effect);
            let channels = ChannelModel::new(&one, observations.support, &[]).unwrap();
            let made = channels.predict([&observations.steps[step].input]).unwrap()[0].to_array();
            let numbers = observations.steps[step].observed.iter_mut().zip(NOISE);
            for ((observed, sd), made) in numbers.zip(made) {
                let noise = 0.3 * sd * normal(&mut rng);
                *observed = observed.map(|_| made + noise);
            }
        }
        let fit = fit_per_push(&observations, &model, "pusher-friction", &FitSettings::default());
        let fit = fit.unwrap();
        assert_eq!(fit.parameters, ["friction"]);
        let sd = |spread| match spread {
            Spread::RelativeSd(sd) => sd,
            Spread::Sd(sd) => panic!("{sd}"),
        };
        // The model says both.
        let carried = fit.fit.description.effects.iter().find(|one| one.id == about.id).unwrap();
        for (of, told) in [(&carried.per_push, fit.per_push), (&carried.per_place, fit.per_place)] {
            assert_eq!(of.get("friction").copied().unwrap_or(Spread::RelativeSd(0.0)), told);
        }
        ([fit.per_push, fit.per_place].map(sd), fit.gain, fit.per_session.map(sd))
    }

    #[test]
    fn a_spread_that_is_tried_takes_the_place_of_all_that_an_earlier_fit_found() {
        let (observations, mut model) = recorded(1);
        let about = by_id("pusher-friction").unwrap().info();
        let mut effect = ModelEffect::from(effects::Setting::new(about, &[0.25]));
        effect.per_push.insert("friction".to_owned(), Spread::RelativeSd(0.3));
        effect.per_session.insert("friction".to_owned(), Spread::RelativeSd(0.4));
        model.effects.push(effect);
        let settings = &FitSettings::default();
        let unit = super::unit(about);
        let fitting = super::Fitting { observations: &observations, about, unit, settings };
        fitting.spread(&mut model, [Spread::RelativeSd(0.1), Spread::RelativeSd(0.0)]);
        let setting = model.effects.last().unwrap().setting();
        assert_eq!(setting.per_push["friction"], Spread::RelativeSd(0.1));
    }

    #[test]
    fn a_friction_that_a_session_shares_is_told_from_one_that_each_push_has() {
        let ([push, _], _, session) = found_in(0.4, 0.0, Some(5));
        assert!(session.is_some_and(|sd| sd > 0.2 && sd > 2.0 * push), "{session:?} {push}");
        // Nothing differs, and no session has a part of it.
        assert_eq!(found_in(0.0, 0.0, Some(5)).2, None);
    }

    #[test]
    fn what_no_fit_tells_is_refused() {
        let (observations, mut model) = recorded(1);
        let refused = |model: &models::Description, id: &str| {
            let error = fit_per_push(&observations, model, id, &FitSettings::default());
            error.unwrap_err().to_string()
        };
        assert!(refused(&model, "table-tilt").contains("add it first"));
        let about = by_id("inertia").unwrap().info();
        model.effects.push(effects::Setting::new(about, &[1.0]).into());
        for id in ["inertia", "support-points", "table-anisotropy", "vertex-contact"] {
            assert!(refused(&model, id).contains("no plain numbers"), "{id}");
        }
    }

    #[test]
    fn a_friction_that_differs_from_push_to_push_is_told_from_one_that_does_not() {
        let ([none, _], [gain, _]) = found(0.0, 0.0);
        assert!(none < 0.08 && gain < 0.5, "{none} {gain}");
        let ([some, places], [gain, se]) = found(0.4, 0.0);
        assert!((0.25..0.6).contains(&some) && gain > 3.0 * se, "{some} {gain} {se}");
        assert!(places < some, "{places} {some}");
    }

    #[test]
    fn a_friction_that_differs_within_steps_is_told_by_their_mean_motion() {
        let ([push, place], _) = found(0.0, 0.4);
        assert!(push < 0.1 && (0.3..0.5).contains(&place), "{push} {place}");
    }
}
