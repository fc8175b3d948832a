//! The pusher's way over one step.

use std::sync::Arc;

use mechanics::{Polyline, PusherPath};
use nalgebra::Vector2;

/// Where the pusher's center is over a step, in the world frame; time counts from the step's start.
///
/// Before and after the step it goes on at the velocity of its ends.
#[derive(Clone, Debug)]
pub struct Track {
    duration: f64,
    start: Vector2<f64>,
    end: Vector2<f64>,
    kind: Kind,
}

#[derive(Clone, Debug)]
enum Kind {
    /// The cubic with these velocities at its ends, in m/s.
    Cubic { start_velocity: Vector2<f64>, end_velocity: Vector2<f64> },
    Polyline {
        line: Arc<Polyline>,
        /// Whether the velocity truly jumps at its points.
        is_kinked: bool,
    },
}

/// Gauss–Legendre points and weights on 0 to 1: the speed of a constant acceleration along a line is
/// exact, and one that turns back within two hundredths.
const GAUSS: [(f64, f64); 8] = [
    (0.019_855_071_751_231_856, 0.050_614_268_145_188_13),
    (0.101_666_761_293_186_64, 0.111_190_517_226_687_23),
    (0.237_233_795_041_835_5, 0.156_853_322_938_943_65),
    (0.408_282_678_752_175_1, 0.181_341_891_689_181),
    (0.591_717_321_247_825, 0.181_341_891_689_181),
    (0.762_766_204_958_164_5, 0.156_853_322_938_943_65),
    (0.898_333_238_706_813_4, 0.111_190_517_226_687_23),
    (0.980_144_928_248_768_1, 0.050_614_268_145_188_13),
];

/// Two times that are closer are one, as a share of the duration.
const ROUNDING: f64 = 1e-9;

/// Shortest duration of a step, in s.
const SHORTEST: f64 = 1e-200;

impl Track {
    /// A straight way from `start` to `end` (m) at constant velocity in `duration` (s).
    pub fn straight(start: Vector2<f64>, end: Vector2<f64>, duration: f64) -> Self {
        let velocity = (end - start) / duration;
        Self::cubic((start, velocity), (end, velocity), duration)
    }

    /// A way from `start` to `end` (m) with a constant `acceleration` (m/s²) in `duration` (s).
    pub fn accelerated(
        start: Vector2<f64>,
        end: Vector2<f64>,
        acceleration: Vector2<f64>,
        duration: f64,
    ) -> Self {
        let (mean, change) = ((end - start) / duration, 0.5 * duration * acceleration);
        Self::cubic((start, mean - change), (end, mean + change), duration)
    }

    /// The cubic through two places (m) with their velocities (m/s), `duration` (s) apart.
    pub fn cubic(
        start: (Vector2<f64>, Vector2<f64>),
        end: (Vector2<f64>, Vector2<f64>),
        duration: f64,
    ) -> Self {
        let kind = Kind::Cubic { start_velocity: start.1, end_velocity: end.1 };
        Self { duration, start: start.0, end: end.0, kind }
    }

    /// Straight pieces between timed points of a smooth way.
    pub fn polyline(polyline: Arc<Polyline>) -> Self {
        Self::through(polyline, false)
    }

    /// Straight pieces between timed points at which the velocity jumps: a step is integrated from
    /// one to the next.
    pub fn kinked(polyline: Arc<Polyline>) -> Self {
        Self::through(polyline, true)
    }

    fn through(line: Arc<Polyline>, is_kinked: bool) -> Self {
        let last = line.n_pieces() - 1;
        let duration = line.piece_end(last);
        let (start, end) = (line.position(0, 0.0), line.position(last, duration));
        Self { duration, start, end, kind: Kind::Polyline { line, is_kinked } }
    }

    /// Length of the step, in s.
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// Where the step begins, in m.
    pub fn start(&self) -> Vector2<f64> {
        self.start
    }

    /// Where the step ends, in m.
    pub fn end(&self) -> Vector2<f64> {
        self.end
    }

    /// Mean velocity over the step, in m/s.
    pub fn mean_velocity(&self) -> Vector2<f64> {
        (self.end - self.start) / self.duration
    }

    /// Length of the path over the step, there and back counted twice, in m.
    pub fn length(&self) -> f64 {
        let speed = |velocity: Vector2<f64>| velocity.x.hypot(velocity.y);
        match &self.kind {
            Kind::Cubic { start_velocity, end_velocity } => {
                let mean = self.mean_velocity();
                if *start_velocity == mean && *end_velocity == mean {
                    return self.duration * speed(mean);
                }
                let at = |share: f64| self.at(share * self.duration).1;
                let shares = GAUSS.map(|(share, weight)| weight * speed(at(share)));
                self.duration * shares.iter().sum::<f64>()
            }
            Kind::Polyline { line, .. } => {
                let starts = [0.0].into_iter().chain((0..).map(|piece| line.piece_end(piece)));
                let piece = |(piece, start): (usize, f64)| {
                    (line.piece_end(piece) - start) * speed(line.velocity(piece, start))
                };
                (0..line.n_pieces()).zip(starts).map(piece).sum()
            }
        }
    }

    /// Position and velocity at a time, in m and m/s.
    pub fn at(&self, time: f64) -> (Vector2<f64>, Vector2<f64>) {
        let inside = time.clamp(0.0, self.duration);
        let (position, velocity) = match &self.kind {
            Kind::Cubic { start_velocity, end_velocity } => {
                self.hermite(start_velocity, end_velocity, inside)
            }
            Kind::Polyline { line, .. } => {
                let piece = (0..line.n_pieces() - 1).find(|&piece| inside < line.piece_end(piece));
                let piece = piece.unwrap_or(line.n_pieces() - 1);
                (line.position(piece, inside), line.velocity(piece, inside))
            }
        };
        (position + (time - inside) * velocity, velocity)
    }

    /// When the velocity jumps next after a time, in s; none on a smooth way.
    pub(crate) fn kink_after(&self, time: f64) -> Option<f64> {
        let Kind::Polyline { line, is_kinked: true } = &self.kind else { return None };
        // A kink that has been reached but for rounding is passed.
        let from = time + ROUNDING * self.duration;
        (0..line.n_pieces() - 1).map(|piece| line.piece_end(piece)).find(|end| *end > from)
    }

    /// Whether every number is finite and the duration long enough to be divided.
    pub(crate) fn is_usable(&self) -> bool {
        let ends = self.start + self.end;
        let rates = match &self.kind {
            Kind::Cubic { start_velocity, end_velocity } => start_velocity + end_velocity,
            Kind::Polyline { .. } => Vector2::zeros(),
        };
        self.duration >= SHORTEST
            && (self.duration + ends.x + ends.y + rates.x + rates.y).is_finite()
    }

    fn hermite(
        &self,
        start_velocity: &Vector2<f64>,
        end_velocity: &Vector2<f64>,
        time: f64,
    ) -> (Vector2<f64>, Vector2<f64>) {
        let mean = self.mean_velocity();
        let s = time / self.duration;
        // About the straight way: deviations of the end velocities from the mean.
        let (early, late) = (start_velocity - mean, end_velocity - mean);
        let bend = s * (1.0 - s);
        let position = self.start + time * mean + time * (1.0 - s) * ((1.0 - s) * early - s * late);
        let velocity =
            mean + ((1.0 - s).powi(2) - 2.0 * bend) * early + (s * s - 2.0 * bend) * late;
        (position, velocity)
    }
}

#[cfg(test)]
mod tests {
    use super::Track;
    use mechanics::Polyline;
    use nalgebra::Vector2;
    use std::sync::Arc;

    #[test]
    fn a_cubic_has_its_ends_and_their_velocities() {
        let (a, b) = (Vector2::new(0.1, 0.2), Vector2::new(0.14, 0.19));
        let (u, v) = (Vector2::new(0.02, 0.0), Vector2::new(0.01, 0.03));
        let track = Track::cubic((a, u), (b, v), 0.5);
        for (time, position, velocity) in [(0.0, a, u), (0.5, b, v), (0.6, b + 0.1 * v, v)] {
            let (r, rate) = track.at(time);
            assert!((r - position).norm() + (rate - velocity).norm() < 1e-15);
        }
        let slope = (track.at(0.2 + 1e-6).0 - track.at(0.2 - 1e-6).0) / 2e-6;
        assert!((slope - track.at(0.2).1).norm() < 1e-9);
    }

    #[test]
    fn a_constant_acceleration_is_exact() {
        let (start, velocity) = (Vector2::new(0.1, 0.0), Vector2::new(0.02, 0.01));
        let acceleration = Vector2::new(0.3, -0.2);
        let place = |t: f64| start + t * velocity + 0.5 * t * t * acceleration;
        let track = Track::accelerated(start, place(0.4), acceleration, 0.4);
        assert!((track.at(0.1).0 - place(0.1)).norm() < 1e-16);
        assert!((track.at(0.3).1 - velocity - 0.3 * acceleration).norm() < 1e-15);
    }

    #[test]
    fn there_and_back_has_the_length_of_both_ways() {
        let (start, way) = (Vector2::new(0.1, 0.2), Vector2::new(0.03, 0.04));
        let straight = Track::straight(start, start + way, 0.3);
        assert!((straight.length() - 0.05).abs() < 1e-17);
        let faster = Track::accelerated(start, start + way, way, 0.3);
        assert!((faster.length() - 0.05).abs() < 1e-16);
        // At rest in the middle, 0.25 a T² away: both ways are 0.5 a T².
        let back = Track::accelerated(start, start, way, 0.4);
        let exact = 0.25 * 0.05 * 0.4 * 0.4;
        assert!((back.length() / exact - 1.0).abs() < 2e-2, "{}", back.length());
        let points = [(0.0, 0.0), (1.0, 0.05), (2.0, 0.0), (2.5, 0.01)];
        let points = points.map(|(time, x)| (time, Vector2::new(x, 0.0)));
        let line = Track::polyline(Arc::new(Polyline::new(&points).unwrap()));
        assert!((line.length() - 0.11).abs() < 1e-16);
    }

    #[test]
    fn a_polyline_turns_at_its_points() {
        let points = [(0.0, 0.0, 0.0), (1.0, 1.0, 0.0), (2.0, 1.0, 3.0)];
        let points = points.map(|(t, x, y)| (t, Vector2::new(x, y)));
        let track = Track::polyline(Arc::new(Polyline::new(&points).unwrap()));
        assert_eq!(track.at(0.5), (Vector2::new(0.5, 0.0), Vector2::new(1.0, 0.0)));
        assert_eq!(track.at(1.5), (Vector2::new(1.0, 1.5), Vector2::new(0.0, 3.0)));
        assert_eq!(track.at(3.0).0, Vector2::new(1.0, 6.0));
    }
}
