//! Commands as functions, for programs that have no command line: bindings to other languages.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;

use clap::Parser;

use crate::tool::command_line::CommandLine;
use crate::tool::failure::message;
use crate::tool::heard::{Heard, Stopped};
use crate::tool::listener::{Listener, Printed};
use crate::tool::terminal::Terminal;
use crate::tool::wrong_usage::WrongUsage;

/// Why a command printed no result.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CommandError {
    /// The input or the computation failed, in the words of the command line.
    #[error("{0}")]
    Failed(String),
    /// The arguments make no sense.
    #[error("{0}")]
    WrongUsage(String),
    /// The listener wanted no more of it.
    #[error("stopped before the end; nothing was written")]
    Stopped,
}

/// Runs a command as if these words stood behind `pushlab` on a command line, and listens instead of
/// printing.
///
/// A command that is stopped writes nothing: outputs appear whole, and last.
///
/// # Errors
/// `WrongUsage` for words that are no command, `Failed` with what the command says, `Stopped` if the
/// listener says so.
pub fn run<W: AsRef<str>>(
    words: &[W],
    listener: Arc<dyn Listener>,
) -> Result<Printed, CommandError> {
    let words = ["pushlab"].into_iter().chain(words.iter().map(AsRef::as_ref));
    let command_line = match CommandLine::try_parse_from(words) {
        Ok(command_line) => command_line,
        Err(error) if !error.use_stderr() => {
            return Ok(Printed { text: error.to_string(), ..Printed::default() });
        }
        Err(error) => {
            let text = error.to_string();
            let text = text.strip_prefix("error: ").unwrap_or(&text).trim_end();
            return Err(CommandError::WrongUsage(text.to_owned()));
        }
    };
    let heard = Heard::new(listener);
    let terminal = Terminal::heard_by(heard.clone());
    match catch_unwind(AssertUnwindSafe(|| command_line.run(&terminal))) {
        Ok(Ok(())) => Ok(heard.printed()),
        Ok(Err(error)) if error.is::<WrongUsage>() => {
            Err(CommandError::WrongUsage(message(&error)))
        }
        Ok(Err(error)) => Err(CommandError::Failed(message(&error))),
        Err(payload) if payload.is::<Stopped>() => Err(CommandError::Stopped),
        Err(payload) => resume_unwind(payload),
    }
}

/// An error of the crates with its causes, and what may help, as the command line says it.
pub fn explained(error: impl std::error::Error + Send + Sync + 'static) -> String {
    message(&anyhow::Error::from(error))
}

#[cfg(test)]
mod tests {
    use std::sync::{Arc, Mutex};

    use super::{CommandError, run};
    use crate::tool::listener::Listener;

    /// Writes down what it hears, and stops after so many of these.
    struct Notes {
        heard: Mutex<Vec<String>>,
        most: usize,
    }

    impl Notes {
        fn new(most: usize) -> Arc<Self> {
            Arc::new(Self { heard: Mutex::default(), most })
        }

        fn note(&self, text: String) {
            self.heard.lock().unwrap().push(text);
        }
    }

    impl Listener for Notes {
        fn tell(&self, text: &str) {
            self.note(text.to_owned());
        }
        fn progress(&self, what: &str, done: usize, total: usize) {
            self.note(format!("{what} {done} of {total}"));
        }
        fn phase(&self, phase: &str) {
            self.note(phase.to_owned());
        }
        fn is_stopped(&self) -> bool {
            self.heard.lock().unwrap().len() >= self.most
        }
    }

    const PUSHES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/pushes");

    #[test]
    fn what_is_printed_is_the_document_and_the_text_of_the_command_line() {
        let notes = Notes::new(usize::MAX);
        let printed = run(&["ingest", PUSHES], notes.clone()).unwrap();
        let document: serde_json::Value = serde_json::from_str(&printed.document).unwrap();
        assert_eq!(document["schema"], "pushlab.ingest/1");
        assert!(printed.text.contains("pushes") && !printed.text.contains('\u{1b}'));
        let heard = notes.heard.lock().unwrap();
        assert!(heard.iter().any(|line| line.starts_with("recordings read: 1 of ")), "{heard:?}");
    }

    #[test]
    fn work_that_nobody_wants_ends_early_and_leaves_no_file() {
        let dir = tempfile::tempdir().unwrap();
        let table = dir.path().join("steps.csv");
        let words = ["ingest", PUSHES, "-o", table.to_str().unwrap()];
        let notes = Notes::new(1);
        let error = run(&words, notes.clone()).unwrap_err();
        assert!(matches!(error, CommandError::Stopped), "{error}");
        assert_eq!(notes.heard.lock().unwrap().len(), 1);
        assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 0);
    }

    #[test]
    fn wrong_words_and_failures_are_told_apart_in_the_words_of_the_command_line() {
        let error = |words: &[&str]| run(words, Notes::new(usize::MAX)).unwrap_err();
        let usage = error(&["ingest", "--no-such-option"]);
        assert!(matches!(usage, CommandError::WrongUsage(_)), "{usage}");
        assert!(usage.to_string().starts_with("unexpected argument"), "{usage}");
        let failed = error(&["ingest", "no/such/set"]).to_string();
        assert!(
            failed.contains("no/such/set") && failed.contains("help: check the path"),
            "{failed}"
        );
    }
}
