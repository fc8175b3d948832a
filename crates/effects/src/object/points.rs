//! Sums over the points that stand for a support, in the machine's vector registers.

mod lane;
mod local;

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
use pulp::{Arch, Simd, WithSimd};

use self::lane::{Lane, Register};

/// A load and its derivatives by the motion.
pub(crate) type Load = (Vector3<f64>, Matrix3<f64>);

/// The points that stand for a support, in blocks.
#[derive(Clone, Debug)]
pub(crate) struct Points {
    blocks: Vec<Block>,
}

/// A point that stands for a small plate around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Point {
    /// From the center of the support, in m.
    pub(crate) place: Vector2<f64>,
    /// Share of the load.
    pub(crate) share: f64,
    /// Radius of gyration of the plate over √2, in m: turning about its middle at ω, it dissipates
    /// what one does that slides at `spin`·ω. With it nothing is singular where the object turns
    /// about a point.
    pub(crate) spin: f64,
}

/// Some points; what is over has no share.
#[derive(Clone, Debug)]
struct Block {
    x: [f64; SIZE],
    y: [f64; SIZE],
    share: [f64; SIZE],
    spin: [f64; SIZE],
}

const SIZE: usize = 8;

impl Points {
    pub(crate) fn new(points: &[Point]) -> Self {
        let block = |chunk: &[Point]| {
            let of = |number: fn(&Point) -> f64| {
                std::array::from_fn(|k| chunk.get(k).map_or(0.0, number))
            };
            Block {
                x: of(|point| point.place.x),
                y: of(|point| point.place.y),
                share: of(|point| point.share),
                spin: of(|point| point.spin),
            }
        };
        Self { blocks: points.chunks(SIZE).map(block).collect() }
    }

    /// The derivatives by the motion of Σ of each point's share of √(|T v|² + s² ω²), and those of
    /// the derivatives.
    ///
    /// v = (vx, vy) + ω J `stretch` r and s = `stretch` times the spin. No operation is fused and
    /// the order is fixed, so the bits do not depend on the machine.
    pub(crate) fn load(&self, tensor: &Matrix2<f64>, stretch: f64, motion: &Vector3<f64>) -> Load {
        let sums = Arch::new().dispatch(Forces { points: self, tensor, stretch, motion });
        let sums = sums.map(|sums| total(&sums));
        let [x, y, turn, xx, xy, yy, x_turn, y_turn, turn_turn] = sums;
        let force = tensor.tr_mul(&Vector2::new(x, y));
        let block = tensor.tr_mul(&Matrix2::new(xx, xy, xy, yy)) * tensor;
        let side = tensor.tr_mul(&Vector2::new(x_turn, y_turn));
        let slope = Matrix3::new(
            block.m11, block.m12, side.x, block.m21, block.m22, side.y, side.x, side.y, turn_turn,
        );
        (Vector3::new(force.x, force.y, turn), slope)
    }

    /// Σ of each point's share of |M r|.
    pub(crate) fn mean_norm(&self, matrix: &Matrix2<f64>) -> f64 {
        total(&Arch::new().dispatch(Norms { points: self, matrix }))
    }
}

/// One pass for the load.
struct Forces<'a> {
    points: &'a Points,
    tensor: &'a Matrix2<f64>,
    stretch: f64,
    motion: &'a Vector3<f64>,
}

impl WithSimd for Forces<'_> {
    type Output = [[f64; SIZE]; 9];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [[f64; SIZE]; 9] {
        let Self { points, tensor, stretch, motion } = self;
        let mut sums = [[0.0; SIZE]; 9];
        let one = Register::all(simd, 1.0);
        for register in 0..SIZE / S::F64_LANES {
            let mut added = [Register::all(simd, 0.0); 9];
            for block in &points.blocks {
                let x = Register::of(simd, &block.x, register);
                let y = Register::of(simd, &block.y, register);
                let share = Register::of(simd, &block.share, register);
                let spin = Register::of(simd, &block.spin, register);
                let terms = forces(one, [x, y], spin, share, tensor, stretch, motion);
                for number in 0..9 {
                    added[number] = added[number] + terms[number];
                }
            }
            for number in 0..9 {
                added[number].put(&mut sums[number], register);
            }
        }
        sums
    }
}

/// Square of a speed below which a point is at rest: its direction is 0.
const AT_REST: f64 = 1e-300;

/// What a point adds to the load and to its derivatives. The image of a motion at the point is
/// (T v, s ω), its direction u and the lever l the image of ω = 1: the weight times u (in the plane)
/// and l·u, and the weight over the image's length times the elements of 1 − u uᵀ, its product with l
/// and l·(1 − u uᵀ) l = |l × u|².
#[inline(always)]
fn forces<L: Lane>(
    one: L,
    [x, y]: [L; 2],
    spin: L,
    weight: L,
    tensor: &Matrix2<f64>,
    stretch: f64,
    motion: &Vector3<f64>,
) -> [L; 9] {
    let (m11, m12) = (one.alike(tensor.m11), one.alike(tensor.m12));
    let (m21, m22) = (one.alike(tensor.m21), one.alike(tensor.m22));
    let (turn, stretch) = (one.alike(motion.z), one.alike(stretch));
    let (arm_x, arm_y) = (-stretch * y, stretch * x);
    let vx = one.alike(motion.x) + turn * arm_x;
    let vy = one.alike(motion.y) + turn * arm_y;
    let (image_x, image_y) = (m11 * vx + m12 * vy, m21 * vx + m22 * vy);
    let (lever_x, lever_y) = (m11 * arm_x + m12 * arm_y, m21 * arm_x + m22 * arm_y);
    let lever_s = stretch * spin;
    let image_s = turn * lever_s;
    let square = image_x * image_x + image_y * image_y + image_s * image_s;
    let inverse = square.at_least(AT_REST).inverse_root();
    let (ux, uy, us) = (image_x * inverse, image_y * inverse, image_s * inverse);
    // The components of l × u.
    let cross_x = lever_y * us - lever_s * uy;
    let cross_y = lever_s * ux - lever_x * us;
    let cross_s = lever_x * uy - lever_y * ux;
    let over = weight * inverse;
    [
        weight * ux,
        weight * uy,
        weight * (lever_x * ux + lever_y * uy + lever_s * us),
        over * (uy * uy + us * us),
        -over * ux * uy,
        over * (ux * ux + us * us),
        over * (uy * cross_s - us * cross_y),
        over * (us * cross_x - ux * cross_s),
        over * (cross_x * cross_x + cross_y * cross_y + cross_s * cross_s),
    ]
}

/// One pass for the sum of norms.
struct Norms<'a> {
    points: &'a Points,
    matrix: &'a Matrix2<f64>,
}

impl WithSimd for Norms<'_> {
    type Output = [f64; SIZE];

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> [f64; SIZE] {
        let Self { points, matrix: m } = self;
        let mut sums = [0.0; SIZE];
        let of = Register::all(simd, 0.0);
        let (m11, m12, m21, m22) =
            (of.alike(m.m11), of.alike(m.m12), of.alike(m.m21), of.alike(m.m22));
        for register in 0..SIZE / S::F64_LANES {
            let mut added = Register::all(simd, 0.0);
            for block in &points.blocks {
                let x = Register::of(simd, &block.x, register);
                let y = Register::of(simd, &block.y, register);
                let share = Register::of(simd, &block.share, register);
                let (image_x, image_y) = (m11 * x + m12 * y, m21 * x + m22 * y);
                added = added + share * (image_x * image_x + image_y * image_y).root();
            }
            added.put(&mut sums, register);
        }
        sums
    }
}

/// The sum over the places of a block, always in the same order.
#[inline(always)]
fn total(sums: &[f64; SIZE]) -> f64 {
    let [a, b, c, d, e, f, g, h] = sums;
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

#[cfg(test)]
mod tests {
    use super::{Point, Points};
    use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
    use planar::perpendicular;

    fn points() -> Vec<Point> {
        let point = |k: usize| {
            let at = k as f64;
            let place = 0.04 * Vector2::new((1.7 * at).sin(), (2.3 * at).cos());
            Point { place, share: 0.02 + 0.001 * at, spin: 1e-4 * at }
        };
        (0..21).map(point).collect()
    }

    #[test]
    fn lanes_sum_what_single_points_sum() {
        let (points, stretch) = (points(), 1.1);
        let tensor = Matrix2::new(1.2, 0.1, 0.1, 0.9);
        let motion = Vector3::new(0.01, -0.02, 0.7);
        let (mut load, mut slope) = (Vector3::zeros(), Matrix3::zeros());
        for Point { place, share, spin } in &points {
            let arm = tensor * (stretch * perpendicular(place));
            let map = Matrix3::new(
                tensor.m11,
                tensor.m12,
                arm.x,
                tensor.m21,
                tensor.m22,
                arm.y,
                0.0,
                0.0,
                stretch * spin,
            );
            let image = map * motion;
            let unit = image / image.norm();
            load += *share * map.transpose() * unit;
            let across = Matrix3::identity() - unit * unit.transpose();
            slope += *share / image.norm() * map.transpose() * across * map;
        }
        let (lanes_load, lanes_slope) = Points::new(&points).load(&tensor, stretch, &motion);
        assert!((lanes_load - load).norm() < 1e-14 * load.norm());
        assert!((lanes_slope - slope).norm() < 1e-13 * slope.norm());
    }

    #[test]
    fn a_point_at_rest_adds_nothing() {
        let one = [Point { place: Vector2::new(0.01, 0.0), share: 1.0, spin: 1e-3 }];
        let (load, slope) = Points::new(&one).load(&Matrix2::identity(), 1.0, &Vector3::zeros());
        assert_eq!((load, slope), (Vector3::zeros(), Matrix3::zeros()));
    }

    #[test]
    fn the_mean_norm_is_that_of_the_points() {
        let points = points();
        let matrix = Matrix2::new(1.2, 0.1, 0.1, 0.9);
        let sum: f64 = points.iter().map(|point| point.share * (matrix * point.place).norm()).sum();
        assert!((Points::new(&points).mean_norm(&matrix) - sum).abs() < 1e-15);
    }
}
