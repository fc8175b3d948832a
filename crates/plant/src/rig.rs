//! The rig during one push, and one implicit step of its motion.

use libm::{sincos, sqrt};
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
use planar::{Pose, cross};

use crate::resistance::Footing;
use crate::state::State;
use crate::tip_contact::{Holder, Response, TipContact};
use crate::truth::TipFriction;
use crate::{Plant, PlantError, TipPath, Variation};

const MAX_ITERATIONS: usize = 40;
const MAX_HALVINGS: usize = 14;
/// Force left over after Newton's method, as a share of the object's weight.
const RESIDUAL: f64 = 1e-9;

/// A plant, a path and the variation of one push.
pub(crate) struct Rig<'a> {
    pub(crate) plant: &'a Plant,
    pub(crate) path: &'a TipPath,
    footing: Footing,
    /// Load of each pad, in N, and its largest friction on the plain table, in N.
    loads: Vec<f64>,
    frictions: Vec<f64>,
    tip_friction: TipFriction,
    contact_shift: f64,
    stiffness: f64,
    damping: f64,
    /// Center of the load, in m, from the center of mass.
    load_center: Vector2<f64>,
}

/// The motion at the end of a step, in the body's axes, and what goes with it.
struct Solution {
    motion: Vector3<f64>,
    response: Response,
    /// Heat under the object and work of the surroundings over the step, in J.
    support_heat: f64,
    external_work: f64,
}

/// Forces at the beginning of a step that do not depend on the motion, in the body's axes.
struct Surroundings {
    /// Largest friction of each pad, in N; none if it is that of the plain table.
    frictions: Option<Vec<f64>>,
    /// Force and moment about the center of mass, in N and N·m.
    external: Vector3<f64>,
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
        let surroundings = self.surroundings(state, &turn);
        let metric = self.metric(state.place.z);
        let contact = self.contact(time, step, state, &to_body);
        let start = in_axes(&to_body, &state.motion);
        let plant = self.plant;
        let mass = Vector3::new(plant.mass, plant.mass, plant.moment_of_inertia) / step;
        let frictions = surroundings.frictions.as_deref().unwrap_or(&self.frictions);
        let rate = &plant.truth.support_friction.rate;
        let balance = |motion: &Vector3<f64>| {
            let support =
                self.footing.resistance(frictions, motion, &metric, plant.numerics.creep, rate);
            let response = contact.response(motion);
            let left_over = mass.component_mul(&(motion - start)) + support.load
                - response.load
                - surroundings.external;
            (left_over, support, response)
        };
        let size = |left_over: &Vector3<f64>| {
            let arm = left_over.z / self.radius();
            sqrt(left_over.x * left_over.x + left_over.y * left_over.y + arm * arm)
        };
        let goal = RESIDUAL * plant.mass * plant.gravity;
        let mut motion = start;
        let mut now = balance(&motion);
        for _ in 0..MAX_ITERATIONS {
            let error = size(&now.0);
            if error <= goal {
                let (_, support, response) = now;
                let support_heat = step * support.load.dot(&motion);
                let external_work = step * surroundings.external.dot(&motion);
                let solution = Solution { motion, response, support_heat, external_work };
                return Ok(self.advance(time, step, state, &turn, &solution));
            }
            let slope = Matrix3::from_diagonal(&mass) + now.1.slope + now.2.slope;
            let inverse = slope.try_inverse().ok_or("a singular balance of forces")?;
            let direction = inverse * now.0;
            let mut share = 1.0;
            let mut halvings = 0;
            now = loop {
                let trial = motion - share * direction;
                let candidate = balance(&trial);
                if size(&candidate.0) < (1.0 - 1e-4 * share) * error {
                    motion = trial;
                    break candidate;
                }
                share *= 0.5;
                halvings += 1;
                if halvings > MAX_HALVINGS {
                    return Err("the balance of forces does not get better");
                }
            };
        }
        Err("the balance of forces takes too many iterations")
    }

    /// The contact during a step, in the body's axes.
    fn contact(&self, time: f64, step: f64, state: &State, to_body: &Matrix2<f64>) -> TipContact {
        let plant = self.plant;
        let hysteresis = &plant.truth.tip.hysteresis;
        let (here, there) = (self.path.position(time), self.path.position(time + step));
        let center_b =
            to_body * (here + state.deflection - state.place.xy()) + plant.center_of_mass;
        let touch = plant.outline.touch(&center_b, plant.truth.tip.radius);
        let tangent = planar::perpendicular(&touch.normal);
        let arm = touch.point + self.contact_shift * tangent - plant.center_of_mass;
        let second = hysteresis.stiffness * (state.deflection - state.grip);
        let holder = Holder {
            spring: to_body * (self.stiffness * state.deflection + second),
            resistance: self.damping + step * (self.stiffness + hysteresis.stiffness),
            velocity: to_body * ((there - here) / step),
        };
        TipContact::new(&touch, &arm, &holder, step, self.tip_friction, state.slip_speed)
    }

    /// G of the table's and the body's grain together, in the body's axes.
    fn metric(&self, turn: f64) -> Matrix2<f64> {
        let truth = &self.plant.truth;
        let table = truth.table_grain.root_metric(-turn);
        let body = truth.body_grain.root_metric(0.0);
        table * (body * body) * table
    }

    fn surroundings(&self, state: &State, turn: &Matrix2<f64>) -> Surroundings {
        let truth = &self.plant.truth;
        let to_body = turn.transpose();
        let center_w = state.place.xy();
        let mut external = Vector3::zeros();
        let downhill = self.plant.mass * (to_body * Vector2::from(truth.height_map.downhill));
        external += Vector3::new(downhill.x, downhill.y, 0.0);
        if !truth.cable.is_off() {
            let arm = Vector2::from(truth.cable.attachment) - self.plant.center_of_mass;
            let pull = to_body * truth.cable.pull(&(center_w + turn * arm));
            external += Vector3::new(pull.x, pull.y, cross(&arm, &pull));
        }
        let (map, groove, magnet) = (&truth.friction_map, &truth.height_map.groove, &truth.magnet);
        let wobbles = truth.wobble.share != 0.0;
        if map.is_off() && groove.is_off() && magnet.pull == 0.0 && !wobbles {
            return Surroundings { frictions: None, external };
        }
        let lean = truth.wobble.slope(&(to_body * state.force)) / self.radius();
        let weight = self.plant.mass * self.plant.gravity;
        let mut frictions = self.frictions.clone();
        for (index, friction) in frictions.iter_mut().enumerate() {
            let arm = self.footing.place(index);
            let place_w = center_w + turn * arm;
            *friction *= map.factor(&place_w);
            if wobbles {
                *friction *= (1.0 + lean.dot(&(arm - self.load_center))).max(0.0);
            }
            if !groove.is_off() {
                let (slope_w, factor) = groove.at(&place_w);
                let force = -self.loads[index] * (to_body * slope_w);
                external += Vector3::new(force.x, force.y, cross(&arm, &force));
                *friction *= factor;
            }
            if magnet.pull != 0.0 {
                let (down, side_w) = magnet.pulls(&place_w);
                let side = self.loads[index] / weight * (to_body * side_w);
                external += Vector3::new(side.x, side.y, cross(&arm, &side));
                *friction *= 1.0 + down / weight;
            }
        }
        Surroundings { frictions: Some(frictions), external }
    }

    /// The state after a step whose motion is known.
    fn advance(
        &self,
        time: f64,
        step: f64,
        state: &State,
        turn: &Matrix2<f64>,
        solution: &Solution,
    ) -> State {
        let response = &solution.response;
        let mut next = *state;
        next.motion = in_axes(turn, &solution.motion);
        next.place += step * next.motion;
        next.force = turn * response.force;
        next.impulse += step * next.force;
        next.slip_speed = response.slip.abs();
        let rate = turn * response.deflection_rate;
        next.deflection += step * rate;
        let plant = self.plant;
        let hysteresis = &plant.truth.tip.hysteresis;
        let held = hysteresis.stiffness * (next.deflection - next.grip);
        let held_size = sqrt(held.dot(&held));
        let energy = &mut next.energy;
        if held_size > hysteresis.yield_force {
            let share = hysteresis.yield_force / held_size;
            let slip = (1.0 - share) * (next.deflection - next.grip);
            energy.tip_heat += share * held.dot(&slip);
            next.grip += slip;
        }
        let base_way = self.path.position(time + step) - self.path.position(time);
        energy.pusher_work += next.force.dot(&base_way);
        energy.external_work += solution.external_work;
        energy.support_heat += solution.support_heat;
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
