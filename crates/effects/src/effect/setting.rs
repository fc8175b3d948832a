//! An effect with its values, as files carry it.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::{EffectError, EffectInfo, Spread};

/// The id of an effect and its named parameters.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Setting {
    /// Id of the effect.
    pub id: String,
    /// Value of each parameter by its name, in its SI unit.
    pub parameters: BTreeMap<String, f64>,
    /// Of those that differ from push to push.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub per_push: BTreeMap<String, Spread>,
    /// Of those that differ from place to place of the table, faster than a step is long.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub per_place: BTreeMap<String, Spread>,
}

impl Setting {
    /// The setting of an effect with one value for each of its parameters.
    pub fn new(about: &EffectInfo, values: &[f64]) -> Self {
        let names = about.parameters.iter().map(|parameter| parameter.name.to_owned());
        let parameters = names.zip(values.iter().copied()).collect();
        Self { id: about.id.to_owned(), parameters, ..Self::default() }
    }

    /// The values in the order of the effect's parameters; 0 for points, cells and waves that are
    /// left out.
    ///
    /// # Errors
    /// `UnknownParameter` for one that the effect does not have, `MissingParameter` for one without value.
    pub fn values(&self, about: &EffectInfo) -> Result<Vec<f64>, EffectError> {
        let (effect, parameters) = (&self.id, about.names());
        let is_known = |name: &str| about.parameters.iter().any(|known| known.name == name);
        if let Some(name) = self.parameters.keys().find(|name| !is_known(name)) {
            let (effect, name) = (effect.clone(), name.clone());
            return Err(EffectError::UnknownParameter { effect, name, parameters });
        }
        if let Some(missing) = about.missing(|name| self.parameters.contains_key(name)) {
            let (effect, name) = (effect.clone(), missing.name.to_owned());
            return Err(EffectError::MissingParameter { effect, name, parameters });
        }
        let value = |name: &str| self.parameters.get(name).copied().unwrap_or_default();
        Ok(about.parameters.iter().map(|parameter| value(parameter.name)).collect())
    }

    /// Refuses a parameter of which only the logarithm differs one way, and the value the other.
    ///
    /// # Errors
    /// `TwoSpreads`.
    pub fn check_spreads(&self) -> Result<(), EffectError> {
        let is_other = |(name, one): &(&String, &Spread)| {
            self.per_place.get(*name).is_some_and(|other| !one.is_like(*other))
        };
        match self.per_push.iter().find(is_other) {
            None => Ok(()),
            Some((parameter, _)) => {
                let (effect, parameter) = (self.id.clone(), parameter.clone());
                Err(EffectError::TwoSpreads { effect, parameter })
            }
        }
    }
}
