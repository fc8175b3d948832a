//! Memory of predictions.

use faer::{Mat, MatMut};

/// Matrices that predictions write their steps in, kept from one call to the next.
#[derive(Clone, Debug)]
pub struct Workspace {
    first: Mat<f64>,
    second: Mat<f64>,
}

impl Default for Workspace {
    fn default() -> Self {
        Self::new()
    }
}

impl Workspace {
    /// Nothing yet: the first prediction takes what it needs.
    pub const fn new() -> Self {
        Self { first: Mat::new(), second: Mat::new() }
    }

    /// Two matrices of a size, with whatever stood in them.
    pub fn matrices(
        &mut self,
        n_rows: usize,
        n_columns: usize,
    ) -> (MatMut<'_, f64>, MatMut<'_, f64>) {
        if self.first.nrows() < n_rows || self.first.ncols() < n_columns {
            let rows = n_rows.max(self.first.nrows());
            let columns = n_columns.max(self.first.ncols());
            self.first = Mat::zeros(rows, columns);
            self.second = Mat::zeros(rows, columns);
        }
        let Self { first, second } = self;
        (first.get_mut(..n_rows, ..n_columns), second.get_mut(..n_rows, ..n_columns))
    }
}
