//! What is said to people and what is printed for programs.

use std::fmt::Display;
use std::io::{self, IsTerminal, Write};
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use anstream::AutoStream;
use anstyle::{AnsiColor, Style};
use anyhow::{Result, bail};
use clap::ColorChoice;
use indicatif::ProgressDrawTarget;
use serde::Serialize;

use crate::tool::document::document;
use crate::tool::file_ending::is_standard;
use crate::tool::global::Global;
use crate::tool::heard::Heard;
use crate::tool::origin::{Input, Origin};
use crate::tool::progress::{Activity, Progress};
use crate::tool::wrong_usage::WrongUsage;

/// Standard output and standard error, with what the user wants to see of them.
#[derive(Clone)]
pub(crate) struct Terminal {
    /// What standard output gets of a result.
    result: Shown,
    quiet: bool,
    verbose: bool,
    /// Whether the command is one of several, of which their beginning and end is told.
    is_part: bool,
    color: ColorChoice,
    /// What was told beside the result, for programs.
    warnings: Arc<Mutex<Vec<String>>>,
    /// What people have read of it, in this command or another one of the same run.
    read: Arc<Mutex<Vec<String>>>,
    /// A program in place of people.
    heard: Option<Heard>,
    started: Instant,
}

#[derive(Clone, Copy, PartialEq)]
enum Shown {
    Text,
    Json,
    Nothing,
}

/// Style of a title.
pub(crate) const TITLE: Style = Style::new().bold();
/// Style of what deserves a look.
pub(crate) const WARNING: Style = AnsiColor::Yellow.on_default().bold();
/// Style of what failed.
pub(crate) const FAILURE: Style = AnsiColor::Red.on_default().bold();

impl Terminal {
    pub(crate) fn new(global: &Global) -> Self {
        let Global { json, quiet, verbose, color, .. } = *global;
        let result = match (json, quiet) {
            (true, _) => Shown::Json,
            (false, true) => Shown::Nothing,
            (false, false) => Shown::Text,
        };
        let (warnings, read) = (Arc::default(), Arc::default());
        let (is_part, heard, started) = (false, None, Instant::now());
        Self { result, quiet, verbose, is_part, color, warnings, read, heard, started }
    }

    /// For a program that listens: nothing is printed.
    pub(crate) fn heard_by(heard: Heard) -> Self {
        Self {
            result: Shown::Json,
            quiet: false,
            verbose: false,
            is_part: false,
            color: ColorChoice::Never,
            warnings: Arc::default(),
            read: Arc::default(),
            heard: Some(heard),
            started: Instant::now(),
        }
    }

    /// Ends a command: its result for people, or as a document for programs.
    ///
    /// # Errors
    /// `io::Error` if standard output cannot be written, of kind `BrokenPipe` if nobody reads it.
    pub(crate) fn finish(
        &self,
        origin: &Origin,
        result: &impl Serialize,
        text: impl Display,
    ) -> Result<()> {
        self.finish_with(origin, || document(origin, &self.warnings(), result), text)
    }

    /// As [`Terminal::finish`], for a result that makes its document itself.
    ///
    /// # Errors
    /// As [`Terminal::finish`], and if the document cannot be made.
    pub(crate) fn finish_with(
        &self,
        origin: &Origin,
        json: impl FnOnce() -> Result<String>,
        text: impl Display,
    ) -> Result<()> {
        match self.result {
            Shown::Json => match &self.heard {
                Some(heard) => heard.keep(json()?, &text.to_string()),
                None => self.print(&json()?)?,
            },
            Shown::Text => self.print(&text.to_string())?,
            Shown::Nothing => {}
        }
        if self.verbose {
            for Input { path, sha256 } in &origin.inputs {
                self.tell(format_args!("read {}, sha256 {sha256}", path.display()));
            }
            let (seconds, n) = (self.started.elapsed().as_secs_f64(), rayon::current_num_threads());
            self.tell(format_args!("done in {seconds:.1} s with {n} threads"));
        }
        Ok(())
    }

    /// For commands within a command, whose results programs do not get.
    pub(crate) fn within(&self) -> Self {
        let is_json = self.result == Shown::Json;
        let result = if is_json { Shown::Nothing } else { self.result };
        let quiet = self.quiet || is_json;
        let (warnings, read) = (Arc::default(), Arc::default());
        Self { result, quiet, warnings, read, started: Instant::now(), ..self.clone() }
    }

    /// For a command as a part of another one, whose result nobody gets but from its files. What it tells beside
    /// that is its own, and people read the same thing once.
    pub(crate) fn part(&self) -> Self {
        let warnings = Arc::default();
        let (result, verbose, is_part) = (Shown::Nothing, false, true);
        Self { result, verbose, is_part, warnings, ..self.clone() }
    }

    /// For work of which people have seen the progress already.
    pub(crate) fn silent(&self) -> Self {
        Self { quiet: true, ..self.clone() }
    }

    /// For a command with these outputs: one that is standard output takes the place of the result.
    ///
    /// # Errors
    /// If two things are to be printed there.
    pub(crate) fn beside<'a>(&self, outputs: impl IntoIterator<Item = &'a Path>) -> Result<Self> {
        match outputs.into_iter().filter(|output| is_standard(output)).count() {
            0 => Ok(self.clone()),
            1 if self.result != Shown::Json => Ok(Self { result: Shown::Nothing, ..self.clone() }),
            _ => {
                bail!(WrongUsage("one output alone can be standard output: name a file, or --json"))
            }
        }
    }

    /// Warns people, and programs that read the document; of the same thing once.
    pub(crate) fn warn(&self, text: impl Display) {
        self.tell_beside("warning", text.to_string());
    }

    /// Tells people what else is to be known of the result, and programs that read the document.
    pub(crate) fn remark(&self, text: impl Display) {
        self.tell_beside("note", text.to_string());
    }

    fn tell_beside(&self, kind: &str, text: String) {
        let is_new = |list: &Mutex<Vec<String>>| {
            let mut list = list.lock().unwrap_or_else(PoisonError::into_inner);
            let is_new = !list.contains(&text);
            if is_new {
                list.push(text.clone());
            }
            is_new
        };
        if is_new(&self.warnings) && is_new(&self.read) {
            self.tell(format_args!("{WARNING}{kind}:{WARNING:#} {text}"));
        }
    }

    /// What was told beside the result so far.
    pub(crate) fn warnings(&self) -> Vec<String> {
        self.warnings.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Notes what a part told, of which people know.
    pub(crate) fn add_warnings(&self, of_part: &Self) {
        let mut told = self.warnings.lock().unwrap_or_else(PoisonError::into_inner);
        for text in of_part.warnings() {
            if !told.contains(&text) {
                told.push(text);
            }
        }
    }

    /// Whether a person can be asked: one who reads what is told and types.
    pub(crate) fn is_answered(&self) -> bool {
        !self.quiet
            && self.result == Shown::Text
            && io::stdin().is_terminal()
            && io::stderr().is_terminal()
    }

    /// Prints what is no result.
    ///
    /// # Errors
    /// As [`Terminal::finish`].
    pub(crate) fn print_for_people(&self, text: &str) -> Result<()> {
        if self.result == Shown::Text { self.print(text) } else { Ok(()) }
    }

    /// Prints what the user asked for itself, whatever they want to see of the rest.
    ///
    /// # Errors
    /// As [`Terminal::finish`].
    pub(crate) fn print(&self, text: &str) -> Result<()> {
        if let Some(heard) = &self.heard {
            heard.keep_text(text);
            return Ok(());
        }
        let mut stream = AutoStream::new(io::stdout().lock(), self.choice(&io::stdout()));
        stream.write_all(text.as_bytes())?;
        stream.flush()?;
        Ok(())
    }

    /// Tells people who want to see more than errors, on standard error.
    pub(crate) fn note(&self, text: impl Display) {
        if !self.quiet {
            self.tell(text);
        }
    }

    /// Tells people on standard error; nothing is lost if nobody listens.
    pub(crate) fn tell(&self, text: impl Display) {
        if let Some(heard) = &self.heard {
            return heard.tell(&text.to_string());
        }
        let mut stream = AutoStream::new(io::stderr().lock(), self.choice(&io::stderr()));
        let _ = writeln!(stream, "{text}");
    }

    /// Shows how far a long piece of work is, on standard error.
    pub(crate) fn progress(&self, what: &'static str, total: usize) -> Progress {
        if let Some(heard) = &self.heard {
            return Progress::heard(heard.clone(), what, total);
        }
        let target = ProgressDrawTarget::stderr();
        if self.quiet || self.is_part && target.is_hidden() {
            Progress::silent()
        } else {
            Progress::new(what, total, target)
        }
    }

    /// Shows what long work is at, on standard error, if that is a terminal.
    pub(crate) fn activity(&self) -> Activity {
        match &self.heard {
            Some(heard) => Activity::Heard(heard.clone()),
            None if self.quiet => Activity::silent(),
            None => Activity::new(ProgressDrawTarget::stderr()),
        }
    }

    fn choice<S: anstream::stream::RawStream>(&self, stream: &S) -> anstream::ColorChoice {
        match self.color {
            ColorChoice::Auto => AutoStream::choice(stream),
            ColorChoice::Always => anstream::ColorChoice::Always,
            ColorChoice::Never => anstream::ColorChoice::Never,
        }
    }
}
