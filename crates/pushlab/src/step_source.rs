//! Where observed steps are read from: a recording set, or a step table.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use clap::builder::PossibleValuesParser;
use dataset::{
    DatasetError, IngestSettings, MANIFEST_NAME, Manifest, ObjectSpec, Preset, PusherSpec,
    RecordingSet, Suspicion, Table, TableMapping, is_end_points,
};
use diagnosis::{Observations, steady_ingest, step_suspicions};
use planar::MIT_NAMES;

use crate::command_line::preset_parser;
use crate::destination::Inputs;
use crate::origin::{Input, readable};
use crate::recorded_steps::RecordedSteps;
use crate::step_size::StepSize;
use crate::suspected::{refuse, suspected, warn};
use crate::terminal::Terminal;
use crate::wrong_usage::WrongUsage;

/// What names a set or a table.
#[derive(clap::Args)]
pub(crate) struct StepSource {
    /// Recording set (a folder with dataset.toml), or a step table (.csv, .parquet)
    pub(crate) set: PathBuf,
    #[command(flatten)]
    known: Known,
}

/// What is known of a set or a table beside what it says itself.
#[derive(Clone, Default, clap::Args)]
pub(crate) struct Known {
    /// Manifest that says what a step table does not: the object, the pusher and the table that it is of;
    /// else dataset.toml beside it
    #[arg(long, value_name = "FILE")]
    manifest: Option<PathBuf>,
    /// What is known of public data, for recordings or a table of others
    #[arg(long, value_name = "NAME", value_parser = preset_parser())]
    preset: Option<Preset>,
    /// Of public data about several shapes, the pushes of this one alone
    #[arg(long, value_name = "NAME", value_parser = PossibleValuesParser::new(MIT_NAMES),
          requires = "preset")]
    shape: Option<String>,
    /// How the columns of a table of others become ours
    #[arg(long, value_name = "FILE", conflicts_with = "preset")]
    mapping: Option<PathBuf>,
}

impl Known {
    /// The options as typed.
    pub(crate) fn words(&self) -> Vec<String> {
        let path = |path: &Path| path.display().to_string();
        let mut words = Vec::new();
        let mut option = |name: &str, value: Option<String>| {
            words.extend(value.into_iter().flat_map(|value| [format!("--{name}"), value]));
        };
        option("manifest", self.manifest.as_deref().map(path));
        option("preset", self.preset.map(|preset| preset.name().to_owned()));
        option("shape", self.shape.clone());
        option("mapping", self.mapping.as_deref().map(path));
        words
    }

    /// What is known, or what was known when a command with these words read the same.
    pub(crate) fn or_of(self, words: &[String]) -> Self {
        let after = |name: &str| {
            let pair = words.windows(2).find(|pair| pair[0] == format!("--{name}"))?;
            Some(pair[1].clone())
        };
        if self.manifest.is_some() || self.preset.is_some() || self.mapping.is_some() {
            return self;
        }
        Self {
            manifest: after("manifest").map(PathBuf::from),
            preset: after("preset").and_then(|name| Preset::by_name(&name)),
            shape: after("shape"),
            mapping: after("mapping").map(PathBuf::from),
        }
    }
}

/// How recordings become steps; those of a table are made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Reading {
    /// All steps in contact, of a length.
    Plain(Option<StepSize>),
    /// Steps whose noise is known, for tests and fits.
    Steady,
}

impl Reading {
    /// Tells what contradicts the mechanics, and hands it on.
    ///
    /// # Errors
    /// If that is certain, and tests or fits would follow.
    fn heed(self, suspicions: Vec<Suspicion>, terminal: &Terminal) -> Result<Vec<Suspicion>> {
        match self {
            Self::Plain(_) => warn(&suspicions, terminal),
            Self::Steady => refuse(&suspicions, terminal)?,
        }
        Ok(suspicions)
    }
}

/// Observed steps, with what was read for them.
pub(crate) struct Steps {
    /// Of the set, in its manifest.
    pub(crate) name: String,
    pub(crate) observations: Observations,
    pub(crate) inputs: Vec<Input>,
    /// Pushes of the recordings; none of a table.
    pub(crate) n_pushes: Option<usize>,
    /// What of them may be wrong.
    pub(crate) suspicions: Vec<Suspicion>,
}

impl StepSource {
    /// Reads what is named.
    ///
    /// # Errors
    /// If it cannot be read, a table lacks what says what was pushed, or recordings for tests and
    /// fits contradict the mechanics; of others a warning tells that.
    pub(crate) fn read(&self, reading: Reading, terminal: &Terminal) -> Result<Steps> {
        let set = &self.set;
        let is_folder = readable(set)?.is_dir();
        let is_table = self.known.preset == Some(Preset::MitTable);
        if !is_table && (is_folder || is_end_points(set)) {
            return self.recorded(reading, terminal);
        }
        if matches!(reading, Reading::Plain(Some(_))) {
            bail!(WrongUsage("--step is for recordings; the steps of a table are made"));
        }
        let inside = set.join("table.csv");
        let table = if is_folder { &inside } else { set };
        let (mut steps, pusher) = match (&self.known.mapping, self.known.preset) {
            (Some(mapping), _) => {
                Steps::mapped(table, &TableMapping::read(mapping)?, Some(mapping))?
            }
            (None, Some(Preset::MitTable)) => {
                Steps::mapped(table, &TableMapping::mit_table()?, None)?
            }
            (None, known) => Steps::tabled(table, self.known.manifest.as_deref(), known)?,
        };
        let found = step_suspicions(&steps.observations, pusher.friction)?;
        steps.suspicions = reading.heed(found, terminal)?;
        Ok(steps)
    }

    /// A set or table of which this is known.
    pub(crate) fn of(set: &Path, known: Known) -> Self {
        Self { set: set.to_owned(), known }
    }

    /// The paths that are read.
    pub(crate) fn inputs(&self) -> Inputs {
        let files = self.known.manifest.iter().chain(&self.known.mapping);
        Inputs::default().with_set(&self.set, self.known.preset).with(files)
    }

    /// Another set, of which the same is known.
    pub(crate) fn of_same_kind(&self, set: &Path) -> Self {
        Self::of(set, self.known.clone())
    }

    /// The options that decide what is read, as typed.
    pub(crate) fn words(&self) -> Vec<String> {
        self.known.words()
    }

    /// The manifest that tells the object and the rig, where there is one.
    pub(crate) fn rig(&self) -> Option<PathBuf> {
        let own = match self.set.is_dir() {
            true => self.set.join(MANIFEST_NAME),
            false if self.set.ends_with(MANIFEST_NAME) => self.set.clone(),
            false => self.set.with_file_name(MANIFEST_NAME),
        };
        let path = self.known.manifest.clone().unwrap_or(own);
        (self.known.preset.is_none() && Manifest::read(&path).is_ok()).then_some(path)
    }

    fn recorded(&self, reading: Reading, terminal: &Terminal) -> Result<Steps> {
        if self.known.manifest.is_some() || self.known.mapping.is_some() {
            bail!(WrongUsage("--manifest and --mapping are for tables; a set has its own"));
        }
        let set = open_set(&self.set, self.known.preset, self.known.shape.as_deref())?;
        if set.is_of_end_points() && matches!(reading, Reading::Plain(Some(_))) {
            bail!(WrongUsage(
                "--step is for recordings; a push of which the ends are known is one"
            ));
        }
        let suspicions = reading.heed(suspected(&set), terminal)?;
        let settings = match reading {
            Reading::Steady => steady_ingest(),
            Reading::Plain(step) => {
                let usual = IngestSettings::default();
                let step = step.map_or(usual.step, |StepSize(step)| step);
                IngestSettings { step, ..usual }
            }
        };
        let RecordedSteps { table, inputs, n_pushes } =
            RecordedSteps::read(&set, &settings, terminal)?;
        let observations = match reading {
            Reading::Steady => Observations::steady(&table, set.manifest())?,
            Reading::Plain(_) => Observations::of(&table, set.manifest())?,
        };
        let name = set.manifest().name.clone();
        Ok(Steps { name, observations, inputs, n_pushes: Some(n_pushes), suspicions })
    }
}

/// A set by its manifest or a preset, about one shape where that is named.
///
/// # Errors
/// As [`RecordingSet::open`]; for end points without a manifest, what to give.
pub(crate) fn open_set(
    path: &Path,
    preset: Option<Preset>,
    shape: Option<&str>,
) -> Result<RecordingSet> {
    let set = match preset {
        Some(preset) => RecordingSet::open_with_preset(path, preset)?,
        None if is_end_points(path) => bail!(
            "{} has poses before and after pushes, and does not tell what was pushed: give --preset, \
             or the folder of a {MANIFEST_NAME} with format = \"endpoints\" in [recordings]",
            path.display()
        ),
        None => RecordingSet::open(path)?,
    };
    match shape {
        Some(shape) => Ok(set.about(ObjectSpec::mit(shape)?)?),
        None => Ok(set),
    }
}

impl Steps {
    fn of_table(name: &str, observations: Observations, inputs: Vec<Input>) -> Self {
        let (name, suspicions) = (name.to_owned(), Vec::new());
        Self { name, observations, inputs, n_pushes: None, suspicions }
    }

    /// A table of others, and the pusher.
    fn mapped(
        path: &Path,
        mapping: &TableMapping,
        from: Option<&PathBuf>,
    ) -> Result<(Self, PusherSpec)> {
        let table = mapping.read_table(path)?;
        let files = std::iter::once(path).chain(from.map(PathBuf::as_path));
        let inputs = files.map(Input::file).collect::<Result<_>>()?;
        let observations = Observations::of_mapped(&table, mapping)?;
        Ok((Self::of_table(&mapping.name, observations, inputs), mapping.pusher))
    }

    /// A table of `pushlab ingest`, or one whose mapping lies beside it, and the pusher.
    fn tabled(
        path: &Path,
        manifest: Option<&Path>,
        preset: Option<Preset>,
    ) -> Result<(Self, PusherSpec)> {
        let beside = path.with_file_name(MANIFEST_NAME);
        let table = match Table::read(path) {
            Err(DatasetError::ColumnMissing { .. }) if manifest.is_none() && preset.is_none() => {
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
        if let Some(known) = preset.and_then(Preset::manifest) {
            let manifest = known?;
            let observations = Observations::of(&table, &manifest)?;
            let steps = Self::of_table(&manifest.name, observations, vec![Input::file(path)?]);
            return Ok((steps, manifest.pusher));
        }
        let manifest_path = manifest.unwrap_or(&beside);
        let manifest = Manifest::read(manifest_path).with_context(|| {
            format!(
                "a table does not tell what was pushed; give its set's manifest with --manifest, \
                 or put it beside {}",
                path.display()
            )
        })?;
        let inputs = [path, manifest_path].into_iter().map(Input::file).collect::<Result<_>>()?;
        let observations = Observations::of(&table, &manifest)?;
        Ok((Self::of_table(&manifest.name, observations, inputs), manifest.pusher))
    }
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use dataset::Preset;

    use super::Known;

    #[test]
    fn what_was_known_is_found_again_in_the_words_of_the_command() {
        for known in [
            Known { preset: Some(Preset::MitTable), ..Known::default() },
            Known { manifest: Some(PathBuf::from("a set/dataset.toml")), ..Known::default() },
            Known { mapping: Some(PathBuf::from("columns.toml")), ..Known::default() },
        ] {
            let mut words = ["diagnose", "t.csv", "--seed", "7"].map(str::to_owned).to_vec();
            words.extend(known.words());
            assert_eq!(Known::default().or_of(&words).words(), known.words());
            // What is named now counts.
            let now = Known { preset: Some(Preset::MitPush), ..Known::default() };
            assert_eq!(now.clone().or_of(&words).words(), now.words());
        }
        assert!(Known::default().or_of(&["diagnose".to_owned()]).words().is_empty());
    }
}
