//! Centers of rotation, and the vote on which way a pushed object turns.

use crate::MechanicsError;
use crate::{ContactMode, Push};
use nalgebra::{Unit, UnitVector2, Vector2};
use planar::{Twist, cross, perpendicular};
use std::cmp::Ordering;

/// About which point a rigid body turns, in the frame of its twist.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CenterOfRotation {
    /// It turns about a point.
    Point {
        /// The point, in m.
        at: Vector2<f64>,
        /// Which way.
        sense: Sense,
    },
    /// It does not turn: all its points move the same way.
    Translation(UnitVector2<f64>),
    /// It does not move.
    Rest,
}

/// Which way a body turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Sense {
    /// Positive angles.
    CounterClockwise,
    /// Negative angles.
    Clockwise,
    /// Not at all.
    None,
}

impl CenterOfRotation {
    /// The center of rotation of a twist: (−vy, vx)/ω.
    pub fn of(twist: &Twist) -> Self {
        let at = perpendicular(&twist.linear) / twist.angular;
        if twist.angular != 0.0 && at.norm().is_finite() {
            return Self::Point { at, sense: Sense::of(twist.angular) };
        }
        // The largest component is divided out: its square may underflow.
        let linear = twist.linear / twist.linear.amax();
        Unit::try_new(linear, 0.0).map_or(Self::Rest, Self::Translation)
    }

    /// The twist about this center: turning at `rate` ≥ 0 in rad/s or, for a translation, moving at
    /// `rate` in m/s.
    pub fn twist(&self, rate: f64) -> Twist {
        match self {
            Self::Point { at, sense } => {
                let angular = rate * sense.sign();
                Twist { linear: -angular * perpendicular(at), angular }
            }
            Self::Translation(direction) => {
                Twist { linear: rate * direction.into_inner(), angular: 0.0 }
            }
            Self::Rest => Twist::default(),
        }
    }
}

impl Sense {
    /// The sense of a moment, or of an angular velocity.
    pub fn of(value: f64) -> Self {
        match value.partial_cmp(&0.0) {
            Some(Ordering::Greater) => Self::CounterClockwise,
            Some(Ordering::Less) => Self::Clockwise,
            _ => Self::None,
        }
    }

    /// 1, −1 or 0.
    pub fn sign(self) -> f64 {
        match self {
            Self::CounterClockwise => 1.0,
            Self::Clockwise => -1.0,
            Self::None => 0.0,
        }
    }
}

/// Which way a push turns the object, whatever the pressure under it: Mason's voting theorem.
///
/// The two edges of the friction cone and the pusher's velocity each vote by the side on which
/// they pass the center of friction, the origin of S, and the middle one of the three decides: where
/// both edges are on one side that is the majority. A ray through the center votes for no rotation,
/// and wins where it is the middle one: a velocity through it between the edges, or an edge through it
/// that the velocity is on or beyond. `Sense::None`, too, for a pusher that does not approach.
///
/// # Errors
/// A push with a component that is not finite or a negative friction.
///
/// # Source
/// Mason (1986), "Mechanics and planning of manipulator pushing operations".
pub fn sense_of_rotation(push: &Push) -> Result<Sense, MechanicsError> {
    push.validate()?;
    if push.approach_speed() <= 0.0 {
        return Ok(Sense::None);
    }
    let [left, right] =
        [ContactMode::SlidingLeft, ContactMode::SlidingRight].map(|mode| push.edge_of(mode));
    let velocity = push.v_wp_s / push.speed_scale();
    let mut votes = [left, right, velocity].map(|ray| Sense::of(cross(&push.p_sc, &ray)).sign());
    votes.sort_by(f64::total_cmp);
    Ok(Sense::of(votes[1]))
}
