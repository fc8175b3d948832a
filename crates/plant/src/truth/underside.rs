//! The object's bottom, as it meets the table.

use serde::{Deserialize, Serialize};

use super::Texture;

/// A rigid bottom that is not quite flat, on a table that gives way a little.
///
/// Where it stands, the object sinks and tilts until the table bears it; how its weight is spread
/// follows from the heights of table and bottom there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Underside {
    /// Stiffness of the table under the whole bottom, in N/m; 0 for a load that is spread as
    /// `pressure` says wherever the object stands.
    pub stiffness: f64,
    /// How much lower the rim is than the center, in m, at the object's radius.
    pub hollow: f64,
    /// How much lower two opposite corners are than the other two, in m, at the object's radius.
    pub twist: f64,
    /// Height of its bumps, in m.
    pub texture: Texture,
}
