//! Variances of several sources of error at once, by restricted maximum likelihood.

use nalgebra::{DMatrix, DVector};
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

use crate::DiagnosisError;

/// Independent vectors y ~ N(X b, Σ θₖ Kₖ) with a common covariance.
#[derive(Clone, Debug)]
pub(crate) struct Block {
    /// A column each.
    pub(crate) vectors: DMatrix<f64>,
    /// Kₖ for each source of error.
    pub(crate) shapes: Vec<DMatrix<f64>>,
    /// X, whose coefficients b ~ N(0, 1) all blocks share; without columns, or for one vector.
    pub(crate) fixed: DMatrix<f64>,
}

/// What is known of a variance beforehand: ln θ is normal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LogNormal {
    /// Median of θ.
    pub(crate) median: f64,
    /// Standard deviation of ln θ.
    pub(crate) log_sd: f64,
}

/// Where the likelihood is largest.
#[derive(Clone, Debug)]
pub(crate) struct Variances {
    /// θ.
    pub(crate) values: Vec<f64>,
    /// Standard errors of ln θ.
    pub(crate) log_se: Vec<f64>,
    pub(crate) iterations: usize,
    /// Twice the gain in log likelihood that a further step would expect.
    pub(crate) decrement: f64,
}

const MAX_ITERATIONS: usize = 100;
/// What is left to gain is a tenth of a standard error.
const DECREMENT: f64 = 1e-2;
/// Shares of what a step promises: above the first one the next is damped less, below the second more.
const WELL_KEPT: f64 = 0.75;
const BADLY_KEPT: f64 = 0.25;
/// Longest change of ln θ in one iteration.
const LONGEST_STEP: f64 = 1.5;

/// The variances that make the blocks likeliest, times what is known beforehand.
///
/// Newton's method in ln θ with the average of observed and expected information, damped until the
/// likelihood grows.
///
/// # Errors
/// `NotConverged`.
///
/// # Source
/// Gilmour, Thompson & Cullis (1995), Average information REML, Biometrics 51(4).
pub(crate) fn variances(
    blocks: &[Block],
    prior: &[LogNormal],
) -> Result<Variances, DiagnosisError> {
    let mut log: Vec<f64> = prior.iter().map(|prior| prior.median.ln()).collect();
    let mut damping = 1e-3;
    let failed = |iterations: usize, decrement: f64| DiagnosisError::NotConverged {
        what: "the variances of the noise",
        iterations,
        decrement,
    };
    let mut here = Point::at(blocks, prior, &log).ok_or(failed(0, f64::INFINITY))?;
    let mut left = f64::INFINITY;
    for iterations in 0..MAX_ITERATIONS {
        let inverse = here.information.clone().cholesky();
        let inverse = inverse.ok_or(failed(iterations, f64::INFINITY))?.inverse();
        let decrement = here.slope.dot(&(&inverse * &here.slope));
        left = decrement;
        let next = match decrement < DECREMENT {
            true => None,
            false => here.climb(blocks, prior, &log, &mut damping),
        };
        let Some((next_log, next)) = next else {
            let log_se = inverse.diagonal().iter().map(|variance| variance.sqrt()).collect();
            let values = log.iter().map(|log| log.exp()).collect();
            // Where no step gains anything the slope is as flat as it gets.
            let is_flat = decrement < 1e2 * DECREMENT;
            let found = Variances { values, log_se, iterations, decrement };
            return if is_flat { Ok(found) } else { Err(failed(iterations, decrement)) };
        };
        (log, here) = (next_log, next);
    }
    Err(failed(MAX_ITERATIONS, left))
}

/// The logarithm of the likelihood at a point, with its slope and information in ln θ.
struct Point {
    value: f64,
    slope: DVector<f64>,
    information: DMatrix<f64>,
}

impl Point {
    /// None where the covariance is not positive definite.
    fn at(blocks: &[Block], prior: &[LogNormal], log: &[f64]) -> Option<Self> {
        let theta: Vec<f64> = log.iter().map(|log| log.exp()).collect();
        let solved: Option<Vec<Solved<'_>>> =
            blocks.par_iter().map(|block| Solved::of(block, &theta)).collect();
        let solved = solved?;
        let fixed = Fixed::of(&solved)?;
        let derivatives: Vec<Derivatives> =
            solved.par_iter().map(|block| block.derivatives(&fixed)).collect();
        let n = theta.len();
        let mut value = -0.5 * (fixed.log_determinant - fixed.fitted);
        value -= 0.5 * solved.iter().map(|block| block.log_determinant + block.square).sum::<f64>();
        let mut slope = DVector::zeros(n);
        let mut information = DMatrix::zeros(n, n);
        let mut of_fixed = DMatrix::zeros(fixed.coefficients.len(), n);
        for part in &derivatives {
            slope += 0.5 * &part.slope;
            information += 0.5 * &part.information;
            of_fixed += &part.of_fixed;
        }
        information -= 0.5 * of_fixed.transpose() * &fixed.inverse * &of_fixed;
        for k in 0..n {
            slope[k] *= theta[k];
            for l in 0..n {
                information[(k, l)] *= theta[k] * theta[l];
            }
        }
        for (k, prior) in prior.iter().enumerate() {
            let (miss, precision) = (log[k] - prior.median.ln(), prior.log_sd.powi(-2));
            value -= 0.5 * precision * miss * miss;
            slope[k] -= precision * miss;
            information[(k, k)] += precision;
        }
        Some(Self { value, slope, information })
    }

    /// A damped step that raises the likelihood; none if not even a tiny one does.
    fn climb(
        &self,
        blocks: &[Block],
        prior: &[LogNormal],
        log: &[f64],
        damping: &mut f64,
    ) -> Option<(Vec<f64>, Self)> {
        while *damping < 1e9 {
            let mut damped = self.information.clone();
            for k in 0..log.len() {
                damped[(k, k)] *= 1.0 + *damping;
            }
            let step = damped.cholesky()?.solve(&self.slope);
            let scale = (LONGEST_STEP / step.amax()).min(1.0);
            let next: Vec<f64> =
                log.iter().zip(step.iter()).map(|(log, step)| log + scale * step).collect();
            let step = scale * step;
            let promise = self.slope.dot(&step) - 0.5 * step.dot(&(&self.information * &step));
            if let Some(point) = Self::at(blocks, prior, &next).filter(|p| p.value > self.value) {
                let kept = (point.value - self.value) / promise;
                // Where sources trade off, the average information is too small: undamped steps go
                // back and forth across the ridge.
                if kept > WELL_KEPT {
                    *damping = (*damping / 10.0).max(1e-6);
                } else if kept < BADLY_KEPT {
                    *damping = (*damping * 10.0).max(1e-2);
                }
                return Some((next, point));
            }
            *damping *= 10.0;
        }
        None
    }
}

/// A block with the inverse W of its covariance.
struct Solved<'a> {
    block: &'a Block,
    inverse: DMatrix<f64>,
    /// W y and W X.
    vectors: DMatrix<f64>,
    fixed: DMatrix<f64>,
    /// ln det of the covariance, once a vector.
    log_determinant: f64,
    /// Σ yᵀ W y.
    square: f64,
}

/// The common coefficients b, given the variances.
struct Fixed {
    coefficients: DVector<f64>,
    /// (1 + Σ Xᵀ W X)⁻¹.
    inverse: DMatrix<f64>,
    log_determinant: f64,
    /// What they explain of Σ yᵀ W y.
    fitted: f64,
}

/// One block's part of slope and information, with respect to θ.
struct Derivatives {
    slope: DVector<f64>,
    information: DMatrix<f64>,
    /// Xᵀ W Kₖ P y.
    of_fixed: DMatrix<f64>,
}

impl<'a> Solved<'a> {
    fn of(block: &'a Block, theta: &[f64]) -> Option<Self> {
        let n = block.vectors.nrows();
        let mut covariance = DMatrix::zeros(n, n);
        for (theta, shape) in theta.iter().zip(&block.shapes) {
            covariance.zip_apply(shape, |sum: &mut f64, shape| *sum += theta * shape);
        }
        let factor = covariance.cholesky()?;
        let roots = factor.l_dirty().diagonal();
        let n_vectors = block.vectors.ncols() as f64;
        let log_determinant = 2.0 * n_vectors * roots.iter().map(|root| root.ln()).sum::<f64>();
        let inverse = factor.inverse();
        let (vectors, fixed) = (&inverse * &block.vectors, &inverse * &block.fixed);
        let square = block.vectors.dot(&vectors);
        Some(Self { block, inverse, vectors, fixed, log_determinant, square })
    }

    fn derivatives(&self, fixed: &Fixed) -> Derivatives {
        let shapes = &self.block.shapes;
        let (n, n_vectors) = (shapes.len(), self.vectors.ncols() as f64);
        let has_fixed = !fixed.coefficients.is_empty();
        let mut left = self.vectors.clone();
        if has_fixed {
            left.set_column(0, &(left.column(0) - &self.fixed * &fixed.coefficients));
        }
        let pulled: Vec<DMatrix<f64>> = shapes.iter().map(|shape| shape * &left).collect();
        let solved: Vec<DMatrix<f64>> =
            pulled.iter().map(|pulled| &self.inverse * pulled).collect();
        let slope = DVector::from_fn(n, |k, _| {
            let mut trace = n_vectors * self.inverse.dot(&shapes[k]);
            if has_fixed {
                let spread = self.fixed.transpose() * (&shapes[k] * &self.fixed);
                trace -= fixed.inverse.dot(&spread);
            }
            left.dot(&pulled[k]) - trace
        });
        let information = DMatrix::from_fn(n, n, |k, l| pulled[k].dot(&solved[l]));
        let mut of_fixed = DMatrix::zeros(fixed.coefficients.len(), n);
        if has_fixed {
            for (k, pulled) in pulled.iter().enumerate() {
                of_fixed.set_column(k, &(self.fixed.transpose() * pulled.column(0)));
            }
        }
        Derivatives { slope, information, of_fixed }
    }
}

impl Fixed {
    fn of(solved: &[Solved<'_>]) -> Option<Self> {
        let n = solved.first()?.fixed.ncols();
        let mut precision = DMatrix::identity(n, n);
        let mut right = DVector::zeros(n);
        if n > 0 {
            for block in solved {
                precision += block.block.fixed.transpose() * &block.fixed;
                right += block.fixed.transpose() * block.block.vectors.column(0);
            }
        }
        let factor = precision.cholesky()?;
        let log_determinant =
            2.0 * factor.l_dirty().diagonal().iter().map(|root| root.ln()).sum::<f64>();
        let coefficients = factor.solve(&right);
        let fitted = coefficients.dot(&right);
        Some(Self { coefficients, inverse: factor.inverse(), log_determinant, fitted })
    }
}

#[cfg(test)]
mod tests {
    use super::{Block, LogNormal, Point, variances};
    use nalgebra::{DMatrix, DVector};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn normal(rng: &mut ChaCha8Rng) -> f64 {
        let (radius, angle): (f64, f64) = (1.0 - rng.random::<f64>(), rng.random());
        (-2.0 * radius.ln()).sqrt() * (std::f64::consts::TAU * angle).cos()
    }

    /// Blocks of a shared and a white error; coefficients of size 3 where there are columns.
    fn blocks(n_blocks: usize, truth: [f64; 2], n_fixed: usize) -> Vec<Block> {
        const N: usize = 9;
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let block = |_| {
            let shared = DVector::from_fn(N, |k, _| 1.0 + (k as f64).sin());
            let fixed = DMatrix::from_fn(N, n_fixed, |_, _| normal(&mut rng));
            let amount = truth[0].sqrt() * normal(&mut rng);
            let mut y =
                DVector::from_fn(N, |k, _| amount * shared[k] + truth[1].sqrt() * normal(&mut rng));
            fixed.column_iter().for_each(|column| y.axpy(1.5, &column, 1.0));
            let vectors = DMatrix::from_columns(&[y]);
            let shapes = vec![&shared * shared.transpose(), DMatrix::identity(N, N)];
            Block { vectors, shapes, fixed }
        };
        (0..n_blocks).map(block).collect()
    }

    fn vague() -> Vec<LogNormal> {
        vec![LogNormal { median: 1.0, log_sd: 5.0 }, LogNormal { median: 0.1, log_sd: 5.0 }]
    }

    #[test]
    fn variances_of_many_blocks_are_found_within_their_errors() {
        for n_fixed in [0, 2] {
            let truth = [0.04, 0.5];
            let found = variances(&blocks(400, truth, n_fixed), &vague()).unwrap();
            for ((value, se), truth) in found.values.iter().zip(&found.log_se).zip(truth) {
                assert!((value / truth).ln().abs() < 3.0 * se, "{value} {se} {truth}");
            }
            // 400 blocks of nine numbers tell the white variance to √(2/(400·8)).
            assert!((found.log_se[1] / (2.0_f64 / 3200.0).sqrt() - 1.0).abs() < 0.1);
        }
    }

    #[test]
    fn the_slope_is_that_of_the_likelihood() {
        for n_fixed in [0, 2] {
            let blocks = blocks(6, [0.3, 0.2], n_fixed);
            let log = [-0.7, -1.9];
            let here = Point::at(&blocks, &vague(), &log).unwrap();
            for k in 0..2 {
                let value = |step: f64| {
                    let mut log = log;
                    log[k] += step;
                    Point::at(&blocks, &vague(), &log).unwrap().value
                };
                let slope = (value(1e-5) - value(-1e-5)) / 2e-5;
                assert!((slope - here.slope[k]).abs() < 1e-6 * (1.0 + slope.abs()), "{k} {slope}");
            }
        }
    }

    /// White errors of two kinds, of which every block has nearly the same mixture.
    #[test]
    fn sources_that_trade_off_are_told_apart_as_far_as_they_can_be() {
        let mut blocks = blocks(12, [0.04, 0.5], 0);
        for (place, block) in blocks.iter_mut().enumerate() {
            let size = |row: usize| 1.0 + 0.3 * ((row + place) as f64).sin();
            let other = DMatrix::from_fn(9, 9, |i, k| if i == k { size(i).powi(2) } else { 0.0 });
            block.shapes.push(other);
        }
        let prior = [vague()[0], vague()[1], LogNormal { median: 10.0, log_sd: 2.0 }];
        let found = variances(&blocks, &prior).unwrap();
        assert!(found.iterations < 40, "{found:?}");
        assert!((found.values[1] + found.values[2] - 0.5).abs() < 0.2, "{found:?}");
    }

    #[test]
    fn a_source_that_no_number_shows_keeps_what_was_believed() {
        let mut blocks = blocks(40, [0.04, 0.5], 0);
        blocks.iter_mut().for_each(|block| block.shapes[0].fill(0.0));
        let prior = [LogNormal { median: 7.0, log_sd: 1.0 }, vague()[1]];
        let found = variances(&blocks, &prior).unwrap();
        assert!((found.values[0] / 7.0 - 1.0).abs() < 1e-6 && (found.log_se[0] - 1.0).abs() < 1e-6);
    }
}
