//! The nominal set-up without any effect.

use std::sync::Arc;

use mechanics::LimitSurface;
use planar::Twist;

use crate::EffectError;
use crate::error::{not_negative, positive};

/// The base model: nominal friction, gravity and the kind of limit surface.
#[derive(Clone, Debug)]
pub struct Rig {
    surface: Surface,
    pusher_friction: f64,
    support_friction: f64,
    gravity: f64,
    longest_substep: f64,
    /// Largest force along x of a given surface, in N.
    given_force: f64,
}

/// The limit surface that a model starts from.
#[derive(Clone, Debug)]
pub enum Surface {
    /// The ellipsoid about the centroid with c of uniform pressure.
    Ellipsoid,
    /// The exact surface of uniform pressure, from a table: steps of 4 mm differ by less than 1 µm.
    UniformPatch,
    /// Any other surface, in the frame of the outline, in N and N·m for the nominal friction.
    Given(Arc<dyn LimitSurface>),
}

impl Rig {
    /// A rig with the coefficients of friction of pusher and support, standard gravity, and
    /// sub-steps of at most 1 mm of the pusher's way, twice that with inertia.
    ///
    /// # Errors
    /// `InvalidValue` if the pusher's friction is negative or the support's not positive; what a
    /// given surface refuses.
    pub fn new(
        surface: Surface,
        pusher_friction: f64,
        support_friction: f64,
    ) -> Result<Self, EffectError> {
        not_negative("the pusher's friction", pusher_friction, "(dimensionless)")?;
        positive("the support's friction", support_friction, "(dimensionless)")?;
        let (gravity, longest_substep) = (9.81, 1e-3);
        let given_force = match &surface {
            Surface::Given(given) => given.wrench(&Twist::new(1.0, 0.0, 0.0))?.force.norm(),
            Surface::Ellipsoid | Surface::UniformPatch => 0.0,
        };
        Ok(Self {
            surface,
            pusher_friction,
            support_friction,
            gravity,
            longest_substep,
            given_force,
        })
    }

    /// The same rig with another gravity, in m/s².
    ///
    /// # Errors
    /// `InvalidValue` if it is not positive and finite.
    pub fn with_gravity(self, gravity: f64) -> Result<Self, EffectError> {
        Ok(Self { gravity: positive("gravity", gravity, "m/s²")?, ..self })
    }

    /// The same rig, integrated with other sub-steps, in m of the pusher's way; those with inertia solve for
    /// the push twice and are twice as long.
    ///
    /// # Errors
    /// `InvalidValue` if it is not positive and finite.
    pub fn with_longest_substep(self, way: f64) -> Result<Self, EffectError> {
        Ok(Self { longest_substep: positive("the longest sub-step", way, "m")?, ..self })
    }

    /// The limit surface's kind.
    pub fn surface(&self) -> &Surface {
        &self.surface
    }

    /// Nominal friction between pusher and object.
    pub fn pusher_friction(&self) -> f64 {
        self.pusher_friction
    }

    /// Nominal friction between object and support.
    pub fn support_friction(&self) -> f64 {
        self.support_friction
    }

    /// Gravity, in m/s².
    pub fn gravity(&self) -> f64 {
        self.gravity
    }

    /// Longest way of the pusher in one sub-step without inertia, in m.
    pub fn longest_substep(&self) -> f64 {
        self.longest_substep
    }

    /// Force, in N, that a support of the nominal friction bears under `mass`, in kg.
    pub(crate) fn nominal_force(&self, mass: f64) -> f64 {
        match self.surface {
            Surface::Ellipsoid | Surface::UniformPatch => {
                self.support_friction * mass * self.gravity
            }
            Surface::Given(_) => self.given_force,
        }
    }

    /// The given surface with its largest force, if there is one.
    pub(crate) fn given(&self) -> Option<(&dyn LimitSurface, f64)> {
        match &self.surface {
            Surface::Given(given) => Some((given.as_ref(), self.given_force)),
            Surface::Ellipsoid | Surface::UniformPatch => None,
        }
    }

    /// λ: 0 for the ellipsoid or a given surface, 1 for the exact surface of uniform pressure.
    pub fn surface_shape(&self) -> f64 {
        match self.surface {
            Surface::UniformPatch => 1.0,
            Surface::Ellipsoid | Surface::Given(_) => 0.0,
        }
    }
}
