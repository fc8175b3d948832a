//! How the load leans and gathers under an object.

use nalgebra::{Matrix3, Vector2, Vector3};

use crate::plates::{Plate, Plates};
use crate::{EffectError, Object};

/// The load of every support point over that of uniform pressure.
///
/// Of all pressures with a given center and a given mean distance from it, this is the one nearest
/// to uniform pressure (in relative entropy): p(r) ∝ exp(g·r + a |r − d|), with d the center, r and
/// d from the centroid. It is positive everywhere and stays under the outline.
#[derive(Clone, Debug)]
pub(crate) struct Pressure {
    asked: (Vector2<f64>, f64),
    /// Its center from the centroid, in m, axes of the outline.
    pub(crate) center: Vector2<f64>,
    /// How far apart all points are moved about the center besides.
    pub(crate) stretch: f64,
    /// The object's plates, about the center.
    pub(crate) plates: Plates,
}

const MAX_ITERATIONS: usize = 60;
/// In mean distances.
const TOLERANCE: f64 = 1e-12;
/// Near the minimum the dual changes by no more than this.
const ROUNDING: f64 = 1e-13;
/// Largest shift that the load leans by, in standard deviations of uniform pressure along it: at the
/// middle of a square's edge are 1.7. Beyond, all points are shifted.
const FARTHEST: f64 = 0.8;
/// Mean distances to which the load gathers or spreads, over that of uniform pressure. Beyond, all
/// points move apart or together.
const RATIOS: (f64, f64) = (0.75, 1.25);

impl Pressure {
    /// Pressure whose center is `shift` (m) from the centroid, and whose mean distance from it is
    /// `ratio` times that of uniform pressure.
    ///
    /// # Errors
    /// `NotConverged`.
    pub(crate) fn new(
        object: &Object,
        shift: &Vector2<f64>,
        ratio: f64,
    ) -> Result<Self, EffectError> {
        let precision = object.second_moment().try_inverse();
        let precision = precision.expect("an area has a positive second moment");
        let distance = shift.dot(&(precision * shift)).sqrt();
        let center = shift * (FARTHEST / distance.max(FARTHEST));
        let near = ratio.clamp(RATIOS.0, RATIOS.1);
        let weights = weights(object, &center, near)?;
        let stretch = ratio / near;
        let plates = object.plates().each().zip(weights).map(|(plate, weight)| Plate {
            place: stretch * (plate.place - center),
            spin: stretch * stretch * plate.spin,
            share: weight * plate.share,
            ..plate
        });
        Ok(Self { asked: (*shift, ratio), center, stretch, plates: Plates::new(plates) })
    }

    /// Whether this is the pressure with a center and ratio.
    pub(crate) fn is(&self, shift: &Vector2<f64>, ratio: f64) -> bool {
        self.asked == (*shift, ratio)
    }
}

/// Newton's method on the dual ln Σ s exp(e·φ), which is convex; φ are the constraints' misses.
fn weights(object: &Object, center: &Vector2<f64>, ratio: f64) -> Result<Vec<f64>, EffectError> {
    let points = object.points();
    let uniform: f64 = points.iter().map(|(place, share)| share * place.norm()).sum();
    let goal = Vector3::new(center.x / uniform, center.y / uniform, ratio);
    let miss = |place: &Vector2<f64>| {
        let place = Vector3::new(place.x, place.y, (place - center).norm()) / uniform;
        place - goal
    };
    let misses: Vec<Vector3<f64>> = points.iter().map(|(place, _)| miss(place)).collect();
    let dual = |exponents: &Vector3<f64>| {
        let terms = points.iter().zip(&misses);
        terms.map(|((_, share), miss)| share * exponents.dot(miss).exp()).sum::<f64>().ln()
    };
    let mut exponents = Vector3::zeros();
    let mut value = dual(&exponents);
    for _ in 0..MAX_ITERATIONS {
        let (mut slope, mut curvature) = (Vector3::zeros(), Matrix3::zeros());
        for ((_, share), miss) in points.iter().zip(&misses) {
            let share = share * (exponents.dot(miss) - value).exp();
            slope += share * miss;
            curvature += share * miss * miss.transpose();
        }
        if slope.amax() < TOLERANCE {
            let weight = |miss: &Vector3<f64>| (exponents.dot(miss) - value).exp();
            return Ok(misses.iter().map(weight).collect());
        }
        curvature -= slope * slope.transpose();
        let Some(factor) = curvature.cholesky() else { break };
        let step = factor.solve(&slope);
        let mut share = 1.0;
        let mut next = dual(&(exponents - step));
        while next > value + ROUNDING && share > 1e-6 {
            share *= 0.5;
            next = dual(&(exponents - share * step));
        }
        exponents -= share * step;
        value = next;
    }
    Err(EffectError::NotConverged { what: "the pressure's center", iterations: MAX_ITERATIONS })
}

#[cfg(test)]
mod tests {
    use super::Pressure;
    use crate::Object;
    use crate::plates::Plates;
    use nalgebra::Vector2;
    use planar::{MIT_NAMES, mit_object};
    use std::sync::Arc;

    #[test]
    fn the_load_has_the_center_and_the_mean_distance_asked_for() {
        for name in MIT_NAMES {
            let object = Object::uniform(Arc::new(mit_object(name).unwrap().shape), 0.8).unwrap();
            for (x, y, ratio) in [(5e-3, -3e-3, 1.0), (0.0, 0.0, 0.85), (-0.2, 0.1, 1.3)] {
                let shift = Vector2::new(x, y);
                let pressure = Pressure::new(&object, &shift, ratio).unwrap();
                assert!(pressure.plates.each().all(|plate| plate.share > 0.0), "{name}");
                let center: Vector2<f64> =
                    pressure.plates.each().map(|plate| plate.share * plate.place).sum();
                assert!(center.norm() < 1e-12, "{name}");
                let distance = |plates: &Plates| {
                    plates.each().map(|plate| plate.share * plate.place.norm()).sum::<f64>()
                };
                let reached = distance(&pressure.plates);
                let uniform = distance(object.plates());
                assert!((reached / uniform - ratio).abs() < 1e-11, "{name} {ratio}");
            }
        }
    }

    #[test]
    fn pressure_that_is_not_moved_is_uniform() {
        let object = Object::uniform(Arc::new(mit_object("tri1").unwrap().shape), 0.8).unwrap();
        let pressure = Pressure::new(&object, &Vector2::zeros(), 1.0).unwrap();
        assert!(
            pressure.plates.each().all(|plate| (plate.share / plate.uniform - 1.0).abs() < 1e-14)
        );
    }
}
