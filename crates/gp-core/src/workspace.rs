//! Memory of predictions, and predictions in blocks of rows.

use std::cell::Cell;

use faer::{Mat, MatMut, MatRef};
use rayon::prelude::{IndexedParallelIterator, ParallelIterator, ParallelSliceMut};

use crate::GpError;
use crate::checks::check_count;

/// Matrices that predictions write their steps in, kept from one call to the next.
#[derive(Clone, Debug)]
pub struct Workspace {
    first: Mat<f64>,
    second: Mat<f64>,
}

impl Default for Workspace {
    fn default() -> Self {
        Self::new()
    }
}

impl Workspace {
    /// Nothing yet: the first prediction takes what it needs.
    pub const fn new() -> Self {
        Self { first: Mat::new(), second: Mat::new() }
    }

    /// Two matrices of a size, with whatever stood in them.
    pub fn matrices(
        &mut self,
        n_rows: usize,
        n_columns: usize,
    ) -> (MatMut<'_, f64>, MatMut<'_, f64>) {
        if self.first.nrows() < n_rows || self.first.ncols() < n_columns {
            let rows = n_rows.max(self.first.nrows());
            let columns = n_columns.max(self.first.ncols());
            self.first = Mat::zeros(rows, columns);
            self.second = Mat::zeros(rows, columns);
        }
        let Self { first, second } = self;
        (first.get_mut(..n_rows, ..n_columns), second.get_mut(..n_rows, ..n_columns))
    }
}

/// Means and variances of all rows, in blocks of which each is given to `predict` with a workspace
/// of its thread: the results do not depend on who computes which block.
pub fn predict_in_blocks(
    x_star: MatRef<'_, f64>,
    rows_of_block: usize,
    predict: impl Fn(MatRef<'_, f64>, &mut Workspace, &mut [f64], &mut [f64]) + Sync,
) -> (Vec<f64>, Vec<f64>) {
    let mut mean = vec![0.0; x_star.nrows()];
    let mut variance = vec![0.0; x_star.nrows()];
    let means = mean.par_chunks_mut(rows_of_block);
    let blocks = means.zip(variance.par_chunks_mut(rows_of_block)).enumerate();
    blocks.for_each(|(block, (mean, variance))| {
        // Taken and put back: while a product waits for its halves, this thread may take another block.
        let mut workspace = KEPT.take();
        let rows = x_star.subrows(block * rows_of_block, mean.len());
        predict(rows, &mut workspace, mean, variance);
        KEPT.set(workspace);
    });
    (mean, variance)
}

thread_local! {
    /// Of the last block of this thread.
    static KEPT: Cell<Workspace> = const { Cell::new(Workspace::new()) };
}

/// As [`predict_in_blocks`] on the calling thread, into memory that is there.
///
/// # Errors
/// `ShapeMismatch` if there is not one mean and one variance a row.
pub fn predict_blocks_into(
    x_star: MatRef<'_, f64>,
    rows_of_block: usize,
    workspace: &mut Workspace,
    mean: &mut [f64],
    variance: &mut [f64],
    predict: impl Fn(MatRef<'_, f64>, &mut Workspace, &mut [f64], &mut [f64]),
) -> Result<(), GpError> {
    check_count("means", x_star.nrows(), mean.len())?;
    check_count("variances", x_star.nrows(), variance.len())?;
    let blocks = mean.chunks_mut(rows_of_block).zip(variance.chunks_mut(rows_of_block));
    for (block, (mean, variance)) in blocks.enumerate() {
        let rows = x_star.subrows(block * rows_of_block, mean.len());
        predict(rows, workspace, mean, variance);
    }
    Ok(())
}
