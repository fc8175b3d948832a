//! Recordings with a known motion: a square that a round pusher carries along and turns.

use std::path::Path;

use dataset::{PoseStream, Recording, WrenchStream, all_writers};
use nalgebra::Vector2;
use planar::{Pose, perpendicular};

pub(crate) const HALF_SIDE: f64 = 0.045;
pub(crate) const RADIUS: f64 = 0.00475;

/// A push whose motion is prescribed, not computed: the pusher moves straight along the body's
/// x axis, and from the first contact on the object turns at a constant rate about the contact.
#[derive(Clone, Copy)]
pub(crate) struct Made {
    /// Speed of the pusher, in m/s.
    pub(crate) speed: f64,
    /// Time from first contact to the stop, in s.
    pub(crate) duration: f64,
    /// Body y of the contact on the face at −x, in m.
    pub(crate) contact_y: f64,
    /// Yaw rate of the object while pushed, in rad/s.
    pub(crate) yaw_rate: f64,
    /// Normal and tangential force on the object while pushed, in N.
    pub(crate) force: [f64; 2],
    /// Force read without contact, in the world, in N.
    pub(crate) zero: [f64; 2],
    /// Pose of the whole scene in the world.
    pub(crate) scene: Pose,
    /// Whether the whole scene is mirrored at the world's x axis.
    pub(crate) mirrored: bool,
    /// Stamps of the robot, the object and the force per second.
    pub(crate) rates: [f64; 3],
    /// Of the pusher, in m: less than 0 of a point that seems to be inside of the outline.
    pub(crate) radius: f64,
}

pub(crate) const REST: f64 = 0.3;
/// Distance between pusher and outline at the beginning, in m.
pub(crate) const APPROACH: f64 = 4e-3;

impl Default for Made {
    fn default() -> Self {
        Self {
            speed: 0.02,
            duration: 1.0,
            contact_y: 0.01,
            yaw_rate: -0.3,
            force: [2.0, 0.3],
            zero: [0.4, -0.7],
            scene: Pose::new(0.3, -0.2, 0.7),
            mirrored: false,
            rates: [250.0, 100.0, 100.0],
            radius: RADIUS,
        }
    }
}

impl Made {
    pub(crate) fn touch(&self) -> f64 {
        REST + APPROACH / self.speed
    }

    pub(crate) fn stop(&self) -> f64 {
        self.touch() + self.duration
    }

    /// Time in contact and moving, at a time of the recording.
    fn pushed(&self, t: f64) -> f64 {
        (t - self.touch()).clamp(0.0, self.duration)
    }

    fn pusher(&self, t: f64) -> Vector2<f64> {
        let way = self.speed * (t - REST).clamp(0.0, self.stop() - REST);
        let start = -HALF_SIDE - self.radius - APPROACH;
        self.place(&Vector2::new(start + way, self.contact_y))
    }

    /// The object keeps its contact point on the pusher's surface as it turns.
    pub(crate) fn object(&self, t: f64) -> Pose {
        let pushed = self.pushed(t);
        let angle = self.yaw_rate * pushed;
        let turn = Pose::new(0.0, 0.0, angle);
        let pusher = Vector2::new(-HALF_SIDE - self.radius + self.speed * pushed, self.contact_y);
        let contact = pusher + self.radius * turn.rotate(&Vector2::x());
        let origin = contact - turn.rotate(&Vector2::new(-HALF_SIDE, self.contact_y));
        let position = self.place(&origin);
        let sign = if self.mirrored { -1.0 } else { 1.0 };
        Pose { position, angle: sign * (self.scene.angle + angle) }
    }

    fn place(&self, point: &Vector2<f64>) -> Vector2<f64> {
        self.mirror(self.scene.transform_point(point))
    }

    fn mirror(&self, v: Vector2<f64>) -> Vector2<f64> {
        if self.mirrored { Vector2::new(v.x, -v.y) } else { v }
    }

    fn force_on_pusher(&self, t: f64) -> Vector2<f64> {
        let zero = Vector2::from(self.zero);
        let pushed = t - self.touch();
        if !(0.0..=self.duration).contains(&pushed) {
            return zero;
        }
        let turn = Pose::new(0.0, 0.0, self.scene.angle + self.yaw_rate * pushed);
        let normal = turn.rotate(&Vector2::x());
        let on_object = self.force[0] * normal + self.force[1] * perpendicular(&normal);
        zero - self.mirror(on_object)
    }

    pub(crate) fn recording(&self, name: &str) -> Recording {
        let end = self.stop() + REST;
        let stamps = |rate: f64| -> Vec<f64> {
            (0..).map(|i| i as f64 / rate).take_while(|&t| t <= end).collect()
        };
        let mut robot = PoseStream { source: "robot".into(), ..PoseStream::default() };
        for t in stamps(self.rates[0]) {
            let position = self.pusher(t);
            robot.t.push(t);
            robot.x.push(position.x);
            robot.y.push(position.y);
            robot.theta.push(0.0);
        }
        let mut object = PoseStream { source: "object".into(), ..PoseStream::default() };
        for t in stamps(self.rates[1]) {
            let pose = self.object(t);
            object.t.push(t);
            object.x.push(pose.position.x);
            object.y.push(pose.position.y);
            object.theta.push(pose.angle);
        }
        let mut wrench = WrenchStream { source: "wrench".into(), ..WrenchStream::default() };
        for (i, t) in stamps(self.rates[2]).into_iter().enumerate() {
            let force = self.force_on_pusher(t);
            // A sensor's noise of 5 mN, made by hand so that it is the same everywhere.
            let noise = 0.005 * ((i * 7919) % 13) as f64 / 6.0 - 0.005;
            wrench.t.push(t);
            wrench.fx.push(force.x + noise);
            wrench.fy.push(force.y - noise);
        }
        Recording {
            name: name.into(),
            path: name.into(),
            sha256: String::new(),
            epoch_ns: 1_000_000_000_000,
            robot,
            object,
            wrench: Some(wrench),
            remarks: Vec::new(),
        }
    }
}

/// Writes a set of recordings in the format of one writer, with its manifest.
pub(crate) fn write_set(dir: &Path, writer_id: &str, recordings: &[Recording]) {
    let writer = all_writers().iter().find(|writer| writer.id() == writer_id).unwrap();
    let pushes = dir.join("pushes");
    std::fs::create_dir_all(&pushes).unwrap();
    for recording in recordings {
        writer.write(recording, &pushes).unwrap();
    }
    std::fs::write(dir.join("dataset.toml"), manifest(writer.format())).unwrap();
}

pub(crate) fn manifest(format: &str) -> String {
    format!(
        "name = \"made\"\n\n[object]\nshape = \"square\"\nside_m = 0.09\nmass_kg = 0.8374\n\n\
         [pusher]\nradius_m = {RADIUS}\nfriction = 0.25\n\n[support]\nfriction = 0.25\n\n\
         [recordings]\nformat = \"{format}\"\npath = \"pushes\"\n"
    )
}
