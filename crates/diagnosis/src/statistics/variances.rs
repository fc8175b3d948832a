//! Variances of several sources of error at once, by restricted maximum likelihood.

use nalgebra::{DMatrix, DVector};
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

use crate::statistics::blocks::{Block, Derivatives, Fixed, Solved};

/// What is known of a variance beforehand: ln θ is normal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LogNormal {
    /// Median of θ.
    pub(crate) median: f64,
    /// Standard deviation of ln θ.
    pub(crate) log_sd: f64,
    /// No larger θ is possible.
    pub(crate) largest: f64,
}

/// Where the likelihood is largest.
#[derive(Clone, Debug)]
pub(crate) struct Variances {
    /// θ.
    pub(crate) values: Vec<f64>,
    /// Standard errors of ln θ; of what did not converge those of the prior.
    pub(crate) log_se: Vec<f64>,
    /// The same by the scatter of the blocks' own slopes where that is larger: of many blocks it is nearer to
    /// the truth, for no source is quite of the shape that it is taken for.
    pub(crate) robust_log_se: Vec<f64>,
    /// Sources that did not converge: left out, or where nothing else shows in a number as large as was
    /// believed; and those as large as was believed that were likeliest at an impossible size.
    pub(crate) dropped: Vec<usize>,
    /// Blocks that say nothing, for a number of theirs has no source of error or is beyond reckoning.
    pub(crate) n_unused: usize,
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
/// likelihood grows. Where it does not settle, the source that is farthest from settling is dropped and
/// the others are searched for again; without blocks all keep what was believed. What is likeliest at an impossible
/// size stands for something else: it stays as was believed, and the others are searched for again.
///
/// # Source
/// Gilmour, Thompson & Cullis (1995), Average information REML, Biometrics 51(4).
pub(crate) fn variances(blocks: &[Block], prior: &[LogNormal]) -> Variances {
    let believed: Vec<f64> = prior.iter().map(|prior| prior.median).collect();
    let is_used = |block: &&Block| {
        Solved::of(block, &believed).is_some_and(|solved| solved.square.is_finite())
    };
    let used: Vec<&Block> = blocks.iter().filter(is_used).collect();
    let n_unused = blocks.len() - used.len();
    let mut problem = Problem { blocks: used, prior, held: vec![None; prior.len()] };
    let mut iterations = 0;
    while problem.held.iter().any(Option::is_none) && !problem.blocks.is_empty() {
        match problem.climbed(&mut iterations) {
            Ok(top) => match problem.impossible(&top) {
                Some(source) => problem.held[source] = Some(believed[source]),
                None => return Variances { n_unused, iterations, ..problem.variances(&top) },
            },
            Err(unsettled) => problem.drop(unsettled, &believed),
        }
    }
    Variances {
        values: problem
            .held
            .iter()
            .zip(&believed)
            .map(|(held, own)| held.unwrap_or(*own))
            .collect(),
        log_se: prior.iter().map(|prior| prior.log_sd).collect(),
        robust_log_se: prior.iter().map(|prior| prior.log_sd).collect(),
        dropped: problem.dropped(),
        n_unused,
        iterations,
        decrement: 0.0,
    }
}

/// Blocks, and what is searched for.
struct Problem<'a> {
    blocks: Vec<&'a Block>,
    prior: &'a [LogNormal],
    /// θ of the sources that are not searched for.
    held: Vec<Option<f64>>,
}

/// A place where the likelihood is as large as it gets.
struct Top {
    log: Vec<f64>,
    inverse: DMatrix<f64>,
    /// The same by the scatter of the blocks' slopes.
    sandwich: DMatrix<f64>,
    decrement: f64,
}

impl Problem<'_> {
    /// The top, or the source that is farthest from it.
    fn climbed(&self, iterations: &mut usize) -> Result<Top, usize> {
        let mut log: Vec<f64> = self.prior.iter().map(|prior| prior.median.ln()).collect();
        let mut damping = 1e-3;
        let mut here = self.at(&log).ok_or_else(|| self.first_free())?;
        for _ in 0..MAX_ITERATIONS {
            let inverse = here.information.clone().cholesky();
            let inverse = inverse.ok_or_else(|| self.farthest(&here))?.inverse();
            let decrement = here.slope.dot(&(&inverse * &here.slope));
            let next = match decrement < DECREMENT {
                true => None,
                false => self.climb(&here, &log, &mut damping),
            };
            let Some((next_log, next)) = next else {
                // Where no step gains anything the slope is as flat as it gets.
                let is_flat = decrement < 1e2 * DECREMENT;
                return if is_flat {
                    let sandwich = &inverse * &here.scatter * &inverse;
                    Ok(Top { log, inverse, sandwich, decrement })
                } else {
                    Err(self.farthest(&here))
                };
            };
            (log, here) = (next_log, next);
            *iterations += 1;
        }
        Err(self.farthest(&here))
    }

    /// Of the sources searched for the one with the largest slope in its own standard errors.
    fn farthest(&self, here: &Point) -> usize {
        let far = |k: &usize| {
            let far = here.slope[*k].powi(2) / here.information[(*k, *k)].abs();
            if far.is_nan() { f64::INFINITY } else { far }
        };
        let free = (0..self.held.len()).filter(|k| self.held[*k].is_none());
        free.max_by(|a, b| far(a).total_cmp(&far(b))).unwrap_or_default()
    }

    /// Of the sources searched for the one that is farthest beyond what is possible.
    fn impossible(&self, top: &Top) -> Option<usize> {
        let beyond = |k: usize| top.log[k] - self.prior[k].largest.ln();
        let some = (0..self.held.len()).filter(|k| self.held[*k].is_none() && beyond(*k) > 0.0);
        some.max_by(|a, b| beyond(*a).total_cmp(&beyond(*b)))
    }

    fn first_free(&self) -> usize {
        self.held.iter().position(Option::is_none).unwrap_or_default()
    }

    /// Leaves a source out, or holds it where it was believed if some numbers have no other one.
    fn drop(&mut self, source: usize, believed: &[f64]) {
        let mut without = believed.to_vec();
        self.held.iter().zip(&mut without).for_each(|(held, own)| *own = held.unwrap_or(*own));
        without[source] = 0.0;
        let can_do_without = self.blocks.iter().all(|block| Solved::of(block, &without).is_some());
        self.held[source] = Some(if can_do_without { 0.0 } else { believed[source] });
    }

    fn dropped(&self) -> Vec<usize> {
        (0..self.held.len()).filter(|k| self.held[*k].is_some()).collect()
    }

    fn variances(&self, top: &Top) -> Variances {
        let value = |k: usize| self.held[k].unwrap_or_else(|| top.log[k].exp());
        let log_se = |k: usize, variance: f64| match self.held[k] {
            Some(_) => self.prior[k].log_sd,
            None => variance.sqrt(),
        };
        let [curved, scattered] = [&top.inverse, &top.sandwich].map(DMatrix::diagonal);
        let robust = curved.zip_map(&scattered, f64::max);
        let all = |variances: &DVector<f64>| {
            variances.iter().enumerate().map(|(k, variance)| log_se(k, *variance)).collect()
        };
        Variances {
            values: (0..self.held.len()).map(value).collect(),
            log_se: all(&curved),
            robust_log_se: all(&robust),
            dropped: self.dropped(),
            n_unused: 0,
            iterations: 0,
            decrement: top.decrement,
        }
    }

    /// None where the covariance is not positive definite, or a number too large.
    fn at(&self, log: &[f64]) -> Option<Point> {
        let theta: Vec<f64> =
            log.iter().zip(&self.held).map(|(log, held)| held.unwrap_or(log.exp())).collect();
        let solved: Option<Vec<Solved<'_>>> =
            self.blocks.par_iter().map(|block| Solved::of(block, &theta)).collect();
        let solved = solved?;
        let fixed = Fixed::of(&solved)?;
        let derivatives: Vec<Derivatives> =
            solved.par_iter().map(|block| block.derivatives(&fixed)).collect();
        let n = theta.len();
        let mut value = -0.5 * (fixed.log_determinant - fixed.fitted);
        value -= 0.5 * solved.iter().map(|block| block.log_determinant + block.square).sum::<f64>();
        let mut slope = DVector::zeros(n);
        let mut information = DMatrix::zeros(n, n);
        let mut scatter = DMatrix::zeros(n, n);
        let mut of_fixed = DMatrix::zeros(fixed.coefficients.len(), n);
        for part in &derivatives {
            slope += 0.5 * &part.slope;
            information += 0.5 * &part.information;
            scatter += 0.25 * &part.slope * part.slope.transpose();
            of_fixed += &part.of_fixed;
        }
        information -= 0.5 * of_fixed.transpose() * &fixed.inverse * &of_fixed;
        for k in 0..n {
            slope[k] *= theta[k];
            for l in 0..n {
                information[(k, l)] *= theta[k] * theta[l];
                scatter[(k, l)] *= theta[k] * theta[l];
            }
        }
        for (k, prior) in self.prior.iter().enumerate() {
            if self.held[k].is_some() {
                slope[k] = 0.0;
                information.row_mut(k).fill(0.0);
                information.column_mut(k).fill(0.0);
                information[(k, k)] = 1.0;
                scatter.row_mut(k).fill(0.0);
                scatter.column_mut(k).fill(0.0);
                continue;
            }
            let (miss, precision) = (log[k] - prior.median.ln(), prior.log_sd.powi(-2));
            value -= 0.5 * precision * miss * miss;
            slope[k] -= precision * miss;
            information[(k, k)] += precision;
            scatter[(k, k)] += precision;
        }
        value.is_finite().then_some(Point { value, slope, information, scatter })
    }

    /// A damped step that raises the likelihood; none if not even a tiny one does.
    fn climb(&self, here: &Point, log: &[f64], damping: &mut f64) -> Option<(Vec<f64>, Point)> {
        while *damping < 1e9 {
            let mut damped = here.information.clone();
            for k in 0..log.len() {
                damped[(k, k)] *= 1.0 + *damping;
            }
            let step = damped.cholesky()?.solve(&here.slope);
            let scale = (LONGEST_STEP / step.amax()).min(1.0);
            let next: Vec<f64> =
                log.iter().zip(step.iter()).map(|(log, step)| log + scale * step).collect();
            let step = scale * step;
            let promise = here.slope.dot(&step) - 0.5 * step.dot(&(&here.information * &step));
            if let Some(point) = self.at(&next).filter(|point| point.value > here.value) {
                let kept = (point.value - here.value) / promise;
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

/// The logarithm of the likelihood at a point, with its slope and information in ln θ.
struct Point {
    value: f64,
    slope: DVector<f64>,
    information: DMatrix<f64>,
    /// Sum of the squares of the blocks' slopes, and of what the prior's would be.
    scatter: DMatrix<f64>,
}

#[cfg(test)]
mod tests {
    use super::{LogNormal, Problem, variances};
    use crate::statistics::blocks::Block;
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
        vec![
            LogNormal { median: 1.0, log_sd: 5.0, largest: f64::INFINITY },
            LogNormal { median: 0.1, log_sd: 5.0, largest: f64::INFINITY },
        ]
    }

    #[test]
    fn variances_of_many_blocks_are_found_within_their_errors() {
        for n_fixed in [0, 2] {
            let truth = [0.04, 0.5];
            let found = variances(&blocks(400, truth, n_fixed), &vague());
            for ((value, se), truth) in found.values.iter().zip(&found.log_se).zip(truth) {
                assert!((value / truth).ln().abs() < 3.0 * se, "{value} {se} {truth}");
            }
            // 400 blocks of nine numbers tell the white variance to √(2/(400·8)).
            assert!((found.log_se[1] / (2.0_f64 / 3200.0).sqrt() - 1.0).abs() < 0.1);
        }
    }

    #[test]
    fn what_is_likeliest_at_an_impossible_size_stays_as_believed() {
        let blocks = blocks(400, [0.04, 0.5], 0);
        let up_to = |largest: f64| {
            let [shared, white] = [vague()[0], vague()[1]];
            variances(&blocks, &[LogNormal { median: 1e-3, largest, ..shared }, white])
        };
        let (free, held) = (up_to(0.1), up_to(0.01));
        assert!(free.dropped.is_empty() && free.values == up_to(f64::INFINITY).values);
        assert_eq!((held.dropped, held.values[0]), (vec![0], 1e-3));
        // What it does not explain is white.
        assert!(held.values[1] > 1.02 * free.values[1], "{:?} {:?}", held.values, free.values);
    }

    #[test]
    fn a_block_without_numbers_tells_nothing() {
        for n_fixed in [0, 2] {
            let mut with = blocks(40, [0.04, 0.5], n_fixed);
            let without = variances(&with, &vague());
            let none = DMatrix::zeros(0, 0);
            with.push(Block {
                vectors: DMatrix::zeros(0, 1),
                shapes: vec![none.clone(), none],
                fixed: DMatrix::zeros(0, n_fixed),
            });
            assert_eq!(variances(&with, &vague()).values, without.values);
        }
    }

    #[test]
    fn the_slope_is_that_of_the_likelihood() {
        for n_fixed in [0, 2] {
            let blocks = blocks(6, [0.3, 0.2], n_fixed);
            let log = [-0.7, -1.9];
            let prior = vague();
            let problem =
                Problem { blocks: blocks.iter().collect(), prior: &prior, held: vec![None; 2] };
            let here = problem.at(&log).unwrap();
            for k in 0..2 {
                let value = |step: f64| {
                    let mut log = log;
                    log[k] += step;
                    problem.at(&log).unwrap().value
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
        let prior = [
            vague()[0],
            vague()[1],
            LogNormal { median: 10.0, log_sd: 2.0, largest: f64::INFINITY },
        ];
        let found = variances(&blocks, &prior);
        assert!(found.iterations < 40, "{found:?}");
        assert!((found.values[1] + found.values[2] - 0.5).abs() < 0.2, "{found:?}");
    }

    #[test]
    fn a_source_that_no_number_shows_keeps_what_was_believed() {
        let mut blocks = blocks(40, [0.04, 0.5], 0);
        blocks.iter_mut().for_each(|block| block.shapes[0].fill(0.0));
        let prior = [LogNormal { median: 7.0, log_sd: 1.0, largest: f64::INFINITY }, vague()[1]];
        let found = variances(&blocks, &prior);
        assert!((found.values[0] / 7.0 - 1.0).abs() < 1e-6 && (found.log_se[0] - 1.0).abs() < 1e-6);
    }

    #[test]
    fn without_any_block_all_keep_what_was_believed() {
        let found = variances(&[], &vague());
        assert_eq!((found.values, found.log_se), (vec![1.0, 0.1], vec![5.0; 2]));
        assert!(found.dropped.is_empty());
    }

    #[test]
    fn a_block_with_a_number_of_no_source_or_beyond_reckoning_is_passed_over() {
        let spoil: [fn(&mut Block); 2] = [
            |block| {
                for shape in &mut block.shapes {
                    shape.row_mut(3).fill(0.0);
                    shape.column_mut(3).fill(0.0);
                }
            },
            |block| block.vectors[4] = 1e200,
        ];
        for spoil in spoil {
            let mut all = blocks(400, [0.04, 0.5], 0);
            spoil(&mut all[7]);
            let found = variances(&all, &vague());
            assert_eq!((found.n_unused, found.dropped.len()), (1, 0));
            let kept: Vec<Block> =
                all.into_iter().enumerate().filter(|(k, _)| *k != 7).map(|(_, b)| b).collect();
            assert_eq!(found.values, variances(&kept, &vague()).values);
        }
    }

    /// Its shape is no covariance: there is no place where its slope is zero.
    #[test]
    fn a_source_that_does_not_settle_is_dropped_and_the_others_are_found() {
        for n_fixed in [0, 2] {
            let mut all = blocks(200, [0.04, 0.5], n_fixed);
            for block in &mut all {
                let mut shape = DMatrix::zeros(9, 9);
                (shape[(0, 0)], shape[(1, 1)]) = (1.0, -1.0);
                (block.vectors[0], block.vectors[1]) = (40.0, 0.0);
                block.shapes.push(shape);
            }
            let prior = [
                vague()[0],
                vague()[1],
                LogNormal { median: 1e-3, log_sd: 1e3, largest: f64::INFINITY },
            ];
            let found = variances(&all, &prior);
            assert!(found.values.iter().chain(&found.log_se).all(|value| value.is_finite()));
            assert!(found.dropped.contains(&2) && found.values[1] > 0.0, "{found:?}");
        }
    }
}
