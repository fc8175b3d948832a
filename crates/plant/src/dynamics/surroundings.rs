//! What acts on the object besides the tip, and how the table is where it stands.

use nalgebra::{Matrix2, Vector2, Vector3};
use planar::cross;

use crate::dynamics::ground::Footprint;
use crate::dynamics::rig::Rig;
use crate::dynamics::state::State;

/// Loads and frictions at the beginning of a step, in the body's axes.
pub(crate) struct Surroundings {
    /// Largest friction of each pad, in N; none if it is that of the plain table.
    pub(crate) frictions: Option<Vec<f64>>,
    /// Force and moment about the center of mass, in N and N·m.
    pub(crate) external: Vector3<f64>,
}

impl Surroundings {
    /// - `turn`: from the body's axes to the world's.
    pub(crate) fn of(
        rig: &Rig,
        state: &State,
        turn: &Matrix2<f64>,
        footprint: Option<&Footprint>,
    ) -> Self {
        let (plant, truth) = (rig.plant, &rig.plant.truth);
        let to_body = turn.transpose();
        let downhill = plant.mass * (to_body * Vector2::from(truth.height_map.downhill));
        let mut external = Vector3::new(downhill.x, downhill.y, 0.0);
        if !truth.cable.is_off() {
            let arm = Vector2::from(truth.cable.attachment) - plant.center_of_mass;
            let pull = truth.cable.pull(&(state.place.xy() + turn * arm));
            external += load(&(to_body * pull), &arm);
        }
        let is_plain = footprint.is_none()
            && truth.friction_map.is_off()
            && truth.height_map.groove.is_off()
            && truth.magnet.pull == 0.0
            && truth.wobble.share == 0.0;
        let frictions = (!is_plain).then(|| {
            let lean = truth.wobble.slope(&(to_body * state.force)) / rig.radius();
            let mut frictions = rig.frictions.clone();
            for (index, friction) in frictions.iter_mut().enumerate() {
                let arm = rig.footing.place(index);
                let (load_ratio, rub_ratio) = footprint
                    .map_or((1.0, 1.0), |print| (print.loads[index], print.frictions[index]));
                let pad_load = load_ratio * rig.loads[index];
                let place_w = state.place.xy() + turn * arm;
                let (factor, force_w) = at_pad(rig, pad_load, &place_w);
                let leaning = (1.0 + lean.dot(&(arm - rig.load_center))).max(0.0);
                *friction *= rub_ratio * factor * leaning;
                external += load(&(to_body * force_w), &arm);
            }
            frictions
        });
        Self { frictions, external }
    }
}

/// Factor on a pad's friction, and force on it (N, world frame), by its load (N) and where it stands
/// (m).
fn at_pad(rig: &Rig, pad_load: f64, place_w: &Vector2<f64>) -> (f64, Vector2<f64>) {
    let truth = &rig.plant.truth;
    let mut factor = truth.friction_map.factor(place_w);
    let mut force_w = Vector2::zeros();
    if !truth.height_map.groove.is_off() {
        let (slope_w, polish) = truth.height_map.groove.at(place_w);
        force_w -= pad_load * slope_w;
        factor *= polish;
    }
    if truth.magnet.pull != 0.0 {
        let weight = rig.plant.mass * rig.plant.gravity;
        let (down, side_w) = truth.magnet.pulls(place_w);
        force_w += pad_load / weight * side_w;
        factor *= 1.0 + down / weight;
    }
    (factor, force_w)
}

fn load(force: &Vector2<f64>, arm: &Vector2<f64>) -> Vector3<f64> {
    Vector3::new(force.x, force.y, cross(arm, force))
}
