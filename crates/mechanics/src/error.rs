//! What can go wrong in the mechanics.

/// Why a quantity could not be computed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MechanicsError {
    /// A quantity that must be positive and finite is not.
    #[error("{name} must be positive and finite, got {value} {unit}")]
    NotPositive {
        /// Which quantity.
        name: &'static str,
        /// What was given.
        value: f64,
        /// Its unit.
        unit: &'static str,
    },
    /// A quantity that must not be negative, and must be finite, is.
    #[error("{name} must be finite and not negative, got {value} {unit}")]
    Negative {
        /// Which quantity.
        name: &'static str,
        /// What was given.
        value: f64,
        /// Its unit.
        unit: &'static str,
    },
    /// A component is NaN or infinite.
    #[error("{name} must be finite, got {value} {unit}")]
    NotFinite {
        /// Which quantity.
        name: &'static str,
        /// What was given.
        value: f64,
        /// Its unit.
        unit: &'static str,
    },
    /// A direction was asked of a vector without one.
    #[error("{name} is zero and has no direction")]
    NoDirection {
        /// Which vector.
        name: &'static str,
    },
    /// An iteration ended before it reached its tolerance.
    #[error(
        "{what} did not converge: residual {residual:e} after {iterations} iterations (tolerance {tolerance:e})"
    )]
    NotConverged {
        /// What was being solved.
        what: &'static str,
        /// Steps taken.
        iterations: usize,
        /// What was left.
        residual: f64,
        /// What was asked for.
        tolerance: f64,
    },
    /// The load besides the pusher's is more than friction can bear.
    #[error(
        "the external load is {level} times what the limit surface bears: the object slides without a push, lower the load or raise the friction"
    )]
    SlidesByItself {
        /// The load's level on the limit surface, 1 at most for rest.
        level: f64,
    },
    /// A pusher's path is not usable.
    #[error("point {index} of the pusher's path: {reason}")]
    BadPath {
        /// 0-based point, or the number of points if they are too few.
        index: usize,
        /// What is wrong.
        reason: &'static str,
    },
}
