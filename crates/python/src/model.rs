//! A model from its file.

use std::path::PathBuf;
use std::sync::Arc;

use models::{ModelError, ModelFile, Noise, StepInput, StepPrediction, StepSelection};
use numpy::ndarray::{Ix1, Ix2, Ix3};
use numpy::{IntoPyArray, PyArray};
use output::{Existing, OutputFile};
use pushlab::Listener;
use pyo3::{Bound, PyAny, PyResult, Python, pyclass, pymethods};

use crate::array::shaped;
use crate::failure::{PushlabError, refused};
use crate::interruptible::interruptible;
use crate::steps::Steps;

/// Steps that are predicted between two looks at whether anyone still wants them.
const BLOCK: usize = 4096;

/// Numbers of rows, means and covariances.
type Predicted<'py> =
    (Bound<'py, PyArray<i64, Ix1>>, Bound<'py, PyArray<f64, Ix2>>, Bound<'py, PyArray<f64, Ix3>>);

/// A pushing model with its name.
#[pyclass(frozen, module = "pushlab._native")]
pub(crate) struct Model(Arc<ModelFile>);

#[pymethods]
impl Model {
    #[staticmethod]
    fn read(path: PathBuf) -> PyResult<Self> {
        Ok(Self(Arc::new(ModelFile::read(&path).map_err(refused)?)))
    }

    #[getter]
    fn name(&self) -> &str {
        &self.0.name
    }

    #[getter]
    fn effects(&self) -> Vec<&str> {
        self.0.description.effects.iter().map(|effect| effect.id.as_str()).collect()
    }

    /// The pushes that it was fitted to, and those kept from every fit; none for a model that was not.
    #[getter]
    fn split(&self) -> Option<(Vec<String>, Vec<String>)> {
        self.0.split.as_ref().map(|split| (split.fit.clone(), split.confirm.clone()))
    }

    /// Writes the model, and its weights beside it.
    fn write(&self, path: PathBuf, replace: bool) -> PyResult<()> {
        let existing = if replace { Existing::Replace } else { Existing::Refuse };
        let output = OutputFile::new(&path, existing).map_err(refused)?;
        self.0.write_to(output).map_err(refused)
    }

    /// Rows that are steps in contact, N; means, N×3; covariances, N×3×3.
    #[pyo3(signature = (steps, *, noise, tell=None))]
    fn predict<'py>(
        &self,
        py: Python<'py>,
        steps: &Steps,
        noise: bool,
        tell: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Predicted<'py>> {
        let Some(rig) = steps.rig.clone() else {
            return Err(PushlabError::new_err(
                "a table does not tell what was pushed, by what and on what: read it with \
                 manifest=\"dataset.toml\" of its set",
            ));
        };
        let (file, table) = (self.0.clone(), steps.table.clone());
        let noise = if noise { Noise::Included } else { Noise::Excluded };
        let work = move |teller: Arc<dyn Listener>| -> Result<_, ModelError> {
            let selection = StepSelection::default();
            let found = selection.channel_steps(&table, &rig.object, rig.pusher_radius)?;
            let model = file.description.build_in(rig.support, &[])?;
            let mut predicted = Vec::with_capacity(found.steps.len());
            for block in found.steps.chunks(BLOCK) {
                if teller.is_stopped() {
                    break;
                }
                let inputs = StepInput::all_of(block.iter().map(|step| &step.input))?;
                predicted.extend(model.predict(&inputs, noise)?);
                teller.progress("steps predicted:", predicted.len(), found.steps.len());
            }
            Ok((found.rows, predicted))
        };
        let predicted = interruptible(py, tell, work)?;
        let (rows, predicted) = predicted.map_err(refused)?;
        let rows: Vec<i64> = rows.into_iter().map(|row| row as i64).collect();
        let n = predicted.len();
        let mean = |one: &StepPrediction| [one.mean.x, one.mean.y, one.mean.z];
        let means = predicted.iter().flat_map(mean).collect();
        // Symmetric: the order of rows and columns does not matter.
        let covariances = predicted.iter().flat_map(|one| one.covariance.iter().copied()).collect();
        Ok((rows.into_pyarray(py), shaped(py, means, [n, 3])?, shaped(py, covariances, [n, 3, 3])?))
    }
}
