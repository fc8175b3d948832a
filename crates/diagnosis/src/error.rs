//! What can go wrong in a comparison.

use std::path::PathBuf;

use crate::Undetermined;

/// Why observations and a model could not be compared.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DiagnosisError {
    /// Too few pushes to say anything of errors that steps of one push share.
    #[error(
        "{n_pushes} pushes have steps to compare, at least {needed} are needed: record {} more, of at \
         least 20 mm each; rows excluded: {}", needed.saturating_sub(*n_pushes),
        if excluded.is_empty() { "none" } else { excluded }
    )]
    TooFewPushes {
        /// How many there are.
        n_pushes: usize,
        /// How many are needed.
        needed: usize,
        /// Rows excluded, by reason.
        excluded: String,
    },
    /// A second set is not of the same rig as the first, or is the first.
    #[error("the set that is to confirm cannot: {what}; give other recordings of the same rig")]
    OtherKind {
        /// How it differs.
        what: &'static str,
    },
    /// Predictions are of other observations.
    #[error("{n_predictions} predictions do not fit {n_steps} steps; predict these observations")]
    OtherSteps {
        /// Number of predictions.
        n_predictions: usize,
        /// Number of steps.
        n_steps: usize,
    },
    /// A matrix is no covariance of a push's numbers.
    #[error("the covariance of push {push} is not positive definite, or not of its numbers' size")]
    NotACovariance {
        /// 0-based index of the push.
        push: usize,
    },
    /// Nothing that was measured, nor a prior, depends on a number that is to be fitted.
    #[error("nothing depends on one of the numbers to be fitted; free fewer")]
    Flat,
    /// One cluster alone determines a number that is to be fitted: its error cannot be told.
    #[error(
        "one of the numbers to be fitted rests on {cluster} alone, so nothing tells how wrong it is; \
         record others that show it, or free fewer"
    )]
    OneCluster {
        /// The push, or the session, in words.
        cluster: String,
        /// Names of its pushes.
        pushes: Vec<String>,
    },
    /// The data do not determine an effect.
    #[error("{effect} cannot be determined: {why}")]
    Undetermined {
        /// Id of the effect.
        effect: &'static str,
        /// Why, and what to do.
        why: Undetermined,
    },
    /// A score could not be computed.
    #[error("the model's intervals cannot be scored")]
    Scores(#[from] gp_core::GpError),
    /// A diagnosis leaves nothing to tell apart and nothing to measure better.
    #[error(
        "the diagnosis has no rivals, no named effect and no hint that pushes could decide; name an \
         effect that they are to make testable"
    )]
    NothingToSuggest,
    /// Hardly any push can be done within the limits.
    #[error(
        "{n_feasible} of {n_candidates} pushes of {:.0} mm can be done where the object stays within \
         {:.0} × {:.0} mm and off its vertices; allow a larger area or another way: slow pushes \
         need {:.0} mm for four steps, fast ones more",
        1e3 * travel, 1e3 * area[0], 1e3 * area[1], 1e3 * shortest
    )]
    NoFeasiblePush {
        /// How many were tried.
        n_candidates: usize,
        /// How many can be done.
        n_feasible: usize,
        /// Way of a push, in m.
        travel: f64,
        /// Way that holds the fewest steps that are of use, in m.
        shortest: f64,
        /// Extents of the area, in m.
        area: [f64; 2],
    },
    /// No push that can be done makes an effect testable.
    #[error(
        "no push of those that can be done shows {effect}: {because}; what it needs is in `pushlab \
         effects explain {effect}`"
    )]
    NoPushShows {
        /// Id of the effect.
        effect: String,
        /// What stands in the way.
        because: &'static str,
    },
    /// An effect of which no fit tells how it differs from push to push.
    #[error("how {effect} differs from push to push is not fitted: {why}")]
    NotPerPush {
        /// Id of the effect.
        effect: &'static str,
        /// Why, and what to do.
        why: &'static str,
    },
    /// Parts of a set do not go together, or an effect is not for them.
    #[error("{what}")]
    Parts {
        /// What is wrong, and what to do.
        what: String,
    },
    /// A search did not end.
    #[error(
        "{what} did not converge: after {iterations} iterations the likelihood still rises by \
         {decrement:e}; check the recordings for pushes that do not belong"
    )]
    NotConverged {
        /// What was searched for.
        what: &'static str,
        /// Iterations.
        iterations: usize,
        /// Twice the gain in log likelihood that a further step would expect.
        decrement: f64,
    },
    /// A file cannot be read.
    #[error(transparent)]
    Dataset(Box<dataset::DatasetError>),
    /// A file is no diagnosis that this release reads.
    #[error("{}{place}: {what}", path.display())]
    NoDiagnosis {
        /// The file.
        path: PathBuf,
        /// `:line:column`, where there is one.
        place: String,
        /// What is wrong, and what to do.
        what: String,
    },
    /// The table or the model was refused.
    #[error(transparent)]
    Model(#[from] models::ModelError),
}

impl From<dataset::DatasetError> for DiagnosisError {
    fn from(error: dataset::DatasetError) -> Self {
        Self::Dataset(Box::new(error))
    }
}
