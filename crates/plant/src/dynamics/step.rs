//! One implicit step of the rig's motion.

use libm::sqrt;
use nalgebra::{Matrix2, Vector3};

use crate::dynamics::balance::{Balance, Solved};
use crate::dynamics::ground::Footprint;
use crate::dynamics::rig::Rig;
use crate::dynamics::state::{State, rotation};
use crate::dynamics::surroundings::Surroundings;
use crate::dynamics::tip_contact::{Holder, TipContact};

/// Force left over after Newton's method, as a share of the object's weight.
const RESIDUAL: f64 = 1e-9;

impl Rig<'_> {
    /// One step of the implicit Euler method, of first order in its length (s).
    ///
    /// Friction and contact belong to the motion at the end of the step, directions and places to
    /// its beginning. The motion is found by Newton's method with an analytic derivative.
    ///
    /// # Errors
    /// What did not converge; a shorter step may.
    pub(crate) fn step(
        &self,
        time: f64,
        step: f64,
        state: &State,
        footprint: Option<&Footprint>,
    ) -> Result<State, &'static str> {
        let turn = rotation(state.place.z);
        let to_body = turn.transpose();
        let plant = self.plant;
        let surroundings = Surroundings::of(self, state, &turn, footprint);
        let balance = Balance {
            footing: &self.footing,
            frictions: surroundings.frictions.as_deref().unwrap_or(&self.frictions),
            metric: self.metric(state.place.z),
            creep: plant.numerics.creep,
            rate: &plant.truth.support_friction.rate,
            contact: self.contact(time, step, state, &to_body),
            external: surroundings.external,
            start: in_axes(&to_body, &state.motion),
            inertia: Vector3::new(plant.mass, plant.mass, plant.moment_of_inertia) / step,
            arm: self.radius(),
            goal: RESIDUAL * plant.mass * plant.gravity,
        };
        let solved = if balance.rests() { balance.resting() } else { balance.solve()? };
        let mut next = self.advanced(step, state, &turn, &solved);
        let base_way = self.path.position(time + step) - self.path.position(time);
        next.energy.pusher_work += next.force.dot(&base_way);
        next.energy.external_work +=
            step * (surroundings.external.dot(&solved.motion) + solved.response.couple_power);
        Ok(next)
    }

    /// The contact during a step, in the body's axes.
    fn contact(&self, time: f64, step: f64, state: &State, to_body: &Matrix2<f64>) -> TipContact {
        let plant = self.plant;
        let hysteresis = &plant.truth.tip.hysteresis;
        let (here, there) = (self.path.position(time), self.path.position(time + step));
        let center_b =
            to_body * (here + state.deflection - state.place.xy()) + plant.center_of_mass;
        let touch = plant.outline.touch(&center_b, plant.truth.tip.radius);
        let arm = touch.point - plant.center_of_mass;
        let second = hysteresis.stiffness * (state.deflection - state.grip);
        let holder = Holder {
            spring: to_body * (self.stiffness * state.deflection + second),
            resistance: self.damping + step * (self.stiffness + hysteresis.stiffness),
            velocity: to_body * ((there - here) / step),
        };
        let place = (&arm, self.contact_shift, plant.truth.tip.radius);
        let mut friction = self.tip_friction;
        friction.coefficient = plant.ground.tip_friction(friction.coefficient, &touch.point);
        TipContact::new(&touch, place, &holder, step, friction, state.slip_speed)
    }

    /// G of the table's and the body's grain together, in the body's axes.
    fn metric(&self, turn: f64) -> Matrix2<f64> {
        let truth = &self.plant.truth;
        let table = truth.table_grain.root_metric(-turn);
        let body = truth.body_grain.root_metric(0.0);
        table * (body * body) * table
    }

    /// The state after a step whose motion is known.
    fn advanced(&self, step: f64, state: &State, turn: &Matrix2<f64>, solved: &Solved) -> State {
        let (plant, response) = (self.plant, &solved.response);
        let hysteresis = &plant.truth.tip.hysteresis;
        let mut next = *state;
        next.motion = in_axes(turn, &solved.motion);
        next.place += step * next.motion;
        next.force = turn * response.force;
        next.rubbed = turn * solved.support.xy();
        next.impulse += step * next.force;
        next.twisting += step * response.torque;
        next.slip_speed = response.slip.abs();
        let rate = turn * response.deflection_rate;
        next.deflection += step * rate;
        let energy = &mut next.energy;
        let held = hysteresis.stiffness * (next.deflection - next.grip);
        let held_size = sqrt(held.dot(&held));
        if held_size > hysteresis.yield_force {
            let share = hysteresis.yield_force / held_size;
            let slip = (1.0 - share) * (next.deflection - next.grip);
            energy.tip_heat += share * held.dot(&slip);
            next.grip += slip;
        }
        energy.support_heat += step * solved.support.dot(&solved.motion);
        if solved.motion == Vector3::zeros() {
            // What is left of the motion of an object that comes to rest.
            energy.support_heat += energy.kinetic;
        }
        energy.slip_heat += step * response.slip_power;
        energy.tip_heat += step * self.damping * rate.dot(&rate);
        let v = &next.motion;
        energy.kinetic =
            0.5 * plant.mass * (v.x * v.x + v.y * v.y) + 0.5 * plant.moment_of_inertia * v.z * v.z;
        let second = next.deflection - next.grip;
        energy.elastic = 0.5 * self.stiffness * next.deflection.dot(&next.deflection)
            + 0.5 * hysteresis.stiffness * second.dot(&second);
        next
    }
}

/// A motion in other axes.
fn in_axes(turn: &Matrix2<f64>, motion: &Vector3<f64>) -> Vector3<f64> {
    let linear = turn * motion.xy();
    Vector3::new(linear.x, linear.y, motion.z)
}
