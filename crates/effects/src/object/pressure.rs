//! How the load leans under an object.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

use crate::EffectError;
use crate::elementary::exp_each;
use crate::object::points::{Point, Points};

/// The load of every support point where the center of friction is beside the centroid.
///
/// Of all pressures with a given center and the mean distance from it that uniform pressure has
/// from the centroid, this is the one nearest to uniform pressure (in relative entropy): p(r) ∝
/// exp(g·r + a |r − d|), with d the center, r and d from the centroid. It is positive everywhere and
/// stays under the outline.
#[derive(Clone, Debug)]
pub(crate) struct Pressure {
    asked: Vector2<f64>,
    /// Its center from the centroid, in m, axes of the outline.
    pub(crate) center: Vector2<f64>,
    /// The object's points about the center, with their shares.
    pub(crate) lanes: Points,
    /// With the shares of uniform pressure.
    pub(crate) uniform: Points,
    /// With what their shares have over those of uniform pressure.
    pub(crate) surplus: Points,
}

const MAX_ITERATIONS: usize = 60;
/// In mean distances.
const TOLERANCE: f64 = 1e-12;
/// Near the minimum the dual changes by no more than this.
const ROUNDING: f64 = 1e-13;
/// Largest shift that the load leans by, in standard deviations of uniform pressure along it: at the
/// middle of a square's edge are 1.7. Beyond, all points are shifted.
const FARTHEST: f64 = 0.8;

impl Pressure {
    /// Pressure whose center is `shift` from the centroid, in m, on points of this second moment about it,
    /// in m².
    ///
    /// # Errors
    /// `NotConverged`.
    pub(crate) fn new(
        points: &[Point],
        second_moment: &Matrix2<f64>,
        shift: &Vector2<f64>,
    ) -> Result<Self, EffectError> {
        let precision = second_moment.try_inverse();
        let failed = EffectError::NotConverged { what: "the pressure's center", iterations: 0 };
        let precision = precision.ok_or(failed)?;
        let distance = shift.dot(&(precision * shift)).sqrt();
        let center = shift * (FARTHEST / distance.max(FARTHEST));
        let weights = weights(points, &center)?;
        let with = |share_of: fn(f64) -> f64| {
            let shares: Vec<f64> = weights.iter().map(|weight| share_of(*weight)).collect();
            Points::new(&about(points, &center, &shares))
        };
        let (lanes, uniform, surplus) =
            (with(|weight| weight), with(|_| 1.0), with(|weight| weight - 1.0));
        Ok(Self { asked: *shift, center, lanes, uniform, surplus })
    }

    /// Whether this is the pressure with a center.
    pub(crate) fn is(&self, shift: &Vector2<f64>) -> bool {
        self.asked == *shift
    }
}

/// Points seen from a center, with so many times their shares.
fn about(points: &[Point], center: &Vector2<f64>, factors: &[f64]) -> Vec<Point> {
    let point = |(point, factor): (&Point, &f64)| Point {
        place: point.place - center,
        share: point.share * factor,
        spin: point.spin,
    };
    points.iter().zip(factors).map(point).collect()
}

/// Newton's method on the dual ln Σ s exp(e·φ), which is convex; φ are the constraints' misses.
fn weights(points: &[Point], center: &Vector2<f64>) -> Result<Vec<f64>, EffectError> {
    let uniform: f64 = points.iter().map(|point| point.share * point.place.norm()).sum();
    let miss = |point: &Point| {
        let from_center = point.place - center;
        Vector3::new(from_center.x, from_center.y, from_center.norm() - uniform) / uniform
    };
    let misses: Vec<Vector3<f64>> = points.iter().map(miss).collect();
    let mut exponents = Vector3::zeros();
    let mut now = Dual::at(points, &misses, &exponents);
    for _ in 0..MAX_ITERATIONS {
        if now.slope.amax() < TOLERANCE {
            return Ok(now.weights);
        }
        let Some(factor) = now.curvature.cholesky() else { break };
        let step = factor.solve(&now.slope);
        let mut share = 1.0;
        let mut next = Dual::at(points, &misses, &(exponents - step));
        while next.value > now.value + ROUNDING && share > 1e-6 {
            share *= 0.5;
            next = Dual::at(points, &misses, &(exponents - share * step));
        }
        exponents -= share * step;
        now = next;
    }
    Err(EffectError::NotConverged { what: "the pressure's center", iterations: MAX_ITERATIONS })
}

/// ln Σ s exp(e·φ) with its derivatives, and the weights exp(e·φ) over that sum.
struct Dual {
    weights: Vec<f64>,
    value: f64,
    slope: Vector3<f64>,
    curvature: Matrix3<f64>,
}

impl Dual {
    fn at(points: &[Point], misses: &[Vector3<f64>], exponents: &Vector3<f64>) -> Self {
        let mut weights: Vec<f64> = misses.iter().map(|miss| exponents.dot(miss)).collect();
        exp_each(&mut weights);
        let (mut sum, mut slope, mut curvature) = (0.0, Vector3::zeros(), Matrix3::zeros());
        for ((point, miss), weight) in points.iter().zip(misses).zip(&weights) {
            let share = point.share * weight;
            sum += share;
            slope += share * miss;
            curvature += share * miss * miss.transpose();
        }
        weights.iter_mut().for_each(|weight| *weight /= sum);
        slope /= sum;
        curvature = curvature / sum - slope * slope.transpose();
        Self { weights, value: sum.ln(), slope, curvature }
    }
}

#[cfg(test)]
mod tests {
    use super::{Pressure, about, weights};
    use crate::Object;
    use crate::object::points::Point;
    use nalgebra::Vector2;
    use planar::{MIT_NAMES, mit_object};
    use std::sync::Arc;

    fn object(name: &str) -> Object {
        Object::uniform(Arc::new(mit_object(name).unwrap().shape), 0.8).unwrap()
    }

    fn leaning(object: &Object, center: &Vector2<f64>) -> Vec<Point> {
        about(object.points(), center, &weights(object.points(), center).unwrap())
    }

    #[test]
    fn the_load_has_the_center_asked_for_and_the_mean_distance_of_uniform_pressure() {
        for name in MIT_NAMES {
            let object = object(name);
            for (x, y) in [(5e-3, -3e-3), (0.0, 1e-2), (-0.2, 0.1)] {
                let center =
                    Pressure::new(object.points(), object.second_moment(), &Vector2::new(x, y))
                        .unwrap()
                        .center;
                let leaning = leaning(&object, &center);
                assert!(leaning.iter().all(|point| point.share > 0.0), "{name}");
                let center: Vector2<f64> =
                    leaning.iter().map(|point| point.share * point.place).sum();
                assert!(center.norm() < 1e-12, "{name}");
                let distance = |points: &[Point]| {
                    points.iter().map(|point| point.share * point.place.norm()).sum::<f64>()
                };
                let ratio = distance(&leaning) / distance(object.points());
                assert!((ratio - 1.0).abs() < 1e-11, "{name} {ratio}");
            }
        }
    }

    #[test]
    fn pressure_that_is_not_moved_is_uniform() {
        let object = object("tri1");
        for (leaning, uniform) in leaning(&object, &Vector2::zeros()).iter().zip(object.points()) {
            assert!((leaning.share / uniform.share - 1.0).abs() < 1e-14);
        }
    }
}
