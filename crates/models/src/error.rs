//! What can go wrong between a table, a model and its file.

use std::path::PathBuf;

/// Why a model could not be built, fitted, asked, read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// A quantity is NaN, infinite or of the wrong sign.
    #[error("{name} must be {expected}, got {value} {unit}")]
    InvalidValue {
        /// Which quantity.
        name: &'static str,
        /// What it must be.
        expected: &'static str,
        /// What was given.
        value: f64,
        /// Its unit.
        unit: &'static str,
    },
    /// A step starts on an edge that the outline does not have.
    #[error("edge {edge} does not exist: the outline has {n_edges}, counted from 0")]
    NoSuchEdge {
        /// The edge asked for.
        edge: usize,
        /// How many there are.
        n_edges: usize,
    },
    /// A row of a table is no step of a push.
    #[error("row {row} of the table ({recording})")]
    Row {
        /// Its number, from 0.
        row: usize,
        /// The recording that it is of.
        recording: String,
        /// Why.
        source: Box<ModelError>,
    },
    /// A row is about another shape than the object given.
    #[error("the row's shape is {found}, the object is {expected}; give the object of the table")]
    OtherShape {
        /// The row's.
        found: String,
        /// The object's.
        expected: String,
    },
    /// An object that nobody knows.
    #[error(transparent)]
    Object(#[from] planar::PlanarError),
    /// Fewer steps than a fit needs.
    #[error("{what} needs at least {needed} steps, got {actual}; record more pushes")]
    TooFewSteps {
        /// What was to be fitted.
        what: &'static str,
        /// The least number.
        needed: usize,
        /// What was given.
        actual: usize,
    },
    /// An output does not vary over the steps, so nothing can be fitted to it.
    #[error("all {n_steps} steps have the same {output}; a fit needs pushes that differ")]
    ConstantOutput {
        /// Which output.
        output: &'static str,
        /// Number of steps.
        n_steps: usize,
    },
    /// A characteristic length was given for a surface that has its own.
    #[error(
        "a given characteristic length is for an ellipsoid; on {surface} it follows from the pressure"
    )]
    LengthOfAnotherSurface {
        /// The limit surface.
        surface: &'static str,
    },
    /// The data do not determine a parameter.
    #[error("the steps do not determine {parameter}; fix it, or add pushes that slide and turn")]
    Undetermined {
        /// Which parameter.
        parameter: &'static str,
    },
    /// A fit ended before it reached its tolerance.
    #[error(
        "the fit of {what} did not converge in {iterations} iterations (gradient {gradient:e})"
    )]
    NotConverged {
        /// What was fitted.
        what: &'static str,
        /// Steps taken.
        iterations: usize,
        /// Cosine between residual and Jacobian at the end; 0 at a minimum.
        gradient: f64,
    },
    /// A file cannot be read.
    #[error(transparent)]
    Dataset(Box<dataset::DatasetError>),
    /// Something would be computed in more pieces than memory holds.
    #[error("{number:e} {name}, at most {most} are taken; shorten the path, or take larger steps")]
    TooMany {
        /// What the pieces are.
        name: &'static str,
        /// How many there would be.
        number: f64,
        /// How many there may be.
        most: usize,
    },
    /// A model file says something that cannot be.
    #[error("{}:{line}: {key}: {problem}", path.display())]
    Invalid {
        /// The file.
        path: PathBuf,
        /// 1-based line.
        line: usize,
        /// The key, with its tables.
        key: String,
        /// What is wrong, and what to do.
        problem: String,
    },
    /// A model with effects was asked for a motion without the set-up that effects act on.
    #[error(
        "the effects {effects} act on mass, place and time, which a bare step does not have; \
         predict all channels with the set's manifest"
    )]
    EffectsNeedMore {
        /// Their ids.
        effects: String,
    },
    /// Effects, forces or gaps were asked of a model without mechanics.
    #[error("a model of kind {kind} predicts the motion alone; use kind analytical")]
    MotionAlone {
        /// The kind.
        kind: &'static str,
    },
    /// A hybrid was to be made of a model without mechanics.
    #[error("a model of kind {kind} has no physics to learn beside; give one of kind analytical")]
    NoPhysics {
        /// The kind.
        kind: &'static str,
    },
    /// Support points without shares are to bear an object of which nothing is known.
    #[error(
        "shares of support points follow from the object's mass and place; name one object, or give shares"
    )]
    PointsOfNoObject,
    /// A learnt model lacks what it has learnt.
    #[error("the model has no weights; train it")]
    NoWeights,
    /// Weights that do not belong together.
    #[error("the weights' {what} do not belong to such a model; train it again")]
    UnsoundWeights {
        /// Which part.
        what: &'static str,
    },
    /// The physics of a hybrid are not those that its weights were learnt beside.
    #[error(
        "the weights were learnt beside physics with a fitted {parameter}, which the model does not \
         have; train it again"
    )]
    OtherPhysics {
        /// The parameter that is missing.
        parameter: String,
    },
    /// The speed is an input of a learnt model, and a step does not say how long it took.
    #[error("the model was trained with the speed as an input, which a bare step does not have")]
    NoSpeed,
    /// An input that was asked for is the same in all steps.
    #[error("all {n_steps} steps have the same {input}; train without it")]
    ConstantInput {
        /// Its name in `model.toml`.
        input: &'static str,
        /// Number of steps.
        n_steps: usize,
    },
    /// A learnt model was asked about an object that it has never seen.
    #[error(
        "the object's outline is none of the {n_known} that the model was trained on; train one on \
         pushes of this object, or use kind analytical"
    )]
    UnknownOutline {
        /// Outlines that the model knows.
        n_known: usize,
    },
    /// A point of a pusher's path is none.
    #[error("point {point} of the path {problem}")]
    Path {
        /// Its number, from 0.
        point: usize,
        /// What is wrong, and what to do.
        problem: String,
    },
    /// A path begins within the object.
    #[error(
        "the pusher starts {:.2} mm inside the object; start the path outside, or move the object's \
         start pose", 1e3 * depth
    )]
    PusherInside {
        /// How deep its surface is, in m.
        depth: f64,
    },
    /// A step of a roll-out is longer than those that a model has learnt.
    #[error(
        "a step of {:.2} mm is longer than the longest of {:.2} mm that the model was trained on; \
         take shorter steps", 1e3 * way, 1e3 * longest
    )]
    StepTooLong {
        /// The step's way, in m.
        way: f64,
        /// The longest way of a training step, in m.
        longest: f64,
    },
    /// Too few pushes to tell what the steps of one have in common.
    #[error(
        "the correlation of steps needs at least {needed} pushes of three steps or more, got \
         {n_pushes}; record more pushes, or take shorter steps"
    )]
    TooFewPushes {
        /// What was given.
        n_pushes: usize,
        /// The least number.
        needed: usize,
    },
    /// A model that claims no variance was asked how far off it is.
    #[error(
        "the model of kind {kind} claims no scatter of steps in some output; how errors go together is \
         measured of a fitted scatter or a learnt kind"
    )]
    NoVariance {
        /// The kind.
        kind: &'static str,
    },
    /// Particles could not be moved.
    #[error("roll-out")]
    Filter(#[from] filter::FilterError),
    /// A weights file is not what the model file describes.
    #[error("{}: {problem}", path.display())]
    Weights {
        /// The file.
        path: PathBuf,
        /// What is wrong, and what to do.
        problem: String,
    },
    /// A file could not be written.
    #[error(transparent)]
    Output(#[from] output::OutputError),
    /// A file could not be read or removed.
    #[error("cannot {action} {}", path.display())]
    Io {
        /// `read` or `remove`.
        action: &'static str,
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The mechanics refused a step.
    #[error(transparent)]
    Mechanics(#[from] mechanics::MechanicsError),
    /// An effect or a prediction with effects was refused.
    #[error(transparent)]
    Effects(#[from] effects::EffectError),
    /// A kind of model that no file holds.
    #[error("a {kind} model cannot be saved; keep the steps that it was trained on")]
    NotSaved {
        /// Its kind.
        kind: &'static str,
    },
    /// A table for a model that knows more of a step than its place and angle.
    #[error(
        "a table is of p and beta_rad alone, and this model's inputs are {inputs}; ask it itself"
    )]
    NoTable {
        /// The model's inputs.
        inputs: String,
    },
    /// Processes that vary too fast for a table.
    #[error(
        "the finest table is off by {mean_error:.1e} standard deviations in the mean and by \
         {variance_error:.1e} in the variance; ask the model itself"
    )]
    TableTooCoarse {
        /// Over the standard deviation of an observation.
        mean_error: f64,
        /// Over the variance of an observation.
        variance_error: f64,
    },
    /// Moments at uncertain steps that are not known in closed form.
    #[error(
        "what {of} says of an uncertain step is not known in closed form; take the points of a rule, or \
         train kind gp, spgp or rff on p and beta_rad"
    )]
    NoClosedForm {
        /// The model.
        of: String,
    },
    /// A Gaussian process could not be learnt or asked.
    #[error("Gaussian process of {output}")]
    Gp {
        /// Which output.
        output: &'static str,
        /// Why.
        source: gp_core::GpError,
    },
}

impl From<dataset::DatasetError> for ModelError {
    fn from(error: dataset::DatasetError) -> Self {
        Self::Dataset(Box::new(error))
    }
}

/// Refuses a value that is not positive and finite.
pub(crate) fn positive(
    name: &'static str,
    value: f64,
    unit: &'static str,
) -> Result<f64, ModelError> {
    if value > 0.0 && value.is_finite() {
        Ok(value)
    } else {
        Err(ModelError::InvalidValue { name, expected: "positive and finite", value, unit })
    }
}

/// Refuses a value outside of a range, which `expected` states.
pub(crate) fn within(
    name: &'static str,
    value: f64,
    (low, high): (f64, f64),
    expected: &'static str,
    unit: &'static str,
) -> Result<f64, ModelError> {
    if (low..=high).contains(&value) {
        Ok(value)
    } else {
        Err(ModelError::InvalidValue { name, expected, value, unit })
    }
}

/// Refuses a value that is not finite.
pub(crate) fn finite(
    name: &'static str,
    value: f64,
    unit: &'static str,
) -> Result<f64, ModelError> {
    match value.is_finite() {
        true => Ok(value),
        false => Err(ModelError::InvalidValue { name, expected: "finite", value, unit }),
    }
}

/// Refuses a value that is negative or not finite.
pub(crate) fn not_negative(
    name: &'static str,
    value: f64,
    unit: &'static str,
) -> Result<f64, ModelError> {
    if value >= 0.0 && value.is_finite() {
        Ok(value)
    } else {
        Err(ModelError::InvalidValue { name, expected: "finite and not negative", value, unit })
    }
}
