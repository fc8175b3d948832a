//! Clocks of the streams.

use serde::{Deserialize, Serialize};

/// How far the streams' stamps are from the robot's clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Clocks {
    /// Lag of the object stream's stamps, in s: an event at time t is stamped t + latency.
    pub object_latency: f64,
    /// Lag of the force stream's stamps, in s.
    pub force_latency: f64,
}
