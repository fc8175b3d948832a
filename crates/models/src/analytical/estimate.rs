//! A parameter with its standard error and where it comes from.

use serde::{Deserialize, Serialize};

/// A parameter's value with its standard error, in the same unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// Its standard error; 0 for a value taken as exact.
    #[serde(default)]
    pub se: f64,
    /// Where it comes from, for people.
    #[serde(default)]
    pub source: String,
}

impl Estimate {
    /// A value without uncertainty.
    pub fn exact(value: f64, source: &str) -> Self {
        Self { value, se: 0.0, source: source.to_owned() }
    }
}
