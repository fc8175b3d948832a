//! The friction load of a motion, with its derivatives.

use nalgebra::{Matrix2, Matrix3, Vector3};
use planar::perpendicular;

use crate::EffectError;
use crate::object::points::{Load, Points};
use crate::predict::area_friction::{AreaFriction, Local};

/// Friction of one moment, per unit of the largest force, about the center of friction S: of the area,
/// and of spots that bear a share of the weight.
pub(crate) struct Friction<'a> {
    pub(crate) area: AreaFriction<'a>,
    pub(crate) spots: Option<SpotFriction<'a>>,
}

/// Friction of single spots.
pub(crate) struct SpotFriction<'a> {
    /// Their share of the weight.
    pub(crate) share: f64,
    /// About S, with shares of 1.
    pub(crate) points: Points,
    /// Mean distance from S, in m, stretched.
    pub(crate) length: f64,
    pub(crate) stretch: f64,
    pub(crate) tensor: Matrix2<f64>,
    pub(crate) local: Option<Local<'a>>,
    /// From motions at S to those at the area's center.
    pub(crate) to_area: Matrix3<f64>,
}

impl Friction<'_> {
    /// c = Mmax/Fmax, in m: of the ellipsoid, and of spots about S.
    pub(crate) fn length(&self) -> f64 {
        let area = self.area.length();
        match &self.spots {
            Some(SpotFriction { share, length, .. }) => (1.0 - share) * area + share * length,
            None => area,
        }
    }

    /// The load (Fx, Fy, M) of a motion (vx, vy, ω) at S; zero for none.
    pub(crate) fn load(&self, motion: &Vector3<f64>) -> Result<Load, EffectError> {
        let Some(spots) = &self.spots else { return self.area.load(motion) };
        let (load, slope) = spots.load(motion);
        if spots.share == 1.0 {
            return Ok((load, slope));
        }
        let (map, rest) = (&spots.to_area, 1.0 - spots.share);
        let (area, area_slope) = self.area.load(&(map * motion))?;
        let area_slope = map.tr_mul(&(area_slope * map));
        Ok((load + rest * map.tr_mul(&area), slope + rest * area_slope))
    }
}

impl SpotFriction<'_> {
    fn load(&self, motion: &Vector3<f64>) -> Load {
        let (mut load, mut slope) = self.points.load(&self.tensor, self.stretch, motion);
        if let Some(local) = &self.local {
            let law = |place: &_, velocity: &_| local.surplus_and_growth(place, velocity);
            let (more, more_slope) =
                self.points.local_load(&law, &self.tensor, self.stretch, motion);
            load += more;
            slope += more_slope;
        }
        (self.share * load, self.share * slope)
    }
}

/// The map from motions at a point to those at another one that is `arm` from it, in m.
pub(crate) fn motion_at(arm: &nalgebra::Vector2<f64>) -> Matrix3<f64> {
    let turned = perpendicular(arm);
    Matrix3::new(1.0, 0.0, turned.x, 0.0, 1.0, turned.y, 0.0, 0.0, 1.0)
}
