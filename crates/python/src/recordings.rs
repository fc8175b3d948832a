//! A recording set, found but not yet read.

use std::path::PathBuf;

use dataset::{ObjectSpec, Preset};
use pyo3::{PyResult, pyclass, pymethods};

use crate::failure::{PushlabError, refused};

/// The preset of a name.
///
/// # Errors
/// `PushlabError` with those that there are.
pub(crate) fn preset_by_name(name: &str) -> PyResult<Preset> {
    Preset::by_name(name).ok_or_else(|| {
        let known = Preset::ALL.map(Preset::name).join(", ");
        PushlabError::new_err(format!("there is no preset `{name}`; there are {known}"))
    })
}

/// Recordings with what says of which rig they are.
#[pyclass(frozen, module = "pushlab._native")]
pub(crate) struct RecordingSet(dataset::RecordingSet);

#[pymethods]
impl RecordingSet {
    #[new]
    fn open(path: PathBuf, preset: Option<&str>, shape: Option<&str>) -> PyResult<Self> {
        let set = match preset.map(preset_by_name).transpose()? {
            Some(preset) => dataset::RecordingSet::open_with_preset(&path, preset),
            None => dataset::RecordingSet::open(&path),
        };
        let set = set.map_err(refused)?;
        let set = match shape {
            Some(shape) => set.about(ObjectSpec::mit(shape).map_err(refused)?).map_err(refused)?,
            None => set,
        };
        Ok(Self(set))
    }

    #[getter]
    fn name(&self) -> &str {
        &self.0.manifest().name
    }

    #[getter]
    fn format(&self) -> &'static str {
        self.0.format().id()
    }

    #[getter]
    fn folder(&self) -> PathBuf {
        self.0.dir().to_owned()
    }

    #[getter]
    fn recordings(&self) -> Vec<PathBuf> {
        self.0.recordings().to_vec()
    }

    #[getter]
    fn remarks(&self) -> Vec<String> {
        self.0.remarks().iter().map(|remark| remark.text.clone()).collect()
    }
}
