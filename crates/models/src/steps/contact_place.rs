//! Where a contact is for the friction of the support: numbers that outlines have in common.

use std::sync::Arc;

use nalgebra::{Matrix3, Vector2, Vector3};
use planar::{Shape, cross, perpendicular};

use crate::{StepInput, StepPrediction};

/// The places of many contacts; what is known of an outline is kept for the steps after.
#[derive(Default)]
pub(crate) struct ContactPlaces {
    last: Option<Known>,
}

#[derive(Clone)]
struct Known {
    shape: Arc<Shape>,
    centroid_b: Vector2<f64>,
    mean_distance: f64,
}

/// A contact seen from the centroid, and how the motion of the centroid is told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ContactPlace {
    /// The torque of a unit force along the inward normal, over ρ; counter-clockwise positive.
    lever: f64,
    /// How far the centroid is behind the contact, along the inward normal, over ρ.
    depth: f64,
    /// Of the outline, times ρ: 0 on an edge, positive where it bulges.
    curvature: f64,
    /// ρ: the mean distance of the area from its centroid, in m.
    mean_distance: f64,
    /// From the centroid to the body frame's origin, along and to the left of the push, in m.
    origin: Vector2<f64>,
}

impl ContactPlaces {
    /// The place of a step's contact.
    pub(crate) fn of(&mut self, step: &StepInput) -> ContactPlace {
        let shape = step.shared_shape();
        let known = match &self.last {
            Some(known) if Arc::ptr_eq(&known.shape, shape) => known,
            _ => {
                let centroid_b = shape.centroid();
                let mean_distance = shape.mean_distance(&centroid_b);
                self.last.insert(Known { shape: shape.clone(), centroid_b, mean_distance })
            }
        };
        let point = shape.point_at(step.edge(), step.p());
        let normal = shape.inward_normal_at(step.edge(), step.p());
        let (arm, rho) = (point - known.centroid_b, known.mean_distance);
        let along = step.direction_b();
        let origin = -known.centroid_b;
        ContactPlace {
            lever: cross(&arm, &normal) / rho,
            depth: -arm.dot(&normal) / rho,
            curvature: curvature(shape, &point) * rho,
            mean_distance: rho,
            origin: Vector2::new(along.dot(&origin), perpendicular(&along).dot(&origin)),
        }
    }
}

impl ContactPlace {
    /// What a process learns from, without dimension.
    pub(crate) fn inputs(&self) -> [f64; 3] {
        [self.lever, self.depth, self.curvature]
    }

    /// The outputs (m, m, rad) of the body frame's origin as those of the centroid, with Δθ ρ in m.
    ///
    /// Linear in Δθ, so that it holds for residuals too: the arc of a turn is taken as its tangent.
    pub(crate) fn to_common(self, outputs: &Vector3<f64>) -> Vector3<f64> {
        let turned = outputs.z * perpendicular(&self.origin);
        Vector3::new(outputs.x - turned.x, outputs.y - turned.y, outputs.z * self.mean_distance)
    }

    /// What was said of the centroid, as outputs of the origin.
    pub(crate) fn mean_of(self, common: &Vector3<f64>) -> Vector3<f64> {
        self.back() * common
    }

    /// The same with its covariance.
    pub(crate) fn prediction_of(self, common: &StepPrediction) -> StepPrediction {
        let back = self.back();
        let covariance = back * common.covariance * back.transpose();
        let covariance = 0.5 * (covariance + covariance.transpose());
        StepPrediction { mean: back * common.mean, covariance }
    }

    fn back(&self) -> Matrix3<f64> {
        let per_turn = perpendicular(&self.origin) / self.mean_distance;
        let mut back = Matrix3::identity();
        back[(0, 2)] = per_turn.x;
        back[(1, 2)] = per_turn.y;
        back[(2, 2)] = 1.0 / self.mean_distance;
        back
    }
}

/// Of the outline at one of its points, in 1/m.
fn curvature(shape: &Shape, point: &Vector2<f64>) -> f64 {
    match shape {
        Shape::Polygon(_) => 0.0,
        Shape::Ellipse(ellipse) => {
            let (a, b) = ellipse.semi_axes();
            // ab/|dr/dψ|³ at the point (a cos ψ, b sin ψ).
            let speed = (a * point.y / b).hypot(b * point.x / a);
            a * b / speed.powi(3)
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;
    use std::sync::Arc;

    use nalgebra::{Vector2, Vector3};
    use planar::{Ellipse, Polygon, Pose, Shape};
    use proptest::prelude::{ProptestConfig, prop_assert, proptest};

    use super::{ContactPlace, ContactPlaces};
    use crate::{Analytical, StepInput};

    fn step(shape: Shape, edge: usize, p: f64, beta: f64) -> StepInput {
        StepInput::on_edge(Arc::new(shape), 0.005, edge, p, beta, 0.004).unwrap()
    }

    fn place(step: &StepInput) -> ContactPlace {
        ContactPlaces::default().of(step)
    }

    const CORNERS: [[f64; 2]; 3] = [[-0.05, -0.03], [0.07, -0.04], [0.01, 0.06]];

    /// The triangle with its body frame elsewhere, and so many times as large.
    fn triangle(pose: &Pose, size: f64) -> Shape {
        let vertices = CORNERS.map(|[x, y]| pose.transform_point(&(size * Vector2::new(x, y))));
        Shape::Polygon(Polygon::new(vertices.to_vec()).unwrap())
    }

    fn near(a: &ContactPlace, b: &ContactPlace) -> bool {
        a.inputs().iter().zip(b.inputs()).all(|(a, b)| (a - b).abs() < 1e-9)
    }

    #[test]
    fn a_disc_has_one_place_with_a_depth_and_a_curvature_of_three_halves() {
        for k in 0..12 {
            let disc = Shape::Ellipse(Ellipse::disc(0.04).unwrap());
            let [lever, depth, curvature] =
                place(&step(disc, 0, f64::from(k) / 12.0, 0.3)).inputs();
            // ρ is two thirds of the radius.
            assert!(lever.abs() < 1e-9 && (depth - 1.5).abs() < 1e-9);
            assert!((curvature - 2.0 / 3.0).abs() < 1e-9);
        }
    }

    #[test]
    fn the_curvature_at_the_ends_of_an_ellipse_is_that_of_its_circles() {
        let (a, b) = (0.06, 0.04);
        let ellipse = || Shape::Ellipse(Ellipse::new(a, b).unwrap());
        for (p, expected) in [(0.0, a / (b * b)), (0.25, b / (a * a)), (0.5, a / (b * b))] {
            let place = place(&step(ellipse(), 0, p, 0.0));
            assert!((place.curvature / place.mean_distance / expected - 1.0).abs() < 1e-6);
        }
    }

    #[test]
    fn a_push_right_of_the_centroid_has_a_counter_clockwise_lever() {
        // Edge 0 of a square is its lower one, from left to right.
        let at = |p: f64| place(&step(Shape::square(0.09).unwrap(), 0, p, 0.0)).inputs()[0];
        assert!(at(0.75) > 0.1 && at(0.5).abs() < 1e-12 && at(0.25) < -0.1);
    }

    #[test]
    fn outputs_come_back_and_those_of_the_centroid_do_not_depend_on_the_frame() {
        let model = Analytical::nominal(0.25).unwrap();
        let pose = Pose::new(0.02, -0.03, 0.0);
        let outputs = |shape: Shape| {
            let step = step(shape, 1, 0.3, 0.4);
            let place = place(&step);
            (place, step.outputs(&model.motion(&step).unwrap()))
        };
        let (here, one) = outputs(triangle(&Pose::new(0.0, 0.0, 0.0), 1.0));
        let (there, two) = outputs(triangle(&pose, 1.0));
        assert!((one - two).xy().norm() > 1e-4, "the origins move alike");
        // What the arc is longer than its tangent: half of the turn's square times the distance.
        let limit = 0.5 * one.z.powi(2) * 0.05;
        assert!((here.to_common(&one) - there.to_common(&two)).norm() < limit);
        for (place, outputs) in [(here, one), (there, two)] {
            let back = place.mean_of(&place.to_common(&outputs));
            assert!((back - outputs).norm() < 1e-15);
        }
        assert!(here.to_common(&Vector3::x()) == Vector3::x());
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn inputs_do_not_change_with_the_frame_or_the_size_of_an_object(
            p in 0.0..1.0, beta in -1.0..1.0, x in -0.1..0.1, y in -0.1..0.1,
            angle in 0.0..TAU, size in 0.5..2.0, edge in 0usize..3,
        ) {
            let pose = Pose::new(x, y, angle);
            let here = place(&step(triangle(&Pose::new(0.0, 0.0, 0.0), 1.0), edge, p, beta));
            let there = place(&step(triangle(&pose, size), edge, p, beta));
            prop_assert!(near(&here, &there), "{here:?} {there:?}");
        }
    }
}
