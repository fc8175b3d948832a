//! A model of steps and the pusher's path go in, the whole push comes out, with its uncertainty.

pub(crate) mod carried;
pub(crate) mod measurements;
pub(crate) mod push_vector;
pub(crate) mod step_correlation;

mod exact;
mod matched;
mod motion;
mod particle;
mod push_state;
pub(crate) mod settle;
mod touch;
pub(crate) mod tracker;

use std::sync::Arc;

use filter::{ParticleFilter, PlanarSummary, Settings};
use nalgebra::Vector3;
use planar::Pose;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use serde::Serialize;

pub use self::matched::Matching;
pub use self::motion::PushMotion;
use self::particle::Drawn;
pub use self::particle::{PushEvents, PushParticle};
use crate::error::{finite, not_negative, positive};
use crate::{ContactGap, ModelError, PathStep, PushModel, PushPath, Pushed, StepCorrelation};

/// A push rolled out: particles that a model moves step by step along a path of the pusher.
///
/// At every step the contact of each particle is found anew on the outline, with outline and pusher as
/// the model has them ([`PushModel::true_outline`]):
///
/// - The pusher that **touches** pushes for the whole step; place p and angle β are those of the
///   nearest point of the outline, at a vertex those of the edge that faces the pusher more, as in the
///   step table. Each particle draws its motion from the model's Gaussian.
/// - The pusher that does **not touch** moves freely until it meets the outline while moving into it;
///   the object is still until then, and is pushed for the rest of the step.
/// - A pusher that moves **away** from the surface that it touches, or along it, is free.
/// - After a push, contact **holds**: the draw is conditioned on the gap that there was when contact
///   began (0 after a free way; at a start in contact what `gap` makes of the measured one; give or take
///   its sd). So errors along the normal do not add up, as the pusher's place is known. Where the draw
///   leaves more than `tolerance` between pusher and outline contact is **lost**, and the pusher is free.
///
/// What differs from push to push each particle draws once, and all its steps share it
/// ([`PushModel::n_drawn`]).
///
/// Each of these is counted at every step ([`Moment::events`]), and so is what a learnt model is
/// asked beyond the span of its training steps.
#[derive(Clone, Copy, Debug)]
pub struct RollOut<'a> {
    /// Who moves the object.
    pub model: &'a dyn PushModel,
    /// What is pushed.
    pub pushed: &'a Pushed,
    /// How.
    pub settings: &'a RollOutSettings,
}

/// How a push is rolled out.
#[derive(Clone, Debug, PartialEq)]
pub struct RollOutSettings {
    /// How many particles.
    pub n_particles: usize,
    /// Seed of everything random.
    pub seed: u64,
    /// The longest step, in m; a learnt model refuses longer ones than it has seen.
    pub step: f64,
    /// How errors of steps go together.
    pub errors: StepErrors,
    /// Standard deviations of the start pose: of the place along each axis, in m, and in rad.
    pub start_sd: [f64; 2],
    /// The gap that contact holds, drawn once a push: an outline, a pusher and tracked poses do not fit
    /// together exactly.
    pub gap: ContactGap,
    /// Whether the pusher is known to touch at the start, as in a recorded contact: then the measured
    /// gap is an error of measurement.
    pub touching: bool,
    /// A gap that noise makes, in m.
    pub tolerance: f64,
}

/// How the errors of the steps of a push go together.
#[derive(Clone, Debug, PartialEq)]
pub enum StepErrors {
    /// There are none: every particle goes the model's mean way.
    None,
    /// Each step's is drawn anew, with the model's variance.
    Independent,
    /// A part goes on from step to step, the rest is drawn anew, in shares that were measured.
    Held(StepCorrelation),
}

impl Default for RollOutSettings {
    fn default() -> Self {
        Self {
            n_particles: 10_000,
            seed: 7,
            step: 4e-3,
            errors: StepErrors::Independent,
            start_sd: [0.0; 2],
            gap: ContactGap::default(),
            touching: false,
            tolerance: 1e-3,
        }
    }
}

/// The distribution at one time of a roll-out.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Moment {
    /// Since the start, in s.
    pub time: f64,
    /// The pusher's center, in m, frame W.
    pub pusher_w: [f64; 2],
    /// Mean and covariance of the object's pose in W.
    pub pose_wb: PlanarSummary,
    /// What happened to the particles over the step that ends here.
    pub events: PushEvents,
}

impl RollOut<'_> {
    /// Rolls out along a path from a start pose; `watch` sees the particles at the start and after each
    /// step. The same for any number of threads.
    ///
    /// # Errors
    /// `InvalidValue` for a setting; `PusherInside` for a path that starts in the object;
    /// `StepTooLong` for a step of a path with more way than the model has seen; `Filter` for no
    /// particles, and with the step for what the model refuses.
    pub fn run(
        &self,
        start_wb: &Pose,
        path: &PushPath,
        mut watch: impl FnMut(&Moment, &[PushParticle]),
    ) -> Result<Vec<Moment>, ModelError> {
        let steps = path.steps(self.settings.step)?;
        self.check_steps(&steps)?;
        let mut filter = self.start(start_wb, path)?;
        let mut moments = Vec::with_capacity(steps.len() + 1);
        let mut note = |time, pusher_w: [f64; 2], filter: &ParticleFilter<'_, PushParticle>| {
            let particles = filter.particles();
            let pose_wb = PlanarSummary::of(particles, filter.weights())?;
            let events = PushEvents::sum(particles.iter().map(PushParticle::events));
            let moment = Moment { time, pusher_w, pose_wb, events };
            watch(&moment, particles);
            moments.push(moment);
            Ok::<(), ModelError>(())
        };
        note(0.0, path.start_w().into(), &filter)?;
        for step in &steps {
            filter.predict(&self.motion(step)?)?;
            note(step.time + step.duration, step.end_w.into(), &filter)?;
        }
        Ok(moments)
    }

    /// The particles at the start, for a filter of one's own.
    ///
    /// # Errors
    /// As [`RollOut::run`].
    pub fn start(
        &self,
        start_wb: &Pose,
        path: &PushPath,
    ) -> Result<ParticleFilter<'static, PushParticle>, ModelError> {
        self.check()?;
        let RollOutSettings { n_particles, seed, start_sd, gap, errors, .. } = self.settings;
        let [place_sd, angle_sd] = start_sd;
        let first = self.first(start_wb, path)?;
        let mut random = ChaCha8Rng::seed_from_u64(*seed);
        random.set_stream(u64::MAX);
        let mut of_push = ChaCha8Rng::seed_from_u64(*seed);
        of_push.set_stream(u64::MAX - 1);
        let n_drawn = self.n_drawn();
        let particle = |_| {
            let size = match errors {
                StepErrors::Held(correlation) => correlation.size(&mut random),
                StepErrors::None | StepErrors::Independent => 1.0,
            };
            let mut normal = || random.sample::<f64, _>(StandardNormal);
            let noise = [normal(), normal(), normal()];
            let held = Vector3::new(normal(), normal(), normal());
            let mut pose_wb = *start_wb;
            pose_wb.position.x += place_sd * noise[0];
            pose_wb.position.y += place_sd * noise[1];
            pose_wb.angle += angle_sd * noise[2];
            let numbers = (0..n_drawn).map(|_| of_push.sample(StandardNormal)).collect();
            let first = self.with_draw(&first, path, numbers)?;
            Ok(PushParticle { size, ..first.moved(pose_wb, held, gap.sd * normal()) })
        };
        let settings = Settings { seed: *seed, ..Settings::default() };
        let particles = (0..*n_particles).map(particle).collect::<Result<_, ModelError>>()?;
        Ok(ParticleFilter::new(particles, settings)?)
    }

    /// One step as a motion of particles.
    ///
    /// # Errors
    /// As [`PushModel::true_outline`].
    pub fn motion(&self, step: &PathStep) -> Result<PushMotion<'_>, ModelError> {
        let Self { model, pushed, settings } = *self;
        let outline = model.true_outline(pushed)?;
        Ok(PushMotion { model, pushed, outline, settings, step: *step })
    }

    fn check(&self) -> Result<(), ModelError> {
        let RollOutSettings { step, start_sd, gap, tolerance, .. } = self.settings;
        let [place_sd, angle_sd] = start_sd;
        not_negative("pusher radius", self.pushed.pusher_radius, "m")?;
        positive("longest step", *step, "m")?;
        positive("tolerance of contact", *tolerance, "m")?;
        not_negative("sd of the start's place", *place_sd, "m")?;
        not_negative("sd of the start's angle", *angle_sd, "rad")?;
        not_negative("sd of the gap", gap.sd, "m")?;
        for (name, value) in
            [("offset of the gap", gap.offset), ("kept share of the gap", gap.kept)]
        {
            finite(name, value, "m or 1")?;
        }
        Ok(())
    }

    fn check_steps(&self, steps: &[PathStep]) -> Result<(), ModelError> {
        let Some(seen) = self.model.seen() else { return Ok(()) };
        steps.iter().try_for_each(|step| seen.check_way(step.distance()))
    }

    /// The particle at the start, of which all others are copies.
    fn first(&self, start_wb: &Pose, path: &PushPath) -> Result<PushParticle, ModelError> {
        for (name, value) in [
            ("x of the start", start_wb.position.x),
            ("y of the start", start_wb.position.y),
            ("angle of the start", start_wb.angle),
        ] {
            finite(name, value, "m or rad")?;
        }
        let outline = self.model.true_outline(self.pushed)?;
        let center_b = outline.center_b(start_wb, &path.start_w());
        let gap = outline.contact(&center_b).gap;
        let RollOutSettings { touching, tolerance, .. } = self.settings;
        // Deeper than its center at least; that of a pusher without extent may be in by a measuring error.
        let deepest = if *touching { outline.pusher_radius().max(*tolerance) } else { *tolerance };
        if gap < -deepest {
            return Err(ModelError::PusherInside { depth: -gap });
        }
        Ok(PushParticle::at(*start_wb, self.held(gap)))
    }

    /// How many numbers a push draws; none without errors, where all go the mean way.
    fn n_drawn(&self) -> usize {
        match self.settings.errors {
            StepErrors::None => 0,
            StepErrors::Independent | StepErrors::Held(_) => self.model.n_drawn(),
        }
    }

    /// The particle at the start of a push that has drawn such numbers.
    fn with_draw(
        &self,
        first: &PushParticle,
        path: &PushPath,
        numbers: Vec<f64>,
    ) -> Result<PushParticle, ModelError> {
        if numbers.is_empty() {
            return Ok(first.clone());
        }
        let outline = self.model.drawn_outline(self.pushed, &numbers)?;
        let contact_gap = match &outline {
            Some(outline) => self.held(outline.gap(&first.pose_wb, &path.start_w())),
            None => first.contact_gap,
        };
        let drawn = Some(Arc::new(Drawn { numbers, outline }));
        Ok(PushParticle { drawn, contact_gap, ..first.clone() })
    }

    /// The gap that contact holds where this one is measured at the start; none if it is free.
    fn held(&self, gap: f64) -> Option<f64> {
        let RollOutSettings { touching, gap: known, .. } = self.settings;
        if *touching { Some(known.held(gap)) } else { (gap <= 0.0).then_some(gap) }
    }
}

#[cfg(test)]
mod tests;
