//! Sums of a number over steps that share their pushes.

use serde::{Deserialize, Serialize};

use crate::data::clusters::ClusterMean;

/// Of the values of some steps: n, the number of pushes m, Σ v, Σ v², and over pushes with sums S of n′ steps
/// Σ S², Σ S n′ and Σ n′².
///
/// A push is in one of those that are added, as a whole.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub(crate) struct Sums([f64; 7]);

impl Sums {
    /// Over pairs of (push, value).
    pub(crate) fn of(values: &[(usize, f64)]) -> Self {
        let mut values = values.to_vec();
        values.sort_by_key(|(push, _)| *push);
        let mut all = Self::default();
        for of_push in values.chunk_by(|a, b| a.0 == b.0) {
            let n = of_push.len() as f64;
            let sum: f64 = of_push.iter().map(|(_, value)| value).sum();
            let squares: f64 = of_push.iter().map(|(_, value)| value * value).sum();
            all.add(&Self([n, 1.0, sum, squares, sum * sum, sum * n, n * n]));
        }
        all
    }

    pub(crate) fn add(&mut self, other: &Self) {
        self.0.iter_mut().zip(&other.0).for_each(|(sum, other)| *sum += other);
    }

    pub(crate) fn n_steps(&self) -> usize {
        self.0[0] as usize
    }

    pub(crate) fn n_pushes(&self) -> usize {
        self.0[1] as usize
    }

    pub(crate) fn sum(&self) -> f64 {
        self.0[2]
    }

    /// Mean of the squares.
    pub(crate) fn mean_square(&self) -> f64 {
        self.0[3] / self.0[0]
    }

    /// The mean, with a standard error from whole pushes; none for fewer than two.
    pub(crate) fn mean(&self) -> Option<ClusterMean> {
        let [n, n_pushes, sum, _, of_sums, of_products, of_numbers] = self.0;
        if n_pushes < 2.0 {
            return None;
        }
        let mean = sum / n;
        // Σ (S − mean n′)².
        let scatter = of_sums - 2.0 * mean * of_products + mean * mean * of_numbers;
        let se = (scatter.max(0.0) * n_pushes / (n_pushes - 1.0)).sqrt() / n;
        Some(ClusterMean { mean, se, n_steps: n as usize, n_clusters: n_pushes as usize })
    }
}

#[cfg(test)]
mod tests {
    use super::Sums;
    use crate::data::clusters::ClusterMean;

    #[test]
    fn the_mean_of_parts_is_that_of_all_steps() {
        let value = |k: usize| 0.3 + (k as f64 * 1.7).sin();
        let all: Vec<(usize, f64)> = (0..60).map(|k| (k / 7, value(k))).collect();
        let whole = ClusterMean::of(&all).unwrap();
        let mut sums = Sums::of(&all[..28]);
        sums.add(&Sums::of(&all[28..]));
        let found = sums.mean().unwrap();
        assert_eq!((found.n_steps, found.n_clusters), (60, whole.n_clusters));
        assert!((found.mean - whole.mean).abs() < 1e-15, "{found:?} {whole:?}");
        assert!((found.se / whole.se - 1.0).abs() < 1e-12, "{found:?} {whole:?}");
        let square = all.iter().map(|(_, value)| value * value).sum::<f64>() / 60.0;
        assert!((sums.mean_square() - square).abs() < 1e-15);
        assert!(Sums::of(&all[..7]).mean().is_none());
    }
}
