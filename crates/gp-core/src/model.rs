//! A trained Gaussian process as plain data that can be saved and loaded.

use std::sync::Arc;

use faer::Mat;
use serde::{Deserialize, Serialize};

use crate::checks::check_count;
use crate::noise::Noise;
use crate::saved_as;
use crate::{Gp, GpError, Kernel, KernelSpec, Mean};

/// Everything from which `Gp::from_model` rebuilds the same predictions, bit for bit.
///
/// The factorisation is not stored: it follows from the rest in O(N³).
/// A text format has to keep all digits (with `serde_json`: its feature `float_roundtrip`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GpModel {
    /// Version of this format.
    pub version: u32,
    /// The kernel with its parameters.
    pub kernel: KernelSpec,
    /// Noise variance, in the squared unit of the output.
    pub noise_variance: f64,
    /// The constant mean; an estimated one is estimated again.
    pub mean: Mean,
    /// Training inputs, one row a vector.
    pub inputs: Vec<Vec<f64>>,
    /// Training outputs.
    pub outputs: Vec<f64>,
    /// Known noise variance of each row beside the common one; empty if there is none.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub row_noise: Vec<f64>,
}

impl GpModel {
    /// The version that this release writes and reads.
    pub const VERSION: u32 = 1;
}

impl Gp {
    /// The process as plain data.
    ///
    /// # Errors
    /// `NotSerializable` for a user's kernel without a `KernelSpec`.
    pub fn to_model(&self) -> Result<GpModel, GpError> {
        let unknown = || GpError::NotSerializable { kernel: format!("{:?}", self.kernel()) };
        let x = self.inputs();
        let row = |i: usize| (0..x.ncols()).map(|d| x[(i, d)]).collect();
        Ok(GpModel {
            version: GpModel::VERSION,
            kernel: self.kernel().spec().ok_or_else(unknown)?,
            noise_variance: self.noise_variance(),
            mean: self.mean_choice(),
            inputs: (0..x.nrows()).map(row).collect(),
            outputs: self.outputs().to_vec(),
            row_noise: self.row_noise().to_vec(),
        })
    }

    /// The process that `to_model` described.
    ///
    /// # Errors
    /// `UnsupportedVersion`; else as `fit`, since a file may have been edited.
    pub fn from_model(model: &GpModel) -> Result<Self, GpError> {
        if model.version != GpModel::VERSION {
            let supported = GpModel::VERSION;
            return Err(GpError::UnsupportedVersion { found: model.version, supported });
        }
        let kernel: Arc<dyn Kernel> = Arc::from(model.kernel.build());
        let x = matrix(&model.inputs)?;
        if !model.row_noise.is_empty() {
            check_count("row noise", model.outputs.len(), model.row_noise.len())?;
        }
        let noise = Noise { common: model.noise_variance, of_rows: &model.row_noise };
        Self::condition(kernel, x.as_ref(), &model.outputs, noise, model.mean)
    }
}

saved_as!(Gp => GpModel, Gp::to_model);

/// Rows of inputs as a matrix.
///
/// # Errors
/// `ShapeMismatch` for a row with another number of values than the first.
pub(crate) fn matrix(rows: &[Vec<f64>]) -> Result<Mat<f64>, GpError> {
    let n_inputs = rows.first().map_or(0, Vec::len);
    for row in rows {
        check_count("columns of the inputs", n_inputs, row.len())?;
    }
    Ok(Mat::from_fn(rows.len(), n_inputs, |i, d| rows[i][d]))
}
