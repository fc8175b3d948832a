//! A massless tip on its spring and damper, in hard Coulomb contact with the object.

use nalgebra::{Matrix3, Vector2, Vector3};
use planar::{cross, perpendicular};

use crate::dynamics::outline::Touch;
use crate::truth::TipFriction;

/// The contact over one implicit step, in the body's axes.
///
/// The tip pushes with f = −k e − d ė, e its deflection from where the robot holds it, and has no
/// mass. It does not enter the object; it sticks, or slides with f_t = ±μ f_n. With the end of the
/// step's deflection for e, every one of these is linear in the object's motion.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TipContact {
    /// Rows that give the contact point's velocity along normal and tangent.
    normal_row: Vector3<f64>,
    tangent_row: Vector3<f64>,
    /// Force and moment of a unit force along normal and tangent.
    normal_load: Vector3<f64>,
    tangent_load: Vector3<f64>,
    /// Force on a contact point at rest, in N.
    normal_offset: f64,
    tangent_offset: f64,
    /// Velocity of the holder along normal and tangent, and of closing the gap, in m/s.
    base_normal: f64,
    base_tangent: f64,
    closing: f64,
    /// −∂f/∂ė at the end of the step, in N·s/m.
    resistance: f64,
    friction: TipFriction,
    slip_speed: f64,
    /// Spring force of the deflection at the start, in N.
    spring: Vector2<f64>,
    normal: Vector2<f64>,
    /// The tip's radius and how far beside the contact point the force acts, in m.
    radius: f64,
    shift: f64,
}

/// What the contact does to an object with some motion.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Response {
    /// Force and moment on the object, in N and N·m.
    pub(crate) load: Vector3<f64>,
    /// Minus its derivative by the motion.
    pub(crate) slope: Matrix3<f64>,
    /// Force on the object, in N.
    pub(crate) force: Vector2<f64>,
    /// Rate of the tip's deflection, in m/s.
    pub(crate) deflection_rate: Vector2<f64>,
    /// Speed of the tip over the outline along the tangent, in m/s.
    pub(crate) slip: f64,
    /// Heat of that sliding, in W.
    pub(crate) slip_power: f64,
    /// Torque of the object on the tip about the tip's axis, in N·m.
    pub(crate) torque: f64,
    /// Power of the couple by which the force acts beside the contact point, in W.
    pub(crate) couple_power: f64,
}

/// Springs and damper of the tip over one step.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Holder {
    /// k e at the start of the step, in N.
    pub(crate) spring: Vector2<f64>,
    /// d + (step)·k, in N·s/m.
    pub(crate) resistance: f64,
    /// Mean velocity of the holder over the step, in m/s.
    pub(crate) velocity: Vector2<f64>,
}

impl TipContact {
    /// - `arm`: the contact point from the center of mass, in m; - `shift`: how far beside it, along
    ///   the tangent, the force acts, in m; - `radius`: the tip's, in m; - `step`: in s.
    pub(crate) fn new(
        touch: &Touch,
        (arm, shift, radius): (&Vector2<f64>, f64, f64),
        holder: &Holder,
        step: f64,
        friction: TipFriction,
        slip_speed: f64,
    ) -> Self {
        let normal = touch.normal;
        let tangent = perpendicular(&normal);
        let row = |axis: &Vector2<f64>| Vector3::new(axis.x, axis.y, cross(arm, axis));
        let beside = arm + shift * tangent;
        let load = |axis: &Vector2<f64>| Vector3::new(axis.x, axis.y, cross(&beside, axis));
        let base_normal = normal.dot(&holder.velocity);
        let base_tangent = tangent.dot(&holder.velocity);
        let closing = touch.gap / step;
        Self {
            normal_row: row(&normal),
            tangent_row: row(&tangent),
            normal_load: load(&normal),
            tangent_load: load(&tangent),
            normal_offset: holder.resistance * (base_normal - closing) - normal.dot(&holder.spring),
            tangent_offset: holder.resistance * base_tangent - tangent.dot(&holder.spring),
            base_normal,
            base_tangent,
            closing,
            resistance: holder.resistance,
            friction,
            slip_speed,
            spring: holder.spring,
            normal,
            radius,
            shift,
        }
    }

    /// The contact's answer to a motion (vx, vy, ω) at the end of the step.
    pub(crate) fn response(&self, motion: &Vector3<f64>) -> Response {
        let normal_speed = self.normal_row.dot(motion);
        let normal_force = self.normal_offset - self.resistance * normal_speed;
        if normal_force <= 0.0 {
            return Response {
                load: Vector3::zeros(),
                slope: Matrix3::zeros(),
                force: Vector2::zeros(),
                deflection_rate: -self.spring / self.resistance,
                slip: 0.0,
                slip_power: 0.0,
                torque: 0.0,
                couple_power: 0.0,
            };
        }
        let tangent_speed = self.tangent_row.dot(motion);
        let sticking_force = self.tangent_offset - self.resistance * tangent_speed;
        let side = if sticking_force < 0.0 { -1.0 } else { 1.0 };
        let coefficient = self.friction.at(side, self.slip_speed);
        let sticks = side * sticking_force <= coefficient * normal_force;
        let (tangent_force, tangent_slope) = if sticks {
            (sticking_force, self.tangent_row)
        } else {
            (side * coefficient * normal_force, side * coefficient * self.normal_row)
        };
        let tangent = perpendicular(&self.normal);
        let normal_rate = normal_speed - self.base_normal + self.closing;
        let tangent_rate = if sticks {
            tangent_speed - self.base_tangent
        } else {
            -(tangent.dot(&self.spring) + tangent_force) / self.resistance
        };
        let slip = if sticks { 0.0 } else { self.base_tangent + tangent_rate - tangent_speed };
        Response {
            load: normal_force * self.normal_load + tangent_force * self.tangent_load,
            slope: self.resistance
                * (self.normal_load * self.normal_row.transpose()
                    + self.tangent_load * tangent_slope.transpose()),
            force: normal_force * self.normal + tangent_force * tangent,
            deflection_rate: normal_rate * self.normal + tangent_rate * tangent,
            slip,
            slip_power: tangent_force * slip,
            torque: self.shift * normal_force - self.radius * tangent_force,
            couple_power: normal_force * (self.normal_load - self.normal_row).z * motion.z,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Holder, TipContact};
    use crate::dynamics::outline::Touch;
    use crate::truth::TipFriction;
    use nalgebra::{Vector2, Vector3};
    use planar::cross;
    use proptest::prelude::{prop_assert, proptest};

    fn contact(gap: f64, velocity: Vector2<f64>, spring: Vector2<f64>) -> TipContact {
        let touch =
            Touch { point: Vector2::new(-0.045, 0.01), normal: Vector2::new(1.0, 0.0), gap };
        let holder = Holder { spring, resistance: 200.0, velocity };
        TipContact::new(
            &touch,
            (&touch.point, 1e-3, 0.005),
            &holder,
            1e-3,
            TipFriction::default(),
            0.0,
        )
    }

    #[test]
    fn a_tip_that_does_not_arrive_within_the_step_exerts_no_force() {
        let response =
            contact(1e-4, Vector2::new(0.05, 0.0), Vector2::zeros()).response(&Vector3::zeros());
        assert_eq!(response.force, Vector2::zeros());
        let response =
            contact(1e-4, Vector2::new(0.2, 0.0), Vector2::zeros()).response(&Vector3::zeros());
        assert!((response.force - Vector2::new(20.0, 0.0)).norm() < 1e-12);
    }

    proptest! {
        #[test]
        fn the_force_is_in_the_cone_and_balances_the_tip_and_slip_dissipates(
            base in (-0.1..0.1f64, -0.1..0.1f64), v in (-0.1..0.1f64, -0.1..0.1f64, -1.0..1.0f64),
            spring in (-2.0..2.0f64, -2.0..2.0f64),
        ) {
            let spring = Vector2::new(spring.0, spring.1);
            let contact = contact(0.0, Vector2::new(base.0, base.1), spring);
            let motion = Vector3::new(v.0, v.1, v.2);
            let response = contact.response(&motion);
            let force = response.force;
            prop_assert!(force.x >= 0.0 && force.y.abs() <= 0.25 * force.x + 1e-12);
            let balance = force + spring + 200.0 * response.deflection_rate;
            prop_assert!(balance.norm() < 1e-9 || force == Vector2::zeros());
            prop_assert!(response.slip * force.y >= -1e-12);
            // The force acts 5 mm before the tip's axis and 1 mm to the left of it.
            let arm = Vector2::new(0.005, 0.001);
            prop_assert!((response.torque + cross(&arm, &force)).abs() < 1e-12);
            for k in 0..3 {
                let mut step = Vector3::zeros();
                step[k] = 1e-9;
                let (a, b) = (contact.response(&(motion - step)), contact.response(&(motion + step)));
                let slope = (a.load - b.load) / 2e-9;
                prop_assert!((slope - response.slope.column(k)).amax() < 1e-3);
            }
        }
    }
}
