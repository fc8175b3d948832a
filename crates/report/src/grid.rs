//! Values on a regular grid of cells.

use crate::error::{ReportError, check_finite, check_length, check_positive};

/// One value for each cell of a regular grid, row by row from the lowest y.
#[derive(Debug, Clone)]
pub struct Grid {
    pub(crate) x: (f64, f64),
    pub(crate) y: (f64, f64),
    pub(crate) columns: usize,
    pub(crate) rows: usize,
    pub(crate) values: Vec<f64>,
    pub(crate) shown: Option<Vec<bool>>,
}

impl Grid {
    /// Cells that fill `x.0` to `x.1` by `y.0` to `y.1`; `values[row · columns + column]`.
    pub fn new(
        x: (f64, f64),
        y: (f64, f64),
        columns: usize,
        rows: usize,
        values: Vec<f64>,
    ) -> Self {
        Self { x, y, columns, rows, values, shown: None }
    }

    /// The same with the function's values at the cells' centers.
    pub fn sample(
        x: (f64, f64),
        y: (f64, f64),
        columns: usize,
        rows: usize,
        mut value: impl FnMut(f64, f64) -> f64,
    ) -> Self {
        let mut grid = Self::new(x, y, columns, rows, Vec::new());
        grid.values = (0..rows)
            .flat_map(|row| (0..columns).map(move |column| (row, column)))
            .map(|(row, column)| {
                let [x, y] = grid.center(column as f64, row as f64);
                value(x, y)
            })
            .collect();
        grid
    }

    /// The values, row by row from the lowest y.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Shows only the cells that are `true`; the values of the others may be anything finite.
    #[must_use]
    pub fn mask(mut self, shown: Vec<bool>) -> Self {
        self.shown = Some(shown);
        self
    }

    /// The center of a cell; fractions lie between centers.
    pub(crate) fn center(&self, column: f64, row: f64) -> [f64; 2] {
        let at =
            |(low, high): (f64, f64), i: f64, n: usize| low + (high - low) * (i + 0.5) / n as f64;
        [at(self.x, column, self.columns), at(self.y, row, self.rows)]
    }

    /// The grid with one more cell on each side, extrapolated linearly, so that lines between
    /// centers reach the border.
    pub(crate) fn padded(&self) -> Self {
        let width =
            [(self.x.1 - self.x.0) / self.columns as f64, (self.y.1 - self.y.0) / self.rows as f64];
        let (columns, rows) = (self.columns + 2, self.rows + 2);
        let cells = || (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column)));
        // Mirrored twice about the nearest cell: v(-1) = 2 v(0) - v(1).
        let near = |i: usize, n: usize| i.clamp(1, n) - 1;
        let mirrored = |i: usize, n: usize| {
            let at = near(i, n);
            (2 * at + 1).saturating_sub(i).min(n - 1)
        };
        let value = |(row, column): (usize, usize)| {
            let (a, b) = (near(row, self.rows), near(column, self.columns));
            let (c, d) = (mirrored(row, self.rows), mirrored(column, self.columns));
            2.0 * self.values[a * self.columns + b] - self.values[c * self.columns + d]
        };
        let shown = |(row, column): (usize, usize)| {
            self.is_shown(near(row, self.rows) * self.columns + near(column, self.columns))
        };
        Self {
            x: (self.x.0 - width[0], self.x.1 + width[0]),
            y: (self.y.0 - width[1], self.y.1 + width[1]),
            columns,
            rows,
            values: cells().map(value).collect(),
            shown: Some(cells().map(shown).collect()),
        }
    }

    pub(crate) fn is_shown(&self, index: usize) -> bool {
        self.shown.as_ref().is_none_or(|shown| shown[index])
    }

    /// The values of the cells that are shown.
    pub(crate) fn visible(&self) -> impl Iterator<Item = f64> + '_ {
        let cells = self.values.iter().enumerate();
        cells.filter(|(i, _)| self.is_shown(*i)).map(|(_, value)| *value)
    }

    pub(crate) fn check(&self, name: &str) -> Result<(), ReportError> {
        check_positive(name, "columns", self.columns as f64)?;
        check_positive(name, "rows", self.rows as f64)?;
        check_length(name, "values", self.columns * self.rows, self.values.len())?;
        check_finite(name, "values", &self.values)?;
        check_finite(name, "x and y ranges", &[self.x.0, self.x.1, self.y.0, self.y.1])?;
        check_positive(name, "x range width", self.x.1 - self.x.0)?;
        check_positive(name, "y range width", self.y.1 - self.y.0)?;
        let Some(shown) = &self.shown else { return Ok(()) };
        check_length(name, "mask", self.values.len(), shown.len())?;
        if shown.contains(&true) {
            return Ok(());
        }
        Err(ReportError::Empty { mark: name.to_owned() })
    }
}

#[cfg(test)]
mod tests {
    use super::Grid;

    #[test]
    fn padding_continues_a_plane() {
        let plane = |x: f64, y: f64| 1.0 + 2.0 * x - 3.0 * y;
        let padded = Grid::sample((0.0, 1.0), (-1.0, 1.0), 5, 4, plane).padded();
        for row in 0..padded.rows {
            for column in 0..padded.columns {
                let [x, y] = padded.center(column as f64, row as f64);
                let value = padded.values[row * padded.columns + column];
                assert!((value - plane(x, y)).abs() < 1e-12, "{row} {column}");
            }
        }
    }
}
