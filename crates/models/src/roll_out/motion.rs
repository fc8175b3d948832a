//! One step of a path as a motion of particles.

use effects::Track;
use filter::{DrawnMotion, MotionModel};
use nalgebra::{Matrix3, Vector2, Vector3};
use planar::{Feature, Pose, Twist};
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

use super::settle::moved_by;
use super::touch::first_touch;
use super::{PushEvents, PushParticle, Pushed, RollOutSettings, StepErrors};
use crate::step_correlation::root;
use crate::{ModelError, Noise, PathStep, PushModel, StepInput, StepPrediction};

/// One step of a path as a motion of particles: see [`super::RollOut`].
#[derive(Clone, Copy, Debug)]
pub struct PushMotion<'a> {
    pub(super) model: &'a dyn PushModel,
    pub(super) pushed: &'a Pushed,
    pub(super) settings: &'a RollOutSettings,
    pub(super) step: PathStep,
}

/// Shorter pushes move nothing, in m.
const NO_WAY: f64 = 1e-9;

/// The part of a step over which a particle is pushed.
struct Begun {
    /// Free way before, in m.
    free: f64,
    /// The gap that contact holds, in m.
    gap: f64,
    at_vertex: bool,
}

impl MotionModel for PushMotion<'_> {
    type State = PushParticle;
    type Error = ModelError;

    fn advance(
        &self,
        states: &mut [PushParticle],
        random: &mut ChaCha8Rng,
    ) -> Result<(), ModelError> {
        self.advance_each(states, random, |_, _| {})
    }
}

impl DrawnMotion for PushMotion<'_> {
    /// The density of the draw from the model's Gaussian, before contact is made to hold; 0 where the
    /// object is still, and without variance.
    fn advance_with_density(
        &self,
        states: &mut [PushParticle],
        log_densities: &mut [f64],
        random: &mut ChaCha8Rng,
    ) -> Result<(), ModelError> {
        log_densities.fill(0.0);
        self.advance_each(states, random, |index, density| log_densities[index] = density)
    }
}

impl PushMotion<'_> {
    fn advance_each(
        &self,
        states: &mut [PushParticle],
        random: &mut ChaCha8Rng,
        mut density: impl FnMut(usize, f64),
    ) -> Result<(), ModelError> {
        let (mut who, mut inputs, mut begun) = (Vec::new(), Vec::new(), Vec::new());
        for (index, state) in states.iter().enumerate() {
            if let Some(begin) = self.begins(state)
                && let Some(input) = self.input(state, &begin)?
            {
                who.push(index);
                inputs.push(input);
                begun.push(begin);
            }
        }
        let noise = match self.settings.errors {
            StepErrors::None => Noise::Excluded,
            StepErrors::Independent | StepErrors::Held(_) => Noise::Included,
        };
        let predictions = self.model.predict(&inputs, noise)?;
        let seen = self.model.has_seen(&inputs)?;
        let mut pushes = who.iter().zip(&begun).zip(predictions).zip(seen).peekable();
        for (index, state) in states.iter_mut().enumerate() {
            // Each particle has its three numbers, whether it is pushed or not.
            let normal = Vector3::from_fn(|_, _| random.sample(StandardNormal));
            match pushes.next_if(|(((pushed, _), _), _)| **pushed == index) {
                Some((((_, begin), said), is_seen)) => {
                    density(index, self.push(state, begin, &said, normal));
                    state.events.unseen = usize::from(!is_seen);
                }
                None => self.pass(state),
            }
        }
        Ok(())
    }

    /// Whether and where the push begins.
    fn begins(&self, state: &PushParticle) -> Option<Begun> {
        let Pushed { shape, pusher_radius, .. } = self.pushed;
        let PathStep { start_w, .. } = &self.step;
        let (distance, direction_w) = (self.step.distance(), self.direction_w()?);
        let contact_at = |way: f64| {
            let center_w = start_w + way * direction_w;
            shape.contact(&state.pose_wb.inverse_transform_point(&center_w), *pusher_radius)
        };
        let is_vertex = |way: f64| contact_at(way).feature == Feature::Vertex;
        if let Some(gap) = state.contact_gap {
            let into = state.pose_wb.rotate(&contact_at(0.0).normal).dot(&direction_w);
            if into > 0.0 {
                return Some(Begun { free: 0.0, gap, at_vertex: is_vertex(0.0) });
            }
        }
        let body = (&**shape, *pusher_radius);
        let free = first_touch(body, &state.pose_wb, start_w, &direction_w, distance)?;
        Some(Begun { free, gap: state.gap_error, at_vertex: is_vertex(free) })
    }

    fn direction_w(&self) -> Option<Vector2<f64>> {
        (self.step.end_w - self.step.start_w).try_normalize(NO_WAY)
    }

    /// What the model is asked; nothing of a way that is none.
    fn input(&self, state: &PushParticle, begin: &Begun) -> Result<Option<StepInput>, ModelError> {
        let PathStep { start_w, end_w, .. } = &self.step;
        let (distance, Some(direction_w)) = (self.step.distance(), self.direction_w()) else {
            return Ok(None);
        };
        if distance - begin.free < NO_WAY {
            return Ok(None);
        }
        let touch_w = start_w + begin.free * direction_w;
        let duration = self.step.duration * (1.0 - begin.free / distance);
        let Pushed { shape, pusher_radius, object } = self.pushed;
        let Some(object) = object else {
            let bare =
                StepInput::between(shape.clone(), *pusher_radius, &state.pose_wb, &touch_w, end_w)?;
            return bare.lasting(duration).map(Some);
        };
        let is_new = begin.free > 0.0;
        let whole = effects::StepInput {
            object: object.clone(),
            pusher_radius: *pusher_radius,
            pose_wb: state.pose_wb,
            twist_wb: if is_new { Twist::default() } else { state.twist_wb },
            track: Track::straight(touch_w, *end_w, duration),
            touching: true,
            since_contact: if is_new { 0.0 } else { state.since_contact },
            progress: 0.5,
            session: 0,
        };
        StepInput::of(whole, shape.clone()).map(Some)
    }

    /// Moves a particle by a draw; returns the draw's log density.
    fn push(
        &self,
        state: &mut PushParticle,
        begin: &Begun,
        said: &StepPrediction,
        normal: Vector3<f64>,
    ) -> f64 {
        let Some(along_w) = self.direction_w() else { return 0.0 };
        let (error, log_density) = self.error(state, said, normal);
        let drawn_wb = moved_by(&state.pose_wb, &along_w, (said.mean + error).into());
        let RollOutSettings { tolerance, errors, .. } = self.settings;
        let center_w = &self.step.end_w;
        let is_lost = self.pushed.gap(&drawn_wb, center_w) - begin.gap > *tolerance;
        let end_wb = match errors {
            StepErrors::Independent | StepErrors::Held(_) if !is_lost => {
                let covariance = &said.covariance;
                self.pushed.settled(&drawn_wb, center_w, &along_w, covariance, begin.gap)
            }
            _ => drawn_wb,
        };
        let was_free = !state.touches() || begin.free > 0.0;
        let pushed_for = self.step.duration * (1.0 - begin.free / self.step.distance());
        state.since_contact = if was_free { 0.0 } else { state.since_contact } + pushed_for;
        self.arrive(state, end_wb);
        state.contact_gap = (!is_lost).then_some(begin.gap);
        state.events = PushEvents {
            pushed: 1,
            touched: usize::from(was_free),
            at_vertex: usize::from(begin.at_vertex),
            lost: usize::from(is_lost),
            unseen: 0,
        };
        log_density
    }

    /// The error of a draw, along the pusher's motion, its left normal, and of the turn.
    fn error(
        &self,
        state: &PushParticle,
        said: &StepPrediction,
        normal: Vector3<f64>,
    ) -> (Vector3<f64>, f64) {
        let root: Matrix3<f64> = root(&said.covariance);
        let (drawn, log_density) = match &self.settings.errors {
            StepErrors::None => (Vector3::zeros(), 0.0),
            StepErrors::Independent => (normal, log_density(&root, &normal)),
            StepErrors::Held(correlation) => {
                let drawn = correlation.drawn(&state.held, &normal);
                (drawn, log_density(&root, &drawn))
            }
        };
        (root * drawn, log_density)
    }

    /// The object stands still while the pusher passes.
    fn pass(&self, state: &mut PushParticle) {
        let was_touching = state.touches();
        state.twist_wb = Twist::default();
        state.since_contact = 0.0;
        state.contact_gap = None;
        state.events = PushEvents { lost: usize::from(was_touching), ..PushEvents::default() };
    }

    fn arrive(&self, state: &mut PushParticle, end_wb: Pose) {
        let duration = self.step.duration;
        state.twist_wb = Twist {
            linear: (end_wb.position - state.pose_wb.position) / duration,
            angular: (end_wb.angle - state.pose_wb.angle) / duration,
        };
        state.pose_wb = end_wb;
    }
}

/// Log density of root · normal; 0 for a covariance that has none.
fn log_density(root: &Matrix3<f64>, normal: &Vector3<f64>) -> f64 {
    let size: f64 = root.diagonal().iter().product();
    if size > 0.0 {
        -0.5 * normal.norm_squared() - size.ln() - 1.5 * std::f64::consts::TAU.ln()
    } else {
        0.0
    }
}
