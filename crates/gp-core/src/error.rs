//! Everything that can go wrong in this crate, each with the value and the remedy.

/// Why a Gaussian process could not be built, learnt, asked or scored.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GpError {
    /// Two arguments disagree about a number of rows, columns or parameters.
    #[error("{what}: expected {expected}, got {actual}")]
    ShapeMismatch {
        /// What was counted.
        what: &'static str,
        /// The count that the other arguments ask for.
        expected: usize,
        /// The count that was given.
        actual: usize,
    },
    /// A matrix or slice has no rows or no columns.
    #[error("{what}: empty, give at least one row and one column")]
    Empty {
        /// The empty argument.
        what: &'static str,
    },
    /// A NaN or an infinity in the data.
    #[error("{what}: row {row}, column {column} is {value}; remove the row or repair the value")]
    NotFinite {
        /// The argument.
        what: &'static str,
        /// Row, from zero.
        row: usize,
        /// Column, from zero.
        column: usize,
        /// The offending value.
        value: f64,
    },
    /// A parameter that must be positive and finite is not.
    #[error("{name} must be positive and finite, got {value}")]
    NotPositive {
        /// The parameter.
        name: String,
        /// Its value.
        value: f64,
    },
    /// A parameter that must not be negative is negative or not finite.
    #[error("{name} must be finite and not negative, got {value}")]
    Negative {
        /// The parameter.
        name: String,
        /// Its value.
        value: f64,
    },
    /// A number outside the range in which it means something.
    #[error("{name} must lie between {lowest} and {highest}, got {value}")]
    OutOfRange {
        /// The number.
        name: String,
        /// Its value.
        value: f64,
        /// The least that is allowed.
        lowest: f64,
        /// The most that is allowed.
        highest: f64,
    },
    /// A name that no hyperparameter has.
    #[error("no hyperparameter is called {name}; there are: {known}")]
    UnknownParameter {
        /// The name.
        name: String,
        /// All names, with commas between them.
        known: String,
    },
    /// A process was to be conditioned without a noise variance.
    #[error("no noise variance is given; give `noise_variance`, or learn it with `fit`")]
    NoNoiseVariance,
    /// Hyperparameters cannot be learnt from so few rows.
    #[error(
        "learning needs at least {needed} rows, got {actual}; use `condition` with known values"
    )]
    TooFewRows {
        /// The least number of rows.
        needed: usize,
        /// The number given.
        actual: usize,
    },
    /// All outputs are equal, so no hyperparameter can be learnt from them.
    #[error("all {n_rows} outputs equal {value}; there is nothing to learn")]
    ConstantOutputs {
        /// The common value.
        value: f64,
        /// How many there are.
        n_rows: usize,
    },
    /// Two equal input rows without noise make the covariance singular.
    #[error(
        "rows {first} and {second} have equal inputs and the noise variance is 0; \
         drop one of them or give a positive noise variance"
    )]
    DuplicateRows {
        /// The earlier row, from zero.
        first: usize,
        /// The later row, from zero.
        second: usize,
    },
    /// The covariance is not positive definite to working precision.
    #[error(
        "the {what} of size {size} is not positive definite at pivot {pivot}; raise the noise \
         variance, shorten the lengthscales, or drop rows that nearly repeat others"
    )]
    NotPositiveDefinite {
        /// Which matrix.
        what: &'static str,
        /// Rows of the matrix.
        size: usize,
        /// The row at which the factorisation broke down, from zero.
        pivot: usize,
    },
    /// No start of the optimiser converged.
    #[error(
        "none of {n_starts} starts converged; the best stopped after {iterations} iterations with \
         gradient norm {gradient_norm:e}; allow more iterations, more starts or a larger tolerance"
    )]
    NotConverged {
        /// Number of starts tried.
        n_starts: usize,
        /// Iterations of the start with the smallest gradient.
        iterations: usize,
        /// Its gradient norm, in nats per log-parameter.
        gradient_norm: f64,
    },
    /// Inputs that do not tell the slopes of a linear mean.
    #[error(
        "the {n_rows} rows do not tell the mean's slope along input {input} (from 0) from the \
         constant and the slopes before it; give rows that differ in it otherwise, leave the input \
         out, or take a constant mean"
    )]
    UndeterminedSlope {
        /// The input, from zero.
        input: usize,
        /// Number of rows.
        n_rows: usize,
    },
    /// A row without which the others do not tell the mean.
    #[error(
        "without row {row} (from 0) the others do not tell the learnt mean, so they do not predict it; \
         give more rows, or a known mean"
    )]
    UndeterminedWithout {
        /// The row, from zero.
        row: usize,
    },
    /// A linear mean of a process that learns constants only.
    #[error(
        "this process learns a constant mean only; add a `Linear` kernel, or learn the slopes first \
         and give them as a mean function"
    )]
    LinearMean,
    /// Moments at an uncertain input were asked of a process with a polynomial mean.
    #[error(
        "moments at an uncertain input are known for constant and linear means alone; take the points \
         of a rule, or a linear mean"
    )]
    PolynomialMean,
    /// A coverage level outside (0, 1).
    #[error("a coverage level must lie strictly between 0 and 1, got {level}")]
    InvalidLevel {
        /// The level.
        level: f64,
    },
    /// A saved model of a format version that this release does not read.
    #[error("saved model has format version {found}, this release reads version {supported}")]
    UnsupportedVersion {
        /// Version in the model.
        found: u32,
        /// Version that can be read.
        supported: u32,
    },
    /// A saved model without what its learnt mean leaves open.
    #[error(
        "the model was saved (format version {found}) without the uncertainty of its learnt mean, and \
         its data are not with it; learn it again"
    )]
    NoMeanUncertainty {
        /// Version in the model.
        found: u32,
    },
    /// A saved sparse model without the sums over its rows.
    #[error(
        "the model was saved without sums over its rows, so rows cannot be added to it or removed; \
         condition it again on its data"
    )]
    NoRowSums,
    /// A matrix that is no covariance.
    #[error("the {what} is not symmetric, or negative along some direction")]
    NotACovariance {
        /// Which matrix.
        what: &'static str,
    },
    /// Moments at an uncertain input were asked of a kernel for which none are known.
    #[error(
        "moments at an uncertain input are known for the squared exponential of all inputs alone; \
         take the points of a rule for {kernel}"
    )]
    NoClosedForm {
        /// The kernel's debug form.
        kernel: String,
    },
    /// Two things that were not made for each other.
    #[error("{what} differ, so the two do not go together; make both from the same settings")]
    Incompatible {
        /// What differs.
        what: &'static str,
    },
    /// A part of a data set beyond its last.
    #[error("there is no part {part}: the {of} parts count from 0")]
    NoSuchPart {
        /// The part, from 0.
        part: u64,
        /// How many there are.
        of: u64,
    },
    /// A part of a data set that was taken in before.
    #[error("part {part} of {of}, from 0, is there already: leave it out")]
    PartTwice {
        /// The part, from 0.
        part: u64,
        /// How many there are.
        of: u64,
    },
    /// A part of a data set that was never taken in.
    #[error("part {part} of {of}, from 0, is missing: add it too")]
    PartMissing {
        /// The first that is missing, from 0.
        part: u64,
        /// How many there are.
        of: u64,
    },
    /// A user's kernel without a serialisable description.
    #[error("the kernel has no `KernelSpec`, so the model cannot be saved: {kernel}")]
    NotSerializable {
        /// The kernel's debug form.
        kernel: String,
    },
}
