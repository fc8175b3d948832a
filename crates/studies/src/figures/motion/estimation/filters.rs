//! Filters that follow a push.

use anyhow::{Context, Result};
use filter::{
    GaussHermite, Gaussian, GaussianUpdate, LinearMotion, MeasurementModel, MotionModel,
    ParticleFilter, PlanarState, PlanarSummary, Prediction, Rule, Unscented, Weights,
    rauch_tung_striebel,
};
use models::{
    PathStep, PushModel, PushVector, RecordedPush, RollOut, RollOutSettings, StepCorrelation,
    StepErrors,
};
use nalgebra::DVector;
use planar::{Pose, wrap_angle};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::task::{Direction, Measured, Seen, Touch, linear};

/// A filter by its name.
pub(super) struct Filter {
    pub(super) name: &'static str,
    kind: Kind,
}

enum Kind {
    /// Particles that nothing is told.
    Unmeasured,
    Particles,
    /// Weighed by the density of their own draws, too.
    Thesis,
    Auxiliary,
    RaoBlackwellized,
    /// By slopes at the mean.
    Extended,
    /// Unscented, as if all pushes were alike: without the few that go far off.
    Alike,
    /// By the points of a rule; smoothed or not.
    Points(&'static (dyn Rule + Sync), bool),
}

/// Degrees of freedom of a size that is the same for all pushes.
const ALIKE: f64 = 1e9;
/// Two points along each axis: 128 of seven states.
const GRID: GaussHermite = GaussHermite { order: 2 };

pub(super) const FILTERS: [Filter; 10] = [
    filter("none", Kind::Unmeasured),
    filter("particles", Kind::Particles),
    filter("thesis' weights", Kind::Thesis),
    filter("auxiliary", Kind::Auxiliary),
    filter("Rao–Blackwellised", Kind::RaoBlackwellized),
    filter("extended", Kind::Extended),
    filter("unscented", Kind::Points(&Unscented, false)),
    filter("Gauss–Hermite", Kind::Points(&GRID, false)),
    filter("unscented, smoothed", Kind::Points(&Unscented, true)),
    filter("unscented, pushes alike", Kind::Alike),
];

const fn filter(name: &'static str, kind: Kind) -> Filter {
    Filter { name, kind }
}

/// How a push was followed.
#[derive(Clone, Debug, Default)]
pub(super) struct Followed {
    /// After each step: distance from the measured place in m, turn in rad, and the level of the region
    /// that the measured pose is on the border of.
    pub(super) off: Vec<[f64; 3]>,
    /// Of all that was measured, in nats.
    pub(super) log_evidence: f64,
}

/// A push to be followed.
struct Push<'a> {
    roll_out: RollOut<'a>,
    recorded: &'a RecordedPush,
    seen: &'a Seen<'a>,
    steps: Vec<PathStep>,
}

impl Filter {
    /// # Errors
    /// What the model or the filter says.
    pub(super) fn follow(
        &self,
        model: &dyn PushModel,
        settings: &RollOutSettings,
        recorded: &RecordedPush,
        seen: &Seen<'_>,
    ) -> Result<Followed> {
        let alike = match (&self.kind, &settings.errors) {
            (Kind::Alike, StepErrors::Held(correlation)) => {
                let correlation = StepCorrelation { freedom: ALIKE, ..correlation.clone() };
                let errors = StepErrors::Held(correlation);
                Some(RollOutSettings { errors, ..settings.clone() })
            }
            _ => None,
        };
        let settings = alike.as_ref().unwrap_or(settings);
        let roll_out = RollOut { model, pushed: &recorded.pushed, settings };
        let steps = recorded.path.steps(settings.step)?;
        let push = Push { roll_out, recorded, seen, steps };
        match self.kind {
            Kind::Unmeasured | Kind::Particles | Kind::Thesis | Kind::Auxiliary => {
                push.by_particles(&self.kind)
            }
            Kind::RaoBlackwellized => push.rao_blackwellized(),
            Kind::Extended => push.by_gaussians(None, false),
            Kind::Alike => push.by_gaussians(Some(&Unscented), false),
            Kind::Points(rule, is_smoothed) => push.by_gaussians(Some(rule), is_smoothed),
        }
    }
}

impl Followed {
    fn add(&mut self, summary: &PlanarSummary, level: f64, truth: &Pose) {
        let place = (summary.mean.xy() - truth.position).norm();
        self.off.push([place, wrap_angle(summary.mean.z - truth.angle), level]);
    }

    fn add_particles<S: PlanarState>(
        &mut self,
        (particles, weights): (&[S], &Weights),
        truth: (&Pose, [f64; 2]),
    ) -> Result<()> {
        let (pose, sd) = truth;
        let summary = PlanarSummary::of(particles, weights)?;
        let measured = [pose.position.x, pose.position.y, pose.angle];
        let level = summary.level(particles, weights, measured, sd)?;
        self.add(&summary, level, pose);
        Ok(())
    }
}

impl Push<'_> {
    /// The measured pose after a step, and how well it is known.
    fn truth(&self, step: usize) -> (&Pose, [f64; 2]) {
        (&self.recorded.poses_wb[step + 1], self.recorded.pose_sd[1])
    }

    fn by_particles(&self, kind: &Kind) -> Result<Followed> {
        let mut filter = self.roll_out.start(&self.seen.start_wb, &self.recorded.path)?;
        let mut followed = Followed::default();
        let is_told = !matches!(kind, Kind::Unmeasured);
        let update = |filter: &mut ParticleFilter<'_, _>, place: usize| -> Result<f64> {
            match &self.seen.measured[place] {
                Some(measured) if is_told => Ok(filter.update(measured)?.log_evidence),
                _ => Ok(0.0),
            }
        };
        followed.log_evidence += update(&mut filter, 0)?;
        for (k, step) in self.steps.iter().enumerate() {
            let motion = self.roll_out.motion(step)?;
            match (kind, &self.seen.measured[k + 1]) {
                (Kind::Auxiliary, Some(measured)) => {
                    let ahead = self.likelihood_ahead(step, measured)?;
                    let update = filter.auxiliary_step(&motion, measured, ahead)?;
                    followed.log_evidence += update.log_evidence;
                }
                (Kind::Thesis, _) => {
                    filter.predict_weighted_by_density(&motion)?;
                    followed.log_evidence += update(&mut filter, k + 1)?;
                }
                _ => {
                    filter.predict(&motion)?;
                    followed.log_evidence += update(&mut filter, k + 1)?;
                }
            }
            followed.add_particles((filter.particles(), filter.weights()), self.truth(k))?;
        }
        Ok(followed)
    }

    /// The likelihood of a measurement where the model's mean leads a particle.
    fn likelihood_ahead<'s>(
        &'s self,
        step: &PathStep,
        measured: &'s Measured<'_>,
    ) -> Result<impl Fn(&models::PushParticle) -> f64 + Sync + 's> {
        let settings =
            RollOutSettings { errors: StepErrors::None, ..self.roll_out.settings.clone() };
        let step = *step;
        let roll_out = self.roll_out;
        Ok(move |state: &models::PushParticle| {
            let mean = RollOut { settings: &settings, ..roll_out };
            let mut moved = [state.clone()];
            let mut random = ChaCha8Rng::seed_from_u64(0);
            let motion = mean.motion(&step);
            let is_moved =
                motion.is_ok_and(|motion| motion.advance(&mut moved, &mut random).is_ok());
            if is_moved { measured.log_likelihood(&moved[0]) } else { f64::NAN }
        })
    }

    fn rao_blackwellized(&self) -> Result<Followed> {
        let mut filter = self.roll_out.start_carried(&self.seen.start_wb, &self.recorded.path)?;
        let mut followed = Followed::default();
        for k in 0..=self.steps.len() {
            if k > 0 {
                let motion = self.roll_out.carried_motion(&self.steps[k - 1])?;
                filter.predict(&motion.context("steps share errors")?)?;
            }
            if let Some(measured) = &self.seen.measured[k] {
                let of =
                    |state: &filter::RaoBlackwellized<_>| measured.log_likelihood(&state.drawn);
                let likelihoods: Vec<f64> = filter.particles().iter().map(of).collect();
                followed.log_evidence += filter.update_by(&likelihoods)?.log_evidence;
            }
            if k > 0 {
                followed
                    .add_particles((filter.particles(), filter.weights()), self.truth(k - 1))?;
            }
        }
        Ok(followed)
    }

    /// By the points of a rule; without one by slopes.
    fn by_gaussians(&self, rule: Option<&dyn Rule>, is_smoothed: bool) -> Result<Followed> {
        let vector = PushVector::new(self.roll_out, &self.seen.start_wb, &self.recorded.path)?;
        let (mut states, mut predictions) = (Vec::new(), Vec::new());
        let mut followed = Followed::default();
        let mut state = vector.start()?;
        if self.roll_out.settings.start_sd != [0.0; 2] {
            // That the pusher touches is known, too.
            let touch = Touch::of(&self.roll_out, &self.seen.start_wb, &self.recorded.path)?;
            state = state.updated_by(rule.unwrap_or(&Unscented), &touch)?.posterior;
        }
        for k in 0..=self.steps.len() {
            if k > 0 {
                let prediction = predicted(&vector, &self.steps[k - 1], &state, rule)?;
                state = prediction.state().clone();
                predictions.push(prediction);
            }
            if let Some(update) = updated(&state, self.seen.measured[k].as_ref(), rule)? {
                followed.log_evidence += update.log_evidence;
                state = update.posterior;
            }
            states.push(state.clone());
        }
        if is_smoothed {
            states = rauch_tung_striebel(&predictions, &state)?;
        }
        for (k, state) in states[1..].iter().enumerate() {
            let summary = PushVector::pose(state)?;
            let (truth, sd) = self.truth(k);
            let measured = [truth.position.x, truth.position.y, truth.angle];
            followed.add(&summary, summary.gaussian_level(measured, sd), truth);
        }
        Ok(followed)
    }
}

fn predicted(
    vector: &PushVector<'_>,
    step: &PathStep,
    state: &Gaussian,
    rule: Option<&dyn Rule>,
) -> Result<Prediction> {
    if let Some(rule) = rule {
        return Ok(state.predicted_by(rule, |point: &DVector<f64>| vector.after(step, point))?);
    }
    let (moved, slopes) = (vector.after(step, state.mean())?, vector.slopes(step, state)?);
    let added = moved.mean() - &slopes * state.mean();
    let added = Gaussian::new(added, moved.covariance().clone())?;
    Ok(state.predicted(&LinearMotion::new(slopes, added)?)?)
}

fn updated(
    state: &Gaussian,
    measured: Option<&Measured<'_>>,
    rule: Option<&dyn Rule>,
) -> Result<Option<GaussianUpdate>> {
    Ok(match measured {
        None => None,
        Some(Measured::Pose(seen)) => Some(state.updated(&linear(seen, state.mean().len())?)?),
        Some(Measured::Force(seen)) => match (Direction::of(*seen)?, rule) {
            (None, _) => None,
            (Some(direction), Some(rule)) => Some(state.updated_by(rule, &direction)?),
            (Some(direction), None) => Some(state.updated(&direction)?),
        },
    })
}
