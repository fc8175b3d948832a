//! What can go wrong, each with its step and the remedy.

/// Why a filter could not be made, or could not go on.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FilterError {
    /// No particles, or no components.
    #[error("{what}: empty, give at least one")]
    Empty {
        /// What there is none of.
        what: &'static str,
    },
    /// Two arguments disagree about a number of entries.
    #[error("{what}: expected {expected}, got {actual}")]
    ShapeMismatch {
        /// What was counted.
        what: &'static str,
        /// The count that the other arguments ask for.
        expected: usize,
        /// The count that was given.
        actual: usize,
    },
    /// A setting out of its range.
    #[error("{name} must be {expected}, got {value}")]
    OutOfRange {
        /// Which setting.
        name: &'static str,
        /// What is allowed.
        expected: &'static str,
        /// Its value.
        value: f64,
    },
    /// A likelihood or a state that is no number.
    #[error("step {step}: {what} of particle {particle} is {value}; repair the model")]
    NotANumber {
        /// Steps made before.
        step: usize,
        /// What is no number.
        what: &'static str,
        /// Which particle, counted from 0.
        particle: usize,
        /// Its value.
        value: f64,
    },
    /// No particle can explain the measurement.
    #[error(
        "step {step}: all {n_particles} particles have likelihood zero; widen the motion or the \
         measurement noise, or inject particles with `update_or_inject`"
    )]
    Collapsed {
        /// Steps made before.
        step: usize,
        /// How many particles there are.
        n_particles: usize,
    },
    /// A number of a model that is none.
    #[error("{what} is {value}; repair the model or the measurement")]
    NotFinite {
        /// What is no number.
        what: &'static str,
        /// Its value.
        value: f64,
    },
    /// A covariance without an inverse.
    #[error("the {dimension}-dimensional {what} is singular; give the measurement noise")]
    Singular {
        /// Of what.
        what: &'static str,
        /// Its dimension.
        dimension: usize,
    },
    /// A covariance that is none.
    #[error("the {dimension}-dimensional covariance is not positive semi-definite")]
    NotPositiveSemiDefinite {
        /// Its dimension.
        dimension: usize,
    },
    /// The measurement of a particle refused.
    #[error("step {step}: the measurement of particle {particle} refuses")]
    Measurement {
        /// Steps made before.
        step: usize,
        /// Which particle, counted from 0.
        particle: usize,
        /// Why.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// The motion model refused a step.
    #[error("step {step}: the motion model refuses")]
    Motion {
        /// Steps made before.
        step: usize,
        /// Why.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
}
