//! What a process on a grid keeps of its rows, however many there are.

use faer::MatRef;
use gp_core::GpError;
use gp_core::kernel::copy_row;
use rayon::prelude::{IntoParallelIterator, ParallelIterator};

use crate::grid::{Grid, Stencil};

/// Sums over rows for y ≈ W f, with W the shares of M nodes in each row.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct GridSums {
    pub(crate) n_rows: usize,
    /// Subtracted from all outputs.
    pub(crate) origin: f64,
    /// WᵀW by rows: entry by entry its columns and values, and where each row starts.
    pub(crate) starts: Vec<usize>,
    pub(crate) columns: Vec<u32>,
    pub(crate) values: Vec<f64>,
    /// Wᵀy.
    pub(crate) of_y: Vec<f64>,
    /// yᵀy.
    pub(crate) y_y: f64,
}

/// Dense sums of some of the rows.
struct Part {
    /// For each node and each neighbour behind it.
    square: Vec<f64>,
    of_y: Vec<f64>,
    y_y: f64,
}

impl GridSums {
    /// One pass over the rows, in parallel with the same bits for any number of threads.
    ///
    /// # Errors
    /// `Incompatible` if a row is not on the grid.
    pub(crate) fn new(grid: &Grid, x: MatRef<'_, f64>, y: &[f64]) -> Result<Self, GpError> {
        let origin = y.iter().sum::<f64>() / y.len() as f64;
        let per_part = y.len().div_ceil(MOST_PARTS).max(LEAST_ROWS);
        let part = |p: usize| {
            let (start, end) = (p * per_part, y.len().min((p + 1) * per_part));
            let mut part = Part::new(grid);
            part.take(grid, x.subrows(start, end - start), &y[start..end], origin)?;
            Ok(part)
        };
        let parts: Vec<Result<Part, GpError>> =
            (0..y.len().div_ceil(per_part)).into_par_iter().map(part).collect();
        let mut whole = Part::new(grid);
        for part in parts {
            whole.add(&part?);
        }
        Ok(whole.compress(grid, y.len(), origin))
    }

    /// WᵀW v.
    pub(crate) fn multiply(&self, v: &[f64], product: &mut [f64]) {
        for (entries, product) in self.starts.windows(2).zip(product) {
            let row = entries[0]..entries[1];
            let pairs = self.columns[row.clone()].iter().zip(&self.values[row]);
            *product = pairs.map(|(&column, value)| value * v[column as usize]).sum();
        }
    }

    /// Subtracts `factor` times column `row` of WᵀW, from its diagonal on.
    pub(crate) fn subtract_row(&self, row: usize, factor: f64, values: &mut [f64]) {
        for entry in self.starts[row]..self.starts[row + 1] {
            if let Some(below) = (self.columns[entry] as usize).checked_sub(row) {
                values[below] -= factor * self.values[entry];
            }
        }
    }
}

impl Part {
    fn new(grid: &Grid) -> Self {
        let m = grid.n_nodes();
        Self { square: vec![0.0; m * width(grid)], of_y: vec![0.0; m], y_y: 0.0 }
    }

    fn take(
        &mut self,
        grid: &Grid,
        x: MatRef<'_, f64>,
        y: &[f64],
        origin: f64,
    ) -> Result<(), GpError> {
        let width = width(grid);
        let codes = codes(grid.counts.len());
        let (mut stencil, mut row) = (Stencil::default(), vec![0.0; x.ncols()]);
        for (i, y) in y.iter().enumerate() {
            copy_row(x, i, &mut row);
            if !grid.stencil(&row, &mut stencil) {
                return Err(GpError::Incompatible { what: "the rows and the grid" });
            }
            let y = y - origin;
            self.y_y += y * y;
            let (nodes, weights) = (&stencil.nodes, &stencil.weights);
            for (a, (&node, weight)) in nodes.iter().zip(weights).enumerate() {
                self.of_y[node as usize] += weight * y;
                let square = &mut self.square[node as usize * width..][..width];
                let codes = &codes[a * nodes.len()..][..nodes.len()];
                for (code, other) in codes[a..].iter().zip(&weights[a..]) {
                    square[*code as usize] += weight * other;
                }
            }
        }
        Ok(())
    }

    fn add(&mut self, other: &Self) {
        self.square.iter_mut().zip(&other.square).for_each(|(sum, term)| *sum += term);
        self.of_y.iter_mut().zip(&other.of_y).for_each(|(sum, term)| *sum += term);
        self.y_y += other.y_y;
    }

    /// Both triangles, without what is 0.
    fn compress(self, grid: &Grid, n_rows: usize, origin: f64) -> GridSums {
        let (m, width) = (grid.n_nodes(), width(grid));
        let mut rows: Vec<Vec<(u32, f64)>> = vec![Vec::new(); m];
        let offsets = offsets(grid);
        for a in 0..m {
            for (code, value) in self.square[a * width..][..width].iter().enumerate() {
                if *value == 0.0 {
                    continue;
                }
                let other = grid.place_of(i64::from(grid.nodes[a]) + offsets[code]);
                rows[a].push((other, *value));
                if other as usize != a {
                    rows[other as usize].push((a as u32, *value));
                }
            }
        }
        let mut starts = vec![0];
        let (mut columns, mut values) = (Vec::new(), Vec::new());
        for mut row in rows {
            row.sort_unstable_by_key(|(column, _)| *column);
            columns.extend(row.iter().map(|(column, _)| *column));
            values.extend(row.iter().map(|(_, value)| *value));
            starts.push(columns.len());
        }
        let Self { of_y, y_y, .. } = self;
        GridSums { n_rows, origin, starts, columns, values, of_y, y_y }
    }
}

/// Neighbours that two nodes of a stencil can be of each other: from −3 to 3 along each input.
fn width(grid: &Grid) -> usize {
    7_usize.pow(grid.counts.len() as u32)
}

/// Which neighbour each node of a stencil is of each other.
fn codes(d: usize) -> Vec<u16> {
    let n = 4_usize.pow(d as u32);
    let code = |a: usize, b: usize| {
        (0..d as u32).rev().fold(0, |code, k| {
            let digit = |node: usize| node / 4_usize.pow(k) % 4;
            code * 7 + digit(b) + 3 - digit(a)
        }) as u16
    };
    (0..n * n).map(|pair| code(pair / n, pair % n)).collect()
}

/// The difference of numbers on the whole grid for each neighbour.
fn offsets(grid: &Grid) -> Vec<i64> {
    let d = grid.counts.len();
    let offset = |code: usize| {
        (0..d).map(move |k| {
            let digit = code / 7_usize.pow((d - 1 - k) as u32) % 7;
            let below: usize = grid.counts[k + 1..].iter().product();
            (digit as i64 - 3) * below as i64
        })
    };
    (0..width(grid)).map(|code| offset(code).sum()).collect()
}

/// Parts that run in parallel, and the fewest rows of one.
const MOST_PARTS: usize = 8;
const LEAST_ROWS: usize = 5000;
