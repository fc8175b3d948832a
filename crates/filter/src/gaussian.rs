//! A Gaussian, and what becomes of it in a nonlinear motion.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::sync::OnceLock;

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};
use rand::{Rng, RngExt};
use rand_distr::StandardNormal;

use crate::linearized::symmetric;
use crate::slab::TruncatedNormal;
use crate::{FilterError, Rule};

/// A Gaussian over vectors.
#[derive(Clone, Debug)]
pub struct Gaussian {
    mean: DVector<f64>,
    covariance: DMatrix<f64>,
    /// A square root R of the covariance, R Rᵀ, by its eigenvectors, with a column for each direction
    /// that has variance.
    root: DMatrix<f64>,
    /// The triangular root and the log determinant, from the first density on; none of a singular one.
    triangular: OnceLock<Option<(Cholesky<f64, Dyn>, f64)>>,
}

impl PartialEq for Gaussian {
    /// By mean and covariance, from which the rest follows.
    fn eq(&self, other: &Self) -> bool {
        self.mean == other.mean && self.covariance == other.covariance
    }
}

/// Eigenvalues above −tolerance times the largest are rounding.
const ROUNDING: f64 = 1e-10;
/// Ways whose numbers change less than this with a standard deviation have no direction.
const STRAIGHT: f64 = 1e-9;

impl Gaussian {
    /// A Gaussian of a mean and a covariance.
    ///
    /// # Errors
    /// `ShapeMismatch`; `NotPositiveSemiDefinite` for a covariance that is none, or not symmetric.
    pub fn new(mean: DVector<f64>, covariance: DMatrix<f64>) -> Result<Self, FilterError> {
        let (expected, dimension) = (mean.len(), mean.len());
        for actual in [covariance.nrows(), covariance.ncols()] {
            if actual != expected {
                return Err(FilterError::ShapeMismatch { what: "covariance", expected, actual });
            }
        }
        let scale = covariance.amax();
        let is_symmetric = (&covariance - covariance.transpose()).amax() <= ROUNDING * scale;
        if !is_symmetric || !mean.iter().chain(&covariance).all(|value| value.is_finite()) {
            return Err(FilterError::NotPositiveSemiDefinite { dimension });
        }
        if covariance.diagonal().iter().any(|variance| *variance < -ROUNDING * scale) {
            return Err(FilterError::NotPositiveSemiDefinite { dimension });
        }
        // In standard deviations, so that coordinates of any unit count alike.
        let units = covariance.diagonal().map(|variance| variance.max(0.0).sqrt());
        let unit = |i: usize| if units[i] > 0.0 { units[i] } else { 1.0 };
        let scaled =
            DMatrix::from_fn(dimension, dimension, |i, j| covariance[(i, j)] / (unit(i) * unit(j)));
        let eigen = scaled.symmetric_eigen();
        if eigen.eigenvalues.iter().any(|value| *value < -ROUNDING * dimension as f64) {
            return Err(FilterError::NotPositiveSemiDefinite { dimension });
        }
        let is_wide = |k: &usize| eigen.eigenvalues[*k] > ROUNDING * dimension as f64;
        let wide: Vec<usize> = (0..dimension).filter(is_wide).collect();
        let root = DMatrix::from_fn(dimension, wide.len(), |i, k| {
            unit(i) * eigen.eigenvalues[wide[k]].sqrt() * eigen.eigenvectors[(i, wide[k])]
        });
        Ok(Self { mean, covariance, root, triangular: OnceLock::new() })
    }

    /// A Gaussian of independent coordinates.
    ///
    /// # Errors
    /// `ShapeMismatch`; `OutOfRange` for a standard deviation that is negative or no number.
    pub fn independent(mean: DVector<f64>, sds: &[f64]) -> Result<Self, FilterError> {
        if let Some(value) = sds.iter().find(|sd| !(**sd >= 0.0 && sd.is_finite())) {
            let (name, expected) = ("standard deviation", "finite and not negative");
            return Err(FilterError::OutOfRange { name, expected, value: *value });
        }
        let variances = DVector::from_iterator(sds.len(), sds.iter().map(|sd| sd * sd));
        Self::new(mean, DMatrix::from_diagonal(&variances))
    }

    /// The mean.
    #[must_use]
    pub fn mean(&self) -> &DVector<f64> {
        &self.mean
    }

    /// The covariance.
    #[must_use]
    pub fn covariance(&self) -> &DMatrix<f64> {
        &self.covariance
    }

    /// A draw.
    pub fn sample(&self, random: &mut dyn Rng) -> DVector<f64> {
        let normal = DVector::from_fn(self.root.ncols(), |_, _| random.sample(StandardNormal));
        &self.mean + &self.root * normal
    }

    /// The log density, in nats.
    ///
    /// # Errors
    /// `ShapeMismatch`; `NotPositiveSemiDefinite` for a singular covariance, which has none.
    pub fn log_density(&self, at: &DVector<f64>) -> Result<f64, FilterError> {
        let (expected, actual) = (self.mean.len(), at.len());
        if actual != expected {
            return Err(FilterError::ShapeMismatch { what: "point", expected, actual });
        }
        let triangular = self.triangular.get_or_init(|| {
            let factor = self.covariance.clone().cholesky()?;
            let log_determinant = 2.0 * factor.l().diagonal().iter().map(|x| x.ln()).sum::<f64>();
            Some((factor, log_determinant))
        });
        let singular = FilterError::NotPositiveSemiDefinite { dimension: expected };
        let (factor, log_determinant) = triangular.as_ref().ok_or(singular)?;
        let off = at - &self.mean;
        let square = off.dot(&factor.solve(&off));
        Ok(-0.5 * (square + log_determinant + expected as f64 * TAU.ln()))
    }

    /// The Gaussian with the moments of what a motion makes of this one, where the motion gives a
    /// Gaussian (m, C) for each state: the mean of m, and the mean of C plus the covariance of m.
    ///
    /// # Errors
    /// What `motion` says; `ShapeMismatch` if its Gaussians differ in dimension.
    pub fn propagated<E: From<FilterError>>(
        &self,
        rule: &dyn Rule,
        motion: impl Fn(&DVector<f64>) -> Result<Self, E>,
    ) -> Result<Self, E> {
        let moved = self.points(rule).into_iter().map(|(point, w)| Ok((motion(&point)?, w)));
        let moved = moved.collect::<Result<Vec<_>, E>>()?;
        Ok(Self::of_mixture(&moved)?)
    }

    /// The parts of this Gaussian that go different ways, in the order of the ways' numbers, with their
    /// probabilities: slabs between parallel planes, each as the Gaussian of its moments.
    ///
    /// Points over the first `n` coordinates tell how probable each way is and across which direction
    /// the ways change; ways that are next to each other have neighboring numbers. All parts together
    /// have the mean and the covariance of the whole.
    ///
    /// # Errors
    /// What `way` says; `NotPositiveSemiDefinite` if rounding left no covariance.
    pub fn split<E: From<FilterError>>(
        &self,
        rule: &dyn Rule,
        n: usize,
        mut way: impl FnMut(&DVector<f64>) -> Result<i64, E>,
    ) -> Result<Vec<(i64, f64, Self)>, E> {
        let root = self.root_of_first(n);
        let mut shares: BTreeMap<i64, f64> = BTreeMap::new();
        let mut direction = DVector::zeros(root.ncols());
        for (point, weight) in rule.points(root.ncols()) {
            if weight > 0.0 {
                let own = way(&(&self.mean + &root * &point))?;
                *shares.entry(own).or_default() += weight;
                // The covariance of the way's number with the standard coordinates, whose mean is 0.
                direction.axpy(weight * own as f64, &point, 1.0);
            }
        }
        let straight = direction.try_normalize(STRAIGHT).filter(|_| shares.len() > 1);
        let Some(direction) = straight else {
            // One way, or ways that no plane tells apart: the most probable has it all.
            let most = shares.into_iter().max_by(|a, b| a.1.total_cmp(&b.1));
            return Ok(vec![(most.map_or(0, |(way, _)| way), 1.0, self.clone())]);
        };
        let across = root * direction;
        let mut parts = Vec::with_capacity(shares.len());
        let mut below = 0.0;
        for (way, share) in shares {
            let slab = TruncatedNormal::between(below, below + share);
            below += share;
            let mean = &self.mean + slab.mean * &across;
            let covariance =
                &self.covariance + (slab.variance - 1.0) * &across * across.transpose();
            parts.push((way, share, Self::new(mean, covariance)?));
        }
        Ok(parts)
    }

    /// A rule's points over the first `n` coordinates, with the others at their conditional means; and
    /// the covariance that the others keep, which is zero for the first.
    ///
    /// What depends on the first coordinates alone needs no points over the others.
    pub fn points_of_first(
        &self,
        rule: &dyn Rule,
        n: usize,
    ) -> (Vec<(DVector<f64>, f64)>, DMatrix<f64>) {
        let root = self.root_of_first(n);
        let points = rule.points(root.ncols()).into_iter().filter(|(_, weight)| *weight > 0.0);
        let points = points.map(|(point, weight)| (&self.mean + &root * point, weight)).collect();
        let mut rest = &self.covariance - &root * root.transpose();
        (0..n.min(rest.nrows())).for_each(|i| {
            rest.row_mut(i).fill(0.0);
            rest.column_mut(i).fill(0.0);
        });
        (points, rest)
    }

    /// R with R Rᵀ = C for the first `n` coordinates and for them with the others: what the others have
    /// in common with them.
    fn root_of_first(&self, n: usize) -> DMatrix<f64> {
        let d = self.mean.len();
        if n >= d {
            return self.root.clone();
        }
        let units = self.covariance.diagonal().map(|variance| variance.max(0.0).sqrt());
        let unit = |i: usize| if units[i] > 0.0 { units[i] } else { 1.0 };
        let scaled = DMatrix::from_fn(n, n, |i, j| self.covariance[(i, j)] / (unit(i) * unit(j)));
        let eigen = scaled.symmetric_eigen();
        let wide: Vec<usize> =
            (0..n).filter(|k| eigen.eigenvalues[*k] > ROUNDING * d as f64).collect();
        // C of all with the first, times the inverse root of the first.
        DMatrix::from_fn(d, wide.len(), |i, k| {
            let along = eigen.eigenvectors.column(wide[k]);
            let with = (0..n).map(|j| self.covariance[(i, j)] / unit(j) * along[j]);
            with.sum::<f64>() / eigen.eigenvalues[wide[k]].sqrt()
        })
    }

    /// The Gaussian with the moments of weighted points, of any sum of weights, and a covariance that
    /// each of them keeps.
    ///
    /// # Errors
    /// `Empty`; `ShapeMismatch` for points or a covariance of another dimension;
    /// `NotPositiveSemiDefinite`.
    pub fn of_points(
        points: &[(DVector<f64>, f64)],
        kept: &DMatrix<f64>,
    ) -> Result<Self, FilterError> {
        let first = points.first().ok_or(FilterError::Empty { what: "points" })?;
        let expected = first.0.len();
        let sizes = points.iter().map(|(point, _)| point.len()).chain([kept.nrows(), kept.ncols()]);
        if let Some(actual) = sizes.into_iter().find(|size| *size != expected) {
            return Err(FilterError::ShapeMismatch { what: "point", expected, actual });
        }
        let total: f64 = points.iter().map(|(_, weight)| weight).sum();
        let mut mean = DVector::zeros(expected);
        points.iter().for_each(|(point, weight)| mean.axpy(weight / total, point, 1.0));
        let mut covariance = kept.clone();
        for (point, weight) in points {
            let off = point - &mean;
            covariance.ger(weight / total, &off, &off, 1.0);
        }
        Self::new(mean, covariance)
    }

    /// The rule's points in the state's own coordinates.
    pub(crate) fn points(&self, rule: &dyn Rule) -> Vec<(DVector<f64>, f64)> {
        let points = rule.points(self.root.ncols()).into_iter();
        points.map(|(point, weight)| (self.at(&point), weight)).collect()
    }

    /// The rule's points ξ in the coordinates of the root, those without weight left out.
    pub(crate) fn standard_points(&self, rule: &dyn Rule) -> Vec<(DVector<f64>, f64)> {
        let points = rule.points(self.root.ncols()).into_iter();
        points.filter(|(_, weight)| *weight > 0.0).collect()
    }

    /// The state at a point ξ.
    pub(crate) fn at(&self, point: &DVector<f64>) -> DVector<f64> {
        &self.mean + &self.root * point
    }

    /// R with R Rᵀ = C.
    pub(crate) fn root(&self) -> &DMatrix<f64> {
        &self.root
    }

    /// L with L R = 1: what makes standard normal numbers of deviations from the mean.
    pub(crate) fn whitener(&self) -> DMatrix<f64> {
        let units = self.covariance.diagonal().map(|variance| variance.max(0.0).sqrt());
        let scaled = |i: usize, k: usize| {
            if units[i] > 0.0 { self.root[(i, k)] / units[i] } else { 0.0 }
        };
        let (d, n) = (self.mean.len(), self.root.ncols());
        // The scaled root has orthogonal columns.
        let squares: Vec<f64> =
            (0..n).map(|k| (0..d).map(|i| scaled(i, k).powi(2)).sum()).collect();
        DMatrix::from_fn(n, d, |k, i| {
            if units[i] > 0.0 { scaled(i, k) / (squares[k] * units[i]) } else { 0.0 }
        })
    }

    /// Where ξ has this mean and covariance instead of 0 and 1.
    pub(crate) fn of_standard(
        &self,
        mean: &DVector<f64>,
        covariance: &DMatrix<f64>,
    ) -> Result<Self, FilterError> {
        let of_state = symmetric(&self.root * covariance * self.root.transpose());
        Self::new(self.at(mean), of_state)
    }

    /// The Gaussian with the moments of weighted ones, of any sum of weights.
    pub(crate) fn of_mixture(parts: &[(Self, f64)]) -> Result<Self, FilterError> {
        let first = parts.first().ok_or(FilterError::Empty { what: "components" })?;
        let expected = first.0.mean.len();
        if let Some((other, _)) = parts.iter().find(|(part, _)| part.mean.len() != expected) {
            let actual = other.mean.len();
            return Err(FilterError::ShapeMismatch { what: "component", expected, actual });
        }
        let total: f64 = parts.iter().map(|(_, weight)| weight).sum();
        let mut mean = DVector::zeros(expected);
        parts.iter().for_each(|(part, weight)| mean.axpy(weight / total, &part.mean, 1.0));
        let mut covariance = DMatrix::zeros(expected, expected);
        for (part, weight) in parts {
            let off = &part.mean - &mean;
            covariance += weight / total * (&part.covariance + &off * off.transpose());
        }
        Self::new(mean, covariance)
    }
}
