//! Where pseudo-inputs stand, or start.

use faer::{Mat, MatRef};
use gp_core::checks::check_inputs;
use gp_core::kernel::{column, copy_row};
use gp_core::vector::dot;
use gp_core::{GpError, Kernel};
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// The pseudo-inputs of a process that is to be learnt.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum PseudoInputs {
    /// Placed among the rows, then learnt together with the hyperparameters.
    Learnt {
        /// How many.
        count: usize,
        /// Where they start.
        placement: Placement,
    },
    /// Placed among the rows and kept there.
    Placed {
        /// How many.
        count: usize,
        /// Where they are.
        placement: Placement,
    },
    /// Given, M×D, and kept.
    Given(Mat<f64>),
}

/// How pseudo-inputs are placed among the rows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Placement {
    /// One after the other at the row whose variance given the others is largest; fewer than asked
    /// for where what is left is below 1e-6 of the prior variance.
    #[default]
    GreedyVariance,
    /// The centers of k-means clusters, started by k-means++.
    KMeans,
}

impl PseudoInputs {
    /// The number asked for.
    pub fn count(&self) -> usize {
        match self {
            Self::Learnt { count, .. } | Self::Placed { count, .. } => *count,
            Self::Given(z) => z.nrows(),
        }
    }

    /// Whether they move.
    pub(crate) fn are_learnt(&self) -> bool {
        matches!(self, Self::Learnt { .. })
    }

    /// The pseudo-inputs by rows.
    ///
    /// # Errors
    /// `Empty`, `ShapeMismatch`, `NotFinite` of given ones; `OutOfRange` if more are asked for than there are rows, or none.
    pub(crate) fn place(
        &self,
        kernel: &dyn Kernel,
        x: MatRef<'_, f64>,
        seed: u64,
    ) -> Result<Vec<f64>, GpError> {
        let (count, placement) = match self {
            Self::Learnt { count, placement } | Self::Placed { count, placement } => {
                (*count, *placement)
            }
            Self::Given(z) => {
                check_inputs("pseudo-inputs", z.as_ref(), x.ncols())?;
                return Ok(crate::sparse_gp::rows_of(z.as_ref()));
            }
        };
        if count == 0 || count > x.nrows() {
            return Err(GpError::OutOfRange {
                name: "number of pseudo-inputs".to_owned(),
                value: count as f64,
                lowest: 1.0,
                highest: x.nrows() as f64,
            });
        }
        let rows = candidates(x.nrows(), count, seed);
        let x = Mat::from_fn(rows.len(), x.ncols(), |i, d| x[(rows[i], d)]);
        Ok(match placement {
            Placement::GreedyVariance => greedy_variance(kernel, &x, count),
            Placement::KMeans => k_means(&x, count, seed),
        })
    }
}

/// Rows among which pseudo-inputs are placed: all, or a random part of many.
fn candidates(n: usize, count: usize, seed: u64) -> Vec<usize> {
    let mut rows = shuffled_rows(n, seed);
    rows.truncate((10 * count).max(2000));
    rows
}

/// All row numbers in a random order.
pub(crate) fn shuffled_rows(n: usize, seed: u64) -> Vec<usize> {
    let mut rows: Vec<usize> = (0..n).collect();
    rows.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
    rows
}

/// A Cholesky factorisation with pivoting that stops after `count` columns; O(N count²).
fn greedy_variance(kernel: &dyn Kernel, x: &Mat<f64>, count: usize) -> Vec<f64> {
    let n = x.nrows();
    let mut rest = vec![0.0; n];
    kernel.diagonal(x.as_ref(), &mut rest);
    let least = 1e-6 * rest.iter().fold(0.0_f64, |largest, value| largest.max(*value));
    let (mut z, mut row) = (Vec::new(), vec![0.0; x.ncols()]);
    // By rows of the data: entry k of row i is its covariance with the k-th pivot, whitened.
    let mut factor = vec![0.0; n * count];
    let mut values = vec![0.0; n];
    for k in 0..count {
        let pivot = (0..n).fold(0, |best, i| if rest[i] > rest[best] { i } else { best });
        if rest[pivot] <= least {
            break;
        }
        copy_row(x.as_ref(), pivot, &mut row);
        z.extend_from_slice(&row);
        kernel.column(x.as_ref(), &row, &mut values);
        let root = rest[pivot].sqrt();
        let of_pivot = factor[pivot * count..pivot * count + k].to_vec();
        for (i, known) in factor.chunks_exact_mut(count).enumerate() {
            known[k] = (values[i] - dot(&of_pivot, &known[..k])) / root;
            rest[i] -= known[k] * known[k];
        }
        rest[pivot] = 0.0;
    }
    z
}

/// Centers after ten rounds of Lloyd's iteration from k-means++, in inputs of unit variance.
///
/// # Source
/// Arthur & Vassilvitskii, k-means++: the advantages of careful seeding (2007).
fn k_means(x: &Mat<f64>, count: usize, seed: u64) -> Vec<f64> {
    let scales: Vec<f64> = (0..x.ncols()).map(|d| inverse_spread(column(x, d))).collect();
    let distance = |i: usize, center: &[f64]| -> f64 {
        let term = |d: usize| ((x[(i, d)] - center[d]) * scales[d]).powi(2);
        (0..x.ncols()).map(term).sum()
    };
    let mut centers = first_centers(x, count, seed, &distance);
    for _ in 0..10 {
        let mut sums = vec![vec![0.0; x.ncols()]; centers.len()];
        let mut counts = vec![0_usize; centers.len()];
        for i in 0..x.nrows() {
            let nearest = |best: (usize, f64), (c, center): (usize, &Vec<f64>)| {
                let distance = distance(i, center);
                if distance < best.1 { (c, distance) } else { best }
            };
            let (c, _) = centers.iter().enumerate().fold((0, f64::INFINITY), nearest);
            counts[c] += 1;
            sums[c].iter_mut().enumerate().for_each(|(d, sum)| *sum += x[(i, d)]);
        }
        for ((center, sum), n) in centers.iter_mut().zip(sums).zip(counts) {
            if n > 0 {
                *center = sum.iter().map(|sum| sum / n as f64).collect();
            }
        }
    }
    centers.concat()
}

/// Rows drawn with a probability in proportion to the squared distance to those drawn before.
fn first_centers(
    x: &Mat<f64>,
    count: usize,
    seed: u64,
    distance: &dyn Fn(usize, &[f64]) -> f64,
) -> Vec<Vec<f64>> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let row = |i: usize| -> Vec<f64> { (0..x.ncols()).map(|d| x[(i, d)]).collect() };
    let mut centers = vec![row(rng.random_range(0..x.nrows()))];
    let mut nearest = vec![f64::INFINITY; x.nrows()];
    while centers.len() < count {
        let newest = centers.last().expect("there is a first center");
        for (i, nearest) in nearest.iter_mut().enumerate() {
            *nearest = nearest.min(distance(i, newest));
        }
        let mut left = rng.random::<f64>() * nearest.iter().sum::<f64>();
        let passed = |weight: &f64| {
            left -= weight;
            *weight > 0.0 && left <= 0.0
        };
        // All rows repeat a center when no distance is left.
        match nearest.iter().position(passed) {
            Some(next) => centers.push(row(next)),
            None => break,
        }
    }
    centers
}

/// 1 over the standard deviation; 0 for equal values.
fn inverse_spread(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / n;
    if variance > 0.0 { variance.sqrt().recip() } else { 0.0 }
}

/// The standard deviation of an input; 1 for equal values.
pub(crate) fn spread(x: MatRef<'_, f64>, d: usize) -> f64 {
    let n = x.nrows() as f64;
    let mean = x.col(d).iter().sum::<f64>() / n;
    let variance = x.col(d).iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n;
    if variance > 0.0 { variance.sqrt() } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use faer::Mat;
    use gp_core::SquaredExponential;

    use super::{Placement, PseudoInputs};

    fn place(placement: Placement, x: &Mat<f64>, count: usize) -> Vec<f64> {
        let kernel = SquaredExponential::unit(1).unwrap();
        PseudoInputs::Placed { count, placement }.place(&kernel, x.as_ref(), 3).unwrap()
    }

    #[test]
    fn three_clusters_get_one_center_each() {
        let x = Mat::from_fn(60, 1, |i, _| 10.0 * (i % 3) as f64 + 0.01 * (i / 3) as f64);
        for placement in [Placement::GreedyVariance, Placement::KMeans] {
            let mut z = place(placement, &x, 3);
            z.sort_by(f64::total_cmp);
            let expected = [0.1, 10.1, 20.1];
            assert!(z.iter().zip(expected).all(|(z, e)| (z - e).abs() < 0.11), "{z:?}");
        }
    }

    #[test]
    fn rows_that_add_nothing_are_left_out() {
        let x = Mat::from_fn(20, 1, |i, _| (i % 2) as f64);
        assert_eq!(place(Placement::GreedyVariance, &x, 5).len(), 2);
        assert_eq!(place(Placement::KMeans, &x, 5).len(), 2);
    }
}
