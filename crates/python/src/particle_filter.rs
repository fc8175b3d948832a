//! A particle filter whose models are functions of Python.

use filter::{FilterError, MotionModel, Settings, all_resamplers};
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::types::PyAnyMethods;
use pyo3::{Bound, Py, PyAny, PyErr, PyResult, Python, pyclass, pymethods};
use rand::Rng;

use crate::array::shaped;
use crate::failure::{PushlabError, refused};

/// Weighted particles, each a vector of D numbers.
#[pyclass(module = "pushlab._native")]
pub(crate) struct ParticleFilter {
    filter: filter::ParticleFilter<'static, Vec<f64>>,
    dimension: usize,
}

#[pymethods]
impl ParticleFilter {
    #[new]
    fn new(
        particles: PyReadonlyArray2<'_, f64>,
        resampler: &str,
        resample_below: f64,
        seed: u64,
    ) -> PyResult<Self> {
        let known = all_resamplers();
        let Some(&resampler) = known.iter().find(|known| known.id() == resampler) else {
            let names: Vec<_> = known.iter().map(|known| known.id()).collect();
            let names = names.join(", ");
            return Err(PushlabError::new_err(format!(
                "there is no resampler `{resampler}`; there are {names}"
            )));
        };
        let settings = Settings { resampler, resample_below, seed };
        let filter = filter::ParticleFilter::new(states(&particles), settings).map_err(refused)?;
        Ok(Self { filter, dimension: particles.shape()[1] })
    }

    /// N×D.
    #[getter]
    fn particles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        array(py, self.filter.particles(), self.dimension)
    }

    /// N, summing to 1.
    #[getter]
    fn weights<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, self.filter.weights().as_slice())
    }

    #[getter]
    fn effective_size(&self) -> f64 {
        self.filter.weights().effective_size()
    }

    #[getter]
    fn step(&self) -> usize {
        self.filter.step()
    }

    /// Moves all particles by `motion(states, seed)`, which is called for blocks of them.
    fn predict(&mut self, py: Python<'_>, motion: Py<PyAny>) -> PyResult<()> {
        let motion = PythonMotion { motion, dimension: self.dimension };
        py.detach(|| self.filter.predict(&motion)).map_err(raised)
    }

    /// Weighs them by log likelihoods: the log evidence, the effective size, and whether they were drawn anew.
    fn update(
        &mut self,
        py: Python<'_>,
        log_likelihoods: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<(f64, f64, bool)> {
        let values: Vec<f64> = log_likelihoods.as_array().iter().copied().collect();
        let update = py.detach(|| self.filter.update_by(&values)).map_err(raised)?;
        Ok((update.log_evidence, update.effective_size, update.resampled))
    }

    /// Draws all particles anew by their weights.
    fn resample(&mut self, py: Python<'_>) {
        py.detach(|| self.filter.resample());
    }
}

/// A motion as a function of Python has it.
struct PythonMotion {
    motion: Py<PyAny>,
    dimension: usize,
}

impl MotionModel for PythonMotion {
    type State = Vec<f64>;
    type Error = PyErr;

    fn advance(&self, states: &mut [Vec<f64>], random: &mut dyn Rng) -> Result<(), PyErr> {
        Python::attach(|py| {
            let before = array(py, states, self.dimension)?;
            let after = self.motion.bind(py).call1((before, random.next_u64()))?;
            let after: PyReadonlyArray2<'_, f64> = after.extract()?;
            let expected = (states.len(), self.dimension);
            let found = (after.shape()[0], after.shape()[1]);
            if found != expected {
                return Err(PushlabError::new_err(format!(
                    "the motion returned an array of shape {found:?}, and was given one of {expected:?}"
                )));
            }
            for (state, row) in states.iter_mut().zip(after.as_array().rows()) {
                state.iter_mut().zip(row).for_each(|(value, after)| *value = *after);
            }
            Ok(())
        })
    }
}

fn states(array: &PyReadonlyArray2<'_, f64>) -> Vec<Vec<f64>> {
    array.as_array().rows().into_iter().map(|row| row.to_vec()).collect()
}

fn array<'py>(
    py: Python<'py>,
    states: &[Vec<f64>],
    dimension: usize,
) -> PyResult<Bound<'py, PyArray2<f64>>> {
    shaped(py, states.concat(), [states.len(), dimension])
}

/// What the function raised, or what the filter says.
fn raised(error: FilterError) -> PyErr {
    match error {
        FilterError::Motion { step, source } => match source.downcast::<PyErr>() {
            Ok(own) => *own,
            Err(source) => refused(FilterError::Motion { step, source }),
        },
        error => refused(error),
    }
}
