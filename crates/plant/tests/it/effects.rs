//! What each hidden effect does to what is recorded.

use std::collections::BTreeMap;

use dataset::ObjectSpec;
use nalgebra::Vector2;
use planar::{Pose, Shape};
use plant::{
    Design, GenerateSettings, Hidden, HiddenEffect, Scatter, Sensor, Sensors, SimulatedPush,
    effect_kinds, simulate,
};

/// Largest differences of the recordings of two sets.
#[derive(Debug, Default)]
struct Differences {
    /// Displacement since the start, in m, a turn counting 45 mm/rad.
    motion: f64,
    /// Force toward the end of the way, in N.
    force: f64,
    /// Distance of the nominal tip from the nominal outline while both touch, in m.
    gap: f64,
    /// Stamps of the object's stream, in s.
    stamp: f64,
}

/// Pushes of all places in all orientations, read by perfect sensors.
fn set(hidden: Option<HiddenEffect>, n_pushes: usize) -> Vec<SimulatedPush> {
    let even = Sensor::default();
    let design = Design { n_pushes, repeat_share: 0.0, travel: 0.04, ..Design::default() };
    let settings = GenerateSettings {
        hidden: hidden.map(Hidden::Effect).into_iter().collect(),
        design,
        scatter: Scatter::NONE,
        sensors: Sensors { robot: even, object: even, force: even, ..Sensors::ideal() },
        ..GenerateSettings::default()
    };
    simulate(&settings).expect("a set")
}

fn pose(push: &SimulatedPush, k: usize) -> Pose {
    let object = &push.recording.object;
    Pose::new(object.x[k], object.y[k], object.theta[k])
}

fn gap(push: &SimulatedPush, square: &Shape, k: usize) -> f64 {
    let robot = &push.recording.robot;
    let last = robot.len() - 1;
    let tip = Vector2::new(robot.x[k.min(last)], robot.y[k.min(last)]);
    square.contact(&pose(push, k).inverse_transform_point(&tip), 0.00475).gap
}

fn late_force(push: &SimulatedPush) -> Vector2<f64> {
    let wrench = push.recording.wrench.as_ref().expect("forces");
    let k = wrench.len() - 50;
    Vector2::new(wrench.fx[k], wrench.fy[k])
}

fn differences(plain: &[SimulatedPush], other: &[SimulatedPush]) -> Differences {
    let square = ObjectSpec::mit("rect1").expect("a known object").shape;
    let mut largest = Differences::default();
    for (a, b) in plain.iter().zip(other) {
        let n = a.recording.object.len().min(b.recording.object.len());
        for k in 0..n {
            let moved = |push| {
                let (now, start) = (pose(push, k), pose(push, 0));
                (now.position - start.position, now.angle - start.angle)
            };
            let ((pa, ta), (pb, tb)) = (moved(a), moved(b));
            largest.motion = largest.motion.max((pa - pb).norm() + 0.045 * (ta - tb).abs());
            let touches =
                |push: &SimulatedPush| push.trajectory.touches_at(a.recording.object.t[k].max(0.0));
            if touches(a) && touches(b) {
                largest.gap = largest.gap.max((gap(a, &square, k) - gap(b, &square, k)).abs());
            }
            let stamps = a.recording.object.t[k] - b.recording.object.t[k];
            largest.stamp = largest.stamp.max(stamps.abs());
        }
        largest.force = largest.force.max((late_force(a) - late_force(b)).norm());
    }
    largest
}

/// For motion, force, gap and stamp: whether an effect of typical size must change it by more than
/// 0.3 mm, 0.03 N, 0.3 mm, 1 ms (`y`), must leave it within 0.07 mm, 0.02 N, 0.15 mm, 0 ms (`n`), or
/// may do either (`-`). A change of the force moves the tip on its spring by 20 µm/N, also at the
/// first touch, which has a peak of several N.
const CHANNELS: &[(&str, &str)] = &[
    ("support-friction", "nynn"),
    ("pressure-radius", "yynn"),
    ("limit-surface-shape", "yynn"),
    ("friction-center-offset", "yynn"),
    ("table-anisotropy", "yynn"),
    ("body-anisotropy", "yynn"),
    ("friction-gradient", "yynn"),
    ("table-tilt", "yynn"),
    ("rate-dependent-friction", "yynn"),
    ("support-stiction", "yynn"),
    ("friction-drift", "nynn"),
    ("pusher-friction", "yynn"),
    ("pusher-friction-asymmetry", "yynn"),
    ("pusher-stiction", "yynn"),
    ("pusher-radius", "y-yn"),
    ("contact-bias", "yynn"),
    ("edge-rounding", "y--n"),
    ("pusher-compliance", "y-yn"),
    ("pose-offset", "ynyn"),
    ("yaw-offset", "nnyn"),
    ("robot-offset", "nnyn"),
    ("stream-latency", "nnny"),
    ("force-bias", "nynn"),
    ("support-points", "yynn"),
    ("pressure-map", "yynn"),
    ("vertex-contact", "--nn"),
    ("push-height", "yynn"),
    ("friction-field", "yynn"),
    ("cable-drag", "yynn"),
    ("chipped-corner", "yyyn"),
    ("flexing-tip", "y-yn"),
    ("liquid-film", "yy-n"),
    ("magnet", "yynn"),
    ("sticky-spot", "yynn"),
    ("wobbling-foot", "yynn"),
    ("worn-groove", "yynn"),
];

#[test]
fn each_effect_changes_the_channels_that_it_should_and_no_other() {
    let plain = set(None, 16);
    let expected: BTreeMap<_, _> = CHANNELS.iter().copied().collect();
    let mut wrong = Vec::new();
    for kind in effect_kinds().into_iter().filter(|kind| kind.id != "inertia") {
        let found = differences(&plain, &set(Some(HiddenEffect::typical(kind.id).unwrap()), 16));
        let changes = [
            (found.motion, 3e-4, 7e-5),
            (found.force, 0.03, 0.02),
            (found.gap, 3e-4, 1.5e-4),
            (found.stamp, 1e-3, 0.0),
        ];
        let is_right = |(rule, (change, least, most)): (char, (f64, f64, f64))| match rule {
            'y' => change > least,
            'n' => change <= most,
            _ => true,
        };
        if !expected[kind.id].chars().zip(changes).all(is_right) {
            wrong.push((kind.id, found));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn an_effect_of_size_zero_is_no_effect_to_the_last_bit() {
    let plain = set(None, 2);
    for kind in effect_kinds().into_iter().filter(|kind| kind.id != "inertia") {
        let mut effect = HiddenEffect::typical(kind.id).unwrap();
        for parameter in kind.parameters {
            if let Some(off) = parameter.off {
                effect = effect.with(parameter.name, off).unwrap();
            }
        }
        assert_eq!(set(Some(effect), 2), plain, "{}", kind.id);
    }
}

#[test]
fn fast_pushes_let_the_object_slide_on_after_the_stop() {
    let slide = |hidden: Option<HiddenEffect>| {
        let pushes = set(hidden, 12);
        let slide = |push: &SimulatedPush| {
            let stop = push.trajectory.duration() - 0.3;
            let (there, end) = (push.trajectory.pose_at(stop), push.trajectory.end_pose());
            (end.position - there.position).norm()
        };
        pushes.iter().map(slide).fold(0.0, f64::max)
    };
    let (slow, fast) = (slide(None), slide(Some(HiddenEffect::typical("inertia").unwrap())));
    // What a slow tip still moves the object is its spring's 20 µm/N.
    assert!(slow < 1e-4, "{slow}");
    assert!(fast > 0.01, "{fast}");
}
