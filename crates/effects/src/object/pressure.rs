//! How the load leans under an object.

use std::sync::OnceLock;

use nalgebra::{Matrix3, Vector2, Vector3};
use pulp::{Arch, Simd, WithSimd};

use crate::EffectError;
use crate::Object;
use crate::elementary::{LANES, Lanes, exp};
use crate::object::points::lane::Register;
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
        let about = |point: &Point| Point { place: point.place - center, ..*point };
        let points: Vec<Point> = object.points().iter().map(about).collect();
        let misses = Misses::new(&points, object.points_distance());
        let (weights, exponents) = weights(&misses, start)?;
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
    misses: &Misses,
    mut exponents: Vector3<f64>,
) -> Result<(Vec<f64>, Vector3<f64>), EffectError> {
    let mut now = misses.dual(&exponents);
    for _ in 0..MAX_ITERATIONS {
        if now.slope.amax() < TOLERANCE {
            return Ok((now.weights, exponents));
        }
        let Some(factor) = now.curvature.cholesky() else { break };
        let step = factor.solve(&now.slope);
        let mut share = 1.0;
        let mut next = misses.dual(&(exponents - step));
        while next.value > now.value + ROUNDING && share > 1e-6 {
            share *= 0.5;
            next = misses.dual(&(exponents - share * step));
        }
        exponents -= share * step;
        now = next;
    }
    Err(EffectError::NotConverged { what: "the pressure's center", iterations: MAX_ITERATIONS })
}

/// What each point misses of the constraints, in blocks; what is over has no share.
struct Misses {
    blocks: Vec<Block>,
}

struct Block {
    share: Lanes,
    misses: [Lanes; 3],
}

/// ln Σ s exp(e·φ) with its derivatives, and the weights exp(e·φ) over that sum.
struct Dual {
    weights: Vec<f64>,
    value: f64,
    slope: Vector3<f64>,
    curvature: Matrix3<f64>,
}

impl Misses {
    /// Of points about the center that is asked for, and the mean distance.
    fn new(points: &[Point], distance: f64) -> Self {
        let scale = 1.0 / distance;
        let block = |chunk: &[Point]| {
            let mut block = Block { share: [0.0; LANES], misses: [[0.0; LANES]; 3] };
            for (lane, Point { place, share, .. }) in chunk.iter().enumerate() {
                block.share[lane] = *share;
                block.misses[0][lane] = scale * place.x;
                block.misses[1][lane] = scale * place.y;
                block.misses[2][lane] = scale * place.norm() - 1.0;
            }
            block
        };
        Self { blocks: points.chunks(LANES).map(block).collect() }
    }

    fn dual(&self, exponents: &Vector3<f64>) -> Dual {
        let mut weights = vec![0.0; LANES * self.blocks.len()];
        let sums = DualSums { blocks: &self.blocks, weights: &mut weights, exponents };
        let [sum, x, y, n, xx, xy, xn, yy, yn, nn] = Arch::new().dispatch(sums);
        weights.iter_mut().for_each(|weight| *weight /= sum);
        let slope = Vector3::new(x, y, n) / sum;
        let square = Matrix3::new(xx, xy, xn, xy, yy, yn, xn, yn, nn) / sum;
        Dual { weights, value: sum.ln(), slope, curvature: square - slope * slope.transpose() }
    }
}

/// One pass for the sums of s exp(e·φ) times 1, φ and the products of φ; the exponentials are kept.
struct DualSums<'a> {
    blocks: &'a [Block],
    weights: &'a mut [f64],
    exponents: &'a Vector3<f64>,
}

impl WithSimd for DualSums<'_> {
    type Output = [f64; 10];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [f64; 10] {
        let mut sums = [[0.0; LANES]; 10];
        for (block, weights) in self.blocks.iter().zip(self.weights.as_chunks_mut().0) {
            let [x, y, n] = &block.misses;
            let [a, b, c]: [f64; 3] = (*self.exponents).into();
            let exponent: Lanes = std::array::from_fn(|k| a * x[k] + b * y[k] + c * n[k]);
            *weights = exp(&exponent);
        }
        for register in 0..LANES / S::F64_LANES {
            let mut added = [Register::all(simd, 0.0); 10];
            for (block, weights) in self.blocks.iter().zip(self.weights.as_chunks().0) {
                let of = |numbers: &Lanes| Register::of(simd, numbers, register);
                let load = of(&block.share) * of(weights);
                let [x, y, n] = [of(&block.misses[0]), of(&block.misses[1]), of(&block.misses[2])];
                let (by_x, by_y, by_n) = (load * x, load * y, load * n);
                let terms = [
                    load,
                    by_x,
                    by_y,
                    by_n,
                    by_x * x,
                    by_x * y,
                    by_x * n,
                    by_y * y,
                    by_y * n,
                    by_n * n,
                ];
                for number in 0..10 {
                    added[number] = added[number] + terms[number];
                }
            }
            for number in 0..10 {
                added[number].put(&mut sums[number], register);
            }
        }
        sums.map(|lanes| lanes.iter().sum())
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
