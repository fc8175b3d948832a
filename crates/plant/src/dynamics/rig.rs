//! The rig during one push.

use libm::sqrt;
use nalgebra::{Vector2, Vector3};
use planar::Pose;

use crate::dynamics::ground::Footprint;
use crate::dynamics::resistance::Footing;
use crate::dynamics::state::{State, rotation};
use crate::truth::TipFriction;
use crate::{Plant, PlantError, TipPath, Variation};

/// A footprint is that of the object until it has moved so far, in m, or is pushed so much more or
/// less, over its weight.
const MOVED: f64 = 5e-5;
const PUSHED: f64 = 0.01;

/// A plant, a path and the variation of one push.
pub(crate) struct Rig<'a> {
    pub(crate) plant: &'a Plant,
    pub(crate) path: &'a TipPath,
    pub(crate) footing: Footing,
    /// Load of each pad, in N, and its largest friction on the plain table, in N.
    pub(crate) loads: Vec<f64>,
    pub(crate) frictions: Vec<f64>,
    pub(crate) tip_friction: TipFriction,
    pub(crate) contact_shift: f64,
    pub(crate) stiffness: f64,
    pub(crate) damping: f64,
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

    /// What the ground does to the pads in a state, from what it did a little before.
    ///
    /// # Errors
    /// If the object tips over.
    pub(crate) fn footprint(
        &self,
        state: &State,
        last: Option<&Footprint>,
    ) -> Result<Option<Footprint>, &'static str> {
        let ground = &self.plant.ground;
        if ground.is_even() {
            return Ok(None);
        }
        let turn = rotation(state.place.z);
        let place = |index: usize| state.place.xy() + turn * self.footing.place(index);
        let places: Vec<_> = (0..self.loads.len()).map(place).collect();
        ground.footprint(&places, state, last).map(Some)
    }

    /// Whether a footprint is no longer that of a state.
    pub(crate) fn has_left(&self, footprint: &Footprint, state: &State) -> bool {
        let moved = state.place - footprint.place;
        let turned = self.radius() * moved.z;
        let squared = moved.x * moved.x + moved.y * moved.y + turned * turned;
        let pushed = state.rubbed - footprint.rubbed;
        let felt = PUSHED * self.plant.mass * self.plant.gravity;
        squared > MOVED * MOVED || pushed.dot(&pushed) > felt * felt
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
}
