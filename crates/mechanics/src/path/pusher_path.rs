//! Paths that a pusher's center follows over the table.

use crate::MechanicsError;
use nalgebra::Vector2;

/// The motion of a pusher's center in the world W, from time 0 to `duration`, in smooth pieces.
pub trait PusherPath: Sync {
    /// Number of pieces within which the velocity is continuous, at least 1.
    fn n_pieces(&self) -> usize {
        1
    }

    /// Time at which a piece ends, in s; the last one's is the path's duration.
    fn piece_end(&self, piece: usize) -> f64;

    /// The center's position, in m, at a `time` within a piece or at its borders.
    fn position(&self, piece: usize, time: f64) -> Vector2<f64>;

    /// The center's velocity, in m/s; at a piece's borders, the limit from within.
    fn velocity(&self, piece: usize, time: f64) -> Vector2<f64>;
}

/// A straight path at constant velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StraightPath {
    /// Where the center starts, in m, frame W.
    pub start_w: Vector2<f64>,
    /// Its velocity, in m/s, frame W.
    pub velocity_w: Vector2<f64>,
    /// How long it moves, in s.
    pub duration: f64,
}

impl PusherPath for StraightPath {
    fn piece_end(&self, _: usize) -> f64 {
        self.duration
    }

    fn position(&self, _: usize, time: f64) -> Vector2<f64> {
        self.start_w + time * self.velocity_w
    }

    fn velocity(&self, _: usize, _: f64) -> Vector2<f64> {
        self.velocity_w
    }
}

/// Straight segments between timed points, each at constant velocity.
#[derive(Clone, Debug, PartialEq)]
pub struct Polyline {
    times: Vec<f64>,
    points: Vec<Vector2<f64>>,
}

impl Polyline {
    /// A polyline through points in m, frame W, at times in s; time counts from the first of them.
    ///
    /// # Errors
    /// `BadPath` for fewer than two points, times that do not increase, or what is not finite.
    pub fn new(timed_points: &[(f64, Vector2<f64>)]) -> Result<Self, MechanicsError> {
        let bad =
            |index: usize, reason: &'static str| Err(MechanicsError::BadPath { index, reason });
        if timed_points.len() < 2 {
            return bad(timed_points.len(), "a path needs at least two points");
        }
        for (index, (time, point)) in timed_points.iter().enumerate() {
            if !(time + point.x + point.y).is_finite() {
                return bad(index, "its time and position must be finite");
            }
            if index > 0 && *time <= timed_points[index - 1].0 {
                return bad(index, "its time must be later than the one before");
            }
        }
        let start = timed_points[0].0;
        Ok(Self {
            times: timed_points.iter().map(|(time, _)| time - start).collect(),
            points: timed_points.iter().map(|(_, point)| *point).collect(),
        })
    }
}

impl PusherPath for Polyline {
    fn n_pieces(&self) -> usize {
        self.points.len() - 1
    }

    fn piece_end(&self, piece: usize) -> f64 {
        self.times[piece + 1]
    }

    fn position(&self, piece: usize, time: f64) -> Vector2<f64> {
        self.points[piece] + (time - self.times[piece]) * self.velocity(piece, time)
    }

    fn velocity(&self, piece: usize, _: f64) -> Vector2<f64> {
        (self.points[piece + 1] - self.points[piece]) / (self.times[piece + 1] - self.times[piece])
    }
}

/// A smooth path given by two functions of time: position in m and velocity in m/s, frame W.
#[derive(Clone, Copy, Debug)]
pub struct SmoothPath<P, V> {
    /// The center's position.
    pub position_w: P,
    /// The center's velocity: the position's derivative.
    pub velocity_w: V,
    /// How long it moves, in s.
    pub duration: f64,
}

impl<P, V> PusherPath for SmoothPath<P, V>
where
    P: Fn(f64) -> Vector2<f64> + Sync,
    V: Fn(f64) -> Vector2<f64> + Sync,
{
    fn piece_end(&self, _: usize) -> f64 {
        self.duration
    }

    fn position(&self, _: usize, time: f64) -> Vector2<f64> {
        (self.position_w)(time)
    }

    fn velocity(&self, _: usize, time: f64) -> Vector2<f64> {
        (self.velocity_w)(time)
    }
}
