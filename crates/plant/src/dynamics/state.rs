//! The state of the rig while it moves.

use libm::sincos;
use nalgebra::{Matrix2, SVector, Vector2, Vector3};

use crate::dynamics::energy::Energy;

/// Everything that a time step changes, world frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct State {
    /// Place of the center of mass and turn of the body, in m and rad.
    pub(crate) place: Vector3<f64>,
    /// Their rates, in m/s and rad/s.
    pub(crate) motion: Vector3<f64>,
    /// Tip's center against where the robot holds it, in m.
    pub(crate) deflection: Vector2<f64>,
    /// Where the tip's second spring is held, in m, on the same scale.
    pub(crate) grip: Vector2<f64>,
    /// Force of the tip on the object, in N.
    pub(crate) force: Vector2<f64>,
    /// What of it and of other forces the table's friction meets, and not the object's mass, in N.
    pub(crate) rubbed: Vector2<f64>,
    /// Integral of the tip's force over time, in N·s.
    pub(crate) impulse: Vector2<f64>,
    /// Integral of the object's torque on the tip about the tip's axis, in N·m·s.
    pub(crate) twisting: f64,
    /// Sums of work since the start, in J.
    pub(crate) energy: Energy,
    /// Speed of the tip over the outline in the latest step, in m/s; 0 if it sticks.
    pub(crate) slip_speed: f64,
}

impl State {
    pub(crate) fn at_rest(place: Vector3<f64>) -> Self {
        Self {
            place,
            motion: Vector3::zeros(),
            deflection: Vector2::zeros(),
            grip: Vector2::zeros(),
            force: Vector2::zeros(),
            rubbed: Vector2::zeros(),
            impulse: Vector2::zeros(),
            twisting: 0.0,
            energy: Energy::default(),
            slip_speed: 0.0,
        }
    }

    /// Richardson's extrapolation of a first-order step from two half steps (`self`) and one whole
    /// step: of second order. What may jump is left as the half steps have it.
    pub(crate) fn extrapolated(&self, whole: &Self) -> Self {
        Self {
            place: beyond(&self.place, &whole.place),
            motion: beyond(&self.motion, &whole.motion),
            deflection: beyond(&self.deflection, &whole.deflection),
            impulse: beyond(&self.impulse, &whole.impulse),
            twisting: self.twisting + (self.twisting - whole.twisting),
            energy: self.energy.beyond(&whole.energy),
            ..*self
        }
    }
}

fn beyond<const N: usize>(half: &SVector<f64, N>, whole: &SVector<f64, N>) -> SVector<f64, N> {
    half + (half - whole)
}

/// From the axes of a frame turned by an angle (rad) to the outer ones.
pub(crate) fn rotation(angle: f64) -> Matrix2<f64> {
    let (sin, cos) = sincos(angle);
    Matrix2::new(cos, -sin, sin, cos)
}
