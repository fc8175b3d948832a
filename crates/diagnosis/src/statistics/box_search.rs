//! The range of cells in which residuals share most of one mean.

/// Neighbouring cells of an axis; on a periodic one they may go on from the last to the first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct CellRange {
    pub(crate) first: usize,
    pub(crate) n: usize,
}

/// Number of steps and sum of their values in a cell.
pub(crate) type Tally = (f64, f64);

/// S²/n: by how much the sum of squares falls when the mean is taken off.
pub(crate) fn gain((n, sum): Tally) -> f64 {
    if n > 0.0 { sum * sum / n } else { 0.0 }
}

impl CellRange {
    /// Whether it holds a cell of an axis with `n_cells`.
    pub(crate) fn holds(&self, cell: usize, n_cells: usize) -> bool {
        (cell + n_cells - self.first) % n_cells < self.n
    }

    /// Every range of an axis, the short ones first.
    pub(crate) fn all(n_cells: usize, is_periodic: bool) -> impl Iterator<Item = Self> {
        (1..=n_cells).flat_map(move |n| {
            let wraps = is_periodic && n < n_cells;
            let n_starts = if wraps { n_cells } else { n_cells - n + 1 };
            (0..n_starts).map(move |first| Self { first, n })
        })
    }

    pub(crate) fn cells(self, n_cells: usize) -> impl Iterator<Item = usize> {
        (self.first..self.first + self.n).map(move |cell| cell % n_cells)
    }
}

/// The gain of means above zero alone.
pub(crate) fn gain_above((n, sum): Tally) -> f64 {
    gain((n, sum.max(0.0)))
}

/// The range of an axis with the largest gain.
pub(crate) fn best_range(cells: &[Tally], is_periodic: bool, gain: fn(Tally) -> f64) -> CellRange {
    let mut best = (f64::NEG_INFINITY, CellRange { first: 0, n: cells.len() });
    for range in CellRange::all(cells.len(), is_periodic) {
        let own = range.cells(cells.len()).map(|cell| cells[cell]);
        let found = gain(own.fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1)));
        if found > best.0 {
            best = (found, range);
        }
    }
    best.1
}

/// The ranges of two axes with the largest gain; `cells` row by row of the first axis.
pub(crate) fn best_ranges(
    cells: &[Tally],
    periodic: [bool; 2],
    n_columns: usize,
    gain: fn(Tally) -> f64,
) -> [CellRange; 2] {
    let n_rows = cells.len() / n_columns;
    let mut best = (f64::NEG_INFINITY, [CellRange { first: 0, n: 1 }; 2]);
    for rows in CellRange::all(n_rows, periodic[0]) {
        let mut columns = vec![(0.0, 0.0); n_columns];
        for row in rows.cells(n_rows) {
            for (column, cell) in columns.iter_mut().zip(&cells[row * n_columns..]) {
                *column = (column.0 + cell.0, column.1 + cell.1);
            }
        }
        let range = best_range(&columns, periodic[1], gain);
        let own = range.cells(n_columns).map(|column| columns[column]);
        let found = gain(own.fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1)));
        if found > best.0 {
            best = (found, [rows, range]);
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::{CellRange, Tally, best_range, best_ranges, gain};

    fn cells(means: &[f64]) -> Vec<Tally> {
        means.iter().map(|mean| (20.0, 20.0 * mean)).collect()
    }

    #[test]
    fn neighbours_with_half_of_the_mean_belong_together() {
        let range = |means: &[f64], periodic| best_range(&cells(means), periodic, gain);
        assert_eq!(range(&[0.1, 2.0, 1.5, 0.2, -0.4], false), CellRange { first: 1, n: 2 });
        assert_eq!(range(&[1.0, 1.0, 1.0], false), CellRange { first: 0, n: 3 });
        assert_eq!(range(&[-2.0, 0.1, 0.1, -1.8], false), CellRange { first: 0, n: 1 });
        assert_eq!(range(&[-2.0, 0.1, 0.1, -1.8], true), CellRange { first: 3, n: 2 });
        assert!(
            CellRange { first: 3, n: 2 }.holds(0, 4) && !CellRange { first: 3, n: 2 }.holds(1, 4)
        );
    }

    #[test]
    fn a_corner_is_found_in_the_plane_and_cells_without_steps_do_no_harm() {
        let mut plane = cells(&[0.0; 20]);
        for index in [3, 4, 8, 9] {
            plane[index] = (20.0, -30.0);
        }
        plane[13] = (0.0, 0.0);
        let [rows, columns] = best_ranges(&plane, [false; 2], 5, gain);
        assert_eq!((rows, columns), (CellRange { first: 0, n: 2 }, CellRange { first: 3, n: 2 }));
    }
}
