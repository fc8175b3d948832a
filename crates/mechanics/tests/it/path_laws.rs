//! Laws and known answers of a push along a path.

use mechanics::{
    ContactMode, Ellipsoid, MechanicsError, PathMotion, PathSettings, Place, Polyline, Pusher,
    PusherPath, Slider, SmoothPath, StraightPath, push_along, push_along_with_external_wrench,
};
use nalgebra::Vector2;
use planar::{Polygon, Pose, Shape, Wrench, mit_object};

const SIDE: f64 = 0.09;
const PUSHER: Pusher = Pusher { radius: 0.00475, friction: 0.25 };
const ORIGIN: Pose = Pose { position: Vector2::new(0.0, 0.0), angle: 0.0 };

fn run(
    path: &dyn PusherPath,
    pusher: &Pusher,
    start: &Pose,
    settings: &PathSettings,
) -> PathMotion {
    let shape = Shape::square(SIDE).unwrap();
    let surface = Ellipsoid::new(2.0, 2.0 * 0.3826 * SIDE).unwrap();
    let slider = Slider { shape: &shape, surface: &surface, pose_bs: Pose::default() };
    push_along(&slider, pusher, path, start, settings).unwrap()
}

/// A push on the square's left side, from touch, at `angle` to its normal.
fn straight(y: f64, angle: f64, speed: f64, duration: f64) -> StraightPath {
    StraightPath {
        start_w: Vector2::new(-0.5 * SIDE - PUSHER.radius, y),
        velocity_w: speed * Vector2::new(angle.cos(), angle.sin()),
        duration,
    }
}

fn default_run(path: &dyn PusherPath) -> PathMotion {
    run(path, &PUSHER, &ORIGIN, &PathSettings::default())
}

#[test]
fn a_push_through_the_center_carries_the_object_straight() {
    let motion = default_run(&straight(0.0, 0.0, 0.02, 0.2));
    assert!((motion.pose_wb.position - Vector2::new(0.004, 0.0)).norm() < 1e-12);
    assert!(motion.pose_wb.angle.abs() < 1e-12);
    assert_eq!(motion.phases.len(), 1);
    assert!((motion.mean_normal_force - 2.0).abs() < 1e-12);
    assert!((motion.contact_time - 0.2).abs() < 1e-12);
}

#[test]
fn a_push_left_of_the_center_turns_the_object_clockwise() {
    let motion = default_run(&straight(0.0225, 0.0, 0.02, 0.2));
    assert!(motion.pose_wb.angle < -0.02, "{motion:?}");
    assert_eq!(motion.phases[0].place, Place::Edge(1));
}

/// Errors of the default settings against a thousandfold finer run, in m and rad.
fn error_of_default(path: &dyn PusherPath) -> (f64, f64) {
    let coarse = default_run(path).pose_wb;
    let settings = PathSettings { tolerance: 1e-12, max_travel: 2.5e-4 };
    let fine = run(path, &PUSHER, &ORIGIN, &settings).pose_wb;
    ((coarse.position - fine.position).norm(), (coarse.angle - fine.angle).abs())
}

#[test]
fn the_default_step_is_right_to_a_micrometer_and_ten_microradians() {
    for y in [-0.044, -0.03, -0.011, 0.0, 0.02, 0.0449] {
        for angle in [-1.2, -0.6, -0.25, 0.0, 0.2, 0.7, 1.3] {
            let (position, turn) = error_of_default(&straight(y, angle, 0.02, 0.2));
            assert!(position < 1e-6 && turn < 1e-5, "{y} {angle}: {position:e} m, {turn:e} rad");
            let (position, turn) = error_of_default(&straight(y, angle, 0.1, 0.5));
            assert!(position < 1e-6 && turn < 1e-5, "{y} {angle}: {position:e} m, {turn:e} rad");
        }
    }
}

/// A direct midpoint rule with a fixed step that restarts the gap at zero, as an oracle.
fn midpoint(path: &StraightPath, n_steps: usize) -> Pose {
    let shape = Shape::square(SIDE).unwrap();
    let surface = Ellipsoid::new(2.0, 2.0 * 0.3826 * SIDE).unwrap();
    let slider = Slider { shape: &shape, surface: &surface, pose_bs: Pose::default() };
    let velocity = |time: f64, pose: &Pose| {
        let center = path.start_w + time * path.velocity_w;
        let contact = slider.contact(&PUSHER, pose, &center);
        let push = slider.push_at(&PUSHER, pose, &contact, &path.velocity_w);
        slider.velocity(&push, pose).unwrap().1
    };
    let moved = |pose: &Pose, h: f64, at: &Pose, time: f64| {
        let twist = velocity(time, at);
        Pose { position: pose.position + h * twist.linear, angle: pose.angle + h * twist.angular }
    };
    let h = path.duration / n_steps as f64;
    (0..n_steps).fold(ORIGIN, |pose, i| {
        let time = i as f64 * h;
        let half = moved(&pose, 0.5 * h, &pose, time);
        moved(&pose, h, &half, time + 0.5 * h)
    })
}

#[test]
fn the_path_agrees_with_a_plain_midpoint_rule_across_switches() {
    for (y, angle) in [(0.01, 0.0), (-0.03, 0.5), (0.044, -0.3), (0.02, 1.0), (-0.02, 0.2)] {
        let path = straight(y, angle, 0.1, 0.3);
        let (ours, theirs) = (default_run(&path).pose_wb, midpoint(&path, 20_000));
        let error = (ours.position - theirs.position).norm();
        assert!(error < 1e-7, "{y} {angle}: {error:e} m");
        assert!((ours.angle - theirs.angle).abs() < 1e-6, "{y} {angle}");
    }
}

#[test]
fn the_object_rests_until_the_pusher_arrives() {
    let touching = straight(0.02, 0.1, 0.02, 0.2);
    let lead = 0.5;
    let early = StraightPath {
        start_w: touching.start_w - lead * touching.velocity_w,
        duration: touching.duration + lead,
        ..touching
    };
    let (late, early) = (default_run(&touching), default_run(&early));
    assert!((early.contact_span().unwrap().0 - lead).abs() < 1e-7);
    assert!((late.pose_wb.position - early.pose_wb.position).norm() < 1e-8);
    assert!((late.pose_wb.angle - early.pose_wb.angle).abs() < 1e-7);
    assert!((late.mean_normal_force - early.mean_normal_force).abs() < 1e-6);
}

#[test]
fn an_object_under_the_pusher_is_moved_out_before_it_is_pushed() {
    let depth = 1e-3;
    let outside = straight(0.0, 0.0, 0.02, 0.2);
    let inside = StraightPath { start_w: outside.start_w + Vector2::new(depth, 0.0), ..outside };
    let motion = default_run(&inside);
    assert!((motion.overlap - depth).abs() < 1e-15);
    assert!((motion.pose_wb.position - Vector2::new(0.004 + depth, 0.0)).norm() < 1e-12);
    assert!(default_run(&outside).overlap < 1e-15);
}

#[test]
fn a_sliding_push_has_its_force_on_the_edge_of_the_cone_to_the_side_of_its_slip() {
    for (side, mode) in [(1.0, ContactMode::SlidingLeft), (-1.0, ContactMode::SlidingRight)] {
        let motion = default_run(&straight(0.0, 1.2 * side, 0.02, 0.2));
        assert!(motion.phases.iter().all(|phase| phase.mode == mode), "{:?}", motion.phases);
        let edge = side * PUSHER.friction * motion.mean_normal_force;
        assert!((motion.mean_tangential_force - edge).abs() < 1e-12);
        assert!(side * motion.slip > 1e-3);
    }
}

#[test]
fn a_pusher_that_passes_by_moves_nothing() {
    let path = StraightPath {
        start_w: Vector2::new(-0.1, 0.06),
        velocity_w: Vector2::new(0.1, 0.0),
        duration: 2.0,
    };
    let motion = default_run(&path);
    assert_eq!((motion.pose_wb, motion.contact_span()), (ORIGIN, None));
    assert_eq!((motion.contact_time, motion.mean_normal_force, motion.slip), (0.0, 0.0, 0.0));
}

#[test]
fn a_pusher_that_turns_back_leaves_the_object_where_it_was() {
    let start = Vector2::new(-0.5 * SIDE - PUSHER.radius, 0.01);
    let there = start + Vector2::new(0.004, 0.0);
    let path = Polyline::new(&[(3.0, start), (3.2, there), (3.4, start)]).unwrap();
    let motion = default_run(&path);
    let pushed = default_run(&straight(0.01, 0.0, 0.02, 0.2));
    assert!((motion.pose_wb.position - pushed.pose_wb.position).norm() < 1e-12);
    assert!((motion.contact_span().unwrap().1 - 0.2).abs() < 1e-12);
    assert!(motion.contact.gap > 0.003);
}

#[test]
fn a_pusher_slides_off_over_the_vertex_and_the_object_stays_behind() {
    let motion = default_run(&straight(0.04, 1.2, 0.05, 1.0));
    let places: Vec<Place> = motion.phases.iter().map(|phase| phase.place).collect();
    assert!(places.contains(&Place::Edge(1)) && places.contains(&Place::Vertex(1)), "{places:?}");
    assert!(motion.contact_span().unwrap().1 < 1.0 && motion.contact.gap > 0.001);
    assert!(motion.slip > 0.004);
}

#[test]
fn a_push_in_two_halves_is_the_whole_push() {
    let whole = straight(0.015, 0.3, 0.05, 0.4);
    let first = StraightPath { duration: 0.2, ..whole };
    let half = default_run(&first).pose_wb;
    let second = StraightPath { start_w: whole.start_w + 0.2 * whole.velocity_w, ..first };
    let joined = run(&second, &PUSHER, &half, &PathSettings::default()).pose_wb;
    let expected = default_run(&whole).pose_wb;
    assert!((joined.position - expected.position).norm() < 1e-8);
    assert!((joined.angle - expected.angle).abs() < 1e-7);
}

#[test]
fn a_smooth_path_that_is_straight_gives_the_straight_push() {
    let path = straight(0.015, 0.3, 0.05, 0.2);
    let smooth = SmoothPath {
        position_w: |time: f64| path.start_w + time * path.velocity_w,
        velocity_w: |_: f64| path.velocity_w,
        duration: path.duration,
    };
    assert_eq!(default_run(&smooth), default_run(&path));
}

#[test]
fn the_gap_stays_closed_while_they_touch() {
    for (y, angle) in [(0.02, 0.2), (-0.02, 0.9), (0.03, -1.0)] {
        let motion = default_run(&straight(y, angle, 0.05, 0.4));
        assert!(motion.samples.last().unwrap().touching, "{y} {angle}");
        assert!(motion.contact.gap.abs() < 1e-12, "{y} {angle}: {:e} m", motion.contact.gap);
    }
}

#[test]
fn changes_of_the_contact_are_timed_to_a_tenth_of_a_micrometer_of_travel() {
    let speed = 0.05;
    let mut n_changes = 0;
    for (y, angle) in [(0.04, 1.2), (0.044, 0.4), (-0.04, -1.0), (0.02, 1.0), (-0.03, 0.9)] {
        let path = straight(y, angle, speed, 1.0);
        let coarse = default_run(&path).phases;
        let settings = PathSettings { tolerance: 1e-12, max_travel: 7e-4 };
        let fine = run(&path, &PUSHER, &ORIGIN, &settings).phases;
        assert_eq!(coarse.len(), fine.len(), "{y} {angle}: {coarse:?} {fine:?}");
        for (ours, theirs) in coarse.iter().zip(&fine) {
            assert_eq!((ours.mode, ours.place), (theirs.mode, theirs.place));
            let error = speed * (ours.end - theirs.end).abs();
            assert!(error < 1e-7, "{y} {angle}: {error:e} m in {ours:?}");
        }
        n_changes += fine.len() - 1;
    }
    assert!(n_changes >= 5, "{n_changes}");
}

#[test]
fn paths_and_pushers_out_of_range_are_refused() {
    let at = |x: f64| Vector2::new(x, 0.0);
    let refused = |points: &[(f64, Vector2<f64>)]| Polyline::new(points).unwrap_err().to_string();
    assert_eq!(
        refused(&[(0.0, at(0.0))]),
        "point 1 of the pusher's path: a path needs at least two points"
    );
    assert_eq!(
        refused(&[(0.0, at(0.0)), (0.0, at(1.0))]),
        "point 1 of the pusher's path: its time must be later than the one before"
    );
    let shape = Shape::square(SIDE).unwrap();
    let surface = Ellipsoid::new(2.0, 0.08).unwrap();
    let slider = Slider { shape: &shape, surface: &surface, pose_bs: Pose::default() };
    let pusher = Pusher { radius: -0.001, friction: 0.3 };
    let path = straight(0.0, 0.0, 0.02, 0.2);
    let error = push_along(&slider, &pusher, &path, &ORIGIN, &PathSettings::default()).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the pusher's radius must be finite and not negative, got -0.001 m"
    );
}

/// Objects with a center of friction away from the body's origin: polygons, ellipses, a notch.
fn objects() -> Vec<(&'static str, Shape)> {
    let notch = [[0.05, 0.05], [-0.05, 0.05], [-0.03, 0.0], [-0.05, -0.05], [0.05, -0.05]];
    let notch = notch.iter().map(|p| Vector2::new(p[0], p[1])).collect();
    let mut objects: Vec<_> = ["rect1", "tri1", "tri3", "ellip1", "ellip3", "hex", "butter"]
        .map(|name| (name, mit_object(name).unwrap().shape))
        .into();
    objects.push(("notch", Shape::Polygon(Polygon::new(notch).unwrap())));
    objects
}

/// A push from the left, 1 mm away at first, at height `y` and an angle.
fn approach(shape: &Shape, radius: f64, y: f64, angle: f64) -> StraightPath {
    let direction = Vector2::new(angle.cos(), angle.sin());
    let mut start = Vector2::new(-0.2, y);
    while shape.contact(&start, radius).gap > 1e-3 {
        start.x += shape.contact(&start, radius).gap.min(1e-3);
        if start.x > 0.2 {
            break;
        }
    }
    StraightPath { start_w: start, velocity_w: 0.02 * direction, duration: 0.6 }
}

#[test]
fn halving_the_step_changes_less_than_a_micrometer_and_ten_microradians() {
    let default = PathSettings::default();
    let halved =
        PathSettings { tolerance: default.tolerance / 64.0, max_travel: default.max_travel / 2.0 };
    let (mut modes, mut places, mut n_wedged) = (Vec::new(), Vec::new(), 0);
    for (name, shape) in objects() {
        let center = shape.centroid();
        let surface = Ellipsoid::new(2.0, 2.0 * shape.mean_distance(&center)).unwrap();
        let pose_bs = Pose::new(center.x + 0.004, center.y - 0.003, 0.7);
        let slider = Slider { shape: &shape, surface: &surface, pose_bs };
        // A point is held by no notch: see push_along.
        let smallest = if matches!(name, "butter" | "notch") { 5e-4 } else { 0.0 };
        for radius in [smallest, PUSHER.radius] {
            let pusher = Pusher { radius, friction: 0.25 };
            for (y, angle) in [(0.0, 0.1), (0.02, -0.4), (-0.03, 0.9), (0.038, 0.5), (0.004, -0.9)]
            {
                let path = approach(&shape, radius, y, angle);
                let push = |settings| {
                    push_along(&slider, &pusher, &path, &ORIGIN, settings)
                        .unwrap_or_else(|e| panic!("{name} {radius} {y} {angle} {e}"))
                };
                let (coarse, fine) = (push(&default), push(&halved));
                let shift = (coarse.pose_wb.position - fine.pose_wb.position).norm();
                let turn = (coarse.pose_wb.angle - fine.pose_wb.angle).abs();
                let case = format!("{name}, radius {radius}, y {y}, angle {angle}");
                assert!(shift < 1e-6 && turn < 1e-5, "{case}: {shift:e} m, {turn:e} rad");
                modes.extend(fine.phases.iter().map(|phase| phase.mode));
                places.extend(fine.phases.iter().map(|phase| phase.place));
                n_wedged += fine.phases.windows(2).filter(|w| w[0].end > w[1].start).count();
            }
        }
    }
    // The pushes are worth the name: all modes, vertices and wedging occur.
    for mode in [ContactMode::Sticking, ContactMode::SlidingLeft, ContactMode::SlidingRight] {
        assert!(modes.contains(&mode));
    }
    assert!(places.iter().any(|place| matches!(place, Place::Vertex(_))));
    assert!(n_wedged > 0);
}

#[test]
fn a_pusher_wedged_in_a_notch_carries_the_object_along() {
    let (_, shape) = objects().pop().unwrap();
    let surface = Ellipsoid::new(2.0, 0.07).unwrap();
    let slider = Slider { shape: &shape, surface: &surface, pose_bs: Pose::default() };
    let path = approach(&shape, PUSHER.radius, 0.0, 0.0);
    let motion = push_along(&slider, &PUSHER, &path, &ORIGIN, &PathSettings::default()).unwrap();
    assert_eq!(motion.phases.len(), 2, "{:?}", motion.phases);
    assert!(motion.phases.iter().all(|phase| phase.mode == ContactMode::Sticking));
    assert!(motion.pose_wb.angle.abs() < 1e-12);
    let (start, end) = motion.contact_span().unwrap();
    assert!((motion.contact_time - (end - start)).abs() < 1e-12);
}

#[test]
fn a_load_that_helps_the_pusher_lowers_its_force_along_the_path() {
    let shape = Shape::square(SIDE).unwrap();
    let surface = Ellipsoid::new(2.0, 2.0 * 0.3826 * SIDE).unwrap();
    let slider = Slider { shape: &shape, surface: &surface, pose_bs: Pose::default() };
    let push = |path: &StraightPath, load: Wrench| {
        let external = move |_: f64, pose: &Pose| Wrench {
            force: pose.inverse_rotate(&load.force),
            torque: load.torque,
        };
        push_along_with_external_wrench(
            &slider,
            &PUSHER,
            path,
            &ORIGIN,
            &PathSettings::default(),
            &external,
        )
    };
    let central = push(&straight(0.0, 0.0, 0.02, 0.2), Wrench::new(0.5, 0.0, 0.0)).unwrap();
    assert!((central.mean_normal_force - 1.5).abs() < 1e-9);
    // Gravity down the table's slope drags the far side of a turning object along.
    let path = straight(0.02, 0.2, 0.02, 0.5);
    let (level, tilted) = (
        push(&path, Wrench::default()).unwrap(),
        push(&path, Wrench::new(0.0, -0.6, 0.0)).unwrap(),
    );
    assert_eq!(level, default_run(&path));
    assert!(tilted.pose_wb.position.y < level.pose_wb.position.y - 1e-4);
    let error = push(&path, Wrench::new(2.5, 0.0, 0.0)).unwrap_err();
    assert_eq!(error, MechanicsError::SlidesByItself { level: 1.25 });
}

#[test]
fn on_a_turned_table_everything_turns_with_it() {
    let shape = Shape::square(SIDE).unwrap();
    let surface = Ellipsoid::new(2.0, 2.0 * 0.3826 * SIDE).unwrap();
    let slider = Slider { shape: &shape, surface: &surface, pose_bs: Pose::default() };
    let here = straight(0.02, 0.2, 0.02, 0.5);
    let push = |table: &Pose| {
        let path = StraightPath {
            start_w: table.transform_point(&here.start_w),
            velocity_w: table.rotate(&here.velocity_w),
            ..here
        };
        let downhill = table.rotate(&Vector2::new(0.1, -0.6));
        let external =
            |_: f64, pose: &Pose| Wrench { force: pose.inverse_rotate(&downhill), torque: 0.0 };
        let settings = PathSettings::default();
        push_along_with_external_wrench(&slider, &PUSHER, &path, table, &settings, &external)
            .unwrap()
            .pose_wb
    };
    let table = Pose::new(0.1, -0.2, 0.8);
    let (turned, expected) = (push(&table), table * push(&ORIGIN));
    assert!((turned.position - expected.position).norm() < 1e-8);
    assert!((turned.angle - expected.angle).abs() < 1e-7);
}
