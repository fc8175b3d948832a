//! What can go wrong with effects and predictions.

use mechanics::MechanicsError;

/// Why a model could not be built or a step not predicted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EffectError {
    /// A number of the step, the object or the rig is not what it must be.
    #[error("{name} must be {expected}, got {value} {unit}")]
    InvalidValue {
        /// Which number.
        name: &'static str,
        /// What it must be.
        expected: &'static str,
        /// What was given.
        value: f64,
        /// Its unit.
        unit: &'static str,
    },
    /// An effect's parameter is outside its range.
    #[error("{effect}: {parameter} must be within {low} and {high} {unit}, got {value}")]
    OutOfRange {
        /// Id of the effect.
        effect: String,
        /// Name of the parameter.
        parameter: String,
        /// What was given.
        value: f64,
        /// The parameter's unit.
        unit: &'static str,
        /// Smallest allowed value.
        low: f64,
        /// Largest allowed value.
        high: f64,
    },
    /// A switch is neither off nor on.
    #[error("{effect}: {parameter} is a switch and must be 0 or 1, got {value}")]
    NotASwitch {
        /// Id of the effect.
        effect: String,
        /// Name of the parameter.
        parameter: String,
        /// What was given.
        value: f64,
    },
    /// As many values are needed as the effect has parameters.
    #[error("{effect} has the parameters {parameters}; got {got} values")]
    WrongCount {
        /// Id of the effect.
        effect: String,
        /// Names of its parameters.
        parameters: String,
        /// How many values were given.
        got: usize,
    },
    /// No effect has this id.
    #[error("there is no effect `{id}`; there are {known}")]
    UnknownEffect {
        /// What was asked for.
        id: String,
        /// All ids.
        known: String,
    },
    /// A parameter is not one of the effect's.
    #[error("{effect} has no parameter `{name}`; it has {parameters}")]
    UnknownParameter {
        /// Id of the effect.
        effect: String,
        /// What was given.
        name: String,
        /// Names of its parameters.
        parameters: String,
    },
    /// A parameter has no value.
    #[error("{effect} has no value of its parameter `{name}`; give one of each of {parameters}")]
    MissingParameter {
        /// Id of the effect.
        effect: String,
        /// The name.
        name: String,
        /// Names of its parameters.
        parameters: String,
    },
    /// A parameter differs by its value from push to push and by its logarithm from place to place, or the
    /// other way round.
    #[error(
        "`{parameter}` of {effect} differs from push to push and from place to place in two units; \
         give `sd` for both or `relative_sd` for both"
    )]
    TwoSpreads {
        /// Id of the effect.
        effect: String,
        /// Name of the parameter.
        parameter: String,
    },
    /// An effect was added twice.
    #[error("{effect} is already in the model; change its values instead of adding it again")]
    DuplicateEffect {
        /// Id of the effect.
        effect: String,
    },
    /// The corners of an outline cannot be rounded that much, or it cannot be that much smaller.
    #[error(
        "this outline cannot be moved inwards by {radius} m, for round corners or for a pusher thinner than a \
         point; its shortest edge is {shortest} m"
    )]
    TooRound {
        /// How far inwards was asked for: the radius of corners, and what a pusher is thinner than a point, in m.
        radius: f64,
        /// The shortest edge, in m.
        shortest: f64,
    },
    /// The weight of a rigid object cannot rest on some points.
    #[error(
        "the center of mass ({x}, {y}) m is not between the support points; give points about it, or \
         their shares of the weight"
    )]
    NotBetween {
        /// Of the center of mass, in m, frame of the outline.
        x: f64,
        /// The same.
        y: f64,
    },
    /// A solver ended before it reached its tolerance.
    #[error("{what} did not converge within {iterations} iterations")]
    NotConverged {
        /// What was being solved.
        what: &'static str,
        /// Steps taken.
        iterations: usize,
    },
    /// A prediction overflowed.
    #[error(
        "the predicted {channel} is {value}: numbers of the step, the object or the effects are too \
         large or too small to compute with"
    )]
    NotFinite {
        /// Name of the first such number.
        channel: &'static str,
        /// What came out.
        value: f64,
    },
    /// The mechanics refused something.
    #[error(transparent)]
    Mechanics(#[from] MechanicsError),
}

/// The value, if it is finite.
pub(crate) fn finite(
    name: &'static str,
    value: f64,
    unit: &'static str,
) -> Result<f64, EffectError> {
    if value.is_finite() {
        return Ok(value);
    }
    Err(EffectError::InvalidValue { name, expected: "finite", value, unit })
}

/// The value, if it is positive and finite.
pub(crate) fn positive(
    name: &'static str,
    value: f64,
    unit: &'static str,
) -> Result<f64, EffectError> {
    if value > 0.0 && value.is_finite() {
        return Ok(value);
    }
    Err(EffectError::InvalidValue { name, expected: "positive and finite", value, unit })
}

/// The value, if it is finite and not negative.
pub(crate) fn not_negative(
    name: &'static str,
    value: f64,
    unit: &'static str,
) -> Result<f64, EffectError> {
    if value >= 0.0 && value.is_finite() {
        return Ok(value);
    }
    Err(EffectError::InvalidValue { name, expected: "finite and not negative", value, unit })
}
