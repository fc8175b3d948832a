//! Small triangles, in vector registers and without a matrix product.

use faer::{MatMut, MatRef};
use pulp::{Arch, Simd, WithSimd};

/// The most rows and columns of a tile.
pub(crate) const TILE: usize = 32;

/// Columns of a tile, which stays in the first cache.
type Tile = [[f64; TILE]; TILE];

/// Overwrites the lower triangle of a symmetric matrix by its Cholesky factor, or tells the first
/// pivot that is not positive.
pub(crate) fn factorize_tile(mut matrix: MatMut<'_, f64>) -> Result<(), usize> {
    let mut columns = [[0.0; TILE]; TILE];
    load(matrix.as_ref(), &mut columns);
    let failed = Arch::new().dispatch(FactorColumns(&mut columns[..matrix.ncols()]));
    store(&columns, matrix.as_mut());
    failed.map_or(Ok(()), Err)
}

/// Replaces X by X L⁻ᵀ.
pub(crate) fn solve_tile(factor: MatRef<'_, f64>, mut x: MatMut<'_, f64>) {
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

/// Replaces L by L⁻¹.
pub(crate) fn invert_tile(factor: MatMut<'_, f64>) {
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
        match column.try_as_col_major() {
            Some(column) => values[..column.nrows()].copy_from_slice(column.as_slice()),
            None => values.iter_mut().zip(column.iter()).for_each(|(value, entry)| *value = *entry),
        }
    }
}

fn store(tile: &Tile, matrix: MatMut<'_, f64>) {
    for (mut column, values) in matrix.col_iter_mut().zip(tile) {
        let n = column.nrows();
        match column.as_mut().try_as_col_major_mut() {
            Some(column) => column.as_slice_mut().copy_from_slice(&values[..n]),
            None => column.iter_mut().zip(values).for_each(|(entry, value)| *entry = *value),
        }
    }
}
