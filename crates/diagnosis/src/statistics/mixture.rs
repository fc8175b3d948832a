//! Parts of a whole that explain numbers best.

use nalgebra::{DMatrix, DVector};

/// Ridge on the diagonal, in its mean: columns that are alike share.
const RIDGE: f64 = 1e-9;
/// How far a slope may be from its sign, in the largest element of the matrix.
const TOLERANCE: f64 = 1e-10;

/// The s ≥ 0 with Σ s = 1 and the least sᵀKs of a positive semidefinite K.
///
/// That of |As|² + (Σ s − 1)² over s ≥ 0, with K = AᵀA, is in proportion to it.
///
/// # Source
/// Lawson & Hanson (1974), Solving least squares problems, chapter 23.
pub(crate) fn best_mixture(gram: &DMatrix<f64>) -> DVector<f64> {
    let n = gram.nrows();
    let scale = (gram.trace() / n as f64).max(f64::MIN_POSITIVE);
    let whole = DMatrix::from_fn(n, n, |i, j| {
        gram[(i, j)] / scale + 1.0 + if i == j { RIDGE } else { 0.0 }
    });
    let enough = TOLERANCE * whole.amax();
    let (mut parts, mut free) = (DVector::zeros(n), Vec::<usize>::new());
    for _ in 0..3 * n {
        let slopes = DVector::repeat(n, 1.0) - &whole * &parts;
        let steepest = (0..n).filter(|k| !free.contains(k) && slopes[*k] > enough);
        let Some(next) = steepest.max_by(|a, b| slopes[*a].total_cmp(&slopes[*b])) else { break };
        free.push(next);
        while let Some(wanted) = solved(&whole, &free) {
            if wanted.iter().all(|part| *part > 0.0) {
                parts.fill(0.0);
                free.iter().zip(&wanted).for_each(|(k, part)| parts[*k] = *part);
                break;
            }
            // As far as the first part that would become negative.
            let reach = |(k, wanted): (&usize, &f64)| match *wanted > 0.0 {
                true => 1.0,
                false => parts[*k] / (parts[*k] - wanted),
            };
            let reach = free.iter().zip(&wanted).map(reach).fold(1.0, f64::min);
            for (k, wanted) in free.iter().zip(&wanted) {
                parts[*k] += reach * (wanted - parts[*k]);
            }
            let least = free.iter().map(|k| parts[*k]).fold(f64::INFINITY, f64::min);
            free.retain(|k| parts[*k] > least.max(0.0));
        }
    }
    let sum = parts.sum();
    if sum > 0.0 { parts / sum } else { DVector::repeat(n, 1.0 / n as f64) }
}

/// The minimum over some parts, whatever their sign; none where they are not told apart or are none.
fn solved(whole: &DMatrix<f64>, free: &[usize]) -> Option<Vec<f64>> {
    let block = whole.select_rows(free).select_columns(free);
    let factor = block.cholesky().filter(|_| !free.is_empty())?;
    Some(factor.solve(&DVector::repeat(free.len(), 1.0)).iter().copied().collect())
}

#[cfg(test)]
mod tests {
    use super::best_mixture;
    use nalgebra::{DMatrix, DVector};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    #[test]
    fn a_mixture_without_error_is_found() {
        let truth = DVector::from_vec(vec![0.0, 0.3, 0.0, 0.0, 0.5, 0.2, 0.0]);
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut rows = DMatrix::from_fn(40, 7, |_, _| rng.random_range(-1.0..1.0));
        for mut row in rows.row_iter_mut() {
            // Nothing is missing where the mixture is right.
            let missing = (&row * &truth)[0];
            row.add_scalar_mut(-missing);
        }
        let found = best_mixture(&rows.tr_mul(&rows));
        assert!((found - truth).amax() < 1e-6);
    }

    #[test]
    fn no_exchange_of_parts_is_better() {
        for seed in 0..20 {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let rows = DMatrix::from_fn(30, 12, |_, _| rng.random_range(-1.0..1.5));
            let gram = rows.tr_mul(&rows);
            let found = best_mixture(&gram);
            assert!(found.min() >= 0.0 && (found.sum() - 1.0).abs() < 1e-12);
            let slopes = 2.0 * &gram * &found;
            let level = slopes.dot(&found);
            for (slope, part) in slopes.iter().zip(&found) {
                // Stationary where there is some, rising where there is none.
                assert!(slope - level > -1e-6 * slopes.amax(), "{seed}");
                assert!(*part == 0.0 || (slope - level).abs() < 1e-6 * slopes.amax(), "{seed}");
            }
        }
    }

    #[test]
    fn columns_alike_and_none_that_count_still_give_parts() {
        let zero = best_mixture(&DMatrix::zeros(4, 4));
        assert!((zero.sum() - 1.0).abs() < 1e-12 && zero.min() >= 0.0);
        let alike = best_mixture(&DMatrix::repeat(5, 5, 2.0));
        assert!((alike.sum() - 1.0).abs() < 1e-12 && alike.min() >= 0.0);
    }
}
