//! A step table, and what it is of.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use dataset::{
    Cells, Manifest, ObjectChoice, ObjectSpec, SupportSpec, Table, TableMapping, columns,
};
use numpy::{IntoPyArray, PyReadonlyArray1};
use pyo3::{Bound, IntoPyObjectExt, PyAny, PyResult, Python, pyclass, pymethods};

use crate::failure::{PushlabError, refused};
use crate::recordings::preset_by_name;

/// What of the rig a model has to know.
#[derive(Clone)]
pub(crate) struct Rig {
    pub(crate) object: ObjectChoice,
    pub(crate) pusher_radius: f64,
    pub(crate) support: SupportSpec,
}

/// Rows of a table in memory.
#[pyclass(frozen, module = "pushlab._native")]
pub(crate) struct Steps {
    pub(crate) table: Arc<Table>,
    pub(crate) rig: Option<Rig>,
}

#[pymethods]
impl Steps {
    /// Reads a table; one of a manifest, a mapping and a preset says what it is of.
    #[staticmethod]
    #[pyo3(signature = (path, *, manifest=None, mapping=None, preset=None, shape=None))]
    fn read(
        py: Python<'_>,
        path: PathBuf,
        manifest: Option<PathBuf>,
        mapping: Option<PathBuf>,
        preset: Option<&str>,
        shape: Option<&str>,
    ) -> PyResult<Self> {
        let table = py.detach(|| Table::read(&path)).map_err(refused)?;
        let mut rig = match (mapping, manifest, preset) {
            (Some(mapping), ..) => Some(of_mapping(TableMapping::read(&mapping).map_err(refused)?)),
            (_, Some(manifest), _) => {
                Some(of_manifest(Manifest::read(&manifest).map_err(refused)?))
            }
            (.., Some("mit-table")) => {
                Some(of_mapping(TableMapping::mit_table().map_err(refused)?))
            }
            (.., Some(preset)) => {
                let manifest = preset_by_name(preset)?.manifest().transpose();
                manifest.map_err(refused)?.map(of_manifest)
            }
            _ => None,
        };
        if let (Some(rig), Some(shape)) = (&mut rig, shape) {
            rig.object = ObjectChoice::Fixed(Box::new(ObjectSpec::mit(shape).map_err(refused)?));
        }
        Ok(Self { table: Arc::new(table), rig })
    }

    fn __len__(&self) -> usize {
        self.table.len()
    }

    /// Name, unit and meaning of each column.
    #[getter]
    fn columns(&self) -> Vec<(&'static str, &'static str, &'static str)> {
        self.table.columns().map(|column| (column.name, column.unit, column.meaning)).collect()
    }

    /// An array of numbers (NaN where none was measured), or of text its codes and the words they stand for.
    fn column<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyAny>> {
        let Some(column) = columns().iter().find(|column| column.name == name) else {
            let names: Vec<_> = self.table.columns().map(|column| column.name).collect();
            let text = format!("there is no column `{name}`; there are {}", names.join(", "));
            return Err(PushlabError::new_err(text));
        };
        match py.detach(|| column.cells(&self.table.rows)) {
            Cells::Real(cells) => {
                let numbers: Vec<f64> =
                    cells.into_iter().map(|cell| cell.unwrap_or(f64::NAN)).collect();
                Ok(numbers.into_pyarray(py).into_any())
            }
            Cells::Integer(cells) => Ok(cells.into_pyarray(py).into_any()),
            Cells::Text(cells) => {
                let (codes, words) = coded(cells);
                (codes.into_pyarray(py), words).into_bound_py_any(py)
            }
        }
    }

    /// Some of the rows, by their numbers from 0.
    fn select(&self, rows: PyReadonlyArray1<'_, i64>) -> PyResult<Self> {
        let row = |index: &i64| {
            let row = usize::try_from(*index).ok().and_then(|index| self.table.rows.get(index));
            row.cloned().ok_or_else(|| {
                let n = self.table.len();
                let text = format!("there is no row {index}: the table has {n}, numbered from 0");
                PushlabError::new_err(text)
            })
        };
        let rows = rows.as_array().iter().map(row).collect::<PyResult<_>>()?;
        let provenance = self.table.provenance.clone();
        Ok(Self { table: Arc::new(Table { rows, provenance }), rig: self.rig.clone() })
    }

    /// What made the rows: pairs of key and value.
    #[getter]
    fn provenance(&self) -> Vec<(String, String)> {
        self.table.provenance.entries.clone()
    }

    /// Writes a .csv or .parquet file, in place of one that is there.
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        py.detach(|| self.table.write(&path)).map_err(refused)
    }
}

fn of_manifest(manifest: Manifest) -> Rig {
    let Manifest { object, pusher, support, .. } = manifest;
    Rig { object, pusher_radius: pusher.radius, support }
}

fn of_mapping(mapping: TableMapping) -> Rig {
    let TableMapping { object, pusher, support, .. } = mapping;
    Rig { object: ObjectChoice::Fixed(Box::new(object)), pusher_radius: pusher.radius, support }
}

/// Words by number, in the order of their first use.
fn coded(cells: Vec<String>) -> (Vec<i32>, Vec<String>) {
    let mut known: HashMap<String, i32> = HashMap::new();
    let mut words = Vec::new();
    let code = |cell: String| {
        if let Some(code) = known.get(&cell) {
            return *code;
        }
        let code = words.len() as i32;
        words.push(cell.clone());
        known.insert(cell, code);
        code
    };
    (cells.into_iter().map(code).collect(), words)
}
