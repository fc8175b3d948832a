//! What a learnt mean leaves open.

use serde::{Deserialize, Serialize};

/// c + Σ g_k h_k(x) + k(x, Z) w: by so much f(x) moves with one standard deviation of a learnt mean.
///
/// Its square is part of the variance at x: 0 where many data are near, and where there are none the
/// variance of the mean itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Deviation {
    /// c, in the unit of the output: of a constant mean its standard deviation.
    pub constant: f64,
    /// g, one a product of inputs (see [`gp_core::Monomials`]); none of a constant mean.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub coefficients: Vec<f64>,
    /// w, one a pseudo-input.
    pub weights: Vec<f64>,
}
