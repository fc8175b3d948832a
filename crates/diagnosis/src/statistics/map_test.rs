//! Whether means differ between the cells of a map by more than chance.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::statistics::quantile::normal_of_chi_square;

/// Where each step of a map belongs.
#[derive(Clone, Debug)]
pub(crate) struct MapTest {
    /// None for a step without value or in a cell with too little.
    cell_of: Vec<Option<usize>>,
    /// Share of the steps in each cell; empty for the test of one common mean against zero.
    shares: Vec<f64>,
    /// Mean and variance of the statistic under flips.
    moments: [f64; 2],
}

/// Flips of the signs of whole clusters.
pub(crate) struct Flips(Vec<Vec<i8>>);

/// The largest normal quantile among all maps, for each flip.
pub(crate) struct Largest(Vec<f64>);

/// What flips act on: sums of each cluster.
struct Sums {
    by_cluster: Vec<Vec<(usize, f64)>>,
    whole: Vec<f64>,
    /// Reciprocal of Σs² of each cell.
    weights: Vec<f64>,
}

impl Flips {
    pub(crate) fn new(n_flips: usize, n_clusters: usize, seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let flip = |_| (0..n_clusters).map(|_| if rng.random::<bool>() { 1 } else { -1 }).collect();
        Self((0..n_flips).map(flip).collect())
    }
}

impl MapTest {
    /// The test for means that differ between cells, and the quantile of each flip.
    ///
    /// With s the sums of a cluster's residuals in the cells, less each cell's share of its whole
    /// sum, T = Σ (Σs)²/Σs², first over clusters and then over cells. No matrix is inverted, and a
    /// cell of few clusters weighs no more than their number: sparse cells do no harm.
    pub(crate) fn of_cells(
        cell_of: Vec<Option<usize>>,
        n_cells: usize,
        (values, clusters): (&[f64], &[usize]),
        flips: &Flips,
    ) -> Option<(Self, Vec<f64>)> {
        let mut shares = vec![0.0; n_cells];
        cell_of.iter().flatten().for_each(|cell| shares[*cell] += 1.0);
        let n_steps: f64 = shares.iter().sum();
        shares.iter_mut().for_each(|share| *share /= n_steps);
        let many = shares.iter().filter(|share| **share > 0.0).count() > 1;
        many.then(|| Self::calibrated(cell_of, shares, (values, clusters), flips)).flatten()
    }

    /// The test for a common mean other than zero.
    pub(crate) fn of_mean(
        is_used: impl Iterator<Item = bool>,
        (values, clusters): (&[f64], &[usize]),
        flips: &Flips,
    ) -> Option<(Self, Vec<f64>)> {
        let cell_of = is_used.map(|used| used.then_some(0)).collect();
        Self::calibrated(cell_of, Vec::new(), (values, clusters), flips)
    }

    fn calibrated(
        cell_of: Vec<Option<usize>>,
        shares: Vec<f64>,
        (values, clusters): (&[f64], &[usize]),
        flips: &Flips,
    ) -> Option<(Self, Vec<f64>)> {
        let mut test = Self { cell_of, shares, moments: [0.0; 2] };
        let sums = test.sums(values, clusters);
        let of = |signs: &Vec<i8>| test.statistic(&sums, |cluster| f64::from(signs[cluster]));
        let mut flipped: Vec<f64> = flips.0.iter().map(of).collect();
        let n = flipped.len() as f64;
        let mean = flipped.iter().sum::<f64>() / n;
        let variance = flipped.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / n;
        test.moments = [mean, variance];
        flipped.iter_mut().for_each(|value| *value = test.quantile(*value));
        (mean > 0.0 && variance > 1e-9 * mean * mean).then_some((test, flipped))
    }

    /// The normal quantile of the statistic of other values in the same cells.
    pub(crate) fn normal_quantile(&self, values: &[f64], clusters: &[usize]) -> f64 {
        self.quantile(self.statistic(&self.sums(values, clusters), |_| 1.0))
    }

    /// The cell of each step, where it has one with enough data.
    pub(crate) fn cell_of(&self) -> &[Option<usize>] {
        &self.cell_of
    }

    /// By the χ² distribution with the statistic's mean and variance.
    fn quantile(&self, statistic: f64) -> f64 {
        let [mean, variance] = self.moments;
        let freedom = 2.0 * mean * mean / variance;
        normal_of_chi_square(statistic * freedom / mean, freedom)
    }

    fn sums(&self, values: &[f64], clusters: &[usize]) -> Sums {
        let used = || self.cell_of.iter().enumerate().filter_map(|(k, cell)| Some((k, (*cell)?)));
        let n_steps = used().count() as f64;
        let is_mean = self.shares.is_empty();
        let total: f64 = used().map(|(k, _)| values[k]).sum();
        let center = if is_mean { 0.0 } else { total / n_steps };
        let n_clusters = clusters.iter().max().map_or(0, |last| last + 1);
        let mut by_cluster: Vec<Vec<(usize, f64)>> = vec![Vec::new(); n_clusters];
        for (k, cell) in used() {
            let (sums, value) = (&mut by_cluster[clusters[k]], values[k] - center);
            match sums.iter_mut().find(|(known, _)| *known == cell) {
                Some((_, sum)) => *sum += value,
                None => sums.push((cell, value)),
            }
        }
        let whole: Vec<f64> =
            by_cluster.iter().map(|sums| sums.iter().map(|(_, sum)| sum).sum()).collect();
        let n_cells = self.shares.len().max(1);
        let share = |cell: usize| self.shares.get(cell).copied().unwrap_or(0.0);
        let squares: f64 = whole.iter().map(|sum| sum * sum).sum();
        let mut scatter: Vec<f64> = (0..n_cells).map(|c| share(c).powi(2) * squares).collect();
        for (sums, whole) in by_cluster.iter().zip(&whole) {
            for (cell, sum) in sums {
                scatter[*cell] += sum * sum - 2.0 * share(*cell) * sum * whole;
            }
        }
        let least = 1e-12 * scatter.iter().copied().fold(0.0, f64::max);
        let weight = |scatter: &f64| if *scatter > least { scatter.recip() } else { 0.0 };
        Sums { weights: scatter.iter().map(weight).collect(), by_cluster, whole }
    }

    fn statistic(&self, sums: &Sums, sign: impl Fn(usize) -> f64) -> f64 {
        let mut cells = vec![0.0; sums.weights.len()];
        let mut whole = 0.0;
        for (cluster, own) in sums.by_cluster.iter().enumerate() {
            let sign = sign(cluster);
            own.iter().for_each(|(cell, sum)| cells[*cell] += sign * sum);
            whole += sign * sums.whole[cluster];
        }
        let share = |cell: usize| self.shares.get(cell).copied().unwrap_or(0.0);
        let parts = cells.iter().zip(&sums.weights).enumerate();
        parts.map(|(cell, (sum, weight))| weight * (sum - share(cell) * whole).powi(2)).sum()
    }
}

impl Largest {
    /// Over the quantiles of the flips of each map.
    pub(crate) fn of(maps: &[Vec<f64>]) -> Self {
        let n_flips = maps.first().map_or(0, Vec::len);
        let largest =
            |flip: usize| maps.iter().map(|map| map[flip]).fold(f64::NEG_INFINITY, f64::max);
        Self((0..n_flips).map(largest).collect())
    }

    /// Probability that chance makes any map as sure as this.
    pub(crate) fn probability(&self, quantile: f64) -> f64 {
        let above = self.0.iter().filter(|value| **value >= quantile).count();
        (1 + above) as f64 / (1 + self.0.len()) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::{Flips, Largest, MapTest};

    /// Forty clusters of six steps, one in each cell; `effect` in the first cell.
    fn quantile(bias: f64, effect: f64) -> (f64, Vec<f64>) {
        let clusters: Vec<usize> = (0..240).map(|k| k / 6).collect();
        let value = |k: usize| {
            let noise = (k as f64 * 12.9898).sin() + (clusters[k] as f64 * 78.233).sin();
            bias + noise + if k.is_multiple_of(6) { effect } else { 0.0 }
        };
        let values: Vec<f64> = (0..240).map(value).collect();
        let cells = (0..240).map(|k| Some(k % 6)).collect();
        let flips = Flips::new(499, 40, 7);
        let (test, flipped) = MapTest::of_cells(cells, 6, (&values, &clusters), &flips).unwrap();
        (test.normal_quantile(&values, &clusters), flipped)
    }

    #[test]
    fn only_means_that_differ_are_structure() {
        let (none, flipped) = quantile(0.0, 0.0);
        let (biased, _) = quantile(5.0, 0.0);
        assert!((none - biased).abs() < 1e-9, "{none} {biased}");
        let largest = Largest::of(&[flipped]);
        assert!(largest.probability(none) > 0.05, "{none}");
        assert!(largest.probability(quantile(0.0, 1.0).0) < 0.005);
    }

    #[test]
    fn flips_of_noise_are_about_standard_normal() {
        let (_, flipped) = quantile(0.0, 0.0);
        let n = flipped.len() as f64;
        let mean = flipped.iter().sum::<f64>() / n;
        let variance = flipped.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / n;
        assert!(mean.abs() < 0.1 && (variance - 1.0).abs() < 0.2, "{mean} {variance}");
    }

    #[test]
    fn a_common_mean_is_found_by_its_own_test_alone() {
        let clusters: Vec<usize> = (0..60).map(|k| k / 3).collect();
        let values: Vec<f64> = (0..60).map(|k| 0.5 + (k as f64 * 2.3).sin()).collect();
        let flips = Flips::new(199, 20, 1);
        let used = || values.iter().map(|_| true);
        let (test, flipped) = MapTest::of_mean(used(), (&values, &clusters), &flips).unwrap();
        let found = test.normal_quantile(&values, &clusters);
        assert!(Largest::of(&[flipped]).probability(found) < 0.01, "{found}");
        let one_cell = vec![Some(0); 60];
        assert!(MapTest::of_cells(one_cell, 1, (&values, &clusters), &flips).is_none());
    }
}
