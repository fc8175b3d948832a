//! All that Bayesian linear regression needs of the data, in a form that merges.

use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::{Accum, Mat, MatRef, Par};
use gp_core::GpError;
use gp_core::checks::{check_count, check_inputs, check_outputs};
use gp_core::kernel::{column, column_mut};
use gp_core::vector::dot;
use rayon::prelude::{IntoParallelIterator, ParallelIterator};
use serde::{Deserialize, Serialize};

use crate::RandomFeatures;

/// ΦᵀΦ, Φᵀ1, Φᵀy, yᵀy, 1ᵀy and N of the rows seen so far, y less a fixed origin.
///
/// Rows are taken in blocks of at most 256, each by a matrix product, and blocks are added with
/// compensated sums. However the rows were split over calls, files or machines, every entry is the
/// exact sum but for a relative error of some 256 ε in its terms: results agree to rounding.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SufficientStatistics {
    version: u32,
    /// Which features these are sums of.
    features: u64,
    n_features: usize,
    n_rows: u64,
    origin: f64,
    /// ΦᵀΦ, the lower triangle by columns, then Φᵀ1, Φᵀy, yᵀy and 1ᵀy.
    sums: Vec<f64>,
    /// What rounding left over of each sum.
    remainders: Vec<f64>,
}

impl SufficientStatistics {
    /// The version that this release writes and reads.
    pub const VERSION: u32 = 1;

    /// No rows yet.
    ///
    /// - `origin`: subtracted from all outputs, in their unit; near their mean it saves digits.
    ///
    /// # Errors
    /// `NotFinite` for an origin that is not.
    pub fn new(features: &RandomFeatures, origin: f64) -> Result<Self, GpError> {
        check_outputs("origin of the outputs", &[origin], 1)?;
        let m = features.n_features();
        let n = length(m);
        Ok(Self {
            version: Self::VERSION,
            features: features.fingerprint(),
            n_features: m,
            n_rows: 0,
            origin,
            sums: vec![0.0; n],
            remainders: vec![0.0; n],
        })
    }

    /// Takes in rows; O(N M²), in parallel, with the same bits for any number of threads.
    ///
    /// - `x`: inputs, N×D; `y`: outputs, N.
    ///
    /// # Errors
    /// `Empty`, `ShapeMismatch`, `NotFinite`; `Incompatible` for other features than in `new`.
    pub fn update(
        &mut self,
        features: &RandomFeatures,
        x: MatRef<'_, f64>,
        y: &[f64],
    ) -> Result<(), GpError> {
        check_inputs("inputs", x, features.n_inputs())?;
        check_outputs("outputs", y, x.nrows())?;
        self.check_features(features)?;
        let per_part = y.len().div_ceil(MOST_PARTS).next_multiple_of(BLOCK);
        let part = |start: usize| {
            let n = per_part.min(y.len() - start);
            let mut part = Self::new(features, self.origin)?;
            part.add_rows(features, x.subrows(start, n), &y[start..start + n]);
            Ok(part)
        };
        let starts: Vec<usize> = (0..y.len()).step_by(per_part).collect();
        let parts: Vec<Result<Self, GpError>> = starts.into_par_iter().map(part).collect();
        for part in parts {
            self.merge(&part?)?;
        }
        Ok(())
    }

    /// Takes in what others have seen.
    ///
    /// # Errors
    /// `Incompatible` if the features, the origin or the version differ.
    pub fn merge(&mut self, other: &Self) -> Result<(), GpError> {
        let same = self.features == other.features && self.version == other.version;
        if !same || self.sums.len() != other.sums.len() {
            return Err(GpError::Incompatible { what: "features of the statistics" });
        }
        if self.origin != other.origin {
            return Err(GpError::Incompatible { what: "output origins of the statistics" });
        }
        self.n_rows += other.n_rows;
        self.add(0, &other.sums);
        self.remainders.iter_mut().zip(&other.remainders).for_each(|(r, other)| *r += other);
        Ok(())
    }

    /// The number of rows N.
    pub fn n_rows(&self) -> u64 {
        self.n_rows
    }

    /// What is subtracted from all outputs.
    pub fn origin(&self) -> f64 {
        self.origin
    }

    /// # Errors
    /// `Incompatible` unless these are sums of the given features; `ShapeMismatch` or `NotFinite`
    /// where a file was edited.
    pub(crate) fn check_features(&self, features: &RandomFeatures) -> Result<(), GpError> {
        if self.version != Self::VERSION {
            let supported = Self::VERSION;
            return Err(GpError::UnsupportedVersion { found: self.version, supported });
        }
        if self.features != features.fingerprint() {
            return Err(GpError::Incompatible { what: "features and those of the statistics" });
        }
        check_count("features of the statistics", features.n_features(), self.n_features)?;
        check_outputs("sums of the statistics", &self.sums, length(self.n_features))?;
        check_outputs("remainders of the statistics", &self.remainders, self.sums.len())
    }

    /// ΦᵀΦ, the lower triangle.
    pub(crate) fn square(&self) -> Mat<f64> {
        let m = self.n_features;
        let mut square = Mat::zeros(m, m);
        let mut start = 0;
        for j in 0..m {
            for (i, entry) in column_mut(&mut square, j).iter_mut().enumerate().skip(j) {
                *entry = self.total(start + i - j);
            }
            start += m - j;
        }
        square
    }

    /// Φᵀ1.
    pub(crate) fn of_one(&self) -> Vec<f64> {
        self.totals(0)
    }

    /// Φᵀy.
    pub(crate) fn of_y(&self) -> Vec<f64> {
        self.totals(self.n_features)
    }

    /// yᵀy.
    pub(crate) fn y_y(&self) -> f64 {
        self.total(self.sums.len() - 2)
    }

    /// 1ᵀy.
    pub(crate) fn one_y(&self) -> f64 {
        self.total(self.sums.len() - 1)
    }

    fn total(&self, index: usize) -> f64 {
        self.sums[index] + self.remainders[index]
    }

    fn totals(&self, offset: usize) -> Vec<f64> {
        let start = self.n_features * (self.n_features + 1) / 2 + offset;
        (start..start + self.n_features).map(|index| self.total(index)).collect()
    }

    fn add_rows(&mut self, features: &RandomFeatures, x: MatRef<'_, f64>, y: &[f64]) {
        let m = self.n_features;
        let mut phi = Mat::zeros(BLOCK.min(y.len()), m);
        let mut square = Mat::zeros(m, m);
        for start in (0..y.len()).step_by(BLOCK) {
            let n = BLOCK.min(y.len() - start);
            if n < phi.nrows() {
                phi = Mat::zeros(n, m);
            }
            features.fill(x.subrows(start, n), &mut phi, None);
            multiply_transposed(&phi, &mut square);
            let y: Vec<f64> = y[start..start + n].iter().map(|y| y - self.origin).collect();
            self.add_block(&phi, &square, &y);
        }
    }

    /// Adds what was summed over one block.
    pub(crate) fn add_block(&mut self, phi: &Mat<f64>, square: &Mat<f64>, y: &[f64]) {
        let m = self.n_features;
        let mut start = 0;
        for j in 0..m {
            self.add(start, &column(square, j)[j..]);
            start += m - j;
        }
        let ones = vec![1.0; y.len()];
        let of_one: Vec<f64> = (0..m).map(|j| dot(column(phi, j), &ones)).collect();
        let of_y: Vec<f64> = (0..m).map(|j| dot(column(phi, j), y)).collect();
        self.add(start, &of_one);
        self.add(start + m, &of_y);
        self.add(start + 2 * m, &[dot(y, y), y.iter().sum()]);
        self.n_rows += y.len() as u64;
    }

    /// Compensated: what the rounding of a sum loses is kept in its remainder.
    fn add(&mut self, start: usize, terms: &[f64]) {
        let range = start..start + terms.len();
        let sums = self.sums[range.clone()].iter_mut().zip(&mut self.remainders[range]);
        gp_core::vector::vectorized(|| {
            for ((sum, remainder), term) in sums.zip(terms) {
                let total = *sum + term;
                let added = total - *sum;
                *remainder += (*sum - (total - added)) + (term - added);
                *sum = total;
            }
        });
    }
}

/// ΦᵀΦ, the lower triangle.
pub(crate) fn multiply_transposed(phi: &Mat<f64>, square: &mut Mat<f64>) {
    matmul(
        square.as_mut(),
        BlockStructure::TriangularLower,
        Accum::Replace,
        phi.transpose(),
        BlockStructure::Rectangular,
        phi,
        BlockStructure::Rectangular,
        1.0,
        Par::Seq,
    );
}

/// Rows that one matrix product takes.
pub(crate) const BLOCK: usize = 256;
/// Parts that run in parallel.
const MOST_PARTS: usize = 16;

/// Sums of M features.
fn length(m: usize) -> usize {
    m * (m + 1) / 2 + 2 * m + 2
}
