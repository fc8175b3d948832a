//! Frames, signs and units that cannot be, on sets of the simulator; and none where nothing is wrong.

use std::f64::consts::{FRAC_PI_2, PI};

use dataset::{Manifest, ObjectChoice, Recording, RecordingSet, Suspicion, suspicions};
use plant::{Design, GenerateSettings, Layout, PushedObject, generate};

/// The recordings of a set, as read.
fn made(settings: &GenerateSettings) -> (Vec<Recording>, Manifest) {
    let folder = tempfile::tempdir().unwrap();
    generate(settings, &folder.path().join("set")).unwrap();
    let set = RecordingSet::open(&folder.path().join("set")).unwrap();
    let read = set.recordings().iter().map(|path| set.read(path).unwrap());
    (read.collect(), set.manifest().clone())
}

fn settings(shape: &str, layout: Layout, hidden: &[&str], seed: u64) -> GenerateSettings {
    GenerateSettings {
        object: PushedObject::Mit { name: shape.into() },
        hidden: hidden.iter().map(|hidden| hidden.parse().unwrap()).collect(),
        design: Design { n_pushes: 16, layout, ..Design::default() },
        format: "csv".into(),
        seed,
        ..GenerateSettings::default()
    }
}

fn told(found: &[Suspicion]) -> Vec<&str> {
    found.iter().map(|suspicion| suspicion.what.as_str()).collect()
}

/// Every effect of the catalogue, larger than a diagnosis would meet it.
const STRONG: &[&str] = &[
    "support-friction: coefficient=0.5",
    "support-friction: coefficient=0.125",
    "pressure-radius: ratio=0.6",
    "limit-surface-shape: patch_share=0",
    "friction-center-offset: x_mm=20, y_mm=-15",
    "table-anisotropy: ratio=2, direction_deg=34",
    "body-anisotropy: ratio=2, direction_deg=34",
    "friction-gradient: x_per_m=4, y_per_m=-3",
    "table-tilt: x_m_s2=-1, y_m_s2=0.8",
    "rate-dependent-friction: slope=0.4",
    "support-stiction: ratio=2",
    "friction-drift: change=-0.6",
    "pusher-friction: coefficient=0.8",
    "pusher-friction: coefficient=0.02",
    "pusher-friction-asymmetry: difference=1",
    "pusher-stiction: ratio=2.5",
    "pusher-radius: radius_mm=7",
    "pusher-radius: radius_mm=1",
    "contact-bias: offset_mm=6",
    "edge-rounding: radius_mm=15",
    "pusher-compliance: compliance_mm_per_n=2",
    "inertia: speed_m_s=0.5",
    "pose-offset: x_mm=10, y_mm=-8",
    "yaw-offset: angle_deg=15",
    "yaw-offset: angle_deg=-15",
    "stream-latency: delay_ms=150",
    "force-bias: x_n=1, y_n=-0.6, rotation_rad=0.4",
];

#[test]
fn nothing_is_suspected_of_what_is_right_whatever_it_hides() {
    let rich = |hidden: &'static &'static str| ("rect1", Layout::Rich, vec![*hidden]);
    let plain = ["rect1", "tri2", "ellip2", "butter"].map(|shape| (shape, Layout::Rich, vec![]));
    let narrow = ("rect1", Layout::Narrow { edge: 1 }, vec![]);
    let sets = plain.into_iter().chain([narrow]).chain(STRONG.iter().map(rich));
    for (index, (shape, layout, hidden)) in sets.enumerate() {
        let (recordings, manifest) = made(&settings(shape, layout, &hidden, 60 + index as u64));
        let found = suspicions(recordings, &manifest);
        assert_eq!(told(&found), [""; 0], "{shape} {hidden:?}: {found:?}");
    }
}

/// A corruption of recordings or manifest, and what has to be said of it.
type Corruption = (&'static str, fn(&mut Recording), fn(&mut Manifest));

const CORRUPTIONS: &[Corruption] = &[
    ("the object's angle has the wrong sign", |r| scale(&mut r.object.theta, -1.0), |_| {}),
    (
        "the object's frame is mirrored (y, and the angle's sign)",
        |r| {
            scale(&mut r.object.y, -1.0);
            scale(&mut r.object.theta, -1.0);
        },
        |_| {},
    ),
    (
        "swapped x and y of the object's positions",
        |r| std::mem::swap(&mut r.object.x, &mut r.object.y),
        |_| {},
    ),
    ("wrong sign of y of the object's positions", |r| scale(&mut r.object.y, -1.0), |_| {}),
    (
        "swapped x and y of the pusher's positions",
        |r| std::mem::swap(&mut r.robot.x, &mut r.robot.y),
        |_| {},
    ),
    ("wrong sign of x of the pusher's positions", |r| scale(&mut r.robot.x, -1.0), |_| {}),
    (
        "swapped x and y of both the pusher's and the object's positions",
        |r| {
            std::mem::swap(&mut r.object.x, &mut r.object.y);
            std::mem::swap(&mut r.robot.x, &mut r.robot.y);
        },
        |_| {},
    ),
    (
        "the object's frame is turned by 90° against the pusher's",
        |r| {
            std::mem::swap(&mut r.object.x, &mut r.object.y);
            scale(&mut r.object.x, -1.0);
            r.object.theta.iter_mut().for_each(|theta| *theta += FRAC_PI_2);
        },
        |_| {},
    ),
    (
        "the object's angles are in degrees, not rad",
        |r| scale(&mut r.object.theta, 180.0 / PI),
        |_| {},
    ),
    (
        "both the pusher's and the object's positions are in mm, not m",
        |r| {
            lengths(&mut r.robot, 1e3);
            lengths(&mut r.object, 1e3);
        },
        |_| {},
    ),
    ("the object's positions are in mm, not m", |r| lengths(&mut r.object, 1e3), |_| {}),
    ("the pusher's positions are in mm, not m", |r| lengths(&mut r.robot, 1e3), |_| {}),
    ("the pusher's positions are 1000 times too small", |r| lengths(&mut r.robot, 1e-3), |_| {}),
    ("the pusher's radius is in mm, not m", |_| {}, |m| m.pusher.radius *= 1e3),
    ("swapped x and y of the force", |r| swap_forces(r), |_| {}),
    (
        "wrong signs of x and y of the force",
        |r| {
            scale_forces(r, -1.0);
        },
        |_| {},
    ),
    ("wrong sign of y of the force", |r| scale(&mut r.wrench.as_mut().unwrap().fy, -1.0), |_| {}),
    ("the force is in mN, not N", |r| scale_forces(r, 1e3), |_| {}),
    ("the force is in kN, not N", |r| scale_forces(r, 1e-3), |_| {}),
    ("the times are in ms, not s", |r| times(r, 1e3), |_| {}),
    ("the times are 1000 times too small", |r| times(r, 1e-3), |_| {}),
    (
        "the mass is in g, not kg",
        |_| {},
        |m| {
            let ObjectChoice::Fixed(object) = &mut m.object else { return };
            object.mass *= 1e3;
        },
    ),
];

fn scale(values: &mut [f64], factor: f64) {
    values.iter_mut().for_each(|value| *value *= factor);
}

fn lengths(stream: &mut dataset::PoseStream, factor: f64) {
    scale(&mut stream.x, factor);
    scale(&mut stream.y, factor);
}

fn swap_forces(recording: &mut Recording) {
    let wrench = recording.wrench.as_mut().unwrap();
    std::mem::swap(&mut wrench.fx, &mut wrench.fy);
}

fn scale_forces(recording: &mut Recording, factor: f64) {
    let wrench = recording.wrench.as_mut().unwrap();
    scale(&mut wrench.fx, factor);
    scale(&mut wrench.fy, factor);
}

fn times(recording: &mut Recording, factor: f64) {
    scale(&mut recording.robot.t, factor);
    scale(&mut recording.object.t, factor);
    scale(&mut recording.wrench.as_mut().unwrap().t, factor);
}

#[test]
fn each_mistake_is_told_as_what_it_is_and_nothing_else() {
    for (shape, hidden) in
        [("rect1", &[][..]), ("tri2", &["table-anisotropy: ratio=1.3, direction_deg=34"])]
    {
        let (recordings, manifest) = made(&settings(shape, Layout::Rich, hidden, 51));
        for (what, corrupt, misstate) in CORRUPTIONS {
            let (mut recordings, mut manifest) = (recordings.clone(), manifest.clone());
            recordings.iter_mut().for_each(corrupt);
            misstate(&mut manifest);
            let found = suspicions(recordings, &manifest);
            eprintln!("{found:#?}");
            assert_eq!(told(&found), [*what], "{shape}: {found:?}");
            assert!(found[0].is_certain && !found[0].fix.is_empty(), "{found:?}");
        }
    }
}

#[test]
fn one_edge_and_one_orientation_tell_signs_of_what_moves() {
    let (recordings, manifest) = made(&settings("rect1", Layout::Narrow { edge: 1 }, &[], 52));
    for corrupt in [
        |r: &mut Recording| scale(&mut r.object.theta, -1.0),
        |r: &mut Recording| scale(&mut r.object.y, -1.0),
        |r: &mut Recording| scale_forces(r, -1.0),
        |r: &mut Recording| swap_forces(r),
    ] {
        let mut recordings = recordings.clone();
        recordings.iter_mut().for_each(corrupt);
        let found = suspicions(recordings, &manifest);
        assert!(found.len() == 1 && found[0].is_certain, "{found:?}");
    }
}
