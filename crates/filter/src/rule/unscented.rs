//! Points along the axes.

use nalgebra::DVector;

use super::Rule;

/// The unscented transform: 2d + 1 points, right for polynomials of degree three.
///
/// κ = 3 − d up to three dimensions; beyond, κ = 0, which keeps the weights positive.
///
/// # Source
/// Julier & Uhlmann (1997), A new extension of the Kalman filter to nonlinear systems.
#[derive(Clone, Copy, Debug, Default)]
pub struct Unscented;

impl Rule for Unscented {
    fn points(&self, dimension: usize) -> Vec<(DVector<f64>, f64)> {
        let d = dimension as f64;
        let kappa = (3.0 - d).max(0.0);
        let (reach, weight) = ((d + kappa).sqrt(), 0.5 / (d + kappa));
        let middle = (DVector::zeros(dimension), kappa / (d + kappa));
        let along = |axis: usize| {
            [-reach, reach].map(|place| {
                let mut point = DVector::zeros(dimension);
                point[axis] = place;
                (point, weight)
            })
        };
        std::iter::once(middle).chain((0..dimension).flat_map(along)).collect()
    }
}
