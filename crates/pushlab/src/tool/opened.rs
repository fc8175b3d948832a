//! The one way to open what a command is about: recordings, a step table of ours, or one of others.

use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use dataset::{
    DatasetError, MANIFEST_NAME, Manifest, ObjectSpec, Preset, RecordingSet, Table, TableMapping,
    all_formats, find_recordings, is_end_points, read_text,
};
use diagnosis::Observations;

use crate::tool::known::Known;
use crate::tool::origin::{Input, readable};
use crate::tool::rig::Rig;
use crate::tool::wrong_usage::WrongUsage;

/// An input as it was recognized.
pub(crate) enum Opened {
    /// Recordings, found but not yet read.
    Recordings(Box<RecordingSet>),
    /// A step table, read.
    Table(Box<OpenedTable>),
}

/// A step table with what says what it is of.
pub(crate) struct OpenedTable {
    pub(crate) table: Table,
    pub(crate) about: About,
    /// The table's file, and the one that says what it is of.
    pub(crate) inputs: Vec<Input>,
    /// Whether a mapping made our columns from those of others.
    pub(crate) is_converted: bool,
}

/// What says what a table is of.
pub(crate) enum About {
    Manifest(Box<Manifest>),
    Mapping(Box<TableMapping>),
}

impl About {
    /// Reads a manifest, or a mapping.
    fn read(path: &Path) -> Result<Self, DatasetError> {
        Ok(match is_mapping(path) {
            true => Self::Mapping(Box::new(TableMapping::read(path)?)),
            false => Self::Manifest(Box::new(Manifest::read(path)?)),
        })
    }

    pub(crate) fn rig(&self) -> Rig {
        match self {
            Self::Manifest(manifest) => Rig::from(manifest.as_ref()),
            Self::Mapping(mapping) => Rig::from(mapping.as_ref()),
        }
    }

    /// The steps of a table of this.
    ///
    /// # Errors
    /// As [`Observations::of`] and [`Observations::of_mapped`].
    pub(crate) fn observations(&self, table: &Table) -> Result<Observations> {
        Ok(match self {
            Self::Manifest(manifest) => Observations::of(table, manifest)?,
            Self::Mapping(mapping) => Observations::of_mapped(table, mapping)?,
        })
    }
}

/// What a path names.
enum Named {
    Set,
    Table(PathBuf),
    /// The mapping of a table, without the table.
    Mapping,
}

/// What a path names, by the options and by what is there.
fn named(path: &Path, known: &Known) -> Result<Named> {
    let is_folder = readable(path)?.is_dir();
    let is_table = known.mapping.is_some() || known.preset == Some(Preset::MitTable);
    let has_ending = |endings: &[&str]| {
        path.extension().and_then(|own| own.to_str()).is_some_and(|own| endings.contains(&own))
    };
    if is_folder {
        let inside = path.join("table.csv");
        return match is_table || is_mapping(&path.join(MANIFEST_NAME)) {
            true if inside.is_file() => Ok(Named::Table(inside)),
            true => match &tables(path)[..] {
                [only] => Ok(Named::Table(only.clone())),
                several => bail!(
                    "{} is a folder with {} tables; name the one that the mapping is for",
                    path.display(),
                    several.len()
                ),
            },
            false => match lone_table(path).filter(|_| known.preset.is_none()) {
                Some(table) => bail!(
                    "{} holds tables and no recordings; name one, such as {}",
                    path.display(),
                    table.display()
                ),
                None => Ok(Named::Set),
            },
        };
    }
    if is_table || !is_end_points(path) && has_ending(&["csv", "parquet"]) {
        return Ok(Named::Table(path.to_owned()));
    }
    if is_mapping(path) {
        return Ok(Named::Mapping);
    }
    let is_recording = || all_formats().iter().any(|format| format.find(path).is_ok());
    if known.preset.is_none() && !is_end_points(path) && !has_ending(&["toml"]) {
        match is_recording() {
            true => bail!(
                "{} is one recording; give the folder that has its {MANIFEST_NAME}, which `pushlab \
                 init` writes",
                path.display()
            ),
            false => bail!(
                "{} is no recording set (a folder with {MANIFEST_NAME}) and no step table (.csv, \
                 .parquet)",
                path.display()
            ),
        }
    }
    Ok(Named::Set)
}

/// Opens recordings or a table.
///
/// # Errors
/// If it is neither, if what says what was pushed is missing or wrong, or if options do not go together.
pub(crate) fn open(path: &Path, known: &Known) -> Result<Opened> {
    match named(path, known)? {
        Named::Table(table) => Ok(Opened::Table(Box::new(open_table(&table, known)?))),
        Named::Mapping => bail!(
            "{path} says how a table of others is read; give the table, with --mapping {path}",
            path = path.display()
        ),
        Named::Set if known.manifest.is_some() => {
            bail!(WrongUsage("--manifest and --mapping are for tables; a set has its own"))
        }
        Named::Set => Ok(Opened::Recordings(Box::new(open_set(path, known)?))),
    }
}

/// What an input says of its rig, with where that stands; recordings are not looked for where a manifest
/// tells it.
///
/// # Errors
/// As [`open`].
pub(crate) fn open_rig(path: &Path, known: &Known) -> Result<(Rig, Vec<Input>, String)> {
    let stated = |path: &Path| -> Result<(Rig, Vec<Input>, String)> {
        let about = About::read(path)?;
        Ok((about.rig(), vec![Input::file(path)?], path.display().to_string()))
    };
    let of_preset = |preset: Preset| format!("preset {}", preset.name());
    match (named(path, known)?, known.preset) {
        (Named::Mapping, _) => stated(path),
        (Named::Set, None) if !is_end_points(path) && known.manifest.is_none() => {
            let manifest = if path.is_dir() { path.join(MANIFEST_NAME) } else { path.to_owned() };
            readable(&manifest)?;
            stated(&manifest)
        }
        (_, preset) => Ok(match open(path, known)? {
            Opened::Recordings(set) => {
                let source = preset.map_or_else(|| set.dir().display().to_string(), of_preset);
                (Rig::from(set.manifest()), Vec::new(), source)
            }
            Opened::Table(opened) => {
                let of_file = || opened.inputs.last().map(|input| input.path.display().to_string());
                let source = preset.map(of_preset).or_else(of_file).unwrap_or_default();
                // The rows decide nothing of it.
                let inputs = opened.inputs.iter().skip(1).cloned().collect();
                (opened.about.rig(), inputs, source)
            }
        }),
    }
}

/// A set by its manifest or a preset, about one shape where that is named.
fn open_set(path: &Path, known: &Known) -> Result<RecordingSet> {
    let set = match known.preset {
        Some(preset) => RecordingSet::open_with_preset(path, preset)?,
        None if is_end_points(path) => bail!(
            "{} has poses before and after pushes, and does not tell what was pushed: give --preset, \
             or the folder of a {MANIFEST_NAME} with format = \"endpoints\" in [recordings]",
            path.display()
        ),
        None => RecordingSet::open(path)?,
    };
    match &known.shape {
        Some(shape) => Ok(set.about(ObjectSpec::mit(shape)?)?),
        None => Ok(set),
    }
}

fn open_table(path: &Path, known: &Known) -> Result<OpenedTable> {
    match (&known.mapping, known.preset) {
        (Some(mapping), _) => converted(path, TableMapping::read(mapping)?, Some(mapping)),
        (None, Some(Preset::MitTable)) => converted(path, TableMapping::mit_table()?, None),
        (None, preset) => ours(path, known.manifest.as_deref(), preset),
    }
}

/// A table of others; or one that the mapping has converted before, of which it still tells the rig.
fn converted(path: &Path, mapping: TableMapping, from: Option<&PathBuf>) -> Result<OpenedTable> {
    let is_parquet = path.extension().is_some_and(|ending| ending == "parquet");
    let own = |error: DatasetError| match error {
        DatasetError::ColumnMissing { .. } => Table::read(path).map_err(|_| error),
        other => Err(other),
    };
    let (table, is_converted) = match is_parquet {
        true => {
            let read = Table::read(path).with_context(|| {
                format!("tables of others are read as CSV; write {} as CSV", path.display())
            });
            (read?, false)
        }
        false => match mapping.read_table(path) {
            Ok(table) => (table, true),
            Err(error) => (own(error)?, false),
        },
    };
    let files = std::iter::once(path).chain(from.map(PathBuf::as_path));
    let inputs = files.map(Input::file).collect::<Result<_>>()?;
    Ok(OpenedTable { table, about: About::Mapping(Box::new(mapping)), inputs, is_converted })
}

/// A table of `pushlab ingest`, or one whose mapping lies beside it.
fn ours(path: &Path, manifest: Option<&Path>, preset: Option<Preset>) -> Result<OpenedTable> {
    let beside = path.with_file_name(MANIFEST_NAME);
    let table = match Table::read(path) {
        Err(error @ DatasetError::ColumnMissing { .. }) => {
            if manifest.is_none() && preset.is_none() && is_mapping(&beside) {
                return converted(path, TableMapping::read(&beside)?, Some(&beside));
            }
            return Err(error).with_context(|| {
                format!(
                    "{} is not a table of `pushlab ingest`, and needs a mapping of its columns: give \
                     --preset mit-table, or --mapping FILE (`pushlab init . --preset mit-table -o \
                     mapping.toml` writes one to start from)",
                    path.display()
                )
            });
        }
        table => table?,
    };
    if let Some(known) = preset.and_then(Preset::manifest) {
        let (about, inputs) = (About::Manifest(Box::new(known?)), vec![Input::file(path)?]);
        return Ok(OpenedTable { table, about, inputs, is_converted: false });
    }
    let stated = manifest.unwrap_or(&beside);
    let about = About::read(stated).with_context(|| {
        format!(
            "a table does not tell what was pushed (outline and mass), by what (radius and friction \
             of the tip) and on what (friction of the table); give its set's manifest with \
             --manifest, or put it beside {}",
            path.display()
        )
    })?;
    let inputs = [path, stated].into_iter().map(Input::file).collect::<Result<_>>()?;
    Ok(OpenedTable { table, about, inputs, is_converted: false })
}

/// Whether a file is the mapping of a table, right or wrong.
fn is_mapping(path: &Path) -> bool {
    let says_so = |line: &str| {
        let line = line.trim_start();
        line.starts_with("schema") && line.contains("pushlab.table-mapping/")
    };
    let is_toml = path.extension().is_some_and(|ending| ending == "toml");
    is_toml && path.is_file() && read_text(path).is_ok_and(|text| text.lines().any(says_so))
}

/// A table in a folder that has neither a manifest nor recordings.
fn lone_table(dir: &Path) -> Option<PathBuf> {
    if dir.join(MANIFEST_NAME).exists() || find_recordings(dir).is_ok() {
        return None;
    }
    tables(dir).into_iter().next()
}

/// The tables in a folder, by name.
fn tables(dir: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(dir).into_iter().flatten();
    let files = entries.filter_map(|entry| Some(entry.ok()?.path()));
    let is_table = |path: &PathBuf| {
        path.extension().is_some_and(|ending| ending == "csv" || ending == "parquet")
    };
    let mut found: Vec<_> = files.filter(is_table).collect();
    found.sort();
    found
}
