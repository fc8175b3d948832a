//! Which pushes share errors.

use models::Cluster;

use crate::{DiagnosisError, Observations};

impl Observations {
    /// How many clusters there are.
    pub(crate) fn n_clusters(&self) -> usize {
        self.cluster_of.iter().max().map_or(0, |last| last + 1)
    }

    /// The cluster of each push.
    pub(crate) fn clusters_of_pushes(&self) -> Vec<usize> {
        let mut clusters = vec![0; self.pushes.len()];
        for (push, cluster) in self.push_of.iter().zip(&self.cluster_of) {
            clusters[*push] = *cluster;
        }
        clusters
    }

    /// The pushes of each cluster.
    pub(crate) fn pushes_of_clusters(&self) -> Vec<Vec<usize>> {
        let mut pushes = vec![Vec::new(); self.n_clusters()];
        for (push, cluster) in self.clusters_of_pushes().into_iter().enumerate() {
            pushes[cluster].push(push);
        }
        pushes
    }

    /// A cluster in words: a push by its name, a session by its first push.
    pub(crate) fn name_of_cluster(&self, cluster: usize) -> String {
        let pushes = &self.pushes_of_clusters()[cluster];
        let first = &self.pushes[pushes[0]];
        match self.cluster {
            Cluster::Push => format!("push {first}"),
            Cluster::Session => format!("the session of push {first}"),
        }
    }

    /// The error of a number that a cluster alone determines.
    pub(crate) fn alone_determines(&self, cluster: usize) -> DiagnosisError {
        let pushes = &self.pushes_of_clusters()[cluster];
        DiagnosisError::OneCluster {
            cluster: self.name_of_cluster(cluster),
            pushes: pushes.iter().map(|push| self.pushes[*push].to_string()).collect(),
        }
    }
}
