//! Where the squared error gathers, whether or not it has a sign.

use serde::Serialize;

use crate::compare::structure::{Structure, TestedMap};
use crate::compare::words::{place, size};
use crate::data::clusters::ClusterMean;
use crate::statistics::box_search::{CellRange, Tally, gain, gain_above};
use crate::{Condition, Covariate};

/// A small region that holds much of a number's squared error.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Concentration {
    /// What gathers where, with mm and degrees.
    pub sentence: String,
    /// Which number.
    pub name: &'static str,
    /// Its SI unit.
    pub unit: &'static str,
    /// Where: all of them hold.
    pub conditions: Vec<Condition>,
    /// The same as cells of each covariate, as in [`CovariateCells`](crate::CovariateCells), also where
    /// they are all.
    #[serde(skip)]
    pub region: Vec<(Covariate, Vec<usize>)>,
    /// Steps there.
    pub n_steps: usize,
    /// Pushes that they are of.
    pub n_pushes: usize,
    /// Root mean square error there.
    pub rms: f64,
    /// Root mean square error of all other steps.
    pub rms_elsewhere: f64,
    /// Share of the number's squared error there.
    pub error_share: f64,
    /// Share of the steps there.
    pub step_share: f64,
}

/// Least share of the squared error.
const LEAST_SHARE: f64 = 0.1;
/// Least ratio of the mean squares there and elsewhere.
const LEAST_RATIO: f64 = 3.0;
/// Most of the steps.
const MOST_STEPS: f64 = 0.25;
/// Standard errors, from whole clusters, between the mean square there and that of all.
const FEWEST_SE: f64 = 2.5;
/// A region over fewer covariates is preferred if its gain is this share of the best.
const SIMPLER: f64 = 0.8;

/// The region of each number of the motion in which squared error gathers most, if it does.
///
/// A mean residual shows what a model misses by the same each time. Where outcomes differ between
/// pushes that are alike, the mean may vanish; this shows them, too.
pub(crate) fn concentrations(structure: &Structure<'_>) -> Vec<Concentration> {
    const MOTION: std::ops::Range<usize> = 0..3;
    let of_number = |(index, series): (usize, &crate::compare::structure::Series)| {
        let reading = &series.reading;
        let is_asked = MOTION.contains(&reading.number) && !reading.is_in_sense();
        is_asked.then(|| concentration(structure, index)).flatten()
    };
    structure.series.iter().enumerate().filter_map(of_number).collect()
}

fn concentration(structure: &Structure<'_>, index: usize) -> Option<Concentration> {
    let series = &structure.series[index];
    let used = series.signs.iter().filter(|sign| **sign != 0.0).count() as f64;
    let total: f64 = series.values.iter().map(|value| value * value).sum();
    let excess: Vec<f64> = series.values.iter().map(|value| value * value - total / used).collect();
    let maps = structure.maps.iter().filter(|map| map.series == index && !map.axes.is_empty());
    let boxes: Vec<_> = maps.map(|map| best(structure, map, &excess)).collect();
    let largest = boxes.iter().map(|found| found.0).fold(0.0, f64::max);
    let near = boxes.into_iter().filter(|found| found.0 >= SIMPLER * largest);
    let (_, ranges) = near.min_by(|a, b| a.1.len().cmp(&b.1.len()).then(b.0.total_cmp(&a.0)))?;
    let is_there = |step: &usize| series.signs[*step] != 0.0 && structure.is_in(*step, &ranges);
    let steps: Vec<usize> = (0..series.values.len()).filter(is_there).collect();
    let clusters = &structure.observations.cluster_of;
    let there: Vec<_> = steps.iter().map(|k| (clusters[*k], excess[*k])).collect();
    let mean = ClusterMean::of(&there)?;
    let n = steps.len() as f64;
    let square: f64 = steps.iter().map(|k| series.values[*k].powi(2)).sum();
    let elsewhere = (total - square) / (used - n);
    let (error_share, step_share) = (square / total, n / used);
    let gathers = mean.n_steps >= structure.settings.fewest_steps
        && mean.n_clusters >= structure.settings.fewest_pushes
        && mean.mean >= FEWEST_SE * mean.se
        && error_share >= LEAST_SHARE
        && step_share <= MOST_STEPS
        && square / n >= LEAST_RATIO * elsewhere;
    if !gathers {
        return None;
    }
    let mut found = Concentration {
        sentence: String::new(),
        name: series.reading.name,
        unit: series.reading.unit(),
        conditions: structure.conditions(&ranges),
        region: structure.region(&ranges),
        n_steps: steps.len(),
        n_pushes: structure.observations.n_pushes_of(&steps),
        rms: (square / n).sqrt(),
        rms_elsewhere: elsewhere.max(0.0).sqrt(),
        error_share,
        step_share,
    };
    found.sentence = gathered(&found);
    Some(found)
}

/// The box of a map in which most is above the mean square.
fn best(
    structure: &Structure<'_>,
    map: &TestedMap,
    excess: &[f64],
) -> (f64, Vec<(usize, CellRange)>) {
    let n_cells = map.axes.iter().map(|axis| structure.axes[*axis].n_cells()).product();
    let mut cells: Vec<Tally> = vec![(0.0, 0.0); n_cells];
    for (cell, value) in map.test.cell_of().iter().zip(excess) {
        if let Some(cell) = cell {
            cells[*cell] = (cells[*cell].0 + 1.0, cells[*cell].1 + value);
        }
    }
    let ranges = structure.best_box(map, &cells, gain_above);
    let inside = map
        .test
        .cell_of()
        .iter()
        .enumerate()
        .filter(|(step, cell)| cell.is_some() && structure.is_in(*step, &ranges));
    let tally = inside.fold((0.0, 0.0), |sum, (step, _)| (sum.0 + 1.0, sum.1 + excess[step]));
    (gain(tally), ranges)
}

/// `misses dx by 1.1 mm at p > 0.8: 2 % of the steps hold 21 % of its squared error`.
fn gathered(found: &Concentration) -> String {
    let Concentration { name, conditions, step_share, error_share, .. } = found;
    let (size, place) = (size(found.rms, found.unit), place(conditions));
    let (steps, error) = (100.0 * step_share, 100.0 * error_share);
    format!(
        "misses {name} by {size}{place}: {steps:.0} % of the steps hold {error:.0} % of its \
         squared error"
    )
}

#[cfg(test)]
mod tests {
    use super::concentrations;
    use crate::MapSettings;
    use crate::compare::structure::Structure;
    use crate::synthetic::{Made, made};

    fn sentences(miss: impl Fn(&Made) -> f64) -> Vec<String> {
        let (observations, predictions, floor) = made(0, miss);
        let residuals = predictions.residuals(&observations).unwrap();
        let settings = MapSettings { n_flips: 99, ..MapSettings::default() };
        let structure = Structure::of(&residuals, &observations, &predictions, &floor, &settings);
        concentrations(&structure).into_iter().map(|found| found.sentence).collect()
    }

    #[test]
    fn scatter_without_a_sign_is_found_where_it_is() {
        let corner = |step: &Made| step.p > 0.8 && step.beta > 0.2618;
        let scattered =
            sentences(|step| if corner(step) { 5e-4 * step.direction.signum() } else { 0.0 });
        assert_eq!(scattered.len(), 1, "{scattered:?}");
        let expected = "misses dx by 0.50 mm at p > 0.8 with β > 15°: 8 % of the steps hold 99 % \
                        of its squared error";
        assert_eq!(scattered[0], expected);
        assert!(sentences(|_| 0.0).is_empty());
    }
}
