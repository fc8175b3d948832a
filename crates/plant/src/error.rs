//! What can go wrong in the plant.

use std::path::PathBuf;

/// Why a simulation or a recording set could not be made.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlantError {
    /// A number that is out of its range.
    #[error("{name} = {value} {unit} is not allowed, expected {allowed}")]
    OutOfRange {
        /// Which number.
        name: String,
        /// What was given.
        value: f64,
        /// Its unit.
        unit: &'static str,
        /// What would be right.
        allowed: String,
    },
    /// A load that cannot be spread over the outline as asked.
    #[error(
        "no pressure under this outline has its center at ({}, {}) m from the uniform one's and \
         {ratio} times its mean distance; ask for less",
        shift[0],
        shift[1]
    )]
    Pressure {
        /// Shift of the center, in m.
        shift: [f64; 2],
        /// Ratio of the mean distances.
        ratio: f64,
    },
    /// Feet about a center of mass that is not under the outline.
    #[error(
        "no three feet about the center of mass ({}, {}) m balance the object, which has nothing there; hide \
         another effect",
        center_of_mass[0],
        center_of_mass[1]
    )]
    Feet {
        /// In m, body frame.
        center_of_mass: [f64; 2],
    },
    /// Wear that the outline has no room for.
    #[error("the outline cannot be worn like this: {what}")]
    Wear {
        /// What is wrong.
        what: String,
    },
    /// A tip that begins inside the object.
    #[error("the tip begins {depth} m inside the object; begin further away or at another place")]
    Blocked {
        /// How deep, in m.
        depth: f64,
    },
    /// A step that was made as short as allowed without success.
    #[error("no step of {step} s or more could be taken at {time} s: {why}")]
    NotConverged {
        /// Time in the push, in s.
        time: f64,
        /// The shortest step tried, in s.
        step: f64,
        /// What failed.
        why: &'static str,
    },
    /// A hidden effect that is not written as `id: name=value, …`, or is not known.
    #[error("hidden effect `{text}`: {what}")]
    Hidden {
        /// What was asked for.
        text: String,
        /// What is wrong and what is allowed.
        what: String,
    },
    /// A design that makes no pushes.
    #[error("{what}")]
    Design {
        /// What is wrong.
        what: String,
    },
    /// A list of pushes that could not be read.
    #[error("{}:{line}: {what}", path.display())]
    PushList {
        /// The file.
        path: PathBuf,
        /// The line, 1-based; 0 for the whole file.
        line: u64,
        /// What is wrong.
        what: String,
    },
    /// A way to write recordings that is not known.
    #[error("unknown format `{name}`, expected one of {allowed}")]
    UnknownFormat {
        /// What was asked for.
        name: String,
        /// What there is.
        allowed: String,
    },
    /// One push of a set failed.
    #[error("push {name}")]
    Push {
        /// Its name.
        name: String,
        /// Why.
        source: Box<PlantError>,
    },
    /// A recording that could not be written.
    #[error(transparent)]
    Dataset(#[from] dataset::DatasetError),
    /// A shape that is not possible or not known.
    #[error(transparent)]
    Shape(#[from] planar::PlanarError),
    /// A file or folder that could not be written.
    #[error(transparent)]
    Output(#[from] output::OutputError),
}

impl PlantError {
    /// Whether it is the motion of a push that could not be followed, and not what was asked for.
    pub(crate) fn is_of_the_motion(&self) -> bool {
        matches!(self, Self::NotConverged { .. })
    }
}

/// Refuses a number outside of its range.
pub(crate) fn check_range(
    name: &str,
    value: f64,
    unit: &'static str,
    (low, high): (f64, f64),
) -> Result<(), PlantError> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    let allowed = format!("a number from {low} to {high}");
    Err(PlantError::OutOfRange { name: name.to_owned(), value, unit, allowed })
}
