//! Where the tracked frame is in the object.

use serde::{Deserialize, Serialize};

/// The tracked frame against the frame of the nominal outline.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Markers {
    /// Origin of the tracked frame in the outline's frame, in m.
    pub shift: [f64; 2],
    /// Turn of the tracked frame against the outline's, in rad.
    pub yaw: f64,
}
