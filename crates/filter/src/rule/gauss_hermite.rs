//! A grid of Gauss–Hermite points.

use nalgebra::{DMatrix, DVector};

use super::Rule;

/// The product of Gauss–Hermite rules: mᵈ points, right for polynomials of degree 2m − 1 along each
/// axis.
///
/// # Source
/// Golub & Welsch (1969), Calculation of Gauss quadrature rules, Mathematics of Computation 23.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GaussHermite {
    /// Points along each axis; 0 counts as 1.
    pub order: usize,
}

impl Rule for GaussHermite {
    fn points(&self, dimension: usize) -> Vec<(DVector<f64>, f64)> {
        let line = self.line();
        let n = line.len();
        let point = |index: usize| {
            let digits = (0..dimension).map(|axis| index / n.pow(axis as u32) % n);
            let places: Vec<f64> = digits.clone().map(|digit| line[digit].0).collect();
            let weight = digits.map(|digit| line[digit].1).product();
            (DVector::from_vec(places), weight)
        };
        (0..n.pow(dimension as u32)).map(point).collect()
    }
}

impl GaussHermite {
    /// Points and weights of one axis: eigenvalues of the Jacobi matrix of Hermite's polynomials.
    fn line(&self) -> Vec<(f64, f64)> {
        let n = self.order.max(1);
        let jacobi =
            DMatrix::from_fn(
                n,
                n,
                |i, j| {
                    if i.abs_diff(j) == 1 { (i.max(j) as f64).sqrt() } else { 0.0 }
                },
            );
        let eigen = jacobi.symmetric_eigen();
        let mut line: Vec<(f64, f64)> =
            (0..n).map(|k| (eigen.eigenvalues[k], eigen.eigenvectors[(0, k)].powi(2))).collect();
        line.sort_by(|a, b| a.0.total_cmp(&b.0));
        line
    }
}
