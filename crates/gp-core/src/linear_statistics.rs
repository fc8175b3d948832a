//! All that Bayesian linear regression needs of its data: sums over rows, which merge.

use faer::linalg::matmul::matmul;
use faer::linalg::matmul::triangular;
use faer::{Accum, Mat, MatRef, Par};
use rayon::prelude::{IndexedParallelIterator, ParallelIterator, ParallelSlice};
use serde::{Deserialize, Serialize};

use crate::checks::{check_inputs, check_outputs};
use crate::kernel::column;
use crate::vector::add_compensated;
use crate::{GpError, Mergeable};

/// ΦᵀΦ, Φᵀy, yᵀy and N of the rows seen so far.
///
/// Memory is that of M(M + 3) numbers, whatever the number of rows. Rows are taken in groups of 960 by matrix
/// products, and groups are added with compensated sums: results agree to rounding however rows were split over
/// calls, and to the last bit where [`Parts`](crate::Parts) merge the same parts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Saved", into = "Saved")]
pub struct LinearStatistics {
    n_features: usize,
    n_rows: u64,
    /// ΦᵀΦ, the lower triangle by columns, then Φᵀy and yᵀy.
    sums: Vec<f64>,
    /// What rounding left over of each sum.
    remainders: Vec<f64>,
}

/// As it is written.
#[derive(Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Saved {
    n_features: usize,
    n_rows: u64,
    sums: Vec<f64>,
    remainders: Vec<f64>,
}

/// Rows that one matrix product takes.
const GROUP: usize = 960;
/// Parts that run in parallel.
const MOST_PARTS: usize = 16;

impl LinearStatistics {
    /// No rows yet, of so many features.
    ///
    /// # Errors
    /// `Empty` for none.
    pub fn new(n_features: usize) -> Result<Self, GpError> {
        if n_features == 0 {
            return Err(GpError::Empty { what: "features" });
        }
        let n = length(n_features);
        Ok(Self { n_features, n_rows: 0, sums: vec![0.0; n], remainders: vec![0.0; n] })
    }

    /// Takes in rows; O(N M²), in parallel, with the same bits for any number of threads.
    ///
    /// - `features`: Φ, N×M; `y`: outputs, N.
    ///
    /// # Errors
    /// `Empty`, `ShapeMismatch`, `NotFinite`.
    pub fn update(&mut self, features: MatRef<'_, f64>, y: &[f64]) -> Result<(), GpError> {
        check_inputs("features", features, self.n_features)?;
        check_outputs("outputs", y, features.nrows())?;
        let per_part = y.len().div_ceil(MOST_PARTS).next_multiple_of(GROUP);
        let part = |(part, y): (usize, &[f64])| {
            let mut statistics = Self::new(self.n_features)?;
            statistics.add_rows(features.subrows(part * per_part, y.len()), y);
            Ok(statistics)
        };
        let parts: Vec<Result<Self, GpError>> =
            y.par_chunks(per_part).enumerate().map(part).collect();
        parts.into_iter().try_for_each(|part| self.merge(&part?))
    }

    /// The number of features M.
    pub fn n_features(&self) -> usize {
        self.n_features
    }

    /// The number of rows N.
    pub fn n_rows(&self) -> u64 {
        self.n_rows
    }

    /// ΦᵀΦ, M×M.
    pub fn square(&self) -> Mat<f64> {
        let m = self.n_features;
        // Columns before j hold Σ (m − k) numbers.
        let at = |i: usize, j: usize| j * m - j * j.saturating_sub(1) / 2 + i - j;
        Mat::from_fn(m, m, |i, j| self.total(at(i.max(j), i.min(j))))
    }

    /// Φᵀy, M.
    pub fn of_y(&self) -> Vec<f64> {
        let end = self.sums.len() - 1;
        (end - self.n_features..end).map(|index| self.total(index)).collect()
    }

    /// yᵀy.
    pub fn y_y(&self) -> f64 {
        self.total(self.sums.len() - 1)
    }

    fn total(&self, index: usize) -> f64 {
        self.sums[index] + self.remainders[index]
    }

    /// Takes in rows that have been checked, on the calling thread.
    fn add_rows(&mut self, features: MatRef<'_, f64>, y: &[f64]) {
        let m = self.n_features;
        let (mut square, mut of_y) = (Mat::zeros(m, m), Mat::zeros(m, 1));
        for (group, y) in y.chunks(GROUP).enumerate() {
            let rows = features.subrows(group * GROUP, y.len());
            let (lower, whole) = (
                triangular::BlockStructure::TriangularLower,
                triangular::BlockStructure::Rectangular,
            );
            let into = square.as_mut();
            triangular::matmul(
                into,
                lower,
                Accum::Replace,
                rows.transpose(),
                whole,
                rows,
                whole,
                1.0,
                Par::Seq,
            );
            let outputs = MatRef::from_column_major_slice(y, y.len(), 1);
            matmul(of_y.as_mut(), Accum::Replace, rows.transpose(), outputs, 1.0, Par::Seq);
            let mut start = 0;
            for j in 0..m {
                self.add(start, &column(&square, j)[j..m]);
                start += m - j;
            }
            self.add(start, column(&of_y, 0));
            self.add(start + m, &[y.iter().map(|y| y * y).sum()]);
            self.n_rows += y.len() as u64;
        }
    }

    /// Compensated: what the rounding of a sum loses is kept in its remainder.
    fn add(&mut self, start: usize, terms: &[f64]) {
        let range = start..start + terms.len();
        add_compensated(&mut self.sums[range.clone()], &mut self.remainders[range], terms);
    }
}

impl Mergeable for LinearStatistics {
    fn merge(&mut self, other: &Self) -> Result<(), GpError> {
        if self.n_features != other.n_features {
            return Err(GpError::Incompatible { what: "numbers of features of the statistics" });
        }
        self.n_rows += other.n_rows;
        self.add(0, &other.sums);
        self.remainders.iter_mut().zip(&other.remainders).for_each(|(own, other)| *own += other);
        Ok(())
    }
}

impl TryFrom<Saved> for LinearStatistics {
    type Error = GpError;

    fn try_from(saved: Saved) -> Result<Self, GpError> {
        let Saved { n_features, n_rows, sums, remainders } = saved;
        let none = Self::new(n_features)?;
        check_outputs("sums of the statistics", &sums, none.sums.len())?;
        check_outputs("remainders of the statistics", &remainders, sums.len())?;
        Ok(Self { n_features, n_rows, sums, remainders })
    }
}

impl From<LinearStatistics> for Saved {
    fn from(statistics: LinearStatistics) -> Self {
        let LinearStatistics { n_features, n_rows, sums, remainders } = statistics;
        Self { n_features, n_rows, sums, remainders }
    }
}

/// Sums of M features.
fn length(m: usize) -> usize {
    m * (m + 1) / 2 + m + 1
}
