//! What a uniform pressure does, on every MIT shape: the centroids of the triangles are not the origin.

use mechanics::{
    Ellipsoid, LimitSurface, Patch, PathSettings, PushMotion, Pusher, Slider, StraightPath,
    UniformSupport, push_along,
};
use nalgebra::Vector2;
use planar::{Contact, Feature, MIT_NAMES, Pose, Shape, Twist, mit_object};

const SPEED: f64 = 0.02;

/// A frictionless push whose normal is the ray to the centroid, if one meets an edge so.
fn central_pushes(shape: &Shape) -> Vec<Contact> {
    let center = shape.centroid();
    let normals = (0..shape.n_edges()).map(|edge| shape.inward_normal_at(edge, 0.25));
    normals
        .map(|normal| shape.contact(&(center - 0.3 * normal), 0.0))
        .filter(|contact| contact.feature == Feature::Edge)
        .filter(|contact| planar::cross(&contact.normal, &(center - contact.point)).abs() < 1e-12)
        .collect()
}

fn pushed(slider: &Slider<'_>, contact: &Contact) -> PushMotion {
    let pusher = Pusher { radius: 0.005, friction: 0.0 };
    let velocity = SPEED * contact.normal;
    let push = slider.push_at(&pusher, &Pose::default(), contact, &velocity);
    slider.velocity(&push, &Pose::default()).unwrap().0
}

#[test]
fn a_push_through_the_centroid_of_a_uniform_object_does_not_turn_it() {
    for name in MIT_NAMES {
        let shape = mit_object(name).unwrap().shape;
        let center = shape.centroid();
        let support = UniformSupport::new(&shape, 2.0).unwrap();
        let (in_body, patch) =
            (Ellipsoid::uniform(&shape, 2.0).unwrap(), Patch::uniform(&shape, 2.0).unwrap());
        let own = |surface| Slider { shape: &shape, surface, pose_bs: Pose::default() };
        let sliders = [support.slider(&shape), own(&in_body), own(&patch)];
        let pushes = central_pushes(&shape);
        assert!(!pushes.is_empty(), "{name}");
        for contact in pushes {
            for (kind, slider) in sliders.iter().enumerate() {
                let turn = pushed(slider, &contact).twist_ws_s.angular;
                assert!(turn.abs() * 0.05 < 1e-8 * SPEED, "{name}, slider {kind}: {turn} rad/s");
            }
            // Through the centroid of a triangle a surface that is moved there twice turns.
            let twice = Slider { pose_bs: Pose::new(center.x, center.y, 0.0), ..own(&in_body) };
            let turn = pushed(&twice, &contact).twist_ws_s.angular;
            let arm = planar::cross(&contact.normal, &center).abs();
            assert_eq!(arm > 1e-5, turn.abs() > 1e-3, "{name}: {arm} m, {turn} rad/s");
        }
    }
}

#[test]
fn a_uniform_object_goes_the_same_way_in_its_own_frame_and_about_its_centroid() {
    let shape = mit_object("tri1").unwrap().shape;
    let support = UniformSupport::new(&shape, 2.0).unwrap();
    let in_body = Ellipsoid::uniform(&shape, 2.0).unwrap();
    let own = Slider { shape: &shape, surface: &in_body, pose_bs: Pose::default() };
    let pusher = Pusher { radius: 0.005, friction: 0.3 };
    let normal = shape.inward_normal_at(0, 0.4);
    let path = StraightPath {
        start_w: shape.point_at(0, 0.4) - pusher.radius * normal,
        velocity_w: SPEED * normal,
        duration: 1.0,
    };
    let end = |slider: &Slider<'_>| {
        push_along(slider, &pusher, &path, &Pose::default(), &PathSettings::default())
            .unwrap()
            .pose_wb
    };
    let (one, other) = (end(&support.slider(&shape)), end(&own));
    assert!(
        (one.position - other.position).norm() < 2e-8 && (one.angle - other.angle).abs() < 1e-6
    );
    assert!(one.angle.abs() > 0.01);
}

/// The ellipsoid of uniform pressure is upright about the centroid. That through the true loads of two
/// translations and a turn has a net force in the turn where the center of torsion is another point than
/// the center of friction: there, a push through the centroid turns it.
#[test]
fn the_ellipsoid_through_the_true_loads_of_a_triangle_is_another_one() {
    for (name, is_triangle) in [("rect1", false), ("hex", false), ("tri1", true), ("tri3", true)] {
        let shape = mit_object(name).unwrap().shape;
        let center: Vector2<f64> = shape.centroid();
        let uniform = UniformSupport::new(&shape, 1.0).unwrap();
        let tilted = Ellipsoid::through_loads(&Patch::uniform(&shape, 1.0).unwrap()).unwrap();
        let turn = Twist::new(0.0, 0.0, 1.0);
        assert!(uniform.surface().wrench(&turn).unwrap().force.norm() < 1e-14, "{name}");
        let about_center = tilted.shifted(&center).unwrap();
        let net = about_center.wrench(&turn).unwrap().force.norm();
        assert_eq!(net > 0.03, is_triangle, "{name}: {net}");
        let slider = Slider { shape: &shape, surface: &tilted, pose_bs: Pose::default() };
        let turns = central_pushes(&shape)
            .iter()
            .any(|contact| pushed(&slider, contact).twist_ws_s.angular.abs() * 0.05 > 1e-3 * SPEED);
        assert_eq!(turns, is_triangle, "{name}");
    }
}
