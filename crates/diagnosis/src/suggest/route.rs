//! Pushes that a rig can do, and how they are expected to go.

use std::sync::Arc;

use effects::{Object, PushPhysics, StepInput, Track};
use models::ChannelModel;
use nalgebra::{Rotation2, Vector2};
use planar::{Feature, Pose, Shape, Twist};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use std::f64::consts::TAU;

use super::area::{FEWEST_STEPS, Reach, SHORTEST_WAY};
use super::standpoint::Standpoint;
use super::{SuggestSettings, SuggestedPush, halton};
use crate::data::steady_ingest::{FIRST_TIME, FIRST_WAY, STEP_TIME, STEP_WAY};
use crate::predict::rollout::moved_by;
use crate::{DiagnosisError, Observations};

/// A push with its expected steps.
#[derive(Clone, Debug)]
pub(super) struct Route {
    pub(super) push: SuggestedPush,
    /// Those that a diagnosis would use.
    pub(super) steps: Vec<RouteStep>,
}

/// A step that is expected.
#[derive(Clone, Debug)]
pub(super) struct RouteStep {
    pub(super) input: StepInput,
    /// p and β (rad) at its start.
    pub(super) place: [f64; 2],
    pub(super) predicted: [f64; 7],
}

/// Distance from vertices that a push begins with and keeps, in m: 1.5 mm are lost to a diagnosis
/// anyway, and the model is not exact.
const FROM_VERTEX: [f64; 2] = [6e-3, 3e-3];
/// Way on which the pusher comes to the touch, and what is added for it to get fast, in m and m/s².
const APPROACH: f64 = 0.01;
const ACCELERATION: f64 = 1.0;
/// Feasible pushes without which there is no choice.
const FEWEST_ROUTES: usize = 8;
/// What an expected path may stand out of the area by, in m.
const OVERSTEP: f64 = 2e-3;
/// A larger expected gap is a lost contact, in m.
const LOST: f64 = 5e-4;
/// Of what is written down: 0.1 mm and 0.1°.
const GRID: f64 = 1e-4;
const GRID_ANGLE: f64 = std::f64::consts::PI / 1800.0;

/// Candidates that can be done, evenly over places, angles, orientations and speeds.
pub(super) fn candidates(
    observations: &Observations,
    standpoint: &Standpoint,
    reach: &Reach,
    settings: &SuggestSettings,
) -> Result<Vec<Route>, DiagnosisError> {
    let object = observations.steps[0].input.object.clone();
    let model = ChannelModel::new(&standpoint.description, observations.support, &settings.own)?;
    let physics = model.physics(&object)?;
    let rig = Rig { object: &object, physics, reach, steepest: settings.steepest };
    let mut rng = ChaCha8Rng::seed_from_u64(settings.seed);
    let shift = std::array::from_fn(|_| rng.random::<f64>());
    let route = |index: usize| rig.route(halton::point(index as u32, &shift));
    let routes: Vec<Option<Route>> =
        (0..settings.n_candidates).into_par_iter().map(route).collect();
    let routes: Vec<Route> = routes.into_iter().flatten().collect();
    if routes.len() < FEWEST_ROUTES {
        return Err(DiagnosisError::NoFeasiblePush {
            n_candidates: settings.n_candidates,
            n_feasible: routes.len(),
            travel: reach.travel,
            shortest: SHORTEST_WAY,
            area: reach.area.map(|[low, high]| high - low),
        });
    }
    Ok(routes)
}

struct Rig<'a> {
    object: &'a Arc<Object>,
    physics: PushPhysics,
    reach: &'a Reach,
    steepest: f64,
}

/// Steps as they would be recorded, the poses passed, and how far the contact stays good, in m.
struct Course {
    steps: Vec<RouteStep>,
    positions_w: Vec<Vector2<f64>>,
    good_way: f64,
}

impl Rig<'_> {
    /// The push at a point of the unit cube; none where it cannot be done.
    fn route(&self, [along, angle, yaw, speed, x, y]: [f64; 6]) -> Option<Route> {
        let shape = self.object.shape();
        let (edge, p) = place(shape, along);
        let to_grid = |value: f64, grid: f64| (value / grid).round() * grid;
        let speeds = &self.reach.speeds;
        let push = SuggestedPush {
            edge,
            p: to_grid(p, 1e-3),
            angle: to_grid((2.0 * angle - 1.0) * self.steepest, GRID_ANGLE),
            speed: speeds[((speed * speeds.len() as f64) as usize).min(speeds.len() - 1)],
            travel: self.reach.travel,
            pose_wb: Pose::new(0.0, 0.0, to_grid((yaw - 0.5) * TAU, GRID_ANGLE)),
            path_w: [Vector2::zeros(); 3],
            repeat: String::new(),
        };
        if from_vertex(shape, edge, push.p) < FROM_VERTEX[0] || !self.is_free(&push) {
            return None;
        }
        let center = self.reach.area.map(|[low, high]| 0.5 * (low + high));
        let there = self.course(&laid_at(&push, center))?;
        let mut place = center;
        for (axis, share) in [x, y].into_iter().enumerate() {
            let [low, high] = self.reach.area[axis];
            let offsets = there.positions_w.iter().map(|position| position[axis] - center[axis]);
            let (least, most) =
                offsets.fold((0.0, 0.0), |(a, b): (f64, f64), x| (a.min(x), b.max(x)));
            let room = high - low - (most - least);
            if room < -OVERSTEP {
                return None;
            }
            place[axis] = to_grid(low - least + share * room.max(0.0), GRID);
        }
        let push = laid_at(&push, place);
        let course = self.course(&push)?;
        let is_inside = course.positions_w.iter().all(|position| {
            (0..2).all(|axis| {
                let [low, high] = self.reach.area[axis];
                (low - OVERSTEP..=high + OVERSTEP).contains(&position[axis])
            })
        });
        if !is_inside || course.steps.len() < FEWEST_STEPS {
            return None;
        }
        let travel = push.travel.min((1e3 * course.good_way).floor() / 1e3);
        let path_w = self.path(&push, travel);
        let push = SuggestedPush { travel, path_w, ..push };
        let steps = if self.reach.is_of_ends { vec![self.whole(&push)?] } else { course.steps };
        Some(Route { push, steps })
    }

    /// The push in one step, for sets that know no more of it than its ends.
    fn whole(&self, push: &SuggestedPush) -> Option<RouteStep> {
        let [start, _, end] = push.path_w;
        let input = StepInput {
            object: self.object.clone(),
            pusher_radius: self.reach.pusher_radius,
            pose_wb: push.pose_wb,
            twist_wb: Twist::default(),
            track: Track::straight(start, end, (end - start).norm() / push.speed),
            touching: false,
            since_contact: 0.0,
            run_up: None,
            progress: 0.5,
            session: 0,
        };
        let predicted = self.physics.predict(&input).ok()?.to_array();
        Some(RouteStep { input, place: [push.p, push.angle], predicted })
    }

    /// The push as the model expects it, step by step; none where it cannot be predicted.
    fn course(&self, push: &SuggestedPush) -> Option<Course> {
        let shape = self.object.shape();
        let [touch_w, direction_w] = self.touch(push);
        let step_way = STEP_WAY.max(STEP_TIME * push.speed);
        let (mut pose_wb, mut twist_wb) = (push.pose_wb, Twist::default());
        let first_way = FIRST_WAY.max(FIRST_TIME * push.speed);
        let (mut way, mut length) = (0.0, first_way);
        let mut course =
            Course { steps: vec![], positions_w: vec![pose_wb.position], good_way: 0.0 };
        while way + length <= push.travel + 1e-9 {
            let (start, end) =
                (touch_w + way * direction_w, touch_w + (way + length) * direction_w);
            let duration = length / push.speed;
            let contact =
                shape.contact(&pose_wb.inverse_transform_point(&start), self.reach.pusher_radius);
            let beta = pose_wb.inverse_rotate(&direction_w);
            let beta = planar::cross(&contact.normal, &beta).atan2(contact.normal.dot(&beta));
            let step = StepInput {
                object: self.object.clone(),
                pusher_radius: self.reach.pusher_radius,
                pose_wb,
                twist_wb,
                track: Track::straight(start, end, duration),
                touching: true,
                since_contact: way / push.speed,
                run_up: None,
                progress: 0.5,
                session: 0,
            };
            let moved = self.physics.predict(&step).ok()?;
            let end_wb = moved_by(&pose_wb, &direction_w, [moved.dx, moved.dy, moved.dtheta]);
            let after =
                shape.contact(&end_wb.inverse_transform_point(&end), self.reach.pusher_radius);
            let is_good = after.feature == Feature::Edge
                && after.edge == push.edge
                && after.gap.abs() < LOST
                && from_vertex(shape, after.edge, after.p) > FROM_VERTEX[1];
            if !is_good {
                break;
            }
            if way >= first_way {
                let (place, predicted) = ([contact.p, beta], moved.to_array());
                course.steps.push(RouteStep { input: step, place, predicted });
            }
            let linear = (end_wb.position - pose_wb.position) / duration;
            twist_wb = Twist { linear, angular: (end_wb.angle - pose_wb.angle) / duration };
            pose_wb = end_wb;
            course.positions_w.push(pose_wb.position);
            (way, length) = (way + length, step_way);
            course.good_way = way;
        }
        let is_whole = way + length > push.travel + 1e-9;
        if is_whole {
            course.good_way = push.travel;
        }
        Some(course)
    }

    /// The pusher's center where it touches, and the direction in which it goes, frame W.
    fn touch(&self, push: &SuggestedPush) -> [Vector2<f64>; 2] {
        let shape = self.object.shape();
        let normal = shape.inward_normal_at(push.edge, push.p);
        let touch_b = shape.point_at(push.edge, push.p) - self.reach.pusher_radius * normal;
        let direction_b = Rotation2::new(push.angle) * normal;
        [push.pose_wb.transform_point(&touch_b), push.pose_wb.rotate(&direction_b)]
    }

    fn path(&self, push: &SuggestedPush, travel: f64) -> [Vector2<f64>; 3] {
        let [touch_w, direction_w] = self.touch(push);
        [touch_w - approach(push.speed) * direction_w, touch_w, touch_w + travel * direction_w]
    }

    /// Whether the pusher meets nothing on its way to the touch.
    fn is_free(&self, push: &SuggestedPush) -> bool {
        const N_PLACES: u32 = 8;
        let shape = self.object.shape();
        let [start_w, touch_w, _] = self.path(push, 0.0);
        (1..=N_PLACES).all(|k| {
            let share = f64::from(k) / f64::from(N_PLACES);
            let center_b = push.pose_wb.inverse_transform_point(&touch_w.lerp(&start_w, share));
            let gap = shape.contact(&center_b, self.reach.pusher_radius).gap;
            !shape.contains(&center_b) && gap > 0.5 * share * APPROACH * push.angle.cos()
        })
    }
}

fn approach(speed: f64) -> f64 {
    APPROACH + 0.5 * speed * speed / ACCELERATION
}

fn laid_at(push: &SuggestedPush, [x, y]: [f64; 2]) -> SuggestedPush {
    SuggestedPush { pose_wb: Pose::new(x, y, push.pose_wb.angle), ..push.clone() }
}

/// The edge and the place on it at a share of the outline's length.
fn place(shape: &Shape, share: f64) -> (usize, f64) {
    let Shape::Polygon(polygon) = shape else { return (0, share) };
    let mut left = share * polygon.perimeter();
    for (edge, (from, to)) in polygon.edges().enumerate() {
        let length = (to - from).norm();
        if left < length {
            return (edge, left / length);
        }
        left -= length;
    }
    (0, 0.0)
}

/// Distance of a place on an edge from the edge's nearer end, in m; infinite on an ellipse.
fn from_vertex(shape: &Shape, edge: usize, p: f64) -> f64 {
    match shape {
        Shape::Polygon(polygon) => {
            let length = polygon.edges().nth(edge).map_or(0.0, |(from, to)| (to - from).norm());
            p.min(1.0 - p) * length
        }
        Shape::Ellipse(_) => f64::INFINITY,
    }
}
