//! The friction load of a motion, with its derivatives.

use std::borrow::Cow;

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
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
    pub(crate) points: Cow<'a, Points>,
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
            let law = |places: [&_; 2], velocities: [&_; 2]| local.of_all(places, velocities);
            let (more, more_slope) =
                self.points.local_load(&law, &self.tensor, self.stretch, motion);
            load += more;
            slope += more_slope;
        }
        (self.share * load, self.share * slope)
    }
}

/// The map from motions at a point to those at another one that is `arm` from it, in m.
pub(crate) fn motion_at(arm: &Vector2<f64>) -> Matrix3<f64> {
    let turned = perpendicular(arm);
    Matrix3::new(1.0, 0.0, turned.x, 0.0, 1.0, turned.y, 0.0, 0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::{AreaFriction, Friction, SpotFriction, motion_at};
    use crate::object::spots::Spots;
    use crate::{Object, Spot, Support};
    use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
    use planar::{Shape, perpendicular};
    use std::sync::Arc;

    const SPOTS: [(f64, f64, f64); 3] =
        [(0.04, 0.03, 0.2), (-0.035, 0.01, 0.25), (0.01, -0.04, 0.15)];

    /// Of a square with a part of its weight on spots, and its center of friction.
    fn friction<'a>(
        object: &'a Object,
        support: &Support,
        spots: &'a Spots,
    ) -> (Friction<'a>, Vector2<f64>) {
        let area = AreaFriction::new(object, (support, 1.0), None, None, None).unwrap();
        let spots_friction = SpotFriction {
            share: spots.share,
            points: spots.leaning(&Vector2::zeros()),
            length: spots.mean_distance,
            stretch: 1.0,
            tensor: Matrix2::identity(),
            local: None,
            to_area: motion_at(&-spots.center),
        };
        (Friction { area, spots: Some(spots_friction) }, spots.center)
    }

    #[test]
    fn the_load_is_that_of_the_spots_and_of_the_rest_on_the_area() {
        let object = Object::uniform(Arc::new(Shape::square(0.09).unwrap()), 0.8).unwrap();
        let spots =
            SPOTS.map(|(x, y, share)| Spot { place_o: Vector2::new(x, y), share, radius: 1e-9 });
        let spots = Spots::new(&spots, object.centroid(), object.mean_distance()).unwrap().unwrap();
        let (friction, center) = friction(&object, &Support::nominal(0.25, 0.0), &spots);
        let motion = Vector3::new(0.012, -0.007, 0.4);
        let (load, slope) = friction.load(&motion).unwrap();
        // By hand, force by force: of each spot, and of the ellipsoid at the square's middle.
        let c = object.mean_distance();
        let at_middle = motion.xy() + motion.z * perpendicular(&-center);
        let speed = at_middle.norm().hypot(c * motion.z);
        let mut by_hand = {
            let (force, moment) = (0.4 * at_middle / speed, 0.4 * c * c * motion.z / speed);
            Vector3::new(force.x, force.y, moment + planar::cross(&-center, &force))
        };
        for (x, y, share) in SPOTS {
            let arm = Vector2::new(x, y) - center;
            let velocity = motion.xy() + motion.z * perpendicular(&arm);
            let force = share * velocity.normalize();
            by_hand += Vector3::new(force.x, force.y, planar::cross(&arm, &force));
        }
        assert!((load - by_hand).norm() < 1e-12, "{load} {by_hand}");
        let mut differences = Matrix3::zeros();
        for axis in 0..3 {
            let mut step = Vector3::zeros();
            step[axis] = 1e-6;
            let [(high, _), (low, _)] =
                [motion + step, motion - step].map(|motion| friction.load(&motion).unwrap());
            differences.set_column(axis, &((high - low) / 2e-6));
        }
        assert!((slope - differences).norm() < 1e-5 * slope.norm(), "{slope} {differences}");
    }
}
