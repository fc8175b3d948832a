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
