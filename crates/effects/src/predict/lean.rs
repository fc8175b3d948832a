//! The load that leans as a push above the table tips the object.

use nalgebra::Vector2;
use planar::Pose;

use crate::EffectError;
use crate::predict::balance::ContactKinematics;
use crate::predict::contact_event::ContactEvent;
use crate::predict::forward::Forward;
use crate::predict::instant::{ForceBalance, Memory, Rate};

/// Searches of the lean that belongs to a push: each comes nearer by the height over the object's size,
/// times its friction.
const MAX_LEANS: i32 = 40;
const PLAIN_LEANS: i32 = 10;
/// In the object's mean distance.
const LEAN_TOLERANCE: f64 = 1e-6;
/// What a change of sides may move the pressure by, over the object's mean distance.
const LARGEST_JUMP: f64 = 0.1;

impl<'a> Forward<'a> {
    /// Motion and force at a moment of the quasi-static push.
    pub(crate) fn rate(
        &mut self,
        time: f64,
        pose: &Pose,
        meeting: &ContactEvent,
    ) -> Result<Rate, EffectError> {
        let law = self.law;
        self.with_lean(pose, time, meeting, |instant, touch, memory| {
            instant.pushed(touch, &law, memory)
        })
    }

    /// The loads of a moment, under a pressure whose center is moved by a lean, in m.
    pub(crate) fn balance(
        &self,
        pose: &Pose,
        time: f64,
        lean_o: &Vector2<f64>,
    ) -> Result<ForceBalance<'a>, EffectError> {
        ForceBalance::new(self.physics, (self.step, self.spots), pose, time, lean_o)
    }

    /// The answer under a load that leans as the pushing force tips the object: their balance.
    ///
    /// # Errors
    /// `NotConverged` for a pusher so high that no lean is that of its force.
    pub(crate) fn with_lean(
        &mut self,
        pose: &Pose,
        time: f64,
        meeting: &ContactEvent,
        answer: impl Fn(&ForceBalance<'a>, &ContactKinematics, &mut Memory) -> Result<Rate, EffectError>,
    ) -> Result<Rate, EffectError> {
        let point = self.acting_point(&meeting.contact);
        let gain = self.law.height / (self.step.object.mass() * self.physics.rig().gravity());
        let length = self.step.object.mean_distance();
        let mut last: Option<[Vector2<f64>; 2]> = None;
        for iteration in 0..MAX_LEANS {
            let instant = self.balance(pose, time, &self.lean_o)?;
            let touch = instant.touch(&meeting.contact, &point, &meeting.velocity_w);
            if gain == 0.0 {
                return answer(&instant, &touch, &mut self.memory);
            }
            let memory = self.memory.clone();
            let rate = answer(&instant, &touch, &mut self.memory)?;
            let answered = gain * rate.force_o;
            let change = answered - self.lean_o;
            // The force may jump where it changes sides: ever shorter steps find where.
            let part = 0.5_f64.powi((iteration - PLAIN_LEANS).max(0));
            let next = match last.filter(|_| iteration < PLAIN_LEANS) {
                Some([answered_before, change_before]) => {
                    // Anderson's acceleration: the mix of two answers that would change least.
                    let turn = change - change_before;
                    let share = change.dot(&turn) / turn.norm_squared().max(f64::MIN_POSITIVE);
                    answered - share.clamp(-1.0, 1.0) * (answered - answered_before)
                }
                None => self.lean_o + part * change,
            };
            last = Some([answered, change]);
            self.lean_o = next;
            let is_jump = iteration == MAX_LEANS - 1 && change.norm() <= LARGEST_JUMP * length;
            if change.norm() <= LEAN_TOLERANCE * length || is_jump {
                return Ok(rate);
            }
            // The pressure of the next lean is near that of this one.
            let pressure = self.memory.pressure.take();
            self.memory = memory;
            self.memory.pressure = pressure;
        }
        let iterations = MAX_LEANS.unsigned_abs() as usize;
        Err(EffectError::NotConverged { what: "the lean under the push", iterations })
    }
}
