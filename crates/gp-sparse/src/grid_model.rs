//! A process on a grid as plain data that can be saved and loaded.

use std::sync::Arc;

use gp_core::checks::{check_count, check_not_negative, check_outputs, check_range};
use gp_core::kernel::check_kernel_and_inputs;
use gp_core::{GpError, KernelSpec, Mean, saved_as};
use serde::{Deserialize, Serialize};

use crate::GridGp;
use crate::grid::Grid;
use crate::grid_sums::GridSums;

/// Everything from which `GridGp::from_model` rebuilds the same predictions, bit for bit, in O(M³).
///
/// It holds about 7ᴰ M numbers, however many rows were learnt from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GridGpModel {
    /// Version of this format.
    pub version: u32,
    /// The kernel with its parameters.
    pub kernel: KernelSpec,
    /// Noise variance, in the squared unit of the output.
    pub noise_variance: f64,
    /// The mean; a learnt one is learnt again.
    pub mean: Mean,
    /// Variance of a noise on the nodes over their prior variance.
    pub jitter: f64,
    /// Where the first node of the whole grid stands, one an input.
    pub first: Vec<f64>,
    /// The distance of nodes, one an input.
    pub spacing: Vec<f64>,
    /// Nodes along each input.
    pub counts: Vec<usize>,
    /// Numbers on the whole grid of the nodes in use, the last input varying fastest.
    pub nodes: Vec<u32>,
    /// Number of rows.
    pub n_rows: usize,
    /// Subtracted from all outputs.
    pub origin: f64,
    /// Where each row of WᵀW starts among its entries, and where the last ends.
    pub starts: Vec<usize>,
    /// The columns of its entries.
    pub columns: Vec<u32>,
    /// Its entries.
    pub values: Vec<f64>,
    /// Wᵀy.
    pub of_y: Vec<f64>,
    /// yᵀy.
    pub y_y: f64,
}

impl GridGpModel {
    /// The version that this release writes and reads.
    pub const VERSION: u32 = 1;
}

saved_as!(GridGp => GridGpModel, GridGp::to_model);

impl GridGp {
    /// The process as plain data.
    ///
    /// # Errors
    /// `NotSerializable` for a user's kernel without a `KernelSpec`.
    pub fn to_model(&self) -> Result<GridGpModel, GpError> {
        let unknown = || GpError::NotSerializable { kernel: format!("{:?}", self.kernel()) };
        let (grid, sums) = (self.grid.clone(), self.sums.clone());
        Ok(GridGpModel {
            version: GridGpModel::VERSION,
            kernel: self.kernel().spec().ok_or_else(unknown)?,
            noise_variance: self.noise_variance(),
            mean: self.mean,
            jitter: self.jitter,
            first: grid.first,
            spacing: grid.spacing,
            counts: grid.counts,
            nodes: grid.nodes,
            n_rows: sums.n_rows,
            origin: sums.origin,
            starts: sums.starts,
            columns: sums.columns,
            values: sums.values,
            of_y: sums.of_y,
            y_y: sums.y_y,
        })
    }

    /// The process that `to_model` described.
    ///
    /// # Errors
    /// `UnsupportedVersion`; else as `fit`, since a file may have been edited.
    pub fn from_model(model: &GridGpModel) -> Result<Self, GpError> {
        if model.version != GridGpModel::VERSION {
            let (found, supported) = (model.version, GridGpModel::VERSION);
            return Err(GpError::UnsupportedVersion { found, supported });
        }
        model.mean.check()?;
        let degree = f64::from(model.mean.degree().unwrap_or(0));
        check_range("degree of the mean on a grid", degree, 0.0, 2.0)?;
        check_not_negative("jitter", model.jitter)?;
        let numbers = model.clone();
        check_outputs("first nodes of the grid", &model.first, model.first.len())?;
        let grid = Grid::saved(numbers.first, numbers.spacing, numbers.counts, numbers.nodes)?;
        let m = grid.n_nodes();
        check_outputs("sums of the outputs", &model.of_y, m)?;
        check_outputs("other sums", &[model.origin, model.y_y], 2)?;
        check_count("starts of the sums", m + 1, model.starts.len())?;
        let n = model.values.len();
        check_outputs("sums of the shares", &model.values, n)?;
        check_count("columns of the sums", n, model.columns.len())?;
        let rows = model.starts.is_sorted() && model.starts.last() == Some(&n);
        if !rows || model.columns.iter().any(|column| *column as usize >= m) {
            return Err(GpError::Incompatible { what: "nodes and sums of the model" });
        }
        let sums = GridSums {
            n_rows: model.n_rows,
            origin: model.origin,
            starts: numbers.starts,
            columns: numbers.columns,
            values: numbers.values,
            of_y: numbers.of_y,
            y_y: model.y_y,
        };
        let kernel = Arc::from(model.kernel.build());
        check_kernel_and_inputs(&*kernel, grid.positions().as_ref())?;
        Self::condition(kernel, model.noise_variance, (grid, sums), model.mean, model.jitter)
    }
}
