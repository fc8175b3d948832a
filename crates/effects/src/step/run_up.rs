//! A push before a step.

use nalgebra::Vector2;
use planar::{Pose, wrap_angle};

use crate::EffectError;
use crate::error::{finite, not_negative};

/// Object and pusher at a moment of a push.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PushMoment {
    /// Time since the push's first contact, in s.
    pub since_contact: f64,
    /// Measured pose of the tracked frame B in W.
    pub pose_wb: Pose,
    /// The pusher's measured center in W, in m.
    pub pusher_w: Vector2<f64>,
    /// The pusher's velocity in W, in m/s.
    pub pusher_velocity_w: Vector2<f64>,
}

impl PushMoment {
    /// Refuses numbers that no push has.
    ///
    /// # Errors
    /// `InvalidValue` for one that is not finite, or a negative time.
    pub fn validate(&self) -> Result<(), EffectError> {
        let Self { since_contact, pose_wb: Pose { position, angle }, .. } = self;
        not_negative("the time since contact", *since_contact, "s")?;
        finite("a pose of the push", position.x + position.y + angle, "m or rad")?;
        let (place, velocity) = (self.pusher_w, self.pusher_velocity_w);
        finite("the pusher's place", place.x + place.y, "m")?;
        finite("the pusher's velocity", velocity.x + velocity.y, "m/s")?;
        Ok(())
    }
}

/// A push as it was measured, moment by moment: what a step in its midst has behind it.
///
/// Between two moments object and pusher go on a line; before the first and after the last they are where they are
/// there.
#[derive(Clone, Debug, PartialEq)]
pub struct RunUp {
    moments: Vec<PushMoment>,
}

impl RunUp {
    /// A push through some moments, in the order of their times.
    ///
    /// # Errors
    /// `InvalidValue` for no moment, a number that is not finite, or a time that is negative or not later than the
    /// one before.
    pub fn new(moments: Vec<PushMoment>) -> Result<Self, EffectError> {
        let mut before = f64::NEG_INFINITY;
        let refused = |name, expected, value, unit| {
            Err(EffectError::InvalidValue { name, expected, value, unit })
        };
        if moments.is_empty() {
            return refused("the moments of a push", "at least one", 0.0, "(count)");
        }
        for moment in &moments {
            moment.validate()?;
            if moment.since_contact <= before {
                let (expected, value) = ("later than the moment before", moment.since_contact);
                return refused("the time since contact", expected, value, "s");
            }
            before = moment.since_contact;
        }
        Ok(Self { moments })
    }

    /// The push at a time since its first contact, in s.
    pub fn at(&self, since_contact: f64) -> PushMoment {
        let after = self.moments.partition_point(|moment| moment.since_contact < since_contact);
        let last = self.moments.len() - 1;
        if after == 0 || after > last {
            return PushMoment { since_contact, ..self.moments[after.min(last)] };
        }
        let (early, late) = (&self.moments[after - 1], &self.moments[after]);
        let share =
            (since_contact - early.since_contact) / (late.since_contact - early.since_contact);
        let between = |a: &Vector2<f64>, b: &Vector2<f64>| a + share * (b - a);
        let (from, to) = (&early.pose_wb, &late.pose_wb);
        PushMoment {
            since_contact,
            pose_wb: Pose {
                position: between(&from.position, &to.position),
                angle: from.angle + share * wrap_angle(to.angle - from.angle),
            },
            pusher_w: between(&early.pusher_w, &late.pusher_w),
            pusher_velocity_w: between(&early.pusher_velocity_w, &late.pusher_velocity_w),
        }
    }
}
