//! Fitting the analytical model's parameters to observed steps.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use crate::least_squares::least_squares;
use crate::{
    Analytical, CharacteristicLength, Estimate, ModelError, OUTPUTS, StepInput, StepObservation,
};

/// A fitted analytical model and how the fit ended.
#[derive(Clone, Debug)]
pub struct AnalyticalFit {
    /// The model with μp and c, their standard errors, and the scatter of the residuals.
    pub model: Analytical,
    /// Correlation of the estimates of μp and c.
    pub correlation: f64,
    /// Iterations of the least-squares solver.
    pub iterations: usize,
    /// Largest cosine between the residual and a parameter's influence: 0 at a minimum.
    pub gradient: f64,
}

impl Analytical {
    /// Fits μp and c to observed steps of one object, starting from this model.
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
        let start_friction = self.pusher_friction().value.max(1e-3);
        let start = vec![start_friction.ln(), self.characteristic_length(&steps[0].input).ln()];
        let fit = least_squares(&["mu_p", "c"], start, |x| {
            let model = candidate(x)?;
            let mut r = DVector::zeros(3 * steps.len());
            for (i, step) in steps.iter().enumerate() {
                let error = model.error(step)?.component_div(&scale);
                r.fixed_rows_mut::<3>(3 * i).copy_from(&error);
            }
            Ok(r)
        })?;
        let bare = candidate(&fit.parameters)?;
        let scatter = bare.scatter_of(steps)?;
        let estimate = |k: usize| {
            let value = f64::exp(fit.parameters[k]);
            let source = format!("least squares on {} steps", steps.len());
            Estimate { value, se: value * fit.covariance[(k, k)].sqrt(), source }
        };
        let length = CharacteristicLength::Given(estimate(1));
        Ok(AnalyticalFit {
            model: Self::new(estimate(0), length, scatter)?,
            correlation: correlation(&fit.covariance),
            iterations: fit.iterations,
            gradient: fit.gradient,
        })
    }

    /// Observed less predicted outputs.
    pub(crate) fn error(&self, step: &StepObservation) -> Result<Vector3<f64>, ModelError> {
        Ok(step.outputs - self.outputs(&step.input)?)
    }

    /// (Δx, Δy, Δθ) of a step.
    pub(crate) fn outputs(&self, step: &StepInput) -> Result<Vector3<f64>, ModelError> {
        Ok(step.outputs(&self.motion(step)?))
    }

    /// Mean of e eᵀ/d² over the steps, with two degrees of freedom taken by the parameters.
    fn scatter_of(&self, steps: &[StepObservation]) -> Result<Matrix3<f64>, ModelError> {
        let mut sum = Matrix3::zeros();
        for step in steps {
            let error = self.error(step)? / step.input.distance();
            sum += error * error.transpose();
        }
        Ok(sum / (steps.len() - 2) as f64)
    }
}

/// The model with parameters (ln μp, ln c).
fn candidate(x: &[f64]) -> Result<Analytical, ModelError> {
    let exact = |x: f64| Estimate::exact(x.exp(), "trial");
    let length = CharacteristicLength::Given(exact(x[1]));
    Analytical::new(exact(x[0]), length, Matrix3::zeros())
}

/// The standard deviation of each output over the steps.
fn output_sd(steps: &[StepObservation]) -> Result<Vector3<f64>, ModelError> {
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
    covariance[(0, 1)] / (covariance[(0, 0)] * covariance[(1, 1)]).sqrt()
}
