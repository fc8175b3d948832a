//! The limit surfaces that an analytical model may stand on.

use std::sync::Arc;

use mechanics::{
    EdgePush, Ellipsoid, LimitSurface, Patch, PointSet, UniformPressure, UniformSupport,
    UniformSurface, uniform_surfaces,
};
use planar::{Pose, Shape};

use crate::{EffectiveSurface, ModelError};

/// Which limit surface an object has: one that stands for uniform pressure over the outline, or a measured
/// one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum SurfaceKind {
    /// The ellipsoid about the centroid with the exact ratio c of largest moment to largest force,
    /// or with a given one; its push is a closed form.
    #[default]
    Ellipsoid,
    /// The exact surface.
    UniformPatch,
    /// The exact surface of the pressure lumped at points.
    Points {
        /// About how many.
        n_points: usize,
    },
    /// Any other that mechanics lists.
    Listed(&'static UniformSurface),
    /// One that was measured under an object, for that object alone.
    Effective(EffectiveSurface),
}

impl SurfaceKind {
    /// The name of a measured surface.
    pub const EFFECTIVE: &'static str = "effective-quartic";

    /// Every kind that stands for uniform pressure, points in their usual number.
    pub fn all() -> impl Iterator<Item = Self> {
        uniform_surfaces().iter().map(|surface| match surface.name() {
            Ellipsoid::NAME => Self::Ellipsoid,
            Patch::NAME => Self::UniformPatch,
            PointSet::NAME => Self::Points { n_points: PointSet::ENOUGH },
            _ => Self::Listed(surface),
        })
    }

    /// The kind of uniform pressure with a name; none if there is no such kind.
    pub fn named(name: &str) -> Option<Self> {
        Self::all().find(|kind| kind.name() == name)
    }

    /// Its name in `model.toml`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ellipsoid => Ellipsoid::NAME,
            Self::UniformPatch => Patch::NAME,
            Self::Points { .. } => PointSet::NAME,
            Self::Listed(surface) => surface.name(),
            Self::Effective(_) => Self::EFFECTIVE,
        }
    }

    /// The surface under a shape that bears 1 N, with an ellipsoid's c in m.
    ///
    /// The size of the force does not matter to a quasi-static motion on a level table.
    pub(crate) fn under(self, shape: &Shape, length: f64) -> Result<Support, ModelError> {
        if self != Self::Ellipsoid {
            let (surface, pose_bs) = (self.in_body(shape, 1.0)?, Pose::default());
            return Ok(Support { surface, pose_bs, at_edge: None });
        }
        let support = UniformSupport::with_length(shape, 1.0, length)?;
        let (surface, pose_bs) = (*support.surface(), *support.pose_bs());
        let at_edge = EdgePush::new(shape, &surface, &pose_bs);
        Ok(Support { surface: Arc::new(surface), pose_bs, at_edge })
    }

    /// The surface in the body's frame under a shape that bears `force`, in N.
    pub(crate) fn in_body(
        self,
        shape: &Shape,
        force: f64,
    ) -> Result<Arc<dyn LimitSurface>, ModelError> {
        Ok(match self {
            Self::Ellipsoid => Arc::new(Ellipsoid::uniform(shape, force)?),
            Self::UniformPatch => Arc::new(Patch::uniform(shape, force)?),
            Self::Points { n_points } => Arc::new(PointSet::sampling(shape, force, n_points)?),
            Self::Listed(surface) => surface.over(shape, force)?,
            Self::Effective(surface) => Arc::new(surface.bearing(force)?),
        })
    }
}

/// A limit surface and where its frame S is in the body.
#[derive(Debug)]
pub(crate) struct Support {
    pub surface: Arc<dyn LimitSurface>,
    pub pose_bs: Pose,
    /// Most pushes at once, where the surface is an ellipsoid.
    pub at_edge: Option<EdgePush>,
}

#[cfg(test)]
mod tests {
    use super::SurfaceKind;
    use mechanics::{LimitSurface, Patch};
    use planar::{Shape, Twist, mit_object};

    #[test]
    fn in_the_frame_of_the_body_every_kind_bears_as_much() {
        for shape in [Shape::square(0.09).unwrap(), mit_object("tri1").unwrap().shape] {
            let exact = Patch::uniform(&shape, 3.0).unwrap();
            for kind in [SurfaceKind::Ellipsoid, SurfaceKind::UniformPatch] {
                let surface = kind.in_body(&shape, 3.0).unwrap();
                for twist_b in [Twist::new(0.3, -0.8, 0.0), Twist::new(0.0, 0.0, 1.0)] {
                    let power = surface.dissipation(&twist_b).unwrap();
                    let expected = exact.dissipation(&twist_b).unwrap();
                    assert!((power / expected - 1.0).abs() < 0.03, "{kind:?} {power} {expected}");
                }
            }
        }
    }

    /// Every surface stands for the same pressure, so their largest forces and moments are alike.
    #[test]
    fn every_kind_bears_what_the_exact_surface_bears() {
        for shape in [Shape::square(0.09).unwrap(), mit_object("tri1").unwrap().shape] {
            let exact = Patch::uniform(&shape, 1.0).unwrap();
            let center = shape.centroid();
            let c = shape.mean_distance(&center);
            for kind in SurfaceKind::all() {
                let support = kind.under(&shape, c).unwrap();
                for twist_b in [
                    Twist::new(1.0, 0.0, 0.0),
                    Twist::new(0.3, -0.8, 0.0),
                    Twist::new(center.y, -center.x, 1.0),
                ] {
                    let twist_s = twist_b.shifted(&support.pose_bs.position);
                    let power = support.surface.dissipation(&twist_s).unwrap();
                    let expected = exact.dissipation(&twist_b).unwrap();
                    assert!((power / expected - 1.0).abs() < 0.03, "{kind:?} {power} {expected}");
                }
            }
        }
    }
}
