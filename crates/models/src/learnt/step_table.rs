//! What processes of (p, β) believe, read from a grid.

use faer::{Mat, MatRef};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::{ModelError, Noise, StepInput, StepPrediction};

/// Means and standard deviations on a grid over (p, β), between whose nodes cubics run.
///
/// A read costs 16 nodes, whatever the process: O(1) where a sparse one needs O(M²). The grid is
/// halved until random places between its nodes are as near to the processes as [`TableReport`]
/// says; the processes are asked beyond it.
#[derive(Clone, Debug)]
pub(crate) struct StepTable {
    /// Along p and along β.
    n: [usize; 2],
    /// By rows of equal p.
    nodes: Vec<Belief>,
}

/// What three processes believe at one place, per meter of way.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Belief {
    pub(crate) mean: [f64; 3],
    /// Of an observation.
    pub(crate) observed_sd: [f64; 3],
    /// Of the function.
    pub(crate) function_sd: [f64; 3],
}

/// How near a table is to its processes, by the worst of the outputs at random places.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TableReport {
    /// Nodes along p and along β.
    pub n: [usize; 2],
    /// Error of the mean, over the standard deviation of an observation there: at most 0.01.
    pub mean_error: f64,
    /// Error of the variance of the function or of an observation, over that of an observation there:
    /// at most 10⁻³.
    pub variance_error: f64,
}

const MEAN_ERROR: f64 = 1e-2;
const VARIANCE_ERROR: f64 = 1e-3;
/// β within ± this, in rad: a little more than pushes that press.
const WIDEST: f64 = 1.65;
const COARSEST: usize = 17;
const FINEST: usize = 513;
/// Random places at which a table is compared with its processes.
const N_TRIED: usize = 2000;

impl StepTable {
    /// Of what processes believe at inputs, one (p, β) a row.
    ///
    /// # Errors
    /// `TableTooCoarse` for processes that vary faster than the finest grid; what they say.
    pub(crate) fn of(
        believed: impl Fn(MatRef<'_, f64>) -> Result<Vec<Belief>, ModelError>,
    ) -> Result<(Self, TableReport), ModelError> {
        let mut random = ChaCha8Rng::seed_from_u64(7);
        let mut place = || [random.random(), WIDEST * (2.0 * random.random::<f64>() - 1.0)];
        let tried: Vec<[f64; 2]> = (0..N_TRIED).map(|_| place()).collect();
        let truth = believed(Mat::from_fn(N_TRIED, 2, |i, d| tried[i][d]).as_ref())?;
        let mut n = COARSEST;
        loop {
            let at = |i: usize, d: usize| match d {
                0 => (i / n) as f64 / (n - 1) as f64,
                _ => WIDEST * (2.0 * (i % n) as f64 / (n - 1) as f64 - 1.0),
            };
            let nodes = believed(Mat::from_fn(n * n, 2, at).as_ref())?;
            let table = Self { n: [n; 2], nodes };
            let report = table.compared(&tried, &truth);
            if report.mean_error <= MEAN_ERROR && report.variance_error <= VARIANCE_ERROR {
                return Ok((table, report));
            }
            if n >= FINEST {
                let TableReport { mean_error, variance_error, .. } = report;
                return Err(ModelError::TableTooCoarse { mean_error, variance_error });
            }
            n = 2 * n - 1;
        }
    }

    /// Fills predictions of steps; returns those beyond the table.
    pub(crate) fn read(
        &self,
        steps: &[StepInput],
        noise: Noise,
        predictions: &mut [StepPrediction],
    ) -> Vec<usize> {
        let mut beyond = Vec::new();
        for (i, (step, prediction)) in steps.iter().zip(predictions).enumerate() {
            let Some(belief) = self.at([step.p(), step.beta()]) else {
                beyond.push(i);
                continue;
            };
            let sd = match noise {
                Noise::Included => belief.observed_sd,
                Noise::Excluded => belief.function_sd,
            };
            let distance = step.distance();
            for (k, (mean, sd)) in belief.mean.iter().zip(sd).enumerate() {
                prediction.mean[k] = mean * distance;
                prediction.covariance[(k, k)] = (sd * distance).powi(2);
            }
        }
        beyond
    }

    /// What is believed at a place; none beyond the grid.
    fn at(&self, [p, beta]: [f64; 2]) -> Option<Belief> {
        let shares = [p, 0.5 * (beta / WIDEST + 1.0)];
        if !shares.iter().all(|share| (0.0..=1.0).contains(share)) {
            return None;
        }
        let (row, along_p) = cubic(shares[0], self.n[0]);
        let (column, along_beta) = cubic(shares[1], self.n[1]);
        let mut sum = Belief::default();
        for (i, of_p) in along_p.iter().enumerate() {
            let start = (row + i) * self.n[1] + column;
            for (node, of_beta) in self.nodes[start..start + 4].iter().zip(&along_beta) {
                sum.add(of_p * of_beta, node);
            }
        }
        Some(sum)
    }

    fn compared(&self, tried: &[[f64; 2]], truth: &[Belief]) -> TableReport {
        let (mut mean_error, mut variance_error) = (0.0_f64, 0.0_f64);
        let within =
            tried.iter().zip(truth).filter_map(|(place, truth)| Some((self.at(*place)?, truth)));
        for (found, truth) in within {
            for k in 0..3 {
                let sd = truth.observed_sd[k].max(f64::MIN_POSITIVE);
                let off =
                    |found: f64, truth: f64| (found * found - truth * truth).abs() / (sd * sd);
                mean_error = mean_error.max((found.mean[k] - truth.mean[k]).abs() / sd);
                variance_error = variance_error
                    .max(off(found.observed_sd[k], truth.observed_sd[k]))
                    .max(off(found.function_sd[k], truth.function_sd[k]));
            }
        }
        TableReport { n: self.n, mean_error, variance_error }
    }
}

impl Belief {
    fn add(&mut self, weight: f64, other: &Self) {
        for k in 0..3 {
            self.mean[k] += weight * other.mean[k];
            self.observed_sd[k] += weight * other.observed_sd[k];
            self.function_sd[k] += weight * other.function_sd[k];
        }
    }
}

/// The first of four nodes about a share of an axis with `n` nodes, and their weights by Lagrange.
fn cubic(share: f64, n: usize) -> (usize, [f64; 4]) {
    let place = share * (n - 1) as f64;
    let first = (place as usize).saturating_sub(1).min(n - 4);
    let t = place - (first + 1) as f64;
    let (before, after, beyond) = (t + 1.0, t - 1.0, t - 2.0);
    let weights = [
        -t * after * beyond / 6.0,
        before * after * beyond / 2.0,
        -before * t * beyond / 2.0,
        before * t * after / 6.0,
    ];
    (first, weights)
}

#[cfg(test)]
mod tests {
    use super::{Belief, StepTable, WIDEST, cubic};
    use crate::ModelError;

    #[test]
    fn cubics_are_kept_exactly_everywhere() {
        let f = |x: f64| 1.0 + x - 3.0 * x * x + 2.0 * x * x * x;
        for k in 0..=100 {
            let share = f64::from(k) / 100.0;
            let (first, weights) = cubic(share, 7);
            let node = |i: usize| f((first + i) as f64 / 6.0);
            let value: f64 = (0..4).map(|i| weights[i] * node(i)).sum();
            assert!((value - f(share)).abs() < 1e-14, "{share}");
        }
    }

    #[test]
    fn a_table_is_as_fine_as_what_it_holds_asks_for_and_says_when_that_is_too_fine() {
        let wave = |waves: f64| {
            StepTable::of(move |x| {
                let belief = |i: usize| {
                    let wave = (waves * (x[(i, 0)] + 0.3 * x[(i, 1)] / WIDEST)).sin();
                    let sd = [1.0 + 0.5 * wave; 3];
                    Belief { mean: [wave; 3], observed_sd: sd, function_sd: sd }
                };
                Ok((0..x.nrows()).map(belief).collect())
            })
        };
        let (slow, fast) = (wave(2.0).unwrap(), wave(40.0).unwrap());
        assert!(slow.1.n[0] < fast.1.n[0], "{:?} {:?}", slow.1, fast.1);
        for (table, report) in [&slow, &fast] {
            assert!(report.mean_error <= 0.01 && report.variance_error <= 1e-3, "{report:?}");
            assert!(table.at([0.5, WIDEST + 1e-9]).is_none());
            assert!(table.at([1.0, -WIDEST]).is_some() && table.at([f64::NAN, 0.0]).is_none());
        }
        let error = wave(3000.0).unwrap_err();
        assert!(matches!(error, ModelError::TableTooCoarse { .. }), "{error}");
    }
}
