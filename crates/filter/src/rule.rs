//! Points and weights that stand for a Gaussian.

mod gauss_hermite;
mod simplex;
mod unscented;

use nalgebra::DVector;

pub use gauss_hermite::GaussHermite;
pub use simplex::Simplex;
pub use unscented::Unscented;

/// A rule that integrates functions of a standard normal vector.
pub trait Rule: Sync {
    /// Points with their weights, which are not negative and sum to 1.
    fn points(&self, dimension: usize) -> Vec<(DVector<f64>, f64)>;
}
