//! A fit over the parts of a set: a loop of equations of each part, their sum, and a step.

use effects::Effect;
use models::Description;
use nalgebra::{DMatrix, DVector};
use serde::{Deserialize, Serialize};

use super::equations::NormalEquations;
use super::fitted_model::described;
use super::gathered::{Here, Last, PartedFit};
use super::member::Member;
use super::problem::Problem;
use super::robust::Robust;
use super::space::Space;
use super::{FitSettings, field};
use crate::{DiagnosisError, NoiseModel, Observations};

/// Where a fit over parts stands, which every part has to know.
///
/// The noise is that of a sample of the set, linearised about a first fit to the sample, and the place at first is
/// that of [`crate::fit_with_noise`] on the sample. From there steps of Levenberg and Marquardt's method lead to the
/// minimum over all parts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FitPlace {
    /// Ids of the effects asked for.
    free: Vec<String>,
    /// Standard deviation of each source of error.
    noise: Vec<f64>,
    /// In the coordinates of the effects.
    x: Vec<f64>,
    /// Where the covariance of the noise is linearised.
    about: Vec<f64>,
    /// Half-widths of secants.
    widths: Vec<f64>,
    /// Typical whitened residual of a push, at least 1.
    scale: f64,
    damping: f64,
    /// The last place that was better than those before.
    last: Option<Last>,
    /// Whether no step led down from here.
    is_stuck: bool,
    /// How often slopes were worked out anew where no step led down.
    renewed: usize,
    is_converged: bool,
    /// How often weights were renewed.
    rescaled: usize,
    rounds: usize,
}

/// As a fit to a whole set.
const CONVERGED: f64 = 1e-3;
/// Near enough where a step does not lead down: as in a fit to a whole set.
const STUCK: f64 = 0.04;
/// The same where no damped step does either: half a standard error, by which such a fit looks around at a kink.
/// What is left widens the errors of the estimates.
const AT_A_KINK: f64 = 0.25;
const DAMPING: f64 = 1e-3;
/// A step that does not lead down costs a round.
const DAMPED_MORE: f64 = 100.0;
const MOST_RESCALED: usize = 6;
const MOST_RENEWED: usize = 4;
const STIFFEST: f64 = 1e3;
const KEPT: f64 = 1e-3;
const NARROWEST: f64 = 1e-4;
const SETTLED: f64 = 0.01;

impl FitPlace {
    /// Fits effects of a model to a sample of a set, for a fit to all of it to start from.
    ///
    /// # Errors
    /// As [`crate::fit_with_noise`]; `Parts` for an effect that is not fitted in parts.
    pub fn of_sample(
        sample: &Observations,
        model: &Description,
        free: &[&str],
        settings: &FitSettings,
    ) -> Result<Self, DiagnosisError> {
        let noise = NoiseModel::learn(model, &settings.own, sample)?;
        let space = Space::new(sample, model, free, settings, None)?;
        check(model, &space)?;
        let start = space.place(|member| member.start.clone());
        let residuals = space.residuals(&start)?;
        // As a fit to a whole set: twice from the same start, the second time with noise about the first fit.
        let search = |about: &Description| {
            let whitening = noise.whitening(about, &settings.own, sample)?;
            let robust = Robust::at(&whitening.rows(), &whitening.whiten_residuals(&residuals));
            let mut problem = Problem::new(space.clone(), &whitening, robust);
            let x = problem.search()?.after.at.x;
            Ok::<_, DiagnosisError>((x, problem.robust.scale(), problem.secants.clone()))
        };
        let (about, ..) = search(model)?;
        let (x, scale, widths) = search(&described(&space, model, &about, true)?)?;
        Ok(Self {
            free: free.iter().map(|id| (*id).to_owned()).collect(),
            noise: noise.sources.iter().map(|source| source.sd).collect(),
            x,
            about,
            widths,
            scale,
            damping: DAMPING,
            last: None,
            is_stuck: false,
            renewed: 0,
            is_converged: false,
            rescaled: 0,
            rounds: 0,
        })
    }

    /// Whether it is the minimum over all parts.
    pub fn is_converged(&self) -> bool {
        self.is_converged
    }

    /// The model at this place, without its nuisances.
    ///
    /// # Errors
    /// `Model`; `Parts` for a place of another model.
    pub fn description(
        &self,
        part: &Observations,
        model: &Description,
        settings: &FitSettings,
    ) -> Result<Description, DiagnosisError> {
        described(&self.space(part, model, settings)?, model, &self.x, false)
    }

    /// What a part says at this place.
    ///
    /// # Errors
    /// `Model` for what the model refuses; `Parts` for a place of another model.
    pub fn equations(
        &self,
        part: &Observations,
        model: &Description,
        settings: &FitSettings,
    ) -> Result<NormalEquations, DiagnosisError> {
        let space = self.space(part, model, settings)?;
        let noise = NoiseModel::of_sds(&self.noise).ok_or_else(other_model)?;
        let about = described(&space, model, &self.about, true)?;
        let whitening = noise.whitening(&about, &settings.own, part)?;
        let robust = Robust::of_scale(&whitening.rows(), self.scale);
        NormalEquations::of(&Problem::new(space, &whitening, robust), &self.x, &self.widths)
    }

    fn space<'a>(
        &self,
        part: &'a Observations,
        model: &Description,
        settings: &FitSettings,
    ) -> Result<Space<'a>, DiagnosisError> {
        let free: Vec<&str> = self.free.iter().map(String::as_str).collect();
        let space = Space::new(part, model, &free, settings, None)?;
        check(model, &space)?;
        let n = space.members.iter().map(Member::len).sum::<usize>();
        if self.is_sound(n) { Ok(space) } else { Err(other_model()) }
    }

    /// Whether it is a place of so many numbers.
    fn is_sound(&self, n: usize) -> bool {
        [&self.x, &self.about, &self.widths].iter().all(|own| own.len() == n)
            && self.last.as_ref().is_none_or(|last| last.is_sound(n))
    }

    /// Where the sum of all parts leads, and what it says here.
    ///
    /// # Errors
    /// `Flat`; `NotConverged` where no step leads further down, and the minimum is far; `Parts` for sums of
    /// another fit.
    pub fn step(&self, sums: &NormalEquations) -> Result<(Self, PartedFit), DiagnosisError> {
        let n = self.x.len();
        let fits = sums.is_sound() && sums.numbers.iter().all(|number| number.index < n);
        if !(fits && self.is_sound(n)) {
            return Err(other_model());
        }
        let here = Here::of((&self.x, self.scale), sums)?;
        let mut next = Self { rounds: self.rounds + 1, ..self.clone() };
        let is_lower = |last: &Last| last.value - here.last.value > KEPT * last.promise;
        if let Some(last) = self.last.as_ref().filter(|last| !is_lower(last)) {
            next.damping *= DAMPED_MORE;
            next.x.clone_from(&last.x);
            let is_stiff = next.damping >= STIFFEST;
            if last.decrement < STUCK || is_stiff && last.decrement < AT_A_KINK {
                (next.is_stuck, next.last) = (true, None);
            } else if !is_stiff {
                next.go(last.clone())?;
            } else if self.renewed < MOST_RENEWED {
                next.narrow();
            } else {
                let (what, decrement) = ("the fit over parts", last.decrement);
                return Err(DiagnosisError::NotConverged {
                    what,
                    iterations: next.rounds,
                    decrement,
                });
            }
        } else {
            next.fit_widths(self.last.as_ref(), sums);
            next.renewed = if self.last.is_some() { 0 } else { self.renewed };
            if self.is_stuck || here.last.decrement < CONVERGED {
                next.settle(sums.scale());
            } else {
                next.damping = (self.damping / 10.0).max(1e-12);
                next.go(here.last.clone())?;
            }
        }
        let ended = (next.is_converged(), next.rounds);
        let found = here.estimates(self.scale, sums, ended)?;
        Ok((next, found))
    }

    /// What comes next at the end of a descent: other weights, or nothing.
    fn settle(&mut self, scale: f64) {
        (self.damping, self.last, self.is_stuck) = (DAMPING, None, false);
        let is_settled = (scale / self.scale - 1.0).abs() < SETTLED;
        if !is_settled && self.rescaled < MOST_RESCALED {
            self.scale = scale;
            self.rescaled += 1;
        } else {
            self.is_converged = true;
        }
    }

    /// A damped step from a place.
    fn go(&mut self, mut from: Last) -> Result<(), DiagnosisError> {
        let n = from.moved.len();
        let curvature = DMatrix::from_column_slice(n, n, &from.curvature);
        let pull = DVector::from_column_slice(&from.pull);
        let mut damped = curvature.clone();
        (0..n).for_each(|k| damped[(k, k)] *= 1.0 + self.damping);
        let step = damped.cholesky().ok_or(DiagnosisError::Flat)?.solve(&pull);
        from.promise = 2.0 * step.dot(&pull) - step.dot(&(curvature * &step));
        self.x.clone_from(&from.x);
        for ((step, k), [low, high]) in step.iter().zip(&from.moved).zip(&from.ranges) {
            self.x[*k] = (self.x[*k] + step).max(*low).min(*high);
        }
        self.last = Some(from);
        Ok(())
    }

    /// Begins again where no step led down: slopes over wide secants promise what no place keeps. Those of the last
    /// step are already as narrow as the errors; from the second time on they get narrower.
    fn narrow(&mut self) {
        (self.damping, self.last) = (DAMPING, None);
        let factor = if self.renewed == 0 { 1.0 } else { 0.1 };
        self.widths.iter_mut().for_each(|width| *width *= factor);
        self.renewed += 1;
    }

    /// Secants as wide as the last step, at least as the error that each number has when all others are known.
    fn fit_widths(&mut self, last: Option<&Last>, sums: &NormalEquations) {
        let n = sums.numbers.len();
        for (k, number) in sums.numbers.iter().enumerate() {
            let curvature = sums.data.curvature[k * n + k] + sums.priors.curvature[k * n + k];
            let step = last.map_or(0.0, |last| (self.x[number.index] - last.x[number.index]).abs());
            let width = step.max(self.scale / curvature.sqrt());
            self.widths[number.index] = width.max(NARROWEST * number.secant).min(number.secant);
        }
    }
}

/// Refuses what parts cannot fit each alone.
fn check(model: &Description, space: &Space<'_>) -> Result<(), DiagnosisError> {
    let refused = |effect: &str, why: &str| {
        let what =
            format!("{effect} is not for parts of a set: {why}; use `fit` on a sample of it");
        Err(DiagnosisError::Parts { what })
    };
    let drift = effects::FrictionDrift.info().id;
    let is_carried = model.effects.iter().any(|effect| effect.id == drift);
    if is_carried || space.members.iter().any(|member| member.id() == drift) {
        return refused(drift, "it follows the place of a push in the whole set");
    }
    let has_no_slope = |member: &&Member| {
        let is_switch = member.switches().iter().any(|is_switch| *is_switch);
        is_switch
            || !member.thresholds().is_empty()
            || member.is_moved_mixture()
            || field::is_field(member.effect.info())
    };
    match space.members.iter().find(has_no_slope) {
        Some(member) => refused(member.id(), "no sum of slopes leads to it"),
        None => Ok(()),
    }
}

fn other_model() -> DiagnosisError {
    let what = "the place of the fit is of another model or release; begin anew".to_owned();
    DiagnosisError::Parts { what }
}

#[cfg(test)]
mod tests {
    use gp_core::Parts;

    use super::FitPlace;
    use crate::synthetic::pushed_with;
    use crate::{
        DiagnosisError, Fit, FitSettings, NoiseModel, NormalEquations, Observations, PartedFit,
        fit_with_noise,
    };
    use models::Description;

    const FREE: [&str; 2] = ["pusher-friction", "table-tilt"];

    fn settings() -> FitSettings {
        FitSettings { resemblances: false, ..FitSettings::default() }
    }

    /// Each fourth push from the first, the second and so on.
    fn parts(all: &Observations, of: usize) -> Vec<Observations> {
        let names: Vec<String> = all.pushes().iter().map(ToString::to_string).collect();
        let part = |k: usize| names.iter().skip(k).step_by(of).cloned().collect::<Vec<_>>();
        (0..of).map(|k| all.part(&part(k)).unwrap()).collect()
    }

    fn merged(
        place: &FitPlace,
        parts: &[Observations],
        model: &Description,
        order: &[usize],
    ) -> NormalEquations {
        let mut sums = Parts::new(parts.len() as u64);
        for k in order {
            let equations = place.equations(&parts[*k], model, &settings()).unwrap();
            // As it comes from a file.
            let text = serde_json::to_string(&equations).unwrap();
            sums.add(*k as u64, serde_json::from_str(&text).unwrap()).unwrap();
        }
        sums.finish().unwrap()
    }

    /// The end of the loop.
    fn looped(
        mut place: FitPlace,
        parts: &[Observations],
        model: &Description,
    ) -> (FitPlace, PartedFit) {
        for _ in 0..40 {
            let (next, found) = place.step(&merged(&place, parts, model, &[2, 0, 3, 1])).unwrap();
            place = serde_json::from_str(&serde_json::to_string(&next).unwrap()).unwrap();
            if found.is_converged {
                return (place, found);
            }
        }
        panic!("the loop does not end");
    }

    #[test]
    fn a_loop_over_parts_leads_to_the_fit_of_the_whole() {
        let (all, model, _) = pushed_with(("table-tilt", &[0.2, -0.1]), 5);
        let noise = NoiseModel::learn(&model, &[], &all).unwrap();
        let whole: Fit = fit_with_noise(&all, &model, &FREE, &noise, &settings()).unwrap();
        let parts = parts(&all, 4);
        let of = |sample| FitPlace::of_sample(sample, &model, &FREE, &settings()).unwrap();
        // With the noise of the whole, from the place of a sample.
        let start = FitPlace { x: of(&parts[0]).x, ..of(&all) };
        let (place, found) = looped(start, &parts, &model);
        assert!(place.is_converged() && found.decrement < 1e-3, "{found:?}");
        let counted = (found.n_pushes as usize, found.n_steps as usize);
        assert_eq!(counted, (whole.n_pushes, whole.n_steps));
        assert!((found.whitened_rms / whole.whitened_rms[1] - 1.0).abs() < 1e-2, "{found:?}");
        for effect in &whole.effects {
            let own = found.effects.iter().find(|own| own.id == effect.id).unwrap();
            for (one, other) in effect.parameters.iter().zip(&own.parameters) {
                // A thirtieth of a standard error is where either descent may end.
                let apart = (one.value - other.value).abs() / one.se;
                let is_alike = apart < 0.1 && (other.se / one.se - 1.0).abs() < 0.1;
                assert!(is_alike, "{}: {one:?} {other:?}", effect.id);
            }
        }
        let written = found.description(&model, "a set").unwrap();
        let tilt = written.effects.iter().find(|effect| effect.id == "table-tilt").unwrap();
        let source = "fit in parts to 60 pushes (440 steps) of a set";
        assert_eq!(tilt.parameters["ax"].source, source);
    }

    #[test]
    fn sums_are_the_same_bits_in_whatever_order_parts_come() {
        let (all, model, _) = pushed_with(("table-tilt", &[0.2, -0.1]), 5);
        let parts = parts(&all, 4);
        let place = FitPlace::of_sample(&parts[0], &model, &FREE[..1], &settings()).unwrap();
        let one = merged(&place, &parts, &model, &[0, 1, 2, 3]);
        for order in [[3, 2, 1, 0], [1, 3, 0, 2]] {
            assert_eq!(merged(&place, &parts, &model, &order), one);
        }
        let mut other = Parts::new(2);
        other.add(0, one.clone()).unwrap();
        let free = FitPlace::of_sample(&parts[0], &model, &FREE, &settings()).unwrap();
        let more = free.equations(&parts[1], &model, &settings()).unwrap();
        let refused = other.add(1, more.clone()).unwrap_err().to_string();
        assert!(refused.starts_with("numbers that are fitted"), "{refused}");
        assert!(matches!(place.step(&more), Err(DiagnosisError::Parts { .. })));
        // A file that lost a number.
        let mut damaged = place.clone();
        damaged.widths.pop();
        assert!(matches!(damaged.step(&one), Err(DiagnosisError::Parts { .. })));
    }

    #[test]
    fn what_parts_cannot_fit_alone_is_refused() {
        let (all, model, _) = pushed_with(("table-tilt", &[0.2, -0.1]), 5);
        for id in ["friction-drift", "support-points", "friction-field"] {
            let refused = FitPlace::of_sample(&all, &model, &[id], &settings()).unwrap_err();
            let refused = refused.to_string();
            assert!(refused.starts_with(&format!("{id} is not for parts of a set")), "{refused}");
        }
    }
}
