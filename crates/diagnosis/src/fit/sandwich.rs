//! Covariance of estimates whose data share errors within clusters.

use nalgebra::DMatrix;

use super::descent::Minimum;
use super::problem::Problem;
use crate::cut_offs::MODEL_TOLERANCE;
use crate::{DiagnosisError, Observations};

/// The jackknife over clusters, in one Newton step each, halved until the others gain by it or it is short.
///
/// With A the curvature and δ what leaving a cluster out moves the estimate by,
/// V = (G−1)/G Σ δδᵀ + A⁻¹PA⁻¹, with P the priors' share of A, for each prior stands for one
/// measurement of its own. To each variance (1 % of the estimate's size)² is added, a vector's in
/// every direction, so that no choice of axes matters; and to V what the descent left undone.
///
/// # Errors
/// `Flat`; `OneCluster`.
///
/// # Source
/// Bell & McCaffrey (2002), Bias reduction in standard errors for linear regression with
/// multi-stage samples, Survey Methodology 28(2).
pub(super) fn sandwich(
    problem: &Problem,
    minimum: &Minimum,
    observations: &Observations,
) -> Result<DMatrix<f64>, DiagnosisError> {
    let Minimum { at, slopes, curvature, moved, .. } = minimum;
    let n = moved.len();
    let inverse = curvature.clone().cholesky().ok_or(DiagnosisError::Flat)?.inverse();
    let mut sum = DMatrix::zeros(n, n);
    let clusters = observations.pushes_of_clusters();
    for (cluster, pushes) in clusters.iter().enumerate() {
        let without = problem.without(minimum, pushes);
        let shift = without.ok_or_else(|| observations.alone_determines(cluster))?.shift;
        sum.ger(1.0, &shift, &shift, 1.0);
    }
    let n_clusters = clusters.len() as f64;
    let first = problem.whitening.n_numbers();
    // What a prior says is off by its standard deviation, however much it is made to weigh.
    let mut priors = slopes.rows(first, slopes.nrows() - first).into_owned();
    for (mut row, noise) in priors.row_iter_mut().zip(problem.space.noise_of_strains(&at.x)) {
        row *= noise;
    }
    let of_priors = &inverse * (priors.transpose() * priors) * &inverse;
    let of_curvature = &inverse * problem.robust.scale().powi(2);
    let mut covariance = sum * ((n_clusters - 1.0) / n_clusters) + of_priors;
    covariance += minimum.decrement * &of_curvature;
    let shares = problem.space.shares(&at.x);
    let sizes = shares.flat_map(|(member, own)| member.sizes(own));
    let sizes: Vec<f64> = sizes.chain(problem.space.spread_at(&at.x)).collect();
    for (column, &k) in moved.iter().enumerate() {
        covariance[(column, column)] += (MODEL_TOLERANCE * sizes[k]).powi(2);
    }
    Ok(covariance)
}
