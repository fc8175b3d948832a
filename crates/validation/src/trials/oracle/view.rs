//! What the oracle looks at in a push: poses at fixed ways of the tip, and mean forces between.

use dataset::{PoseStream, WrenchStream};
use nalgebra::{DVector, Matrix3, Vector2, Vector3};
use planar::{Pose, Shape, cross, mit_object, perpendicular};
use plant::{GenerateSettings, PushedObject, SimulatedPush};

/// Way of the tip after the touch at which the first pose is read, and between poses, in m.
const FIRST: f64 = 2e-3;
const STEP: f64 = 5e-3;
/// Distance from a vertex within which nothing is read, in m.
const VERTEX: f64 = 1.5e-3;
/// Variance of the middle of a parabola fitted to n even samples, times n.
const PARABOLA: f64 = 2.25;

/// Where one push is looked at.
pub(super) struct View {
    times: Vec<f64>,
    /// Half the time of a step, in s.
    half: f64,
    /// Direction of the tip.
    direction: Vector2<f64>,
    /// Inward normals, and contact points from the body's origin, axes of W.
    normals: Vec<Vector2<f64>>,
    arms: Vec<Vector2<f64>>,
    has_force: bool,
}

/// A number of a step, as a combination of what is read, of the kind `number` of the seven that
/// are observed of a step.
pub(super) struct StepNumber {
    pub(super) number: usize,
    pub(super) weights: DVector<f64>,
}

impl View {
    /// The view of a push without noise, as far as the tip stays on one edge.
    pub(super) fn of(push: &SimulatedPush, rig: &GenerateSettings) -> Self {
        let SimulatedPush { plan, trajectory, recording, .. } = push;
        let radius = rig.nominal.pusher_radius;
        let shape = outline(&rig.object);
        let half = 0.5 * STEP / plan.speed;
        let touch = trajectory.first_touch().unwrap_or(f64::INFINITY);
        let stop =
            trajectory.duration() - rig.design.rests[1] - plan.speed / rig.design.acceleration;
        let mut view = Self {
            times: Vec::new(),
            half,
            direction: Vector2::x(),
            normals: Vec::new(),
            arms: Vec::new(),
            has_force: recording.wrench.is_some(),
        };
        let contact_at = |time: f64| {
            let tip = trajectory.pose_at(time).inverse_transform_point(&trajectory.tip_at(time));
            shape.contact(&tip, radius)
        };
        let mut time = touch + FIRST / plan.speed;
        while time + half < stop && trajectory.touches_at(time + half) {
            // What is read at a time is smoothed over half a step to either side.
            let ends = [time - half, time, time + half].map(|time| contact_at(time.max(touch)));
            if ends.iter().any(|contact| is_near_vertex(&shape, &contact.point)) {
                break;
            }
            let (pose, contact) = (trajectory.pose_at(time), &ends[1]);
            view.times.push(time);
            view.normals.push(pose.rotate(&contact.normal));
            view.arms.push(pose.rotate(&contact.point));
            time += 2.0 * half;
        }
        if view.times.len() < 2 {
            view.times.clear();
        } else {
            let last = view.times[view.times.len() - 1];
            let way = trajectory.tip_at(last) - trajectory.tip_at(view.times[0]);
            view.direction = way.normalize();
        }
        view
    }

    pub(super) fn is_empty(&self) -> bool {
        self.times.is_empty()
    }

    fn n_steps(&self) -> usize {
        self.times.len().saturating_sub(1)
    }

    fn n_numbers(&self) -> usize {
        if self.is_empty() {
            return 0;
        }
        3 * self.times.len() + if self.has_force { 2 * self.n_steps() } else { 0 }
    }

    /// All that is read of a push: x, y (m) and yaw (rad) at each time, then the mean reading of
    /// the force (N) of each step, axes of W.
    pub(super) fn numbers(&self, push: &SimulatedPush) -> DVector<f64> {
        let mut numbers = Vec::with_capacity(self.n_numbers());
        let object = &push.recording.object;
        for time in &self.times {
            numbers.extend(smoothed(object, *time, self.half).iter());
        }
        for wrench in push.recording.wrench.iter().filter(|_| !self.is_empty()) {
            for pair in self.times.windows(2) {
                numbers.extend(mean_force(wrench, [pair[0], pair[1]]).iter());
            }
        }
        DVector::from_vec(numbers)
    }

    /// The change from one push to another, over a share; zero where the other loses contact.
    pub(super) fn difference(
        &self,
        off: &SimulatedPush,
        on: &SimulatedPush,
        share: f64,
    ) -> DVector<f64> {
        let loses = |time: &f64| !on.trajectory.touches_at(time + self.half);
        if self.times.iter().any(loses) {
            return DVector::zeros(self.n_numbers());
        }
        (self.numbers(on) - self.numbers(off)) / share
    }

    /// Variance of each number by the sensors alone.
    pub(super) fn sensor_variances(&self, noisy: &GenerateSettings) -> DVector<f64> {
        let sensors = &noisy.sensors;
        let time = 2.0 * self.half;
        let speed = STEP / time;
        let smooth = |sd: f64, rate: f64| PARABOLA * sd * sd / (rate * time);
        let jitter = |sensor: &plant::Sensor| speed * sensor.jitter_sd;
        // What the tip's measured place is wrong by shows like an error of the object's.
        let position =
            smooth(sensors.object.noise_sd.hypot(jitter(&sensors.object)), sensors.object.rate)
                + smooth(sensors.robot.noise_sd.hypot(jitter(&sensors.robot)), sensors.robot.rate);
        let yaw = smooth(sensors.object.yaw_noise_sd, sensors.object.rate);
        let force = sensors.force.noise_sd.powi(2) / (sensors.force.rate * time).max(1.0);
        let n_poses = 3 * self.times.len();
        DVector::from_fn(self.n_numbers(), |row, _| match (row < n_poses, row % 3) {
            (true, 2) => yaw,
            (true, _) => position,
            (false, _) => force,
        })
    }

    /// Displacement, turn, force and gap of each step, to first order.
    pub(super) fn step_numbers(&self) -> Vec<StepNumber> {
        let zero = || DVector::zeros(self.n_numbers());
        let mut numbers = Vec::new();
        let left = perpendicular(&self.direction);
        for step in 0..self.n_steps() {
            for (number, axis) in [(0, self.direction), (1, left)] {
                let mut weights = zero();
                for (end, sign) in [(step, -1.0), (step + 1, 1.0)] {
                    weights[3 * end] = sign * axis.x;
                    weights[3 * end + 1] = sign * axis.y;
                }
                numbers.push(StepNumber { number, weights });
            }
            let mut weights = zero();
            (weights[3 * step + 2], weights[3 * step + 5]) = (-1.0, 1.0);
            numbers.push(StepNumber { number: 2, weights });
            if self.has_force {
                let at = 3 * self.times.len() + 2 * step;
                let normal = self.normals[step];
                for (number, axis) in [(3, normal), (4, perpendicular(&normal))] {
                    let mut weights = zero();
                    (weights[at], weights[at + 1]) = (axis.x, axis.y);
                    numbers.push(StepNumber { number, weights });
                }
            }
        }
        for (k, (normal, arm)) in
            self.normals.iter().zip(&self.arms).enumerate().take(self.times.len())
        {
            // The outline comes nearer where its point moves against the inward normal.
            let mut weights = zero();
            (weights[3 * k], weights[3 * k + 1]) = (normal.x, normal.y);
            weights[3 * k + 2] = cross(arm, normal);
            numbers.push(StepNumber { number: 5, weights });
        }
        if self.is_empty() { Vec::new() } else { numbers }
    }
}

fn outline(object: &PushedObject) -> Shape {
    match object {
        PushedObject::Mit { name } => mit_object(name).map(|object| object.shape),
        _ => mit_object("rect1").map(|object| object.shape),
    }
    .expect("trials push an object of the catalogue")
}

fn is_near_vertex(shape: &Shape, point_b: &Vector2<f64>) -> bool {
    let Shape::Polygon(polygon) = shape else { return false };
    polygon.edges().any(|(from, _)| (from - point_b).norm() < VERTEX)
}

/// The middle of parabolas through the samples about a time.
fn smoothed(stream: &PoseStream, time: f64, half: f64) -> Vector3<f64> {
    let (mut gram, mut moments) = (Matrix3::zeros(), Matrix3::zeros());
    for (k, stamp) in stream.t.iter().enumerate() {
        let u = (stamp - time) / half;
        if u.abs() <= 1.0 {
            let powers = Vector3::new(1.0, u, u * u);
            gram += powers * powers.transpose();
            let pose = Pose::new(stream.x[k], stream.y[k], stream.theta[k]);
            moments += powers
                * Vector3::new(pose.position.x, pose.position.y, stream.theta[k]).transpose();
        }
    }
    let inverse = gram.try_inverse().unwrap_or_else(Matrix3::zeros);
    (inverse * moments).row(0).transpose()
}

fn mean_force(wrench: &WrenchStream, [from, to]: [f64; 2]) -> Vector2<f64> {
    let (mut sum, mut n) = (Vector2::zeros(), 0.0);
    for (k, stamp) in wrench.t.iter().enumerate() {
        if (from..to).contains(stamp) {
            sum += Vector2::new(wrench.fx[k], wrench.fy[k]);
            n += 1.0;
        }
    }
    if n > 0.0 { sum / n } else { sum }
}
