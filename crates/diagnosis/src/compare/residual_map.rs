//! Where a model fails: mean residuals over covariates, and whether they are more than chance.

use serde::Serialize;

use crate::Covariate;
use crate::compare::structure::{Structure, TestedMap};
use crate::data::clusters::ClusterMean;

/// Mean residuals of one number of a step over one or two covariates.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ResidualMap {
    /// Which number; `drift` is dy, and `turn` dtheta, in the sense that the model predicts.
    pub name: &'static str,
    /// Its SI unit.
    pub unit: &'static str,
    /// Over what.
    pub covariates: Vec<Covariate>,
    /// The cells with enough data.
    pub cells: Vec<Cell>,
    /// Probability of means that differ as much in any map, were every push's residual beyond the
    /// common mean as likely of the other sign.
    pub p_adjusted: f64,
}

/// Steps within a range of each covariate.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cell {
    /// Lower and upper end, for each covariate of the map.
    pub ranges: Vec<[f64; 2]>,
    /// Which cell of each covariate, as in [`CovariateCells`](crate::CovariateCells).
    #[serde(skip)]
    pub indices: Vec<usize>,
    /// Steps in it.
    pub n_steps: usize,
    /// Pushes that they are of.
    pub n_pushes: usize,
    /// Mean of observed less predicted.
    pub mean: f64,
    /// Lower end of its 95 % interval, from whole clusters.
    pub low95: f64,
    /// Upper end of its 95 % interval.
    pub high95: f64,
    /// Root mean square of observed less predicted.
    pub rms: f64,
    /// Mean of observed less predicted over the noise floor, by which numbers of all units compare;
    /// none without floor.
    pub over_floor: Option<f64>,
}

/// All maps, the surest first.
///
/// The test of a map is for means that differ between its cells, whatever their common mean, against
/// its values when whole clusters change their sign; over all maps by the largest normal quantile
/// (max-T), so that many maps do not make a find.
pub(crate) fn residual_maps(structure: &Structure<'_>) -> Vec<ResidualMap> {
    let mut maps: Vec<&TestedMap> =
        structure.maps.iter().filter(|map| !map.axes.is_empty()).collect();
    maps.sort_by(|a, b| b.quantile.total_cmp(&a.quantile));
    maps.into_iter().map(|map| shown(structure, map)).collect()
}

fn shown(structure: &Structure<'_>, map: &TestedMap) -> ResidualMap {
    let series = &structure.series[map.series];
    let axes: Vec<_> = map.axes.iter().map(|axis| &structure.axes[*axis]).collect();
    let n_cells = axes.iter().map(|axis| axis.n_cells()).product();
    let mut by_cell: Vec<Vec<usize>> = vec![Vec::new(); n_cells];
    for (step, cell) in map.test.cell_of().iter().enumerate() {
        cell.iter().for_each(|cell| by_cell[*cell].push(step));
    }
    let cell = |(index, steps): (usize, &Vec<usize>)| {
        let clusters = &structure.observations.cluster_of;
        let values: Vec<_> = steps.iter().map(|k| (clusters[*k], series.values[*k])).collect();
        let mean = ClusterMean::of(&values)?;
        let [low95, high95] = mean.interval();
        let mut rest = index;
        let mut indices: Vec<usize> = Vec::new();
        for axis in axes.iter().rev() {
            indices.insert(0, rest % axis.n_cells());
            rest /= axis.n_cells();
        }
        let ranges = axes.iter().zip(&indices).map(|(axis, index)| axis.bins.ends(*index));
        let ranges: Vec<[f64; 2]> = ranges.collect();
        let white = steps.iter().map(|k| series.values[*k] / series.scales[*k]).sum::<f64>();
        let over_floor = series.has_floor.then(|| white / steps.len() as f64);
        let rms = (values.iter().map(|(_, x)| x * x).sum::<f64>() / values.len() as f64).sqrt();
        let ClusterMean { mean, n_steps, .. } = mean;
        let n_pushes = structure.observations.n_pushes_of(steps);
        Some(Cell { ranges, indices, n_steps, n_pushes, mean, low95, high95, rms, over_floor })
    };
    ResidualMap {
        name: series.reading.name,
        unit: series.reading.unit(),
        covariates: axes.iter().map(|axis| axis.covariate).collect(),
        cells: by_cell.iter().enumerate().filter_map(cell).collect(),
        p_adjusted: structure.largest.probability(map.quantile),
    }
}
