//! Errors as exceptions, in the words of the command line.

use std::error::Error;

use pyo3::PyErr;
use pyo3::exceptions::PyValueError;

pyo3::create_exception!(
    pushlab,
    PushlabError,
    PyValueError,
    "What was wrong with an input or a computation, with the value, its unit and what to do."
);

/// An error of a crate with its causes.
pub(crate) fn refused(error: impl Error + Send + Sync + 'static) -> PyErr {
    PushlabError::new_err(pushlab::explained(error))
}
