//! What of the residuals depends on something, over every map.

use crate::compare::axis::{Axis, sets};
use crate::compare::reading::Reading;
use crate::statistics::box_search::{CellRange, Tally, best_range, best_ranges};
use crate::statistics::map_test::{Flips, Largest, MapTest};
use crate::{Condition, Covariate, NoiseFloor, Observations, Predictions};

/// How maps are made and tested.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapSettings {
    /// Fewest steps of a cell.
    pub fewest_steps: usize,
    /// Fewest pushes of a cell.
    pub fewest_pushes: usize,
    /// Random flips of signs; the smallest probability is 1/(1 + n).
    pub n_flips: usize,
    /// Seed of the flips.
    pub seed: u64,
}

impl Default for MapSettings {
    fn default() -> Self {
        Self { fewest_steps: 12, fewest_pushes: 5, n_flips: 999, seed: 7 }
    }
}

/// Every map of every reading with its test, and what chance does to the surest of them.
pub(crate) struct Structure<'a> {
    pub(crate) observations: &'a Observations,
    pub(crate) settings: &'a MapSettings,
    pub(crate) axes: Vec<Axis>,
    pub(crate) series: Vec<Series>,
    pub(crate) maps: Vec<TestedMap>,
    pub(crate) largest: Largest,
}

/// The residuals of one number in one reading.
pub(crate) struct Series {
    pub(crate) reading: Reading,
    /// What turns a residual of the number into one of the reading; 0 where there is none.
    pub(crate) signs: Vec<f64>,
    /// In the number's unit; 0 where there is none.
    pub(crate) values: Vec<f64>,
    /// The floor of each step, in the number's unit; the error's own size where it is not known.
    pub(crate) scales: Vec<f64>,
    /// Whether `scales` is the floor.
    pub(crate) has_floor: bool,
}

/// A reading over some axes.
pub(crate) struct TestedMap {
    /// Index of the series.
    pub(crate) series: usize,
    /// Indices of the axes: none for the mean of everything.
    pub(crate) axes: Vec<usize>,
    pub(crate) test: MapTest,
    pub(crate) quantile: f64,
}

impl<'a> Structure<'a> {
    pub(crate) fn of(
        residuals: &[[Option<f64>; 7]],
        observations: &'a Observations,
        predictions: &Predictions,
        floor: &NoiseFloor,
        settings: &'a MapSettings,
    ) -> Self {
        let axes = Axis::all(observations);
        let series = |reading| Series::of(reading, residuals, observations, predictions, floor);
        let series: Vec<Series> = Reading::all().filter_map(series).collect();
        let clusters = &observations.cluster_of;
        let flips = Flips::new(settings.n_flips, observations.n_clusters(), settings.seed);
        let (mut maps, mut flipped) = (Vec::new(), Vec::new());
        for (index, series) in series.iter().enumerate() {
            let white = series.white();
            for axes_of_map in sets(&axes) {
                let data = (white.as_slice(), clusters.as_slice());
                let used = series.signs.iter().map(|sign| *sign != 0.0);
                let tested = if axes_of_map.is_empty() {
                    MapTest::of_mean(used, data, &flips)
                } else {
                    let (cell_of, n) = cells(&axes, &axes_of_map, used, clusters, settings);
                    MapTest::of_cells(cell_of, n, data, &flips)
                };
                let Some((test, under_chance)) = tested else { continue };
                let quantile = test.normal_quantile(&white, clusters);
                maps.push(TestedMap { series: index, axes: axes_of_map, test, quantile });
                flipped.push(under_chance);
            }
        }
        let largest = Largest::of(&flipped);
        Self { observations, settings, axes, series, maps, largest }
    }
}

impl Structure<'_> {
    /// The ranges of a map's axes with the largest gain, from the tally of each of its cells.
    pub(crate) fn best_box(
        &self,
        map: &TestedMap,
        cells: &[Tally],
        gain: fn(Tally) -> f64,
    ) -> Vec<(usize, CellRange)> {
        let is_periodic = |axis: usize| self.axes[axis].covariate.is_periodic();
        match map.axes[..] {
            [] => Vec::new(),
            [axis] => vec![(axis, best_range(cells, is_periodic(axis), gain))],
            [a, b, ..] => {
                let periodic = [is_periodic(a), is_periodic(b)];
                let [first, second] = best_ranges(cells, periodic, self.axes[b].n_cells(), gain);
                vec![(a, first), (b, second)]
            }
        }
    }

    /// Whether a step is in all ranges.
    pub(crate) fn is_in(&self, step: usize, ranges: &[(usize, CellRange)]) -> bool {
        ranges.iter().all(|(axis, range)| {
            let axis = &self.axes[*axis];
            range.holds(axis.cell_of[step], axis.n_cells())
        })
    }

    /// The ranges as conditions, but for those that hold every step.
    pub(crate) fn conditions(&self, ranges: &[(usize, CellRange)]) -> Vec<Condition> {
        ranges.iter().filter_map(|(axis, range)| Condition::of(&self.axes[*axis], *range)).collect()
    }

    /// The cells of each covariate in its range.
    pub(crate) fn region(&self, ranges: &[(usize, CellRange)]) -> Vec<(Covariate, Vec<usize>)> {
        let cells = |(axis, range): &(usize, CellRange)| {
            let axis = &self.axes[*axis];
            (axis.covariate, range.cells(axis.n_cells()).collect())
        };
        ranges.iter().map(cells).collect()
    }
}

impl Series {
    /// None if no step has the number.
    fn of(
        reading: Reading,
        residuals: &[[Option<f64>; 7]],
        observations: &Observations,
        predictions: &Predictions,
        floor: &NoiseFloor,
    ) -> Option<Self> {
        let number = reading.number;
        let mut signs = reading.signs(predictions, observations);
        let (mut values, mut squares, mut n) = (Vec::new(), 0.0, 0_usize);
        for (sign, residual) in signs.iter_mut().zip(residuals) {
            let Some(residual) = residual[number] else {
                *sign = 0.0;
                values.push(0.0);
                continue;
            };
            values.push(*sign * residual);
            squares += residual * residual;
            n += 1;
        }
        let rms = (squares / n.max(1) as f64).sqrt();
        let floors = floor.of_steps(number, observations);
        let has_floor = floors.is_some();
        let scales = floors.unwrap_or_else(|| vec![rms; observations.n_steps()]);
        let usable = rms > 0.0 && scales.iter().all(|scale| *scale > 0.0);
        usable.then_some(Self { reading, signs, values, scales, has_floor })
    }

    /// The values over the floor.
    pub(crate) fn white(&self) -> Vec<f64> {
        self.values.iter().zip(&self.scales).map(|(value, scale)| value / scale).collect()
    }
}

/// The cell of each step over some axes, where the cell has enough steps of enough clusters; and the
/// number of cells with too few among them. The last axis runs fastest.
fn cells(
    axes: &[Axis],
    chosen: &[usize],
    used: impl Iterator<Item = bool>,
    clusters: &[usize],
    settings: &MapSettings,
) -> (Vec<Option<usize>>, usize) {
    let n_cells = chosen.iter().map(|axis| axes[*axis].n_cells()).product();
    let place = |k: usize| {
        chosen.iter().fold(0, |cell, axis| cell * axes[*axis].n_cells() + axes[*axis].cell_of[k])
    };
    let mut cell_of: Vec<_> = used.enumerate().map(|(k, used)| used.then(|| place(k))).collect();
    let mut members: Vec<Vec<usize>> = vec![Vec::new(); n_cells];
    for (cell, cluster) in cell_of.iter().zip(clusters) {
        cell.iter().for_each(|cell: &usize| members[*cell].push(*cluster));
    }
    let enough = |clusters: &mut Vec<usize>| {
        let n_steps = clusters.len();
        clusters.sort_unstable();
        clusters.dedup();
        n_steps >= settings.fewest_steps && clusters.len() >= settings.fewest_pushes
    };
    let enough: Vec<bool> = members.iter_mut().map(enough).collect();
    cell_of.iter_mut().for_each(|cell| *cell = cell.filter(|cell| enough[*cell]));
    (cell_of, n_cells)
}
