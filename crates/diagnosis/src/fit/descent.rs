//! The way down: Levenberg and Marquardt's method with bounds and secants.

use nalgebra::{DMatrix, DVector};

use super::problem::{Evaluation, Problem};
use crate::DiagnosisError;

/// Where a descent ended.
#[derive(Clone, Debug)]
pub(super) struct Minimum {
    pub(super) at: Evaluation,
    /// The numbers that are not held by a bound, and shares; columns of `slopes` and `curvature` are theirs.
    pub(super) moved: Vec<usize>,
    /// −∂z/∂x, the rows of the data and then those of the priors.
    pub(super) slopes: DMatrix<f64>,
    /// The weight of each row.
    pub(super) weights: DVector<f64>,
    /// SᵀWS: half the second derivatives of what is minimised.
    pub(super) curvature: DMatrix<f64>,
    /// SᵀWz, 0 of shares that a bound holds: what pulls on, where a jump ends the way down.
    pub(super) pull: DVector<f64>,
    /// Slopes of all numbers that are not frozen.
    pub(super) whole: DMatrix<f64>,
    pub(super) iterations: usize,
    /// Squared distance to the minimum of the quadratic there, in its standard errors.
    pub(super) decrement: f64,
}

/// Where a descent starts, and what it may take for granted.
pub(super) struct Start {
    pub(super) at: Evaluation,
    /// Slopes of a place nearby, of all numbers that are not frozen.
    pub(super) slopes: Option<DMatrix<f64>>,
    pub(super) exactness: Exactness,
}

/// How near to the minimum a descent ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Exactness {
    /// What is left to fall is small beside the fall.
    Rough,
    /// Within a standard error of it, which is enough for numbers that mean little alone.
    Mixture,
    /// The sum is as good as the smallest.
    Sum,
    /// So is the place, and slopes were worked out within a standard error of it.
    Estimates,
}

impl Exactness {
    /// What may be left to fall after a fall, in squared standard errors.
    pub(super) fn near(self, fall: f64) -> f64 {
        match self {
            Self::Rough => SETTLED.max(BRIEFLY * fall),
            Self::Mixture => NEAR_BY.max(ROUGHLY * fall),
            Self::Sum => SETTLED,
            Self::Estimates => CONVERGED,
        }
    }
}

/// The quadratic at a place.
struct Quadratic {
    moved: Vec<usize>,
    slopes: DMatrix<f64>,
    weights: DVector<f64>,
    curvature: DMatrix<f64>,
    /// −½ its slope.
    pull: DVector<f64>,
    decrement: f64,
}

/// Steps that a brief descent goes down.
pub(super) const BRIEF: usize = 12;
const MAX_ITERATIONS: usize = 200;
/// A thirtieth of a standard error: predictions are hardly smooth on a finer scale.
const CONVERGED: f64 = 1e-3;
/// The same where the sum alone counts, of which a difference of [`APART`](crate::cut_offs::APART) is the least
/// that matters; it is near enough wherever no step leads down.
const SETTLED: f64 = 0.2;
/// Where no step leads further down, a fifth of a standard error is near enough: predictions jump a
/// little where pushes come to slide or let go. What is left widens the errors of the estimates.
const STUCK: f64 = 0.04;
/// Where slopes over standard errors lead no further either, places half of one away are tried along each axis of
/// the quadratic: at a kink a slope promises what no place keeps.
const POLL: f64 = 0.5;
/// Slopes that leave more than this of the distance are worked out anew.
const SLOW: f64 = 0.3;
/// Share of the fall so far that a brief or rough descent leaves to go.
const BRIEFLY: f64 = 0.01;
/// The same of a mixture.
const ROUGHLY: f64 = 1e-3;
/// Slopes worked out where this is left of the distance are those of the end: a standard error.
const NEAR_BY: f64 = 1.0;
/// Damping at first, and of slopes that were just worked out.
const DAMPING: f64 = 1e-3;
/// Damping at which a step is too short to matter.
const STIFFEST: f64 = 1e3;
/// Share of the promised fall that a step has to keep.
const KEPT: f64 = 1e-3;
/// The narrowest secant, in those of the coordinates.
const NARROWEST: f64 = 1e-4;

impl Problem<'_> {
    /// The minimum below a start.
    ///
    /// Slopes are secants as wide as the last step, at least as the standard error that the data
    /// leave the number when all others are known, and never wider than those of the coordinates.
    /// Between them they follow the predictions by Broyden's updates.
    ///
    /// # Errors
    /// `NotConverged`; `Flat`; what a prediction refuses at a place that was reached.
    pub(super) fn descend(&self, start: Start) -> Result<Minimum, DiagnosisError> {
        let Start { mut at, slopes: mut known, exactness } = start;
        let (mut widths, mut damping, mut last) = (self.secants.clone(), DAMPING, f64::INFINITY);
        let (first, is_final) = (at.value, exactness == Exactness::Estimates);
        let is_mixture = exactness == Exactness::Mixture;
        let mut is_enough = !is_final;
        // Whether slopes are taken over standard errors, where the last step does not need wider ones.
        let mut is_fitted = false;
        for iterations in 1..=MAX_ITERATIONS {
            let is_fresh = known.is_none();
            let whole = match known.take() {
                Some(known) => known,
                None => self.slopes(&at, &widths)?,
            };
            let quadratic = self.quadratic(&at, &whole)?;
            let decrement = quadratic.decrement;
            is_enough |= is_fresh && decrement < NEAR_BY;
            let fall = (first - at.value) / self.robust.scale().powi(2);
            let near = exactness.near(fall);
            let next = match decrement < near {
                true => None,
                false => self.step_down(&at, &quadratic, &mut damping),
            };
            if let Some(next) = next {
                self.fit_widths(&mut widths, &quadratic, &at, &next);
                let keeps = is_fresh || decrement < SLOW * last;
                known = keeps.then(|| updated(whole, &self.moved(), &widths, &at, &next));
                (at, last, is_fitted) = (next, decrement, false);
                continue;
            }
            let is_low = decrement < STUCK.max(near) || (is_fresh && !is_final);
            if is_enough && is_low && (is_fresh || !is_mixture) {
                return Ok(self.end(quadratic, at, whole, iterations));
            }
            if is_fresh && is_fitted {
                let Some(next) = self.poll(&at, &quadratic) else {
                    return Ok(self.end(quadratic.within(POLL), at, whole, iterations));
                };
                (at, last) = (next, f64::INFINITY);
            } else {
                self.fit_widths(&mut widths, &quadratic, &at, &at);
                is_fitted = true;
            }
            damping = DAMPING;
        }
        let (what, iterations) = ("the fit", MAX_ITERATIONS);
        let whole = self.slopes(&at, &widths)?;
        let quadratic = self.quadratic(&at, &whole)?;
        match quadratic.decrement {
            decrement if decrement < STUCK => Ok(self.end(quadratic, at, whole, iterations)),
            decrement => Err(DiagnosisError::NotConverged { what, iterations, decrement }),
        }
    }

    /// At most some steps down a start, with the slopes that are known there: near the minimum below
    /// it where it is a smooth one.
    ///
    /// # Errors
    /// `Flat`; what a prediction refuses.
    pub(super) fn descend_briefly(
        &self,
        start: Start,
        most_steps: usize,
    ) -> Result<Minimum, DiagnosisError> {
        let Start { mut at, slopes, .. } = start;
        let (mut widths, mut damping) = (self.secants.clone(), DAMPING);
        let mut whole = match slopes {
            Some(slopes) => slopes,
            None => self.slopes(&at, &widths)?,
        };
        let (mut steps, first) = (0, at.value);
        loop {
            let quadratic = self.quadratic(&at, &whole)?;
            let fall = first - at.value;
            let is_end = steps == most_steps || self.is_near(quadratic.decrement, fall);
            let next = match is_end {
                true => None,
                false => self.step_down(&at, &quadratic, &mut damping),
            };
            let Some(next) = next else { return Ok(self.end(quadratic, at, whole, steps)) };
            self.fit_widths(&mut widths, &quadratic, &at, &next);
            whole = updated(whole, &self.moved(), &widths, &at, &next);
            (at, steps) = (next, steps + 1);
        }
    }

    /// Slopes known at one place as they are at another, as far as the change between the two tells them.
    pub(super) fn carried(
        &self,
        slopes: DMatrix<f64>,
        from: &Evaluation,
        to: &Evaluation,
    ) -> DMatrix<f64> {
        updated(slopes, &self.moved(), &self.secants, from, to)
    }

    /// Whether little is left to fall beside the fall so far.
    pub(super) fn is_near(&self, decrement: f64, fall: f64) -> bool {
        decrement * self.robust.scale().powi(2) < STUCK.max(BRIEFLY * fall)
    }

    /// The quadratic at a place, over the numbers that do not press against a bound.
    fn quadratic(
        &self,
        at: &Evaluation,
        whole: &DMatrix<f64>,
    ) -> Result<Quadratic, DiagnosisError> {
        let weights = self.robust.weights(&at.z);
        let all = self.moved();
        let pull = whole.tr_mul(&at.z.component_mul(&weights));
        let is_free = |column: &usize| {
            let (x, (low, high)) = (at.x[all[*column]], self.ranges[all[*column]]);
            !(x <= low && pull[*column] < 0.0 || x >= high && pull[*column] > 0.0)
        };
        let columns: Vec<usize> = (0..all.len()).filter(is_free).collect();
        let (slopes, curvature) = curved(whole, &columns, &weights);
        let pull = pull.select_rows(&columns);
        let moved = columns.iter().map(|column| all[*column]).collect();
        let factor = curvature.clone().cholesky().ok_or(DiagnosisError::Flat)?;
        let decrement = pull.dot(&factor.solve(&pull)) / self.robust.scale().powi(2);
        Ok(Quadratic { moved, slopes, weights, curvature, pull, decrement })
    }

    /// A damped step that keeps some of its promise; none if only one too short to matter would.
    fn step_down(
        &self,
        from: &Evaluation,
        quadratic: &Quadratic,
        damping: &mut f64,
    ) -> Option<Evaluation> {
        let Quadratic { moved, curvature, pull, .. } = quadratic;
        while *damping < STIFFEST {
            let mut damped = curvature.clone();
            for k in 0..damped.nrows() {
                damped[(k, k)] *= 1.0 + *damping;
            }
            let step = damped.cholesky()?.solve(pull);
            let promise = 2.0 * step.dot(pull) - step.dot(&(curvature * &step));
            let mut x = from.x.clone();
            for (step, &k) in step.iter().zip(moved) {
                x[k] = (x[k] + step).clamp(self.ranges[k].0, self.ranges[k].1);
            }
            // A place that the mechanics refuse is no way down.
            if let Ok(next) = self.stand(x)
                && from.value - next.value > KEPT * promise
            {
                *damping = (*damping / 10.0).max(1e-12);
                return Some(next);
            }
            *damping *= 10.0;
        }
        None
    }

    /// The lowest place near by that is lower by more than a descent would stop at; none if no place
    /// is.
    fn poll(&self, from: &Evaluation, quadratic: &Quadratic) -> Option<Evaluation> {
        let Quadratic { moved, curvature, .. } = quadratic;
        // In standard errors that each number has when the others are known, so that units do not
        // matter.
        let units = curvature.diagonal().map(|curvature| curvature.sqrt().recip());
        let scaled = DMatrix::from_fn(moved.len(), moved.len(), |row, column| {
            units[row] * curvature[(row, column)] * units[column]
        });
        let axes = scaled.symmetric_eigen();
        let enough = SETTLED * self.robust.scale().powi(2);
        let mut lowest: Option<Evaluation> = None;
        for (axis, stiffness) in axes.eigenvectors.column_iter().zip(&axes.eigenvalues) {
            let length = POLL * self.robust.scale() / stiffness.sqrt();
            for side in [-length, length] {
                let mut x = from.x.clone();
                for ((share, unit), &k) in axis.iter().zip(&units).zip(moved) {
                    x[k] = (x[k] + side * share * unit).clamp(self.ranges[k].0, self.ranges[k].1);
                }
                let least = lowest.as_ref().map_or(from.value - enough, |lowest| lowest.value);
                // A place that the mechanics refuse is no way down.
                lowest = self.stand(x).ok().filter(|next| next.value < least).or(lowest);
            }
        }
        lowest
    }

    /// Where a descent ends. A share at an end of its range is known as if it could go on, and its
    /// column is there with the others.
    fn end(
        &self,
        quadratic: Quadratic,
        at: Evaluation,
        whole: DMatrix<f64>,
        iterations: usize,
    ) -> Minimum {
        let Quadratic { mut moved, mut slopes, weights, mut curvature, mut pull, decrement } =
            quadratic;
        let all = self.moved();
        let is_kept = |column: &usize| self.shares[all[*column]] || moved.contains(&all[*column]);
        let columns: Vec<usize> = (0..all.len()).filter(is_kept).collect();
        if columns.len() > moved.len() {
            (slopes, curvature) = curved(&whole, &columns, &weights);
            let kept: Vec<usize> = columns.iter().map(|column| all[*column]).collect();
            let of = |k: &usize| moved.iter().position(|own| own == k).map_or(0.0, |own| pull[own]);
            pull = DVector::from_iterator(kept.len(), kept.iter().map(of));
            moved = kept;
        }
        Minimum { at, moved, slopes, weights, curvature, pull, whole, iterations, decrement }
    }

    fn fit_widths(&self, widths: &mut [f64], at: &Quadratic, from: &Evaluation, to: &Evaluation) {
        for (column, &k) in at.moved.iter().enumerate() {
            let least = self.robust.scale() / at.curvature[(column, column)].sqrt();
            let last = (to.x[k] - from.x[k]).abs();
            widths[k] = last.max(least).clamp(NARROWEST * self.secants[k], self.secants[k]);
        }
    }
}

impl Quadratic {
    /// The same, known to be no farther from the minimum than a number of standard errors.
    fn within(self, standard_errors: f64) -> Self {
        Self { decrement: self.decrement.min(standard_errors.powi(2)), ..self }
    }
}

/// Some columns of slopes, and half the second derivatives by them.
fn curved(
    whole: &DMatrix<f64>,
    columns: &[usize],
    weights: &DVector<f64>,
) -> (DMatrix<f64>, DMatrix<f64>) {
    let slopes = whole.select_columns(columns);
    let curvature = curvature(&slopes, weights);
    (slopes, curvature)
}

/// Half the second derivatives by slopes.
pub(super) fn curvature(slopes: &DMatrix<f64>, weights: &DVector<f64>) -> DMatrix<f64> {
    let mut weighted = slopes.clone();
    for (mut row, weight) in weighted.row_iter_mut().zip(weights) {
        row *= *weight;
    }
    slopes.tr_mul(&weighted)
}

/// The slopes nearest to those known, in numbers over their widths, that give what a step changed.
///
/// # Source
/// Broyden (1965), A class of methods for solving nonlinear simultaneous equations, Mathematics of
/// Computation 19.
fn updated(
    mut slopes: DMatrix<f64>,
    moved: &[usize],
    widths: &[f64],
    from: &Evaluation,
    to: &Evaluation,
) -> DMatrix<f64> {
    let step = |k: &usize| to.x[*k] - from.x[*k];
    let step = DVector::from_iterator(moved.len(), moved.iter().map(step));
    let scaled = DVector::from_iterator(
        moved.len(),
        moved.iter().zip(&step).map(|(k, step)| step / widths[*k].powi(2)),
    );
    let square = scaled.dot(&step);
    if square > 0.0 {
        let missed = &to.z - &from.z + &slopes * &step;
        slopes.ger(-1.0 / square, &missed, &scaled, 1.0);
    }
    slopes
}
