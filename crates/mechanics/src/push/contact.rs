//! One contact that pushes: what goes in and what comes out.

use crate::MechanicsError;
use nalgebra::{UnitVector2, Vector2};
use planar::{Twist, Wrench, perpendicular};

/// A pusher in contact with a slider, all in the slider frame S (origin at the center of friction).
///
/// The pusher translates: every point of it moves with `v_wp_s`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Push {
    /// Contact point, in m.
    pub p_sc: Vector2<f64>,
    /// Normal of the contact, into the slider.
    pub normal_s: UnitVector2<f64>,
    /// The pusher's velocity, in m/s.
    pub v_wp_s: Vector2<f64>,
    /// Coefficient of friction between pusher and slider, dimensionless.
    pub friction: f64,
}

/// How the contact moves.
///
/// Left and right are those of someone who stands at the pusher and looks along the inward normal:
/// left is the tangent, the normal turned by +90°.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ContactMode {
    /// The contact point moves with the pusher.
    Sticking,
    /// The pusher slides to the left over the slider; the force is on the cone's left edge.
    SlidingLeft,
    /// The pusher slides to the right over the slider; the force is on the cone's right edge.
    SlidingRight,
    /// No force passes: the pusher does not approach the slider, which stays at rest.
    Separated,
}

/// What a push does to the slider.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PushMotion {
    /// Sticking, sliding or separated.
    pub mode: ContactMode,
    /// The slider's velocity, in m/s and rad/s, frame S.
    pub twist_ws_s: Twist,
    /// Contact force on the slider, in N, frame S.
    pub force_s: Vector2<f64>,
    /// Velocity of the pusher over the slider along the tangent, in m/s: positive to the left.
    pub slip: f64,
}

impl Push {
    /// The contact's tangent: the inward normal turned by +90°, "left".
    pub fn tangent_s(&self) -> Vector2<f64> {
        perpendicular(&self.normal_s)
    }

    /// Speed at which the pusher approaches the slider at rest, in m/s.
    pub fn approach_speed(&self) -> f64 {
        self.normal_s.dot(&self.v_wp_s)
    }

    /// The wrench of `force_s` at the contact, in N and N·m.
    pub fn wrench_of(&self, force_s: &Vector2<f64>) -> Wrench {
        Wrench::from_force_at(force_s, &self.p_sc)
    }

    /// A direction along the cone's edge that belongs to a sliding `mode`; else the normal.
    pub(crate) fn edge_of(&self, mode: ContactMode) -> Vector2<f64> {
        let share = match mode {
            ContactMode::SlidingLeft => self.friction,
            ContactMode::SlidingRight => -self.friction,
            ContactMode::Sticking | ContactMode::Separated => 0.0,
        };
        self.normal_s.into_inner() + share * self.tangent_s()
    }

    /// The motion that belongs to a force and a twist.
    pub(crate) fn motion(
        &self,
        mode: ContactMode,
        twist_ws_s: Twist,
        force_s: Vector2<f64>,
    ) -> PushMotion {
        let slip = match mode {
            ContactMode::Sticking => 0.0,
            _ => self.tangent_s().dot(&(self.v_wp_s - twist_ws_s.velocity_at(&self.p_sc))),
        };
        PushMotion { mode, twist_ws_s, force_s, slip }
    }

    /// The motion without contact force.
    pub(crate) fn separated(&self) -> PushMotion {
        self.motion(ContactMode::Separated, Twist::new(0.0, 0.0, 0.0), Vector2::zeros())
    }

    /// The speed's power of two, in m/s: divided by it, a velocity keeps all its digits and its squares
    /// neither over- nor underflow.
    pub(crate) fn speed_scale(&self) -> f64 {
        const EXPONENT: u64 = 0x7ff0_0000_0000_0000;
        let largest = self.v_wp_s.amax();
        if largest == 0.0 {
            return 1.0;
        }
        f64::from_bits(largest.to_bits() & EXPONENT).max(f64::MIN_POSITIVE)
    }

    /// The same push at a velocity `scale` times smaller.
    pub(crate) fn slowed_by(&self, scale: f64) -> Self {
        Self { v_wp_s: self.v_wp_s / scale, ..*self }
    }

    /// Refuses what is not finite and negative friction.
    pub(crate) fn validate(&self) -> Result<(), MechanicsError> {
        for (name, vector, unit) in [
            ("the contact point", &self.p_sc, "m"),
            ("the contact normal", &*self.normal_s, "(dimensionless)"),
            ("the pusher's velocity", &self.v_wp_s, "m/s"),
        ] {
            if let Some(&value) = vector.iter().find(|x| !x.is_finite()) {
                return Err(MechanicsError::NotFinite { name, value, unit });
            }
        }
        if !(self.friction >= 0.0 && self.friction.is_finite()) {
            let name = "the friction coefficient";
            let (value, unit) = (self.friction, "(dimensionless)");
            return Err(MechanicsError::Negative { name, value, unit });
        }
        Ok(())
    }
}

impl PushMotion {
    /// The motion of the push that is `scale` times faster.
    ///
    /// # Errors
    /// `NotFinite` where it is beyond all numbers.
    pub(crate) fn sped_up_by(self, scale: f64) -> Result<Self, MechanicsError> {
        let (twist_ws_s, slip) = (scale * self.twist_ws_s, scale * self.slip);
        for (name, vector, unit) in [
            ("the slider's velocity", twist_ws_s.to_vector(), "m/s or rad/s"),
            ("the contact force", self.force_s.push(slip), "N, or m/s of slip"),
        ] {
            if let Some(&value) = vector.iter().find(|x| !x.is_finite()) {
                return Err(MechanicsError::NotFinite { name, value, unit });
            }
        }
        Ok(Self { twist_ws_s, slip, ..self })
    }
}
