//! Predictions in blocks of rows.

use std::cell::Cell;

use faer::MatRef;
use rayon::prelude::{IndexedParallelIterator, ParallelIterator, ParallelSliceMut};

use crate::checks::{check_count, check_inputs};
use crate::kernel::copy_row;
use crate::vector::add_multiple;
use crate::{GpError, Kernel, Posterior, Workspace};

/// A posterior of which each row is predicted by itself, some of them together.
pub trait PredictBlock: Posterior {
    /// Rows that are predicted together; what they are predicted to be does not depend on it.
    const ROWS: usize;

    /// Means and variances of the rows of a block, which are overwritten; the rows have been checked.
    fn predict_block(
        &self,
        x_star: MatRef<'_, f64>,
        workspace: &mut Workspace,
        mean: &mut [f64],
        variance: &mut [f64],
    );
}

/// Means and variances of all rows, in blocks: the results do not depend on who computes which block.
///
/// # Errors
/// As [`Posterior::predict`].
pub fn predict_in_blocks<P: PredictBlock>(
    posterior: &P,
    x_star: MatRef<'_, f64>,
) -> Result<(Vec<f64>, Vec<f64>), GpError> {
    check_inputs("inputs", x_star, posterior.n_inputs())?;
    let mut mean = vec![0.0; x_star.nrows()];
    let mut variance = vec![0.0; x_star.nrows()];
    let blocks = mean.par_chunks_mut(P::ROWS).zip(variance.par_chunks_mut(P::ROWS));
    blocks.enumerate().for_each(|(block, (mean, variance))| {
        // Taken and put back: while a product waits for its halves, this thread may take another block.
        let mut workspace = KEPT.take();
        let rows = x_star.subrows(block * P::ROWS, mean.len());
        posterior.predict_block(rows, &mut workspace, mean, variance);
        KEPT.set(workspace);
    });
    Ok((mean, variance))
}

thread_local! {
    /// Of the last block of this thread.
    static KEPT: Cell<Workspace> = const { Cell::new(Workspace::new()) };
}

/// As [`predict_in_blocks`] on the calling thread, into memory that is there.
///
/// # Errors
/// As [`Posterior::predict_into`].
pub fn predict_blocks_into<P: PredictBlock>(
    posterior: &P,
    x_star: MatRef<'_, f64>,
    workspace: &mut Workspace,
    mean: &mut [f64],
    variance: &mut [f64],
) -> Result<(), GpError> {
    check_inputs("inputs", x_star, posterior.n_inputs())?;
    check_count("means", x_star.nrows(), mean.len())?;
    check_count("variances", x_star.nrows(), variance.len())?;
    let blocks = mean.chunks_mut(P::ROWS).zip(variance.chunks_mut(P::ROWS));
    for (block, (mean, variance)) in blocks.enumerate() {
        let rows = x_star.subrows(block * P::ROWS, mean.len());
        posterior.predict_block(rows, workspace, mean, variance);
    }
    Ok(())
}

/// What `start` writes for each row x, plus Σⱼ wⱼ k(x, cⱼ) over the rows c of `centers`.
///
/// # Errors
/// As [`Posterior::predict_mean`].
pub fn mean_in_blocks(
    kernel: &dyn Kernel,
    x_star: MatRef<'_, f64>,
    (centers, weights): (MatRef<'_, f64>, &[f64]),
    start: impl Fn(MatRef<'_, f64>, &mut [f64]) + Sync,
) -> Result<Vec<f64>, GpError> {
    check_inputs("inputs", x_star, centers.ncols())?;
    let mut mean = vec![0.0; x_star.nrows()];
    mean.par_chunks_mut(MEANS).enumerate().for_each(|(block, mean)| {
        let rows = x_star.subrows(block * MEANS, mean.len());
        let (mut values, mut center) = (vec![0.0; mean.len()], vec![0.0; x_star.ncols()]);
        start(rows, mean);
        for (j, weight) in weights.iter().enumerate() {
            copy_row(centers, j, &mut center);
            kernel.column(rows, &center, &mut values);
            add_multiple(mean, *weight, &values);
        }
    });
    Ok(mean)
}

/// Rows of which the means alone are predicted together.
const MEANS: usize = 128;
