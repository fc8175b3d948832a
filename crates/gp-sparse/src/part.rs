//! Blocks of rows that one thread takes one after the other.
//!
//! A part owns all its memory, so that an evaluation allocates nothing and parts run in parallel;
//! which rows it has follows from their number alone, so that the sums are the same whoever made
//! them.

use faer::{Mat, MatRef};
use gp_core::Monomials;

use crate::block::{BLOCK, Block, Scratch, Shared, Slopes, Solution, Sums};

/// Some of the rows, and sums over them.
pub(crate) struct Part {
    blocks: Vec<Block>,
    scratch: Scratch,
    pub(crate) sums: Sums,
    pub(crate) slopes: Slopes,
}

impl Part {
    /// All rows in at most [`MOST_PARTS`] parts, for `m` pseudo-inputs; outputs less `origin`.
    ///
    /// - `row_noise`: one a row, or none; - `monomials`: what the mean is a sum of.
    pub(crate) fn split(
        (x, y, row_noise): (MatRef<'_, f64>, &[f64], &[f64]),
        origin: f64,
        monomials: &Monomials,
        m: usize,
        n_parameters: usize,
    ) -> Vec<Self> {
        let per_part = y.len().div_ceil(BLOCK).div_ceil(MOST_PARTS) * BLOCK;
        let block = |start: usize, y: &[f64]| {
            let y: Vec<f64> = y.iter().map(|y| y - origin).collect();
            let noise = |i: usize| row_noise.get(i).copied().unwrap_or(0.0);
            let row_noise = (start..start + y.len()).map(noise).collect();
            Block::new(x.subrows(start, y.len()), (y, row_noise), monomials, m)
        };
        let part = |(p, y): (usize, &[f64])| Self {
            blocks: (y.chunks(BLOCK).enumerate())
                .map(|(b, y)| block(p * per_part + b * BLOCK, y))
                .collect(),
            scratch: Scratch::new(m, 1 + monomials.count()),
            sums: Sums::new(m + 1 + monomials.count()),
            slopes: Slopes {
                square: Mat::zeros(m, m),
                kernel: vec![0.0; n_parameters],
                noise: 0.0,
                z: vec![0.0; m * x.ncols()],
            },
        };
        y.chunks(per_part).enumerate().map(part).collect()
    }

    /// The first pass over all blocks.
    pub(crate) fn sum(&mut self, shared: &Shared<'_>) {
        let sums = &mut self.sums;
        sums.square.fill(0.0);
        (sums.log_determinant, sums.penalty) = (0.0, 0.0);
        self.blocks.iter_mut().for_each(|block| block.sum(shared, sums));
    }

    /// The second pass over all blocks.
    pub(crate) fn differentiate(&mut self, shared: &Shared<'_>, solution: &Solution<'_>) {
        let slopes = &mut self.slopes;
        slopes.square.fill(0.0);
        slopes.kernel.fill(0.0);
        slopes.noise = 0.0;
        slopes.z.fill(0.0);
        for block in &self.blocks {
            block.differentiate(shared, solution, &mut self.scratch, slopes);
        }
    }
}

/// Parts that run in parallel.
const MOST_PARTS: usize = 16;
