//! Fitting the analytical model's parameters to observed steps.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use crate::analytical::least_squares::{SMALL, least_squares};
use crate::{
    Analytical, CharacteristicLength, Estimate, ModelError, OUTPUTS, StepObservation, SurfaceKind,
};

/// A fitted analytical model and how the fit ended.
#[derive(Clone, Debug)]
pub struct AnalyticalFit {
    /// The model with μp and c, their standard errors, and the scatter of the residuals.
    pub model: Analytical,
    /// Correlation of the estimates of μp and c; 0 where μp alone was fitted.
    pub correlation: f64,
    /// Iterations of the least-squares solver.
    pub iterations: usize,
    /// Largest cosine between the residual and a parameter's influence: 0 at a minimum.
    pub gradient: f64,
}

impl Analytical {
    /// Fits μp, and on an ellipsoid c, to observed steps of one object, starting from this model.
    ///
    /// Minimises the sum over the outputs of squared error over that output's variance. Standard
    /// errors come from the curvature there and take the errors for independent.
    ///
    /// # Errors
    /// `TooFewSteps` below four; `ConstantOutput`; `Undetermined` if no step slides (μp has no
    /// influence) or none turns; `NotConverged`; those of a prediction.
    pub fn fit(&self, steps: &[StepObservation]) -> Result<AnalyticalFit, ModelError> {
        let needed = 4;
        if steps.len() < needed {
            let (what, actual) = ("the analytical model", steps.len());
            return Err(ModelError::TooFewSteps { what, needed, actual });
        }
        let scale = output_sd(steps)?;
        let mut names = vec!["mu_p"];
        let mut start = vec![self.pusher_friction().value.max(1e-3).ln()];
        if self.surface() == SurfaceKind::Ellipsoid {
            names.push("c");
            start.push(self.characteristic_length(&steps[0].input).ln());
        }
        let fit = least_squares(&names, start, SMALL, |x| {
            let errors = self.candidate(x)?.errors(steps)?;
            let scaled = errors.iter().flat_map(|error| error.component_div(&scale).data.0[0]);
            Ok(DVector::from_iterator(3 * steps.len(), scaled))
        })?;
        let estimate = |k: usize| {
            let value = f64::exp(fit.parameters[k]);
            let source = format!("least squares on {} steps", steps.len());
            Estimate { value, se: value * fit.covariance[(k, k)].sqrt(), source }
        };
        let length = match names.len() {
            2 => CharacteristicLength::Given(estimate(1)),
            _ => CharacteristicLength::UniformPressure,
        };
        let errors = self.candidate(&fit.parameters)?.errors(steps)?;
        let scatter = scatter_per_way(steps, &errors, names.len());
        Ok(AnalyticalFit {
            model: Self::new(estimate(0), length, scatter)?.with_surface(self.surface())?,
            correlation: correlation(&fit.covariance),
            iterations: fit.iterations,
            gradient: fit.gradient,
        })
    }

    /// Observed less predicted outputs.
    pub(crate) fn errors(
        &self,
        steps: &[StepObservation],
    ) -> Result<Vec<Vector3<f64>>, ModelError> {
        let predicted = self.outputs(steps.iter().map(|step| &step.input))?;
        Ok(steps.iter().zip(predicted).map(|(step, predicted)| step.outputs - predicted).collect())
    }

    /// The model with parameters (ln μp, ln c), or ln μp alone.
    fn candidate(&self, x: &[f64]) -> Result<Self, ModelError> {
        let exact = |x: f64| Estimate::exact(x.exp(), "trial");
        let length = match x.get(1) {
            Some(&c) => CharacteristicLength::Given(exact(c)),
            None => CharacteristicLength::UniformPressure,
        };
        Self::new(exact(x[0]), length, Matrix3::zeros())?.with_surface(self.surface())
    }
}

/// Mean of e eᵀ/d² over steps and their errors, with the degrees of freedom that parameters took; d is the pusher's way.
pub(crate) fn scatter_per_way<'a>(
    steps: impl IntoIterator<Item = &'a StepObservation>,
    errors: &[Vector3<f64>],
    n_parameters: usize,
) -> Matrix3<f64> {
    let mut sum = Matrix3::zeros();
    for (step, error) in steps.into_iter().zip(errors) {
        let error = error / step.input.distance();
        sum += error * error.transpose();
    }
    sum / (errors.len() - n_parameters) as f64
}

/// The standard deviation of each output over the steps.
pub(crate) fn output_sd(steps: &[StepObservation]) -> Result<Vector3<f64>, ModelError> {
    let n = steps.len() as f64;
    let mean = steps.iter().map(|step| step.outputs).sum::<Vector3<f64>>() / n;
    let square = |step: &StepObservation| (step.outputs - mean).map(|x| x * x);
    let sd = (steps.iter().map(square).sum::<Vector3<f64>>() / n).map(f64::sqrt);
    match sd.iter().position(|sd| *sd == 0.0) {
        Some(k) => Err(ModelError::ConstantOutput { output: OUTPUTS[k], n_steps: steps.len() }),
        None => Ok(sd),
    }
}

fn correlation(covariance: &DMatrix<f64>) -> f64 {
    match covariance.nrows() {
        2 => covariance[(0, 1)] / (covariance[(0, 0)] * covariance[(1, 1)]).sqrt(),
        _ => 0.0,
    }
}
