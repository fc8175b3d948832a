//! Motion cone, centers of rotation and the vote on the sense of rotation.

use mechanics::{
    CenterOfRotation, ContactMode, Ellipsoid, LimitSurface, MotionCone, Patch, PointSet, Push,
    QuadraticTraction, Sense, predict, predict_with_external_wrench, sense_of_rotation,
};
use nalgebra::{Unit, Vector2};
use planar::{Polygon, Shape, Twist, Wrench, cross, perpendicular};
use proptest::prelude::{ProptestConfig, Strategy, prop_assert, prop_assert_eq, proptest};

fn pushes() -> impl Strategy<Value = Push> {
    (-0.1..0.1f64, -0.1..0.1f64, -3.2..3.2f64, -1.5..1.5f64, 0.0..2.0f64).prop_map(
        |(x, y, normal, beta, friction)| {
            let direction = |a: f64| Vector2::new(a.cos(), a.sin());
            Push {
                p_sc: Vector2::new(x, y),
                normal_s: Unit::new_normalize(direction(normal)),
                v_wp_s: 0.02 * direction(normal + beta),
                friction,
            }
        },
    )
}

#[test]
fn a_pure_translation_has_a_direction_and_no_center() {
    let center = CenterOfRotation::of(&Twist::new(3.0, 4.0, 0.0));
    let CenterOfRotation::Translation(direction) = center else { panic!("{center:?}") };
    assert_eq!(direction.into_inner(), Vector2::new(0.6, 0.8));
    assert_eq!(center.twist(5.0), Twist::new(3.0, 4.0, 0.0));
    assert_eq!(CenterOfRotation::of(&Twist::default()), CenterOfRotation::Rest);
    assert_eq!(CenterOfRotation::Rest.twist(1.0), Twist::default());
}

#[test]
fn a_push_straight_at_the_center_of_friction_is_a_tie() {
    let push = Push {
        p_sc: Vector2::new(-0.05, 0.0),
        normal_s: Vector2::x_axis(),
        v_wp_s: Vector2::new(0.02, 0.0),
        friction: 0.3,
    };
    assert_eq!(sense_of_rotation(&push), Ok(Sense::None));
    let oblique = Push { v_wp_s: Vector2::new(0.02, 0.001), ..push };
    assert_eq!(sense_of_rotation(&oblique), Ok(Sense::Clockwise));
    let leaving = Push { v_wp_s: Vector2::new(-0.02, 0.001), ..push };
    assert_eq!(sense_of_rotation(&leaving), Ok(Sense::None));
    let beside = Vector2::new(-0.05, 0.02);
    let along = Push { p_sc: beside, v_wp_s: Vector2::new(0.0, 0.02), ..push };
    assert_eq!(sense_of_rotation(&along), Ok(Sense::None));
}

#[test]
fn an_edge_of_the_cone_and_a_velocity_through_the_center_turn_nothing() {
    let push = Push {
        p_sc: Vector2::new(-0.5, -0.125),
        normal_s: Vector2::x_axis(),
        v_wp_s: Vector2::new(1.0, 0.25),
        friction: 0.25,
    };
    assert_eq!(sense_of_rotation(&push), Ok(Sense::None));
    let motion = predict(&Ellipsoid::new(2.0, 0.4).unwrap(), &push).unwrap();
    assert!(motion.twist_ws_s.angular.abs() < 1e-15, "{motion:?}");
    // Without friction the force is through the center, whatever the velocity.
    let oblique = Push { p_sc: Vector2::new(-0.5, 0.0), friction: 0.0, ..push };
    assert_eq!(sense_of_rotation(&oblique), Ok(Sense::None));
}

/// Uneven pressures of all kinds, their center of friction at the origin.
fn pressures() -> Vec<Box<dyn LimitSurface>> {
    let set = |points: &[(f64, f64, f64)]| -> Box<dyn LimitSurface> {
        let total: f64 = points.iter().map(|p| p.2).sum();
        let center: Vector2<f64> =
            points.iter().map(|p| p.2 / total * Vector2::new(p.0, p.1)).sum();
        let centered = points.iter().map(|p| (Vector2::new(p.0, p.1) - center, p.2));
        Box::new(PointSet::new(centered).unwrap())
    };
    let many: Vec<_> = (0..23)
        .map(|k| {
            let part = |step: f64| (f64::from(k) * step).fract() - 0.5;
            (0.1 * part(0.618), 0.08 * part(0.414), 0.1 + (f64::from(k) * 0.733).fract())
        })
        .collect();
    let corners = [(-0.05, -0.04), (0.06, -0.03), (0.0, 0.05)];
    let corners: Vec<_> = corners.iter().map(|p| Vector2::new(p.0, p.1)).collect();
    let ramp = [900.0, 6000.0, -5000.0, 1e5];
    let triangle = |shift: &Vector2<f64>| {
        let moved = corners.iter().map(|corner| corner - shift).collect();
        let traction = QuadraticTraction(ramp);
        let [_, x, y, squared] = ramp;
        let slope = Vector2::new(x, y) + 2.0 * squared * shift;
        let moved_ramp = QuadraticTraction([traction.at(shift), slope.x, slope.y, squared]);
        Patch::quadratic(&Shape::Polygon(Polygon::new(moved).unwrap()), moved_ramp).unwrap()
    };
    let patch = triangle(triangle(&Vector2::zeros()).center_of_friction());
    assert!(patch.center_of_friction().norm() < 1e-15);
    vec![
        set(&[(0.0, 0.05, 1.0), (-0.04, -0.03, 0.8), (0.05, -0.02, 0.3)]),
        set(&[(0.045, 0.045, 0.1), (-0.045, 0.04, 0.9), (-0.04, -0.045, 0.5), (0.05, -0.03, 0.4)]),
        set(&many),
        Box::new(patch),
    ]
}

/// Pushes whose rays pass the origin exactly or by much: all numbers are small multiples of powers of
/// two, so that moments are exact.
fn even_pushes() -> impl Strategy<Value = Push> {
    (-4..=4i32, -4..=4i32, 0..4usize, 0..=4i32, 1..=4i32, -8..=8i32).prop_map(
        |(x, y, side, friction, ahead, aside)| {
            let normal_s =
                [Vector2::x_axis(), Vector2::y_axis(), -Vector2::x_axis(), -Vector2::y_axis()]
                    [side];
            let along = f64::from(ahead) / 64.0 * normal_s.into_inner();
            let v_wp_s = along + f64::from(aside) / 64.0 * perpendicular(&normal_s);
            let p_sc = Vector2::new(f64::from(x), f64::from(y)) / 64.0;
            Push { p_sc, normal_s, v_wp_s, friction: f64::from(friction) / 4.0 }
        },
    )
}

#[test]
fn a_velocity_on_the_edge_of_the_motion_cone_sticks() {
    // Without friction the cone is one ray; through the center no rounding moves it.
    let push = Push {
        p_sc: Vector2::new(-0.05, 0.0),
        normal_s: Vector2::x_axis(),
        v_wp_s: Vector2::new(0.02, 0.0),
        friction: 0.0,
    };
    let surface = Ellipsoid::new(2.0, 0.08).unwrap();
    let cone = MotionCone::new(&surface, &push).unwrap();
    assert!(cone.contains(&push.v_wp_s) && !cone.contains(&-push.v_wp_s));
    assert_eq!(predict(&surface, &push).unwrap().mode, ContactMode::Sticking);
    let general = predict_with_external_wrench(&surface, &push, &Wrench::default()).unwrap();
    assert_eq!(general.mode, ContactMode::Sticking);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn a_twist_and_its_center_of_rotation_say_the_same(
        vx in -1.0..1.0f64, vy in -1.0..1.0f64, omega in -3.0..3.0f64,
    ) {
        let twist = Twist::new(vx, vy, omega);
        let center = CenterOfRotation::of(&twist);
        let CenterOfRotation::Point { at, .. } = center else { panic!("{center:?}") };
        prop_assert!(twist.velocity_at(&at).norm() < 1e-12);
        let back = center.twist(omega.abs());
        prop_assert!((back - twist).to_vector().norm() < 1e-12);
    }

    #[test]
    fn the_vote_is_won_by_the_way_the_object_turns(push in pushes(), c in 0.005..0.2f64) {
        let motion = predict(&Ellipsoid::new(2.0, 2.0 * c).unwrap(), &push).unwrap();
        prop_assert_eq!(sense_of_rotation(&push).unwrap(), Sense::of(motion.twist_ws_s.angular));
    }

    #[test]
    fn the_vote_is_won_by_the_way_the_object_turns_under_any_pressure(push in even_pushes()) {
        for surface in pressures() {
            let motion = predict(surface.as_ref(), &push).unwrap();
            let turn = surface.characteristic_length() * motion.twist_ws_s.angular;
            let turns = if turn.abs() <= 1e-9 * push.v_wp_s.norm() { 0.0 } else { turn };
            prop_assert_eq!(sense_of_rotation(&push).unwrap(), Sense::of(turns), "{:?}", motion);
        }
    }

    /// On an ellipsoid, a force whose line passes the center at a distance d turns the object about
    /// the point opposite to it at c²/d: the centers need no limit surface.
    #[test]
    fn both_constructions_of_the_motion_cone_agree(push in pushes(), c in 0.005..0.2f64) {
        let cone = MotionCone::new(&Ellipsoid::new(2.0, 2.0 * c).unwrap(), &push).unwrap();
        let centers = [1.0, -1.0].map(|side| {
            let edge = push.normal_s.into_inner() + side * push.friction * push.tangent_s();
            let edge = edge.normalize();
            let arm = cross(&push.p_sc, &edge);
            CenterOfRotation::Point { at: c * c / arm * perpendicular(&edge), sense: Sense::of(arm) }
        });
        let edges = MotionCone::edges_from_centers(&push.p_sc, &centers).unwrap();
        prop_assert!((edges[0].into_inner() - cone.left.into_inner()).norm() < 1e-9);
        prop_assert!((edges[1].into_inner() - cone.right.into_inner()).norm() < 1e-9);
        for (ours, theirs) in cone.centers().iter().zip(&centers) {
            let (CenterOfRotation::Point { at: a, sense: s }, CenterOfRotation::Point { at: b, sense: t }) =
                (ours, theirs) else { panic!("{ours:?} {theirs:?}") };
            prop_assert!((a - b).norm() <= 1e-9 * b.norm());
            prop_assert_eq!(s, t);
        }
    }

    #[test]
    fn the_contact_sticks_exactly_within_the_motion_cone(push in pushes(), c in 0.005..0.2f64) {
        let surface = Ellipsoid::new(2.0, 2.0 * c).unwrap();
        let sticks = predict(&surface, &push).unwrap().mode == ContactMode::Sticking;
        let cone = MotionCone::new(&surface, &push).unwrap();
        prop_assert_eq!(cone.contains(&push.v_wp_s), sticks);
    }
}
