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
    /// A bracket that holds no root of an increasing function.
    #[error(
        "{what} is not where it was looked for: the function is {} at {} and {} at {}, which must be \
         negative and positive",
        from[1], from[0], to[1], to[0]
    )]
    NoSignChange {
        /// What was being solved.
        what: &'static str,
        /// The lower end and the function there.
        from: [f64; 2],
        /// The upper end and the function there.
        to: [f64; 2],
    },
    /// The load besides the pusher's is more than friction can bear.
    #[error(
        "the external load is {level} times what the limit surface bears: the object slides without a push, lower the load or raise the friction"
    )]
    SlidesByItself {
        /// The load's level on the limit surface, 1 at most for rest.
        level: f64,
    },
    /// Contacts of one pusher that do not move together.
    #[error("all contacts of a rigid pusher move with one velocity; give each the same v_wp_s")]
    PushersDiffer,
    /// A pusher's path is not usable.
    #[error("point {index} of the pusher's path: {reason}")]
    BadPath {
        /// 0-based point, or the number of points if they are too few.
        index: usize,
        /// What is wrong.
        reason: &'static str,
    },
    /// A matrix that must be symmetric and positive definite is not.
    #[error("{name} must be finite, symmetric and positive definite, got columns {columns:?}")]
    NotPositiveDefinite {
        /// Which matrix.
        name: &'static str,
        /// The matrix, by columns.
        columns: [[f64; 3]; 3],
    },
    /// A point set that spans no volume of loads.
    #[error(
        "a point set needs two distinct points or more, got {distinct}: a single one bears no moment about itself"
    )]
    TooFewPoints {
        /// How many places there are.
        distinct: usize,
    },
    /// A traction field has a value that friction cannot have.
    #[error("the traction must be finite and not negative, got {value} N/m² at ({x}, {y}) m")]
    BadTraction {
        /// The value, in N/m².
        value: f64,
        /// Where, in m.
        x: f64,
        /// Where, in m.
        y: f64,
    },
    /// A quartic that is not convex.
    #[error(
        "the quartic is not convex: its Hessian at the unit load {direction:?} (fx, fy, M/ρ) has the \
         eigenvalue {eigenvalue}; fit with a convexity constraint or use an ellipsoid"
    )]
    NotConvex {
        /// The load's direction (fx, fy, M/ρ).
        direction: [f64; 3],
        /// The smallest eigenvalue of the Hessian there.
        eigenvalue: f64,
    },
    /// A quartic whose convexity could be neither certified nor refuted.
    #[error(
        "convexity undecided after {cells} cells: the quartic's smallest curvature is too near 0"
    )]
    ConvexityUndecided {
        /// Cells that were looked at.
        cells: usize,
    },
    /// Too few measurements for a fit.
    #[error("a fit of {what} needs {needed} wrench-twist pairs or more, got {got}")]
    TooFewPairs {
        /// What is being fitted.
        what: &'static str,
        /// The least number.
        needed: usize,
        /// What was given.
        got: usize,
    },
    /// Measurements that do not determine the surface.
    #[error("the wrench-twist pairs do not determine {what}: their directions are too alike")]
    Undetermined {
        /// What is being fitted.
        what: &'static str,
    },
}
