//! How the errors of the three outputs go together, and what a density that knows it gains.

use anyhow::{Context, Result};
use models::{Noise, PushModel, StepObservation};
use nalgebra::{Matrix3, Vector3};

/// What is left to a joint model of the outputs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct JointOutputs {
    /// Of the errors of Δx and Δy, Δx and Δθ, Δy and Δθ.
    pub correlations: [f64; 3],
    /// Log density of unseen steps gained by knowing them, in nats a step.
    pub gain: f64,
}

impl JointOutputs {
    /// Of a model's errors on steps that it has not seen.
    pub(crate) fn of(model: &dyn PushModel, test: &[StepObservation]) -> Result<Self> {
        let inputs: Vec<_> = test.iter().map(|step| step.input.clone()).collect();
        let predictions = model.predict(&inputs, Noise::Included)?;
        let standardized = test.iter().zip(&predictions).map(|(step, at)| {
            (step.outputs - at.mean).zip_map(&at.covariance.diagonal(), |e, v| e / v.sqrt())
        });
        Self::of_errors(&standardized.collect::<Vec<_>>())
    }

    /// Of errors over their predicted standard deviations. Each half of them is judged with the
    /// second moments of the other, with and without what is off the diagonal.
    fn of_errors(errors: &[Vector3<f64>]) -> Result<Self> {
        let (one, two) = errors.split_at(errors.len() / 2);
        let gain = (gain(&moments(one), two)? + gain(&moments(two), one)?) / 2.0;
        let all = moments(errors);
        let correlation = |i: usize, j: usize| all[(i, j)] / (all[(i, i)] * all[(j, j)]).sqrt();
        Ok(Self { correlations: [correlation(0, 1), correlation(0, 2), correlation(1, 2)], gain })
    }
}

fn moments(errors: &[Vector3<f64>]) -> Matrix3<f64> {
    errors.iter().map(|error| error * error.transpose()).sum::<Matrix3<f64>>() / errors.len() as f64
}

/// Mean of ln N(e | 0, S) − ln N(e | 0, diag S), in nats.
fn gain(moments: &Matrix3<f64>, errors: &[Vector3<f64>]) -> Result<f64> {
    let inverse = moments.try_inverse().context("the errors of the outputs are dependent")?;
    let diagonal = moments.diagonal();
    let determinants = (diagonal.product() / moments.determinant()).ln();
    let square = |error: &Vector3<f64>| {
        let alone: f64 = error.component_mul(error).component_div(&diagonal).sum();
        alone - error.dot(&(inverse * error))
    };
    let squares = errors.iter().map(square).sum::<f64>() / errors.len() as f64;
    Ok(0.5 * (determinants + squares))
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Vector3};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    use super::JointOutputs;

    /// Errors with a correlation of Δx and Δθ.
    fn errors(correlation: f64) -> Vec<Vector3<f64>> {
        let mut covariance = Matrix3::from_diagonal(&Vector3::new(1.0, 4.0, 0.25));
        covariance[(0, 2)] = 0.5 * correlation;
        covariance[(2, 0)] = 0.5 * correlation;
        let root = covariance.cholesky().unwrap().l();
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        (0..20_000).map(|_| root * Vector3::from_fn(|_, _| rng.sample(StandardNormal))).collect()
    }

    #[test]
    fn the_gain_is_the_mutual_information_of_gaussian_errors() {
        for correlation in [0.0, 0.5, -0.8f64] {
            let joint = JointOutputs::of_errors(&errors(correlation)).unwrap();
            let expected = -0.5 * (1.0 - correlation * correlation).ln();
            assert!((joint.gain - expected).abs() < 0.01, "{} {expected}", joint.gain);
            let [xy, x_theta, y_theta] = joint.correlations;
            assert!(
                (x_theta - correlation).abs() < 0.02 && xy.abs() < 0.02 && y_theta.abs() < 0.02
            );
        }
    }
}
