//! A sparse process as plain data that can be saved and loaded.

use std::sync::Arc;

use faer::Mat;
use gp_core::checks::{check_count, check_outputs, check_positive};
use gp_core::cholesky::factorize;
use gp_core::kernel::{check_kernel_and_inputs, fill_lower_gram};
use gp_core::triangle::inverse;
use gp_core::{GpError, KernelSpec, Monomials, saved_as};
use serde::{Deserialize, Serialize};

use crate::deviation::Deviation;
use crate::objective::PSEUDO_COVARIANCE;
use crate::reduction::reduction;
use crate::saved_rows::SparseRows;
use crate::{SparseGp, SparseSettings};

/// Everything from which `SparseGp::from_model` rebuilds the same predictions, bit for bit.
///
/// It holds about M(M + 1)/2 + M(D + 3) numbers, however many rows were learnt from.
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
    /// The constant mean, in the unit of the output; of a learnt polynomial its value at the center.
    pub mean: f64,
    /// Of a learnt polynomial, one a product of inputs.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub mean_coefficients: Vec<f64>,
    /// What inputs are counted from in those products.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub center: Vec<f64>,
    /// The objective, in nats.
    pub objective: f64,
    /// Pseudo-inputs, one row a vector.
    pub pseudo_inputs: Vec<Vec<f64>>,
    /// The weights of the mean, one a pseudo-input.
    pub weights: Vec<f64>,
    /// What a learnt constant mean leaves open; none of another.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deviation: Option<Deviation>,
    /// What a learnt polynomial leaves open, one a coefficient; none of another mean.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub deviations: Vec<Deviation>,
    /// The Cholesky factor of the whitened precision of the pseudo-outputs, lower triangle by rows.
    pub precision_factor: Vec<f64>,
    /// Sums over the rows, without which none can be added.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rows: Option<SparseRows>,
}

impl SparseGpModel {
    /// The version that this release writes; it reads 2 as well. Of version 1 it reads processes about a
    /// known mean; of those with a learnt one that version did not keep what the data leave open of it.
    pub const VERSION: u32 = 3;
}

impl SparseGpModel {
    /// What the mean is a sum of, and its deviations.
    fn learnt_mean(&self, m: usize, d: usize) -> Result<(Monomials, Vec<Deviation>), GpError> {
        let mean = self.settings.mean;
        let degree = mean.degree().unwrap_or(0);
        let zero = vec![0.0; d];
        check_outputs("center", &self.center, if degree > 0 { d } else { 0 })?;
        let monomials = Monomials::new(degree, if degree > 0 { &self.center } else { &zero });
        let check_function = |constant: f64, coefficients: &[f64], weights: &[f64]| {
            check_outputs("mean", &[constant], 1)?;
            check_outputs("coefficients of the mean", coefficients, monomials.count() - 1)?;
            check_outputs("weights", weights, m)
        };
        check_function(self.mean, &self.mean_coefficients, &self.weights)?;
        let deviations: Vec<Deviation> =
            self.deviation.iter().chain(&self.deviations).cloned().collect();
        check_count("deviations of the mean", mean.n_coefficients(d), deviations.len())?;
        for Deviation { constant, coefficients, weights } in &deviations {
            check_function(*constant, coefficients, weights)?;
        }
        Ok((monomials, deviations))
    }
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
        let is_constant = self.monomials.degree() == 0;
        let of_row = |a: usize| (0..=a).map(move |b| self.root[(a, b)]);
        Ok(SparseGpModel {
            version: SparseGpModel::VERSION,
            kernel: self.kernel().spec().ok_or_else(unknown)?,
            settings: self.settings(),
            noise_variance: self.noise_variance(),
            mean: self.mean.constant,
            mean_coefficients: self.mean.coefficients.clone(),
            center: if self.monomials.degree() > 0 {
                self.monomials.center().to_vec()
            } else {
                Vec::new()
            },
            objective: self.objective(),
            pseudo_inputs: (0..z.nrows()).map(row).collect(),
            weights: self.mean.weights.clone(),
            deviation: self.deviations.first().filter(|_| is_constant).cloned(),
            deviations: if is_constant { Vec::new() } else { self.deviations.clone() },
            precision_factor: (0..z.nrows()).flat_map(of_row).collect(),
            rows: self.sums.as_ref().map(|sums| SparseRows::new(sums, z.nrows())),
        })
    }

    /// The process that `to_model` described.
    ///
    /// # Errors
    /// `UnsupportedVersion`, `NoMeanUncertainty`; else as `fit`, since a file may have been edited.
    pub fn from_model(model: &SparseGpModel) -> Result<Self, GpError> {
        let (found, supported) = (model.version, SparseGpModel::VERSION);
        let mean = model.settings.mean;
        match found {
            1 if mean.degree().is_some() => return Err(GpError::NoMeanUncertainty { found }),
            1 | 2 | SparseGpModel::VERSION => {}
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
        let (monomials, deviations) = model.learnt_mean(m, d)?;
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
            mean: Deviation {
                constant: model.mean,
                coefficients: model.mean_coefficients.clone(),
                weights: model.weights.clone(),
            },
            deviations,
            sums: model
                .rows
                .as_ref()
                .map(|rows| rows.sums(&monomials, root.as_ref()))
                .transpose()?,
            monomials,
            reduction: reduction(factor_inverse.as_ref(), root_inverse.as_ref())?,
            factor_inverse,
            root_inverse,
            root,
            objective: model.objective,
            report: None,
        })
    }
}
