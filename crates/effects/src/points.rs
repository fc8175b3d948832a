//! Sums over the points that stand for a support, a few at a time.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
use pulp::{Arch, WithSimd};

use crate::friction::Load;

/// Points from the center of a support with their shares of the load, in lanes.
#[derive(Clone, Debug)]
pub(crate) struct Points {
    lanes: Vec<Lanes>,
}

/// Points side by side; what is over has no share.
#[derive(Clone, Copy, Debug, Default)]
struct Lanes {
    x: [f64; WIDTH],
    y: [f64; WIDTH],
    share: [f64; WIDTH],
}

const WIDTH: usize = 8;

impl Points {
    pub(crate) fn new(points: &[(Vector2<f64>, f64)]) -> Self {
        let lanes = points.chunks(WIDTH).map(|chunk| {
            let mut lanes = Lanes::default();
            for (k, (place, share)) in chunk.iter().enumerate() {
                (lanes.x[k], lanes.y[k], lanes.share[k]) = (place.x, place.y, *share);
            }
            lanes
        });
        Self { lanes: lanes.collect() }
    }

    /// Σ of each point's share of T² v/|T v|, with its moment, and its derivatives by the motion.
    ///
    /// v = (vx, vy) + ω J `stretch` r. The order of the sum does not depend on the machine.
    pub(crate) fn load(&self, tensor: &Matrix2<f64>, stretch: f64, motion: &Vector3<f64>) -> Load {
        let sums = Arch::new().dispatch(Pass { points: self, tensor, stretch, motion });
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
        Arch::new().dispatch(Norms { points: self, matrix })
    }
}

/// One pass for the sum of norms.
struct Norms<'a> {
    points: &'a Points,
    matrix: &'a Matrix2<f64>,
}

impl WithSimd for Norms<'_> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> f64 {
        let m = self.matrix;
        let (m11, m12, m21, m22) = (m.m11, m.m12, m.m21, m.m22);
        let mut sums = [0.0; WIDTH];
        for lanes in &self.points.lanes {
            for k in 0..WIDTH {
                let (x, y) = (lanes.x[k], lanes.y[k]);
                let (image_x, image_y) = (m11 * x + m12 * y, m21 * x + m22 * y);
                sums[k] += lanes.share[k] * (image_x * image_x + image_y * image_y).sqrt();
            }
        }
        sums.iter().sum()
    }
}

/// One pass over all points.
struct Pass<'a> {
    points: &'a Points,
    tensor: &'a Matrix2<f64>,
    stretch: f64,
    motion: &'a Vector3<f64>,
}

impl WithSimd for Pass<'_> {
    type Output = [f64; 9];

    /// Plain loops over lanes, which the compiler turns into the machine's widest instructions.
    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Self::Output {
        let Self { points, tensor, stretch, motion } = self;
        let (m11, m12, m21, m22) = (tensor.m11, tensor.m12, tensor.m21, tensor.m22);
        let mut sums = [[0.0; WIDTH]; 9];
        for lanes in &points.lanes {
            for k in 0..WIDTH {
                let (arm_x, arm_y) = (-stretch * lanes.y[k], stretch * lanes.x[k]);
                let (vx, vy) = (motion.x + motion.z * arm_x, motion.y + motion.z * arm_y);
                let (image_x, image_y) = (m11 * vx + m12 * vy, m21 * vx + m22 * vy);
                let (turned_x, turned_y) = (m11 * arm_x + m12 * arm_y, m21 * arm_x + m22 * arm_y);
                let square = image_x * image_x + image_y * image_y;
                let inverse = if square > 0.0 { 1.0 / square.sqrt() } else { 0.0 };
                let (ux, uy) = (image_x * inverse, image_y * inverse);
                let (along, across) =
                    (turned_x * ux + turned_y * uy, turned_y * ux - turned_x * uy);
                let share = lanes.share[k];
                let weight = share * inverse;
                // The direction across u is (−u_y, u_x).
                sums[0][k] += share * ux;
                sums[1][k] += share * uy;
                sums[2][k] += share * along;
                sums[3][k] += weight * uy * uy;
                sums[4][k] -= weight * ux * uy;
                sums[5][k] += weight * ux * ux;
                sums[6][k] -= weight * uy * across;
                sums[7][k] += weight * ux * across;
                sums[8][k] += weight * across * across;
            }
        }
        sums.map(|lanes| lanes.iter().sum())
    }
}

#[cfg(test)]
mod tests {
    use super::Points;
    use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};
    use planar::perpendicular;

    fn points() -> Vec<(Vector2<f64>, f64)> {
        let point = |k: usize| {
            let at = k as f64;
            (0.04 * Vector2::new((1.7 * at).sin(), (2.3 * at).cos()), 0.02 + 0.001 * at)
        };
        (0..21).map(point).collect()
    }

    #[test]
    fn lanes_sum_what_single_points_sum() {
        let (points, stretch) = (points(), 1.1);
        let tensor = Matrix2::new(1.2, 0.1, 0.1, 0.9);
        let motion = Vector3::new(0.01, -0.02, 0.7);
        let (mut load, mut slope) = (Vector3::zeros(), Matrix3::zeros());
        for (place, share) in &points {
            let arm = stretch * perpendicular(place);
            let map = nalgebra::Matrix2x3::from_columns(&[
                tensor.column(0).into(),
                tensor.column(1).into(),
                tensor * arm,
            ]);
            let image = map * motion;
            let unit = image / image.norm();
            load += *share * map.transpose() * unit;
            let across = map.transpose() * perpendicular(&unit);
            slope += *share / image.norm() * across * across.transpose();
        }
        let (lanes_load, lanes_slope) = Points::new(&points).load(&tensor, stretch, &motion);
        assert!((lanes_load - load).norm() < 1e-14 * load.norm());
        assert!((lanes_slope - slope).norm() < 1e-13 * slope.norm());
    }

    #[test]
    fn a_point_at_rest_adds_nothing() {
        let one = [(Vector2::new(0.01, 0.0), 1.0)];
        let (load, slope) = Points::new(&one).load(&Matrix2::identity(), 1.0, &Vector3::zeros());
        assert_eq!((load, slope), (Vector3::zeros(), Matrix3::zeros()));
    }

    #[test]
    fn the_mean_norm_is_that_of_the_points() {
        let points = points();
        let matrix = Matrix2::new(1.2, 0.1, 0.1, 0.9);
        let sum: f64 = points.iter().map(|(place, share)| share * (matrix * place).norm()).sum();
        assert!((Points::new(&points).mean_norm(&matrix) - sum).abs() < 1e-15);
    }
}
