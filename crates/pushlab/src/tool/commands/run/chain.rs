//! The phases, one command each: done, or passed over where nothing has changed.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result, bail};
use dataset::{MANIFEST_NAME, RecordingSet};
use models::ModelError;
use serde::Serialize;

use super::Args;
use super::ledger::{Ledger, Record};
use super::manifest::Filled;
use crate::tool::command_line::run_typed;
use crate::tool::destination::{Force, Inputs};
use crate::tool::origin::{Input, plain};
use crate::tool::recorded_steps::SET_FILES;
use crate::tool::step_kind::StepKind;
use crate::tool::terminal::{TITLE, Terminal};

/// Files of the folder, in the order in which they are made.
pub(super) const STEPS: &str = "steps.csv";
pub(super) const MODEL: &str = "model.toml";
pub(super) const COMPARISON: &str = "comparison.json";
pub(super) const DIAGNOSIS: &str = "diagnosis.json";
pub(super) const BETTER: &str = "better.toml";
pub(super) const CHANGE: &str = "comparison-better.json";
pub(super) const PAGE: &str = "report.html";
pub(super) const CALIBRATED: &str = "calibrated.toml";
const OUTPUTS: [&str; 8] = [STEPS, MODEL, COMPARISON, DIAGNOSIS, BETTER, CHANGE, PAGE, CALIBRATED];
/// What each was made from.
const LEDGER: &str = "phases.json";
/// The manifest is the first phase.
const N_PHASES: usize = 1 + OUTPUTS.len();

/// A command that makes one file.
pub(super) struct Phase {
    /// As typed, without what it reads and writes.
    command: &'static str,
    /// Whether it reads the recordings.
    reads_set: bool,
    /// That decide the result.
    options: Vec<String>,
    /// Files of the folder that it reads, by the name of the option.
    reads: Vec<(&'static str, PathBuf)>,
    output: &'static str,
}

impl Phase {
    /// Of a command that reads the recordings.
    pub(super) fn of_set(command: &'static str, output: &'static str) -> Self {
        let (options, reads) = (Vec::new(), Vec::new());
        Self { command, reads_set: true, options, reads, output }
    }

    /// Of one that reads what others made alone.
    pub(super) fn of_files(command: &'static str, output: &'static str) -> Self {
        Self { reads_set: false, ..Self::of_set(command, output) }
    }

    /// The same with options.
    pub(super) fn with<'a>(mut self, options: impl IntoIterator<Item = &'a str>) -> Self {
        self.options.extend(options.into_iter().map(str::to_owned));
        self
    }

    /// The same with a file that it reads.
    pub(super) fn reading(mut self, option: &'static str, path: &Path) -> Self {
        self.reads.push((option, path.to_owned()));
        self
    }

    /// The command with all that decides its result but the files' bytes.
    fn words(&self) -> Vec<String> {
        let options = self.options.iter().cloned();
        let reads = self.reads.iter().map(|(option, path)| {
            let name = path.file_name().map(OsStr::to_string_lossy).unwrap_or_default();
            format!("--{option}={name}")
        });
        self.command.split(' ').map(str::to_owned).chain(options).chain(reads).collect()
    }
}

/// What became of a phase.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum State {
    Done,
    /// Its inputs are as they were, and its output is there.
    Unchanged,
    /// There is nothing to be done.
    Needless,
    /// These recordings do not tell it.
    NotTold,
}

/// A phase that is over.
#[derive(Serialize)]
pub(super) struct Past {
    name: &'static str,
    state: State,
    output: PathBuf,
}

/// How far a run has come.
pub(super) struct Chain<'a> {
    args: &'a Args,
    terminal: &'a Terminal,
    ledger: Ledger,
    /// The recordings and what lies beside them.
    pub(super) set: Vec<Input>,
    /// What a step of them is.
    pub(super) step: StepKind,
    pub(super) past: Vec<Past>,
}

impl<'a> Chain<'a> {
    pub(super) fn new(args: &'a Args, terminal: &'a Terminal) -> Self {
        let ledger = Ledger::read(&args.output.join(LEDGER));
        let (set, step, past) = (Vec::new(), StepKind::Steady, Vec::new());
        Self { args, terminal, ledger, set, step, past }
    }

    /// A file of the folder.
    pub(super) fn path(&self, name: &str) -> PathBuf {
        plain(&self.args.output.join(name))
    }

    pub(super) fn seed(&self) -> u64 {
        self.args.seed
    }

    /// Makes sure that every file can be written, and that what is there came from a run.
    ///
    /// # Errors
    /// If one cannot, or is somebody's own and `--force` is not typed.
    pub(super) fn check_outputs(&self, inputs: &Inputs) -> Result<()> {
        for name in OUTPUTS {
            let path = self.path(name);
            if path.is_file() && !self.args.force && !self.ledger.is_own(&path)? {
                bail!(
                    "cannot write {}: it is there, and not as `pushlab run` wrote it; move it, or \
                     replace it with --force",
                    path.display()
                );
            }
            Force::typed(true).file(&path, inputs)?;
        }
        Force::typed(true).file(&self.path(LEDGER), inputs)?;
        Ok(())
    }

    /// Notes the manifest, and what was recorded.
    ///
    /// # Errors
    /// If the set or one of its files cannot be read.
    pub(super) fn begin(&mut self, manifest: Filled) -> Result<()> {
        let folder = &self.args.folder;
        let state = match manifest {
            Filled::AsItWas => State::Unchanged,
            Filled::Written => State::Done,
        };
        self.pass("init", state, plain(&folder.join(MANIFEST_NAME)));
        let set = RecordingSet::open(folder)?;
        if set.is_of_end_points() {
            self.step = StepKind::WholePush;
        }
        let beside = SET_FILES.map(|name| set.dir().join(name)).into_iter();
        for path in beside.filter(|path| path.exists()).chain(set.recordings().to_vec()) {
            self.set.extend(Input::all(&path)?);
        }
        Ok(())
    }

    /// Runs a phase, unless its output is there and made from the same.
    ///
    /// # Errors
    /// What its command says.
    pub(super) fn go(&mut self, phase: &Phase) -> Result<()> {
        let path = self.path(phase.output);
        let mut inputs = if phase.reads_set { self.set.clone() } else { Vec::new() };
        for (_, path) in &phase.reads {
            inputs.push(Input::file(path)?);
        }
        let record = Record::begun(phase.output, phase.words(), &inputs);
        if !self.args.force && self.ledger.is_done(&path, &record)? {
            self.pass(phase.command, State::Unchanged, path);
            return Ok(());
        }
        let number = self.past.len() + 1;
        let name = phase.command;
        self.terminal.note(format_args!("{TITLE}{number} of {N_PHASES}, {name}{TITLE:#}"));
        let started = Instant::now();
        self.ledger.note(record.clone())?;
        let part = self.terminal.part();
        let ended = run_typed(&self.typed(phase, &path)?, &part);
        self.terminal.add_warnings(&part);
        ended?;
        let sha256 = Some(Input::file(&path)?.sha256);
        self.ledger.note(Record { sha256, ..record })?;
        let (path_text, seconds) = (path.display(), started.elapsed().as_secs_f64());
        self.terminal.note(format_args!("  wrote {path_text} in {seconds:.1} s"));
        self.past.push(Past { name, state: State::Done, output: path });
        Ok(())
    }

    /// Runs a phase that the rest can do without, and that asks for the steps of pushes; whether its output is there.
    ///
    /// # Errors
    /// If a file cannot be read or written.
    pub(super) fn go_if_told(&mut self, phase: &Phase) -> Result<bool> {
        if self.step == StepKind::WholePush {
            self.pass(phase.command, State::NotTold, self.path(phase.output));
            return Ok(false);
        }
        let n_past = self.past.len();
        let Err(why) = self.go(phase) else { return Ok(true) };
        let path = self.path(phase.output);
        if self.past.len() > n_past || why.downcast_ref::<ModelError>().is_none() {
            return Err(why);
        }
        self.terminal.note(format_args!("  cannot be told: {why}"));
        let (name, state) = (phase.command, State::NotTold);
        self.past.push(Past { name, state, output: path });
        Ok(false)
    }

    /// Notes a phase that is not asked for.
    pub(super) fn pass_over(&mut self, name: &'static str, output: &str) {
        let path = self.path(output);
        if path.is_file() {
            self.terminal.remark(format_args!(
                "{} is of an earlier run: the diagnosis of now names nothing to add",
                path.display()
            ));
        }
        self.pass(name, State::Needless, path);
    }

    fn pass(&mut self, name: &'static str, state: State, output: PathBuf) {
        let number = self.past.len() + 1;
        let (path, what) = (output.display(), format!("{number} of {N_PHASES}, {name}"));
        let why = match state {
            State::Done => format!("wrote {path}"),
            State::Unchanged if self.past.is_empty() => format!("{path} tells all"),
            State::Unchanged => format!("skipped, {path} is made from the same"),
            State::Needless => "skipped, nothing is named that lowers the error".to_owned(),
            State::NotTold => "skipped, these recordings do not tell it".to_owned(),
        };
        self.terminal.note(format_args!("{TITLE}{what}{TITLE:#}: {why}"));
        self.past.push(Past { name, state, output });
    }

    /// The command as one would type it.
    fn typed(&self, phase: &Phase, output: &Path) -> Result<Vec<String>> {
        let text = |path: &Path| {
            let text = path.to_str().map(str::to_owned);
            text.with_context(|| format!("{} is no text in UTF-8; rename it", path.display()))
        };
        let mut words: Vec<String> = phase.command.split(' ').map(str::to_owned).collect();
        if phase.reads_set {
            words.push(text(&self.args.folder)?);
        }
        words.extend(phase.options.iter().cloned());
        for (option, path) in &phase.reads {
            words.extend([format!("--{option}"), text(path)?]);
        }
        words.extend(["-o".to_owned(), text(output)?]);
        words.extend(output.exists().then(|| "--force".to_owned()));
        Ok(words)
    }
}
