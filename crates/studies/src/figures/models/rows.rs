//! Steps as rows of numbers, for processes that are learnt by themselves.

use anyhow::Result;
use faer::Mat;
use gp_core::{Gp, LearnOptions, Posterior, SquaredExponential};
use models::{StepObservation, learn_options};

use crate::held_out::{Score, Scores};

/// Inputs (p, β), N×2, and the three outputs per meter of the pusher's way.
pub(crate) struct Rows {
    pub x: Mat<f64>,
    pub y: [Vec<f64>; 3],
}

/// A Gaussian process with its hyperparameters.
pub(crate) struct LearntGp {
    pub gp: Gp,
    /// The kernel as it was learnt.
    pub kernel: SquaredExponential,
}

impl Rows {
    pub(crate) fn of(steps: &[StepObservation]) -> Self {
        let inputs = steps.iter().map(|step| [step.input.p(), step.input.beta()]);
        let inputs: Vec<[f64; 2]> = inputs.collect();
        let output = |k: usize| {
            steps.iter().map(|step| step.outputs[k] / step.input.distance()).collect::<Vec<_>>()
        };
        Self {
            x: Mat::from_fn(inputs.len(), 2, |i, d| inputs[i][d]),
            y: [output(0), output(1), output(2)],
        }
    }

    /// The exact process of every output, with the prior of the pushing models.
    pub(crate) fn learn(&self) -> Result<[LearntGp; 3]> {
        let options = LearnOptions { n_starts: 2, ..learn_options() };
        let learn = |k: usize| {
            let unit = SquaredExponential::unit(2)?;
            let gp = Gp::builder(unit).options(options.clone()).fit(self.x.as_ref(), &self.y[k])?;
            // Two lengthscales, the signal variance, and the noise variance.
            let values: Vec<f64> = gp.hyperparameters().iter().map(|(_, value)| *value).collect();
            let [lengthscales @ .., signal, _] = &values[..] else {
                anyhow::bail!("a process without hyperparameters");
            };
            Ok(LearntGp { gp, kernel: SquaredExponential::new(lengthscales, *signal)? })
        };
        Ok([learn(0)?, learn(1)?, learn(2)?])
    }

    /// Scores of a process for each output, on these rows.
    pub(crate) fn scores(&self, processes: [&dyn Posterior; 3]) -> Result<Scores> {
        let score = |k: usize| {
            let (mean, variance) = processes[k].predict_observation(self.x.as_ref())?;
            Score::of(&self.y[k], &mean, &variance)
        };
        Ok(Scores([score(0)?, score(1)?, score(2)?]))
    }
}
