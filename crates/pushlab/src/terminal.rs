//! What is said to people and what is printed for programs.

use std::fmt::Display;
use std::io::{self, Write};

use anstream::AutoStream;
use anstyle::{AnsiColor, Style};
use anyhow::Result;
use clap::ColorChoice;
use indicatif::ProgressDrawTarget;
use serde::Serialize;

use crate::document::Document;
use crate::global::Global;
use crate::origin::Origin;
use crate::progress::Progress;

/// Standard output and standard error, with what the user wants to see of them.
pub(crate) struct Terminal {
    json: bool,
    quiet: bool,
    color: ColorChoice,
}

/// Style of a title.
pub(crate) const TITLE: Style = Style::new().bold();
/// Style of what deserves a look.
pub(crate) const WARNING: Style = AnsiColor::Yellow.on_default().bold();
/// Style of what failed.
pub(crate) const FAILURE: Style = AnsiColor::Red.on_default().bold();

impl Terminal {
    pub(crate) fn new(global: &Global) -> Self {
        Self { json: global.json, quiet: global.quiet, color: global.color }
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
        if self.json {
            self.print(&Document { origin, result }.to_json()?)
        } else if self.quiet {
            Ok(())
        } else {
            self.print(&text.to_string())
        }
    }

    /// As [`Terminal::finish`], for a result whose JSON has a form of its own.
    ///
    /// # Errors
    /// As [`Terminal::finish`].
    pub(crate) fn finish_plain(&self, json: &str, text: impl Display) -> Result<()> {
        if self.json {
            self.print(json)
        } else if self.quiet {
            Ok(())
        } else {
            self.print(&text.to_string())
        }
    }

    /// For commands within a command, whose results programs do not get.
    pub(crate) fn within(&self) -> Self {
        Self { json: false, quiet: self.quiet || self.json, color: self.color }
    }

    /// For work of which people have seen the progress already.
    pub(crate) fn silent(&self) -> Self {
        Self { json: self.json, quiet: true, color: self.color }
    }

    /// Prints what is no result.
    ///
    /// # Errors
    /// As [`Terminal::finish`].
    pub(crate) fn print_for_people(&self, text: &str) -> Result<()> {
        if self.json || self.quiet { Ok(()) } else { self.print(text) }
    }

    /// Prints what the user asked for itself, whatever they want to see of the rest.
    ///
    /// # Errors
    /// As [`Terminal::finish`].
    pub(crate) fn print(&self, text: &str) -> Result<()> {
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
        let mut stream = AutoStream::new(io::stderr().lock(), self.choice(&io::stderr()));
        let _ = writeln!(stream, "{text}");
    }

    /// Shows how far a long piece of work is, on standard error.
    pub(crate) fn progress(&self, what: &'static str, total: usize) -> Progress {
        if self.quiet {
            Progress::silent()
        } else {
            Progress::new(what, total, ProgressDrawTarget::stderr())
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
