//! Where a model fails: mean residuals over a covariate, and whether they are more than chance.

use effects::Channels;
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use crate::clusters::ClusterMean;
use crate::errors::UNITS;
use crate::quantile::normal_of_chi_square;
use crate::{Covariate, Observations};

/// Mean residuals of one number of a step over one covariate.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ResidualMap {
    /// Which number.
    pub name: &'static str,
    /// Its SI unit.
    pub unit: &'static str,
    /// Over what.
    pub covariate: Covariate,
    /// The cells with enough data.
    pub cells: Vec<Cell>,
    /// Probability of means that differ as much in any map, were every push's residual beyond the
    /// common mean as likely of the other sign.
    pub p_adjusted: f64,
}

/// Steps within a range of a covariate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Cell {
    /// Lower end.
    pub from: f64,
    /// Upper end.
    pub to: f64,
    /// Steps in it.
    pub n_steps: usize,
    /// Pushes that they are of.
    pub n_pushes: usize,
    /// Mean of observed less predicted.
    pub mean: f64,
    /// Lower end of its 95 % interval, from whole pushes.
    pub low95: f64,
    /// Upper end of its 95 % interval.
    pub high95: f64,
}

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

/// A map with what its test needs.
struct Draft {
    map: ResidualMap,
    /// Each push's sums over the cells, whitened by their scatter: their own sum is the score.
    scores: Vec<DVector<f64>>,
    statistic: f64,
    rank: f64,
}

/// All maps, the surest first.
///
/// The test is for means that differ between the cells, whatever their common mean: with s the sums
/// of a push's residuals over the cells, less their share of its whole sum, T = (Σs)ᵀ(Σssᵀ)⁺(Σs),
/// against its values when whole pushes change their sign; over all maps by the largest normal
/// quantile of T (max-T), so that many maps do not make a find.
pub(crate) fn residual_maps(
    residuals: &[[Option<f64>; 7]],
    observations: &Observations,
    settings: &MapSettings,
) -> Vec<ResidualMap> {
    let mut drafts: Vec<Draft> = Vec::new();
    for covariate in Covariate::ALL {
        let values = covariate.values(observations);
        for number in 0..Channels::NAMES.len() {
            drafts.extend(draft(residuals, observations, (covariate, &values), number, settings));
        }
    }
    let largest = flipped(&drafts, observations.pushes.len(), settings);
    for draft in &mut drafts {
        let above = largest.iter().filter(|value| **value >= draft.statistic).count();
        draft.map.p_adjusted = (1 + above) as f64 / (1 + largest.len()) as f64;
    }
    drafts.sort_by(|a, b| b.statistic.total_cmp(&a.statistic));
    drafts.into_iter().map(|draft| draft.map).collect()
}

/// The largest statistic of all maps, for each flip.
fn flipped(drafts: &[Draft], n_pushes: usize, settings: &MapSettings) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(settings.seed);
    let flip = |_| {
        let signs: Vec<f64> =
            (0..n_pushes).map(|_| if rng.random::<bool>() { 1.0 } else { -1.0 }).collect();
        drafts.iter().map(|draft| draft.statistic_of(&signs)).fold(f64::NEG_INFINITY, f64::max)
    };
    (0..settings.n_flips).map(flip).collect()
}

impl Draft {
    fn statistic_of(&self, signs: &[f64]) -> f64 {
        let mut sum = DVector::zeros(self.map.cells.len());
        for (score, sign) in self.scores.iter().zip(signs) {
            sum.axpy(*sign, score, 1.0);
        }
        normal_of_chi_square(sum.norm_squared(), self.rank)
    }
}

fn draft(
    residuals: &[[Option<f64>; 7]],
    observations: &Observations,
    (covariate, values): (Covariate, &[f64]),
    number: usize,
    settings: &MapSettings,
) -> Option<Draft> {
    let bins = covariate.bins(values);
    let mut by_cell: Vec<Vec<(usize, f64)>> = vec![Vec::new(); bins.n_cells()];
    for (index, residual) in residuals.iter().enumerate() {
        if let Some(residual) = residual[number] {
            by_cell[bins.cell(values[index])].push((observations.push_of[index], residual));
        }
    }
    let (mut cells, mut kept) = (Vec::new(), Vec::new());
    for (index, steps) in by_cell.iter().enumerate() {
        let Some(mean) = ClusterMean::of(steps) else { continue };
        if mean.n_steps < settings.fewest_steps || mean.n_pushes < settings.fewest_pushes {
            continue;
        }
        let ([from, to], [low95, high95]) = (bins.ends(index), mean.interval());
        let ClusterMean { mean, n_steps, n_pushes, .. } = mean;
        cells.push(Cell { from, to, n_steps, n_pushes, mean, low95, high95 });
        kept.push(steps.as_slice());
    }
    let (scores, rank) = whitened(contrasts(&kept, observations.pushes.len()))?;
    let (name, unit) = (Channels::NAMES[number], UNITS[number]);
    let map = ResidualMap { name, unit, covariate, cells, p_adjusted: 1.0 };
    let mut draft = Draft { map, scores, statistic: 0.0, rank };
    draft.statistic = draft.statistic_of(&vec![1.0; observations.pushes.len()]);
    Some(draft)
}

/// Each push's sums over the cells of what is beyond the common mean, less each cell's share of
/// the push's whole sum: no common change of all residuals alters them by more than noise.
fn contrasts(cells: &[&[(usize, f64)]], n_pushes: usize) -> Vec<Vec<f64>> {
    let n_steps = cells.iter().map(|steps| steps.len()).sum::<usize>() as f64;
    let total: f64 = cells.iter().flat_map(|steps| steps.iter()).map(|(_, value)| value).sum();
    let mut sums = vec![vec![0.0; cells.len()]; n_pushes];
    for (cell, steps) in cells.iter().enumerate() {
        steps.iter().for_each(|(push, value)| sums[*push][cell] += value - total / n_steps);
    }
    for sum in &mut sums {
        let whole: f64 = sum.iter().sum();
        let shares = cells.iter().map(|steps| steps.len() as f64 / n_steps);
        sum.iter_mut().zip(shares).for_each(|(value, share)| *value -= share * whole);
    }
    sums
}

/// The sums of pushes times (Σssᵀ)^(−½), and the number of directions in which they vary; none if
/// there is none, as with a single cell.
fn whitened(sums: Vec<Vec<f64>>) -> Option<(Vec<DVector<f64>>, f64)> {
    let sums: Vec<DVector<f64>> = sums.into_iter().map(DVector::from_vec).collect();
    let n = sums.first().map(DVector::len).filter(|n| *n > 0)?;
    let scatter = sums.iter().fold(DMatrix::zeros(n, n), |all, sum| all + sum * sum.transpose());
    let eigen = scatter.symmetric_eigen();
    let least = 1e-10 * eigen.eigenvalues.max();
    let roots =
        eigen.eigenvalues.map(|value| if value > least { value.sqrt().recip() } else { 0.0 });
    let rank = roots.iter().filter(|root| **root > 0.0).count();
    let whitening = DMatrix::from_diagonal(&roots) * eigen.eigenvectors.transpose();
    (rank > 0).then(|| (sums.iter().map(|sum| &whitening * sum).collect(), rank as f64))
}

#[cfg(test)]
mod tests {
    use super::{contrasts, whitened};

    #[test]
    fn a_common_mean_is_no_structure_and_one_cell_has_none() {
        let cells = |bias: f64| {
            let value = |k: usize| bias + (k as f64 * 1.7).sin();
            let of = |first: usize| -> Vec<_> { (0..8).map(|k| (k, value(first + k))).collect() };
            [of(0), of(8), of(16)]
        };
        let of = |bias: f64| {
            let cells = cells(bias);
            let cells: Vec<_> = cells.iter().map(Vec::as_slice).collect();
            contrasts(&cells, 8)
        };
        for (with, without) in of(3.0).iter().flatten().zip(of(0.0).iter().flatten()) {
            assert!((with - without).abs() < 1e-12);
        }
        let (scores, rank) = whitened(of(0.0)).unwrap();
        assert_eq!((scores.len(), rank), (8, 2.0));
        let alone = cells(1.0);
        assert!(whitened(contrasts(&[&alone[0]], 8)).is_none());
    }
}
