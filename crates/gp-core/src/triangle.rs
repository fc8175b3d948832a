//! Lower triangular matrices in blocks over the matrix product: factor, solve, invert, square.
//!
//! All work on column-major matrices in place. The arithmetic is cut into products whose number and
//! order follow from the sizes alone; large ones run in parallel, so that the bits do not depend on
//! the number of threads.

use faer::linalg::matmul::matmul;
use faer::{Accum, MatMut, MatRef, Par};
use pulp::{Arch, Simd, WithSimd};

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
    for start in (0..n).step_by(width) {
        let end = n.min(start + width);
        let rows = matrix.as_mut().get_mut(start.., ..end);
        let (known, mut panel) = rows.split_at_col_mut(start);
        let (known, width) = (known.as_ref(), end - start);
        add_product(panel.as_mut(), known, known.subrows(0, width).transpose());
        let (mut pivots, below) = panel.split_at_row_mut(width);
        factorize(pivots.as_mut()).map_err(|pivot| start + pivot)?;
        solve_rows(pivots.as_ref(), below);
    }
    Ok(())
}

/// Replaces X by X L⁻ᵀ, each of whose rows solves L x' = x; n² operations a row.
pub fn solve_rows(factor: MatRef<'_, f64>, mut x: MatMut<'_, f64>) {
    let n = factor.nrows();
    if n <= TILE {
        return solve_tile(factor, x);
    }
    let width = panel_width(n);
    for start in (0..n).step_by(width) {
        let end = n.min(start + width);
        let (known, mut panel) = x.as_mut().get_mut(.., ..end).split_at_col_mut(start);
        let coefficients = factor.get(start..end, ..start);
        add_product(panel.as_mut(), known.as_ref(), coefficients.transpose());
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
        for first in (0..start).step_by(width) {
            let last = first + width;
            let (a, b) = (left.as_ref().subcols(first, start - first), done.as_ref());
            let product = product.as_mut().get_mut(.., first..last);
            multiply(product, Accum::Replace, a, b.get(first..start, first..last), -1.0);
        }
        multiply(left.as_mut(), Accum::Replace, pivots.as_ref(), product.as_ref(), 1.0);
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

/// The rows that a scratch matrix has for a triangle of size n.
pub fn scratch_rows(n: usize) -> usize {
    panel_width(n)
}

/// Rows and columns of the tiles that are handled without a matrix product.
const TILE: usize = 32;

/// Columns that one matrix product finishes: wide enough for its speed, narrow enough for little
/// work above the diagonal.
fn panel_width(n: usize) -> usize {
    if n > 16 * TILE { 2 * TILE } else { TILE }
}

/// Multiplications of a product that one thread does at once.
const LEAF: usize = 1 << 23;

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

/// sum ← sum − A B.
fn add_product(sum: MatMut<'_, f64>, a: MatRef<'_, f64>, b: MatRef<'_, f64>) {
    if a.ncols() > 0 {
        multiply(sum, Accum::Add, a, b, -1.0);
    }
}

fn clear_above(mut matrix: MatMut<'_, f64>) {
    for j in 1..matrix.ncols() {
        matrix.as_mut().col_mut(j).subrows_mut(0, j).fill(0.0);
    }
}

/// Columns of a tile, which stays in the first cache.
type Tile = [[f64; TILE]; TILE];

fn factorize_tile(mut matrix: MatMut<'_, f64>) -> Result<(), usize> {
    let mut columns = [[0.0; TILE]; TILE];
    load(matrix.as_ref(), &mut columns);
    let failed = Arch::new().dispatch(FactorColumns(&mut columns[..matrix.ncols()]));
    store(&columns, matrix.as_mut());
    failed.map_or(Ok(()), Err)
}

fn solve_tile(factor: MatRef<'_, f64>, mut x: MatMut<'_, f64>) {
    let triangle = Triangle::new(factor);
    let mut columns = [[0.0; TILE]; TILE];
    for start in (0..x.nrows()).step_by(TILE) {
        let n_rows = TILE.min(x.nrows() - start);
        let mut rows = x.as_mut().subrows_mut(start, n_rows);
        load(rows.as_ref(), &mut columns);
        triangle.solve(&mut columns);
        store(&columns, rows.as_mut());
    }
}

fn invert_tile(factor: MatMut<'_, f64>) {
    let mut columns = [[0.0; TILE]; TILE];
    (0..TILE).for_each(|i| columns[i][i] = 1.0);
    Triangle::new(factor.as_ref()).solve(&mut columns);
    // The rows are those of L⁻ᵀ.
    store(&columns, factor.transpose_mut());
}

/// A triangle by rows, with 1 over its diagonal.
struct Triangle {
    rows: Tile,
    n: usize,
}

impl Triangle {
    fn new(factor: MatRef<'_, f64>) -> Self {
        let n = factor.nrows();
        let mut rows = [[0.0; TILE]; TILE];
        for (j, row) in rows[..n].iter_mut().enumerate() {
            (0..j).for_each(|k| row[k] = factor[(j, k)]);
            row[j] = factor[(j, j)].recip();
        }
        Self { rows, n }
    }

    fn solve(&self, columns: &mut Tile) {
        let (columns, rows) = (&mut columns[..self.n], &self.rows);
        Arch::new().dispatch(SolveColumns { columns, rows });
    }
}

/// Overwrites a tile by its Cholesky factor; returns the first pivot that is not positive.
struct FactorColumns<'a>(&'a mut [[f64; TILE]]);

impl WithSimd for FactorColumns<'_> {
    type Output = Option<usize>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Option<usize> {
        for j in 0..self.0.len() {
            let (known, rest) = self.0.split_at_mut(j);
            subtract(simd, &mut rest[0], known, |_, column| column[j]);
            let pivot = rest[0][j];
            if pivot <= 0.0 || pivot.is_nan() {
                return Some(j);
            }
            scale(&mut rest[0], pivot.sqrt().recip());
        }
        None
    }
}

/// Replaces the columns X of a tile by those of X L⁻ᵀ.
struct SolveColumns<'a> {
    columns: &'a mut [[f64; TILE]],
    rows: &'a Tile,
}

impl WithSimd for SolveColumns<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for (j, row) in self.rows[..self.columns.len()].iter().enumerate() {
            let (known, rest) = self.columns.split_at_mut(j);
            subtract(simd, &mut rest[0], known, |k, _| row[k]);
            scale(&mut rest[0], row[j]);
        }
    }
}

/// sum ← sum − Σ coefficient·column.
#[inline(always)]
fn subtract<S: Simd>(
    simd: S,
    sum: &mut [f64; TILE],
    columns: &[[f64; TILE]],
    coefficient: impl Fn(usize, &[f64; TILE]) -> f64,
) {
    match TILE / S::F64_LANES {
        0..4 => subtract_in::<S, 1>(simd, sum, columns, coefficient),
        4..8 => subtract_in::<S, 4>(simd, sum, columns, coefficient),
        _ => subtract_in::<S, 8>(simd, sum, columns, coefficient),
    }
}

/// As `subtract`, with `N` vector registers of the sum at a time.
#[inline(always)]
fn subtract_in<S: Simd, const N: usize>(
    simd: S,
    sum: &mut [f64; TILE],
    columns: &[[f64; TILE]],
    coefficient: impl Fn(usize, &[f64; TILE]) -> f64,
) {
    let (sum, _) = S::as_mut_simd_f64s(sum);
    for (block, sum) in sum.as_chunks_mut::<N>().0.iter_mut().enumerate() {
        let mut registers = *sum;
        for (k, column) in columns.iter().enumerate() {
            let factor = simd.splat_f64s(-coefficient(k, column));
            let column = &S::as_simd_f64s(column).0.as_chunks::<N>().0[block];
            for (register, value) in registers.iter_mut().zip(column) {
                *register = simd.mul_add_f64s(*value, factor, *register);
            }
        }
        *sum = registers;
    }
}

#[inline(always)]
fn scale(column: &mut [f64; TILE], factor: f64) {
    for value in column {
        *value *= factor;
    }
}

fn load(matrix: MatRef<'_, f64>, tile: &mut Tile) {
    for (values, column) in tile.iter_mut().zip(matrix.col_iter()) {
        values.iter_mut().zip(column.iter()).for_each(|(value, entry)| *value = *entry);
    }
}

fn store(tile: &Tile, matrix: MatMut<'_, f64>) {
    for (column, values) in matrix.col_iter_mut().zip(tile) {
        column.iter_mut().zip(values).for_each(|(entry, value)| *entry = *value);
    }
}

#[cfg(test)]
mod tests {
    use faer::{Mat, Side};

    use super::{factorize, invert, scratch_rows, solve_rows, square};

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
