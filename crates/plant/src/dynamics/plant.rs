//! The rig, ready to be pushed.

use dataset::ObjectSpec;
use nalgebra::Vector2;
use planar::Shape;

use crate::dynamics::ground::Ground;
use crate::dynamics::outline::Outline;
use crate::dynamics::pads::Pads;
use crate::{Numerics, PlantError, Truth, Variation};

const FEWEST_PADS: usize = 100;

/// A simulated rig: an object on a table, and a tip on a robot that pushes it.
///
/// Rigid-body dynamics in the plane with Coulomb friction under at least a hundred pads, and a
/// round, elastic tip in hard Coulomb contact. Nothing in it is quasi-static, and it shares no
/// formula with the models that it tests.
#[derive(Clone, Debug)]
pub struct Plant {
    pub(crate) mass: f64,
    pub(crate) moment_of_inertia: f64,
    pub(crate) center_of_mass: Vector2<f64>,
    /// Distance of the farthest point of the outline from the body's origin, in m.
    pub(crate) radius: f64,
    pub(crate) gravity: f64,
    pub(crate) outline: Outline,
    pub(crate) truth: Truth,
    pub(crate) numerics: Numerics,
    pub(crate) ground: Ground,
    shape: Shape,
    uniform: Pads,
}

impl Plant {
    /// A rig for an object with its nominal mass and outline, and what is true of it.
    ///
    /// - `gravity`: in m/s².
    ///
    /// # Errors
    /// `OutOfRange` for a number that is not possible, `Wear` for wear that the outline has no
    /// room for, `Pressure` for a load that cannot be spread so,
    /// `Feet` for feet that cannot balance the object.
    pub fn new(
        object: &ObjectSpec,
        truth: &Truth,
        gravity: f64,
        numerics: &Numerics,
    ) -> Result<Self, PlantError> {
        truth.check()?;
        if numerics.n_pads < FEWEST_PADS {
            return Err(PlantError::OutOfRange {
                name: "n_pads".into(),
                value: numerics.n_pads as f64,
                unit: "(a number)",
                allowed: format!("{FEWEST_PADS} or more"),
            });
        }
        for (name, value, unit) in [
            ("tolerance", numerics.tolerance, "m"),
            ("longest_step", numerics.longest_step, "s"),
            ("creep", numerics.creep, "m/s"),
            ("gravity", gravity, "m/s²"),
            ("the object's mass", object.mass, "kg"),
            ("its moment of inertia", object.moment_of_inertia, "kg·m²"),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                let (name, allowed) = (name.into(), "a positive, finite number".into());
                return Err(PlantError::OutOfRange { name, value, unit, allowed });
            }
        }
        let mass = object.mass * truth.body.mass_ratio;
        let center_of_mass = object.center_of_mass + Vector2::from(truth.body.center_shift);
        let uniform = Pads::uniform(&object.shape, numerics.n_pads);
        let plant = Self {
            mass,
            moment_of_inertia: object.moment_of_inertia * truth.body.mass_ratio,
            center_of_mass,
            radius: object.shape.bounding_radius(),
            gravity,
            outline: Outline::new(&object.shape, &truth.wear)?,
            truth: truth.clone(),
            numerics: *numerics,
            ground: Ground::new(truth, &object.shape, &uniform, &center_of_mass, mass * gravity),
            shape: object.shape.clone(),
            uniform,
        };
        plant.pads(&Variation::default())?;
        Ok(plant)
    }

    /// What is true of the rig.
    #[must_use]
    pub fn truth(&self) -> &Truth {
        &self.truth
    }

    /// The pads of a push.
    pub(crate) fn pads(&self, variation: &Variation) -> Result<Pads, PlantError> {
        let pressure = &self.truth.pressure;
        let shift = Vector2::from(pressure.center_shift) + Vector2::from(variation.pressure_shift);
        let ratio = pressure.radius_ratio * variation.pressure_radius;
        let area = self.uniform.rimmed(&self.shape, pressure.rim_share).reshaped(&shift, ratio)?;
        let feet = (&pressure.feet, &self.shape);
        let stood = area.on_feet(feet, &self.center_of_mass, (&shift, ratio))?;
        Ok(stood.blended(pressure.patch_share))
    }
}
