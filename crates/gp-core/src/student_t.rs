//! A Gaussian process whose noise has heavy tails, and its predictions.

use std::f64::consts::PI;
use std::sync::Arc;

use faer::MatRef;
use serde::{Deserialize, Serialize};

use crate::checks::{check_count, check_inputs, check_outputs, check_positive, check_range};
use crate::kernel::check_kernel_and_inputs;
use crate::model::matrix;
use crate::noise::Noise;
use crate::student_t_bound::{StudentTBound, Tails};
use crate::{Gp, GpError, JointGaussian, Kernel, KernelSpec, Mean, Posterior, saved_as};

/// y = f(x) + ε with f ~ GP(m, k) and ε of a Student t with scale σ and ν degrees of freedom,
/// conditioned on data: rows far from the others lose their influence.
///
/// The belief about f is the best Gaussian in the variational sense, which is a posterior under
/// Gaussian noise of its own variance a row. Among the ways to such a belief this one maximises a
/// lower bound of ln p(y), cannot fail as the iterations of expectation propagation can, and gives
/// every row a positive weight, which Laplace's approximation does not.
///
/// # Source
/// Tipping & Lawrence, Variational inference for Student-t models (2005).
#[derive(Clone, Debug)]
pub struct StudentTGp {
    /// The process with the noise of each row.
    gp: Gp,
    tails: Tails,
    bound: f64,
}

/// Everything from which `StudentTGp::from_model` rebuilds the same predictions, bit for bit.
///
/// A text format has to keep all digits (with `serde_json`: its feature `float_roundtrip`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StudentTGpModel {
    /// Version of this format.
    pub version: u32,
    /// The kernel with its parameters.
    pub kernel: KernelSpec,
    /// σ², in the squared unit of the output.
    pub scale_variance: f64,
    /// ν.
    pub degrees_of_freedom: f64,
    /// The mean; a learnt one is learnt again.
    pub mean: Mean,
    /// The bound of ln p(y | X), in nats.
    pub bound: f64,
    /// Training inputs, one row a vector.
    pub inputs: Vec<Vec<f64>>,
    /// Training outputs.
    pub outputs: Vec<f64>,
    /// The variance of the Gaussian noise that stands for each row's.
    pub row_noise: Vec<f64>,
}

impl StudentTGpModel {
    /// The version that this release writes and reads.
    pub const VERSION: u32 = 1;
}

impl StudentTGp {
    /// Conditions known parameters on data; O(N³) a visit, some ten of them.
    ///
    /// - `x`: inputs, N×D; `y`: outputs, N.
    /// - `scale_variance`: σ², positive, in the squared unit of the output.
    /// - `degrees_of_freedom`: ν above 2, so that the noise has a variance.
    ///
    /// # Errors
    /// `Empty`, `ShapeMismatch`, `NotFinite`, `NotPositive`, `OutOfRange`; `NotPositiveDefinite`;
    /// `NotConverged` if the belief does not settle.
    pub fn fit(
        kernel: impl Kernel + 'static,
        x: MatRef<'_, f64>,
        y: &[f64],
        scale_variance: f64,
        degrees_of_freedom: f64,
        mean: Mean,
    ) -> Result<Self, GpError> {
        check_kernel_and_inputs(&kernel, x)?;
        check_outputs("outputs", y, x.nrows())?;
        mean.check()?;
        let tails = Tails { scale_variance, degrees: degrees_of_freedom };
        check_tails(tails)?;
        Self::condition(Arc::new(kernel), x, y, tails, mean)
    }

    pub(crate) fn condition(
        kernel: Arc<dyn Kernel>,
        x: MatRef<'_, f64>,
        y: &[f64],
        tails: Tails,
        mean: Mean,
    ) -> Result<Self, GpError> {
        let mut bound = StudentTBound::new(x, y, mean);
        let value =
            bound.evaluate(&*kernel, tails, &mut vec![0.0; kernel.parameters().len() + 2])?;
        let row_noise = bound.noise();
        let noise = Noise { common: 0.0, of_rows: &row_noise };
        Ok(Self { gp: Gp::condition(kernel, x, y, noise, mean)?, tails, bound: value })
    }

    /// The kernel, with its parameters in the user's units.
    pub fn kernel(&self) -> &dyn Kernel {
        self.gp.kernel()
    }

    /// The squared scale σ² of the noise, in the squared unit of the output.
    pub fn scale_variance(&self) -> f64 {
        self.tails.scale_variance
    }

    /// The degrees of freedom ν of the noise: the fewer, the heavier its tails.
    pub fn degrees_of_freedom(&self) -> f64 {
        self.tails.degrees
    }

    /// The lower bound of ln p(y | X), in nats.
    pub fn bound(&self) -> f64 {
        self.bound
    }

    /// The variance of the Gaussian noise that stands for each row's: large for an outlier.
    pub fn row_noise(&self) -> &[f64] {
        self.gp.row_noise()
    }

    /// The process with that noise, which has the same belief about f.
    pub fn process(&self) -> &Gp {
        &self.gp
    }

    /// ln p(y*) of an observation at each row, in nats: the Student t about the uncertain f.
    ///
    /// `predict_observation` gives the same mean and variance, but a Gaussian of that variance has
    /// other tails. Integrated over the precision of the noise, by the trapezoidal rule on its
    /// logarithm.
    ///
    /// # Errors
    /// `Empty`, `ShapeMismatch` or `NotFinite` if `x_star` is not a finite M×D matrix or `y_star`
    /// does not hold M finite values.
    pub fn predict_log_density(
        &self,
        x_star: MatRef<'_, f64>,
        y_star: &[f64],
    ) -> Result<Vec<f64>, GpError> {
        let (mean, variance) = self.predict(x_star)?;
        check_outputs("outputs", y_star, x_star.nrows())?;
        let density = |((y, mean), variance): ((&f64, &f64), &f64)| {
            log_density(self.tails, (y - mean) * (y - mean), *variance)
        };
        Ok(y_star.iter().zip(&mean).zip(&variance).map(density).collect())
    }

    /// The process as plain data.
    ///
    /// # Errors
    /// `NotSerializable` for a user's kernel without a `KernelSpec`.
    pub fn to_model(&self) -> Result<StudentTGpModel, GpError> {
        let gp = self.gp.to_model()?;
        Ok(StudentTGpModel {
            version: StudentTGpModel::VERSION,
            kernel: gp.kernel,
            scale_variance: self.tails.scale_variance,
            degrees_of_freedom: self.tails.degrees,
            mean: gp.mean,
            bound: self.bound,
            inputs: gp.inputs,
            outputs: gp.outputs,
            row_noise: gp.row_noise,
        })
    }

    /// The process that `to_model` described.
    ///
    /// # Errors
    /// `UnsupportedVersion`; else what is wrong with an edited file.
    pub fn from_model(model: &StudentTGpModel) -> Result<Self, GpError> {
        if model.version != StudentTGpModel::VERSION {
            let supported = StudentTGpModel::VERSION;
            return Err(GpError::UnsupportedVersion { found: model.version, supported });
        }
        let tails =
            Tails { scale_variance: model.scale_variance, degrees: model.degrees_of_freedom };
        check_tails(tails)?;
        check_outputs("bound", &[model.bound], 1)?;
        check_count("row noise", model.outputs.len(), model.row_noise.len())?;
        for noise in &model.row_noise {
            check_positive("noise variance of a row", *noise)?;
        }
        let kernel = model.kernel.build();
        let x = matrix(&model.inputs)?;
        let noise = Noise { common: 0.0, of_rows: &model.row_noise };
        let gp = Gp::condition(Arc::from(kernel), x.as_ref(), &model.outputs, noise, model.mean)?;
        Ok(Self { gp, tails, bound: model.bound })
    }
}

saved_as!(StudentTGp => StudentTGpModel, StudentTGp::to_model);

impl Posterior for StudentTGp {
    fn n_inputs(&self) -> usize {
        self.gp.n_inputs()
    }

    fn predict_mean(&self, x_star: MatRef<'_, f64>) -> Result<Vec<f64>, GpError> {
        self.gp.predict_mean(x_star)
    }

    fn predict(&self, x_star: MatRef<'_, f64>) -> Result<(Vec<f64>, Vec<f64>), GpError> {
        self.gp.predict(x_star)
    }

    fn predict_joint(&self, x_star: MatRef<'_, f64>) -> Result<JointGaussian, GpError> {
        self.gp.predict_joint(x_star)
    }

    fn predict_noise(&self, x_star: MatRef<'_, f64>) -> Result<Vec<f64>, GpError> {
        check_inputs("inputs", x_star, self.n_inputs())?;
        let Tails { scale_variance, degrees } = self.tails;
        Ok(vec![scale_variance * degrees / (degrees - 2.0); x_star.nrows()])
    }
}

fn check_tails(tails: Tails) -> Result<(), GpError> {
    check_positive("scale variance of the noise", tails.scale_variance)?;
    check_range("degrees of freedom of the noise", tails.degrees, LEAST_DEGREES, f64::MAX)
}

/// The next number above 2.
const LEAST_DEGREES: f64 = 2.0 + 2.0 * f64::EPSILON;

/// ln ∫ N(e | 0, v + σ²/λ) Gamma(λ | ν/2, ν/2) dλ.
///
/// By u = ln λ the integrand is smooth. Between its mode without f's variance and u = 0 it has a
/// peak of width √(2/ν), which falls like e^(uν/2) on the left and faster on the right.
fn log_density(tails: Tails, square: f64, variance: f64) -> f64 {
    let half = 0.5 * tails.degrees;
    let width = half.sqrt().recip();
    let mode = (half + 0.5).ln() - (half + 0.5 * square / tails.scale_variance).ln();
    let left = mode.min(0.0) - 12.0 * width - 40.0 / half;
    let step = 0.125 * width.min(1.0);
    let n = ((12.0 * width - left) / step) as usize;
    let terms: Vec<f64> = (0..=n)
        .map(|i| {
            let u = left + i as f64 * step;
            let total = variance + tails.scale_variance * (-u).exp();
            half * (u - u.exp() + 1.0) - 0.5 * (square / total + total.ln())
        })
        .collect();
    let highest = terms.iter().fold(f64::NEG_INFINITY, |highest, term| highest.max(*term));
    let sum: f64 = terms.iter().map(|term| (term - highest).exp()).sum();
    let normalization = half * half.ln() - half - libm::lgamma(half) - 0.5 * (2.0 * PI).ln();
    highest + (step * sum).ln() + normalization
}

#[cfg(test)]
mod tests {
    use super::{Tails, log_density};

    #[test]
    fn the_density_about_a_certain_value_is_the_student_t() {
        for degrees in [2.1, 4.0, 30.0, 2000.0] {
            let tails = Tails { scale_variance: 0.3, degrees };
            for error in [0.0, 0.4, 3.0, 50.0] {
                let square = error * error;
                let (found, expected) =
                    (log_density(tails, square, 0.0), tails.log_density(square));
                assert!(
                    (found - expected).abs() < 1e-9 * (1.0 + expected.abs()),
                    "{found} {expected}"
                );
            }
        }
    }
}
