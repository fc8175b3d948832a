//! Sums over points whose friction differs from point to point.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
use pulp::{Arch, Simd, WithSimd};

use super::lane::{Lane, Register};
use super::{Block, Points, SIZE, forces, total};
use crate::object::points::Load;

/// Relative surplus s of friction at a place that slides with a velocity, and ds/d ln |v|.
pub(crate) type Law<'a> = dyn Fn(&Vector2<f64>, &Vector2<f64>) -> (f64, f64) + 'a;

impl Points {
    /// Σ of each point's share times its surplus s times T²v/|Tv|, with the derivatives by the
    /// motion; `law` tells the surplus.
    ///
    /// v = (vx, vy) + ω J `stretch` r; what is at rest adds nothing. As in [`Points::load`] the bits
    /// do not depend on the machine.
    pub(crate) fn local_load(
        &self,
        law: &Law<'_>,
        tensor: &Matrix2<f64>,
        stretch: f64,
        motion: &Vector3<f64>,
    ) -> Load {
        let pass = LocalForces { points: self, law, tensor, stretch, motion };
        let [x, y, turn, sides @ ..] = Arch::new().dispatch(pass).map(|sums| total(&sums));
        let [xx, xy, yy, x_turn, y_turn, turn_turn, growth @ ..] = sides;
        let slope = Matrix3::new(xx, xy, x_turn, xy, yy, y_turn, x_turn, y_turn, turn_turn);
        // From directions of images to those of velocities.
        let mut map = Matrix3::identity();
        map.fixed_view_mut::<2, 2>(0, 0).copy_from(&tensor.transpose());
        let faster = map * Matrix3::from_row_slice(&growth);
        (map * Vector3::new(x, y, turn), map * slope * map.transpose() + faster)
    }
}

/// One pass for the load: [`forces`] with the weights, and Σ of the growths over |v|² times the elements
/// of (u, l·u)ᵀ(v, v·J r), since ds = ds/d ln |v| · v·dv/|v|².
struct LocalForces<'a> {
    points: &'a Points,
    law: &'a Law<'a>,
    tensor: &'a Matrix2<f64>,
    stretch: f64,
    motion: &'a Vector3<f64>,
}

impl WithSimd for LocalForces<'_> {
    /// Three of the load, six of its symmetric and nine of its other derivatives.
    type Output = [[f64; SIZE]; 18];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [[f64; SIZE]; 18] {
        let Self { points, law, tensor, stretch, motion } = self;
        let mut sums = [[0.0; SIZE]; 18];
        let (none, one) = (Register::all(simd, 0.0), Register::all(simd, 1.0));
        let (move_x, move_y) = (one.alike(motion.x), one.alike(motion.y));
        let (turn, stretched) = (one.alike(motion.z), one.alike(stretch));
        for block in &points.blocks {
            let Surplus { weight, growth } = Surplus::of(block, law, stretch, motion);
            for register in 0..SIZE / S::F64_LANES {
                let x = Register::of(simd, &block.x, register);
                let y = Register::of(simd, &block.y, register);
                let weight = Register::of(simd, &weight, register);
                let growth = Register::of(simd, &growth, register);
                let forces_of = forces(one, [x, y], none, weight, tensor, stretch, motion);
                let growths = forces(one, [x, y], none, growth, tensor, stretch, motion);
                let (arm_x, arm_y) = (-stretched * y, stretched * x);
                let (vx, vy) = (move_x + turn * arm_x, move_y + turn * arm_y);
                let faster = [vx, vy, vx * arm_x + vy * arm_y];
                for number in 0..9 {
                    let sum = Register::of(simd, &sums[number], register);
                    (sum + forces_of[number]).put(&mut sums[number], register);
                    let sum = Register::of(simd, &sums[9 + number], register);
                    let grown = growths[number / 3] * faster[number % 3];
                    (sum + grown).put(&mut sums[9 + number], register);
                }
            }
        }
        sums
    }
}

/// What the law says of the points of a block.
struct Surplus {
    /// Share times surplus.
    weight: [f64; SIZE],
    /// Share times ds/d ln |v|, over |v|².
    growth: [f64; SIZE],
}

impl Surplus {
    fn of(block: &Block, law: &Law<'_>, stretch: f64, motion: &Vector3<f64>) -> Self {
        let Block { x, y, share, .. } = block;
        let (mut weight, mut growth) = ([0.0; SIZE], [0.0; SIZE]);
        for k in 0..SIZE {
            let place = stretch * Vector2::new(x[k], y[k]);
            let velocity = motion.xy() + motion.z * Vector2::new(-place.y, place.x);
            let square = velocity.norm_squared();
            if share[k] == 0.0 || square == 0.0 {
                continue;
            }
            let (surplus, grows) = law(&place, &velocity);
            weight[k] = share[k] * surplus;
            growth[k] = share[k] * grows / square;
        }
        Self { weight, growth }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Point, Points};
    use nalgebra::{Matrix2, Vector2, Vector3};

    fn points() -> Points {
        let point = |k: usize| {
            let at = k as f64;
            let place = 0.04 * Vector2::new((1.7 * at).sin(), (2.3 * at).cos());
            Point { place, share: 0.02 + 0.001 * at, spin: 1e-4 }
        };
        Points::new(&(0..21).map(point).collect::<Vec<_>>())
    }

    const TENSOR: Matrix2<f64> = Matrix2::new(1.2, 0.1, 0.1, 0.9);
    const STRETCH: f64 = 1.1;

    /// A law of place and speed.
    fn law(place: &Vector2<f64>, velocity: &Vector2<f64>) -> (f64, f64) {
        let ratio = velocity.norm() / 0.02;
        ((1.0 + 9.0 * place.x) * ratio.ln_1p(), (1.0 + 9.0 * place.x) * ratio / (1.0 + ratio))
    }

    #[test]
    fn a_surplus_of_one_everywhere_is_the_load_of_points_without_spin() {
        let still: Vec<_> = (0..21)
            .map(|k| {
                let at = f64::from(k);
                let place = 0.04 * Vector2::new((1.7 * at).sin(), (2.3 * at).cos());
                Point { place, share: 0.02 + 0.001 * at, spin: 0.0 }
            })
            .collect();
        let motion = Vector3::new(0.01, -0.02, 0.7);
        let (load, slope) = points().local_load(&|_, _| (1.0, 0.0), &TENSOR, STRETCH, &motion);
        let (same, same_slope) = Points::new(&still).load(&TENSOR, STRETCH, &motion);
        assert!((load - same).norm() < 1e-14 * same.norm());
        assert!((slope - same_slope).norm() < 1e-13 * same_slope.norm());
    }

    #[test]
    fn the_slope_is_that_of_the_load() {
        let (points, motion) = (points(), Vector3::new(0.01, -0.02, 0.7));
        let load = |motion: &Vector3<f64>| points.local_load(&law, &TENSOR, STRETCH, motion);
        let (_, slope) = load(&motion);
        for (axis, step) in [1e-7, 1e-7, 1e-5].into_iter().enumerate() {
            let mut ends = [motion; 2];
            ends[0][axis] += step;
            ends[1][axis] -= step;
            let secant = (load(&ends[0]).0 - load(&ends[1]).0) / (2.0 * step);
            assert!((secant - slope.column(axis)).norm() < 1e-6 * slope.column(axis).norm());
        }
    }

    #[test]
    fn what_rests_adds_nothing() {
        let (load, slope) = points().local_load(&law, &TENSOR, STRETCH, &Vector3::zeros());
        assert!(load.iter().chain(slope.iter()).all(|number| *number == 0.0));
    }
}
