//! How fast an object with inertia is where a step of a push begins.

use planar::{Pose, Twist};

use crate::EffectError;
use crate::predict::contact_event::ContactEvent;
use crate::predict::forward::Forward;
use crate::predict::inertia::GAMMA;
use crate::step::run_up::RunUp;

/// Longest last interval of the run-up, in m of the pusher's way; it is no longer than friction takes to stop
/// the object.
const LAST_WAY: f64 = 4e-3;
/// Length of an interval in that of the one after it.
const GROWTH: f64 = 2.0;
/// What was longer ago than so many times what friction takes to stop the object is forgotten: one interval goes
/// over it.
const MEMORY: f64 = 4.0;

impl Forward<'_> {
    /// The velocity that the object takes up from rest while the pusher goes `pushed_for` (s) along its measured
    /// way, in the contacts that were measured there.
    ///
    /// The object's measured velocity would tell of each push what no model knows of it: where there is little
    /// friction an object keeps it.
    pub(crate) fn run_up(&mut self, push: &RunUp, pushed_for: f64) -> Result<Twist, EffectError> {
        let (pose, meeting) = self.earlier(push, pushed_for);
        let mut twist_w = self.struck(-pushed_for, &pose, &meeting, &Twist::default())?;
        let mut from = pushed_for;
        for to in self.ends_of_intervals(pushed_for) {
            twist_w = self.pushed_on(push, (from, to), &twist_w)?;
            from = to;
        }
        Ok(twist_w)
    }

    /// Where the intervals of the run-up end, in s before the start, the first one first.
    fn ends_of_intervals(&self, pushed_for: f64) -> Vec<f64> {
        let (rig, speed) = (self.physics.rig(), self.now.velocity_w.norm());
        let to_stop = speed / (rig.support_friction() * rig.gravity());
        let (mut end, mut length) = (0.0, to_stop.min(LAST_WAY / speed));
        let mut ends = Vec::new();
        while end < pushed_for {
            ends.push(end);
            end += length;
            length *= GROWTH;
            if end >= MEMORY * to_stop {
                break;
            }
        }
        ends.reverse();
        ends
    }

    /// The velocity after an interval, by the rule of [`Forward::press_with_inertia`].
    fn pushed_on(
        &mut self,
        push: &RunUp,
        (from, to): (f64, f64),
        start: &Twist,
    ) -> Result<Twist, EffectError> {
        let length = GAMMA * (from - to);
        let first = self.earlier_stage(push, from - length, length, start)?;
        let target = *start + (1.0 - GAMMA) / GAMMA * (first + -1.0 * *start);
        self.earlier_stage(push, to, length, &target)
    }

    /// The velocity at which all loads balance, `before` seconds ago; without the pusher's if it lets go.
    fn earlier_stage(
        &mut self,
        push: &RunUp,
        before: f64,
        length: f64,
        target: &Twist,
    ) -> Result<Twist, EffectError> {
        let (pose, meeting) = self.earlier(push, before);
        Ok(self.stage_in(-before, &pose, &meeting, (length, target))?.twist_w)
    }

    /// Pose of the outline and contact some time before the start, in s.
    fn earlier(&self, push: &RunUp, before: f64) -> (Pose, ContactEvent) {
        if before == 0.0 {
            return (self.pose_wo, self.now);
        }
        let since_contact = self.step.since_contact - before;
        let pose_wb = self.measurement.in_robot(&push.at(since_contact).pose_wb);
        let pose_wo = pose_wb * self.pose_ob.inverse();
        let pusher = push.at(since_contact - self.measurement.latency);
        (pose_wo, self.contact_with((pusher.pusher_w, pusher.pusher_velocity_w), &pose_wo))
    }
}
