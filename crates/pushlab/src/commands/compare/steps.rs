//! The steps that are compared: of a recording set, or of a step table.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use dataset::{
    DatasetError, IngestSettings, MANIFEST_NAME, Manifest, Preset, RecordingSet, Table,
    TableMapping,
};
use diagnosis::Observations;

use super::Args;
use crate::failure::WrongUsage;
use crate::origin::{Input, readable};
use crate::recorded_steps::RecordedSteps;
use crate::step_size::StepSize;
use crate::terminal::Terminal;

/// Observed steps, with what was read for them.
pub(super) struct Steps {
    pub(super) observations: Observations,
    pub(super) inputs: Vec<Input>,
}

impl Steps {
    /// Reads what the arguments name.
    ///
    /// # Errors
    /// If it cannot be read, or a table lacks what says what was pushed.
    pub(super) fn read(args: &Args, terminal: &Terminal) -> Result<Self> {
        let set = &args.set;
        let is_folder = readable(set)?.is_dir();
        if is_folder && args.preset != Some(Preset::MitTable) {
            return Self::recorded(args, terminal);
        }
        if args.step.is_some() {
            bail!(WrongUsage("--step is for recordings; the steps of a table are made"));
        }
        let inside = set.join("table.csv");
        let table = if is_folder { &inside } else { set };
        match (&args.mapping, args.preset) {
            (Some(mapping), _) => Self::mapped(table, &TableMapping::read(mapping)?, Some(mapping)),
            (None, Some(Preset::MitTable)) => {
                Self::mapped(table, &TableMapping::mit_table()?, None)
            }
            (None, Some(_)) => bail!(WrongUsage("this preset is for recordings, not for a table")),
            (None, None) => Self::tabled(table, args.manifest.as_deref()),
        }
    }

    fn recorded(args: &Args, terminal: &Terminal) -> Result<Self> {
        if args.manifest.is_some() || args.mapping.is_some() {
            bail!(WrongUsage("--manifest and --mapping are for tables; a set has its own"));
        }
        let set = match args.preset {
            Some(preset) => RecordingSet::open_with_preset(&args.set, preset)?,
            None => RecordingSet::open(&args.set)?,
        };
        let mut settings = IngestSettings::default();
        if let Some(StepSize(step)) = args.step {
            settings.step = step;
        }
        let RecordedSteps { table, inputs, .. } = RecordedSteps::read(&set, &settings, terminal)?;
        Ok(Self { observations: Observations::of(&table, set.manifest())?, inputs })
    }

    /// A table of others.
    fn mapped(path: &Path, mapping: &TableMapping, from: Option<&PathBuf>) -> Result<Self> {
        let table = mapping.read_table(path)?;
        let files = std::iter::once(path).chain(from.map(PathBuf::as_path));
        let inputs = files.map(Input::file).collect::<Result<_>>()?;
        Ok(Self { observations: Observations::of_mapped(&table, mapping)?, inputs })
    }

    /// A table of `pushlab ingest`, or one whose mapping lies beside it.
    fn tabled(path: &Path, manifest: Option<&Path>) -> Result<Self> {
        let beside = path.with_file_name(MANIFEST_NAME);
        let table = match Table::read(path) {
            Err(DatasetError::ColumnMissing { .. }) if manifest.is_none() => {
                let mapping = TableMapping::read(&beside).with_context(|| {
                    format!(
                        "{} is not a table of `pushlab ingest`; give --preset mit-table, or \
                         --mapping FILE for its columns",
                        path.display()
                    )
                })?;
                return Self::mapped(path, &mapping, Some(&beside));
            }
            table => table?,
        };
        let manifest_path = manifest.unwrap_or(&beside);
        let manifest = Manifest::read(manifest_path).with_context(|| {
            format!(
                "a table does not tell what was pushed; give its set's manifest with --manifest, \
                 or put it beside {}",
                path.display()
            )
        })?;
        let inputs = [path, manifest_path].into_iter().map(Input::file).collect::<Result<_>>()?;
        Ok(Self { observations: Observations::of(&table, &manifest)?, inputs })
    }
}
