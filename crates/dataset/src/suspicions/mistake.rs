//! What can be wrong with the frames and units of poses, outline and pusher.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Matrix2, Vector2};
use planar::{Contact, Pose, Shape, wrap_angle};

use super::moment::Moment;

/// Poses, outline and pusher as they would be without one mistake.
#[derive(Clone, Debug)]
pub(super) struct View {
    /// What is wrong with those recorded.
    pub(super) what: String,
    /// What to correct.
    pub(super) fix: String,
    /// What the evidence for a unit asks for: a fit better by far.
    pub(super) is_unit: bool,
    robot: Matrix2<f64>,
    object: Matrix2<f64>,
    /// Factor and offset of the yaw, in rad.
    yaw: (f64, f64),
    outline: f64,
    radius: f64,
}

/// A moment in such a view.
pub(super) struct Seen {
    pub(super) contact: Contact,
    /// Inward normal in W.
    pub(super) normal: Vector2<f64>,
    /// Way of the pusher in W, in m.
    pub(super) way: Vector2<f64>,
    /// Way of the pusher along the material of the object, along the normal turned by +90°, in m.
    pub(super) slip: f64,
}

impl View {
    /// As recorded.
    pub(super) fn recorded() -> Self {
        Self {
            what: String::new(),
            fix: String::new(),
            is_unit: false,
            robot: Matrix2::identity(),
            object: Matrix2::identity(),
            yaw: (1.0, 0.0),
            outline: 1.0,
            radius: 1.0,
        }
    }

    /// What the outline's lengths have to be multiplied by.
    pub(super) fn outline_scale(&self) -> f64 {
        self.outline
    }

    /// A moment seen so; `radius` of the pusher in m as stated.
    pub(super) fn seen(&self, moment: &Moment, shape: &Shape, radius: f64) -> Seen {
        let pusher = moment.pusher.map(|position| self.robot * position);
        let pose = moment.object.map(|(position, yaw)| {
            let (factor, offset) = self.yaw;
            Pose { position: self.object * position, angle: wrap_angle(factor * yaw + offset) }
        });
        // The outline is left as it is, and all else made larger instead.
        let center = pose[1].inverse_transform_point(&pusher[1]);
        let mut contact =
            shape.contact(&(center / self.outline), self.radius * radius / self.outline);
        contact.gap *= self.outline;
        let material = self.outline * contact.point;
        let normal = pose[1].rotate(&contact.normal);
        let way = pusher[2] - pusher[0];
        let carried = pose[2].transform_point(&material) - pose[0].transform_point(&material);
        Seen { contact, normal, way, slip: (way - carried).dot(&planar::perpendicular(&normal)) }
    }

    /// Every single mistake, the likelier first.
    pub(super) fn mistakes() -> Vec<Self> {
        let mut all = vec![Self {
            what: "the object's angle has the wrong sign".into(),
            fix: "set theta with scale = -1 under streams.object.columns (fields in MCAP and \
                  bags; of a quaternion qz)"
                .into(),
            yaw: (-1.0, 0.0),
            ..Self::recorded()
        }];
        for (name, axes, offset) in mirrors() {
            all.push(Self {
                what: format!("the object's frame is mirrored ({name}, and the angle's sign)"),
                fix: format!("correct {name} and theta under streams.object.columns (or fields)"),
                object: axes,
                yaw: (-1.0, offset),
                ..Self::recorded()
            });
        }
        for quarter in [FRAC_PI_2, PI, -FRAC_PI_2] {
            all.push(Self {
                what: format!(
                    "the object's frame is turned by {:.0}° against the pusher's",
                    -quarter.to_degrees()
                ),
                fix: format!("set streams.object.transform = {{ yaw_rad = {quarter:.4} }}"),
                object: nalgebra::Rotation2::new(quarter).into_inner(),
                yaw: (1.0, quarter),
                ..Self::recorded()
            });
        }
        for (name, axes) in axes() {
            for (stream, robot, object) in [
                ("object", Matrix2::identity(), axes),
                ("robot", axes, Matrix2::identity()),
                ("robot and streams.object", axes, axes),
            ] {
                all.push(Self {
                    what: format!("{} of {}", name, of(stream)),
                    fix: format!("correct x and y under streams.{stream}.columns (or fields)"),
                    robot,
                    object,
                    ..Self::recorded()
                });
            }
        }
        all.extend(units());
        all
    }
}

fn of(stream: &str) -> &'static str {
    match stream {
        "object" => "the object's positions",
        "robot" => "the pusher's positions",
        _ => "both the pusher's and the object's positions",
    }
}

/// Reflections: name, positions, offset of the yaw whose sign turns.
fn mirrors() -> [(&'static str, Matrix2<f64>, f64); 3] {
    [
        ("y", Matrix2::new(1.0, 0.0, 0.0, -1.0), 0.0),
        ("x", Matrix2::new(-1.0, 0.0, 0.0, 1.0), PI),
        ("x and y", Matrix2::new(0.0, 1.0, 1.0, 0.0), FRAC_PI_2),
    ]
}

/// What can be wrong with two axes.
pub(super) fn axes() -> [(&'static str, Matrix2<f64>); 7] {
    [
        ("swapped x and y", Matrix2::new(0.0, 1.0, 1.0, 0.0)),
        ("wrong sign of y", Matrix2::new(1.0, 0.0, 0.0, -1.0)),
        ("wrong sign of x", Matrix2::new(-1.0, 0.0, 0.0, 1.0)),
        ("wrong signs of x and y", Matrix2::new(-1.0, 0.0, 0.0, -1.0)),
        ("swapped x and y, one of them with the wrong sign,", Matrix2::new(0.0, -1.0, 1.0, 0.0)),
        ("swapped x and y, one of them with the wrong sign,", Matrix2::new(0.0, 1.0, -1.0, 0.0)),
        ("swapped x and y, both with the wrong sign,", Matrix2::new(0.0, -1.0, -1.0, 0.0)),
    ]
}

/// Angles in degrees, and lengths in millimeters or centimeters.
fn units() -> Vec<View> {
    let unit = |what: String, fix: String| View { what, fix, is_unit: true, ..View::recorded() };
    let angle = |scale: f64, what: &str| View {
        yaw: (scale, 0.0),
        ..unit(
            what.to_owned(),
            format!("set theta with scale = {scale:.9} under streams.object.columns (or fields)"),
        )
    };
    let mut all = vec![
        angle(1_f64.to_radians(), "the object's angles are in degrees, not rad"),
        angle(1_f64.to_degrees(), "the object's angles are 57 times too small"),
    ];
    for (scale, how) in [
        (1e-3, "in mm, not m"),
        (1e-2, "in cm, not m"),
        (0.0254, "in inches, not m"),
        (0.3048, "in feet, not m"),
        (1e3, "1000 times too small"),
        (1e2, "100 times too small"),
    ] {
        let scaled = Matrix2::identity() * scale;
        let same = Matrix2::identity();
        for (stream, robot, object) in [
            ("robot and streams.object", scaled, scaled),
            ("object", same, scaled),
            ("robot", scaled, same),
        ] {
            all.push(View {
                robot,
                object,
                ..unit(
                    format!("{} are {how}", of(stream)),
                    format!(
                        "set x and y with scale = {scale} under streams.{stream}.columns (or fields)"
                    ),
                )
            });
        }
        let outline = |radius: f64, what: &str, key: &str| View {
            outline: scale,
            radius,
            ..unit(format!("{what} {how}"), format!("correct {key} in the manifest"))
        };
        all.push(outline(1.0, "the object's dimensions are", "[object]"));
        all.push(outline(
            scale,
            "the object's dimensions and the pusher's radius are",
            "[object] and pusher.radius_m",
        ));
        all.push(View {
            radius: scale,
            ..unit(
                format!("the pusher's radius is {how}"),
                "correct pusher.radius_m in the manifest".into(),
            )
        });
    }
    all
}
