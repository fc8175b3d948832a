//! The commands of the command line.

use pushlab::CommandError;
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::{Bound, PyAny, PyResult, pyfunction};

use crate::failure::PushlabError;
use crate::interruptible::interruptible;

/// Runs a command, as if these words stood behind `pushlab`: the JSON document and the text that it prints.
#[pyfunction]
pub(crate) fn run(words: Vec<String>, tell: &Bound<'_, PyAny>) -> PyResult<(String, String)> {
    let work = move |teller| pushlab::run(&words, teller);
    match interruptible(tell.py(), Some(tell), work)? {
        Ok(printed) => Ok((printed.document, printed.text)),
        Err(CommandError::Stopped) => Err(PyKeyboardInterrupt::new_err(())),
        Err(error) => Err(PushlabError::new_err(error.to_string())),
    }
}
