//! Where the pusher's center goes, and the steps that a model takes along it.

use std::f64::consts::TAU;

use dataset::{CubicSpline, EndCondition};
use nalgebra::Vector2;

use crate::ModelError;
use crate::error::positive;

/// The way of a pusher's center over the table, frame W, from time 0 on.
///
/// Arcs and splines are kept as chords that are nowhere more than 1 µm off.
#[derive(Clone, Debug, PartialEq)]
pub struct PushPath {
    /// Time in s and place in m, the times increasing.
    points: Vec<(f64, Vector2<f64>)>,
    /// Indices of the points at which every division into steps has to stop, first and last among
    /// them.
    stops: Vec<usize>,
}

/// A straight piece of a path, for a model to take in one go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathStep {
    /// Time at its start, in s.
    pub time: f64,
    /// How long it takes, in s.
    pub duration: f64,
    /// Where the pusher's center starts, in m, frame W.
    pub start_w: Vector2<f64>,
    /// Where it ends.
    pub end_w: Vector2<f64>,
}

/// Faster robots do not push, in m/s: such a pair of points is a jump.
const FASTEST: f64 = 3.0;
/// Straighter than this is straight, in m.
const SAGITTA: f64 = 1e-6;
/// Chords between two points of a spline.
const PIECES: usize = 64;
/// Most chords of an arc or a spline: an arc of 100 km has as many.
const MOST_CHORDS: usize = 1_000_000;
/// Most steps along a path: 80 m in steps of 4 mm.
const MOST_STEPS: usize = 20_000;

impl PushPath {
    /// A straight way at a constant speed in m/s.
    ///
    /// # Errors
    /// As [`PushPath::polyline`].
    pub fn straight(
        start_w: Vector2<f64>,
        end_w: Vector2<f64>,
        speed: f64,
    ) -> Result<Self, ModelError> {
        Self::polyline(&[start_w, end_w], speed)
    }

    /// Straight pieces at a constant speed in m/s; every point ends a step.
    ///
    /// # Errors
    /// `Path` for fewer than two points, equal neighbors or a point that is not finite;
    /// `InvalidValue` for a speed that is not positive, or above 3 m/s.
    pub fn polyline(points_w: &[Vector2<f64>], speed: f64) -> Result<Self, ModelError> {
        let points = at_speed(points_w, speed)?;
        let stops = (0..points.len()).collect();
        Ok(Self { points, stops })
    }

    /// An arc from a place about a center by an angle in rad, counter-clockwise positive, at a
    /// constant speed in m/s.
    ///
    /// # Errors
    /// As [`PushPath::polyline`]; `InvalidValue` for an angle of 0 or beyond ± 2π.
    pub fn arc(
        start_w: Vector2<f64>,
        center_w: Vector2<f64>,
        angle: f64,
        speed: f64,
    ) -> Result<Self, ModelError> {
        if !(angle.abs() > 0.0 && angle.abs() <= TAU) {
            let (name, expected) = ("angle of the arc", "not 0, and within ±2π");
            return Err(ModelError::InvalidValue { name, expected, value: angle, unit: "rad" });
        }
        let arm = start_w - center_w;
        let widest = (8.0 * SAGITTA / arm.norm().max(SAGITTA)).sqrt();
        let n = count("chords of the arc", (angle.abs() / widest).ceil().max(1.0), MOST_CHORDS)?;
        let place = |k: usize| {
            let turn = nalgebra::Rotation2::new(angle * k as f64 / n as f64);
            center_w + turn * arm
        };
        Self::smooth(at_speed(&(0..=n).map(place).collect::<Vec<_>>(), speed)?)
    }

    /// The cubic spline through points, by the way between them, at a constant speed in m/s.
    ///
    /// # Errors
    /// As [`PushPath::polyline`].
    pub fn spline(points_w: &[Vector2<f64>], speed: f64) -> Result<Self, ModelError> {
        let by_way = at_speed(points_w, speed)?;
        let knots: Vec<f64> = by_way.iter().map(|(time, _)| *time).collect();
        let axis = |k: usize| {
            let values: Vec<f64> = points_w.iter().map(|point| point[k]).collect();
            CubicSpline::interpolate(&knots, &values, EndCondition::Natural)
                .map_err(|error| refused(0, error.to_string()))
        };
        let [x, y] = [axis(0)?, axis(1)?];
        let end = knots[knots.len() - 1];
        let n = count("chords of the spline", (PIECES * (knots.len() - 1)) as f64, MOST_CHORDS)?;
        let place = |k: usize| {
            let at = (end * k as f64 / n as f64).min(end);
            let value = |axis: &CubicSpline| {
                let beyond = || refused(k / PIECES, format!("has no spline at {at} s"));
                axis.value(at).ok_or_else(beyond)
            };
            Ok(Vector2::new(value(&x)?, value(&y)?))
        };
        let chords = (0..=n).map(place).collect::<Result<Vec<_>, ModelError>>()?;
        Self::smooth(at_speed(&chords, speed)?)
    }

    /// A smooth way through points with their times in s, as a robot reports it; where it rests it
    /// waits.
    ///
    /// # Errors
    /// `Path` for fewer than two points, one that is not finite, times that do not increase, or a
    /// jump: two points that are more than 3 m/s apart.
    pub fn timed(points_w: &[(f64, Vector2<f64>)]) -> Result<Self, ModelError> {
        Self::smooth(checked(points_w)?)
    }

    /// As [`PushPath::timed`], with a step from each point to the next, as a table has them.
    ///
    /// # Errors
    /// As [`PushPath::timed`].
    pub fn stepwise(points_w: &[(f64, Vector2<f64>)]) -> Result<Self, ModelError> {
        let points = checked(points_w)?;
        let stops = (0..points.len()).collect();
        Ok(Self { points, stops })
    }

    fn smooth(points: Vec<(f64, Vector2<f64>)>) -> Result<Self, ModelError> {
        let stops = vec![0, points.len() - 1];
        Ok(Self { points, stops })
    }

    /// How long it takes, in s.
    pub fn duration(&self) -> f64 {
        self.points[self.points.len() - 1].0
    }

    /// Its length, in m.
    pub fn length(&self) -> f64 {
        self.points.windows(2).map(|pair| (pair[1].1 - pair[0].1).norm()).sum()
    }

    /// Where it begins, in m, frame W.
    pub fn start_w(&self) -> Vector2<f64> {
        self.points[0].1
    }

    /// Time and place of its points, in s and m: enough to draw it.
    pub fn points(&self) -> &[(f64, Vector2<f64>)] {
        &self.points
    }

    /// The path in steps of equal way, none longer than `longest` in m, each between two stops.
    ///
    /// A stop is the start, the end, a corner of a polyline, or a point of a stepwise path, of which
    /// steps that are longer are divided. The chord of a step is its way.
    ///
    /// # Errors
    /// `InvalidValue` for a length that is not positive, or of which the path has more than 20 000.
    pub fn steps(&self, longest: f64) -> Result<Vec<PathStep>, ModelError> {
        positive("length of a step", longest, "m")?;
        let mut steps = Vec::new();
        for ends in self.stops.windows(2) {
            let piece = &self.points[ends[0]..=ends[1]];
            let ways = ways(piece);
            let whole = ways[ways.len() - 1];
            // A recorded step of 4 mm is one step of 4 mm, for all its rounding.
            let n = (whole / longest - 1e-6).ceil().max(1.0);
            let all = count("steps along the path", steps.len() as f64 + n, MOST_STEPS)?;
            let n = all - steps.len();
            let at = |k: usize| along(piece, &ways, whole * k as f64 / n as f64, k == n);
            for k in 0..n {
                let ((time, start_w), (end, end_w)) = (at(k), at(k + 1));
                steps.push(PathStep { time, duration: end - time, start_w, end_w });
            }
        }
        Ok(steps)
    }
}

impl PathStep {
    /// How far the pusher moves, in m.
    pub fn distance(&self) -> f64 {
        (self.end_w - self.start_w).norm()
    }
}

/// A number of pieces, unless they are too many.
fn count(name: &'static str, number: f64, most: usize) -> Result<usize, ModelError> {
    if number <= most as f64 {
        return Ok(number as usize);
    }
    Err(ModelError::TooMany { name, number, most })
}

/// The way to each point of a piece, in m.
fn ways(piece: &[(f64, Vector2<f64>)]) -> Vec<f64> {
    let mut sum = 0.0;
    let way = |pair: &[(f64, Vector2<f64>)]| {
        sum += (pair[1].1 - pair[0].1).norm();
        sum
    };
    std::iter::once(0.0).chain(piece.windows(2).map(way)).collect()
}

/// Time and place after a way.
fn along(
    piece: &[(f64, Vector2<f64>)],
    ways: &[f64],
    way: f64,
    is_end: bool,
) -> (f64, Vector2<f64>) {
    if is_end {
        return piece[piece.len() - 1];
    }
    let next = ways.partition_point(|passed| *passed <= way).clamp(1, piece.len() - 1);
    let ((early, from), (late, to)) = (piece[next - 1], piece[next]);
    let length = ways[next] - ways[next - 1];
    let share = if length > 0.0 { (way - ways[next - 1]) / length } else { 0.0 };
    (early + share * (late - early), from + share * (to - from))
}

/// Points with the times at which a constant speed passes them.
fn at_speed(points_w: &[Vector2<f64>], speed: f64) -> Result<Vec<(f64, Vector2<f64>)>, ModelError> {
    positive("speed of the pusher", speed, "m/s")?;
    if speed > FASTEST {
        let (name, expected) = ("speed of the pusher", "at most 3 m/s");
        return Err(ModelError::InvalidValue { name, expected, value: speed, unit: "m/s" });
    }
    finite(points_w.iter())?;
    let mut time = 0.0;
    let mut timed = Vec::with_capacity(points_w.len());
    for (index, point) in points_w.iter().enumerate() {
        if let Some((_, last)) = timed.last() {
            let way = (point - last as &Vector2<f64>).norm();
            if way == 0.0 {
                let problem = "is where the one before it is; leave one of them out";
                return Err(refused(index, problem.to_owned()));
            }
            time += way / speed;
        }
        timed.push((time, *point));
    }
    Ok(timed)
}

/// Recorded points from time 0 on.
fn checked(points_w: &[(f64, Vector2<f64>)]) -> Result<Vec<(f64, Vector2<f64>)>, ModelError> {
    finite(points_w.iter().map(|(_, point)| point))?;
    let begins = points_w[0].0;
    for (index, (time, point)) in points_w.iter().enumerate() {
        if !time.is_finite() {
            return Err(refused(index, format!("has a time of {time} s; it must be finite")));
        }
        let Some((earlier, last)) = index.checked_sub(1).map(|before| points_w[before]) else {
            continue;
        };
        if *time <= earlier {
            let problem = format!("is at {time} s, after one at {earlier} s; times must increase");
            return Err(refused(index, problem));
        }
        let speed = (point - last).norm() / (time - earlier);
        if speed > FASTEST {
            let jump = 1e3 * (point - last).norm();
            let problem = format!(
                "is a jump of {jump:.1} mm in {:.4} s, which is {speed:.1} m/s; robots push at 3 m/s \
                 at most, so mend the path",
                time - earlier
            );
            return Err(refused(index, problem));
        }
    }
    Ok(points_w.iter().map(|(time, point)| (time - begins, *point)).collect())
}

fn finite<'a>(points_w: impl ExactSizeIterator<Item = &'a Vector2<f64>>) -> Result<(), ModelError> {
    let n = points_w.len();
    if n < 2 {
        return Err(refused(n, "is missing: a path has two points or more".to_owned()));
    }
    for (index, point) in points_w.enumerate() {
        if !(point.x.is_finite() && point.y.is_finite()) {
            let problem = format!("is ({}, {}) m; it must be finite", point.x, point.y);
            return Err(refused(index, problem));
        }
    }
    Ok(())
}

fn refused(point: usize, problem: String) -> ModelError {
    ModelError::Path { point, problem }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use nalgebra::Vector2;

    use super::{PathStep, PushPath};
    use crate::ModelError;

    fn at(x: f64, y: f64) -> Vector2<f64> {
        Vector2::new(x, y)
    }

    #[test]
    fn every_kind_of_path_is_as_long_as_its_steps_and_goes_at_its_speed() {
        let corner = [at(0.0, 0.0), at(0.03, 0.0), at(0.03, 0.041)];
        let paths = [
            (PushPath::straight(at(0.0, 0.1), at(0.05, 0.1), 0.02).unwrap(), 0.05),
            (PushPath::polyline(&corner, 0.02).unwrap(), 0.071),
            (PushPath::arc(at(0.1, 0.0), at(0.0, 0.0), -0.5 * PI, 0.02).unwrap(), 0.05 * PI),
            (PushPath::spline(&[at(0.0, 0.0), at(0.01, 0.0), at(0.05, 0.0)], 0.02).unwrap(), 0.05),
        ];
        for (path, length) in paths {
            assert!((path.length() - length).abs() < 1e-6, "{} {length}", path.length());
            assert!((path.duration() - path.length() / 0.02).abs() < 1e-9);
            let steps = path.steps(0.004).unwrap();
            assert!(steps.iter().all(|step| step.distance() < 0.004 + 1e-9));
            assert!(steps.iter().all(|step| step.distance() > 0.003));
            assert_eq!(steps[0].start_w, path.start_w());
            for pair in steps.windows(2) {
                assert_eq!(pair[0].end_w, pair[1].start_w);
                assert!((pair[0].time + pair[0].duration - pair[1].time).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn no_step_cuts_a_corner_and_an_arc_turns_evenly() {
        let corner = [at(0.0, 0.0), at(0.03, 0.0), at(0.03, 0.041)];
        let steps = PushPath::polyline(&corner, 0.02).unwrap().steps(0.004).unwrap();
        assert!(steps.iter().any(|step| step.end_w == corner[1]));
        assert!(steps.iter().all(|step| {
            let way = step.end_w - step.start_w;
            way.x.abs() < 1e-12 || way.y.abs() < 1e-12
        }));
        let arc = PushPath::arc(at(0.1, 0.0), at(0.0, 0.0), 1.0, 0.02).unwrap();
        let steps = arc.steps(0.004).unwrap();
        for pair in steps.windows(2) {
            let ways = [0, 1].map(|k: usize| pair[k].end_w - pair[k].start_w);
            let turn = ways[0].angle(&ways[1]);
            assert!((turn - 1.0 / steps.len() as f64).abs() < 2e-3, "{turn}");
        }
        assert!(steps.iter().all(|step| (step.end_w.norm() - 0.1).abs() < 2e-6));
    }

    #[test]
    fn a_path_of_too_many_pieces_is_refused_with_number_and_limit() {
        let far = PushPath::straight(at(0.0, 0.0), at(1e6, 0.0), 0.02).unwrap();
        assert_eq!(
            far.steps(0.004).unwrap_err().to_string(),
            "2.5e8 steps along the path, at most 20000 are taken; shorten the path, or take larger \
             steps"
        );
        assert_eq!(far.steps(50.0).unwrap().len(), 20_000);
        let endless = PushPath::straight(at(-1e308, 0.0), at(1e308, 0.0), 0.02).unwrap();
        assert!(endless.steps(0.004).is_err());
        let error = PushPath::arc(at(1e12, 0.0), at(0.0, 0.0), 6.0, 0.02).unwrap_err();
        assert!(error.to_string().contains("chords of the arc, at most 1000000"), "{error}");
    }

    #[test]
    fn recorded_steps_are_kept_and_longer_ones_divided() {
        let points = [(5.0, at(0.0, 0.0)), (5.2, at(0.004, 0.0)), (5.6, at(0.012, 0.0))];
        let path = PushPath::stepwise(&points).unwrap();
        let ways: Vec<f64> = path.steps(0.004).unwrap().iter().map(PathStep::distance).collect();
        assert_eq!(ways.len(), 3);
        assert!(ways.iter().all(|way| (way - 0.004).abs() < 1e-12));
        assert!((path.duration() - 0.6).abs() < 1e-12);
        // Without the stops of a table the same way is divided evenly.
        assert_eq!(PushPath::timed(&points).unwrap().steps(0.007).unwrap().len(), 2);
    }

    #[test]
    fn a_path_there_and_back_has_the_steps_of_its_whole_way() {
        let points = [(0.0, at(0.0, 0.0)), (1.0, at(0.02, 0.0)), (2.0, at(0.0, 0.0))];
        let steps = PushPath::timed(&points).unwrap().steps(0.004).unwrap();
        assert_eq!(steps.len(), 10);
        assert!(steps.iter().all(|step| (step.distance() - 0.004).abs() < 1e-12));
        let farthest = steps.iter().map(|step| step.end_w.x).fold(0.0, f64::max);
        assert!((farthest - 0.02).abs() < 1e-12);
    }

    #[test]
    fn what_is_no_path_is_refused_with_the_point() {
        let problem = |result: Result<PushPath, ModelError>| result.unwrap_err().to_string();
        let nan = at(f64::NAN, 0.0);
        let timed = |t: [f64; 3], x: [f64; 3]| {
            let points: Vec<_> = (0..3).map(|k| (t[k], at(x[k], 0.0))).collect();
            problem(PushPath::timed(&points))
        };
        for (message, says) in [
            (problem(PushPath::straight(at(0.0, 0.0), nan, 0.02)), "point 1 of the path is (NaN"),
            (problem(PushPath::straight(at(0.0, 0.0), at(0.0, 0.0), 0.02)), "leave one"),
            (problem(PushPath::polyline(&[at(0.0, 0.0)], 0.02)), "two points or more"),
            (problem(PushPath::polyline(&[], 0.02)), "two points or more"),
            (problem(PushPath::straight(at(0.0, 0.0), at(0.1, 0.0), 4.0)), "3 m/s, got 4 m/s"),
            (problem(PushPath::straight(at(0.0, 0.0), at(0.1, 0.0), -1.0)), "got -1 m/s"),
            (problem(PushPath::arc(at(0.1, 0.0), at(0.0, 0.0), 7.0, 0.02)), "±2π"),
            (timed([0.0, 0.1, 0.1], [0.0, 0.1, 0.2]), "point 2 of the path is at 0.1 s"),
            (timed([0.0, 0.1, 0.2], [0.0, 0.002, 0.5]), "a jump of 498.0 mm"),
            (timed([0.0, f64::INFINITY, 0.2], [0.0, 0.1, 0.2]), "a time of inf s"),
        ] {
            assert!(message.contains(says), "{says}: {message}");
        }
        let path = PushPath::straight(at(0.0, 0.0), at(0.1, 0.0), 0.02).unwrap();
        assert!(path.steps(0.0).is_err() && path.steps(f64::NAN).is_err());
    }
}
