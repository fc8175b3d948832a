//! The step of an object with inertia.

use mechanics::ContactMode;
use nalgebra::Vector2;
use planar::{Pose, Twist};

use crate::EffectError;
use crate::predict::contact_event::ContactEvent;
use crate::predict::forward::Forward;
use crate::predict::instant::Rate;
use crate::predict::moved::moved;

/// 1 − 1/√2: both stages of the rule have this share of the sub-step.
pub(crate) const GAMMA: f64 = 1.0 - std::f64::consts::FRAC_1_SQRT_2;
/// Share of the time to rest that a free slide goes in one step.
const SLIDE_SHARE: f64 = 0.125;
/// A slide takes some seventy steps to rest.
const MOST_SLIDES: usize = 10_000;
/// Share of the first energy below which the rest of a slide is added in one piece.
const REST_SHARE: f64 = 1e-4;

impl Forward<'_> {
    /// The velocity at the start, after the pusher pushed for some time, in s, made to fit the contact.
    pub(crate) fn start_moving(&mut self, pushed_for: f64) -> Result<(), EffectError> {
        let step = self.step;
        self.twist_w = match step.run_up.as_deref().filter(|_| step.touching) {
            Some(push) => self.run_up(push, pushed_for)?,
            None => {
                let center_w = self.pose_wo.transform_point(step.object.center_of_mass());
                let center_w = center_w + self.measurement.robot_w;
                step.twist_wb.shifted(&(center_w - step.pose_wb.position))
            }
        };
        if self.touching {
            self.meet_pusher()?;
        }
        Ok(())
    }

    /// One sub-step in contact; false, and nothing done, if the pusher lets go.
    ///
    /// # Source
    /// The rule SDIRK2 of Alexander (1977), "Diagonally implicit Runge–Kutta methods for stiff
    /// O.D.E.'s": at low speed friction makes the motion stiff, and it ends in the quasi-static one.
    pub(crate) fn press_with_inertia(&mut self, length: f64) -> Result<bool, EffectError> {
        let before = self.twist_w;
        self.meet_pusher()?;
        let (time, pose, start) = (self.time, self.pose_wo, self.twist_w);
        let share = GAMMA * length;
        let early = self.moved_center(&pose, &start, share);
        let Some((first, _)) = self.stage(time + share, &early, share, &start)? else {
            self.twist_w = before;
            return Ok(false);
        };
        let ratio = (1.0 - GAMMA) / GAMMA;
        let target = start + ratio * (first.twist_w + -1.0 * start);
        let mean = (1.0 - GAMMA) * first.twist_w + GAMMA * start;
        let late = self.moved_center(&pose, &mean, length);
        let Some((second, meeting)) = self.stage(time + length, &late, share, &target)? else {
            self.twist_w = before;
            return Ok(false);
        };
        let force_o = (1.0 - GAMMA) * first.force_o + GAMMA * second.force_o;
        self.record(time + length, &late, &meeting.contact, &force_o, length);
        let mean = (1.0 - GAMMA) * first.twist_w + GAMMA * second.twist_w;
        self.pose_wo = self.moved_center(&pose, &mean, length);
        self.twist_w = second.twist_w;
        self.reach(time + length);
        Ok(true)
    }

    /// Pose and velocity of the center of mass after sliding freely for some time.
    ///
    /// Midpoint rule in steps of an eighth of the time that is left until rest.
    pub(crate) fn slid_with_inertia(&self, time: f64) -> Result<(Pose, Twist), EffectError> {
        let (mut pose, mut twist, mut left) = (self.pose_wo, self.twist_w, time);
        let (first, mut memory) = (self.energy(&twist), self.memory.clone());
        for _ in 0..MOST_SLIDES {
            if left <= 0.0 {
                return Ok((pose, twist));
            }
            let energy = self.energy(&twist);
            if energy <= f64::MIN_POSITIVE {
                self.rest(&pose, &mut memory)?;
                return Ok((pose, Twist::default()));
            }
            let now = self.balance(&pose, self.time, &Vector2::zeros())?;
            let (acceleration, power) = now.free_acceleration(&twist, &mut memory)?;
            // With constant forces the energy 2E/P more seconds would bring the object to rest.
            let until_rest = if power > 0.0 { 2.0 * energy / power } else { f64::INFINITY };
            if energy <= REST_SHARE * first && until_rest <= left {
                pose = self.moved_center(&pose, &twist, 0.5 * until_rest);
                self.rest(&pose, &mut memory)?;
                return Ok((pose, Twist::default()));
            }
            let length = left.min(SLIDE_SHARE * until_rest);
            let middle = twist + 0.5 * length * acceleration;
            let half_way = self.moved_center(&pose, &twist, 0.5 * length);
            let then = self.balance(&half_way, self.time, &Vector2::zeros())?;
            let (acceleration, _) = then.free_acceleration(&middle, &mut memory)?;
            pose = self.moved_center(&pose, &middle, length);
            twist += length * acceleration;
            left -= length;
        }
        Err(EffectError::NotConverged { what: "the free slide", iterations: MOST_SLIDES })
    }

    /// An inelastic impact with Coulomb friction, if the pusher is faster than the object.
    fn meet_pusher(&mut self) -> Result<(), EffectError> {
        if self.closing_speed(&self.now, &self.pose_wo, &self.twist_w) > 0.0 {
            self.twist_w = self.struck(self.time, &self.pose_wo, &self.now, &self.twist_w)?;
        }
        Ok(())
    }

    /// The velocity after the impact of a pusher on an object that moved with `twist_w`.
    pub(crate) fn struck(
        &self,
        time: f64,
        pose: &Pose,
        meeting: &ContactEvent,
        twist_w: &Twist,
    ) -> Result<Twist, EffectError> {
        let instant = self.balance(pose, time, &Vector2::zeros())?;
        let point = self.acting_point(&meeting.contact);
        let touch = instant.touch(&meeting.contact, &point, &meeting.velocity_w);
        instant.struck(&touch, &self.law, twist_w)
    }

    /// An implicit stage: the velocity at which all loads balance; none if the pusher lets go.
    fn stage(
        &mut self,
        time: f64,
        pose: &Pose,
        length: f64,
        target: &Twist,
    ) -> Result<Option<(Rate, ContactEvent)>, EffectError> {
        let meeting = self.meet(time, pose);
        let rate = self.stage_in(time, pose, &meeting, (length, target))?;
        Ok((rate.mode != ContactMode::Separated).then_some((rate, meeting)))
    }

    /// The same in a contact, without the pusher's load if it lets go.
    pub(crate) fn stage_in(
        &mut self,
        time: f64,
        pose: &Pose,
        meeting: &ContactEvent,
        (length, target): (f64, &Twist),
    ) -> Result<Rate, EffectError> {
        let law = self.law;
        self.with_lean(pose, time, meeting, |instant, touch, memory| {
            instant.pushed_with_inertia(touch, &law, length, target, memory)
        })
    }

    fn energy(&self, twist: &Twist) -> f64 {
        let object = &self.step.object;
        0.5 * (object.mass() * twist.linear.norm_squared()
            + object.moment_of_inertia() * twist.angular * twist.angular)
    }

    /// A pose after its center of mass moved with a constant velocity.
    fn moved_center(&self, pose: &Pose, twist: &Twist, time: f64) -> Pose {
        let center = self.step.object.center_of_mass();
        let before = pose.transform_point(center);
        let turned = moved(pose, &Twist { angular: twist.angular, ..Twist::default() }, time);
        let position = before + time * twist.linear - turned.rotate(center);
        Pose { position, ..turned }
    }
}
