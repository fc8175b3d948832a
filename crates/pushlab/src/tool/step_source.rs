//! Where observed steps are read from: a recording set, or a step table.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use dataset::{IngestSettings, MANIFEST_NAME, Manifest, Part, RecordingSet, Suspicion, Table};
use diagnosis::{Observations, steady_ingest, step_suspicions};

use crate::tool::destination::Inputs;
use crate::tool::known::Known;
use crate::tool::opened::{Opened, OpenedTable, open};
use crate::tool::origin::Input;
use crate::tool::recorded_steps::RecordedSteps;
use crate::tool::rig::Rig;
use crate::tool::step_kind::StepKind;
use crate::tool::step_size::StepSize;
use crate::tool::suspected::{refuse, suspected, warn};
use crate::tool::terminal::Terminal;
use crate::tool::wrong_usage::WrongUsage;

/// What names a set or a table.
#[derive(clap::Args)]
pub(crate) struct StepSource {
    /// Recording set (a folder with dataset.toml), or a step table (.csv, .parquet)
    pub(crate) set: PathBuf,
    #[command(flatten)]
    known: Known,
}

/// How recordings become steps; those of a table are made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Reading {
    /// All steps in contact, of a length.
    Plain(StepSize),
    /// Steps whose noise is known, to look at.
    Look,
    /// Steps whose noise is known, for tests and fits.
    Steady,
}

impl Reading {
    /// Steps to look at: of a length, if one is asked for.
    pub(crate) fn looked_at(step: Option<StepSize>) -> Self {
        step.map_or(Self::Look, Self::Plain)
    }

    /// Tells what contradicts the mechanics, and hands it on.
    ///
    /// # Errors
    /// If that is certain, and tests or fits would follow.
    fn heed(self, suspicions: Vec<Suspicion>, terminal: &Terminal) -> Result<Vec<Suspicion>> {
        match self {
            Self::Plain(_) | Self::Look => warn(&suspicions, terminal),
            Self::Steady => refuse(&suspicions, terminal)?,
        }
        Ok(suspicions)
    }
}

/// Observed steps, with what was read for them.
pub(crate) struct Steps {
    /// What the input says of object, pusher and table.
    pub(crate) rig: Rig,
    pub(crate) observations: Observations,
    /// What a step is.
    pub(crate) kind: StepKind,
    /// All steps in contact, where those observed are some of them: near vertices, too.
    pub(crate) in_contact: Option<Observations>,
    pub(crate) inputs: Vec<Input>,
    /// Pushes of the recordings; none of a table.
    pub(crate) n_pushes: Option<usize>,
    /// What of them may be wrong.
    pub(crate) suspicions: Vec<Suspicion>,
    /// From the first step to the end of the last, in s, where the rows tell.
    pub(crate) duration: Option<f64>,
}

impl StepSource {
    /// Reads what is named.
    ///
    /// # Errors
    /// If it cannot be read, a table lacks what says what was pushed, or recordings for tests and
    /// fits contradict the mechanics; of others a warning tells that.
    pub(crate) fn read(&self, reading: Reading, terminal: &Terminal) -> Result<Steps> {
        self.read_part(reading, None, terminal)
    }

    /// Reads a part of a set, or a table that is one.
    ///
    /// # Errors
    /// As [`StepSource::read`].
    pub(crate) fn read_part(
        &self,
        reading: Reading,
        part: Option<Part>,
        terminal: &Terminal,
    ) -> Result<Steps> {
        match (self.open()?, part) {
            (Opened::Recordings(set), Some(part)) => {
                recorded(&set.in_part(part), reading, terminal)
            }
            (Opened::Recordings(set), None) => recorded(&set, reading, terminal),
            (Opened::Table(opened), _) => tabled(*opened, reading, terminal),
        }
    }

    /// Opens what is named, for a command that asks for more than steps.
    ///
    /// # Errors
    /// As [`open`].
    pub(crate) fn open(&self) -> Result<Opened> {
        open(&self.set, &self.known)
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
    pub(crate) fn manifest(&self) -> Option<PathBuf> {
        let own = match self.set.is_dir() {
            true => self.set.join(MANIFEST_NAME),
            false if self.set.ends_with(MANIFEST_NAME) => self.set.clone(),
            false => self.set.with_file_name(MANIFEST_NAME),
        };
        let path = self.known.manifest.clone().unwrap_or(own);
        (self.known.preset.is_none() && Manifest::read(&path).is_ok()).then_some(path)
    }
}

fn recorded(set: &RecordingSet, reading: Reading, terminal: &Terminal) -> Result<Steps> {
    if set.is_of_end_points() && matches!(reading, Reading::Plain(_)) {
        bail!(WrongUsage("--step is for recordings; a push of which the ends are known is one"));
    }
    let suspicions = reading.heed(suspected(set), terminal)?;
    let settings = match reading {
        Reading::Steady | Reading::Look => steady_ingest(),
        Reading::Plain(StepSize(step)) => IngestSettings { step, ..IngestSettings::default() },
    };
    let RecordedSteps { table, inputs, n_pushes } = RecordedSteps::read(set, &settings, terminal)?;
    let in_contact = Observations::of(&table, set.manifest())?;
    let (observations, in_contact) = match reading {
        Reading::Plain(_) => (in_contact, None),
        Reading::Steady | Reading::Look => {
            (Observations::steady(&table, set.manifest())?, Some(in_contact))
        }
    };
    let kind = match reading {
        _ if set.is_of_end_points() => StepKind::WholePush,
        Reading::Plain(step) => StepKind::Length(step),
        Reading::Steady | Reading::Look => StepKind::Steady,
    };
    let (rig, n_pushes, duration) = (Rig::from(set.manifest()), Some(n_pushes), duration(&table));
    Ok(Steps { rig, observations, kind, in_contact, inputs, n_pushes, suspicions, duration })
}

fn tabled(opened: OpenedTable, reading: Reading, terminal: &Terminal) -> Result<Steps> {
    let OpenedTable { table, about, inputs, .. } = opened;
    if matches!(reading, Reading::Plain(_)) {
        bail!(WrongUsage("--step is for recordings; the steps of a table are made"));
    }
    let (rig, observations) = (about.rig(), about.observations(&table)?);
    let found = step_suspicions(&observations, rig.pusher.friction)?;
    let suspicions = reading.heed(found, terminal)?;
    let duration = duration(&table);
    let (kind, in_contact, n_pushes) = (StepKind::OfTable, None, None);
    Ok(Steps { rig, observations, kind, in_contact, inputs, n_pushes, suspicions, duration })
}

/// From the first step of a table to the end of the last, in s; none where all are at one time, which then
/// was not known.
fn duration(table: &Table) -> Option<f64> {
    let times = || table.rows.iter().map(|row| row.t);
    let (start, last) = (times().reduce(f64::min)?, times().reduce(f64::max)?);
    let end = table.rows.iter().map(|row| row.t + row.dt).fold(start, f64::max);
    (last > start).then_some(end - start)
}
