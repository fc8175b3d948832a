//! What shares errors, a push or a session, and means over steps that know it.

use std::collections::HashMap;
use std::hash::Hash;

use models::{ChannelObservation, Cluster};

use crate::cut_offs::FEWEST_SESSIONS;
use crate::statistics::quantile::student_975;

/// What shares errors, and its index for each step of a whole set.
pub(crate) fn clusters(steps: &[ChannelObservation], push_of: &[usize]) -> (Cluster, Vec<usize>) {
    let mut session_of = HashMap::new();
    for (step, push) in steps.iter().zip(push_of) {
        // A push that a table spreads over sessions is of the one that it begins in.
        session_of.entry(*push).or_insert(step.input.session);
    }
    let sessions = numbered(push_of.iter().map(|push| session_of[push]));
    match sessions.iter().max().map_or(0, |last| last + 1) {
        FEWEST_SESSIONS.. => (Cluster::Session, sessions),
        _ => (Cluster::Push, push_of.to_vec()),
    }
}

/// Each label's number, counted from 0 in the order in which labels come.
pub(crate) fn numbered<T: Eq + Hash>(labels: impl Iterator<Item = T>) -> Vec<usize> {
    let mut numbers = HashMap::new();
    let number = |label: T| {
        let next = numbers.len();
        *numbers.entry(label).or_insert(next)
    };
    labels.map(number).collect()
}

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
    use super::{ClusterMean, clusters};
    use crate::split;
    use crate::synthetic::{made, recorded};
    use models::Cluster;

    #[test]
    fn parts_keep_the_clusters_of_their_whole() {
        let (all, _) = recorded(15);
        let parts = split(&all, 7).unwrap();
        let [fit, confirm] = [&parts.fit, &parts.confirm].map(|names| all.part(names).unwrap());
        let half = fit.part(&parts.fit[..20]).unwrap();
        for (part, n) in [(&all, 15), (&fit, 11), (&confirm, 4)] {
            assert_eq!((part.cluster, part.n_clusters()), (Cluster::Session, n));
        }
        assert_eq!(half.cluster, Cluster::Session);
        for part in [&all, &fit, &confirm, &half] {
            for (step, cluster) in part.steps.iter().zip(&part.cluster_of) {
                for (other, other_cluster) in part.steps.iter().zip(&part.cluster_of) {
                    let is_same = step.input.session == other.input.session;
                    assert_eq!(is_same, cluster == other_cluster);
                }
            }
            let mut pushes: Vec<usize> = part.pushes_of_clusters().concat();
            pushes.sort_unstable();
            assert!(pushes.into_iter().eq(0..part.pushes.len()));
        }
        let few = recorded(11).0;
        assert_eq!((few.cluster, few.n_clusters()), (Cluster::Push, few.pushes.len()));
    }

    #[test]
    fn a_push_that_goes_on_into_another_session_is_of_one_cluster() {
        let (mut all, ..) = made(0, |_| 0.0);
        for (index, step) in all.steps.iter_mut().enumerate() {
            // Twenty sessions, each of which begins within a push.
            step.input.session = ((index + 2) / 240) as u32;
        }
        let (cluster, of_step) = clusters(&all.steps, &all.push_of);
        assert_eq!(cluster, Cluster::Session);
        for (one, other) in (0..all.steps.len()).zip(1..all.steps.len()) {
            if all.push_of[one] == all.push_of[other] {
                assert_eq!(of_step[one], of_step[other], "{one}");
            }
        }
    }

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
