//! Sums over points whose friction differs from point to point.

use nalgebra::{Matrix2, Matrix3, Vector3};
use pulp::{Arch, Simd, WithSimd};

use super::lane::{Lane, Register};
use super::{Block, Points, SIZE, forces, total};
use crate::object::points::Load;
use crate::object::sliding::{LocalFriction, SlidingPoints};

/// Relative surplus s of friction at places that slide with velocities, x and y of each, and ds/d ln |v|.
pub(crate) type Law<'a> = dyn Fn([&[f64]; 2], [&[f64]; 2]) -> LocalFriction + 'a;

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
        for blocks in points.blocks.chunks(BLOCKS) {
            let surplus = Surplus::of(blocks, law, stretch, motion);
            for (k, block) in blocks.iter().enumerate() {
                let (weight, growth) = (&surplus.weight[k], &surplus.growth[k]);
                for register in 0..SIZE / S::F64_LANES {
                    let x = Register::of(simd, &block.x, register);
                    let y = Register::of(simd, &block.y, register);
                    let weight = Register::of(simd, weight, register);
                    let growth = Register::of(simd, growth, register);
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
        }
        sums
    }
}

/// Blocks that a law is asked of at a time.
const BLOCKS: usize = SlidingPoints::MOST / SIZE;

/// What the law says of the points of some blocks.
struct Surplus {
    /// Share times surplus.
    weight: [[f64; SIZE]; BLOCKS],
    /// Share times ds/d ln |v|, over |v|².
    growth: [[f64; SIZE]; BLOCKS],
}

impl Surplus {
    #[inline(always)]
    fn of(blocks: &[Block], law: &Law<'_>, stretch: f64, motion: &Vector3<f64>) -> Self {
        let none = [[0.0; SIZE]; BLOCKS];
        let (mut x, mut y, mut vx, mut vy) = (none, none, none, none);
        for (k, block) in blocks.iter().enumerate() {
            for point in 0..SIZE {
                x[k][point] = stretch * block.x[point];
                y[k][point] = stretch * block.y[point];
                vx[k][point] = motion.x - motion.z * y[k][point];
                vy[k][point] = motion.y + motion.z * x[k][point];
            }
        }
        let n = SIZE * blocks.len();
        let lists = [&x, &y, &vx, &vy].map(|list| &list.as_flattened()[..n]);
        let found = law([lists[0], lists[1]], [lists[2], lists[3]]);
        let (mut weight, mut growth) = (none, none);
        for (k, block) in blocks.iter().enumerate() {
            for point in 0..SIZE {
                let square = vx[k][point] * vx[k][point] + vy[k][point] * vy[k][point];
                // What rests, or bears nothing, adds nothing, whatever a law says of it.
                let is_there = square != 0.0 && block.share[point] != 0.0;
                let weighted = |number: f64| if is_there { number } else { 0.0 };
                let (surplus, grows) =
                    (found.surplus[SIZE * k + point], found.growth[SIZE * k + point]);
                weight[k][point] = weighted(block.share[point] * surplus);
                growth[k][point] = weighted(block.share[point] * grows / square);
            }
        }
        Self { weight, growth }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Point, Points};
    use crate::LocalFriction;
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
    fn law([x, _]: [&[f64]; 2], [vx, vy]: [&[f64]; 2]) -> LocalFriction {
        let mut found = LocalFriction::default();
        for k in 0..x.len() {
            let (factor, ratio) = (1.0 + 9.0 * x[k], vx[k].hypot(vy[k]) / 0.02);
            found.surplus[k] = factor * ratio.ln_1p();
            found.growth[k] = factor * ratio / (1.0 + ratio);
        }
        found
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
        let one = LocalFriction { surplus: [1.0; 64], ..LocalFriction::default() };
        let (load, slope) = points().local_load(&|_, _| one.clone(), &TENSOR, STRETCH, &motion);
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
