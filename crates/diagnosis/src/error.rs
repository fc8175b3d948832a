//! What can go wrong in a comparison.

/// Why observations and a model could not be compared.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum DiagnosisError {
    /// Too few pushes to say anything of errors that steps of one push share.
    #[error(
        "{n_pushes} pushes have steps to compare, at least {needed} are needed; rows set aside: {set_aside}"
    )]
    TooFewPushes {
        /// How many there are.
        n_pushes: usize,
        /// How many are needed.
        needed: usize,
        /// Rows set aside, by reason.
        set_aside: String,
    },
    /// Predictions are of other observations.
    #[error("{n_predictions} predictions do not fit {n_steps} steps; predict these observations")]
    OtherSteps {
        /// Number of predictions.
        n_predictions: usize,
        /// Number of steps.
        n_steps: usize,
    },
    /// A matrix that is no covariance.
    #[error(
        "the covariance of the {n_numbers} numbers of push {push} must be positive definite; check \
         that no standard deviation is 0 or not finite"
    )]
    NotACovariance {
        /// The push, counted from 0.
        push: usize,
        /// How many numbers of it are observed.
        n_numbers: usize,
    },
    /// The table or the model was refused.
    #[error(transparent)]
    Model(#[from] models::ModelError),
}
