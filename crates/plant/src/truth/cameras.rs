//! Where motion capture has its frame.

use serde::{Deserialize, Serialize};

/// The frame of motion capture against the robot's.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Cameras {
    /// Added to every place of the object that is told, along the robot's axes, in m.
    pub shift: [f64; 2],
}
