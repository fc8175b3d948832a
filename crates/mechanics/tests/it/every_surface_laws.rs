//! What the push obeys on every limit surface, facets and quartics among them.

use crate::surfaces::{Lopsided, Row, rows};
use mechanics::{
    ContactMode, Ellipsoid, LimitSurface, MechanicsError, PathMotion, PathSettings, Push,
    PushMotion, Pusher, PusherPath, Slider, SmoothPath, StraightPath, predict,
    predict_multi_contact, predict_with_external_wrench, push_along,
};
use nalgebra::{Unit, UnitVector2, Vector2};
use planar::{Pose, Shape, Twist, Wrench};
use proptest::prelude::{ProptestConfig, Strategy, prop_assert, prop_assert_eq, proptest};

/// Relative accuracy of loads and motions that is asked of all.
const TOLERANCE: f64 = 1e-7;
/// Powers of ten of the speeds at which a push is the same push, in m/s.
const EXPONENTS: [i32; 10] = [-300, -220, -165, -155, -80, -10, 0, 40, 100, 150];

fn unit(angle: f64) -> UnitVector2<f64> {
    Unit::new_normalize(Vector2::new(angle.cos(), angle.sin()))
}

/// Pushes that approach, or not, at any point, with friction 0 to 2.
fn pushes() -> impl Strategy<Value = Push> {
    (-0.08..0.08f64, -0.08..0.08f64, -3.2..3.2f64, -1.7..1.7f64, 0.0..2.0f64).prop_map(
        |(x, y, normal, beta, friction)| Push {
            p_sc: Vector2::new(x, y),
            normal_s: unit(normal),
            v_wp_s: 0.02 * unit(normal + beta).into_inner(),
            friction,
        },
    )
}

/// Contact condition, friction cone, on the surface, and no load within it that dissipates more.
fn check(
    surface: &dyn LimitSurface,
    push: &Push,
    external: &Wrench,
    motion: &PushMotion,
) -> Result<(), String> {
    let law = |name: &str, holds: bool| {
        if holds { Ok(()) } else { Err(format!("{name}: {push:?} gave {motion:?}")) }
    };
    let (normal, tangent) = (push.normal_s.into_inner(), push.tangent_s());
    let (f_n, f_t) = (normal.dot(&motion.force_s), tangent.dot(&motion.force_s));
    let (speed, size) = (push.v_wp_s.norm(), motion.force_s.norm());
    let relative = push.v_wp_s - motion.twist_ws_s.velocity_at(&push.p_sc);
    if motion.mode == ContactMode::Separated {
        law("no approach", push.approach_speed() <= 0.0)?;
        return law("at rest", motion.twist_ws_s == Twist::default() && size == 0.0);
    }
    law("contact", normal.dot(&relative).abs() <= TOLERANCE * speed)?;
    law("presses", f_n > 0.0)?;
    law("cone", f_t.abs() <= push.friction * f_n + TOLERANCE * size)?;
    match motion.mode {
        ContactMode::Sticking => law("sticks", relative.norm() <= TOLERANCE * speed)?,
        mode => {
            let side = if mode == ContactMode::SlidingLeft { 1.0 } else { -1.0 };
            law("slips to its side", side * motion.slip > -TOLERANCE * speed)?;
            law("edge", (f_t - side * push.friction * f_n).abs() <= TOLERANCE * size)?;
        }
    }
    let load = push.wrench_of(&motion.force_s) + *external;
    law("on the surface", (surface.level(&load).unwrap() - 1.0).abs() <= TOLERANCE)?;
    let dissipated = surface.dissipation(&motion.twist_ws_s).unwrap();
    law("dissipation", dissipated >= 0.0)?;
    law(
        "maximum power",
        (load.power(&motion.twist_ws_s) - dissipated).abs() <= TOLERANCE * dissipated,
    )?;
    for k in 0..12 {
        let turn = [-60.0, -10.0, 10.0, 60.0][k % 4];
        let along = unit(f64::from(k as u32)).into_inner();
        let other = surface.wrench(&Twist { linear: along, angular: turn }).unwrap();
        let power = other.power(&motion.twist_ws_s);
        law("most power", power <= dissipated * (1.0 + TOLERANCE))?;
    }
    Ok(())
}

fn mirror(v: &Vector2<f64>) -> Vector2<f64> {
    Vector2::new(v.x, -v.y)
}

fn mirrored(push: &Push) -> Push {
    Push {
        p_sc: mirror(&push.p_sc),
        normal_s: Unit::new_unchecked(mirror(&push.normal_s)),
        v_wp_s: mirror(&push.v_wp_s),
        friction: push.friction,
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn every_push_obeys_the_laws_of_contact_and_maximum_power(push in pushes()) {
        for Row { name, surface, .. } in rows() {
            let motion = predict(surface.as_ref(), &push).unwrap();
            let found = check(surface.as_ref(), &push, &Wrench::default(), &motion);
            prop_assert_eq!(found, Ok(()), "{}", name);
        }
    }

    #[test]
    fn loads_besides_the_pusher_keep_the_laws(
        push in pushes(), level in 0.0..0.9f64,
        direction in (-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64),
    ) {
        for Row { name, surface, .. } in rows() {
            let along = Wrench::new(direction.0, direction.1, 0.04 * direction.2);
            let external = level / surface.level(&along).unwrap() * along;
            let motion = predict_with_external_wrench(surface.as_ref(), &push, &external).unwrap();
            prop_assert_eq!(check(surface.as_ref(), &push, &external, &motion), Ok(()), "{}", name);
        }
    }

    #[test]
    fn in_the_mirror_the_push_is_the_mirror_image(push in pushes()) {
        for Row { name, surface, mirrored: image } in rows() {
            let here = predict(surface.as_ref(), &push).unwrap();
            let there = predict(image.as_ref(), &mirrored(&push)).unwrap();
            let swapped = match here.mode {
                ContactMode::SlidingLeft => ContactMode::SlidingRight,
                ContactMode::SlidingRight => ContactMode::SlidingLeft,
                mode => mode,
            };
            prop_assert_eq!(there.mode, swapped, "{}", name);
            let speed = push.v_wp_s.norm();
            let gap = mirror(&there.twist_ws_s.linear) - here.twist_ws_s.linear;
            let turn = 0.04 * (there.twist_ws_s.angular + here.twist_ws_s.angular);
            prop_assert!(gap.norm() + turn.abs() <= TOLERANCE * speed, "{name}: {here:?} {there:?}");
            let force = (mirror(&there.force_s) - here.force_s).norm();
            prop_assert!(force <= 1e-5 * here.force_s.norm(), "{name}: {here:?} {there:?}");
        }
    }
}

/// Pushes of every mode.
fn chosen() -> Vec<Push> {
    [(0.01, 0.1, 0.5), (0.03, -0.2, 0.3), (-0.02, 0.9, 0.3), (0.02, -1.2, 0.1), (0.0, 1.8, 0.2)]
        .map(|(y, angle, friction)| Push {
            p_sc: Vector2::new(-0.045, y),
            normal_s: Vector2::x_axis(),
            v_wp_s: unit(angle).into_inner(),
            friction,
        })
        .into()
}

/// Whether a motion is another one `scale` times as fast.
fn is_scaled(there: &PushMotion, here: &PushMotion, scale: f64) -> bool {
    let gap = (1.0 / scale * there.twist_ws_s - here.twist_ws_s).to_vector();
    there.mode == here.mode
        && gap.norm() <= 1e-9 * here.twist_ws_s.to_vector().norm()
        && (there.slip / scale - here.slip).abs() <= 1e-9
        && (there.force_s - here.force_s).norm() <= 1e-9 * here.force_s.norm()
}

#[test]
fn a_push_is_the_same_at_every_speed_under_every_law() {
    for Row { name, surface, .. } in rows() {
        let surface = surface.as_ref();
        let c = surface.characteristic_length();
        let load = Wrench::new(0.02, -0.01, 0.01 * c);
        for push in chosen() {
            let notch = |v_wp_s| {
                let other = Push { p_sc: Vector2::new(-0.045, -0.03), normal_s: unit(0.4), ..push };
                [Push { v_wp_s, ..push }, Push { v_wp_s, ..other }]
            };
            let all = |v_wp_s| -> Vec<PushMotion> {
                let push = Push { v_wp_s, ..push };
                let mut motions = predict_multi_contact(surface, &notch(v_wp_s), &load).unwrap();
                motions.push(predict(surface, &push).unwrap());
                motions.push(predict_with_external_wrench(surface, &push, &load).unwrap());
                motions
            };
            let here = all(push.v_wp_s);
            for scale in EXPONENTS.map(|exponent| 10.0_f64.powi(exponent)) {
                for (there, here) in all(scale * push.v_wp_s).iter().zip(&here) {
                    assert!(is_scaled(there, here, scale), "{name} {scale:e}: {there:?} {here:?}");
                }
            }
        }
    }
}

#[test]
fn dissipation_is_homogeneous_at_every_speed() {
    let twist = Twist::new(0.3, -0.2, 7.0);
    for Row { surface, .. } in rows() {
        let here = surface.dissipation(&twist).unwrap();
        for scale in EXPONENTS.map(|exponent| 10.0_f64.powi(exponent)) {
            let there = surface.dissipation(&(scale * twist)).unwrap() / scale;
            assert!((there / here - 1.0).abs() < 1e-12, "{surface:?} {scale:e}: {there} {here}");
        }
    }
}

#[test]
fn a_motion_beyond_all_numbers_is_an_error() {
    for Row { name, surface, .. } in rows() {
        for push in chosen() {
            let v_wp_s = f64::MAX * push.v_wp_s;
            let motions = predict(surface.as_ref(), &Push { v_wp_s, ..push });
            let Ok(motion) = motions else { continue };
            let numbers = motion.twist_ws_s.to_vector().push(motion.slip);
            assert!(numbers.iter().all(|x| x.is_finite()), "{name}: {motion:?}");
        }
    }
    let turning = Push { v_wp_s: Vector2::new(f64::MAX, 0.0), ..chosen()[1] };
    let error = predict(&Ellipsoid::new(2.0, 0.02).unwrap(), &turning).unwrap_err();
    assert!(matches!(error, MechanicsError::NotFinite { name: "the slider's velocity", .. }));
}

#[test]
fn friction_that_resists_one_way_more_bears_a_load_that_way() {
    let (ellipsoid, middle) = (Ellipsoid::new(2.0, 0.08).unwrap(), Wrench::new(1.6, 0.0, 0.0));
    // It bears 3.6 N along x and 0.4 N against it.
    let surface = Lopsided { ellipsoid, middle };
    let push = Push {
        p_sc: Vector2::new(0.045, 0.0),
        normal_s: -Vector2::x_axis(),
        v_wp_s: Vector2::new(-0.02, 0.0),
        friction: 0.3,
    };
    let external = Wrench::new(2.4, 0.0, 0.0);
    for slope in [0.0, 0.02, -0.04] {
        let push = Push { v_wp_s: push.v_wp_s + Vector2::new(0.0, slope), ..push };
        let motion = predict_with_external_wrench(&surface, &push, &external).unwrap();
        assert_eq!(check(&surface, &push, &external, &motion), Ok(()));
    }
    let straight = predict_with_external_wrench(&surface, &push, &external).unwrap();
    assert!((straight.force_s - Vector2::new(-2.8, 0.0)).norm() < 1e-9, "{straight:?}");
}

fn moved(surface: &dyn LimitSurface, start: &Pose, path: &dyn PusherPath) -> PathMotion {
    let shape = Shape::square(0.09).unwrap();
    let slider = Slider { shape: &shape, surface, pose_bs: Pose::new(0.002, -0.001, 0.3) };
    let pusher = Pusher { radius: 0.005, friction: 0.25 };
    push_along(&slider, &pusher, path, start, &PathSettings::default()).unwrap()
}

#[test]
fn two_half_steps_are_one_step_on_every_surface() {
    for Row { name, surface, .. } in rows() {
        for (y, angle) in [(0.01, 0.1), (-0.03, 0.8), (0.04, 0.9)] {
            let path = StraightPath {
                start_w: Vector2::new(-0.05, y),
                velocity_w: 0.02 * unit(angle).into_inner(),
                duration: 0.4,
            };
            let push = |start: &Pose, path: &dyn PusherPath| moved(surface.as_ref(), start, path);
            let whole = push(&Pose::default(), &path);
            let first = StraightPath { duration: 0.2, ..path };
            let half = push(&Pose::default(), &first);
            let second = StraightPath { start_w: path.position(0, 0.2), ..first };
            let joined = push(&half.pose_wb, &second);
            let gap = (joined.pose_wb.position - whole.pose_wb.position).norm();
            let turn = (joined.pose_wb.angle - whole.pose_wb.angle).abs();
            assert!(gap < 2e-8 && turn < 1e-6, "{name} {y} {angle}: {gap:e} m, {turn:e} rad");
            assert!((half.slip + joined.slip - whole.slip).abs() < 2e-8, "{name} {y} {angle}");
            let impulse = |motion: &PathMotion| motion.mean_normal_force * motion.contact_time;
            let sum = impulse(&half) + impulse(&joined);
            assert!((sum / impulse(&whole) - 1.0).abs() < 1e-4, "{name} {y} {angle}");
        }
    }
}

#[test]
fn a_path_is_the_same_at_every_speed() {
    for Row { name, surface, .. } in rows() {
        // From 2 mm away over the corner.
        let path = |speed: f64| StraightPath {
            start_w: Vector2::new(-0.052, 0.04),
            velocity_w: speed * unit(0.9).into_inner(),
            duration: 0.02 / speed,
        };
        let here = moved(surface.as_ref(), &Pose::default(), &path(0.02));
        for speed in EXPONENTS.map(|exponent| 10.0_f64.powi(exponent)) {
            let there = moved(surface.as_ref(), &Pose::default(), &path(speed));
            let gap = (there.pose_wb.position - here.pose_wb.position).norm();
            let turn = (there.pose_wb.angle - here.pose_wb.angle).abs();
            assert!(gap < 2e-8 && turn < 1e-6, "{name} {speed:e}: {gap:e} m, {turn:e} rad");
            let kinds = |motion: &PathMotion| -> Vec<_> {
                motion.phases.iter().map(|phase| (phase.mode, phase.place)).collect()
            };
            assert_eq!(kinds(&there), kinds(&here), "{name} {speed:e}");
        }
    }
}

/// To and fro along x, `n` times in a second, `way` to the far end.
fn to_and_fro(start: Vector2<f64>, way: f64, n: f64) -> impl PusherPath {
    let rate = std::f64::consts::TAU * n;
    SmoothPath {
        position_w: move |t: f64| start + Vector2::new(0.5 * way * (1.0 - (rate * t).cos()), 0.0),
        velocity_w: move |t: f64| Vector2::new(0.5 * way * rate * (rate * t).sin(), 0.0),
        duration: 1.0,
    }
}

#[test]
fn a_pusher_that_comes_back_has_pushed_as_far_as_it_went() {
    let surface = Ellipsoid::new(2.0, 0.07).unwrap();
    let shape = Shape::square(0.09).unwrap();
    let slider = Slider { shape: &shape, surface: &surface, pose_bs: Pose::default() };
    let pusher = Pusher { radius: 0.005, friction: 0.25 };
    for (gap, n) in [(0.0, 1.0), (0.0, 8.0), (0.02, 1.0), (0.02, 64.0), (0.02, 128.0)] {
        let path = to_and_fro(Vector2::new(-0.05 - gap, 0.0), 0.05, n);
        let settings = PathSettings::default();
        let motion = push_along(&slider, &pusher, &path, &Pose::default(), &settings).unwrap();
        let far = motion.pose_wb.position.x;
        assert!((far - (0.05 - gap)).abs() < 1e-6, "{gap} {n}: {far} m");
        for pair in motion.samples.windows(2).filter(|pair| pair[0].touching && pair[1].touching) {
            let way = (pair[1].pose_wb.position - pair[0].pose_wb.position).norm();
            assert!(way <= 1.001 * settings.max_travel, "{gap} {n}: {way} m in a step");
        }
    }
}
