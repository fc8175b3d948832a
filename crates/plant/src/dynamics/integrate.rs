//! Time stepping: the implicit Euler method, extrapolated, with steps as long as its error allows.

use libm::sqrt;
use nalgebra::Vector2;
use planar::Pose;

use crate::dynamics::ground::Footprint;
use crate::dynamics::rig::Rig;
use crate::dynamics::state::State;
use crate::{Plant, PlantError, TipPath, Trajectory, Variation};

const FIRST_STEP: f64 = 1e-3;
const SHORTEST_STEP: f64 = 1e-9;
const MOST_STEPS: usize = 400_000;

impl Plant {
    /// Simulates one push: wait, approach, push, stop and hold.
    ///
    /// - `pose_wb`: the object at rest at the beginning.
    ///
    /// # Errors
    /// `Blocked` if the tip begins inside the object, `OutOfRange` for a path without length or
    /// speed, `Pressure` for a variation that cannot be, `NotConverged` if steps get too short.
    pub fn push(
        &self,
        pose_wb: &Pose,
        path: &TipPath,
        variation: &Variation,
    ) -> Result<Trajectory, PlantError> {
        check_path(path)?;
        let rig = Rig::new(self, path, variation)?;
        integrate(&rig, &rig.start(pose_wb)?)
    }
}

/// Follows the rig from a state to the end of its path.
///
/// Each step is taken whole and in two halves. Their difference decides whether it is short enough;
/// their extrapolation, of second order, is the result. Steps end where the path's acceleration
/// jumps.
fn integrate(rig: &Rig, start: &State) -> Result<Trajectory, PlantError> {
    let numerics = &rig.plant.numerics;
    let mut trajectory =
        Trajectory::new(rig.path, rig.pose(&start.place), rig.plant.center_of_mass, start);
    let (mut state, mut time, mut trial) = (*start, 0.0, FIRST_STEP);
    let not_stable = |why| PlantError::NotConverged { time: 0.0, step: 0.0, why };
    let mut footprint = rig.footprint(&state, None).map_err(not_stable)?;
    for end in rig.path.breaks() {
        while time < end {
            let left = end - time;
            let step = trial.min(numerics.longest_step).min(left);
            // A rest that is hardly a step is not left for the next one.
            let step = if left - step < 0.1 * step { left } else { step };
            match taken(rig, time, step, &state, footprint.as_ref()) {
                Ok((next, error)) => {
                    let ratio = error / numerics.tolerance;
                    let growth = (0.9 / sqrt(ratio.max(1e-6))).clamp(0.1, 4.0);
                    trial = step * growth;
                    if ratio > 1.0 && step > SHORTEST_STEP {
                        continue;
                    }
                    state = next;
                    time = if step == left { end } else { time + step };
                    trajectory.record(time, &state);
                    let last = footprint.as_ref();
                    if let Some(last) = last.filter(|last| rig.has_left(last, &state)) {
                        let way = (state.place - last.place).xy();
                        let friction = last.mean_friction(&rig.loads);
                        trajectory.record_friction(sqrt(way.dot(&way)), friction);
                        footprint = rig
                            .footprint(&state, Some(last))
                            .map_err(|why| PlantError::NotConverged { time, step, why })?;
                    }
                    if trajectory.n_steps() > MOST_STEPS {
                        let why = "the push takes too many steps";
                        return Err(PlantError::NotConverged { time, step, why });
                    }
                }
                Err(why) if step <= SHORTEST_STEP => {
                    return Err(PlantError::NotConverged { time, step, why });
                }
                Err(_) => trial = 0.2 * step,
            }
        }
    }
    Ok(trajectory)
}

/// The state after a step, and the difference of the whole step from two halves, in m.
fn taken(
    rig: &Rig,
    time: f64,
    step: f64,
    state: &State,
    footprint: Option<&Footprint>,
) -> Result<(State, f64), &'static str> {
    let half = 0.5 * step;
    let whole = rig.step(time, step, state, footprint)?;
    let first = rig.step(time, half, state, footprint)?;
    let halves = rig.step(time + half, half, &first, footprint)?;
    let moved = halves.place - whole.place;
    let turned = rig.radius() * moved.z;
    let bent = halves.deflection - whole.deflection;
    let sped = rig.swing_time() * (halves.motion - whole.motion);
    let spun = rig.radius() * sped.z;
    let squared = moved.x * moved.x + moved.y * moved.y + turned * turned + bent.dot(&bent);
    let error = sqrt(squared + sped.x * sped.x + sped.y * sped.y + spun * spun);
    if !error.is_finite() {
        return Err("the motion is not finite");
    }
    Ok((halves.extrapolated(&whole), error))
}

fn check_path(path: &TipPath) -> Result<(), PlantError> {
    let positive = [
        ("the length of the path", path.length, "m"),
        ("its speed", path.speed, "m/s"),
        ("its acceleration", path.acceleration, "m/s²"),
        ("its wait plus 1", path.wait + 1.0, "s"),
        ("its hold plus 1", path.hold + 1.0, "s"),
    ];
    for (name, value, unit) in positive {
        if !(value > 0.0 && value.is_finite()) {
            let (name, allowed) = (name.into(), "a positive, finite number".into());
            return Err(PlantError::OutOfRange { name, value, unit, allowed });
        }
    }
    let direction = Vector2::from(path.direction).norm();
    if !((direction - 1.0).abs() < 1e-9 && path.start.iter().all(|x| x.is_finite())) {
        return Err(PlantError::OutOfRange {
            name: "the length of the path's direction".into(),
            value: direction,
            unit: "",
            allowed: "1, and a finite start".into(),
        });
    }
    Ok(())
}
