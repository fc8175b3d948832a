//! A set of steps, and the same steps in other units, other axes and a mirror.

use std::sync::Arc;

use effects::{Effect, Frame, Object, Rig, Role, StepInput, Surface, Track};
use nalgebra::Vector2;
use planar::{Polygon, Pose, Shape, Twist, mit_object};

/// How a world differs from the plain one.
#[derive(Clone, Copy, Debug)]
pub(crate) struct World {
    /// Its meter, second and kilogram: plain numbers times these are its numbers.
    pub(crate) length: f64,
    pub(crate) time: f64,
    pub(crate) mass: f64,
    pub(crate) is_mirrored: bool,
    /// Angle of the plain x axis in its axes, in rad: of the table and of the body.
    pub(crate) turn: f64,
    pub(crate) body_turn: f64,
}

const RADIUS: f64 = 0.005;

impl World {
    pub(crate) const PLAIN: Self =
        Self { length: 1.0, time: 1.0, mass: 1.0, is_mirrored: false, turn: 0.0, body_turn: 0.0 };

    pub(crate) fn rig(&self, surface: Surface) -> Rig {
        let gravity = 9.81 * self.length / self.time.powi(2);
        let rig = Rig::new(surface, 0.25, 0.25).unwrap();
        rig.with_gravity(gravity).unwrap().with_longest_substep(1e-3 * self.length).unwrap()
    }

    /// Values of the plain world, as they are in this one.
    pub(crate) fn values(&self, effect: &dyn Effect, values: &[f64]) -> Vec<f64> {
        let about = effect.info();
        let scaled: Vec<f64> =
            about.parameters.iter().zip(values).map(|(p, v)| v * self.unit(p.unit)).collect();
        let sign = if self.is_mirrored { -1.0 } else { 1.0 };
        let turn = |frame: Frame| match frame {
            Frame::World => self.turn,
            Frame::Body => self.body_turn,
        };
        let mut mapped = scaled.clone();
        for (index, parameter) in about.parameters.iter().enumerate() {
            match parameter.role {
                Role::Odd => mapped[index] *= sign,
                Role::X(frame) => {
                    let vector = Vector2::new(scaled[index], sign * scaled[index + 1]);
                    let vector = Pose::new(0.0, 0.0, turn(frame)).rotate(&vector);
                    (mapped[index], mapped[index + 1]) = (vector.x, vector.y);
                }
                Role::Direction(frame) => mapped[index] = sign * scaled[index] + turn(frame),
                Role::Even
                | Role::Y(_)
                | Role::Ratio(_)
                | Role::Switch
                | Role::Share
                | Role::Part
                | Role::Cell
                | Role::Wave
                | Role::Reference
                | Role::Threshold => {}
            }
        }
        mapped
    }

    /// Channels of this world as they are in the plain one.
    pub(crate) fn channels_back(&self, channels: &[f64; 7]) -> [f64; 7] {
        let sign = if self.is_mirrored { -1.0 } else { 1.0 };
        let (m, n) = (self.length, self.unit("N"));
        let scales = [m, sign * m, sign, n, sign * n, m, m];
        std::array::from_fn(|i| channels[i] / scales[i])
    }

    pub(crate) fn steps(&self) -> Vec<StepInput> {
        let square = self.object(&[(45., 45.), (-45., 45.), (-45., -45.), (45., -45.)], (0., 0.));
        let corners = [(60., -30.), (45., 45.), (-20., 50.), (-55., -10.), (-20., -40.)];
        let crooked = self.object(&corners, (2., -3.));
        let mut steps = Vec::new();
        for index in 0..48 {
            let share = |prime: usize| (index * prime % 53) as f64 / 53.0;
            let object = if index % 3 == 0 { &crooked } else { &square };
            let beta = 1.5 * (share(7) - 0.5);
            let p =
                if index % 6 == 5 { 2e-3 * (1 + index / 3) as f64 } else { 0.1 + 0.8 * share(11) };
            let plain = Plain {
                edge: index % 4,
                p,
                beta,
                speed: [0.02, 0.1, 0.3][index % 3],
                pose_wb: Pose::new(0.4 * share(3) - 0.1, 0.3 * share(5), 6.0 * share(13)),
                kind: match index % 8 {
                    6 => Kind::First,
                    7 => Kind::After,
                    _ => Kind::Steady,
                },
                progress: share(17),
            };
            steps.push(self.step(object, &plain, index % 4 == 1));
        }
        steps.extend(self.steps_on_other_outlines());
        steps
    }

    /// Pushes of outlines that are not convex or very long, on edges that a pusher reaches.
    fn steps_on_other_outlines(&self) -> Vec<StepInput> {
        let l = [(-20., -30.), (60., -30.), (60., 0.), (10., 0.), (10., 60.), (-20., 60.)];
        let u = [
            (-52., -30.),
            (48., -30.),
            (48., 55.),
            (23., 55.),
            (23., 0.),
            (-22., 0.),
            (-22., 50.),
            (-52., 50.),
        ];
        let Shape::Polygon(butter) = mit_object("butter").unwrap().shape else {
            panic!("a polygon")
        };
        let butter: Vec<_> = butter.vertices().iter().map(|v| (1e3 * v.x, 1e3 * v.y)).collect();
        let long = [(75., 7.5), (-75., 7.5), (-75., -7.5), (75., -7.5)];
        let objects = [
            (self.object(&l, (1., -2.)), vec![0, 1, 2, 4, 5]),
            (self.object(&u, (0., 3.)), vec![0, 1, 4, 7]),
            (self.object(&butter, (0., 0.)), (0..butter.len()).collect()),
            (self.object(&long, (5., 0.)), vec![0, 1, 2, 3]),
        ];
        let mut steps = Vec::new();
        for index in 0..20 {
            let share = |prime: usize| (index * prime % 23) as f64 / 23.0;
            let (object, edges) = &objects[index % 4];
            let plain = Plain {
                edge: edges[index / 4 % edges.len()],
                p: 0.3 + 0.5 * share(7),
                beta: 1.2 * (share(11) - 0.5),
                speed: [0.02, 0.1, 0.3][index % 3],
                pose_wb: Pose::new(0.4 * share(3) - 0.1, 0.3 * share(5), 6.0 * share(13)),
                kind: Kind::Steady,
                progress: share(17),
            };
            steps.push(self.step(object, &plain, false));
        }
        steps
    }

    fn unit(&self, unit: &str) -> f64 {
        let (m, s) = (self.length, self.time);
        let newton = self.mass * m / (s * s);
        match unit {
            "1" | "rad" => 1.0,
            "m" => m,
            "1/m" => 1.0 / m,
            "s" => s,
            "m/s" => m / s,
            "m/s²" => m / (s * s),
            "N" => newton,
            "m/N" => m / newton,
            _ => panic!("{unit} is not a unit of the catalogue"),
        }
    }

    fn point(&self, x: f64, y: f64, turn: f64) -> Vector2<f64> {
        let y = if self.is_mirrored { -y } else { y };
        Pose::new(0.0, 0.0, turn).rotate(&(self.length * Vector2::new(x, y)))
    }

    /// An outline by its corners in mm, frame of the plain body; and its center of mass.
    fn object(&self, corners: &[(f64, f64)], center: (f64, f64)) -> Arc<Object> {
        let body = |x: f64, y: f64| self.point(1e-3 * x, 1e-3 * y, self.body_turn);
        let mut vertices: Vec<_> = corners.iter().map(|c| body(c.0, c.1)).collect();
        if self.is_mirrored {
            vertices.reverse();
        }
        let shape = Arc::new(Shape::Polygon(Polygon::new(vertices).unwrap()));
        let (mass, moment) = (0.8 * self.mass, 1.1e-3 * self.mass * self.length.powi(2));
        Arc::new(Object::new(shape, mass, moment, body(center.0, center.1)).unwrap())
    }

    fn step(&self, object: &Arc<Object>, plain: &Plain, is_accelerated: bool) -> StepInput {
        let sign = if self.is_mirrored { -1.0 } else { 1.0 };
        // Edges of the mirrored outline run the other way round.
        let n = object.shape().n_edges();
        let (edge, p) = match self.is_mirrored {
            true => ((2 * n - 2 - plain.edge) % n, 1.0 - plain.p),
            false => (plain.edge, plain.p),
        };
        let position = self.point(plain.pose_wb.position.x, plain.pose_wb.position.y, self.turn);
        let angle = sign * plain.pose_wb.angle + self.turn - self.body_turn;
        let pose_wb = Pose { position, angle };
        let (normal, radius) = (object.shape().inward_normal_at(edge, p), RADIUS * self.length);
        let speed = plain.speed * self.length / self.time;
        let direction = pose_wb.rotate(&Pose::new(0.0, 0.0, sign * plain.beta).rotate(&normal));
        let gap = match plain.kind {
            Kind::After => 0.0,
            Kind::First | Kind::Steady => 1e-4 * self.length,
        };
        let start_b = object.shape().point_at(edge, p) - (radius + gap) * normal;
        let start = pose_wb.transform_point(&start_b);
        let duration = 4e-3 * self.length / speed;
        let turning = sign * 3.0 * plain.speed / self.time;
        let (touching, since_contact, way) = match plain.kind {
            Kind::Steady => (true, 1.0, speed * duration),
            Kind::First => (true, 0.0, speed * duration),
            Kind::After => (false, 1.0, 0.0),
        };
        let acceleration = match is_accelerated && plain.kind != Kind::After {
            true => 0.3 * speed / duration * direction,
            false => Vector2::zeros(),
        };
        StepInput {
            object: object.clone(),
            pusher_radius: radius,
            pose_wb,
            twist_wb: Twist { linear: 0.9 * speed * direction, angular: turning },
            track: Track::accelerated(start, start + way * direction, acceleration, duration),
            touching,
            since_contact: since_contact * self.time,
            run_up: None,
            progress: plain.progress,
            session: 0,
        }
    }
}

/// A step in the plain world.
struct Plain {
    edge: usize,
    p: f64,
    beta: f64,
    speed: f64,
    pose_wb: Pose,
    kind: Kind,
    progress: f64,
}

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    First,
    Steady,
    After,
}
