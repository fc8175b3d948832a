//! One step, integrated along the pusher's way.

use mechanics::ContactMode;
use nalgebra::Vector2;
use planar::{Contact, Feature, Pose, Twist, perpendicular};

use crate::effect::Stage;
use crate::effect::geometry::Outline;
use crate::object::spots::Spots;
use crate::predict::contact_event::ContactEvent;
use crate::predict::instant::Memory;
use crate::predict::moved::moved;
use crate::predict::touch_time::{TOUCH, touch_time};
use crate::{Channels, ContactLaw, EffectError, MeasurementModel, PushPhysics, StepInput};

/// The state of a step while it is integrated.
pub(crate) struct Forward<'a> {
    pub(crate) physics: &'a PushPhysics,
    pub(crate) step: &'a StepInput,
    pub(crate) measurement: MeasurementModel,
    outline: Outline<'a>,
    /// Where the object rests, if not on its area alone.
    pub(crate) spots: Option<&'a Spots>,
    pub(crate) law: ContactLaw,
    /// The tracked frame in the outline's.
    pub(crate) pose_ob: Pose,
    /// Whether measured and true geometry are the same.
    is_plain: bool,
    pub(crate) has_inertia: bool,
    pub(crate) time: f64,
    pub(crate) pose_wo: Pose,
    /// Velocity of the center of mass, axes of W; followed only with inertia.
    pub(crate) twist_w: Twist,
    pub(crate) touching: bool,
    /// The contact at this time and pose.
    pub(crate) now: ContactEvent,
    /// How far the pusher yields along the normal, in m.
    deflection: f64,
    /// How far the center of the pressure is moved by the push, in m, axes of the outline.
    pub(crate) lean_o: Vector2<f64>,
    /// Time integral of the measured force, normal and tangential to the nominal contact, in N·s.
    impulse: Vector2<f64>,
    pub(crate) memory: Memory,
    /// Times and velocities of the last moments of the push, the later one first.
    pub(crate) trail: Vec<(f64, Twist)>,
}

const LEAST_SUBSTEPS: f64 = 4.0;
const LEAST_DYNAMIC_SUBSTEPS: f64 = 3.0;
/// A sub-step with inertia solves for the push twice: it goes that much farther.
const DYNAMIC_LENGTH: f64 = 2.0;
const MOST_SUBSTEPS: f64 = 1e5;
/// Share of a sub-step within which a change of the contact is found.
pub(crate) const SHORTEST: f64 = 1e-6;

impl<'a> Forward<'a> {
    pub(crate) fn new(
        physics: &'a PushPhysics,
        step: &'a StepInput,
        spots: Option<&'a Spots>,
    ) -> Result<Self, EffectError> {
        let (measurement, geometry) = (physics.measurement(step), physics.geometry(step));
        let pose_bo = measurement.pose_bo();
        let pose_wo = measurement.in_robot(&step.pose_wb) * pose_bo;
        let (law, has_inertia) = (physics.contact(step, &pose_wo), physics.has_inertia());
        let is_plain = measurement == MeasurementModel::default()
            && geometry.radius_excess == 0.0
            && geometry.corner_radius == 0.0
            && law.compliance == 0.0;
        let nowhere = Contact {
            point: Vector2::zeros(),
            normal: Vector2::x(),
            edge: 0,
            p: 0.0,
            gap: 0.0,
            feature: Feature::Edge,
        };
        let mut forward = Self {
            physics,
            step,
            measurement,
            outline: Outline::new(step, geometry)?,
            spots,
            law,
            pose_ob: pose_bo.inverse(),
            is_plain,
            has_inertia,
            time: 0.0,
            pose_wo,
            twist_w: Twist::default(),
            touching: false,
            now: ContactEvent { contact: nowhere, velocity_w: Vector2::zeros() },
            deflection: 0.0,
            lean_o: Vector2::zeros(),
            impulse: Vector2::zeros(),
            memory: Memory::default(),
            trail: Vec::with_capacity(2),
        };
        forward.now = forward.meet(0.0, &pose_wo);
        Ok(forward)
    }

    /// All channels at the end of the step.
    pub(crate) fn run(self) -> Result<Channels, EffectError> {
        self.run_past(|_| {})
    }

    /// The same, seen at the start and after each sub-step.
    pub(crate) fn run_past(mut self, mut seen: impl FnMut(&Self)) -> Result<Channels, EffectError> {
        self.start()?;
        seen(&self);
        let start_wb = self.measured_pose();
        let gap_start = self.measured_gap();
        self.finish_late_motion();
        let duration = self.step.track.duration();
        let longest = duration / self.n_substeps()?;
        let mut let_go = false;
        while duration - self.time > 1e-9 * longest {
            let length = longest.min(duration - self.time);
            let shortest = (SHORTEST * longest).min(length);
            let kink = self.kink_within(length);
            let length = self.until_turn(kink.unwrap_or(length)).max(shortest);
            if self.touching {
                self.touching = self.press(length, shortest)?;
                let_go = !self.touching;
            } else {
                self.trail.clear();
                self.go_free(length, let_go)?;
                let_go = false;
            }
            if kink == Some(length) {
                self.trail.clear();
            }
            seen(&self);
        }
        self.time = duration;
        let end_wb = self.measured_pose();
        let along = self.step.direction_w();
        let moved = end_wb.position - start_wb.position;
        let force = self.impulse / duration;
        Channels {
            dx: along.dot(&moved),
            dy: perpendicular(&along).dot(&moved),
            dtheta: end_wb.angle - start_wb.angle,
            force_normal: force.x,
            force_tangential: force.y,
            gap_start,
            gap_end: self.measured_gap(),
        }
        .checked()
    }

    /// As many sub-steps of equal time as the path asks for, or the rule.
    fn n_substeps(&self) -> Result<f64, EffectError> {
        let (length, least) = match self.has_inertia {
            true => (DYNAMIC_LENGTH, LEAST_DYNAMIC_SUBSTEPS),
            false => (1.0, LEAST_SUBSTEPS),
        };
        let longest = length * self.physics.rig().longest_substep();
        // A path of a whole number of sub-steps must not gain one by rounding.
        let n = (self.step.track.length() / longest - 1e-6).ceil().max(least);
        let n = (self.physics.share_of_substeps() * n).ceil();
        if n <= MOST_SUBSTEPS {
            return Ok(n);
        }
        let (name, unit) = ("the pusher's path over the longest sub-step", "(count)");
        Err(EffectError::InvalidValue { name, expected: "at most 100000", value: n, unit })
    }

    /// Sets the object where it truly is at the start.
    fn start(&mut self) -> Result<(), EffectError> {
        let meeting = self.now;
        let approach = self.pose_wo.rotate(&meeting.contact.normal).dot(&meeting.velocity_w);
        if self.law.compliance > 0.0 && approach > 0.0 {
            let pose = self.pose_wo;
            let rate = self.rate(0.0, &pose, &meeting)?;
            self.deflection = self.law.compliance * meeting.contact.normal.dot(&rate.force_o);
            self.now.contact.gap += self.deflection;
            self.trail.extend((rate.mode != ContactMode::Separated).then_some((0.0, rate.twist_w)));
        }
        let mut pushed_for = 0.0;
        if self.step.touching {
            // What the pusher still goes before it moves the object: its spring is not wound up
            // yet, or the object's stream lags behind. One that leaves has no such way before it.
            let approach = approach.max(0.0);
            let ahead = self.deflection
                + self.outline.approach_gap()
                + approach * self.measurement.latency.max(0.0);
            let lost = (ahead - approach * self.step.since_contact).max(0.0);
            self.close(lost);
            self.touching = lost <= TOUCH;
            let late = if approach > 0.0 { ahead / approach } else { 0.0 };
            pushed_for = (self.step.since_contact - late).max(0.0);
        } else {
            if self.step.since_contact == 0.0 {
                self.close(self.now.contact.gap + self.outline.approach_gap());
            }
            self.touching = self.now.contact.gap <= TOUCH && approach > 0.0;
        }
        if self.has_inertia {
            self.start_moving(pushed_for)?;
        }
        Ok(())
    }

    /// After contact a late stream still shows the motion of before; inertia follows it itself.
    fn finish_late_motion(&mut self) {
        let is_after = !self.step.touching && self.step.since_contact > 0.0;
        if is_after && !self.has_inertia && self.measurement.latency > 0.0 {
            let late = self.measurement.latency.min(self.step.track.duration());
            self.pose_wo = moved(&self.pose_wo, &self.step.twist_wb, late);
            self.now = self.meet(0.0, &self.pose_wo);
        }
    }

    /// Time without contact, up to the touch at most.
    fn go_free(&mut self, length: f64, let_go: bool) -> Result<(), EffectError> {
        if !self.has_inertia && self.physics.acts_at(Stage::Load) {
            self.rest(&self.pose_wo, &mut self.memory.clone())?;
        }
        let start = self.now;
        let gap_at = |run: &Self, time: f64, pose: &Pose| run.meet(time, pose).contact.gap;
        let speed = self.closing_speed(&start, &self.pose_wo, &self.twist_w);
        if !let_go && start.contact.gap <= TOUCH && speed > 0.0 {
            self.touching = true;
            return Ok(());
        }
        let (mut pose, mut twist) = self.slid(length)?;
        let mut high = length;
        let end_gap = gap_at(self, self.time + length, &pose);
        // A measured overlap that does not get deeper is no touch.
        if end_gap < start.contact.gap.min(0.0) && !let_go {
            let gap_after = |time: f64| -> Result<f64, EffectError> {
                Ok(gap_at(self, self.time + time, &self.slid(time)?.0))
            };
            high = touch_time((start.contact.gap, end_gap), length, gap_after)?;
            (pose, twist) = self.slid(high)?;
            self.touching = true;
        }
        let (before, nothing) = (self.pose_wo, Vector2::zeros());
        self.record(self.time, &before, &start.contact, &nothing, high);
        (self.pose_wo, self.twist_w) = (pose, twist);
        self.time += high;
        self.now = self.meet(self.time, &pose);
        if self.touching {
            self.close(0.0);
        }
        Ok(())
    }

    /// Refuses an object that has to rest at a pose and cannot.
    pub(crate) fn rest(&self, pose: &Pose, memory: &mut Memory) -> Result<(), EffectError> {
        self.balance(pose, self.time, &Vector2::zeros())?.refuse_sliding_by_itself(memory)
    }

    /// Pose and velocity after some time without contact.
    fn slid(&self, time: f64) -> Result<(Pose, Twist), EffectError> {
        if self.has_inertia {
            self.slid_with_inertia(time)
        } else {
            Ok((self.pose_wo, self.twist_w))
        }
    }

    /// The true contact, its gap that to the yielding pusher.
    pub(crate) fn meet(&self, time: f64, pose_wo: &Pose) -> ContactEvent {
        self.contact_with(self.pusher(time), pose_wo)
    }

    /// The same with a pusher at a place, in m, with a velocity, in m/s.
    pub(crate) fn contact_with(
        &self,
        (center_w, velocity_w): (Vector2<f64>, Vector2<f64>),
        pose_wo: &Pose,
    ) -> ContactEvent {
        let mut contact = self.outline.nearest(&pose_wo.inverse_transform_point(&center_w));
        contact.gap += self.deflection;
        ContactEvent { contact, velocity_w }
    }

    /// Where the pusher is, in m, and its velocity, in m/s, at a time of the object's stream.
    pub(crate) fn pusher(&self, time: f64) -> (Vector2<f64>, Vector2<f64>) {
        self.step.track.at(time - self.measurement.latency)
    }

    /// The contact with its place and velocity, for a moment.
    pub(crate) fn acting_point(&self, contact: &Contact) -> Vector2<f64> {
        self.outline.acting_point(contact)
    }

    /// Speed at which pusher and contact point near each other, in m/s.
    pub(crate) fn closing_speed(&self, meeting: &ContactEvent, pose: &Pose, twist: &Twist) -> f64 {
        let arm = meeting.contact.point - self.step.object.center_of_mass();
        let point_velocity = twist.velocity_at(&pose.rotate(&arm));
        pose.rotate(&meeting.contact.normal).dot(&(meeting.velocity_w - point_velocity))
    }

    /// Goes on to a later time in contact.
    pub(crate) fn reach(&mut self, time: f64) {
        self.time = time;
        self.now = self.meet(time, &self.pose_wo);
        self.close(0.0);
    }

    /// Moves the object along the normal until the gap has a size, in m; the contact stays.
    fn close(&mut self, gap: f64) {
        let contact = &mut self.now.contact;
        self.pose_wo.position += (gap - contact.gap) * self.pose_wo.rotate(&contact.normal);
        contact.gap = gap;
    }

    /// Adds a sub-step's force as the sensor shows it, in the frame of the nominal contact.
    pub(crate) fn record(
        &mut self,
        time: f64,
        pose: &Pose,
        contact: &Contact,
        force_o: &Vector2<f64>,
        length: f64,
    ) {
        let (normal, force) = if self.is_plain {
            (contact.normal, *force_o)
        } else {
            let pose_wb = self.measured(pose);
            let normal_b = self.nominal(time, &pose_wb).normal;
            (pose_wb.rotate(&normal_b), self.measurement.force(&pose.rotate(force_o)))
        };
        self.impulse +=
            length * Vector2::new(normal.dot(&force), perpendicular(&normal).dot(&force));
        if self.law.compliance > 0.0 && *force_o != Vector2::zeros() {
            self.deflection = self.law.compliance * contact.normal.dot(force_o);
        }
    }

    /// The contact that the measured streams show.
    fn nominal(&self, time: f64, pose_wb: &Pose) -> Contact {
        let center_b = pose_wb.inverse_transform_point(&self.step.track.at(time).0);
        self.step.object.shape().contact(&center_b, self.step.pusher_radius)
    }

    fn measured_gap(&self) -> f64 {
        if self.is_plain {
            return self.now.contact.gap;
        }
        self.nominal(self.time, &self.measured_pose()).gap
    }
}
