//! All that Bayesian linear regression needs of the data, in a form that merges.

use faer::linalg::matmul::triangular::{BlockStructure, matmul};
use faer::{Accum, Mat, MatRef, Par};
use gp_core::checks::{check_count, check_inputs, check_outputs};
use gp_core::kernel::{column, column_mut};
use gp_core::vector::add_compensated;
use gp_core::{GpError, Mergeable};
use rayon::prelude::{IndexedParallelIterator, ParallelIterator, ParallelSlice};
use serde::{Deserialize, Serialize};

use crate::{Form, RandomFeatures};

/// ΦᵀΦ, Φᵀ1, Φᵀy, yᵀy, 1ᵀy and N of the rows seen so far, y less a fixed origin.
///
/// Rows are taken in groups of at most 960, each by matrix products, and groups are added with
/// compensated sums. However the rows were split over calls, files or machines, every entry is the
/// exact sum but for a relative error of at most 960 ε in its terms: results agree to rounding.
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
        let per_part = rows_of_part(y.len());
        let part = |memory: &mut FeatureRows, (part, y): (usize, &[f64])| {
            let mut statistics = Self::new(features, self.origin)?;
            statistics.add_rows(features, x.subrows(part * per_part, y.len()), y, memory);
            Ok(statistics)
        };
        let memory = || FeatureRows::new(features, false);
        let parts: Vec<Result<Self, GpError>> =
            y.par_chunks(per_part).enumerate().map_init(memory, part).collect();
        for part in parts {
            self.merge(&part?)?;
        }
        Ok(())
    }

    /// Takes in what others have seen. Of many parts, [`gp_core::Parts`] have the same bits in any order.
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

    /// No rows of other features of as many columns.
    pub(crate) fn clear(&mut self, features: &RandomFeatures) {
        self.features = features.fingerprint();
        self.n_rows = 0;
        self.sums.fill(0.0);
        self.remainders.fill(0.0);
    }

    /// Takes in rows that have been checked, on the calling thread.
    pub(crate) fn add_rows(
        &mut self,
        features: &RandomFeatures,
        x: MatRef<'_, f64>,
        y: &[f64],
        rows: &mut FeatureRows,
    ) {
        for (group, y) in y.chunks(GROUP).enumerate() {
            rows.square.fill(0.0);
            for (block, y) in y.chunks(BLOCK).enumerate() {
                let start = group * GROUP + block * BLOCK;
                rows.fill(features, x.subrows(start, y.len()), y, self.origin);
                rows.add_square();
            }
            self.add_square(&rows.square);
            self.n_rows += y.len() as u64;
        }
    }

    /// Adds (Φ, y, 1)ᵀ(Φ, y, 1), of which the lower triangle is given.
    fn add_square(&mut self, square: &Mat<f64>) {
        let m = self.n_features;
        let mut start = 0;
        for j in 0..m {
            self.add(start, &column(square, j)[j..m]);
            start += m - j;
        }
        let row = |i: usize| (0..m).map(|j| square[(i, j)]).collect::<Vec<f64>>();
        self.add(start, &row(m + 1));
        self.add(start + m, &row(m));
        self.add(start + 2 * m, &[square[(m, m)], square[(m + 1, m)]]);
    }

    /// Compensated: what the rounding of a sum loses is kept in its remainder.
    fn add(&mut self, start: usize, terms: &[f64]) {
        let range = start..start + terms.len();
        add_compensated(&mut self.sums[range.clone()], &mut self.remainders[range], terms);
    }
}

impl Mergeable for SufficientStatistics {
    fn merge(&mut self, other: &Self) -> Result<(), GpError> {
        Self::merge(self, other)
    }
}

/// A block of rows (Φ, y, 1), and memory for their products.
pub(crate) struct FeatureRows {
    n: usize,
    values: Mat<f64>,
    /// The sine beside each cosine, where features and their slopes do not have it anyway.
    sines: Mat<f64>,
    /// The sum of (Φ, y, 1)ᵀ(Φ, y, 1) over blocks, the lower triangle.
    square: Mat<f64>,
}

impl FeatureRows {
    pub(crate) fn new(features: &RandomFeatures, with_sines: bool) -> Self {
        let width = features.n_features() + 2;
        let has_sines = with_sines && features.form == Form::Cosines;
        let n_sines = if has_sines { features.phases.len() } else { 0 };
        Self {
            n: 0,
            values: Mat::zeros(BLOCK, width),
            sines: Mat::zeros(BLOCK, n_sines),
            square: Mat::zeros(width, width),
        }
    }

    /// Writes at most [`BLOCK`] rows.
    pub(crate) fn fill(
        &mut self,
        features: &RandomFeatures,
        x: MatRef<'_, f64>,
        y: &[f64],
        origin: f64,
    ) {
        let (n, m) = (y.len(), features.n_features());
        self.n = n;
        let sines = (self.sines.ncols() > 0).then(|| self.sines.as_mut().subrows_mut(0, n));
        features.fill(x, self.values.as_mut().subrows_mut(0, n), sines);
        for (value, y) in column_mut(&mut self.values, m).iter_mut().zip(y) {
            *value = y - origin;
        }
        column_mut(&mut self.values, m + 1)[..n].fill(1.0);
    }

    /// (Φ, y, 1).
    pub(crate) fn values(&self) -> MatRef<'_, f64> {
        self.values.as_ref().subrows(0, self.n)
    }

    /// Cosine number `j` of the rows, and the sine beside it.
    pub(crate) fn pair(&self, j: usize, n_frequencies: usize) -> (&[f64], &[f64]) {
        let sine = match self.sines.ncols() {
            0 => column(&self.values, n_frequencies + j),
            _ => column(&self.sines, j),
        };
        (&column(&self.values, j)[..self.n], &sine[..self.n])
    }

    fn add_square(&mut self) {
        let values = self.values.as_ref().subrows(0, self.n);
        let (lower, whole) = (BlockStructure::TriangularLower, BlockStructure::Rectangular);
        let square = self.square.as_mut();
        matmul(square, lower, Accum::Add, values.transpose(), whole, values, whole, 1.0, Par::Seq);
    }
}

/// Rows of a part: parts run in parallel, and what they are follows from the number of rows alone.
pub(crate) fn rows_of_part(n_rows: usize) -> usize {
    n_rows.div_ceil(MOST_PARTS).next_multiple_of(4 * GROUP)
}

/// Rows that one matrix product takes: with two hundred features they stay in the second cache. No
/// power of two, so that the columns do not compete for the same places in it.
pub(crate) const BLOCK: usize = 240;
/// Rows that are summed before a compensated sum takes them.
const GROUP: usize = 4 * BLOCK;
/// Parts that run in parallel.
const MOST_PARTS: usize = 16;

/// Sums of M features.
fn length(m: usize) -> usize {
    m * (m + 1) / 2 + 2 * m + 2
}
