//! Object, pusher and table as an input states them.

use std::path::Path;

use anyhow::Result;
use dataset::{Manifest, ObjectChoice, ObjectSupport, PusherSpec, SupportSpec, TableMapping};
use effects::readable_unit;
use models::{Description, Estimate, MadeFor, ModelFile, RigDifference};

use crate::tool::people::four_digits;
use crate::tool::terminal::Terminal;

/// What a manifest or a mapping says of the rig.
pub(crate) struct Rig {
    /// Of the set or the table.
    pub(crate) name: String,
    pub(crate) object: ObjectChoice,
    pub(crate) object_support: ObjectSupport,
    pub(crate) pusher: PusherSpec,
    pub(crate) support: SupportSpec,
}

impl From<&Manifest> for Rig {
    fn from(manifest: &Manifest) -> Self {
        let Manifest { name, object, object_support, pusher, support, .. } = manifest.clone();
        Self { name, object, object_support, pusher, support }
    }
}

impl From<&TableMapping> for Rig {
    fn from(mapping: &TableMapping) -> Self {
        let TableMapping { name, object, object_support, pusher, support, .. } = mapping.clone();
        let object = ObjectChoice::Fixed(Box::new(object));
        Self { name, object, object_support, pusher, support }
    }
}

impl Rig {
    /// The analytical model with its nominal values, which come from `source`.
    ///
    /// # Errors
    /// If no model can have them.
    pub(crate) fn nominal(&self, source: &str) -> Result<Description> {
        let friction = Estimate::exact(self.pusher.friction, source);
        Ok(Description::nominal(friction, &self.object, &self.object_support, source)?)
    }

    /// What a model that is made for it carries.
    pub(crate) fn made_for(&self) -> MadeFor {
        MadeFor::new(&self.name, &self.object, self.pusher, self.support)
    }

    /// Warns of a model that was made for another object, pusher or table, with what differs.
    pub(crate) fn warn_of_other(&self, path: &Path, file: &ModelFile, terminal: &Terminal) {
        let Some(made_for) = &file.made_for else { return };
        let found: Vec<_> = made_for.differences(&self.made_for()).iter().map(told).collect();
        if !found.is_empty() {
            terminal.warn(format_args!(
                "{} was made for another rig, {:?}, than {:?}: {}; what was fitted there may not hold here",
                path.display(),
                made_for.set,
                self.name,
                found.join("; ")
            ));
        }
    }
}

/// A difference in the words and units of people.
fn told(found: &RigDifference) -> String {
    let RigDifference { what, unit, values } = found;
    let (per, unit) = readable_unit(unit);
    let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
    let [there, here] = [0, 1].map(|side| {
        let numbers: Vec<_> = values[side].iter().map(|value| four_digits(per * value)).collect();
        numbers.join(" × ")
    });
    format!("{what} {there}{unit} there, {here}{unit} here")
}
