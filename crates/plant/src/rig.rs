//! The rig during one push, and one implicit step of its motion.

use libm::{sincos, sqrt};
use nalgebra::{Matrix2, Vector2, Vector3};
use planar::Pose;

use crate::balance::{Balance, Solved};
use crate::resistance::Footing;
use crate::state::State;
use crate::surroundings::Surroundings;
use crate::tip_contact::{Holder, TipContact};
use crate::truth::TipFriction;
use crate::{Plant, PlantError, TipPath, Variation};

/// Force left over after Newton's method, as a share of the object's weight.
const RESIDUAL: f64 = 1e-9;

/// A plant, a path and the variation of one push.
pub(crate) struct Rig<'a> {
    pub(crate) plant: &'a Plant,
    pub(crate) path: &'a TipPath,
    pub(crate) footing: Footing,
    /// Load of each pad, in N, and its largest friction on the plain table, in N.
    pub(crate) loads: Vec<f64>,
    pub(crate) frictions: Vec<f64>,
    tip_friction: TipFriction,
    contact_shift: f64,
    stiffness: f64,
    damping: f64,
    /// Center of the load, in m, from the center of mass.
    pub(crate) load_center: Vector2<f64>,
}

impl<'a> Rig<'a> {
    pub(crate) fn new(
        plant: &'a Plant,
        path: &'a TipPath,
        variation: &Variation,
    ) -> Result<Self, PlantError> {
        let truth = &plant.truth;
        let pads = plant.pads(variation)?;
        let weight = plant.mass * plant.gravity;
        let loads: Vec<_> = pads.share.iter().map(|share| share * weight).collect();
        let coefficient = truth.support_friction.coefficient * variation.support_friction;
        let stiffness = 1.0 / truth.tip.compliance;
        Ok(Self {
            plant,
            path,
            footing: Footing::new(&pads, &plant.center_of_mass),
            frictions: loads.iter().map(|load| coefficient * load).collect(),
            loads,
            tip_friction: TipFriction {
                coefficient: truth.tip_friction.coefficient * variation.tip_friction,
                ..truth.tip_friction
            },
            contact_shift: truth.tip.bias + variation.contact_shift,
            stiffness,
            damping: 2.0 * truth.tip.damping_ratio * sqrt(stiffness * plant.mass),
            load_center: pads.center() - plant.center_of_mass,
        })
    }

    /// The object at rest before the push.
    pub(crate) fn start(&self, pose_wb: &Pose) -> Result<State, PlantError> {
        let turn = rotation(pose_wb.angle);
        let center = pose_wb.position + turn * self.plant.center_of_mass;
        let state = State::at_rest(Vector3::new(center.x, center.y, pose_wb.angle));
        let gap = self.gap(&state, &self.path.position(0.0));
        if gap.is_finite() && gap >= 0.0 {
            return Ok(state);
        }
        Err(PlantError::Blocked { depth: -gap })
    }

    /// Distance of a tip from the object, in m.
    fn gap(&self, state: &State, tip_w: &Vector2<f64>) -> f64 {
        let to_body = rotation(state.place.z).transpose();
        let center_b = to_body * (tip_w - state.place.xy()) + self.plant.center_of_mass;
        self.plant.outline.touch(&center_b, self.plant.truth.tip.radius).gap
    }

    /// Pose of the body frame.
    pub(crate) fn pose(&self, place: &Vector3<f64>) -> Pose {
        let origin = place.xy() - rotation(place.z) * self.plant.center_of_mass;
        Pose::new(origin.x, origin.y, place.z)
    }

    /// A length that makes turns comparable to displacements, in m.
    pub(crate) fn radius(&self) -> f64 {
        self.plant.radius
    }

    /// Time in which the object swings through a radian on the tip's spring, in s.
    pub(crate) fn swing_time(&self) -> f64 {
        sqrt(self.plant.mass / self.stiffness)
    }

    /// One step of the implicit Euler method, of first order in its length (s).
    ///
    /// Friction and contact belong to the motion at the end of the step, directions and places to
    /// its beginning. The motion is found by Newton's method with an analytic derivative.
    ///
    /// # Errors
    /// What did not converge; a shorter step may.
    pub(crate) fn step(&self, time: f64, step: f64, state: &State) -> Result<State, &'static str> {
        let turn = rotation(state.place.z);
        let to_body = turn.transpose();
        let plant = self.plant;
        let surroundings = Surroundings::of(self, state, &turn);
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
        TipContact::new(&touch, place, &holder, step, self.tip_friction, state.slip_speed)
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

/// From the axes of a frame turned by an angle (rad) to the outer ones.
pub(crate) fn rotation(angle: f64) -> Matrix2<f64> {
    let (sin, cos) = sincos(angle);
    Matrix2::new(cos, -sin, sin, cos)
}
