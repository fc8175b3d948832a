//! Quasi-Newton minimisation (BFGS, and L-BFGS of many variables) of a smooth function that may be
//! undefined at some points.

use serde::{Deserialize, Serialize};

use crate::GpError;
use crate::limited_memory::LimitedMemory;

/// When to stop.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Most iterations.
    pub max_iterations: usize,
    /// Largest component of the gradient at convergence.
    pub gradient_tolerance: f64,
    /// Converged, too, where so many iterations together gain less than the value beside them.
    pub progress: Option<(usize, f64)>,
}

/// The last point of a minimisation.
#[derive(Clone, Debug)]
pub struct Minimum {
    /// Where it is.
    pub point: Vec<f64>,
    /// The function there.
    pub value: f64,
    /// Largest component of the gradient there.
    pub gradient_norm: f64,
    /// Steps taken.
    pub iterations: usize,
    /// Calls of the function.
    pub evaluations: usize,
    /// Why it stopped.
    pub stop: StopReason,
    /// The function at the start, and after each step that was taken.
    pub history: Vec<f64>,
}

/// Why a minimisation stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum StopReason {
    /// Every component of the gradient is below the tolerance: converged.
    GradientBelowTolerance,
    /// The next step would gain less than rounding: converged.
    DecreaseBelowRounding,
    /// The last iterations gained less than asked for: converged.
    ProgressBelowTolerance,
    /// All steps of a stochastic search are done, which knows no better sign of convergence.
    StepsTaken,
    /// Too many iterations: not converged.
    IterationLimit,
    /// No acceptable step along the steepest descent: not converged.
    LineSearchFailed,
}

impl StopReason {
    /// Whether the last point is a minimum as far as can be told.
    pub fn converged(self) -> bool {
        !matches!(self, Self::IterationLimit | Self::LineSearchFailed)
    }
}

/// Minimises a function of which `evaluate(point, gradient)` returns the value.
///
/// A failing evaluation within a line search shortens the step. Up to [`MOST_DENSE`] variables the whole
/// inverse Hessian is kept, above them the last twenty steps (L-BFGS), in memory that grows with the
/// number of variables and not with its square.
///
/// # Errors
/// The function's own error at the start.
///
/// # Source
/// Nocedal & Wright, Numerical Optimization (2006), ch. 6 and 7; Hager & Zhang (2005) for the acceptance
/// of steps whose decrease drowns in rounding.
pub fn minimize<E>(
    evaluate: impl FnMut(&[f64], &mut [f64]) -> Result<f64, E>,
    start: &[f64],
    limits: Limits,
) -> Result<Minimum, E> {
    minimize_from(Curvature::new(start.len()), evaluate, start, limits)
}

/// The most variables of which the whole inverse Hessian is kept.
pub const MOST_DENSE: usize = 1000;

fn minimize_from<E>(
    mut curvature: Curvature,
    mut evaluate: impl FnMut(&[f64], &mut [f64]) -> Result<f64, E>,
    start: &[f64],
    limits: Limits,
) -> Result<Minimum, E> {
    let mut gradient = vec![0.0; start.len()];
    let value = evaluate(start, &mut gradient)?;
    let mut here = Point { position: start.to_vec(), value, gradient };
    let (mut iterations, mut evaluations) = (0, 1);
    let mut history = vec![here.value];
    let stop = loop {
        if here.gradient_norm() <= limits.gradient_tolerance {
            break StopReason::GradientBelowTolerance;
        }
        if limits.progress.is_some_and(|(steps, least)| has_stalled(&history, steps, least)) {
            break StopReason::ProgressBelowTolerance;
        }
        if iterations == limits.max_iterations {
            break StopReason::IterationLimit;
        }
        let direction = curvature.direction(&here.gradient);
        if -dot(&direction, &here.gradient) <= f64::EPSILON * here.value.abs().max(1.0) {
            break StopReason::DecreaseBelowRounding;
        }
        iterations += 1;
        let mut counted = |position: &[f64], gradient: &mut [f64]| {
            evaluations += 1;
            evaluate(position, gradient).ok().filter(|value| value.is_finite())
        };
        match line_search(&mut counted, &here, &direction) {
            Some(next) => {
                curvature.update(&here, &next);
                here = next;
                history.push(here.value);
            }
            None if curvature.is_fresh() => break StopReason::LineSearchFailed,
            None => curvature.forget(),
        }
    };
    let gradient_norm = here.gradient_norm();
    let Point { position: point, value, .. } = here;
    Ok(Minimum { point, value, gradient_norm, iterations, evaluations, stop, history })
}

/// The converged start with the smallest objective, the first of equals.
///
/// # Errors
/// `NotConverged`; the first start's own error if none could begin.
pub fn best_of(ends: &[Result<Minimum, GpError>]) -> Result<(usize, &Minimum), GpError> {
    let minima = || ends.iter().enumerate().filter_map(|(i, end)| Some((i, end.as_ref().ok()?)));
    let by_value = |a: &(usize, &Minimum), b: &(usize, &Minimum)| a.1.value.total_cmp(&b.1.value);
    if let Some(best) = minima().filter(|(_, end)| end.stop.converged()).min_by(by_value) {
        return Ok(best);
    }
    match minima().min_by(|a, b| a.1.gradient_norm.total_cmp(&b.1.gradient_norm)) {
        Some((_, end)) => Err(GpError::NotConverged {
            n_starts: ends.len(),
            iterations: end.iterations,
            gradient_norm: end.gradient_norm,
        }),
        None => Err(ends
            .iter()
            .find_map(|end| end.as_ref().err().cloned())
            .unwrap_or(GpError::Empty { what: "starts" })),
    }
}

/// Whether the last `steps` together gained less than `least`.
fn has_stalled(history: &[f64], steps: usize, least: f64) -> bool {
    let last = history.len() - 1;
    last >= steps && history[last - steps] - history[last] < least
}

/// A point with the function's value and gradient.
struct Point {
    position: Vec<f64>,
    value: f64,
    gradient: Vec<f64>,
}

impl Point {
    fn gradient_norm(&self) -> f64 {
        self.gradient.iter().fold(0.0, |norm, slope| norm.max(slope.abs()))
    }
}

/// What the steps so far tell of the inverse Hessian.
enum Curvature {
    Dense(InverseHessian),
    Limited(LimitedMemory),
}

impl Curvature {
    fn new(n: usize) -> Self {
        if n <= MOST_DENSE {
            Self::Dense(InverseHessian { n, entries: Vec::new() })
        } else {
            Self::Limited(LimitedMemory::default())
        }
    }

    fn is_fresh(&self) -> bool {
        match self {
            Self::Dense(whole) => whole.entries.is_empty(),
            Self::Limited(last) => last.is_fresh(),
        }
    }

    fn forget(&mut self) {
        match self {
            Self::Dense(whole) => whole.entries.clear(),
            Self::Limited(last) => *last = LimitedMemory::default(),
        }
    }

    /// −H g, with no component above `MAX_STEP`; without curvature a step of at most 1 downhill.
    fn direction(&self, gradient: &[f64]) -> Vec<f64> {
        let (mut direction, longest): (Vec<f64>, f64) = match self {
            _ if self.is_fresh() => (gradient.iter().map(|slope| -slope).collect(), 1.0),
            Self::Dense(whole) => (whole.direction(gradient), MAX_STEP),
            Self::Limited(last) => (last.direction(gradient), MAX_STEP),
        };
        let norm = direction.iter().fold(0.0_f64, |norm, step| norm.max(step.abs()));
        if norm > longest {
            direction.iter_mut().for_each(|step| *step *= longest / norm);
        }
        direction
    }

    fn update(&mut self, from: &Point, to: &Point) {
        let difference =
            |a: &[f64], b: &[f64]| -> Vec<f64> { a.iter().zip(b).map(|(a, b)| a - b).collect() };
        let step = difference(&to.position, &from.position);
        let change = difference(&to.gradient, &from.gradient);
        let along = dot(&step, &change);
        if along <= f64::EPSILON * dot(&change, &change).sqrt() * dot(&step, &step).sqrt() {
            return;
        }
        match self {
            Self::Dense(whole) => whole.update(&step, &change, along),
            Self::Limited(last) => last.update(step, change, along),
        }
    }
}

/// The BFGS approximation of the inverse Hessian, by rows; empty until the first step.
struct InverseHessian {
    n: usize,
    entries: Vec<f64>,
}

impl InverseHessian {
    fn direction(&self, gradient: &[f64]) -> Vec<f64> {
        self.entries.chunks_exact(self.n).map(|row| -dot(row, gradient)).collect()
    }

    /// H ← (I − s tᵀ/sᵀt) H (I − t sᵀ/sᵀt) + s sᵀ/sᵀt with step s and change of gradient t.
    fn update(&mut self, step: &[f64], change: &[f64], along: f64) {
        if self.entries.is_empty() {
            self.entries = vec![0.0; self.n * self.n];
            let scale = along / dot(change, change);
            (0..self.n).for_each(|i| self.entries[i * self.n + i] = scale);
        }
        let image: Vec<f64> =
            self.entries.chunks_exact(self.n).map(|row| dot(row, change)).collect();
        let outer = (1.0 + dot(change, &image) / along) / along;
        for (i, row) in self.entries.chunks_exact_mut(self.n).enumerate() {
            for (j, entry) in row.iter_mut().enumerate() {
                let mixed = (image[i] * step[j] + step[i] * image[j]) / along;
                *entry += outer * step[i] * step[j] - mixed;
            }
        }
    }
}

/// The longest step in one coordinate: a factor of e² in a parameter.
const MAX_STEP: f64 = 2.0;
const SUFFICIENT_DECREASE: f64 = 1e-4;
const CURVATURE: f64 = 0.9;
const MAX_TRIALS: usize = 40;
/// Relative error that a value may carry from rounding: that of ln |K| where noise is at its wall.
const VALUE_ROUNDING: f64 = 1e-8;

/// A step along `direction` that meets the Wolfe conditions, found by bracketing.
fn line_search(
    evaluate: &mut impl FnMut(&[f64], &mut [f64]) -> Option<f64>,
    here: &Point,
    direction: &[f64],
) -> Option<Point> {
    let slope_here = dot(direction, &here.gradient);
    let rounding = VALUE_ROUNDING * here.value.abs().max(1.0);
    let (mut low, mut low_value, mut low_slope) = (0.0, here.value, slope_here);
    let mut high = f64::INFINITY;
    let mut length = 1.0;
    for _ in 0..MAX_TRIALS {
        let move_by = |(x, step): (&f64, &f64)| x + length * step;
        let position: Vec<f64> = here.position.iter().zip(direction).map(move_by).collect();
        let mut gradient = vec![0.0; position.len()];
        let Some(value) = evaluate(&position, &mut gradient) else {
            high = length;
            length = low + 0.25 * (high - low);
            continue;
        };
        let slope = dot(direction, &gradient);
        let decreased = value <= here.value + SUFFICIENT_DECREASE * length * slope_here;
        let flat = value <= here.value + rounding
            && slope <= (2.0 * SUFFICIENT_DECREASE - 1.0) * slope_here;
        if !decreased && !flat {
            high = length;
            length = low + interpolate(high - low, low_value, low_slope, value);
        } else if slope < CURVATURE * slope_here {
            (low, low_value, low_slope) = (length, value, slope);
            length = if high.is_finite() { 0.5 * (low + high) } else { 2.0 * length };
        } else {
            return Some(Point { position, value, gradient });
        }
    }
    None
}

/// The minimum of the parabola through a value and slope at 0 and a value at `width`, kept off
/// both ends.
fn interpolate(width: f64, value: f64, slope: f64, value_at_width: f64) -> f64 {
    let bend = value_at_width - value - slope * width;
    let minimum = -0.5 * slope * width * width / bend;
    if minimum.is_finite() { minimum.clamp(0.1 * width, 0.9 * width) } else { 0.5 * width }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::{Curvature, Limits, StopReason, minimize, minimize_from};
    use crate::limited_memory::LimitedMemory;

    const LIMITS: Limits = Limits { max_iterations: 200, gradient_tolerance: 1e-9, progress: None };

    fn rosenbrock(x: &[f64], gradient: &mut [f64]) -> Result<f64, ()> {
        let (a, b) = (1.0 - x[0], x[1] - x[0] * x[0]);
        gradient[0] = -2.0 * a - 400.0 * x[0] * b;
        gradient[1] = 200.0 * b;
        Ok(a * a + 100.0 * b * b)
    }

    #[test]
    fn the_curved_valley_ends_at_one_one() {
        let minimum = minimize(rosenbrock, &[-1.2, 1.0], LIMITS).unwrap();
        assert!(minimum.stop.converged());
        assert!(minimum.point.iter().all(|x| (x - 1.0).abs() < 1e-8), "{minimum:?}");
        assert!(minimum.iterations < 60, "{minimum:?}");
    }

    #[test]
    fn few_steps_remembered_reach_the_same_minimum() {
        let curvature = Curvature::Limited(LimitedMemory::default());
        let minimum = minimize_from(curvature, rosenbrock, &[-1.2, 1.0], LIMITS).unwrap();
        assert!(minimum.stop.converged());
        assert!(minimum.point.iter().all(|x| (x - 1.0).abs() < 1e-8), "{minimum:?}");
        assert!(minimum.iterations < 60, "{minimum:?}");
    }

    #[test]
    fn many_variables_are_minimized_in_little_memory() {
        // Valleys side by side, each as curved as the one of two variables.
        let valleys = |x: &[f64], gradient: &mut [f64]| -> Result<f64, ()> {
            x.chunks(2).zip(gradient.chunks_mut(2)).map(|(x, slope)| rosenbrock(x, slope)).sum()
        };
        let start: Vec<f64> = (0..20_000).map(|i| [-1.2, 1.0, 0.3, -0.5][i % 4]).collect();
        let minimum = minimize(valleys, &start, LIMITS).unwrap();
        assert!(minimum.stop.converged());
        assert!(minimum.point.iter().all(|x| (x - 1.0).abs() < 1e-7), "{}", minimum.gradient_norm);
        assert!(minimum.iterations < 120, "{}", minimum.iterations);
    }

    #[test]
    fn a_quadratic_with_spread_eigenvalues_is_solved() {
        let scales: Vec<f64> = (0..10).map(|i| 10f64.powf(0.4 * i as f64)).collect();
        let quadratic = |x: &[f64], gradient: &mut [f64]| -> Result<f64, ()> {
            for i in 0..10 {
                gradient[i] = scales[i] * (x[i] - i as f64);
            }
            Ok((0..10).map(|i| 0.5 * scales[i] * (x[i] - i as f64).powi(2)).sum())
        };
        let minimum = minimize(quadratic, &[0.0; 10], LIMITS).unwrap();
        assert!(minimum.stop.converged());
        assert!(minimum.point.iter().enumerate().all(|(i, x)| (x - i as f64).abs() < 1e-6));
    }

    #[test]
    fn a_function_undefined_beyond_a_border_is_minimized_inside() {
        let barrier = |x: &[f64], gradient: &mut [f64]| {
            if x[0] >= 1.0 {
                return Err(());
            }
            gradient[0] = -3.0 + 1.0 / (1.0 - x[0]);
            Ok(-3.0 * x[0] - (1.0 - x[0]).ln())
        };
        let minimum = minimize(barrier, &[-4.0], LIMITS).unwrap();
        assert!((minimum.point[0] - 2.0 / 3.0).abs() < 1e-8, "{minimum:?}");
        assert!(minimize(barrier, &[2.0], LIMITS).is_err());
    }

    #[test]
    fn too_few_iterations_are_reported() {
        let limits = Limits { max_iterations: 3, ..LIMITS };
        let minimum = minimize(rosenbrock, &[-1.2, 1.0], limits).unwrap();
        assert_eq!(minimum.stop, StopReason::IterationLimit);
        assert_eq!(minimum.iterations, 3);
    }

    #[test]
    fn a_wrong_gradient_is_no_convergence() {
        let uphill = |x: &[f64], gradient: &mut [f64]| -> Result<f64, ()> {
            gradient[0] = -2.0 * x[0];
            Ok(x[0] * x[0])
        };
        let minimum = minimize(uphill, &[1.0], LIMITS).unwrap();
        assert_eq!(minimum.stop, StopReason::LineSearchFailed);
    }
}
