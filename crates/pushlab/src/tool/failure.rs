//! How a run ends, and what is said when it fails.

use dataset::MANIFEST_NAME;
use std::io::{self, ErrorKind};
use std::process::ExitCode;

use crate::tool::terminal::{FAILURE, Terminal};
use crate::tool::wrong_usage::WrongUsage;

/// How a run ended, as exit codes tell it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Outcome {
    /// As asked.
    Done = 0,
    /// The input or the computation failed.
    Failed = 1,
    /// The arguments make no sense.
    WrongUsage = 2,
}

impl From<Outcome> for ExitCode {
    fn from(outcome: Outcome) -> Self {
        Self::from(outcome as u8)
    }
}

/// Says what failed, why, and what may help; returns how the run ended.
pub(crate) fn report(error: &anyhow::Error, terminal: &Terminal) -> Outcome {
    // Nobody reads the result any more, as in `pushlab … | head`.
    let gone = |error: &io::Error| error.kind() == ErrorKind::BrokenPipe;
    if error.chain().filter_map(|cause| cause.downcast_ref::<io::Error>()).any(gone) {
        return Outcome::Done;
    }
    terminal.tell(format_args!("{FAILURE}error:{FAILURE:#} {}", message(error)));
    if error.is::<WrongUsage>() { Outcome::WrongUsage } else { Outcome::Failed }
}

/// What failed, why, and what may help.
pub(crate) fn message(error: &anyhow::Error) -> String {
    let help = remedy(error).map_or_else(String::new, |remedy| format!("\n  help: {remedy}"));
    chain(error) + &help
}

/// The error and its causes, without those that an error's own message already names.
fn chain(error: &anyhow::Error) -> String {
    let mut text = error.to_string();
    for cause in error.chain().skip(1).map(ToString::to_string) {
        if !text.contains(&cause) {
            text += &format!("\n  because: {cause}");
        }
    }
    text
}

/// Whether a message is about a model file that is not there.
fn is_model(message: &str) -> bool {
    let first = message.lines().next().unwrap_or_default();
    first.ends_with(".toml") && !first.ends_with(MANIFEST_NAME)
}

/// What to do about a draft that `init` wrote, or an error of the operating system; other messages
/// say it themselves.
fn remedy(error: &anyhow::Error) -> Option<&'static str> {
    if ["TODO", "still to be filled in"].iter().any(|part| chain(error).contains(part)) {
        return Some("fill in what is marked TODO in this file");
    }
    let system = error.chain().find_map(|cause| cause.downcast_ref::<io::Error>())?;
    match system.kind() {
        ErrorKind::NotFound if is_model(&chain(error)) => Some(
            "check the path; `pushlab models init SET` writes the nominal model of a recording set",
        ),
        ErrorKind::NotFound => Some("check the path; a relative one begins at the current folder"),
        ErrorKind::PermissionDenied => Some("check who may read and write there"),
        ErrorKind::IsADirectory => Some("this is a folder; name a file"),
        ErrorKind::NotADirectory => Some("a part of the path is a file; name a folder"),
        ErrorKind::InvalidData => Some("this is no text in UTF-8; check that it is the right file"),
        ErrorKind::StorageFull => Some("make room, or write elsewhere"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use std::io::{Error, ErrorKind};

    use anyhow::Context;

    use super::{chain, remedy};

    #[test]
    fn causes_are_named_once_with_a_remedy() {
        let cause = || Error::new(ErrorKind::NotFound, "no such file");
        let error = Err::<(), _>(cause()).context("cannot read a").unwrap_err();
        assert_eq!(chain(&error), "cannot read a\n  because: no such file");
        let error = Err::<(), _>(cause()).context("cannot read a: no such file").unwrap_err();
        assert_eq!(chain(&error), "cannot read a: no such file");
        assert!(remedy(&error).is_some_and(|text| text.contains("check the path")));
        assert_eq!(remedy(&anyhow::anyhow!("own")), None);
    }
}
