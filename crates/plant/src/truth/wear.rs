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
    /// Rough vertices.
    pub burr: Burr,
}

/// Vertices that new edges left rough, where the tip catches.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Burr {
    /// How many vertices have one, from the first on.
    pub n_vertices: usize,
    /// Friction of the tip there, beside that of the sides.
    pub friction: f64,
    /// Distance at which it has fallen to 37 %, in m.
    pub reach: f64,
}

impl Default for Burr {
    fn default() -> Self {
        Self { n_vertices: 0, friction: 0.0, reach: 0.005 }
    }
}
