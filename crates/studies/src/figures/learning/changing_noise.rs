//! Figure M.6: noise that depends on the input, told from noise that does not.

use anyhow::{Context, Result};
use faer::Mat;
use gp_core::scores::{coverage, nlpd};
use gp_core::{Gp, GpError, HeteroscedasticGp, LearnOptions, Posterior, SquaredExponential};
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use rayon::iter::{IntoParallelIterator, ParallelIterator};
use report::{Band, Color, Figure, Line, Panel, Points, Table};

use crate::figures::inputs::{Inputs, SEED};
use crate::figures::sketch::Sketch;

/// As many rows as Silverman's (1985) motorcycle data have.
const N_ROWS: usize = 133;
const FOLDS: (usize, usize) = (10, 4);
/// Where predictions are drawn, in ms.
const POINTS: usize = 241;
const REACH: f64 = 60.0;

/// A kind of process of one input.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Same,
    Changing,
}

/// What each kind says of rows that it has not seen.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CrossValidated {
    /// Mean negative log density, in nats: of the same noise everywhere, and of a changing one.
    pub(crate) nlpd: [f64; 2],
    /// Shares inside the 50 % and 95 % intervals, of both.
    pub(crate) inside: [[f64; 2]; 2],
}

pub(crate) fn draw(inputs: &Inputs) -> Result<Sketch> {
    let (t, y) = impact(N_ROWS, SEED, noise_sd);
    let n_folds = if inputs.quick() { FOLDS.1 } else { FOLDS.0 };
    let found = cross_validated(&t, &y, n_folds)?;
    let grid: Vec<f64> = (0..POINTS).map(|i| REACH * i as f64 / (POINTS - 1) as f64).collect();
    let truth: Vec<f64> = grid.iter().map(|t| acceleration(*t)).collect();
    let mut figure = Figure::new(1, 2).panel_size(430.0, 300.0).one_legend();
    let mut table = Table::new().column("t_ms", &grid).column("truth_g", &truth);
    for (kind, title, name) in [
        (Kind::Same, "the same noise everywhere", "same"),
        (Kind::Changing, "noise that depends on the input", "changing"),
    ] {
        let (mean, variance) = kind.learn(&t, &y)?.predict_observation(column(&grid).as_ref())?;
        let edge = |sign: f64| -> Vec<f64> {
            mean.iter().zip(&variance).map(|(m, v)| m + sign * v.sqrt()).collect()
        };
        let (low, high) = (edge(-2.0), edge(2.0));
        let panel = Panel::new("time after the impact / ms", "acceleration / g")
            .title(title)
            .with(Band::new(&grid, &low, &high).color(Color::BLUE).label("±2 standard deviations"))
            .with(Line::new(&grid, &truth).color(Color::INK).width(1.3).dashed().label("function"))
            .with(Line::new(&grid, &mean).color(Color::BLUE).label("mean"))
            .with(Points::new(&t, &y).color(Color::VERMILION).radius(2.0).label("data"));
        figure = figure.with(panel);
        let sd: Vec<f64> = variance.iter().map(|variance| variance.sqrt()).collect();
        let columns = (format!("{name}_mean_g"), format!("{name}_sd_g"));
        table = table.column(&columns.0, &mean).column(&columns.1, &sd);
    }
    let [same, changing] = found.nlpd;
    let percent = |kind: usize| found.inside[kind].map(|share| 100.0 * share);
    let ([same_50, same_95], [changing_50, changing_95]) = (percent(0), percent(1));
    let caption = format!(
        "{N_ROWS} simulated rows like the head of a rider after an impact (the classic test is Silverman's, \
         1985): quiet, then a swing with noise ten times as large. Bands are those of an observation. On \
         rows of {n_folds} folds that were left out, the negative log density is {same:.3} nats a row with \
         the same noise everywhere and {changing:.3} with noise that depends on the input; the 50 % \
         intervals hold {same_50:.0} and {changing_50:.0} % of them, the 95 % intervals {same_95:.0} and \
         {changing_95:.0} %."
    );
    let alt = "Two panels of the same data: one with a band from the same noise everywhere, one with a \
               band whose width depends on the input.";
    Ok(Sketch::new(figure, table, &caption, alt))
}

/// Scores of rows in folds that were left out; the folds are drawn at random.
///
/// # Errors
/// Fewer rows than folds, or what a process says.
pub(crate) fn cross_validated(t: &[f64], y: &[f64], n_folds: usize) -> Result<CrossValidated> {
    let mut order: Vec<usize> = (0..t.len()).collect();
    order.shuffle(&mut ChaCha8Rng::seed_from_u64(SEED));
    let fold = |fold: usize| {
        let part = |is_left_out: bool| {
            let rows = order.iter().enumerate();
            let rows = rows.filter(move |(place, _)| (place % n_folds == fold) == is_left_out);
            rows.map(|(_, row)| (t[*row], y[*row])).unzip::<f64, f64, Vec<_>, Vec<_>>()
        };
        let ((train_t, train_y), (test_t, test_y)) = (part(false), part(true));
        let predict = |kind: Kind| {
            let process = kind.learn(&train_t, &train_y)?;
            process.predict_observation(column(&test_t).as_ref())
        };
        let predictions = [predict(Kind::Same), predict(Kind::Changing)];
        let [same, changing] = predictions.map(|said| said.with_context(|| format!("fold {fold}")));
        Ok((test_y, [same?, changing?]))
    };
    let folds = (0..n_folds).into_par_iter().map(fold).collect::<Result<Vec<_>>>()?;
    let observed: Vec<f64> = folds.iter().flat_map(|(y, _)| y.iter().copied()).collect();
    let mut found = CrossValidated { nlpd: [0.0; 2], inside: [[0.0; 2]; 2] };
    for kind in 0..2 {
        let said = folds.iter().map(|(_, said)| &said[kind]);
        let (mean, variance): (Vec<_>, Vec<_>) = said.cloned().unzip();
        let (mean, variance) = (mean.concat(), variance.concat());
        found.nlpd[kind] = nlpd(&observed, &mean, &variance)?;
        found.inside[kind].copy_from_slice(&coverage(&observed, &mean, &variance, &[0.5, 0.95])?);
    }
    Ok(found)
}

impl Kind {
    fn learn(self, t: &[f64], y: &[f64]) -> Result<Box<dyn Posterior>, GpError> {
        let (x, kernel) = (column(t), || SquaredExponential::unit(1));
        let options = LearnOptions { max_iterations: 2000, ..LearnOptions::default() };
        Ok(match self {
            Self::Same => {
                Box::new(Gp::builder(kernel()?).options(options.clone()).fit(x.as_ref(), y)?)
            }
            Self::Changing => {
                Box::new(HeteroscedasticGp::learn(kernel()?, kernel()?, x.as_ref(), y, &options)?.0)
            }
        })
    }
}

fn column(values: &[f64]) -> Mat<f64> {
    Mat::from_fn(values.len(), 1, |i, _| values[i])
}

/// Times (ms) and accelerations (g) with noise: a quarter of the rows before the impact, half in the
/// swing, a quarter after.
fn impact(n: usize, seed: u64, noise_sd: fn(f64) -> f64) -> (Vec<f64>, Vec<f64>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let row = |i: usize| {
        let range = [2.0..14.0, 14.0..30.0, 14.0..30.0, 30.0..57.0][i % 4].clone();
        let t = rng.random_range(range);
        let noise: f64 = rng.sample(StandardNormal);
        (t, acceleration(t) + noise_sd(t) * noise)
    };
    (0..n).map(row).unzip()
}

/// The swing at t ms, in g.
fn acceleration(t: f64) -> f64 {
    let swing = |center: f64, width: f64| (-((t - center) / width).powi(2)).exp();
    -110.0 * swing(21.0, 4.5) + 45.0 * swing(33.0, 5.0)
}

/// The noise at t ms, in g.
fn noise_sd(t: f64) -> f64 {
    2.0 + 20.0 / (1.0 + (15.0 - t).exp())
}

#[cfg(test)]
mod tests {
    use super::{N_ROWS, cross_validated, impact, noise_sd};

    #[test]
    fn noise_that_depends_on_the_input_is_worth_knowing() {
        let (t, y) = impact(N_ROWS, 3, noise_sd);
        let found = cross_validated(&t, &y, 5).unwrap();
        let [same, changing] = found.nlpd;
        assert!(changing < same - 0.2, "{found:?}");
        let [half, most] = found.inside[1];
        assert!((half - 0.5).abs() < 0.1 && most > 0.87, "{found:?}");
    }

    #[test]
    fn where_the_noise_is_the_same_everywhere_little_is_lost() {
        let (t, y) = impact(N_ROWS, 4, |_| 15.0);
        let [same, changing] = cross_validated(&t, &y, 5).unwrap().nlpd;
        assert!((changing - same).abs() < 0.1, "{changing} {same}");
    }
}
