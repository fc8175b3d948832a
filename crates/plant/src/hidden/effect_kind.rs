//! One effect that can be hidden in a truth.

use super::Quantity;
use crate::{Design, PlantError, Truth};

/// An effect, its parameters, and what it changes.
#[derive(Debug)]
pub struct EffectKind {
    /// Its name.
    pub id: &'static str,
    /// What it is, in one line.
    pub about: &'static str,
    /// Whether the catalogue of missing effects has it.
    pub in_catalogue: bool,
    /// Its parameters, in the order in which they are applied.
    pub parameters: &'static [Parameter],
    /// Puts it into a truth, or into the design where it is a matter of the pushes.
    pub(crate) apply: fn(&mut Truth, &mut Design, &[f64]) -> Result<(), PlantError>,
}

/// A number of an effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Its name, without the unit's ending.
    pub name: &'static str,
    /// What kind of number it is.
    pub quantity: Quantity,
    /// Value at which the effect vanishes, in SI units; none where no value does so alone.
    pub off: Option<f64>,
    /// Value if none is given, and typical size, in SI units.
    pub typical: f64,
    /// Least and largest value, in SI units.
    pub range: (f64, f64),
}

impl Parameter {
    pub(crate) const fn new(
        name: &'static str,
        quantity: Quantity,
        off: f64,
        typical: f64,
        range: (f64, f64),
    ) -> Self {
        Self { name, quantity, off: Some(off), typical, range }
    }

    /// A parameter that says where or how, but not how much.
    pub(crate) const fn free(
        name: &'static str,
        quantity: Quantity,
        typical: f64,
        range: (f64, f64),
    ) -> Self {
        Self { name, quantity, off: None, typical, range }
    }

    /// The names by which it may be given, each with its unit's ending; the first is in SI units.
    #[must_use]
    pub fn keys(&self) -> Vec<String> {
        let suffixes = self.quantity.suffixes().iter();
        suffixes.map(|(suffix, _)| format!("{}{suffix}", self.name)).collect()
    }
}
