//! The ellipsoidal limit surface.

use crate::quadric_push::quadric_push;
use crate::{LimitSurface, MechanicsError, Push, PushMotion, WrenchSet};
use nalgebra::{Matrix3, Vector3};
use planar::{Twist, Wrench};

/// (Fx² + Fy²)/Fmax² + M²/Mmax² = 1, upright and centered.
///
/// # Source
/// Lee & Cutkosky (1991), "Fixture planning with friction".
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipsoid {
    f_max: f64,
    tau_max: f64,
}

impl Ellipsoid {
    /// An ellipsoid from its largest pure force, in N, and largest pure moment, in N·m.
    ///
    /// # Errors
    /// `NotPositive` if one of them is not positive and finite.
    pub fn new(f_max: f64, tau_max: f64) -> Result<Self, MechanicsError> {
        for (name, value, unit) in [("f_max", f_max, "N"), ("tau_max", tau_max, "N·m")] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(MechanicsError::NotPositive { name, value, unit });
            }
        }
        Ok(Self { f_max, tau_max })
    }
}

impl LimitSurface for Ellipsoid {
    fn dissipation(&self, twist_s: &Twist) -> Result<f64, MechanicsError> {
        Ok((self.f_max * twist_s.linear.norm()).hypot(self.tau_max * twist_s.angular))
    }

    fn wrenches(&self, twist_s: &Twist) -> Result<WrenchSet, MechanicsError> {
        let power = self.dissipation(twist_s)?;
        if power == 0.0 {
            return Err(MechanicsError::NoDirection { name: "twist" });
        }
        Ok(WrenchSet::Point(Wrench {
            force: self.f_max * self.f_max / power * twist_s.linear,
            torque: self.tau_max * self.tau_max / power * twist_s.angular,
        }))
    }

    fn level(&self, wrench_s: &Wrench) -> Result<f64, MechanicsError> {
        Ok((wrench_s.force.norm() / self.f_max).hypot(wrench_s.torque / self.tau_max))
    }

    fn twist(&self, wrench_s: &Wrench) -> Result<Twist, MechanicsError> {
        let level = self.level(wrench_s)?;
        if level == 0.0 {
            return Err(MechanicsError::NoDirection { name: "wrench" });
        }
        Ok(Twist {
            linear: wrench_s.force / (level * self.f_max * self.f_max),
            angular: wrench_s.torque / (level * self.tau_max * self.tau_max),
        })
    }

    fn characteristic_length(&self) -> f64 {
        self.tau_max / self.f_max
    }

    fn push(&self, push: &Push) -> Result<PushMotion, MechanicsError> {
        let (force, moment) = (self.f_max.powi(-2), self.tau_max.powi(-2));
        quadric_push(&Matrix3::from_diagonal(&Vector3::new(force, force, moment)), push)
    }
}
