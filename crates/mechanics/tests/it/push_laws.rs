//! Laws and known answers of the push at one contact.

use mechanics::{
    ContactMode, Ellipsoid, LimitSurface, MechanicsError, Patch, PointSet, Push, PushMotion,
    predict, predict_with_external_wrench,
};
use nalgebra::{Unit, UnitVector2, Vector2};
use planar::{Shape, Twist, Wrench};
use proptest::prelude::{ProptestConfig, Strategy, prop_assert, prop_assert_eq, proptest};

fn unit(angle: f64) -> UnitVector2<f64> {
    Unit::new_normalize(Vector2::new(angle.cos(), angle.sin()))
}

/// Upright ellipsoids about a point up to 0.05 m away from S, hence tilted.
fn surfaces() -> impl Strategy<Value = Ellipsoid> {
    (0.5..10.0f64, 0.005..0.2f64, -0.05..0.05f64, -0.05..0.05f64).prop_map(|(f_max, c, x, y)| {
        Ellipsoid::new(f_max, c * f_max).unwrap().shifted(&Vector2::new(x, y)).unwrap()
    })
}

/// Upright and centered ellipsoids: the origin of S is the center of friction.
fn centered() -> impl Strategy<Value = Ellipsoid> {
    (0.5..10.0f64, 0.005..0.2f64).prop_map(|(f_max, c)| Ellipsoid::new(f_max, c * f_max).unwrap())
}

/// Pushes at any point and normal, approaching or not, with friction 0 to 3.
fn pushes() -> impl Strategy<Value = Push> {
    let vector = |size: f64| (-size..size, -size..size).prop_map(|(x, y)| Vector2::new(x, y));
    (vector(0.1), -3.2..3.2f64, vector(0.2), 0.0..3.0f64).prop_map(
        |(p_sc, angle, v_wp_s, friction)| Push { p_sc, normal_s: unit(angle), v_wp_s, friction },
    )
}

fn square_push(y: f64, velocity: Vector2<f64>, friction: f64) -> Push {
    Push { p_sc: Vector2::new(-0.045, y), normal_s: Vector2::x_axis(), v_wp_s: velocity, friction }
}

fn ellipsoid() -> Ellipsoid {
    Ellipsoid::new(2.0, 2.0 * 0.3826 * 0.09).unwrap()
}

fn contact_velocity(push: &Push, motion: &PushMotion) -> Vector2<f64> {
    motion.twist_ws_s.velocity_at(&push.p_sc)
}

fn distance(a: &Twist, b: &Twist, c: f64) -> f64 {
    (a.linear - b.linear).norm().hypot(c * (a.angular - b.angular))
}

#[test]
fn push_through_the_friction_center_does_not_rotate() {
    let motion = predict(&ellipsoid(), &square_push(0.0, Vector2::new(0.02, 0.0), 0.3)).unwrap();
    assert_eq!(motion.mode, ContactMode::Sticking);
    assert_eq!(motion.twist_ws_s, Twist::new(0.02, 0.0, 0.0));
    assert!((motion.force_s - Vector2::new(2.0, 0.0)).norm() < 1e-15);
}

#[test]
fn sticking_follows_the_formula_of_lynch_with_c_in_the_denominators() {
    let (x, y, c2) = (-0.045, 0.01, (0.3826_f64 * 0.09).powi(2));
    let v = Vector2::new(0.02, 0.003);
    let motion = predict(&ellipsoid(), &square_push(y, v, 1.0)).unwrap();
    let denominator = c2 + x * x + y * y;
    let vx = ((c2 + x * x) * v.x + x * y * v.y) / denominator;
    let vy = (x * y * v.x + (c2 + y * y) * v.y) / denominator;
    let omega = (x * vy - y * vx) / c2;
    assert_eq!(motion.mode, ContactMode::Sticking);
    assert!(distance(&motion.twist_ws_s, &Twist::new(vx, vy, omega), 0.03) < 1e-16);
}

#[test]
fn velocity_and_load_are_in_the_ratio_of_the_ellipsoid() {
    let push = square_push(0.02, Vector2::new(0.02, 0.01), 0.25);
    let PushMotion { twist_ws_s: twist, force_s, .. } = predict(&ellipsoid(), &push).unwrap();
    let load = push.wrench_of(&force_s);
    let c2 = (0.3826_f64 * 0.09).powi(2);
    assert!((twist.linear.x / twist.angular - c2 * load.force.x / load.torque).abs() < 1e-15);
    assert!((twist.linear.y / twist.angular - c2 * load.force.y / load.torque).abs() < 1e-15);
}

#[test]
fn a_pusher_that_does_not_approach_leaves_the_object_at_rest() {
    for velocity in [Vector2::zeros(), Vector2::new(0.0, 0.02), Vector2::new(-0.02, 0.01)] {
        for friction in [0.0, 0.3, 1e6] {
            let motion = predict(&ellipsoid(), &square_push(0.01, velocity, friction)).unwrap();
            assert_eq!(motion.mode, ContactMode::Separated);
            assert_eq!(motion.twist_ws_s, Twist::default());
            assert_eq!(motion.force_s, Vector2::zeros());
            assert_eq!(motion.slip, velocity.y);
        }
    }
}

#[test]
fn without_friction_the_force_is_along_the_normal() {
    let push = square_push(0.01, Vector2::new(0.02, 0.02), 0.0);
    let motion = predict(&ellipsoid(), &push).unwrap();
    assert_eq!(motion.mode, ContactMode::SlidingLeft);
    assert_eq!(motion.force_s.y, 0.0);
}

#[test]
fn with_huge_friction_a_contact_sticks_unless_it_would_have_to_pull() {
    let mut n_sticking = 0;
    for angle in [-1.5_f64, -0.7, 0.0, 0.7, 1.5] {
        let v = 0.02 * unit(angle).into_inner();
        let push = square_push(0.045, v, 1e6);
        let (arm, c) = (planar::perpendicular(&push.p_sc), 0.3826 * 0.09);
        let needed = v - arm * arm.dot(&v) / (c * c + arm.norm_squared());
        let sticks = predict(&ellipsoid(), &push).unwrap().mode == ContactMode::Sticking;
        assert_eq!(sticks, needed.x > 0.0);
        n_sticking += usize::from(sticks);
    }
    assert!((1..5).contains(&n_sticking));
}

#[test]
fn bad_pushes_are_refused_with_their_value() {
    let good = square_push(0.0, Vector2::new(0.02, 0.0), 0.3);
    for general in [false, true] {
        let refuse = |push: Push| {
            let surface = ellipsoid();
            let result = if general {
                predict_with_external_wrench(&surface, &push, &Wrench::default())
            } else {
                predict(&surface, &push)
            };
            result.unwrap_err().to_string()
        };
        assert_eq!(
            refuse(Push { friction: -0.1, ..good }),
            "the friction coefficient must be finite and not negative, got -0.1 (dimensionless)"
        );
        let nan = Push { v_wp_s: Vector2::new(f64::NAN, 0.0), ..good };
        assert_eq!(refuse(nan), "the pusher's velocity must be finite, got NaN m/s");
        let far = Push { p_sc: Vector2::new(f64::INFINITY, 0.0), ..good };
        assert_eq!(refuse(far), "the contact point must be finite, got inf m");
    }
}

#[test]
fn a_load_beyond_the_limit_surface_is_refused() {
    let push = square_push(0.0, Vector2::new(0.02, 0.0), 0.3);
    let error =
        predict_with_external_wrench(&ellipsoid(), &push, &Wrench::new(3.0, 0.0, 0.0)).unwrap_err();
    assert_eq!(error, MechanicsError::SlidesByItself { level: 1.5 });
}

#[test]
fn a_load_along_the_push_lowers_the_pusher_s_force() {
    let push = square_push(0.0, Vector2::new(0.02, 0.0), 0.3);
    let motion =
        predict_with_external_wrench(&ellipsoid(), &push, &Wrench::new(0.5, 0.0, 0.0)).unwrap();
    assert_eq!(motion.mode, ContactMode::Sticking);
    assert!((motion.force_s - Vector2::new(1.5, 0.0)).norm() < 1e-12);
    assert!(distance(&motion.twist_ws_s, &Twist::new(0.02, 0.0, 0.0), 0.03) < 1e-15);
}

/// What must hold for any surface, external load and push that the solver is given.
fn check_laws(
    surface: &dyn LimitSurface,
    push: &Push,
    external: &Wrench,
    motion: &PushMotion,
    tolerance: f64,
) -> Result<(), String> {
    let law = |name: &str, holds: bool| {
        if holds { Ok(()) } else { Err(format!("{name}: {push:?} gave {motion:?}")) }
    };
    let (normal, tangent) = (push.normal_s.into_inner(), push.tangent_s());
    let (f_n, f_t) = (normal.dot(&motion.force_s), tangent.dot(&motion.force_s));
    let speed = push.v_wp_s.norm();
    let relative = push.v_wp_s - contact_velocity(push, motion);
    law("force in the cone", f_t.abs() <= push.friction * f_n + tolerance * motion.force_s.norm())?;
    law(
        "slip is the relative velocity",
        (tangent.dot(&relative) - motion.slip).abs() <= tolerance * speed,
    )?;
    match motion.mode {
        ContactMode::Separated => law("no approach", push.approach_speed() <= 0.0)?,
        ContactMode::Sticking => law("moves along", relative.norm() <= tolerance * speed)?,
        ContactMode::SlidingLeft | ContactMode::SlidingRight => {
            let side = if motion.mode == ContactMode::SlidingLeft { 1.0 } else { -1.0 };
            law("slips to its side", side * motion.slip > -tolerance * speed)?;
            law(
                "force on the edge",
                (f_t - side * push.friction * f_n).abs() < tolerance * motion.force_s.norm(),
            )?;
        }
    }
    if motion.mode != ContactMode::Separated {
        law("no penetration", normal.dot(&relative).abs() <= tolerance * speed)?;
        let load = push.wrench_of(&motion.force_s) + *external;
        law("on the surface", (surface.level(&load).unwrap() - 1.0).abs() < tolerance)?;
        let dissipated = surface.dissipation(&motion.twist_ws_s).unwrap();
        let balance = motion.force_s.dot(&push.v_wp_s) + external.power(&motion.twist_ws_s)
            - dissipated
            - f_t * motion.slip;
        let scale = dissipated + (f_t * motion.slip).abs();
        law("power balance", balance.abs() <= tolerance * scale)?;
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn the_closed_form_obeys_the_laws_of_contact(surface in surfaces(), push in pushes()) {
        let motion = predict(&surface, &push).unwrap();
        let outcome = check_laws(&surface, &push, &Wrench::default(), &motion, 1e-11);
        prop_assert_eq!(outcome, Ok(()));
    }

    #[test]
    fn the_general_solver_agrees_with_the_closed_form(surface in surfaces(), push in pushes()) {
        let closed = predict(&surface, &push).unwrap();
        let general = predict_with_external_wrench(&surface, &push, &Wrench::default()).unwrap();
        let c = surface.characteristic_length();
        prop_assert_eq!(closed.mode, general.mode);
        let error = distance(&closed.twist_ws_s, &general.twist_ws_s, c);
        prop_assert!(error <= 1e-9 * closed.twist_ws_s.linear.norm(), "{}", error);
        prop_assert!((closed.force_s - general.force_s).norm() <= 1e-9 * closed.force_s.norm());
        prop_assert!((closed.slip - general.slip).abs() <= 1e-9 * push.v_wp_s.norm());
    }

    #[test]
    fn external_loads_keep_the_laws(
        surface in surfaces(), push in pushes(), level in 0.0..0.95f64,
        direction in (-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64),
    ) {
        let c = surface.characteristic_length();
        let along = Wrench::new(direction.0, direction.1, c * direction.2);
        let external = level / surface.level(&along).unwrap() * along;
        let motion = predict_with_external_wrench(&surface, &push, &external).unwrap();
        prop_assert_eq!(check_laws(&surface, &push, &external, &motion, 1e-9), Ok(()));
    }

    #[test]
    fn a_mirrored_push_gives_the_mirrored_motion(surface in centered(), push in pushes()) {
        let mirror = |v: &Vector2<f64>| Vector2::new(v.x, -v.y);
        let mirrored = Push {
            p_sc: mirror(&push.p_sc),
            normal_s: Unit::new_unchecked(mirror(&push.normal_s)),
            v_wp_s: mirror(&push.v_wp_s),
            friction: push.friction,
        };
        let here = predict(&surface, &push).unwrap();
        let there = predict(&surface, &mirrored).unwrap();
        let swapped = match here.mode {
            ContactMode::SlidingLeft => ContactMode::SlidingRight,
            ContactMode::SlidingRight => ContactMode::SlidingLeft,
            mode => mode,
        };
        prop_assert_eq!(there.mode, swapped);
        prop_assert_eq!(there.force_s, mirror(&here.force_s));
        prop_assert_eq!(there.slip, -here.slip);
        prop_assert_eq!(there.twist_ws_s.linear, mirror(&here.twist_ws_s.linear));
        prop_assert_eq!(there.twist_ws_s.angular, -here.twist_ws_s.angular);
    }

    #[test]
    fn a_faster_push_moves_faster_under_the_same_force(
        surface in surfaces(), push in pushes(), exponent in -3..6i32,
    ) {
        let scale = 2.0_f64.powi(exponent);
        let slow = predict(&surface, &push).unwrap();
        let fast = predict(&surface, &Push { v_wp_s: scale * push.v_wp_s, ..push }).unwrap();
        prop_assert_eq!(fast.mode, slow.mode);
        prop_assert_eq!(fast.twist_ws_s, scale * slow.twist_ws_s);
        prop_assert!((fast.force_s - slow.force_s).norm() <= 1e-14 * slow.force_s.norm());
    }

    #[test]
    fn a_reversed_push_is_not_undone(surface in surfaces(), push in pushes()) {
        let there = predict(&surface, &push).unwrap();
        let back = predict(&surface, &Push { v_wp_s: -push.v_wp_s, ..push }).unwrap();
        let separated = [there.mode, back.mode].iter().filter(|&&mode| mode == ContactMode::Separated).count();
        prop_assert_eq!(separated, 1);
    }
}

#[test]
fn the_solver_keeps_the_laws_on_the_patch_and_agrees_with_a_fine_point_set() {
    let square = Shape::square(0.09).unwrap();
    let patch = Patch::uniform(&square, 2.0).unwrap();
    let points = PointSet::sampling(&square, 2.0, 2500).unwrap();
    for (y, angle, friction) in [(0.01, 0.1, 0.5), (0.03, -0.2, 0.3), (-0.02, 0.9, 0.3)] {
        let push = square_push(y, 0.02 * unit(angle).into_inner(), friction);
        let exact = predict(&patch, &push).unwrap();
        let sampled = predict(&points, &push).unwrap();
        assert_eq!(check_laws(&patch, &push, &Wrench::default(), &exact, 1e-7), Ok(()));
        assert_eq!(check_laws(&points, &push, &Wrench::default(), &sampled, 1e-7), Ok(()));
        let error = distance(&exact.twist_ws_s, &sampled.twist_ws_s, 0.035);
        assert!(error < 1e-3 * 0.02, "{y} {angle}: {error:e} m/s");
        assert_eq!(exact.mode, sampled.mode);
    }
}
