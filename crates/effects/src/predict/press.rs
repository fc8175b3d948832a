//! A sub-step in contact, by the midpoint rule.

use mechanics::ContactMode;
use planar::{Contact, Pose, Twist};

use crate::EffectError;
use crate::predict::forward::Forward;
use crate::predict::instant::Rate;
use crate::predict::moved::moved;

/// The moment in the middle of a sub-step.
struct Middle {
    time: f64,
    pose_wo: Pose,
    contact: Contact,
    rate: Rate,
}

impl Forward<'_> {
    /// One sub-step in contact; false, and nothing done, if the pusher lets go.
    ///
    /// The midpoint rule, whose way to the middle follows from the moments before: each further
    /// sub-step takes one solution of the push instead of two.
    pub(crate) fn press(&mut self, length: f64, shortest: f64) -> Result<bool, EffectError> {
        if self.has_inertia {
            return self.press_with_inertia(length);
        }
        let foreseen = self.twist_ahead(self.time + 0.25 * length);
        if let Some(foreseen) = foreseen {
            let middle = self.middle(&foreseen, length)?;
            if middle.rate.mode != ContactMode::Separated {
                self.advance(&middle, length);
                return Ok(true);
            }
        }
        let (time, pose, start) = (self.time, self.pose_wo, self.now);
        let first = match self.trail.as_slice() {
            // Known from what the pusher yields by: the gap that was closed since hardly changes it.
            [(at, twist_w)] if *at == time => *twist_w,
            _ => {
                let rate = self.rate(time, &pose, &start)?;
                if rate.mode == ContactMode::Separated {
                    return Ok(false);
                }
                rate.twist_w
            }
        };
        self.trail = vec![(time, first)];
        let middle = self.middle(&first, length)?;
        if middle.rate.mode != ContactMode::Separated {
            self.advance(&middle, length);
            return Ok(true);
        }
        // It lets go on the way to the middle.
        if length > shortest { self.press(0.5 * length, shortest) } else { Ok(false) }
    }

    /// The moment after half a sub-step with some velocity.
    fn middle(&mut self, twist_w: &Twist, length: f64) -> Result<Middle, EffectError> {
        let time = self.time + 0.5 * length;
        let pose_wo = moved(&self.pose_wo, twist_w, 0.5 * length);
        let meeting = self.meet(time, &pose_wo);
        let rate = self.rate(time, &pose_wo, &meeting)?;
        Ok(Middle { time, pose_wo, contact: meeting.contact, rate })
    }

    /// Goes on by a sub-step with the velocity in its middle.
    fn advance(&mut self, middle: &Middle, length: f64) {
        let Middle { time, pose_wo, contact, rate } = middle;
        self.record(*time, pose_wo, contact, &rate.force_o, length);
        self.pose_wo = moved(&self.pose_wo, &rate.twist_w, length);
        self.trail.insert(0, (*time, rate.twist_w));
        self.trail.truncate(2);
        self.reach(self.time + length);
    }

    /// The velocity at a time to come, on a line through the last two moments of the push.
    fn twist_ahead(&self, time: f64) -> Option<Twist> {
        let [(late, last), (early, before)] = self.trail.as_slice() else { return None };
        let ahead = (time - late) / (late - early);
        Some(*last + ahead * (*last + -1.0 * *before))
    }
}
