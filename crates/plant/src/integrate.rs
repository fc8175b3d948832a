//! Time stepping: the implicit Euler method, extrapolated, with steps as long as its error allows.

use libm::sqrt;

use crate::rig::Rig;
use crate::state::State;
use crate::{PlantError, Trajectory};

const FIRST_STEP: f64 = 1e-3;
const SHORTEST_STEP: f64 = 1e-9;
const MOST_STEPS: usize = 400_000;

/// Follows the rig from a state to the end of its path.
///
/// Each step is taken whole and in two halves. Their difference decides whether it is short enough;
/// their extrapolation, of second order, is the result. Steps end where the path's acceleration
/// jumps.
pub(crate) fn integrate(rig: &Rig, start: &State) -> Result<Trajectory, PlantError> {
    let numerics = &rig.plant.numerics;
    let mut trajectory = Trajectory::new(rig, start);
    let (mut state, mut time, mut trial) = (*start, 0.0, FIRST_STEP);
    for end in rig.path.breaks() {
        while time < end {
            let left = end - time;
            let step = trial.min(numerics.longest_step).min(left);
            // A rest that is hardly a step is not left for the next one.
            let step = if left - step < 0.1 * step { left } else { step };
            match taken(rig, time, step, &state) {
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
fn taken(rig: &Rig, time: f64, step: f64, state: &State) -> Result<(State, f64), &'static str> {
    let half = 0.5 * step;
    let whole = rig.step(time, step, state)?;
    let halves = rig.step(time + half, half, &rig.step(time, half, state)?)?;
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
