//! Blocks of rows that one thread takes one after the other.
//!
//! A part owns all its memory, so that an evaluation allocates nothing and parts run in parallel;
//! which rows it has follows from their number alone, so that the sums are the same whoever made
//! them.

use faer::{Mat, MatRef};
use gp_core::Monomials;
use rayon::prelude::{IntoParallelIterator, ParallelIterator};

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
        let rows = Rows { x, y, row_noise, origin, monomials, m };
        let per_part = rows_of_part(y.len());
        let part = |(p, y): (usize, &[f64])| Self {
            blocks: (y.chunks(BLOCK).enumerate())
                .map(|(b, y)| rows.block(p * per_part + b * BLOCK, y.len()))
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

    /// The first pass over all rows with the blocks one after the other in memory; the same bits.
    pub(crate) fn sums(
        (x, y, row_noise): (MatRef<'_, f64>, &[f64], &[f64]),
        origin: f64,
        monomials: &Monomials,
        m: usize,
        shared: &Shared<'_>,
    ) -> Vec<Sums> {
        let rows = Rows { x, y, row_noise, origin, monomials, m };
        let per_part = rows_of_part(y.len());
        let part = |p: usize| {
            let mut sums = Sums::new(m + 1 + monomials.count());
            let end = ((p + 1) * per_part).min(y.len());
            for start in (p * per_part..end).step_by(BLOCK) {
                rows.block(start, BLOCK.min(end - start)).sum(shared, &mut sums);
            }
            sums
        };
        (0..y.len().div_ceil(per_part)).into_par_iter().map(part).collect()
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

/// Rows that one part has.
fn rows_of_part(n_rows: usize) -> usize {
    n_rows.div_ceil(BLOCK).div_ceil(MOST_PARTS) * BLOCK
}

/// All rows, and what they are looked at as.
struct Rows<'a> {
    x: MatRef<'a, f64>,
    y: &'a [f64],
    row_noise: &'a [f64],
    origin: f64,
    monomials: &'a Monomials,
    m: usize,
}

impl Rows<'_> {
    fn block(&self, start: usize, n: usize) -> Block {
        let y = self.y[start..start + n].iter().map(|y| y - self.origin).collect();
        let noise = |i: usize| self.row_noise.get(i).copied().unwrap_or(0.0);
        let row_noise = (start..start + n).map(noise).collect();
        Block::new(self.x.subrows(start, n), (y, row_noise), self.monomials, self.m)
    }
}
