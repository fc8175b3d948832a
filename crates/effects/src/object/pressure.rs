//! How the load leans under an object.

use std::sync::OnceLock;

use nalgebra::{Matrix3, Vector2, Vector3};

use crate::EffectError;
use crate::Object;
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
    /// The object's points about the center, with the shares of uniform pressure.
    points: Vec<Point>,
    /// The load of each over that of uniform pressure.
    weights: Vec<f64>,
    /// g and a, times the mean distance.
    exponents: Vector3<f64>,
    lanes: OnceLock<Points>,
    uniform: OnceLock<Points>,
    surplus: OnceLock<Points>,
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
    /// Pressure whose center is `shift` from an object's centroid, in m.
    ///
    /// # Errors
    /// `NotConverged`.
    pub(crate) fn new(object: &Object, shift: &Vector2<f64>) -> Result<Self, EffectError> {
        Self::near(Vector3::zeros(), object, shift)
    }

    /// The same of an object of which another one is known, whose center is near.
    ///
    /// # Errors
    /// `NotConverged`.
    pub(crate) fn moved(&self, object: &Object, shift: &Vector2<f64>) -> Result<Self, EffectError> {
        Self::near(self.exponents, object, shift)
    }

    fn near(
        start: Vector3<f64>,
        object: &Object,
        shift: &Vector2<f64>,
    ) -> Result<Self, EffectError> {
        let precision = object.second_moment().try_inverse();
        let failed = EffectError::NotConverged { what: "the pressure's center", iterations: 0 };
        let precision = precision.ok_or(failed)?;
        let distance = shift.dot(&(precision * shift)).sqrt();
        let center = shift * (FARTHEST / distance.max(FARTHEST));
        let (weights, exponents) = weights(object.points(), &center, start)?;
        let about = |point: &Point| Point { place: point.place - center, ..*point };
        let points = object.points().iter().map(about).collect();
        let (lanes, uniform, surplus) = (OnceLock::new(), OnceLock::new(), OnceLock::new());
        Ok(Self { asked: *shift, center, points, weights, exponents, lanes, uniform, surplus })
    }

    /// Whether this is the pressure with a center.
    pub(crate) fn is(&self, shift: &Vector2<f64>) -> bool {
        self.asked == *shift
    }

    /// The object's points about the center, with their shares.
    pub(crate) fn lanes(&self) -> &Points {
        self.lanes.get_or_init(|| self.with(|weight| weight))
    }

    /// With the shares of uniform pressure.
    pub(crate) fn uniform(&self) -> &Points {
        self.uniform.get_or_init(|| self.with(|_| 1.0))
    }

    /// With what their shares have over those of uniform pressure.
    pub(crate) fn surplus(&self) -> &Points {
        self.surplus.get_or_init(|| self.with(|weight| weight - 1.0))
    }

    fn with(&self, factor_of: fn(f64) -> f64) -> Points {
        let point = |(point, weight): (&Point, &f64)| Point {
            share: point.share * factor_of(*weight),
            ..*point
        };
        let points: Vec<Point> = self.points.iter().zip(&self.weights).map(point).collect();
        Points::new(&points)
    }
}

/// Newton's method on the dual ln Σ s exp(e·φ), which is convex; φ are the constraints' misses. With the
/// exponents e.
fn weights(
    points: &[Point],
    center: &Vector2<f64>,
    mut exponents: Vector3<f64>,
) -> Result<(Vec<f64>, Vector3<f64>), EffectError> {
    let uniform: f64 = points.iter().map(|point| point.share * point.place.norm()).sum();
    let miss = |point: &Point| {
        let from_center = point.place - center;
        Vector3::new(from_center.x, from_center.y, from_center.norm() - uniform) / uniform
    };
    let misses: Vec<Vector3<f64>> = points.iter().map(miss).collect();
    let mut now = Dual::at(points, &misses, &exponents);
    for _ in 0..MAX_ITERATIONS {
        if now.slope.amax() < TOLERANCE {
            return Ok((now.weights, exponents));
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
    use super::Pressure;
    use crate::Object;
    use crate::object::points::Point;
    use nalgebra::Vector2;
    use planar::{MIT_NAMES, mit_object};
    use std::sync::Arc;

    fn object(name: &str) -> Object {
        Object::uniform(Arc::new(mit_object(name).unwrap().shape), 0.8).unwrap()
    }

    fn leaning(object: &Object, center: &Vector2<f64>) -> Vec<Point> {
        shares(&Pressure::new(object, center).unwrap())
    }

    fn shares(Pressure { points, weights, .. }: &Pressure) -> Vec<Point> {
        let point =
            |(point, weight): (&Point, &f64)| Point { share: point.share * weight, ..*point };
        points.iter().zip(weights).map(point).collect()
    }

    #[test]
    fn the_load_has_the_center_asked_for_and_the_mean_distance_of_uniform_pressure() {
        for name in MIT_NAMES {
            let object = object(name);
            for (x, y) in [(5e-3, -3e-3), (0.0, 1e-2), (-0.2, 0.1)] {
                let leaning = leaning(&object, &Vector2::new(x, y));
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
    fn wherever_the_search_begins_it_ends_at_the_same_load() {
        for name in MIT_NAMES {
            let object = object(name);
            let at = |x: f64, y: f64| Pressure::new(&object, &Vector2::new(x, y)).unwrap();
            let there = at(4e-3, 7e-3);
            for (x, y) in [(4.1e-3, 7e-3), (-6e-3, 2e-3), (0.3, -0.2)] {
                let (moved, anew) = (there.moved(&object, &Vector2::new(x, y)).unwrap(), at(x, y));
                assert_eq!(moved.center, anew.center);
                for (moved, anew) in moved.weights.iter().zip(&anew.weights) {
                    assert!((moved - anew).abs() < 1e-11, "{name} {moved} {anew}");
                }
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
