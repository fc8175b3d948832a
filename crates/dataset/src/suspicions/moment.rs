//! Moments of recordings in which the object moves, as recorded.

use crate::{PoseStream, WrenchStream};
use nalgebra::Vector2;
use planar::Pose;

use super::track::Track;
use crate::curves::sample::quantile;

/// Pusher and object a little before, at, and a little after a time at which the object moves.
#[derive(Clone, Debug)]
pub(super) struct Moment {
    /// Times, in s as recorded.
    pub(super) t: [f64; 3],
    /// Pusher's center in W, in m as recorded.
    pub(super) pusher: [Vector2<f64>; 3],
    /// Position and yaw of B in W, in m and rad as recorded.
    pub(super) object: Poses,
    /// Mean force of the pusher on the object, less that read before any motion, in N.
    pub(super) force: Option<Vector2<f64>>,
}

/// Positions and yaws of B in W at three times, in m and rad as recorded.
type Poses = [(Vector2<f64>, f64); 3];

/// When and how an object moves, whatever the other streams have.
#[derive(Clone, Debug)]
pub(super) struct Motion {
    /// Times, in s as recorded, and poses then.
    moments: Vec<([f64; 3], Poses)>,
    /// When it moves, in s as recorded, in order.
    pub(super) moving: Vec<[f64; 2]>,
    /// First and last sample, in s as recorded.
    pub(super) span: [f64; 2],
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

impl Motion {
    /// The motions of a stream of poses; none where nothing moves.
    ///
    /// No length or time is presumed, for these may be in other units.
    pub(super) fn of(object: &PoseStream) -> Option<Self> {
        let by_time = order(&object.t);
        let marks = marks(object, &by_time)?;
        let position = |i: usize| Vector2::new(object.x[i], object.y[i]);
        let ways: Vec<f64> =
            marks.windows(2).map(|pair| (position(pair[1]) - position(pair[0])).norm()).collect();
        let longest = quantile(ways.clone(), 0.95)?;
        let is_moving: Vec<bool> = ways.iter().map(|way| *way > MOVING * longest).collect();
        let inside: Vec<usize> =
            (1..is_moving.len()).filter(|k| is_moving[k - 1] && is_moving[*k]).collect();
        let mut moving: Vec<[f64; 2]> = Vec::new();
        for (k, _) in is_moving.iter().enumerate().filter(|(_, moves)| **moves) {
            let [from, to] = [marks[k], marks[k + 1]].map(|i| object.t[i]);
            match moving.last_mut().filter(|last| last[1] >= from) {
                Some(last) => last[1] = to,
                None => moving.push([from, to]),
            }
        }
        let stride = inside.len().div_ceil(MOST_MOMENTS).max(1);
        let moment = |k: &usize| {
            let samples = [marks[k - 1], marks[*k], marks[k + 1]];
            (samples.map(|i| object.t[i]), samples.map(|i| (position(i), object.theta[i])))
        };
        Some(Self {
            moments: inside.iter().step_by(stride).map(moment).collect(),
            moving,
            span: [object.t[*by_time.first()?], object.t[*by_time.last()?]],
        })
    }

    /// How many moments there are.
    pub(super) fn len(&self) -> usize {
        self.moments.len()
    }

    /// When the object rests before its first motion; after one a pusher may go on pressing.
    pub(super) fn before(&self) -> Option<[f64; 2]> {
        let onset = self.moving.first()?[0];
        (onset > self.span[0]).then_some([self.span[0], onset])
    }

    /// When the moments are, in s, and where the object is then.
    pub(super) fn places(&self) -> impl Iterator<Item = (f64, Pose)> {
        self.moments.iter().map(|(t, object)| {
            let (position, angle) = object[1];
            (t[1], Pose { position, angle })
        })
    }

    /// Speeds of the object's frame in its moments, in m/s.
    pub(super) fn speeds(&self) -> impl Iterator<Item = f64> {
        self.moments.iter().map(|(t, object)| (object[2].0 - object[0].0).norm() / (t[2] - t[0]))
    }

    /// Its moments with the pusher so many seconds later, where it is known.
    pub(super) fn with(&self, robot: &Track, later: f64) -> impl Iterator<Item = Moment> {
        self.moments.iter().filter_map(move |(t, object)| {
            let [before, now, after] = t.map(|t| robot.at(t + later));
            Some(Moment { t: *t, pusher: [before?, now?, after?], object: *object, force: None })
        })
    }
}

/// Moments within the motions of a recording.
///
/// - `zero`: of the force, as [`zero`] finds it.
pub(super) fn moments(
    motion: &Motion,
    robot: &Track,
    wrench: &Track,
    zero: Vector2<f64>,
) -> Vec<Moment> {
    let with_force = |moment: Moment| {
        let force = wrench.mean([[moment.t[0], moment.t[2]]].into_iter());
        // What is read is the force on the pusher.
        Moment { force: force.map(|force| zero - force), ..moment }
    };
    motion.with(robot, 0.0).map(with_force).collect()
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

/// Median force on the pusher well before the object moves; zero where there is none.
pub(super) fn zero(wrench: Option<&WrenchStream>, motion: &Motion) -> Vector2<f64> {
    let onset = motion.moving.first().map(|moving| moving[0]);
    let Some((wrench, onset)) = wrench.zip(onset) else { return Vector2::zeros() };
    let first = wrench.t.iter().copied().fold(f64::INFINITY, f64::min);
    let last = first + 0.8 * (onset - first);
    let of = |values: &[f64]| {
        let early = wrench.t.iter().zip(values).filter(|(t, _)| **t < last);
        quantile(early.map(|(_, value)| *value).collect(), 0.5).unwrap_or(0.0)
    };
    Vector2::new(of(&wrench.fx), of(&wrench.fy))
}
