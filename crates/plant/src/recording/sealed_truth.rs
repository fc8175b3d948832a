//! The file that tells what is true of a set.

use serde::Serialize;

use crate::recording::simulate::Set;
use crate::{
    Design, GenerateSettings, HiddenEffect, Numerics, PlannedPush, PlantError, Scatter, Sensors,
    Truth, Variation,
};

/// Everything that the recordings of a set do not say.
#[derive(Serialize)]
pub(crate) struct SealedTruth<'a> {
    warning: &'static str,
    seed: u64,
    hidden: &'a [HiddenEffect],
    truth: &'a Truth,
    scatter: &'a Scatter,
    sensors: &'a Sensors,
    numerics: &'a Numerics,
    design: Option<&'a Design>,
    pushes: Vec<SealedPush>,
}

/// What is true of one push.
#[derive(Serialize)]
pub(crate) struct SealedPush {
    pub(crate) recording: String,
    pub(crate) plan: PlannedPush,
    /// Where the object really was at the start: x, y in m, turn in rad.
    pub(crate) place: [f64; 3],
    pub(crate) variation: Variation,
    /// Friction that the table's texture made under the object over that on an even table, mean over its way.
    pub(crate) table_friction: f64,
}

impl<'a> SealedTruth<'a> {
    pub(crate) fn new(
        settings: &'a GenerateSettings,
        set: &'a Set<'_>,
        pushes: Vec<SealedPush>,
    ) -> Self {
        Self {
            warning: "sealed: this file is for scoring alone, nothing that learns may read it",
            seed: settings.seed,
            hidden: &set.hidden,
            truth: set.truth(),
            scatter: &settings.scatter,
            sensors: &settings.sensors,
            numerics: &settings.numerics,
            // A list of pushes is in `pushes` already.
            design: (!matches!(set.design.layout, crate::Layout::List(_))).then_some(&set.design),
            pushes,
        }
    }

    /// As TOML, in SI units.
    pub(crate) fn to_text(&self) -> Result<String, PlantError> {
        toml::to_string(self).map_err(|error| PlantError::Design { what: error.to_string() })
    }
}
