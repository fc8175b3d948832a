//! What a learnt mean leaves open.

use serde::{Deserialize, Serialize};

/// c + k(x, Z) w: by so much f(x) moves with one standard deviation of a learnt constant mean.
///
/// Its square is part of the variance at x: 0 where many data are near, and where there are none the
/// variance of the mean itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Deviation {
    /// c, the standard deviation of the mean, in the unit of the output.
    pub constant: f64,
    /// w, one a pseudo-input.
    pub weights: Vec<f64>,
}
