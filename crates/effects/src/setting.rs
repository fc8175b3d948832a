//! An effect with its values, as files carry it.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::{About, EffectError};

/// The id of an effect and its named parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Setting {
    /// Id of the effect.
    pub id: String,
    /// Value of each parameter by its name, in its SI unit.
    pub parameters: BTreeMap<String, f64>,
}

impl Setting {
    /// The setting of an effect with one value for each of its parameters.
    pub fn new(about: &About, values: &[f64]) -> Self {
        let names = about.parameters.iter().map(|parameter| parameter.name.to_owned());
        let parameters = names.zip(values.iter().copied()).collect();
        Self { id: about.id.to_owned(), parameters }
    }

    /// The values in the order of the effect's parameters.
    ///
    /// # Errors
    /// `WrongParameter` for one that is missing or that the effect does not have.
    pub fn values(&self, about: &About) -> Result<Vec<f64>, EffectError> {
        let wrong = |name: &str| EffectError::WrongParameter {
            effect: self.id.clone(),
            name: name.to_owned(),
            parameters: about.names(),
        };
        let is_known = |name: &str| about.parameters.iter().any(|known| known.name == name);
        if let Some(unknown) = self.parameters.keys().find(|name| !is_known(name)) {
            return Err(wrong(unknown));
        }
        let value = |name| self.parameters.get(name).copied().ok_or_else(|| wrong(name));
        about.parameters.iter().map(|parameter| value(parameter.name)).collect()
    }
}
