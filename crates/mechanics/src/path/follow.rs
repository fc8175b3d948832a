//! The object's motion while a pusher follows a path.

use crate::numerics::root::root_bracket;
use crate::numerics::runge_kutta::{Step, step};
use crate::path::travel::{mean_speed, within_travel};
use crate::{
    ContactMode, ContactPhase, MechanicsError, PathMotion, PathSample, PathSettings, Place, Push,
    Pusher, PusherPath, Slider, predict_multi_contact,
};
use nalgebra::{Matrix2, SVector, Vector2};
use planar::{Contact, Feature, Pose, Wrench};

/// Gap below which pusher and object touch, in m.
const TOUCH: f64 = 1e-9;
/// Shortest travel of a pusher that is nearer than this, in m.
const CREEP: f64 = 1e-6;
/// Travel within which a change of the contact is located, in m.
const SWITCH: f64 = 1e-8;
/// Another wall that is this much further away than the nearest is touched too, in m.
const NEAR: f64 = 3e-8;
const MAX_STEPS: usize = 100_000;

/// Pose of B (x, y, θ) and the integrals of normal force, tangential force and slip.
type State = SVector<f64, 6>;

/// Moves `slider` from `pose_wb` by a pusher that follows `path`, until the path's end.
///
/// The object rests until it is touched and after the pusher has left. In contact, its velocity is
/// that of [`crate::predict`] at the contact of the moment, or of [`predict_multi_contact`] at several; the
/// round pusher rolls over the outline as the object turns, passes vertices and wedges in notches.
/// Runge–Kutta of orders 5 and 4 with adaptive steps that end at each change of mode, edge or vertex
/// (to 10 nm of travel); after each step the object is moved so that the gaps stay closed. A pusher
/// of radius 0 has no two walls to touch and ends in `NotConverged` at the bottom of a notch.
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
    push_along_with_external_wrench(slider, pusher, path, pose_wb, settings, &|_, _| {
        Wrench::default()
    })
}

/// [`push_along`] under an external load besides the pusher's, such as gravity on a tilted table.
///
/// - `external_s`: the load on the slider, in N and N·m, frame S, at a time in s and a pose of B.
///
/// # Errors
/// As [`push_along`], and `SlidesByItself` if the limit surface cannot bear the load at some time
/// that is looked at.
pub fn push_along_with_external_wrench(
    slider: &Slider,
    pusher: &Pusher,
    path: &dyn PusherPath,
    pose_wb: &Pose,
    settings: &PathSettings,
    external_s: &dyn Fn(f64, &Pose) -> Wrench,
) -> Result<PathMotion, MechanicsError> {
    let mut run = Run::new(slider, pusher, path, pose_wb, settings, external_s)?;
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
    external_s: &'a dyn Fn(f64, &Pose) -> Wrench,
    time: f64,
    state: State,
    touching: bool,
    /// Step length to try next, in s.
    trial: f64,
    contact_time: f64,
    overlap: f64,
    phases: Vec<ContactPhase>,
    samples: Vec<PathSample>,
}

/// The contacts of a moment and what they do.
struct Look {
    kind: Kind,
    derivative: State,
}

/// Mode and place of each contact, sorted; [`ContactMode::Separated`] where it does not press.
type Kind = Vec<(ContactMode, Place)>;

fn place_of(contact: &Contact, n_edges: usize) -> Place {
    match contact.feature {
        Feature::Edge => Place::Edge(contact.edge),
        Feature::Vertex => Place::Vertex((contact.edge + usize::from(contact.p > 0.5)) % n_edges),
    }
}

impl<'a> Run<'a> {
    fn new(
        slider: &'a Slider,
        pusher: &'a Pusher,
        path: &'a dyn PusherPath,
        pose_wb: &Pose,
        settings: &'a PathSettings,
        external_s: &'a dyn Fn(f64, &Pose) -> Wrench,
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
            external_s,
            time,
            state,
            touching: false,
            trial,
            contact_time: 0.0,
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
        let left = end - self.time;
        let wait = within_travel(self.path, piece, self.time, longest.min(left), gap.max(CREEP));
        let next = if wait < left { self.time + wait } else { end };
        let (next_gap, next_approach) = gap_and_speed(next);
        let tolerance = SWITCH / mean_speed(self.path, piece, self.time, wait);
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
        if here.kind.iter().all(|(mode, _)| *mode == ContactMode::Separated) {
            self.touching = false;
            return Ok(());
        }
        let remaining = end - self.time;
        let longest = self.trial.min(remaining);
        let travel = self.settings.max_travel;
        let mut h = within_travel(self.path, piece, self.time, longest, travel);
        let mut rejected = false;
        let (h, after, growth) = loop {
            let (mut taken, mut step) = (h, self.step(piece, h, &here)?);
            if !self.keeps(piece, h, &step, &here.kind)? {
                let mut low = 0.0;
                let tolerance = SWITCH / mean_speed(self.path, piece, self.time, h);
                while taken - low > tolerance {
                    let middle = 0.5 * (low + taken);
                    let candidate = self.step(piece, middle, &here)?;
                    if self.keeps(piece, middle, &candidate, &here.kind)? {
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
        self.log(&here.kind, next);
        self.contact_time += next - self.time;
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
        let contacts = self.contacts(piece, time, state);
        let velocity = self.path.velocity(piece, time);
        let push_at = |contact| self.slider.push_at(self.pusher, &pose, contact, &velocity);
        let pushes: Vec<Push> = contacts.iter().map(push_at).collect();
        let external = (self.external_s)(time, &pose);
        let motions = predict_multi_contact(self.slider.surface, &pushes, &external)?;
        let twist = self.slider.velocity_of(&motions[0].twist_ws_s, &pose);
        let mut derivative =
            State::from([twist.linear.x, twist.linear.y, twist.angular, 0.0, 0.0, 0.0]);
        let mut hardest = 0.0;
        for (push, motion) in pushes.iter().zip(&motions) {
            let normal_force = push.normal_s.dot(&motion.force_s);
            derivative[3] += normal_force;
            derivative[4] += push.tangent_s().dot(&motion.force_s);
            if normal_force > hardest {
                (hardest, derivative[5]) = (normal_force, motion.slip);
            }
        }
        let n_edges = self.slider.shape.n_edges();
        let mut kind: Kind = motions
            .iter()
            .zip(&contacts)
            .map(|(motion, contact)| (motion.mode, place_of(contact, n_edges)))
            .collect();
        kind.sort_unstable_by_key(|(_, place)| *place);
        Ok(Look { kind, derivative })
    }

    /// All places that the pusher touches, the nearest first.
    fn contacts(&self, piece: usize, time: f64, state: &State) -> Vec<Contact> {
        let center = self.path.position(piece, time);
        let center_b = pose_of(state).inverse_transform_point(&center);
        self.slider.shape.contacts(&center_b, self.pusher.radius, NEAR)
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
        kind: &Kind,
    ) -> Result<bool, MechanicsError> {
        Ok(self.look(piece, self.time + h, &step.end)?.kind == *kind)
    }

    fn error_of(&self, step: &Step<6>) -> f64 {
        let c = self.slider.surface.characteristic_length();
        Vector2::new(step.error[0], step.error[1]).norm().hypot(c * step.error[2])
    }

    /// The state with the object moved until the gaps are closed, along the normals.
    fn closed(&self, piece: usize, time: f64, mut state: State) -> State {
        let pose = pose_of(&state);
        let contacts = self.contacts(piece, time, &state);
        let shift_b = match contacts[..] {
            [first, second, ..] => {
                let normals =
                    Matrix2::from_rows(&[first.normal.transpose(), second.normal.transpose()]);
                let gaps = Vector2::new(first.gap, second.gap);
                let both = normals.try_inverse().map(|inverse| -inverse * gaps);
                // Walls that are nearly parallel would move the object far along them.
                both.filter(|shift| shift.norm() <= 10.0 * gaps.norm())
            }
            _ => None,
        };
        let nearest = &contacts[0];
        let shift = pose.rotate(&shift_b.unwrap_or(-nearest.gap * nearest.normal));
        state[0] += shift.x;
        state[1] += shift.y;
        state
    }

    /// Adds a step to the history of the contacts that press.
    fn log(&mut self, kind: &Kind, end: f64) {
        let start = self.time;
        for &(mode, place) in kind.iter().filter(|(mode, _)| *mode != ContactMode::Separated) {
            let mut latest = self.phases.iter_mut().rev().take(2 * kind.len());
            let same = |phase: &&mut ContactPhase| {
                (phase.mode, phase.place, phase.end) == (mode, place, start)
            };
            match latest.find(same) {
                Some(phase) => phase.end = end,
                None => self.phases.push(ContactPhase { mode, place, start, end }),
            }
        }
    }

    fn record(&mut self) {
        let (time, pose_wb, touching) = (self.time, pose_of(&self.state), self.touching);
        self.samples.push(PathSample { time, pose_wb, touching });
    }

    fn finish(self, last_piece: usize) -> PathMotion {
        let contact = self.contact(last_piece, self.time, &self.state);
        let contact_time = self.contact_time;
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
