//! What is learnt beside the physics, and how it is kept from what the physics can explain.

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use crate::StepInput;

/// What makes the learnt part of a hybrid orthogonal to its fitted physics.
///
/// A process g learnt on the residuals of fitted physics f can still say what another value of a
/// fitted parameter would say. It is projected, as a function of the step x, to
///
/// h(x) = g(x) − J(x) γ,  γ = (JᵀWJ)⁻¹ JᵀW g(X),
///
/// so that JᵀW h(X) = 0 over the training steps X: J(x) are the slopes of the three outputs by the
/// fitted parameters, and W weighs each output by one over its variance, as the fit does. The fitted
/// parameters are then those of the physics that is nearest to what happens, whatever is learnt
/// beside it. Where g is added to J δ with a δ that nothing is known of, the projection changes only
/// what is called physics and what is not. Conditioning g on JᵀW g(X) = 0 instead would change its
/// covariance in other directions too, and would not go with sparse processes. The variance of g is
/// kept: over the training steps the projection can only lower its weighed mean.
///
/// # Source
/// Plumlee & Joseph, Orthogonal Gaussian process models (2018); Tuo & Wu, Efficient calibration for
/// imperfect computer models (2015); Hodges & Reich, Adding spatially-correlated errors can mess up
/// the fixed effect you love (2010).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OrthogonalDiscrepancy {
    /// The fitted parameters, such as `pusher-friction`; none where nothing is projected.
    pub parameters: Vec<String>,
    /// γ, in the unit that a fit moves each parameter by.
    pub taken: Vec<f64>,
    /// Covariance of the fitted parameters in these units, by rows.
    pub covariance: Vec<Vec<f64>>,
    /// Standard deviation of each observed output over the training steps, in m, m and rad.
    pub output_sd: [f64; 3],
    /// Mean of what the physics say over them, per meter of the pusher's way.
    pub physics_mean: [f64; 3],
    /// The shares of what was learnt over the training steps.
    pub unexplained: Unexplained,
}

/// The share of what was learnt in what a model says, from 0 to 1.
///
/// ⟨h²⟩/(⟨(f − f̄)²⟩ + ⟨h²⟩) with f what the physics say, f̄ its mean over the training steps, h what
/// was learnt, all per meter of the pusher's way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Unexplained {
    /// Of Δx.
    pub dx: f64,
    /// Of Δy.
    pub dy: f64,
    /// Of Δθ.
    pub dtheta: f64,
    /// Of all three, each square over the variance of its output.
    pub all: f64,
}

impl Unexplained {
    /// No physics.
    pub(crate) const ALL: Self = Self { dx: 1.0, dy: 1.0, dtheta: 1.0, all: 1.0 };
}

impl OrthogonalDiscrepancy {
    /// h of each step, of g and the slopes there.
    pub(crate) fn left(
        &self,
        learnt: &[Vector3<f64>],
        slopes: &[Vec<Vector3<f64>>],
    ) -> Vec<Vector3<f64>> {
        let taken = |i: usize| -> Vector3<f64> {
            slopes.iter().zip(&self.taken).map(|(column, taken)| column[i] * *taken).sum()
        };
        learnt.iter().enumerate().map(|(i, learnt)| learnt - taken(i)).collect()
    }

    /// What the uncertainty of the fitted parameters leaves open of step `i`.
    pub(crate) fn covariance_at(&self, slopes: &[Vec<Vector3<f64>>], i: usize) -> Matrix3<f64> {
        let mut sum = Matrix3::zeros();
        for (one, row) in slopes.iter().zip(&self.covariance) {
            for (other, covariance) in slopes.iter().zip(row) {
                sum += *covariance * one[i] * other[i].transpose();
            }
        }
        0.5 * (sum + sum.transpose())
    }

    /// The share of h in what is said of one step.
    pub(crate) fn share(
        &self,
        step: &StepInput,
        physics: &Vector3<f64>,
        left: &Vector3<f64>,
    ) -> f64 {
        let [physics, left] = self.squares(step, physics, left);
        share(physics.sum(), left.sum())
    }

    /// Squares of what the physics say about their mean, and of h, over the outputs' variances.
    fn squares(
        &self,
        step: &StepInput,
        physics: &Vector3<f64>,
        left: &Vector3<f64>,
    ) -> [Vector3<f64>; 2] {
        let about = physics / step.distance() - Vector3::from(self.physics_mean);
        let left = left / step.distance();
        [about, left].map(|value| {
            value.component_div(&Vector3::from(self.output_sd)).map(|value| value * value)
        })
    }

    pub(crate) fn measure(
        &mut self,
        steps: &[&StepInput],
        physics: &[Vector3<f64>],
        left: &[Vector3<f64>],
    ) {
        let per_meter = steps.iter().zip(physics).map(|(step, said)| said / step.distance());
        let sum: Vector3<f64> = per_meter.sum();
        self.physics_mean = (sum / steps.len() as f64).into();
        self.unexplained = self.unexplained_of(steps, physics, left);
    }

    /// The shares of h over some steps.
    pub(crate) fn unexplained_of(
        &self,
        steps: &[&StepInput],
        physics: &[Vector3<f64>],
        left: &[Vector3<f64>],
    ) -> Unexplained {
        let [mut of_physics, mut of_left] = [Vector3::zeros(); 2];
        for (i, step) in steps.iter().enumerate() {
            let [physics, left] = self.squares(step, &physics[i], &left[i]);
            of_physics += physics;
            of_left += left;
        }
        let [dx, dy, dtheta] = std::array::from_fn(|k| share(of_physics[k], of_left[k]));
        Unexplained { dx, dy, dtheta, all: share(of_physics.sum(), of_left.sum()) }
    }

    /// Whether the numbers belong together.
    pub(crate) fn is_sound(&self) -> bool {
        let n = self.parameters.len();
        let finite = |values: &[f64]| values.iter().all(|value| value.is_finite());
        self.taken.len() == n
            && self.covariance.len() == n
            && self.covariance.iter().all(|row| row.len() == n && finite(row))
            && finite(&self.taken)
            && finite(&self.physics_mean)
            && self.output_sd.iter().all(|sd| *sd > 0.0 && sd.is_finite())
    }
}

fn share(physics: f64, left: f64) -> f64 {
    if left > 0.0 { left / (physics + left) } else { 0.0 }
}
