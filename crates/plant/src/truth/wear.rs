//! The outline's corners.

use serde::{Deserialize, Serialize};

/// How the true outline differs from the nominal one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Wear {
    /// Radius of every convex corner of a new object, in m; less where a side has no room for it.
    pub edge_break: f64,
    /// Radius of every convex corner, in m.
    pub corner_radius: f64,
    /// Which vertex is chipped, 0-based.
    pub chip_vertex: usize,
    /// Length that the chip takes from both of its sides, in m; 0 for none.
    pub chip_size: f64,
}
