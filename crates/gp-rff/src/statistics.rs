//! All that Bayesian linear regression needs of the data, in a form that merges.

use faer::{Mat, MatRef};
use gp_core::checks::{check_count, check_inputs, check_outputs, check_positive, check_row_noise};
use gp_core::kernel::column;
use gp_core::vector::add_compensated;
use gp_core::{GpError, Mean, Mergeable, Monomials};
use rayon::prelude::{IndexedParallelIterator, ParallelIterator, ParallelSlice};
use serde::{Deserialize, Serialize};

use crate::RandomFeatures;
use crate::feature_rows::{BLOCK, FeatureRows, GROUP, rows_of_part};
use crate::layout::Layout;

/// ΦᵀWΦ, ΦᵀWH, ΦᵀWy, yᵀWy, HᵀWy and N of the rows seen so far, y less a fixed origin.
///
/// H is what a mean is a sum of: 1, and with [`Self::with_mean`] products of inputs. W are weights of the
/// rows: 1, and with [`Self::with_row_noise`] σₙ²/(σₙ² + r) of those with known noise r beside the common
/// one.
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
    /// By their [`Layout`].
    sums: Vec<f64>,
    /// What rounding left over of each sum.
    remainders: Vec<f64>,
    /// What the mean is a sum of, if not of 1 alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    trend: Option<Trend>,
    /// The common noise variance beside which rows with noise of their own were weighed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    weighed_beside: Option<f64>,
}

/// Products of inputs up to a degree, less a center.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Trend {
    degree: u32,
    center: Vec<f64>,
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
        let mut statistics = Self {
            version: Self::VERSION,
            features: features.fingerprint(),
            n_features: features.n_features(),
            n_rows: 0,
            origin,
            sums: Vec::new(),
            remainders: Vec::new(),
            trend: None,
            weighed_beside: None,
        };
        statistics.empty();
        Ok(statistics)
    }

    /// No rows yet, for a mean that may be a learnt polynomial.
    ///
    /// - `center`: subtracted from inputs in its products; near their mean it saves digits. Statistics that
    ///   are to merge need the same.
    ///
    /// # Errors
    /// `ShapeMismatch` or `NotFinite` if the center is not one finite number an input; as [`Mean::check`];
    /// `Incompatible` where rows are there already.
    pub fn with_mean(
        mut self,
        features: &RandomFeatures,
        mean: Mean,
        center: &[f64],
    ) -> Result<Self, GpError> {
        mean.check()?;
        check_outputs("center of the inputs", center, features.n_inputs())?;
        if self.n_rows > 0 {
            return Err(GpError::Incompatible { what: "mean and that of rows that are there" });
        }
        let degree = mean.degree().unwrap_or(0);
        self.trend = (degree > 0).then(|| Trend { degree, center: center.to_vec() });
        self.empty();
        Ok(self)
    }

    /// The same, for rows with known noise of their own beside a common one of this variance.
    ///
    /// # Errors
    /// `NotPositive`; `Incompatible` where rows were weighed beside another one.
    pub fn with_row_noise(mut self, noise_variance: f64) -> Result<Self, GpError> {
        check_positive("noise variance", noise_variance)?;
        match self.weighed_beside {
            Some(other) if other != noise_variance && self.n_rows > 0 => {
                let what = "noise variances beside which rows were weighed";
                return Err(GpError::Incompatible { what });
            }
            None if self.trend.is_none() => self = self.extended(),
            _ => {}
        }
        self.weighed_beside = Some(noise_variance);
        Ok(self)
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
        self.update_with_row_noise(features, x, y, &[])
    }

    /// As `update`, with known noise variances of the rows, N, or none.
    ///
    /// # Errors
    /// As `update`; `Negative` for a noise that is; `Incompatible` for noise without
    /// [`Self::with_row_noise`].
    pub fn update_with_row_noise(
        &mut self,
        features: &RandomFeatures,
        x: MatRef<'_, f64>,
        y: &[f64],
        row_noise: &[f64],
    ) -> Result<(), GpError> {
        check_inputs("inputs", x, features.n_inputs())?;
        check_outputs("outputs", y, x.nrows())?;
        check_row_noise(row_noise, y.len())?;
        self.check_features(features)?;
        if self.weighed_beside.is_none() && !row_noise.is_empty() {
            return Err(GpError::Incompatible { what: "noise of rows and weights of statistics" });
        }
        let monomials = self.monomials(features.n_inputs());
        let per_part = rows_of_part(y.len());
        let part = |memory: &mut FeatureRows, (part, y): (usize, &[f64])| {
            let mut statistics = self.without_rows();
            let start = part * per_part;
            let row_noise = row_noise.get(start..start + y.len()).unwrap_or(&[]);
            let data = (x.subrows(start, y.len()), y, row_noise);
            statistics.add_rows(features, data, memory);
            statistics
        };
        let memory = || FeatureRows::new(features, monomials.clone(), false);
        let parts: Vec<Self> = y.par_chunks(per_part).enumerate().map_init(memory, part).collect();
        parts.iter().try_for_each(|part| self.merge(part))
    }

    /// Takes in what others have seen. Of many parts, [`gp_core::Parts`] have the same bits in any order.
    ///
    /// # Errors
    /// `Incompatible` if the features, the origin, the mean, the weights or the version differ.
    pub fn merge(&mut self, other: &Self) -> Result<(), GpError> {
        let same = self.features == other.features && self.version == other.version;
        if !same || self.n_features != other.n_features {
            return Err(GpError::Incompatible { what: "features of the statistics" });
        }
        if self.origin != other.origin {
            return Err(GpError::Incompatible { what: "output origins of the statistics" });
        }
        if self.trend != other.trend {
            return Err(GpError::Incompatible { what: "means of the statistics" });
        }
        if self.weighed_beside != other.weighed_beside || self.sums.len() != other.sums.len() {
            return Err(GpError::Incompatible { what: "weights of the statistics" });
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

    /// The common noise variance beside which rows were weighed, if they were.
    pub(crate) fn weighed_beside(&self) -> Option<f64> {
        self.weighed_beside
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
        if let Some(Trend { degree, center }) = &self.trend {
            check_outputs("center of the inputs", center, features.n_inputs())?;
            Mean::Polynomial(*degree).check()?;
        }
        if let Some(noise_variance) = self.weighed_beside {
            check_positive("noise variance of the statistics", noise_variance)?;
        }
        check_outputs("sums of the statistics", &self.sums, self.layout().length())?;
        check_outputs("remainders of the statistics", &self.remainders, self.sums.len())
    }

    /// H.
    pub(crate) fn monomials(&self, n_inputs: usize) -> Monomials {
        match &self.trend {
            Some(Trend { degree, center }) => Monomials::new(*degree, center),
            None => Monomials::new(0, &vec![0.0; n_inputs]),
        }
    }

    /// The sum at a place of the layout.
    pub(crate) fn total(&self, index: usize) -> f64 {
        self.sums[index] + self.remainders[index]
    }

    /// No rows of other features of as many columns, weighed beside another noise if they are weighed.
    pub(crate) fn clear(&mut self, features: &RandomFeatures, noise_variance: f64) {
        self.features = features.fingerprint();
        self.weighed_beside = self.weighed_beside.map(|_| noise_variance);
        self.n_rows = 0;
        self.sums.fill(0.0);
        self.remainders.fill(0.0);
    }

    fn without_rows(&self) -> Self {
        let (sums, remainders) = (Vec::new(), Vec::new());
        let mut other = Self { n_rows: 0, sums, remainders, trend: self.trend.clone(), ..*self };
        other.empty();
        other
    }

    /// All sums 0.
    fn empty(&mut self) {
        let n = self.layout().length();
        (self.sums, self.remainders) = (vec![0.0; n], vec![0.0; n]);
    }

    /// Takes in rows that have been checked, on the calling thread.
    ///
    /// - `row_noise`: one a row, or none.
    pub(crate) fn add_rows(
        &mut self,
        features: &RandomFeatures,
        (x, y, row_noise): (MatRef<'_, f64>, &[f64], &[f64]),
        rows: &mut FeatureRows,
    ) {
        let is_extended = self.layout().is_extended;
        for (group, y) in y.chunks(GROUP).enumerate() {
            rows.clear();
            let mut log_weights = 0.0;
            for (block, y) in y.chunks(BLOCK).enumerate() {
                let start = group * GROUP + block * BLOCK;
                rows.fill(features, x.subrows(start, y.len()), y, self.origin);
                if is_extended {
                    rows.add_spread();
                }
                if let (Some(common), Some(own)) =
                    (self.weighed_beside, row_noise.get(start..start + y.len()))
                {
                    log_weights += rows.weigh(common, own);
                }
                rows.add_square();
            }
            self.add_square(&rows.square);
            if is_extended {
                self.add_spread(&rows.spread, log_weights);
            }
            self.n_rows += y.len() as u64;
        }
    }

    /// Adds (Φ, y, H)ᵀ(Φ, y, H), of which the lower triangle is given.
    fn add_square(&mut self, square: &Mat<f64>) {
        let (m, layout) = (self.n_features, self.layout());
        if layout.is_extended {
            for j in 0..square.ncols() {
                self.add(layout.product(j, j), &column(square, j)[j..]);
            }
            return;
        }
        for j in 0..m {
            self.add(layout.product(j, j), &column(square, j)[j..m]);
        }
        let row = |i: usize| (0..m).map(|j| square[(i, j)]).collect::<Vec<f64>>();
        self.add(layout.product(m + 1, 0), &row(m + 1));
        self.add(layout.product(m, 0), &row(m));
        self.add(layout.product(m, m), &[square[(m, m)], square[(m + 1, m)]]);
    }

    fn add_spread(&mut self, spread: &Mat<f64>, log_weights: f64) {
        let layout = self.layout();
        for k in 0..spread.ncols() {
            self.add(layout.spread(k, k), &column(spread, k)[k..]);
        }
        self.add(layout.log_weights(), &[log_weights]);
    }

    /// Compensated: what the rounding of a sum loses is kept in its remainder.
    fn add(&mut self, start: usize, terms: &[f64]) {
        let range = start..start + terms.len();
        add_compensated(&mut self.sums[range.clone()], &mut self.remainders[range], terms);
    }

    /// The same sums with places for those of weighed rows.
    fn extended(self) -> Self {
        let mut other = Self { weighed_beside: Some(1.0), ..self.clone() };
        other.empty();
        let (m, plain, extended) = (self.n_features, self.layout(), other.layout());
        for i in 0..=m + 1 {
            for j in 0..=i.min(m) {
                let (from, to) = (plain.product(i, j), extended.product(i, j));
                (other.sums[to], other.remainders[to]) = (self.sums[from], self.remainders[from]);
            }
        }
        for one_one in [extended.product(m + 1, m + 1), extended.spread(0, 0)] {
            other.sums[one_one] = self.n_rows as f64;
        }
        other
    }

    pub(crate) fn layout(&self) -> Layout {
        let of_trend = |one: &Trend| Mean::Polynomial(one.degree).n_coefficients(one.center.len());
        Layout {
            n_features: self.n_features,
            n_basis: self.trend.as_ref().map_or(1, of_trend),
            is_extended: self.trend.is_some() || self.weighed_beside.is_some(),
        }
    }
}

impl Mergeable for SufficientStatistics {
    fn merge(&mut self, other: &Self) -> Result<(), GpError> {
        Self::merge(self, other)
    }
}
