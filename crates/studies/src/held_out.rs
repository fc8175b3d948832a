//! Random splits of steps into training and held-out ones, and a model's scores on the latter.

use anyhow::Result;
use gp_core::scores::{coverage, nlpd, nmse};
use models::{Noise, OUTPUTS, PushModel, StepInput, StepObservation};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

/// The levels of the intervals whose coverage is scored.
pub(crate) const LEVELS: [f64; 3] = [0.5, 0.9, 0.95];
/// The place of 95 % among them.
pub(crate) const LEVEL_95: usize = 2;

/// The steps in the random order of split number `split`.
pub(crate) fn shuffled(steps: &[StepObservation], seed: u64, split: u64) -> Vec<StepObservation> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    rng.set_stream(split);
    let mut shuffled = steps.to_vec();
    shuffled.shuffle(&mut rng);
    shuffled
}

/// Steps that no model of a split has seen.
pub(crate) struct HeldOut {
    inputs: Vec<StepInput>,
    outputs: [Vec<f64>; 3],
}

/// How well one output is predicted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Score {
    /// Squared error over the output's variance.
    pub(crate) nmse: f64,
    /// Mean negative log predictive density, in nats.
    pub(crate) nlpd: f64,
    /// Share of observations inside the intervals of [`LEVELS`].
    pub(crate) coverage: [f64; 3],
}

/// How well a model predicts Δx, Δy and Δθ of held-out steps (densities of m, m and rad).
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scores(pub(crate) [Score; 3]);

impl Score {
    /// Of Gaussian predictions.
    pub(crate) fn of(observed: &[f64], mean: &[f64], variance: &[f64]) -> Result<Self> {
        let mut inside = [0.0; 3];
        inside.copy_from_slice(&coverage(observed, mean, variance, &LEVELS)?);
        let (nmse, nlpd) = (nmse(observed, mean)?, nlpd(observed, mean, variance)?);
        Ok(Self { nmse, nlpd, coverage: inside })
    }
}

impl Scores {
    /// The mean over the outputs.
    pub(crate) fn mean(&self, value: impl Fn(&Score) -> f64) -> f64 {
        self.0.iter().map(value).sum::<f64>() / OUTPUTS.len() as f64
    }

    /// Squared error over variance, mean over the outputs.
    pub(crate) fn nmse(&self) -> f64 {
        self.mean(|score| score.nmse)
    }
}

impl HeldOut {
    pub(crate) fn new(steps: &[StepObservation]) -> Self {
        let output = |k: usize| steps.iter().map(|step| step.outputs[k]).collect();
        Self {
            inputs: steps.iter().map(|step| step.input.clone()).collect(),
            outputs: [output(0), output(1), output(2)],
        }
    }

    /// Squared error over variance, mean over the outputs; also for models without scatter.
    pub(crate) fn nmse(&self, model: &dyn PushModel) -> Result<f64> {
        let predictions = model.predict(&self.inputs, Noise::Excluded)?;
        let mut sum = 0.0;
        for (k, observed) in self.outputs.iter().enumerate() {
            let mean: Vec<f64> = predictions.iter().map(|prediction| prediction.mean[k]).collect();
            sum += nmse(observed, &mean)?;
        }
        Ok(sum / OUTPUTS.len() as f64)
    }

    /// All scores of a model that predicts a scatter.
    pub(crate) fn scores(&self, model: &dyn PushModel) -> Result<Scores> {
        let predictions = model.predict(&self.inputs, Noise::Included)?;
        let score = |k: usize| {
            let mean: Vec<f64> = predictions.iter().map(|prediction| prediction.mean[k]).collect();
            let variance: Vec<f64> =
                predictions.iter().map(|prediction| prediction.covariance[(k, k)]).collect();
            Score::of(&self.outputs[k], &mean, &variance)
        };
        Ok(Scores([score(0)?, score(1)?, score(2)?]))
    }
}

/// The value below which a share of the values lies, linear between them; NaN of nothing.
pub(crate) fn quantile(mut values: Vec<f64>, share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let Some(last) = values.len().checked_sub(1) else { return f64::NAN };
    let place = share * last as f64;
    let (low, high) = (values[place.floor() as usize], values[place.ceil() as usize]);
    low + place.fract() * (high - low)
}

#[cfg(test)]
mod tests {
    use super::{HeldOut, quantile, shuffled};
    use models::{Analytical, CharacteristicLength, Estimate, StepInput, StepObservation};
    use nalgebra::{Matrix3, Vector3};
    use planar::Shape;
    use std::sync::Arc;

    #[test]
    fn quantiles_are_linear_between_the_values() {
        assert_eq!(quantile(vec![3.0, 1.0, 2.0], 0.5), 2.0);
        assert_eq!(quantile(vec![4.0, 1.0, 2.0, 3.0], 0.5), 2.5);
        assert_eq!(quantile(vec![4.0, 0.0], 0.25), 1.0);
        assert!(quantile(Vec::new(), 0.5).is_nan());
    }

    fn steps(model: &Analytical) -> Vec<StepObservation> {
        let shape = Arc::new(Shape::square(0.09).unwrap());
        let step = |k: usize| {
            let (p, beta) = (0.05 + 0.009 * k as f64, ((7 * k) % 11) as f64 / 10.0 - 0.5);
            let input = StepInput::on_edge(shape.clone(), 0.005, 1, p, beta, 0.004).unwrap();
            let moved = input.outputs(&model.motion(&input).unwrap());
            StepObservation { input, outputs: moved + Vector3::new(1e-5, 0.0, 0.0) }
        };
        (0..100).map(step).collect()
    }

    #[test]
    fn a_known_error_and_a_known_scatter_give_known_scores() {
        let friction = Estimate::exact(0.25, "test");
        // 1e-5 m over a way of 4 mm is 1.5 standard deviations: outside of half, inside of 90 %.
        let sd = 1e-5 / 0.004 / 1.5;
        let model = Analytical::new(
            friction,
            CharacteristicLength::UniformPressure,
            Matrix3::identity() * sd * sd,
        )
        .unwrap();
        let steps = steps(&model);
        let scores = HeldOut::new(&steps).scores(&model).unwrap();
        assert_eq!(scores.0[0].coverage, [0.0, 1.0, 1.0]);
        assert_eq!(scores.0[2].coverage, [1.0, 1.0, 1.0]);
        let density =
            0.5 * 1.5f64.powi(2) + (sd * 0.004 * (2.0 * std::f64::consts::PI).sqrt()).ln();
        assert!((scores.0[0].nlpd - density).abs() < 1e-9, "{}", scores.0[0].nlpd);
        let nmse = HeldOut::new(&steps).nmse(&model).unwrap();
        assert!((scores.nmse() - nmse).abs() < 1e-15);
        assert!(nmse > 0.0 && nmse < 1e-3);
    }

    #[test]
    fn splits_differ_and_come_again() {
        let steps = steps(&Analytical::nominal(0.25).unwrap());
        let order =
            |split| shuffled(&steps, 1, split).iter().map(|s| s.input.p()).collect::<Vec<_>>();
        assert_eq!(order(3), order(3));
        assert_ne!(order(3), order(4));
        let mut sorted = order(3);
        sorted.sort_by(f64::total_cmp);
        assert_eq!(sorted, steps.iter().map(|s| s.input.p()).collect::<Vec<_>>());
    }
}
