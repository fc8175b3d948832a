//! One push as it is planned, on the nominal outline.

use libm::{cos, sin, sqrt};
use nalgebra::Vector2;
use planar::{Ellipse, Pose, Shape};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

use crate::dynamics::state::rotation;
use crate::error::check_range;
use crate::{PlantError, TipPath};

/// Shortest way to the touch, in m, and shortest distance of the tip from the edge at the start:
/// enough for the force sensor's zero to be seen.
const APPROACH: f64 = 0.004;
const CLEARANCE: f64 = 0.0025;
/// Way at full speed before the touch, in m.
const RUN_UP: f64 = 0.002;
const N_CHORDS: usize = 4096;

/// Where, from where, and how fast the tip pushes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlannedPush {
    /// 0-based edge of the outline that is pushed.
    pub edge: usize,
    /// Place along it, 0 to 1.
    pub p: f64,
    /// From the edge's inward normal to the tip's velocity, counter-clockwise positive, in rad.
    pub angle: f64,
    /// Speed, in m/s.
    pub speed: f64,
    /// Way after the touch, in m.
    pub travel: f64,
    /// Where the object is laid down: x, y in m, and turn in rad, world frame.
    pub place: [f64; 3],
    /// Number of the measuring session.
    pub session: usize,
    /// Name of the group of repeats that it belongs to; empty if it repeats nothing.
    pub repeat: String,
}

impl PlannedPush {
    /// Pose of the object as planned.
    #[must_use]
    pub fn pose(&self) -> Pose {
        Pose::new(self.place[0], self.place[1], self.place[2])
    }

    /// Refuses a push that cannot be done on a shape.
    ///
    /// # Errors
    /// `OutOfRange` with the first number that is not possible.
    pub fn check(&self, shape: &Shape) -> Result<(), PlantError> {
        let last_edge = shape.n_edges() as f64 - 1.0;
        let steepest = 0.49 * std::f64::consts::PI;
        let ranges = [
            ("edge", self.edge as f64, "", 0.0, last_edge),
            ("p", self.p, "", 0.0, 1.0),
            ("the push's angle", self.angle, "rad", -steepest, steepest),
            ("the push's speed", self.speed, "m/s", 0.001, 1.0),
            ("the push's travel", self.travel, "m", 1e-4, 1.0),
            ("x of the object", self.place[0], "m", -10.0, 10.0),
            ("y of the object", self.place[1], "m", -10.0, 10.0),
            ("turn of the object", self.place[2], "rad", -TAU, TAU),
        ];
        ranges.into_iter().try_for_each(|(name, value, unit, low, high)| {
            check_range(name, value, unit, (low, high))
        })
    }

    /// The path of a tip with a nominal radius (m) that makes this push.
    ///
    /// It reaches its speed before it touches, and goes on for `travel` along a straight line.
    ///
    /// - `acceleration`: in m/s²; - `wait`, `hold`: at rest before and after, in s.
    #[must_use]
    pub fn path(
        &self,
        shape: &Shape,
        radius: f64,
        acceleration: f64,
        [wait, hold]: [f64; 2],
    ) -> TipPath {
        let (point, inward) = contact_place(shape, self.edge, self.p);
        let direction_b = rotation(self.angle) * inward;
        let run_up = 0.5 * self.speed * self.speed / acceleration + RUN_UP;
        let approach = APPROACH.max(run_up).max(CLEARANCE / cos(self.angle));
        let start_b = point - radius * inward - approach * direction_b;
        let turn = rotation(self.place[2]);
        let start = Vector2::new(self.place[0], self.place[1]) + turn * start_b;
        let direction = turn * direction_b;
        TipPath {
            start: start.into(),
            direction: direction.into(),
            length: approach + self.travel,
            speed: self.speed,
            acceleration,
            wait,
            hold,
        }
    }
}

/// The outline's point at p along an edge, and the normal into the object there, frame B.
pub(crate) fn contact_place(shape: &Shape, edge: usize, p: f64) -> (Vector2<f64>, Vector2<f64>) {
    match shape {
        Shape::Polygon(_) => (shape.point_at(edge, p), shape.inward_normal_at(edge, p)),
        Shape::Ellipse(ellipse) => {
            let (a, b) = ellipse.semi_axes();
            let psi = parameter_at(ellipse, p);
            let point = Vector2::new(a * cos(psi), b * sin(psi));
            let outward = Vector2::new(point.x / (a * a), point.y / (b * b));
            (point, -outward / sqrt(outward.dot(&outward)))
        }
    }
}

/// Parameter of an ellipse at a share of its arc length, by chords: right to 1e-6.
fn parameter_at(ellipse: &Ellipse, share: f64) -> f64 {
    let (a, b) = ellipse.semi_axes();
    let angle = |k: usize| TAU * k as f64 / N_CHORDS as f64;
    let point = |k: usize| Vector2::new(a * cos(angle(k)), b * sin(angle(k)));
    let chord = |k: usize| {
        let way = point(k + 1) - point(k);
        sqrt(way.dot(&way))
    };
    let chords: Vec<_> = (0..N_CHORDS).map(chord).collect();
    let mut left = share * chords.iter().sum::<f64>();
    for (k, chord) in chords.iter().enumerate() {
        if left <= *chord {
            return angle(k) + left / chord * TAU / N_CHORDS as f64;
        }
        left -= chord;
    }
    TAU
}

#[cfg(test)]
mod tests {
    use super::{PlannedPush, contact_place};
    use nalgebra::Vector2;
    use planar::{Shape, mit_object};
    use std::f64::consts::FRAC_PI_2;

    const RADIUS: f64 = 0.00475;

    fn push() -> PlannedPush {
        PlannedPush {
            edge: 1,
            p: 0.5,
            angle: 0.0,
            speed: 0.02,
            travel: 0.05,
            place: [0.1, 0.0, FRAC_PI_2],
            session: 0,
            repeat: String::new(),
        }
    }

    #[test]
    fn the_tip_stops_where_the_travel_ends() {
        let square = Shape::square(0.09).unwrap();
        let path = push().path(&square, RADIUS, 10.0, [0.1, 0.2]);
        // Edge 1 is the left one, turned to the bottom.
        let touch = Vector2::new(0.1, -0.045 - RADIUS);
        assert!((path.position(0.0) - touch - Vector2::new(0.0, -0.004)).norm() < 1e-12);
        assert!((path.position(9.0) - touch - Vector2::new(0.0, 0.05)).norm() < 1e-12);
    }

    #[test]
    fn a_steep_tip_starts_clear_of_the_edge() {
        let square = Shape::square(0.09).unwrap();
        let steep = PlannedPush { angle: 1.4, ..push() }.path(&square, RADIUS, 10.0, [0.1, 0.2]);
        assert!((-0.045 - RADIUS - steep.start[1] - 0.0025).abs() < 1e-12);
    }

    #[test]
    fn a_fast_tip_starts_from_further_away() {
        let square = Shape::square(0.09).unwrap();
        let fast = PlannedPush { speed: 0.5, ..push() }.path(&square, RADIUS, 10.0, [0.1, 0.2]);
        assert!((fast.length - 0.05 - 0.0125 - 0.002).abs() < 1e-12);
    }

    #[test]
    fn places_on_an_ellipse_are_those_of_its_arc_length() {
        let shape = mit_object("ellip3").unwrap().shape;
        for p in [0.0, 0.1, 0.37, 0.5, 0.99] {
            let (point, inward) = contact_place(&shape, 0, p);
            assert!((point - shape.point_at(0, p)).norm() < 1e-7);
            assert!((inward - shape.inward_normal_at(0, p)).norm() < 1e-5);
        }
    }

    #[test]
    fn impossible_pushes_are_refused() {
        let square = Shape::square(0.09).unwrap();
        push().check(&square).unwrap();
        for (wrong, says) in [
            (PlannedPush { edge: 4, ..push() }, "edge = 4"),
            (PlannedPush { p: 1.2, ..push() }, "p = 1.2"),
            (PlannedPush { speed: 20.0, ..push() }, "speed = 20 m/s"),
            (PlannedPush { angle: 1.6, ..push() }, "angle = 1.6 rad"),
        ] {
            let message = wrong.check(&square).unwrap_err().to_string();
            assert!(message.contains(says), "{message}");
        }
    }
}
