//! As few points as a covariance needs.

use nalgebra::DVector;

use super::Rule;

/// The corners of a regular simplex: d + 1 points of equal weight, right for polynomials of degree two.
///
/// Half the points of [`crate::Unscented`], for functions that take long; means of what bends are those of
/// the unscented transform, but skewness is not seen.
///
/// # Source
/// Julier (2003), The spherical simplex unscented transformation, Proc. American Control Conference,
/// without its point in the middle.
#[derive(Clone, Copy, Debug, Default)]
pub struct Simplex;

impl Rule for Simplex {
    fn points(&self, dimension: usize) -> Vec<(DVector<f64>, f64)> {
        let weight = 1.0 / (dimension + 1) as f64;
        // Along axis m the corner m + 1 is ahead, those before it are behind, the later ones in the middle.
        let place = |corner: usize, axis: usize| {
            let m = (axis + 1) as f64;
            let reach = 1.0 / (m * (m + 1.0) * weight).sqrt();
            match corner.cmp(&(axis + 1)) {
                std::cmp::Ordering::Less => -reach,
                std::cmp::Ordering::Equal => m * reach,
                std::cmp::Ordering::Greater => 0.0,
            }
        };
        let corner = |k: usize| DVector::from_fn(dimension, |axis, _| place(k, axis));
        (0..=dimension).map(|k| (corner(k), weight)).collect()
    }
}
