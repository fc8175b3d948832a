//! A random landscape over a plane.

use serde::{Deserialize, Serialize};

use crate::PlantError;
use crate::error::check_range;

/// Random hills and hollows of many sizes, over a table, an object's bottom or its side.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Texture {
    /// Standard deviation over the plane, in the unit of what varies; 0 for none.
    pub sd: f64,
    /// Wavelength of the largest hills, in m.
    pub longest: f64,
    /// Wavelength of the smallest, in m; each size in between is half of the one before.
    pub shortest: f64,
    /// Standard deviation of the hills of one size over that of those twice as large.
    pub persistence: f64,
}

impl Default for Texture {
    fn default() -> Self {
        Self { sd: 0.0, longest: 0.2, shortest: 0.005, persistence: 0.7 }
    }
}

impl Texture {
    /// Refuses numbers that no texture has.
    ///
    /// # Errors
    /// `OutOfRange` with the first of them, below `name`.
    pub(super) fn check(
        &self,
        name: &str,
        unit: &'static str,
        most: f64,
    ) -> Result<(), PlantError> {
        for (key, value, unit, low, high) in [
            ("sd", self.sd, unit, 0.0, most),
            ("longest", self.longest, "m", 1e-3, 10.0),
            ("shortest", self.shortest, "m", 1e-3, self.longest),
            ("persistence", self.persistence, "", 0.01, 2.0),
        ] {
            check_range(&format!("{name}.{key}"), value, unit, (low, high))?;
        }
        Ok(())
    }
}
