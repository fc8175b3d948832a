//! Lower triangular matrices in blocks over the matrix product: factor, solve, invert, square.
//!
//! All work on column-major matrices in place. The arithmetic is cut into products whose number and
//! order follow from the sizes alone; large ones run in parallel, so that the bits do not depend on
//! the number of threads.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatMut, MatRef, Par};
use rayon::prelude::{IndexedParallelIterator, ParallelIterator};

use crate::kernel::column_mut;
use crate::tile::{TILE, factorize_tile, invert_tile, solve_tile};
use crate::vector::{add_multiple, dot};

/// Overwrites the lower triangle of a symmetric matrix by its Cholesky factor; n³/3 operations.
///
/// What stands above the diagonal has no meaning afterwards.
///
/// # Errors
/// The first pivot that is not positive.
pub fn factorize(mut matrix: MatMut<'_, f64>) -> Result<(), usize> {
    let n = matrix.nrows();
    if n <= TILE {
        return factorize_tile(matrix);
    }
    let width = panel_width(n);
    // A product reads its second factor many times: the columns of that one are to be close together.
    let mut coefficients = Mat::zeros(n, width);
    for start in (0..n).step_by(width) {
        let end = n.min(start + width);
        let rows = matrix.as_mut().get_mut(start.., ..end);
        let (known, mut panel) = rows.split_at_col_mut(start);
        let (known, width) = (known.as_ref(), end - start);
        let mut coefficients = coefficients.as_mut().get_mut(..start, ..width);
        coefficients.copy_from(known.subrows(0, width).transpose());
        increase(panel.as_mut(), known, coefficients.as_ref(), -1.0);
        let (mut pivots, below) = panel.split_at_row_mut(width);
        factorize(pivots.as_mut()).map_err(|pivot| start + pivot)?;
        solve_rows(pivots.as_ref(), below);
    }
    Ok(())
}

/// Replaces X by X L⁻ᵀ, each of whose rows solves L x' = x; n² operations a row.
pub fn solve_rows(factor: MatRef<'_, f64>, mut x: MatMut<'_, f64>) {
    let (n, n_rows) = (factor.nrows(), x.nrows());
    if n_rows > FEW_ROWS && n_rows * n * n > 2 * LEAF {
        let half = (n_rows / 2).next_multiple_of(TILE);
        let (top, bottom) = x.split_at_row_mut(half);
        rayon::join(|| solve_rows(factor, top), || solve_rows(factor, bottom));
        return;
    }
    if n <= TILE {
        return solve_tile(factor, x);
    }
    let width = panel_width(n);
    for start in (0..n).step_by(width) {
        let end = n.min(start + width);
        let (known, mut panel) = x.as_mut().get_mut(.., ..end).split_at_col_mut(start);
        let coefficients = factor.get(start..end, ..start).transpose();
        matmul(panel.as_mut(), Accum::Add, known.as_ref(), coefficients, -1.0, Par::Seq);
        solve_rows(factor.get(start..end, start..end), panel);
    }
}

/// Replaces each vector b by L⁻¹b, in one pass over the triangle of an owned matrix.
pub fn solve_lower(factor: MatRef<'_, f64>, vectors: &mut [&mut [f64]]) {
    for j in 0..factor.ncols() {
        let column = lower_column(factor, j);
        for vector in vectors.iter_mut() {
            let (head, rest) = vector[j..].split_at_mut(1);
            head[0] /= column[0];
            add_multiple(rest, -head[0], &column[1..]);
        }
    }
}

/// Replaces b by L⁻ᵀb, with L in an owned matrix.
pub fn solve_upper(factor: MatRef<'_, f64>, vector: &mut [f64]) {
    for j in (0..factor.ncols()).rev() {
        let column = lower_column(factor, j);
        let (head, rest) = vector[j..].split_at_mut(1);
        head[0] = (head[0] - dot(rest, &column[1..])) / column[0];
    }
}

/// Column j of L from its diagonal on.
fn lower_column(factor: MatRef<'_, f64>, j: usize) -> &[f64] {
    let column = factor.col(j).try_as_col_major().expect("owned matrices are column-major");
    &column.as_slice()[j..]
}

/// Replaces L by L⁻¹; n³/3 operations.
///
/// What stands above the diagonal has no meaning afterwards.
///
/// - `scratch`: [`scratch_rows`]×n.
pub fn invert(mut factor: MatMut<'_, f64>, mut scratch: MatMut<'_, f64>) {
    let n = factor.nrows();
    if n <= TILE {
        return invert_tile(factor);
    }
    let width = panel_width(n);
    for start in (0..n).step_by(width) {
        let end = n.min(start + width);
        let (done, rows) = factor.as_mut().get_mut(..end, ..end).split_at_row_mut(start);
        let (mut left, mut pivots) = rows.split_at_col_mut(start);
        invert(pivots.as_mut(), scratch.as_mut());
        clear_above(pivots.as_mut());
        let mut product = scratch.as_mut().get_mut(..end - start, ..start);
        let (rows, done) = (left.as_ref(), done.as_ref());
        let blocks = product.as_mut().par_col_chunks_mut(width).enumerate();
        blocks.for_each(|(block, product)| {
            let (first, last) = (block * width, (block + 1) * width);
            let (a, b) = (rows.get(.., first..), done.get(first..start, first..last));
            multiply(product, Accum::Replace, a, b, -1.0);
        });
        multiply(left.as_mut(), Accum::Replace, pivots.as_ref(), product.as_ref(), 1.0);
    }
}

/// L⁻¹ of a lower triangle L, with zeros above its diagonal; n³/3 operations.
pub fn inverse(factor: MatRef<'_, f64>) -> Mat<f64> {
    let n = factor.nrows();
    let mut inverse = factor.to_owned();
    invert(inverse.as_mut(), Mat::zeros(scratch_rows(n), n).as_mut());
    clear_above(inverse.as_mut());
    inverse
}

/// Adds the lower triangle of v vᵀ.
pub fn add_outer(sum: &mut Mat<f64>, v: &[f64]) {
    for (j, factor) in v.iter().enumerate() {
        add_multiple(&mut column_mut(sum, j)[j..], *factor, &v[j..]);
    }
}

/// Replaces the lower triangle M by that of MᵀM, where [`invert`] has left M; n³/3 operations.
///
/// - `scratch`: [`scratch_rows`]×n.
pub fn square(mut matrix: MatMut<'_, f64>, mut scratch: MatMut<'_, f64>) {
    let n = matrix.nrows();
    let width = panel_width(n);
    if n <= TILE {
        clear_above(matrix.as_mut());
    }
    for start in (0..n).step_by(width) {
        let end = n.min(start + width);
        let below = matrix.as_ref().get(start.., ..end);
        let mut product = scratch.as_mut().get_mut(..end - start, ..end);
        let panel = below.get(.., start..);
        multiply(product.as_mut(), Accum::Replace, panel.transpose(), below, 1.0);
        matrix.as_mut().get_mut(start..end, ..end).copy_from(product);
    }
}

/// product ← X L for an L with zeros above its diagonal; n² operations a row.
pub fn multiply_rows(mut product: MatMut<'_, f64>, x: MatRef<'_, f64>, lower: MatRef<'_, f64>) {
    let n = lower.nrows();
    for start in (0..n).step_by(WIDE) {
        let end = n.min(start + WIDE);
        for first in (start..end).step_by(NARROW) {
            let last = end.min(first + NARROW);
            let columns = product.as_mut().get_mut(.., first..last);
            let (a, b) = (x.get(.., first..end), lower.get(first..end, first..last));
            multiply(columns, Accum::Replace, a, b, 1.0);
        }
        let columns = product.as_mut().get_mut(.., start..end);
        increase(columns, x.get(.., end..), lower.get(end.., start..end), 1.0);
    }
}

/// product ← X Lᵀ for an L with zeros above its diagonal; n² operations a row.
pub fn multiply_rows_transposed(
    mut product: MatMut<'_, f64>,
    x: MatRef<'_, f64>,
    lower: MatRef<'_, f64>,
) {
    let n = lower.nrows();
    for start in (0..n).step_by(WIDE) {
        let end = n.min(start + WIDE);
        for first in (start..end).step_by(NARROW) {
            let last = end.min(first + NARROW);
            let columns = product.as_mut().get_mut(.., first..last);
            let (a, b) = (x.get(.., start..last), lower.get(first..last, start..last));
            multiply(columns, Accum::Replace, a, b.transpose(), 1.0);
        }
        let columns = product.as_mut().get_mut(.., start..end);
        increase(columns, x.get(.., ..start), lower.get(start..end, ..start).transpose(), 1.0);
    }
}

/// Writes zeros above the diagonal.
pub fn clear_above(mut matrix: MatMut<'_, f64>) {
    for j in 1..matrix.ncols() {
        matrix.as_mut().col_mut(j).subrows_mut(0, j).fill(0.0);
    }
}

/// The rows that a scratch matrix has for a triangle of size n.
pub fn scratch_rows(n: usize) -> usize {
    panel_width(n)
}

/// Columns that one matrix product finishes: wide enough for its speed, narrow enough for little
/// work above the diagonal.
fn panel_width(n: usize) -> usize {
    if n > 16 * TILE { 3 * TILE } else { TILE }
}

/// Columns of a triangle that a product with many rows takes at once: as many as the matrix product
/// keeps in registers, for the least work above the diagonal; and beside a wide rectangle.
const NARROW: usize = 8;
const WIDE: usize = 128;

/// Fewer rows are solved at once, for each part of them reads the whole triangle.
const FEW_ROWS: usize = 128;

/// Multiplications of a product that one thread does at once.
const LEAF: usize = 1 << 22;

/// sum ← factor·A B, or is increased by it; halves of large products run in parallel.
fn multiply(
    sum: MatMut<'_, f64>,
    accum: Accum,
    a: MatRef<'_, f64>,
    b: MatRef<'_, f64>,
    factor: f64,
) {
    let (m, n) = (sum.nrows(), sum.ncols());
    if m * n * a.ncols() <= LEAF {
        matmul(sum, accum, a, b, factor, Par::Seq);
    } else if m >= n {
        let (top, bottom) = sum.split_at_row_mut(m / 2);
        let (a_top, a_bottom) = a.split_at_row(m / 2);
        rayon::join(
            || multiply(top, accum, a_top, b, factor),
            || multiply(bottom, accum, a_bottom, b, factor),
        );
    } else {
        let (left, right) = sum.split_at_col_mut(n / 2);
        let (b_left, b_right) = b.split_at_col(n / 2);
        rayon::join(
            || multiply(left, accum, a, b_left, factor),
            || multiply(right, accum, a, b_right, factor),
        );
    }
}

/// sum ← sum + factor·A B.
fn increase(sum: MatMut<'_, f64>, a: MatRef<'_, f64>, b: MatRef<'_, f64>, factor: f64) {
    if a.ncols() > 0 {
        multiply(sum, Accum::Add, a, b, factor);
    }
}

#[cfg(test)]
mod tests {
    use faer::{Mat, Side};

    use super::{
        factorize, invert, multiply_rows, multiply_rows_transposed, scratch_rows, solve_rows,
        square,
    };

    #[test]
    fn products_with_a_triangle_are_those_with_a_whole_matrix() {
        for n in [1, 7, 8, 9, 100, 128, 129, 300] {
            let triangle = lower(&matrix(n));
            let rows = Mat::from_fn(5, n, |i, j| ((3 * i + j) as f64).sin());
            let mut product = Mat::full(5, n, f64::NAN);
            multiply_rows(product.as_mut(), rows.as_ref(), triangle.as_ref());
            assert!((&product - &rows * &triangle).norm_max() < 1e-13, "{n}");
            multiply_rows_transposed(product.as_mut(), rows.as_ref(), triangle.as_ref());
            assert!((&product - &rows * triangle.transpose()).norm_max() < 1e-13, "{n}");
        }
    }

    fn matrix(n: usize) -> Mat<f64> {
        let value = |i: usize, j: usize| (-0.3 * (i as f64 - j as f64).abs()).exp();
        Mat::from_fn(n, n, |i, j| value(i, j) + if i == j { 0.1 } else { 0.0 })
    }

    fn lower(matrix: &Mat<f64>) -> Mat<f64> {
        Mat::from_fn(
            matrix.nrows(),
            matrix.ncols(),
            |i, j| if i < j { 0.0 } else { matrix[(i, j)] },
        )
    }

    #[test]
    fn every_size_is_factored_solved_inverted_and_squared() {
        for n in [1, 2, 31, 32, 33, 64, 100, 127, 511, 513, 700] {
            let a = matrix(n);
            let mut factor = a.clone();
            factorize(factor.as_mut()).unwrap();
            let factor = lower(&factor);
            assert!((&factor * factor.transpose() - &a).norm_max() < 1e-13, "{n}");
            let mut rows = Mat::from_fn(5, n, |i, j| ((3 * i + j) as f64).sin());
            let right = rows.clone();
            solve_rows(factor.as_ref(), rows.as_mut());
            assert!((&rows * factor.transpose() - right).norm_max() < 1e-12, "{n}");
            let mut inverse = factor.clone();
            let mut scratch = Mat::zeros(scratch_rows(n), n);
            invert(inverse.as_mut(), scratch.as_mut());
            let half = lower(&inverse);
            assert!((&half * &factor - Mat::<f64>::identity(n, n)).norm_max() < 1e-12, "{n}");
            square(inverse.as_mut(), scratch.as_mut());
            let difference = lower(&inverse) - lower(&(half.transpose() * &half));
            assert!(difference.norm_max() < 1e-12, "{n}");
        }
    }

    #[test]
    fn what_stands_above_the_diagonal_does_not_matter() {
        let n = 150;
        let (mut clean, mut spoilt) = (matrix(n), matrix(n));
        (0..n).for_each(|j| (0..j).for_each(|i| spoilt[(i, j)] = f64::NAN));
        for matrix in [&mut clean, &mut spoilt] {
            let mut scratch = Mat::full(scratch_rows(n), n, f64::NAN);
            factorize(matrix.as_mut()).unwrap();
            invert(matrix.as_mut(), scratch.as_mut());
            square(matrix.as_mut(), scratch.as_mut());
        }
        assert_eq!(lower(&clean), lower(&spoilt));
    }

    #[test]
    fn the_first_bad_pivot_is_told() {
        let mut a = matrix(200);
        a[(77, 77)] = -1.0;
        assert_eq!(factorize(a.as_mut()), Err(77));
        let mut a = matrix(20);
        a[(3, 3)] = f64::NAN;
        assert_eq!(factorize(a.as_mut()), Err(3));
    }

    #[test]
    fn a_nearly_singular_matrix_is_factored_as_well_as_by_the_library() {
        let n = 300;
        let smooth = |i: usize, j: usize| (-0.5 * ((i as f64 - j as f64) / 40.0).powi(2)).exp();
        let a = Mat::from_fn(n, n, |i, j| smooth(i, j) + if i == j { 1e-12 } else { 0.0 });
        let mut factor = a.clone();
        factorize(factor.as_mut()).unwrap();
        let factor = lower(&factor);
        let library = a.llt(Side::Lower).unwrap();
        let error = |factor: &Mat<f64>| (factor * factor.transpose() - &a).norm_max();
        assert!(
            error(&factor) < 2.0 * error(&library.L().to_owned()) + 1e-15,
            "{}",
            error(&factor)
        );
    }
}
