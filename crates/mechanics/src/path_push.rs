//! The object's motion while a pusher follows a path.

use crate::root::root_bracket;
use crate::runge_kutta::{Step, step};
use crate::{
    ContactMode, ContactPhase, MechanicsError, PathMotion, PathSample, PathSettings, Place,
    PushMotion, Pusher, PusherPath, Slider,
};
use nalgebra::{SVector, Vector2};
use planar::{Contact, Feature, Pose};

/// Gap below which pusher and object touch, in m.
const TOUCH: f64 = 1e-9;
/// Shortest travel of a pusher that is nearer than this, in m.
const CREEP: f64 = 1e-6;
/// Travel within which a change of the contact is located, in m.
const SWITCH: f64 = 1e-8;
const MAX_STEPS: usize = 100_000;

/// Pose of B (x, y, θ) and the integrals of normal force, tangential force and slip.
type State = SVector<f64, 6>;

/// Moves `slider` from `pose_wb` by a pusher that follows `path`, until the path's end.
///
/// The object rests until it is touched and after the pusher has left. In contact, its velocity is
/// that of [`crate::predict`] at the contact of the moment; the round pusher rolls over the outline
/// as the object turns, and passes vertices. Runge–Kutta of orders 5 and 4 with adaptive steps that
/// end at each change of mode, edge or vertex (to 10 nm of travel); after each step the object is
/// moved along the normal so that the gap stays closed. One contact at a time: a pusher wedged in a
/// notch ends in `NotConverged`.
///
/// # Errors
/// A pusher, path or setting out of range, errors of the surface, or `NotConverged`.
pub fn push_along(
    slider: &Slider,
    pusher: &Pusher,
    path: &dyn PusherPath,
    pose_wb: &Pose,
    settings: &PathSettings,
) -> Result<PathMotion, MechanicsError> {
    let mut run = Run::new(slider, pusher, path, pose_wb, settings)?;
    let mut n_steps = 0;
    for piece in 0..path.n_pieces() {
        let end = path.piece_end(piece);
        let longest_wait = (end - run.time) / 64.0;
        while run.time < end {
            if run.touching {
                run.press(piece, end)?;
            } else {
                run.approach(piece, end, longest_wait)?;
            }
            n_steps += 1;
            if n_steps > MAX_STEPS {
                return Err(MechanicsError::NotConverged {
                    what: "the push along a path",
                    iterations: n_steps,
                    residual: end - run.time,
                    tolerance: settings.tolerance,
                });
            }
        }
    }
    Ok(run.finish(path.n_pieces() - 1))
}

struct Run<'a> {
    slider: &'a Slider<'a>,
    pusher: &'a Pusher,
    path: &'a dyn PusherPath,
    settings: &'a PathSettings,
    time: f64,
    state: State,
    touching: bool,
    /// Step length to try next, in s.
    trial: f64,
    overlap: f64,
    phases: Vec<ContactPhase>,
    samples: Vec<PathSample>,
}

/// The contact of a moment and what it does.
struct Look {
    contact: Contact,
    motion: PushMotion,
    derivative: State,
}

impl Look {
    fn place(&self, n_edges: usize) -> Place {
        match self.contact.feature {
            Feature::Edge => Place::Edge(self.contact.edge),
            Feature::Vertex => {
                Place::Vertex((self.contact.edge + usize::from(self.contact.p > 0.5)) % n_edges)
            }
        }
    }
}

impl<'a> Run<'a> {
    fn new(
        slider: &'a Slider,
        pusher: &'a Pusher,
        path: &'a dyn PusherPath,
        pose_wb: &Pose,
        settings: &'a PathSettings,
    ) -> Result<Self, MechanicsError> {
        for (name, value, unit) in
            [("tolerance", settings.tolerance, "m"), ("max_travel", settings.max_travel, "m")]
        {
            if !(value > 0.0 && value.is_finite()) {
                return Err(MechanicsError::NotPositive { name, value, unit });
            }
        }
        let duration = path.piece_end(path.n_pieces() - 1);
        for (name, value, unit) in
            [("the pusher's radius", pusher.radius, "m"), ("the path's duration", duration, "s")]
        {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(MechanicsError::Negative { name, value, unit });
            }
        }
        let (x, y, angle) = (pose_wb.position.x, pose_wb.position.y, pose_wb.angle);
        for (name, value, unit) in
            [("the start's x", x, "m"), ("its y", y, "m"), ("its angle", angle, "rad")]
        {
            if !value.is_finite() {
                return Err(MechanicsError::NotFinite { name, value, unit });
            }
        }
        let state = State::from([x, y, angle, 0.0, 0.0, 0.0]);
        let samples = vec![PathSample { time: 0.0, pose_wb: *pose_wb, touching: false }];
        let (time, trial, overlap, phases) = (0.0, duration, 0.0, Vec::new());
        Ok(Self {
            slider,
            pusher,
            path,
            settings,
            time,
            state,
            touching: false,
            trial,
            overlap,
            phases,
            samples,
        })
    }

    /// Free motion up to the touch, or for a while.
    fn approach(&mut self, piece: usize, end: f64, longest: f64) -> Result<(), MechanicsError> {
        let pose = pose_of(&self.state);
        let gap_and_speed = |time: f64| {
            let contact = self.contact(piece, time, &self.state);
            let normal = pose.rotate(&contact.normal);
            (contact.gap, normal.dot(&self.path.velocity(piece, time)))
        };
        let (gap, approach) = gap_and_speed(self.time);
        if gap <= TOUCH && approach > 0.0 {
            self.touching = true;
            if self.phases.is_empty() {
                self.overlap = (-gap).max(0.0);
            }
            self.state = self.closed(piece, self.time, self.state);
            return Ok(());
        }
        let speed = self.path.velocity(piece, self.time).norm();
        let reach = if speed > 0.0 { gap.max(CREEP) / speed } else { longest };
        let next = (self.time + reach.min(longest)).min(end);
        let (next_gap, next_approach) = gap_and_speed(next);
        let tolerance = SWITCH * reach / CREEP.max(gap);
        let touch = if gap > TOUCH && next_gap < 0.0 {
            let (low, high) = ((self.time, -gap), (next, -next_gap));
            Some(root_bracket("the time of touch", low, high, tolerance, |t| {
                Ok(-gap_and_speed(t).0)
            })?)
        } else if gap <= TOUCH && next_approach > 0.0 && next_gap <= TOUCH {
            let (low, high) =
                ((self.time, approach.min(-f64::MIN_POSITIVE)), (next, next_approach));
            Some(root_bracket("the start of the push", low, high, tolerance, |t| {
                Ok(gap_and_speed(t).1)
            })?)
        } else {
            None
        };
        self.time = touch.map_or(next, |(_, high)| high.0);
        if self.time >= end {
            self.record();
        }
        Ok(())
    }

    /// One accepted step in contact, up to the next change of mode or place at most.
    fn press(&mut self, piece: usize, end: f64) -> Result<(), MechanicsError> {
        let here = self.look(piece, self.time, &self.state)?;
        if here.motion.mode == ContactMode::Separated {
            self.touching = false;
            return Ok(());
        }
        let kind = self.kind(&here);
        let speed = self.path.velocity(piece, self.time).norm();
        let remaining = end - self.time;
        let mut h = self.trial.min(remaining).min(self.settings.max_travel / speed);
        let mut rejected = false;
        let (h, after, growth) = loop {
            let (mut taken, mut step) = (h, self.step(piece, h, &here)?);
            if !self.keeps(piece, h, &step, kind)? {
                let mut low = 0.0;
                while taken - low > SWITCH / speed {
                    let middle = 0.5 * (low + taken);
                    let candidate = self.step(piece, middle, &here)?;
                    if self.keeps(piece, middle, &candidate, kind)? {
                        low = middle;
                    } else {
                        (taken, step) = (middle, candidate);
                    }
                }
            }
            let error = self.error_of(&step) / self.settings.tolerance;
            let growth = (0.9 * error.powf(-0.2)).clamp(0.2, 5.0);
            if error <= 1.0 {
                break (taken, step.end, growth);
            }
            h = taken * growth;
            rejected = true;
            if h < 1e-15 * end {
                let (what, tolerance) = ("a step along the path", self.settings.tolerance);
                let residual = error * tolerance;
                return Err(MechanicsError::NotConverged {
                    what,
                    iterations: 0,
                    residual,
                    tolerance,
                });
            }
        };
        let next = if h >= remaining { end } else { self.time + h };
        self.log(kind, next);
        self.time = next;
        self.trial = if rejected { h * growth } else { self.trial.max(h * growth) };
        self.state = self.closed(piece, self.time, after);
        self.record();
        Ok(())
    }

    fn contact(&self, piece: usize, time: f64, state: &State) -> Contact {
        self.slider.contact(self.pusher, &pose_of(state), &self.path.position(piece, time))
    }

    fn look(&self, piece: usize, time: f64, state: &State) -> Result<Look, MechanicsError> {
        let pose = pose_of(state);
        let contact = self.contact(piece, time, state);
        let velocity = self.path.velocity(piece, time);
        let push = self.slider.push_at(self.pusher, &pose, &contact, &velocity);
        let (motion, twist) = self.slider.velocity(&push, &pose)?;
        let derivative = State::from([
            twist.linear.x,
            twist.linear.y,
            twist.angular,
            push.normal_s.dot(&motion.force_s),
            push.tangent_s().dot(&motion.force_s),
            if motion.mode == ContactMode::Separated { 0.0 } else { motion.slip },
        ]);
        Ok(Look { contact, motion, derivative })
    }

    fn kind(&self, look: &Look) -> (ContactMode, Place) {
        (look.motion.mode, look.place(self.slider.shape.n_edges()))
    }

    fn step(&self, piece: usize, h: f64, here: &Look) -> Result<Step<6>, MechanicsError> {
        step(self.time, &self.state, &here.derivative, h, |time, state| {
            Ok(self.look(piece, time, state)?.derivative)
        })
    }

    /// Whether the contact is of the same kind after a step.
    fn keeps(
        &self,
        piece: usize,
        h: f64,
        step: &Step<6>,
        kind: (ContactMode, Place),
    ) -> Result<bool, MechanicsError> {
        Ok(self.kind(&self.look(piece, self.time + h, &step.end)?) == kind)
    }

    fn error_of(&self, step: &Step<6>) -> f64 {
        let c = self.slider.surface.characteristic_length();
        Vector2::new(step.error[0], step.error[1]).norm().hypot(c * step.error[2])
    }

    /// The state with the object moved along the normal until the gap is closed.
    fn closed(&self, piece: usize, time: f64, mut state: State) -> State {
        let contact = self.contact(piece, time, &state);
        let shift = -contact.gap * pose_of(&state).rotate(&contact.normal);
        state[0] += shift.x;
        state[1] += shift.y;
        state
    }

    /// Adds a step to the contact's history.
    fn log(&mut self, (mode, place): (ContactMode, Place), end: f64) {
        let start = self.time;
        match self.phases.last_mut() {
            Some(last) if (last.mode, last.place, last.end) == (mode, place, start) => {
                last.end = end
            }
            _ => self.phases.push(ContactPhase { mode, place, start, end }),
        }
    }

    fn record(&mut self) {
        let (time, pose_wb, touching) = (self.time, pose_of(&self.state), self.touching);
        self.samples.push(PathSample { time, pose_wb, touching });
    }

    fn finish(self, last_piece: usize) -> PathMotion {
        let contact = self.contact(last_piece, self.time, &self.state);
        let contact_time = self.phases.iter().map(|phase| phase.end - phase.start).sum();
        let mean = |integral: f64| if contact_time > 0.0 { integral / contact_time } else { 0.0 };
        PathMotion {
            pose_wb: pose_of(&self.state),
            contact,
            contact_time,
            mean_normal_force: mean(self.state[3]),
            mean_tangential_force: mean(self.state[4]),
            slip: self.state[5],
            overlap: self.overlap,
            phases: self.phases,
            samples: self.samples,
        }
    }
}

fn pose_of(state: &State) -> Pose {
    Pose::new(state[0], state[1], state[2])
}
