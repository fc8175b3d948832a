//! By how much what the pseudo-inputs know reduces the variance of the prior.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::matmul::matmul;
use faer::linalg::qr::no_pivoting::factor::{
    qr_in_place, qr_in_place_scratch, recommended_block_size,
};
use faer::linalg::svd::{ComputeSvdVectors, svd, svd_scratch};
use faer::{Accum, Mat, MatRef, Par, diag::Diag};
use gp_core::GpError;

use crate::row_sums::PRECISION;

/// T, with zeros above its diagonal, of which TᵀT = K_uu⁻¹ − Σ = L⁻ᵀ (I − R⁻ᵀR⁻¹) L⁻¹: then k** − |T k*|²
/// is the variance of f, in half the operations of its two parts. O(M³).
///
/// With R⁻¹ = U diag(τ) Vᵀ the middle is V (1 − τ²) Vᵀ, and τ ≤ 1 is known to rounding, so T is too.
///
/// - `factor_inverse`, `root_inverse`: L⁻¹ and R⁻¹, with zeros above their diagonals.
///
/// # Errors
/// `NotPositiveDefinite` if R⁻¹ is so far from finite that it has no singular values.
pub(crate) fn reduction(
    factor_inverse: MatRef<'_, f64>,
    root_inverse: MatRef<'_, f64>,
) -> Result<Mat<f64>, GpError> {
    let m = root_inverse.nrows();
    let (taus, v) = right_vectors(root_inverse)?;
    let mut whole = Mat::zeros(m, m);
    matmul(whole.as_mut(), Accum::Replace, v.transpose(), factor_inverse, 1.0, Par::Seq);
    // From the last column to the first, since what is triangular by reflections has zeros below.
    let share = |i: usize| (1.0 - taus[i] * taus[i]).max(0.0).sqrt();
    let reversed = Mat::from_fn(m, m, |i, j| share(i) * whole[(i, m - 1 - j)]);
    let upper = upper_triangle(reversed);
    Ok(Mat::from_fn(m, m, |i, j| if j > i { 0.0 } else { upper[(m - 1 - i, m - 1 - j)] }))
}

/// Singular values and right singular vectors.
fn right_vectors(matrix: MatRef<'_, f64>) -> Result<(Vec<f64>, Mat<f64>), GpError> {
    let m = matrix.nrows();
    let (no, full) = (ComputeSvdVectors::No, ComputeSvdVectors::Full);
    let (mut values, mut v) = (Diag::zeros(m), Mat::zeros(m, m));
    let scratch = svd_scratch::<f64>(m, m, no, full, Par::Seq, Default::default());
    let mut memory = MemBuffer::new(scratch);
    let stack = MemStack::new(&mut memory);
    let (into_values, into_v) = (values.as_mut(), Some(v.as_mut()));
    svd(matrix, into_values, None, into_v, Par::Seq, stack, Default::default())
        .map_err(|_| GpError::NotPositiveDefinite { what: PRECISION, size: m, pivot: 0 })?;
    Ok((values.column_vector().iter().copied().collect(), v))
}

/// The triangle that reflections leave of a matrix; below its diagonal stands what made them.
fn upper_triangle(mut matrix: Mat<f64>) -> Mat<f64> {
    let m = matrix.nrows();
    let block = recommended_block_size::<f64>(m, m);
    let mut coefficients = Mat::zeros(block, m);
    let scratch = qr_in_place_scratch::<f64>(m, m, block, Par::Seq, Default::default());
    let mut memory = MemBuffer::new(scratch);
    let stack = MemStack::new(&mut memory);
    qr_in_place(matrix.as_mut(), coefficients.as_mut(), Par::Seq, stack, Default::default());
    matrix
}

#[cfg(test)]
mod tests {
    use faer::Mat;
    use gp_core::triangle::inverse;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::reduction;

    /// A lower triangle.
    fn triangle(m: usize, seed: u64, diagonal: impl Fn(usize) -> f64) -> Mat<f64> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut entry = |i: usize, j: usize| match i.cmp(&j) {
            std::cmp::Ordering::Less => 0.0,
            std::cmp::Ordering::Equal => diagonal(i),
            std::cmp::Ordering::Greater => 0.3 * (random.random::<f64>() - 0.5),
        };
        let mut matrix = Mat::zeros(m, m);
        for j in 0..m {
            (0..m).for_each(|i| matrix[(i, j)] = entry(i, j));
        }
        matrix
    }

    #[test]
    fn its_square_is_the_prior_precision_less_the_posterior_covariance() {
        for m in [1, 2, 7, 80] {
            let factor = triangle(m, 3, |i| 1.0 / (1.0 + i as f64 / 8.0));
            let whitened = triangle(m, 5, |i| 0.1 + i as f64);
            // R Rᵀ = I + W Wᵀ.
            let b = &whitened * whitened.transpose() + Mat::<f64>::identity(m, m);
            let root = b.llt(faer::Side::Lower).unwrap().L().to_owned();
            let (l, r) = (inverse(factor.as_ref()), inverse(root.as_ref()));
            let t = reduction(l.as_ref(), r.as_ref()).unwrap();
            let middle = Mat::<f64>::identity(m, m) - r.transpose() * &r;
            let expected = l.transpose() * middle * &l;
            let scale = (l.transpose() * &l).norm_max();
            assert!((t.transpose() * &t - &expected).norm_max() < 1e-13 * scale, "{m}");
            assert!((0..m).all(|j| (0..j).all(|i| t[(i, j)] == 0.0)));
        }
    }

    #[test]
    fn where_data_say_nothing_nothing_is_reduced() {
        let identity = Mat::<f64>::identity(5, 5);
        let t = reduction(identity.as_ref(), identity.as_ref()).unwrap();
        assert!(t.norm_max() < 1e-7, "{t:?}");
    }
}
