//! Means over steps whose errors are shared within a cluster: a push or a session.

use crate::quantile::student_975;

/// A mean over steps, with a standard error from the sums of whole clusters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ClusterMean {
    pub(crate) mean: f64,
    pub(crate) se: f64,
    pub(crate) n_steps: usize,
    pub(crate) n_clusters: usize,
}

impl ClusterMean {
    /// Over pairs of (cluster, value); none for fewer than two clusters.
    pub(crate) fn of(values: &[(usize, f64)]) -> Option<Self> {
        let mut values = values.to_vec();
        values.sort_by_key(|(cluster, _)| *cluster);
        let n_steps = values.len();
        let mean = values.iter().map(|(_, value)| value).sum::<f64>() / n_steps as f64;
        let sums = values.chunk_by(|a, b| a.0 == b.0);
        let sums: Vec<f64> =
            sums.map(|cluster| cluster.iter().map(|(_, value)| value - mean).sum()).collect();
        let n = sums.len() as f64;
        if sums.len() < 2 {
            return None;
        }
        let scatter = sums.iter().map(|sum| sum * sum).sum::<f64>() * n / (n - 1.0);
        Some(Self { mean, se: scatter.sqrt() / n_steps as f64, n_steps, n_clusters: sums.len() })
    }

    /// The 95 % interval of the mean.
    pub(crate) fn interval(&self) -> [f64; 2] {
        let half = student_975(self.n_clusters as f64 - 1.0) * self.se;
        [self.mean - half, self.mean + half]
    }
}

#[cfg(test)]
mod tests {
    use super::ClusterMean;

    #[test]
    fn steps_that_repeat_their_push_add_nothing() {
        let one: Vec<_> = [0.3, -0.2, 0.9, 0.1].into_iter().enumerate().collect();
        let many: Vec<_> = one.iter().flat_map(|pair| [*pair; 5]).collect();
        let (one, many) = (ClusterMean::of(&one).unwrap(), ClusterMean::of(&many).unwrap());
        assert!((one.mean - many.mean).abs() < 1e-15 && (one.se - many.se).abs() < 1e-15);
        // Standard error of the mean of four independent numbers.
        let sd = ([0.3, -0.2, 0.9, 0.1].map(|x: f64| (x - 0.275).powi(2)).iter().sum::<f64>()
            / 3.0)
            .sqrt();
        assert!((one.se - sd / 2.0).abs() < 1e-15);
        assert!(ClusterMean::of(&[(0, 1.0), (0, 2.0)]).is_none());
    }
}
