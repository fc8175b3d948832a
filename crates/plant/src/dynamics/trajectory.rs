//! What happened in a push, as it really was.

use nalgebra::{Vector2, Vector3};
use planar::Pose;

use crate::TipPath;
use crate::dynamics::energy::Energy;
use crate::dynamics::state::{State, rotation};

/// The true motion and force of one push.
#[derive(Clone, Debug, PartialEq)]
pub struct Trajectory {
    path: TipPath,
    start: Pose,
    center_of_mass: Vector2<f64>,
    knots: Vec<Knot>,
    /// How far the object has moved, in m, and the integral over that of the table's friction over an even one's.
    way: f64,
    rubbed: f64,
}

/// The end of a time step.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Knot {
    time: f64,
    state: State,
}

impl Trajectory {
    /// A push that begins with a state.
    ///
    /// - `center_of_mass`: in m, in the body's frame.
    pub(crate) fn new(
        path: &TipPath,
        start: Pose,
        center_of_mass: Vector2<f64>,
        state: &State,
    ) -> Self {
        let knots = vec![Knot { time: 0.0, state: *state }];
        Self { path: *path, start, center_of_mass, knots, way: 0.0, rubbed: 0.0 }
    }

    pub(crate) fn record(&mut self, time: f64, state: &State) {
        self.knots.push(Knot { time, state: *state });
    }

    /// Adds a way (m) on which the table's friction was so much of an even one's.
    pub(crate) fn record_friction(&mut self, way: f64, ratio: f64) {
        self.way += way;
        self.rubbed += way * ratio;
    }

    /// Friction that the table's texture made under the object over that on an even table, mean over the object's
    /// way; 1 where it is even.
    #[must_use]
    pub fn table_friction(&self) -> f64 {
        if self.way > 0.0 { self.rubbed / self.way } else { 1.0 }
    }

    /// How long the push takes, in s.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.last().time
    }

    /// Number of time steps that it took to simulate.
    #[must_use]
    pub fn n_steps(&self) -> usize {
        self.knots.len() - 1
    }

    /// Times at the ends of the time steps, in s.
    pub fn times(&self) -> impl Iterator<Item = f64> + '_ {
        self.knots.iter().map(|knot| knot.time)
    }

    /// Pose of the nominal body frame at the end.
    #[must_use]
    pub fn end_pose(&self) -> Pose {
        self.pose_at(self.duration())
    }

    /// Pose of the nominal body frame at a time (s), held before the start and after the end.
    #[must_use]
    pub fn pose_at(&self, time: f64) -> Pose {
        if time <= 0.0 {
            return self.start;
        }
        let (from, to) = self.around(time);
        let place = place_between(from, to, time);
        let origin = place.xy() - rotation(place.z) * self.center_of_mass;
        Pose::new(origin.x, origin.y, place.z)
    }

    /// Speed of the center of mass (m/s) and rate of turn (rad/s) at the time step before a time.
    #[must_use]
    pub fn motion_at(&self, time: f64) -> (Vector2<f64>, f64) {
        let motion = self.around(time).0.state.motion;
        (motion.xy(), motion.z)
    }

    /// Where the robot says that the tip's center is at a time (s), in m, world frame.
    #[must_use]
    pub fn tip_at(&self, time: f64) -> Vector2<f64> {
        self.path.position(time)
    }

    /// How far the tip is from where the robot holds it at the time step before a time (s), in m,
    /// world frame.
    #[must_use]
    pub fn deflection_at(&self, time: f64) -> Vector2<f64> {
        self.around(time).0.state.deflection
    }

    /// Force of the tip on the object at the time step before a time (s), in N, world frame.
    #[must_use]
    pub fn force_at(&self, time: f64) -> Vector2<f64> {
        self.around(time).0.state.force
    }

    /// Mean force of the tip on the object between two times (s), in N, world frame.
    #[must_use]
    pub fn mean_force(&self, from: f64, to: f64) -> Vector2<f64> {
        (self.impulse_at(to) - self.impulse_at(from)) / (to - from)
    }

    /// Mean torque of the object on the tip about the tip's axis between two times (s), in N·m.
    #[must_use]
    pub fn mean_torque(&self, from: f64, to: f64) -> f64 {
        let twisting = |time: f64| {
            let (before, after, share) = self.between(time);
            before.twisting + share * (after.twisting - before.twisting)
        };
        (twisting(to) - twisting(from)) / (to - from)
    }

    /// Whether the tip pushes at the time step before a time (s).
    #[must_use]
    pub fn touches_at(&self, time: f64) -> bool {
        self.force_at(time) != Vector2::zeros()
    }

    /// When the tip first pushes, in s, to a time step; none if it never does.
    #[must_use]
    pub fn first_touch(&self) -> Option<f64> {
        let touching = self.knots.iter().find(|knot| knot.state.force != Vector2::zeros());
        touching.map(|knot| knot.time)
    }

    /// Where the work of the robot went by the end.
    #[must_use]
    pub fn energy(&self) -> &Energy {
        &self.last().state.energy
    }

    fn impulse_at(&self, time: f64) -> Vector2<f64> {
        let (before, after, share) = self.between(time);
        before.impulse + share * (after.impulse - before.impulse)
    }

    /// The states before and after a time, and how far it is from one to the other, 0 to 1.
    fn between(&self, time: f64) -> (&State, &State, f64) {
        let (from, to) = self.around(time);
        (&from.state, &to.state, share_between(from, to, time))
    }

    fn last(&self) -> &Knot {
        self.knots.last().expect("a trajectory has its start")
    }

    /// The time steps before and after a time.
    fn around(&self, time: f64) -> (&Knot, &Knot) {
        let after = self.knots.partition_point(|knot| knot.time <= time);
        let last = self.knots.len() - 1;
        (&self.knots[after.saturating_sub(1)], &self.knots[after.min(last)])
    }
}

/// How far a time is on the way from one knot to the next, 0 to 1.
fn share_between(from: &Knot, to: &Knot, time: f64) -> f64 {
    let length = to.time - from.time;
    if length > 0.0 { ((time - from.time) / length).clamp(0.0, 1.0) } else { 0.0 }
}

/// The cubic that has the places and motions of both knots.
fn place_between(from: &Knot, to: &Knot, time: f64) -> Vector3<f64> {
    let u = share_between(from, to, time);
    let step = to.time - from.time;
    let (a, b) = (&from.state, &to.state);
    let w = 1.0 - u;
    w * w * (1.0 + 2.0 * u) * a.place
        + u * u * (1.0 + 2.0 * w) * b.place
        + step * u * w * (w * a.motion - u * b.motion)
}
