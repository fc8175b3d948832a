//! Laws and known answers of the push at several contacts.

use mechanics::{
    ContactMode, Ellipsoid, LimitSurface, MechanicsError, Patch, Push, PushMotion, predict,
    predict_multi_contact, predict_with_external_wrench,
};
use nalgebra::{Unit, UnitVector2, Vector2};
use planar::{Shape, Wrench};
use proptest::prelude::{ProptestConfig, Strategy, prop_assert_eq, proptest};

fn unit(angle: f64) -> UnitVector2<f64> {
    Unit::new_normalize(Vector2::new(angle.cos(), angle.sin()))
}

fn contact(x: f64, y: f64, normal: f64, v_wp_s: Vector2<f64>, friction: f64) -> Push {
    Push { p_sc: Vector2::new(x, y), normal_s: unit(normal), v_wp_s, friction }
}

/// The two walls of a notch with normals ± `half` about x, touched by one pusher.
fn notch(half: f64, direction: f64, friction: f64) -> [Push; 2] {
    let v = 0.02 * unit(direction).into_inner();
    [contact(-0.03, -0.003, half, v, friction), contact(-0.03, 0.003, -half, v, friction)]
}

/// What must hold at every contact and for the load.
fn check(
    surface: &dyn LimitSurface,
    pushes: &[Push],
    external: &Wrench,
    motions: &[PushMotion],
    tolerance: f64,
) -> Result<(), String> {
    let twist = motions[0].twist_ws_s;
    let speed = pushes[0].v_wp_s.norm();
    let total: f64 = motions.iter().map(|motion| motion.force_s.norm()).sum();
    let mut load = *external;
    for (push, motion) in pushes.iter().zip(motions) {
        let law = |name: &str, holds: bool| {
            if holds { Ok(()) } else { Err(format!("{name}: {pushes:?} gave {motions:?}")) }
        };
        let relative = push.v_wp_s - twist.velocity_at(&push.p_sc);
        let (normal, tangent) = (push.normal_s.into_inner(), push.tangent_s());
        let (f_n, f_t) = (normal.dot(&motion.force_s), tangent.dot(&motion.force_s));
        law("one body", motion.twist_ws_s == twist)?;
        law("no penetration", normal.dot(&relative) <= tolerance * speed)?;
        law("cone", f_t.abs() <= push.friction * f_n + tolerance * total)?;
        match motion.mode {
            ContactMode::Separated => law("no force", motion.force_s == Vector2::zeros())?,
            ContactMode::Sticking => law("sticks", relative.norm() <= tolerance * speed)?,
            ContactMode::SlidingLeft | ContactMode::SlidingRight => {
                let side = if motion.mode == ContactMode::SlidingLeft { 1.0 } else { -1.0 };
                law("stays on the wall", normal.dot(&relative).abs() <= tolerance * speed)?;
                law("slides to its side", side * tangent.dot(&relative) >= -tolerance * speed)?;
                law("edge", (f_t - side * push.friction * f_n).abs() <= tolerance * total)?;
            }
        }
        load += push.wrench_of(&motion.force_s);
    }
    if total > 0.0 {
        let level = surface.level(&load).unwrap();
        let moves = surface.twist(&load).unwrap().to_vector();
        let c = surface.characteristic_length();
        let scaled = |t: nalgebra::Vector3<f64>| nalgebra::Vector3::new(t.x, t.y, c * t.z);
        let angle = scaled(moves).angle(&scaled(twist.to_vector()));
        if (level - 1.0).abs() > 10.0 * tolerance || angle > 1e-5 {
            return Err(format!("level {level}, {angle} rad: {pushes:?} gave {motions:?}"));
        }
    }
    Ok(())
}

#[test]
fn a_straight_push_into_a_symmetric_notch_presses_on_both_walls_alike() {
    let surface = Ellipsoid::new(2.0, 0.07).unwrap();
    let motions =
        predict_multi_contact(&surface, &notch(0.7, 0.0, 0.0), &Wrench::default()).unwrap();
    // 2 N along x, shared by two forces at ±0.7 rad.
    for motion in &motions {
        assert!((motion.force_s.norm() - 1.0 / 0.7_f64.cos()).abs() < 1e-12);
        assert_eq!(motion.mode, ContactMode::Sticking);
        assert!((motion.twist_ws_s.linear - Vector2::new(0.02, 0.0)).norm() < 1e-16);
    }
}

#[test]
fn walls_that_could_squeeze_the_slider_press_no_harder_than_they_must() {
    let surface = Ellipsoid::new(2.0, 0.07).unwrap();
    let (half, friction) = (0.7_f64, 0.2);
    let motions =
        predict_multi_contact(&surface, &notch(half, 0.0, friction), &Wrench::default()).unwrap();
    // 2 N along x, shared by the edges of the cones that are nearest to x.
    let expected = 1.0 / (half.cos() + friction * half.sin());
    for (motion, side) in motions.iter().zip([1.0, -1.0]) {
        assert_eq!(motion.mode, ContactMode::Sticking);
        let normal_force = unit(side * half).dot(&motion.force_s);
        assert!((normal_force - expected).abs() < 1e-12, "{normal_force} {expected}");
    }
}

#[test]
fn an_oblique_push_leaves_one_wall_or_carries_the_slider_along() {
    let surface = Ellipsoid::new(2.0, 0.07).unwrap();
    let modes = |direction: f64| {
        let motions =
            predict_multi_contact(&surface, &notch(0.7, direction, 0.2), &Wrench::default())
                .unwrap();
        [motions[0].mode, motions[1].mode]
    };
    assert_eq!(modes(0.0), [ContactMode::Sticking; 2]);
    assert_eq!(modes(1.4)[1], ContactMode::Separated);
    assert_eq!(modes(-1.4)[0], ContactMode::Separated);
}

#[test]
fn two_walls_keep_the_laws_wherever_the_pusher_is() {
    let v = Vector2::new(0.02, 0.0);
    let pushes = [contact(-0.05, 0.04, 0.3, v, 0.1), contact(-0.05, 0.01, 0.0, v, 0.1)];
    let surface = Ellipsoid::new(2.0, 0.02).unwrap();
    let mut seen = Vec::new();
    for y in [0.06, 0.03, 0.0, -0.02, -0.05] {
        let moved =
            pushes.map(|push| Push { p_sc: push.p_sc + Vector2::new(0.0, y - 0.04), ..push });
        let motions = predict_multi_contact(&surface, &moved, &Wrench::default()).unwrap();
        assert_eq!(check(&surface, &moved, &Wrench::default(), &motions, 1e-9), Ok(()));
        seen.push([motions[0].mode, motions[1].mode]);
    }
    let n_sliding = |modes: &[ContactMode; 2]| {
        let slides = |mode: &&ContactMode| {
            matches!(mode, ContactMode::SlidingLeft | ContactMode::SlidingRight)
        };
        modes.iter().filter(slides).count()
    };
    assert!(seen.iter().any(|modes| n_sliding(modes) == 2), "{seen:?}");
    assert!(seen.iter().any(|modes| modes.contains(&ContactMode::Separated)), "{seen:?}");
}

#[test]
fn contacts_that_do_not_move_together_are_refused() {
    let surface = Ellipsoid::new(2.0, 0.07).unwrap();
    let [first, second] = notch(0.7, 0.0, 0.2);
    let faster = Push { v_wp_s: 2.0 * second.v_wp_s, ..second };
    let error = predict_multi_contact(&surface, &[first, faster], &Wrench::default());
    assert_eq!(error, Err(MechanicsError::PushersDiffer));
}

fn pushes() -> impl Strategy<Value = Vec<Push>> {
    let place = (-0.06..0.06f64, -0.06..0.06f64, -3.2..3.2f64, 0.0..1.0f64);
    (proptest::collection::vec(place, 1..4), -3.2..3.2f64).prop_map(|(places, direction)| {
        let v = 0.02 * unit(direction).into_inner();
        places.into_iter().map(|(x, y, normal, mu)| contact(x, y, normal, v, mu)).collect()
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(512))]

    #[test]
    fn any_contacts_obey_the_laws_of_contact(
        pushes in pushes(), c in 0.01..0.1f64, x in -0.02..0.02f64, load in -0.5..0.5f64,
    ) {
        let surface = Ellipsoid::new(2.0, 2.0 * c).unwrap();
        let surface = surface.shifted(&Vector2::new(x, 0.01)).unwrap();
        for external in [Wrench::default(), Wrench::new(load, 0.3, 0.2 * c * load)] {
            let motions = predict_multi_contact(&surface, &pushes, &external).unwrap();
            prop_assert_eq!(check(&surface, &pushes, &external, &motions, 1e-8), Ok(()));
        }
    }

    #[test]
    fn one_contact_is_the_single_push(pushes in pushes(), c in 0.01..0.1f64) {
        let surface = Ellipsoid::new(2.0, 2.0 * c).unwrap();
        let external = Wrench::new(0.1, -0.2, 0.01 * c);
        let one = predict_multi_contact(&surface, &pushes[..1], &Wrench::default()).unwrap();
        prop_assert_eq!(one[0], predict(&surface, &pushes[0]).unwrap());
        let loaded = predict_multi_contact(&surface, &pushes[..1], &external).unwrap();
        prop_assert_eq!(loaded[0], predict_with_external_wrench(&surface, &pushes[0], &external).unwrap());
    }
}

#[test]
fn the_laws_hold_on_a_patch_too() {
    let patch = Patch::uniform(&Shape::square(0.09).unwrap(), 2.0).unwrap();
    for direction in [-1.3, -0.5, 0.0, 0.2, 0.9] {
        for (half, friction) in [(0.7, 0.2), (0.3, 0.6), (1.2, 0.0)] {
            let pushes = notch(half, direction, friction);
            let motions = predict_multi_contact(&patch, &pushes, &Wrench::default()).unwrap();
            let laws = check(&patch, &pushes, &Wrench::default(), &motions, 1e-7);
            assert_eq!(laws, Ok(()));
        }
    }
}
