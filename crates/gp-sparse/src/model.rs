//! A sparse process as plain data that can be saved and loaded.

use std::sync::Arc;

use faer::Mat;
use gp_core::checks::{check_count, check_outputs, check_positive};
use gp_core::cholesky::factorize;
use gp_core::kernel::{check_kernel_and_inputs, fill_lower_gram};
use gp_core::triangle::inverse;
use gp_core::{GpError, KernelSpec, saved_as};
use serde::{Deserialize, Serialize};

use crate::deviation::Deviation;
use crate::objective::PSEUDO_COVARIANCE;
use crate::reduction::reduction;
use crate::{SparseGp, SparseSettings};

/// Everything from which `SparseGp::from_model` rebuilds the same predictions, bit for bit.
///
/// It holds M(M + 1)/2 + M(D + 1) numbers, however many rows were learnt from.
/// A text format has to keep all digits (with `serde_json`: its feature `float_roundtrip`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SparseGpModel {
    /// Version of this format.
    pub version: u32,
    /// The kernel with its parameters.
    pub kernel: KernelSpec,
    /// The approximation, the choice of the mean, and the jitter.
    pub settings: SparseSettings,
    /// Noise variance, in the squared unit of the output.
    pub noise_variance: f64,
    /// The constant mean, in the unit of the output.
    pub mean: f64,
    /// The objective, in nats.
    pub objective: f64,
    /// Pseudo-inputs, one row a vector.
    pub pseudo_inputs: Vec<Vec<f64>>,
    /// The weights of the mean, one a pseudo-input.
    pub weights: Vec<f64>,
    /// What a learnt mean leaves open; none of a known one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deviation: Option<Deviation>,
    /// The Cholesky factor of the whitened precision of the pseudo-outputs, lower triangle by rows.
    pub precision_factor: Vec<f64>,
}

impl SparseGpModel {
    /// The version that this release writes. Of version 1 it reads processes about a known mean; of
    /// those with a learnt one that version did not keep what the data leave open of it.
    pub const VERSION: u32 = 2;
}

saved_as!(SparseGp => SparseGpModel, SparseGp::to_model);

impl SparseGp {
    /// The process as plain data.
    ///
    /// # Errors
    /// `NotSerializable` for a user's kernel without a `KernelSpec`.
    pub fn to_model(&self) -> Result<SparseGpModel, GpError> {
        let unknown = || GpError::NotSerializable { kernel: format!("{:?}", self.kernel()) };
        let z = self.pseudo_inputs();
        let row = |a: usize| (0..z.ncols()).map(|d| z[(a, d)]).collect();
        let of_row = |a: usize| (0..=a).map(move |b| self.root[(a, b)]);
        Ok(SparseGpModel {
            version: SparseGpModel::VERSION,
            kernel: self.kernel().spec().ok_or_else(unknown)?,
            settings: self.settings(),
            noise_variance: self.noise_variance(),
            mean: self.mean(),
            objective: self.objective(),
            pseudo_inputs: (0..z.nrows()).map(row).collect(),
            weights: self.weights.clone(),
            deviation: self.deviation.clone(),
            precision_factor: (0..z.nrows()).flat_map(of_row).collect(),
        })
    }

    /// The process that `to_model` described.
    ///
    /// # Errors
    /// `UnsupportedVersion`, `NoMeanUncertainty`; else as `fit`, since a file may have been edited.
    pub fn from_model(model: &SparseGpModel) -> Result<Self, GpError> {
        let (found, supported) = (model.version, SparseGpModel::VERSION);
        let n_deviations = model.settings.mean.n_coefficients(0);
        match found {
            1 if n_deviations > 0 => return Err(GpError::NoMeanUncertainty { found }),
            1 | SparseGpModel::VERSION => {}
            _ => return Err(GpError::UnsupportedVersion { found, supported }),
        }
        let kernel = model.kernel.build();
        let m = model.pseudo_inputs.len();
        let d = model.pseudo_inputs.first().map_or(0, Vec::len);
        for row in &model.pseudo_inputs {
            check_count("columns of the pseudo-inputs", d, row.len())?;
        }
        let z = Mat::from_fn(m, d, |a, j| model.pseudo_inputs[a][j]);
        check_kernel_and_inputs(&*kernel, z.as_ref())?;
        model.settings.check()?;
        check_positive("noise variance", model.noise_variance)?;
        check_outputs("mean and objective", &[model.mean, model.objective], 2)?;
        check_outputs("weights", &model.weights, m)?;
        let deviations = model.deviation.as_slice();
        check_count("deviations of the mean", n_deviations, deviations.len())?;
        for Deviation { constant, weights } in deviations {
            check_outputs("deviation of the mean", &[*constant], 1)?;
            check_outputs("weights of the mean's deviation", weights, m)?;
        }
        check_outputs("precision factor", &model.precision_factor, m * (m + 1) / 2)?;
        let root = Mat::from_fn(m, m, |a, b| match b <= a {
            true => model.precision_factor[a * (a + 1) / 2 + b],
            false => 0.0,
        });
        for a in 0..m {
            check_positive("diagonal of the precision factor", root[(a, a)])?;
        }
        let mut factor = Mat::zeros(m, m);
        fill_lower_gram(&*kernel, z.as_ref(), &mut factor);
        for a in 0..m {
            factor[(a, a)] *= 1.0 + model.settings.jitter;
        }
        factorize(PSEUDO_COVARIANCE, factor.as_mut())?;
        let (factor_inverse, root_inverse) = (inverse(factor.as_ref()), inverse(root.as_ref()));
        Ok(Self {
            kernel: Arc::from(kernel),
            settings: model.settings,
            noise_variance: model.noise_variance,
            z,
            constant: model.mean,
            weights: model.weights.clone(),
            deviation: model.deviation.clone(),
            reduction: reduction(factor_inverse.as_ref(), root_inverse.as_ref())?,
            factor_inverse,
            root_inverse,
            root,
            objective: model.objective,
        })
    }
}
