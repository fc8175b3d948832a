//! Fitting the physics of a hybrid: all its free parameters that the steps determine.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use crate::analytical::fit::output_sd;
use crate::analytical::least_squares::least_squares;
use crate::physics::{DIFFERENCE, Free, Physics};
use crate::{Analytical, ModelError, StepInput, StepObservation};

/// Fitted physics, and what a fit of it may move.
#[derive(Clone, Debug)]
pub(crate) struct PhysicsFit {
    pub(crate) physics: Physics,
    /// What was fitted, about where it ended.
    pub(crate) free: Vec<Free>,
    /// What the steps do not determine, and so was kept.
    pub(crate) kept: Vec<String>,
    /// Of the u of `free`.
    pub(crate) covariance: DMatrix<f64>,
    /// Standard deviation of each output over the steps: what errors are weighed by.
    pub(crate) output_sd: Vector3<f64>,
}

/// A parameter of which less than this share of its influence is its own is not fitted.
const LEAST_OWN: f64 = 1e-4;
/// Change of the outputs over their standard deviation for a unit of u that counts as none.
const NO_INFLUENCE: f64 = 1e-6;

impl Physics {
    /// Minimises the sum over the outputs of squared error over that output's variance.
    ///
    /// # Errors
    /// `TooFewSteps` where steps are not twice the parameters or below four; `ConstantOutput`,
    /// `NotConverged`; those of a prediction.
    pub(crate) fn fit(&self, steps: &[StepObservation]) -> Result<PhysicsFit, ModelError> {
        let inputs: Vec<&StepInput> = steps.iter().map(|step| &step.input).collect();
        let first = inputs.first().ok_or_else(|| too_few(0, FEWEST))?;
        let all = self.free(first)?;
        let needed = FEWEST.max(2 * all.len());
        if steps.len() < needed {
            return Err(too_few(steps.len(), needed));
        }
        let output_sd = output_sd(steps)?;
        let slopes = weighed(&self.jacobian(&all, &inputs)?, &output_sd);
        let own = determined(&slopes);
        let (free, kept): (Vec<_>, Vec<_>) =
            all.into_iter().enumerate().partition(|(k, _)| own.contains(k));
        let free: Vec<Free> = free.into_iter().map(|(_, free)| free).collect();
        let labels: Vec<_> = free.iter().map(|free| free.label).collect();
        let fit = least_squares(&labels, vec![0.0; free.len()], DIFFERENCE, |u| {
            let errors = self.moved(&free, u)?.errors(steps)?;
            let scaled = errors.iter().flat_map(|e| e.component_div(&output_sd).data.0[0]);
            Ok(DVector::from_iterator(3 * steps.len(), scaled))
        })?;
        let moved = self.moved(&free, &fit.parameters)?;
        let sd: Vec<f64> = fit.covariance.diagonal().iter().map(|v| v.sqrt()).collect();
        let names: Vec<_> = free.iter().map(|free| free.name.clone()).collect();
        let there = moved.chosen(&names, first)?;
        let source = format!("least squares on {} steps", steps.len());
        let mut physics = moved.with_errors(&there, &sd, &source)?;
        physics.base = with_scatter(&physics, steps, free.len())?;
        Ok(PhysicsFit {
            free: physics.chosen(&names, first)?,
            physics,
            kept: kept.into_iter().map(|(_, free)| free.name).collect(),
            covariance: fit.covariance,
            output_sd,
        })
    }

    /// Observed less predicted outputs.
    pub(crate) fn errors(
        &self,
        steps: &[StepObservation],
    ) -> Result<Vec<Vector3<f64>>, ModelError> {
        let inputs: Vec<&StepInput> = steps.iter().map(|step| &step.input).collect();
        let predicted = self.outputs(&inputs)?;
        Ok(steps.iter().zip(predicted).map(|(step, predicted)| step.outputs - predicted).collect())
    }

    /// The free parameters of these names, in their order, as far as there are such.
    pub(crate) fn chosen(
        &self,
        names: &[String],
        step: &StepInput,
    ) -> Result<Vec<Free>, ModelError> {
        let free = self.free(step)?;
        let of = |name: &String| free.iter().find(|free| free.name == *name).cloned();
        Ok(names.iter().filter_map(of).collect())
    }
}

const FEWEST: usize = 4;

fn too_few(actual: usize, needed: usize) -> ModelError {
    ModelError::TooFewSteps { what: "the physics of a hybrid", needed, actual }
}

/// Slopes over the outputs' standard deviations: a row for each output of each step.
pub(crate) fn weighed(slopes: &[Vec<Vector3<f64>>], output_sd: &Vector3<f64>) -> DMatrix<f64> {
    let n_rows = slopes.first().map_or(0, |column| 3 * column.len());
    DMatrix::from_fn(n_rows, slopes.len(), |row, k| {
        slopes[k][row / 3][row % 3] / output_sd[row % 3]
    })
}

/// The columns that have an influence of their own, by Gram–Schmidt with pivoting.
fn determined(columns: &DMatrix<f64>) -> Vec<usize> {
    let mut rest = columns.clone();
    let least = NO_INFLUENCE * (columns.nrows() as f64).sqrt();
    let whole: Vec<f64> = columns.column_iter().map(|column| column.norm()).collect();
    let mut own: Vec<usize> = Vec::new();
    loop {
        let left = |k: &usize| {
            let norm = rest.column(*k).norm();
            whole[*k] > least && !own.contains(k) && norm.powi(2) > LEAST_OWN * whole[*k].powi(2)
        };
        let share = |k: &usize| rest.column(*k).norm() / whole[*k];
        let candidates = (0..columns.ncols()).filter(left);
        let Some(pivot) = candidates.max_by(|a, b| share(a).total_cmp(&share(b))) else {
            own.sort_unstable();
            return own;
        };
        let direction = rest.column(pivot).normalize();
        for mut column in rest.column_iter_mut() {
            let along = column.dot(&direction);
            column.axpy(-along, &direction, 1.0);
        }
        own.push(pivot);
    }
}

/// The base with the mean of e eᵀ/d² over the steps, with the degrees of freedom that the
/// parameters took.
fn with_scatter(
    physics: &Physics,
    steps: &[StepObservation],
    n_parameters: usize,
) -> Result<Analytical, ModelError> {
    let mut sum = Matrix3::zeros();
    for (step, error) in steps.iter().zip(physics.errors(steps)?) {
        let error = error / step.input.distance();
        sum += error * error.transpose();
    }
    let scatter = sum / (steps.len() - n_parameters) as f64;
    let base = &physics.base;
    Analytical::new(base.pusher_friction().clone(), base.length().clone(), scatter)?
        .with_surface(base.surface())
}
