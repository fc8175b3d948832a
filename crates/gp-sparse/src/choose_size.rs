//! The number of pseudo-inputs by the density of rows that were held out.

use faer::{Mat, MatRef};
use gp_core::checks::check_row_noise;
use gp_core::{Constraints, GpError, Kernel, Posterior};

use crate::placement::shuffled_rows;
use crate::sparse_gp::check_data;
use crate::warm_start::rows_at;
use crate::{PseudoInputs, SparseGp, SparseOptions};

/// How well one number of pseudo-inputs predicts rows that it has not seen.
#[derive(Clone, Debug, PartialEq)]
pub struct SizeScore {
    /// The number of pseudo-inputs.
    pub count: usize,
    /// Mean negative log predictive density of the held-out rows, in nats.
    pub nlpd: f64,
    /// Mean difference of that to the best number, in nats.
    pub excess: f64,
    /// Standard error of the difference, from its spread over the held-out rows.
    pub excess_standard_error: f64,
}

impl SparseGp {
    /// Learns with each number of pseudo-inputs on a random four fifths of the rows and scores the
    /// rest; returns the smallest number that the best is not ahead of by more than one standard
    /// error, and all scores in the order of `counts`.
    ///
    /// # Errors
    /// As `learn`; `Empty` without counts; `TooFewRows` below ten rows.
    pub fn choose_size(
        kernel: impl Kernel + 'static,
        x: MatRef<'_, f64>,
        y: &[f64],
        counts: &[usize],
        options: &SparseOptions,
    ) -> Result<(usize, Vec<SizeScore>), GpError> {
        check_data(&kernel, x, y)?;
        check_row_noise(&options.row_noise, y.len())?;
        if counts.is_empty() {
            return Err(GpError::Empty { what: "counts" });
        }
        if y.len() < 10 {
            return Err(GpError::TooFewRows { needed: 10, actual: y.len() });
        }
        let rows = shuffled_rows(y.len(), options.seed);
        let (held_out, training) = rows.split_at(y.len() / 5);
        let (x_train, y_train) = part(x, y, training);
        let (x_test, y_test) = part(x, y, held_out);
        let losses = |&count: &usize| {
            let options = SparseOptions {
                pseudo_inputs: with_count(&options.pseudo_inputs, count)?,
                row_noise: rows_at(&options.row_noise, training),
                ..options.clone()
            };
            let (data, nothing) = ((x_train.as_ref(), &*y_train), Constraints::default());
            let (gp, _) = Self::learn_asked(&kernel, data, &options, &nothing)?;
            let (mean, mut variance) = gp.predict_observation(x_test.as_ref())?;
            let own = rows_at(&options.row_noise, held_out);
            variance.iter_mut().zip(&own).for_each(|(variance, own)| *variance += own);
            let loss = |i: usize| {
                let error = y_test[i] - mean[i];
                let normalization = (2.0 * std::f64::consts::PI * variance[i]).ln();
                0.5 * (error * error / variance[i] + normalization)
            };
            Ok((0..y_test.len()).map(loss).collect())
        };
        let losses = counts.iter().map(losses).collect::<Result<Vec<Vec<f64>>, GpError>>()?;
        Ok(choose(counts, &losses))
    }
}

fn choose(counts: &[usize], losses: &[Vec<f64>]) -> (usize, Vec<SizeScore>) {
    let average = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let best = losses
        .iter()
        .min_by(|a, b| average(a).total_cmp(&average(b)))
        .expect("there is at least one count");
    let score = |(&count, loss): (&usize, &Vec<f64>)| {
        let excess: Vec<f64> = loss.iter().zip(best).map(|(loss, best)| loss - best).collect();
        let mean = average(&excess);
        let spread = excess.iter().map(|excess| (excess - mean).powi(2)).sum::<f64>();
        let n = excess.len() as f64;
        SizeScore {
            count,
            nlpd: average(loss),
            excess: mean,
            excess_standard_error: (spread / (n * (n - 1.0).max(1.0))).sqrt(),
        }
    };
    let scores: Vec<SizeScore> = counts.iter().zip(losses).map(score).collect();
    let is_enough = |score: &&SizeScore| score.excess <= score.excess_standard_error;
    let chosen = scores.iter().filter(is_enough).map(|score| score.count).min();
    (chosen.expect("the best is not behind itself"), scores)
}

fn with_count(pseudo_inputs: &PseudoInputs, count: usize) -> Result<PseudoInputs, GpError> {
    match *pseudo_inputs {
        PseudoInputs::Learnt { placement, .. } => Ok(PseudoInputs::Learnt { count, placement }),
        PseudoInputs::Placed { placement, .. } => Ok(PseudoInputs::Placed { count, placement }),
        PseudoInputs::Given(ref z) => Err(GpError::ShapeMismatch {
            what: "pseudo-inputs are given, so their number is not free",
            expected: z.nrows(),
            actual: count,
        }),
    }
}

fn part(x: MatRef<'_, f64>, y: &[f64], rows: &[usize]) -> (Mat<f64>, Vec<f64>) {
    let inputs = Mat::from_fn(rows.len(), x.ncols(), |i, d| x[(rows[i], d)]);
    (inputs, rows.iter().map(|&row| y[row]).collect())
}
