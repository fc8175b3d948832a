//! What a Gaussian and a Gaussian bump make of each other.

use faer::Mat;

use crate::GaussianInput;
use crate::cholesky::{factorize, solve_with};

/// The input's covariance S beside the bumps' precision P = diag(p).
pub(super) struct Factors {
    /// ln |I + S P|.
    pub(super) log_determinant: f64,
    /// (S⁻¹ + P)⁻¹, D×D: the covariance of the product of both, singular where S is.
    pub(super) product: Mat<f64>,
}

impl Factors {
    /// W = P^½ S P^½, so that nothing is divided by S: the product is P^−½ (I + W)⁻¹ W P^−½.
    pub(super) fn new(input: &GaussianInput, precisions: &[f64]) -> Self {
        let (d, s) = (precisions.len(), input.covariance());
        let roots: Vec<f64> = precisions.iter().map(|precision| precision.sqrt()).collect();
        let w = Mat::from_fn(d, d, |i, j| roots[i] * s[(i, j)] * roots[j]);
        let mut factor = Mat::from_fn(d, d, |i, j| w[(i, j)] + f64::from(u8::from(i == j)));
        factorize("identity beside a covariance", factor.as_mut())
            .expect("the identity beside what `GaussianInput` has found positive is positive");
        let mut product = Mat::zeros(d, d);
        let mut solved = vec![0.0; d];
        for j in 0..d {
            (0..d).for_each(|i| solved[i] = w[(i, j)]);
            solve_with(factor.as_ref(), &mut solved);
            (0..d).for_each(|i| product[(i, j)] = solved[i] / (roots[i] * roots[j]));
        }
        Self { log_determinant: log_determinant_beside_identity(w), product }
    }
}

/// ln |I + W| by elimination, with the pivots less 1: all digits of it, however small W is.
fn log_determinant_beside_identity(mut w: Mat<f64>) -> f64 {
    let mut sum = 0.0;
    for k in 0..w.nrows() {
        let beyond_one = w[(k, k)];
        sum += beyond_one.ln_1p();
        for i in k + 1..w.nrows() {
            for j in k + 1..w.nrows() {
                w[(i, j)] -= w[(i, k)] * w[(k, j)] / (1.0 + beyond_one);
            }
        }
    }
    sum
}
