//! Covariance of estimates whose data share errors within clusters.

use nalgebra::{DMatrix, DVector};

use super::descent::Minimum;
use super::problem::Problem;

/// What estimates leave open, in the numbers that were moved.
#[derive(Clone, Debug)]
pub(super) struct Sandwich {
    /// By the scatter of whole clusters and the priors, with the model's own tolerance.
    pub(super) covariance: DMatrix<f64>,
    /// By the curvature alone, as if the noise were known.
    pub(super) of_curvature: DMatrix<f64>,
}

/// Share of an estimate by which models of rigs miss the truth.
const MODEL_TOLERANCE: f64 = 0.01;

impl Sandwich {
    /// The jackknife over clusters, in one Newton step each.
    ///
    /// With A the curvature, u and A₁ a cluster's share of the slope and of A, leaving the cluster
    /// out moves the estimate by δ = (A − A₁)⁻¹u; V = (G−1)/G Σ δδᵀ + A⁻¹PA⁻¹, with P the priors'
    /// share of A, for each prior stands for one measurement of its own. To each variance
    /// (1 % of the estimate)² is added, and to V what the descent left undone.
    ///
    /// # Source
    /// Bell & McCaffrey (2002), Bias reduction in standard errors for linear regression with
    /// multi-stage samples, Survey Methodology 28(2).
    pub(super) fn of(
        problem: &Problem,
        minimum: &Minimum,
        clusters: &[Vec<usize>],
    ) -> Option<Self> {
        let Minimum { at, slopes, weights, curvature, moved, .. } = minimum;
        let (all_rows, n) = (problem.whitening.rows(), moved.len());
        let inverse = curvature.clone().cholesky()?.inverse();
        let mut sum = DMatrix::zeros(n, n);
        for cluster in clusters {
            let (mut slope, mut share) = (DVector::zeros(n), DMatrix::zeros(n, n));
            for row in cluster.iter().flat_map(|push| all_rows[*push].clone()) {
                let of_row = slopes.row(row).transpose();
                slope.axpy(weights[row] * at.z[row], &of_row, 1.0);
                share.ger(weights[row], &of_row, &of_row, 1.0);
            }
            let shift = (curvature - share).cholesky()?.solve(&slope);
            sum.ger(1.0, &shift, &shift, 1.0);
        }
        let n_clusters = clusters.len() as f64;
        let first = problem.whitening.n_numbers();
        let priors = slopes.rows(first, slopes.nrows() - first);
        let of_priors = &inverse * (priors.transpose() * priors) * &inverse;
        let of_curvature = &inverse * problem.robust.scale().powi(2);
        let mut covariance = sum * ((n_clusters - 1.0) / n_clusters) + of_priors;
        covariance += minimum.decrement * &of_curvature;
        for (column, &k) in moved.iter().enumerate() {
            covariance[(column, column)] += (MODEL_TOLERANCE * at.x[k]).powi(2);
        }
        Some(Self { covariance, of_curvature })
    }
}
