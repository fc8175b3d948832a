//! Mistakes that are made with recordings and manifests.

use std::f64::consts::PI;

use dataset::{Manifest, ObjectChoice, ObjectSpec, PoseStream, Recording};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

/// A mistake, and the words by which what is said of it names it.
pub(crate) struct Mistake {
    pub(crate) name: &'static str,
    /// The stream, or what of the manifest.
    pub(crate) stream: &'static str,
    pub(crate) make: fn(&mut Recording, &mut Manifest),
    /// Some of these words have to be said; none where the stream has no such number.
    pub(crate) named: &'static [&'static str],
}

impl Mistake {
    /// Whether what is read depends on how the yaw is written.
    pub(crate) fn is_of_quaternions(&self) -> bool {
        self.name.starts_with("quaternion")
    }
}

const fn mistake(
    name: &'static str,
    stream: &'static str,
    make: fn(&mut Recording, &mut Manifest),
    named: &'static [&'static str],
) -> Mistake {
    Mistake { name, stream, make, named }
}

const KGF: f64 = 9.806_65;
const LBF: f64 = 4.448_222;
const OZF: f64 = 0.278_013_9;
const FOOT: f64 = 0.3048;
const INCH: f64 = 0.0254;

/// What a person may get wrong, stream by stream.
pub(crate) const MISTAKES: &[Mistake] = &[
    mistake(
        "positions in mm",
        "robot",
        |r, _| lengths(&mut r.robot, 1e3),
        &["pusher's positions are in mm"],
    ),
    mistake(
        "positions in mm",
        "object",
        |r, _| lengths(&mut r.object, 1e3),
        &["object's positions are in mm"],
    ),
    mistake(
        "positions in cm",
        "robot",
        |r, _| lengths(&mut r.robot, 1e2),
        &["pusher's positions are in cm"],
    ),
    mistake(
        "positions in cm",
        "object",
        |r, _| lengths(&mut r.object, 1e2),
        &["object's positions are in cm"],
    ),
    mistake(
        "positions in inches",
        "robot",
        |r, _| lengths(&mut r.robot, 1.0 / INCH),
        &["pusher's positions are in inches"],
    ),
    mistake(
        "positions in inches",
        "object",
        |r, _| lengths(&mut r.object, 1.0 / INCH),
        &["object's positions are in inches"],
    ),
    mistake(
        "positions in feet",
        "robot",
        |r, _| lengths(&mut r.robot, 1.0 / FOOT),
        &["pusher's positions are in feet"],
    ),
    mistake(
        "positions in feet",
        "object",
        |r, _| lengths(&mut r.object, 1.0 / FOOT),
        &["object's positions are in feet"],
    ),
    mistake(
        "angles in degrees",
        "object",
        |r, _| scale(&mut r.object.theta, 180.0 / PI),
        &["in degrees"],
    ),
    mistake(
        "angles of the wrong sign",
        "object",
        |r, _| scale(&mut r.object.theta, -1.0),
        &["angle has the wrong sign"],
    ),
    mistake(
        "x mirrored",
        "robot",
        |r, _| scale(&mut r.robot.x, -1.0),
        &["wrong sign of x of the pusher's"],
    ),
    mistake(
        "x mirrored",
        "object",
        |r, _| scale(&mut r.object.x, -1.0),
        &["wrong sign of x of the object's"],
    ),
    mistake(
        "x mirrored",
        "wrench",
        |r, _| force(r, |[x, y]| [-x, y]),
        &["wrong sign of x of the force"],
    ),
    mistake(
        "y mirrored",
        "robot",
        |r, _| scale(&mut r.robot.y, -1.0),
        &["wrong sign of y of the pusher's"],
    ),
    mistake(
        "y mirrored",
        "object",
        |r, _| scale(&mut r.object.y, -1.0),
        &["wrong sign of y of the object's"],
    ),
    mistake(
        "y mirrored",
        "wrench",
        |r, _| force(r, |[x, y]| [x, -y]),
        &["wrong sign of y of the force"],
    ),
    mistake(
        "x and y swapped",
        "robot",
        |r, _| swap(&mut r.robot),
        &["swapped x and y of the pusher's"],
    ),
    mistake(
        "x and y swapped",
        "object",
        |r, _| swap(&mut r.object),
        &["swapped x and y of the object's"],
    ),
    mistake(
        "x and y swapped",
        "wrench",
        |r, _| force(r, |[x, y]| [y, x]),
        &["swapped x and y of the force"],
    ),
    mistake(
        "quaternion w, x, y, z read as x, y, z, w",
        "object",
        |r, _| reorder(&mut r.object),
        &["quaternions are in another order"],
    ),
    mistake(
        "robot and object exchanged",
        "robot, object",
        |r, _| std::mem::swap(&mut r.robot, &mut r.object),
        &["exchanged"],
    ),
    mistake(
        "sign of the force",
        "wrench",
        |r, _| force(r, |f| f.map(|f| -f)),
        &["wrong signs of x and y of the force"],
    ),
    mistake("kgf", "wrench", |r, _| force(r, |f| f.map(|f| f / KGF)), &["kgf"]),
    mistake("gf", "wrench", |r, _| force(r, |f| f.map(|f| 1e3 * f / KGF)), &["in gf"]),
    mistake("lbf", "wrench", |r, _| force(r, |f| f.map(|f| f / LBF)), &["lbf"]),
    mistake("ozf", "wrench", |r, _| force(r, |f| f.map(|f| f / OZF)), &["ozf"]),
    mistake("mN", "wrench", |r, _| force(r, |f| f.map(|f| 1e3 * f)), &["mN"]),
    mistake("kN", "wrench", |r, _| force(r, |f| f.map(|f| 1e-3 * f)), &["kN"]),
    mistake("3 times too large", "wrench", |r, _| force(r, |f| f.map(|f| 3.0 * f)), &["force"]),
    mistake("1 s late", "robot", |r, _| shift(&mut r.robot.t, 1.0), &["pusher's stream is 1.0"]),
    mistake("1 s late", "object", |r, _| shift(&mut r.object.t, 1.0), &["object's stream is 1.0"]),
    mistake(
        "1 s late",
        "wrench",
        |r, _| late_force(r, 1.0),
        &["stream of forces is 1.0", "stream of forces is 0.9"],
    ),
    mistake("3 s early", "robot", |r, _| shift(&mut r.robot.t, -3.0), &["pusher's stream is 3.0"]),
    mistake(
        "3 s early",
        "object",
        |r, _| shift(&mut r.object.t, -3.0),
        &["object's stream is 3.0"],
    ),
    mistake(
        "3 s early",
        "wrench",
        |r, _| late_force(r, -3.0),
        &["stream of forces is 3.0", "stream of forces is 2.9"],
    ),
    mistake(
        "an hour late",
        "robot",
        |r, _| shift(&mut r.robot.t, 3600.0),
        &["pusher's stream is 3600"],
    ),
    mistake(
        "an hour late",
        "object",
        |r, _| shift(&mut r.object.t, 3600.0),
        &["object's stream is 3600"],
    ),
    mistake(
        "an hour late",
        "wrench",
        |r, _| late_force(r, 3600.0),
        &["stream of forces is 3600", "stream of forces is 3599.9"],
    ),
    mistake("times in ms", "all", |r, _| times(r, 1e3), &["times are in ms"]),
    mistake("times in ns", "all", |r, _| times(r, 1e9), &["times are in ns"]),
    mistake("times in minutes", "all", |r, _| times(r, 1.0 / 60.0), &["times are in minutes"]),
    mistake("mass in g", "manifest", |_, m| object(m).mass *= 1e3, &["mass is in g"]),
    mistake("mass in lb", "manifest", |_, m| object(m).mass *= 2.204_623, &["mass is in lb"]),
    mistake(
        "mass 10 times too large",
        "manifest",
        |_, m| object(m).mass *= 10.0,
        &["friction 0.0"],
    ),
    mistake(
        "gravity of 1.62 m/s²",
        "manifest",
        |_, m| m.support.gravity = 1.62,
        &["gravity is not 1.62"],
    ),
    mistake(
        "support friction of 2.5",
        "manifest",
        |_, m| m.support.friction = 2.5,
        &["support.friction = 0.2"],
    ),
    mistake(
        "dimensions in inches",
        "manifest",
        |_, m| outline(m, 1.0 / INCH),
        &["dimensions are in inches"],
    ),
    mistake(
        "pusher's radius in mm",
        "manifest",
        |_, m| m.pusher.radius *= 1e3,
        &["radius is in mm"],
    ),
    mistake(
        "another shape: rect2",
        "manifest",
        |_, m| *object(m) = ObjectSpec::mit("rect2").unwrap(),
        &["outline"],
    ),
    mistake(
        "another shape: hex",
        "manifest",
        |_, m| *object(m) = ObjectSpec::mit("hex").unwrap(),
        &["outline"],
    ),
    mistake(
        "another shape: tri1",
        "manifest",
        |_, m| *object(m) = ObjectSpec::mit("tri1").unwrap(),
        &["outline"],
    ),
    mistake(
        "orientation, in any unit or order",
        "robot",
        |r, _| r.robot.theta.iter_mut().for_each(|t| *t = 57.0 * *t + 1.0),
        &[],
    ),
];

fn object(manifest: &mut Manifest) -> &mut ObjectSpec {
    match &mut manifest.object {
        ObjectChoice::Fixed(object) => object,
        ObjectChoice::ByFileName => panic!("the simulator writes the object into the manifest"),
    }
}

fn outline(manifest: &mut Manifest, factor: f64) {
    let side = 0.09 * factor;
    object(manifest).shape = planar::Shape::square(side).unwrap();
}

fn scale(values: &mut [f64], factor: f64) {
    values.iter_mut().for_each(|value| *value *= factor);
}

fn shift(values: &mut [f64], offset: f64) {
    values.iter_mut().for_each(|value| *value += offset);
}

fn lengths(stream: &mut PoseStream, factor: f64) {
    scale(&mut stream.x, factor);
    scale(&mut stream.y, factor);
}

fn swap(stream: &mut PoseStream) {
    std::mem::swap(&mut stream.x, &mut stream.y);
}

fn force(recording: &mut Recording, change: fn([f64; 2]) -> [f64; 2]) {
    let wrench = recording.wrench.as_mut().unwrap();
    for (x, y) in wrench.fx.iter_mut().zip(&mut wrench.fy) {
        [*x, *y] = change([*x, *y]);
    }
}

fn late_force(recording: &mut Recording, offset: f64) {
    shift(&mut recording.wrench.as_mut().unwrap().t, offset);
}

fn times(recording: &mut Recording, factor: f64) {
    scale(&mut recording.robot.t, factor);
    scale(&mut recording.object.t, factor);
    scale(&mut recording.wrench.as_mut().unwrap().t, factor);
}

/// The yaw and the tilt of a body whose quaternions are written as (w, x, y, z) and read as
/// (x, y, z, w).
fn reorder(stream: &mut PoseStream) {
    for theta in &mut stream.theta {
        let true_one = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), *theta);
        let [x, y, z, w]: [f64; 4] = true_one.coords.into();
        // `Quaternion::new` takes w first.
        let read = UnitQuaternion::from_quaternion(Quaternion::new(z, w, x, y));
        let matrix = read.to_rotation_matrix();
        *theta = matrix[(1, 0)].atan2(matrix[(0, 0)]);
        stream.max_tilt = stream.max_tilt.max(matrix[(2, 2)].clamp(-1.0, 1.0).acos());
    }
}
