//! Moments of recordings in which the object moves, as recorded.

use dataset::{PoseStream, Recording, WrenchStream};
use nalgebra::Vector2;

use super::numbers::quantile;

/// Pusher and object a little before, at, and a little after a time at which the object moves.
#[derive(Clone, Debug)]
pub(super) struct Moment {
    /// Times, in s as recorded.
    pub(super) t: [f64; 3],
    /// Pusher's center in W, in m as recorded.
    pub(super) pusher: [Vector2<f64>; 3],
    /// Position and yaw of B in W, in m and rad as recorded.
    pub(super) object: [(Vector2<f64>, f64); 3],
    /// Mean force of the pusher on the object, less that read before any motion, in N.
    pub(super) force: Option<Vector2<f64>>,
}

/// Moments taken of one recording at most.
const MOST_MOMENTS: usize = 30;
/// Fewest intervals that a recording is cut into.
const FEWEST_INTERVALS: usize = 10;
/// Samples of an interval at first.
const FIRST_STRIDE: usize = 5;
/// An interval belongs to a motion where its way is more than this share of the longest ones'.
const MOVING: f64 = 0.3;
/// Motion that counts, in standard deviations of the noise.
const FEWEST_SDS: f64 = 12.0;

/// Moments within the motions of a recording; none where nothing moves.
///
/// No length or time is presumed, for these may be in other units.
pub(super) fn moments(recording: &Recording) -> Vec<Moment> {
    let (robot, object) = (&recording.robot, &recording.object);
    let by_time = order(&object.t);
    let robot_by_time = order(&robot.t);
    let Some(marks) = marks(object, &by_time) else { return Vec::new() };
    let position = |i: usize| Vector2::new(object.x[i], object.y[i]);
    let ways: Vec<f64> =
        marks.windows(2).map(|pair| (position(pair[1]) - position(pair[0])).norm()).collect();
    let Some(longest) = quantile(ways.clone(), 0.95) else { return Vec::new() };
    let moving: Vec<bool> = ways.iter().map(|way| *way > MOVING * longest).collect();
    let inside: Vec<usize> = (1..moving.len()).filter(|k| moving[k - 1] && moving[*k]).collect();
    let onset = moving.iter().position(|moves| *moves).map(|k| object.t[marks[k]]);
    let zero = zero(recording.wrench.as_ref(), onset);
    let stride = inside.len().div_ceil(MOST_MOMENTS).max(1);
    let at = |k: &usize| {
        let samples = [marks[k - 1], marks[*k], marks[k + 1]];
        let t = samples.map(|i| object.t[i]);
        let [before, now, after] = t.map(|t| pusher_at(robot, &robot_by_time, t));
        let force = mean_force(recording.wrench.as_ref(), t[0], t[2]);
        Some(Moment {
            t,
            pusher: [before?, now?, after?],
            object: samples.map(|i| (position(i), object.theta[i])),
            // What is read is the force on the pusher.
            force: force.map(|force| zero - force),
        })
    };
    inside.iter().step_by(stride).filter_map(at).collect()
}

/// Samples of a stream in the order of their times.
fn order(t: &[f64]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..t.len()).collect();
    order.sort_by(|a, b| t[*a].total_cmp(&t[*b]));
    order
}

/// Samples so far apart that the object's motion between them stands out of the noise.
fn marks(object: &PoseStream, by_time: &[usize]) -> Option<Vec<usize>> {
    let noise = noise(object, by_time)?;
    let mut stride = FIRST_STRIDE;
    while by_time.len() >= FEWEST_INTERVALS * stride {
        let marks: Vec<usize> = by_time.iter().copied().step_by(stride).collect();
        let way = |pair: &[usize]| {
            (object.x[pair[1]] - object.x[pair[0]]).hypot(object.y[pair[1]] - object.y[pair[0]])
        };
        let longest = quantile(marks.windows(2).map(way).collect(), 0.95)?;
        if longest > FEWEST_SDS * noise && longest > 0.0 {
            return Some(marks);
        }
        stride *= 2;
    }
    None
}

/// Standard deviation of a position about its neighbours, in m as recorded.
fn noise(object: &PoseStream, by_time: &[usize]) -> Option<f64> {
    // Of a second difference of white noise, and of the median of a normal number's size.
    const PER_SD: f64 = 2.449_489_742_783_178 * 0.674_489_750_196_082;
    let second = |values: &[f64]| {
        let size = |three: &[usize]| {
            (values[three[0]] - 2.0 * values[three[1]] + values[three[2]]).abs() / PER_SD
        };
        quantile(by_time.windows(3).map(size).collect(), 0.5)
    };
    Some(second(&object.x)?.max(second(&object.y)?))
}

/// Pusher's center by a line between the neighbours of a time.
fn pusher_at(robot: &PoseStream, by_time: &[usize], t: f64) -> Option<Vector2<f64>> {
    let after = by_time.partition_point(|i| robot.t[*i] <= t);
    let (a, b) = (*by_time.get(after.checked_sub(1)?)?, *by_time.get(after)?);
    let share = (t - robot.t[a]) / (robot.t[b] - robot.t[a]);
    let position = |i: usize| Vector2::new(robot.x[i], robot.y[i]);
    Some(position(a).lerp(&position(b), share))
}

/// Median force on the pusher well before the object moves; zero where there is none.
fn zero(wrench: Option<&WrenchStream>, onset: Option<f64>) -> Vector2<f64> {
    let Some((wrench, onset)) = wrench.zip(onset) else { return Vector2::zeros() };
    let first = wrench.t.iter().copied().fold(f64::INFINITY, f64::min);
    let last = first + 0.8 * (onset - first);
    let of = |values: &[f64]| {
        let early = wrench.t.iter().zip(values).filter(|(t, _)| **t < last);
        quantile(early.map(|(_, value)| *value).collect(), 0.5).unwrap_or(0.0)
    };
    Vector2::new(of(&wrench.fx), of(&wrench.fy))
}

fn mean_force(wrench: Option<&WrenchStream>, from: f64, to: f64) -> Option<Vector2<f64>> {
    let wrench = wrench?;
    let inside = |i: &usize| (from..=to).contains(&wrench.t[*i]);
    let (mut sum, mut n) = (Vector2::zeros(), 0_u32);
    for i in (0..wrench.len()).filter(inside) {
        sum += Vector2::new(wrench.fx[i], wrench.fy[i]);
        n += 1;
    }
    (n > 0).then(|| sum / f64::from(n))
}
