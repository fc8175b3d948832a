//! One step of a path as a motion of particles.

use effects::{Track, TrueOutline};
use filter::{DrawnMotion, MotionModel};
use nalgebra::{Matrix3, Rotation2, Vector2, Vector3};
use planar::{Contact, Feature, Pose, Twist, perpendicular};
use rand::{Rng, RngExt};
use rand_distr::StandardNormal;

use super::settle::{Holding, moved_by};
use super::touch::first_touch;
use super::{PushEvents, PushParticle, RollOutSettings, StepErrors};
use crate::error::positive;
use crate::steps::prediction::root;
use crate::{
    ModelError, Noise, PathStep, PushModel, Pushed, SlipMixture, SlipPrediction, StepInput,
    StepPrediction,
};

/// One step of a path as a motion of particles: see [`super::RollOut`].
#[derive(Clone, Debug)]
pub struct PushMotion<'a> {
    pub(super) model: &'a dyn PushModel,
    pub(super) pushed: &'a Pushed,
    /// Of the model.
    pub(super) outline: TrueOutline,
    pub(super) settings: &'a RollOutSettings,
    pub(super) step: PathStep,
}

/// Particles of which a model is asked at once: many for its matrix products, and few enough for what is
/// known of each to stay near the processor.
const TOGETHER: usize = 480;
/// Shorter pushes move nothing, in m.
const NO_WAY: f64 = 1e-9;

/// The part of a step over which a particle is pushed.
pub(super) struct Begun {
    /// Free way before, in m.
    free: f64,
    /// The gap that contact holds, in m.
    pub(super) gap: f64,
    /// The nearest point of the outline when the push begins.
    contact: Contact,
    /// Where the pusher's center is then, in m, frame B.
    start_b: Vector2<f64>,
    /// The pusher's motion, a unit vector in B.
    direction_b: Vector2<f64>,
}

/// The particles of a block that are pushed, and what the model is asked of them.
struct Asked {
    who: Vec<usize>,
    inputs: Vec<StepInput>,
    begun: Vec<Begun>,
}

impl MotionModel for PushMotion<'_> {
    type State = PushParticle;
    type Error = ModelError;

    fn advance(&self, states: &mut [PushParticle], random: &mut dyn Rng) -> Result<(), ModelError> {
        self.advance_each(states, random, |_, _| {})
    }
}

/// What a particle has drawn in a step.
pub(super) struct Draw {
    /// Before contact is made to hold.
    log_density: f64,
    /// How it went in the end less the model's mean: along the pusher's motion, its left normal, the turn.
    off: Vector3<f64>,
    /// Of the model's covariance.
    root: Matrix3<f64>,
}

impl Draw {
    /// A step's error in units of the model's root; 0 of a model without variance, which draws nothing.
    pub(super) fn whitened(&self) -> Vector3<f64> {
        self.root.solve_lower_triangular(&self.off).unwrap_or_default()
    }
}

impl DrawnMotion for PushMotion<'_> {
    /// The density of the draw from the model's Gaussian, before contact is made to hold; 0 where the
    /// object is still, and without variance.
    fn advance_with_density(
        &self,
        states: &mut [PushParticle],
        log_densities: &mut [f64],
        random: &mut dyn Rng,
    ) -> Result<(), ModelError> {
        log_densities.fill(0.0);
        self.advance_each(states, random, |index, draw| log_densities[index] = draw.log_density)
    }
}

impl PushMotion<'_> {
    /// - `drawn`: is told the place of each particle that was pushed, and its draw.
    pub(super) fn advance_each(
        &self,
        states: &mut [PushParticle],
        random: &mut dyn Rng,
        mut drawn: impl FnMut(usize, Draw),
    ) -> Result<(), ModelError> {
        let room = TOGETHER.min(states.len());
        let mut asked = Asked {
            who: Vec::with_capacity(room),
            inputs: Vec::with_capacity(room),
            begun: Vec::with_capacity(room),
        };
        for (block, states) in states.chunks_mut(TOGETHER).enumerate() {
            let first = block * TOGETHER;
            let drawn = |index, draw| drawn(first + index, draw);
            self.advance_block(states, random, &mut asked, drawn)?;
        }
        Ok(())
    }

    fn advance_block(
        &self,
        states: &mut [PushParticle],
        random: &mut dyn Rng,
        Asked { who, inputs, begun }: &mut Asked,
        mut drawn: impl FnMut(usize, Draw),
    ) -> Result<(), ModelError> {
        who.clear();
        inputs.clear();
        begun.clear();
        let direction_w = self.direction_w();
        for (index, state) in states.iter().enumerate() {
            if let Some(direction_w) = &direction_w
                && let Some(begin) = self.begins(state, direction_w)
                && let Some(input) = self.input(state, &begin, direction_w)?
            {
                who.push(index);
                inputs.push(input);
                begun.push(begin);
            }
        }
        let predictions = match self.model.as_mixture() {
            Some(mixture) => self.drawn_ways(mixture, inputs, random)?,
            None => self.said(who.iter().map(|index| &states[*index]), inputs)?,
        };
        let seen = self.model.has_seen(inputs)?;
        let mut pushes = who.iter().zip(begun.iter()).zip(predictions).zip(seen).peekable();
        for (index, state) in states.iter_mut().enumerate() {
            // Each particle has its three numbers, whether it is pushed or not.
            let normal = Vector3::from_fn(|_, _| random.sample(StandardNormal));
            match pushes.next_if(|(((pushed, _), _), _)| **pushed == index) {
                Some((((_, begin), said), is_seen)) => {
                    if let Some(draw) = self.push(state, begin, &said, normal) {
                        drawn(index, draw);
                    }
                    state.events.unseen = usize::from(!is_seen);
                }
                None => self.pass(state),
            }
            if let StepErrors::Held(correlation) = &self.settings.errors {
                let kept = correlation.kept(self.step.distance());
                let anew = Vector3::from_fn(|_, _| random.sample::<f64, _>(StandardNormal));
                state.held = kept * state.held + (1.0 - kept * kept).sqrt() * anew;
            }
        }
        Ok(())
    }

    /// What the model says of the pushes of particles that have drawn their numbers, or of all pushes.
    pub(super) fn said<'s>(
        &self,
        states: impl Iterator<Item = &'s PushParticle> + Clone,
        inputs: &[StepInput],
    ) -> Result<Vec<StepPrediction>, ModelError> {
        if states.clone().all(|state| state.drawn.is_none()) {
            return self.model.predict(inputs, self.noise());
        }
        let draws: Vec<&[f64]> = states.map(PushParticle::drawn).collect();
        self.model.predict_drawn(inputs, &draws, self.noise())
    }

    /// Outline and pusher of a particle's push.
    pub(super) fn outline_of<'s>(&'s self, state: &'s PushParticle) -> &'s TrueOutline {
        let own = state.drawn.as_ref().and_then(|drawn| drawn.outline.as_ref());
        own.unwrap_or(&self.outline)
    }

    pub(super) fn noise(&self) -> Noise {
        match self.settings.errors {
            StepErrors::None => Noise::Excluded,
            StepErrors::Independent | StepErrors::Held(_) => Noise::Included,
        }
    }

    /// Of several ways that each step may go, one by its probability; without errors the likeliest.
    fn drawn_ways(
        &self,
        mixture: &SlipMixture,
        inputs: &[StepInput],
        random: &mut dyn Rng,
    ) -> Result<Vec<StepPrediction>, ModelError> {
        let all = mixture.ways(inputs, self.noise())?;
        let one = |said: SlipPrediction| match self.settings.errors {
            StepErrors::None => said.likeliest(),
            StepErrors::Independent | StepErrors::Held(_) => said.drawn(random.random()),
        };
        Ok(all.into_iter().map(one).collect())
    }

    /// Whether and where the push begins.
    pub(super) fn begins(&self, state: &PushParticle, direction_w: &Vector2<f64>) -> Option<Begun> {
        let turn = Rotation2::new(state.pose_wb.angle);
        let outline = self.outline_of(state);
        let direction_b = turn.inverse_transform_vector(direction_w);
        let start_b = outline.center_b(&state.pose_wb, &self.step.start_w);
        if let Some(gap) = state.contact_gap {
            let contact = outline.contact(&start_b);
            if contact.normal.dot(&direction_b) > 0.0 {
                return Some(Begun { free: 0.0, gap, contact, start_b, direction_b });
            }
        }
        let free = first_touch(outline, start_b, direction_b, self.step.distance())?;
        let start_b = start_b + free * direction_b;
        let contact = outline.contact(&start_b);
        Some(Begun { free, gap: state.gap_error, contact, start_b, direction_b })
    }

    pub(super) fn direction_w(&self) -> Option<Vector2<f64>> {
        (self.step.end_w - self.step.start_w).try_normalize(NO_WAY)
    }

    /// What the model is asked; nothing of a way that is none.
    pub(super) fn input(
        &self,
        state: &PushParticle,
        begin: &Begun,
        direction_w: &Vector2<f64>,
    ) -> Result<Option<StepInput>, ModelError> {
        let distance = self.step.distance();
        if distance - begin.free < NO_WAY {
            return Ok(None);
        }
        let duration = self.step.duration * (1.0 - begin.free / distance);
        let Pushed { shape, pusher_radius, object } = self.pushed;
        let Begun { free, contact, start_b, direction_b, .. } = begin;
        let Some(object) = object else {
            let way =
                (*direction_b, distance - free, positive("the step's duration", duration, "s")?);
            // A gap while they touch is an error of measurement: the model is asked without it.
            let touching_b = start_b + contact.gap * contact.normal;
            let shape = shape.clone();
            let input = StepInput::at_contact(shape, *pusher_radius, contact, touching_b, way);
            return Ok(Some(input));
        };
        let touch_w = self.step.start_w + *free * direction_w;
        let is_new = begin.free > 0.0;
        let whole = effects::StepInput {
            object: object.clone(),
            pusher_radius: *pusher_radius,
            pose_wb: state.pose_wb,
            twist_wb: if is_new { Twist::default() } else { state.twist_wb },
            track: Track::straight(touch_w, self.step.end_w, duration),
            touching: true,
            since_contact: if is_new { 0.0 } else { state.since_contact },
            run_up: None,
            progress: 0.5,
            session: 0,
        };
        StepInput::of(whole, shape.clone()).map(Some)
    }

    /// Moves a particle by a draw, which it returns.
    fn push(
        &self,
        state: &mut PushParticle,
        begin: &Begun,
        said: &StepPrediction,
        normal: Vector3<f64>,
    ) -> Option<Draw> {
        let along_w = self.direction_w()?;
        let root: Matrix3<f64> = root(&said.covariance);
        let (error, log_density) = self.error(state, &root, normal);
        let drawn_wb = moved_by(&state.pose_wb, &along_w, (said.mean + error).into());
        let held = Holding {
            outline: self.outline_of(state),
            center_w: self.step.end_w,
            along_w,
            gap: begin.gap,
            tolerance: self.settings.tolerance,
        };
        let covariance = match self.settings.errors {
            StepErrors::Independent | StepErrors::Held(_) => said.covariance,
            StepErrors::None => Matrix3::zeros(),
        };
        let settled = held.settled(&drawn_wb, &covariance);
        let (is_lost, end_wb) = (settled.is_none(), settled.unwrap_or(drawn_wb));
        let was_free = !state.touches() || begin.free > 0.0;
        let pushed_for = self.step.duration * (1.0 - begin.free / self.step.distance());
        state.since_contact = if was_free { 0.0 } else { state.since_contact } + pushed_for;
        let went = end_wb.position - state.pose_wb.position;
        let went = Vector3::new(
            went.dot(&along_w),
            went.dot(&perpendicular(&along_w)),
            end_wb.angle - state.pose_wb.angle,
        );
        self.arrive(state, end_wb);
        state.contact_gap = (!is_lost).then_some(begin.gap);
        state.events = PushEvents {
            pushed: 1,
            touched: usize::from(was_free),
            at_vertex: usize::from(begin.contact.feature == Feature::Vertex),
            lost: usize::from(is_lost),
            unseen: 0,
        };
        Some(Draw { log_density, off: went - said.mean, root })
    }

    /// The error of a draw, along the pusher's motion, its left normal, and of the turn.
    fn error(
        &self,
        state: &PushParticle,
        root: &Matrix3<f64>,
        normal: Vector3<f64>,
    ) -> (Vector3<f64>, f64) {
        let (drawn, log_density) = match &self.settings.errors {
            StepErrors::None => (Vector3::zeros(), 0.0),
            StepErrors::Independent => (normal, log_density(root, &normal)),
            StepErrors::Held(correlation) => {
                let drawn = state.size * correlation.drawn(&state.held, &normal);
                (drawn, log_density(root, &drawn))
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
