//! Three independent Gaussian processes over the contact's place and the pusher's angle.

use faer::Mat;
use gp_core::{Gp, GpModel, LearnOptions, LearnReport, Posterior, SquaredExponential};
use nalgebra::{Matrix3, Vector3};

use crate::{ModelError, Noise, OUTPUTS, StepInput, StepPrediction, Weights};

/// One process an output, of inputs (p, β), for outputs per meter of the pusher's way.
///
/// A quasi-static push does not know time, and a short one is proportional to the way; what is
/// learnt at one step length thus serves others near it. Edges are folded into one.
#[derive(Clone, Debug)]
pub(crate) struct StepGps([Gp; 3]);

impl StepGps {
    /// Learns all hyperparameters from steps and their targets, in m, m and rad.
    pub(crate) fn learn(
        steps: &[&StepInput],
        targets: &[Vector3<f64>],
        options: &LearnOptions,
    ) -> Result<(Self, [LearnReport; 3]), ModelError> {
        let x = inputs(steps.iter().copied());
        let learn = |k: usize| {
            let rows = targets.iter().zip(steps);
            let y: Vec<f64> = rows.map(|(target, step)| target[k] / step.distance()).collect();
            SquaredExponential::new(&[1.0; 2], 1.0)
                .and_then(|kernel| Gp::learn(kernel, x.as_ref(), &y, options))
                .map_err(|source| ModelError::Gp { output: OUTPUTS[k], source })
        };
        let [(dx, report_x), (dy, report_y), (dtheta, report_theta)] =
            [learn(0)?, learn(1)?, learn(2)?];
        Ok((Self([dx, dy, dtheta]), [report_x, report_y, report_theta]))
    }

    /// The outputs' Gaussians, in m, m and rad.
    pub(crate) fn predict(
        &self,
        steps: &[StepInput],
        noise: Noise,
    ) -> Result<Vec<StepPrediction>, ModelError> {
        let zero = StepPrediction { mean: Vector3::zeros(), covariance: Matrix3::zeros() };
        let mut predictions = vec![zero; steps.len()];
        if steps.is_empty() {
            return Ok(predictions);
        }
        let x = inputs(steps.iter());
        for (k, gp) in self.0.iter().enumerate() {
            let (mean, variance) = match noise {
                Noise::Included => gp.predict_observation(x.as_ref()),
                Noise::Excluded => gp.predict(x.as_ref()),
            }
            .map_err(|source| ModelError::Gp { output: OUTPUTS[k], source })?;
            for (i, prediction) in predictions.iter_mut().enumerate() {
                let distance = steps[i].distance();
                prediction.mean[k] = mean[i] * distance;
                prediction.covariance[(k, k)] = variance[i] * distance * distance;
            }
        }
        Ok(predictions)
    }

    /// The processes as plain data.
    pub(crate) fn weights(&self) -> Result<Weights, ModelError> {
        let model = |k: usize| {
            self.0[k].to_model().map_err(|source| ModelError::Gp { output: OUTPUTS[k], source })
        };
        Ok(Weights {
            schema: Weights::SCHEMA.to_owned(),
            outputs: [model(0)?, model(1)?, model(2)?],
        })
    }

    /// The processes that `weights` described.
    pub(crate) fn from_weights(weights: &Weights) -> Result<Self, ModelError> {
        let build = |k: usize, model: &GpModel| {
            Gp::from_model(model).map_err(|source| ModelError::Gp { output: OUTPUTS[k], source })
        };
        let [dx, dy, dtheta] = &weights.outputs;
        Ok(Self([build(0, dx)?, build(1, dy)?, build(2, dtheta)?]))
    }
}

/// The inputs (p, β in rad), one row a step.
fn inputs<'a>(steps: impl ExactSizeIterator<Item = &'a StepInput>) -> Mat<f64> {
    let rows: Vec<[f64; 2]> = steps.map(|step| [step.p(), step.beta()]).collect();
    Mat::from_fn(rows.len(), 2, |i, d| rows[i][d])
}
