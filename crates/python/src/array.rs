//! NumPy arrays as the crates take and give numbers.

use faer::{Mat, MatRef};
use numpy::{PyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::{Bound, PyResult, Python};

/// A matrix of one's own, one row after the other.
pub(crate) struct Rows {
    values: Vec<f64>,
    n_rows: usize,
    n_columns: usize,
}

impl Rows {
    /// Copies an array, which other threads of Python may change.
    pub(crate) fn of(array: &PyReadonlyArray2<'_, f64>) -> Self {
        let (n_rows, n_columns) = (array.shape()[0], array.shape()[1]);
        let values = array.as_array().iter().copied().collect();
        Self { values, n_rows, n_columns }
    }

    pub(crate) fn matrix(&self) -> MatRef<'_, f64> {
        MatRef::from_row_major_slice(&self.values, self.n_rows, self.n_columns)
    }
}

/// An array with the numbers of a matrix.
///
/// # Errors
/// None: as many numbers come as its shape asks for.
pub(crate) fn array_of<'py>(
    py: Python<'py>,
    matrix: &Mat<f64>,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let (n, m) = (matrix.nrows(), matrix.ncols());
    let values = (0..n).flat_map(|i| (0..m).map(move |j| matrix[(i, j)])).collect();
    shaped(py, values, [n, m])
}

/// An array of a shape.
///
/// # Errors
/// `ValueError` for another number of values.
pub(crate) fn shaped<const D: usize>(
    py: Python<'_>,
    values: Vec<f64>,
    shape: [usize; D],
) -> PyResult<Bound<'_, PyArray<f64, numpy::ndarray::Dim<[usize; D]>>>>
where
    numpy::ndarray::Dim<[usize; D]>: numpy::ndarray::Dimension,
    [usize; D]: numpy::ndarray::IntoDimension<Dim = numpy::ndarray::Dim<[usize; D]>>,
{
    PyArray1::from_vec(py, values).reshape(shape)
}
