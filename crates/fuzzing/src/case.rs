//! One run of a reader, judged: what it made of an input, or how it failed.

use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook};
use std::path::Path;
use std::str::FromStr;
use std::sync::{Mutex, MutexGuard, PoisonError};

use dataset::{ReadLimits, Streams, format_by_id};

use super::reader::{Reader, Verdict};

/// How a reader failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Kind {
    /// A panic came out of it.
    Panic,
    /// Its process ended: an abort, a stack overflow, more memory than allowed.
    Crash,
    /// It took longer than allowed.
    Hang,
    /// It accepted values that the format forbids.
    Wrong,
}

const KINDS: [(Kind, &str); 4] =
    [(Kind::Panic, "panic"), (Kind::Crash, "crash"), (Kind::Hang, "hang"), (Kind::Wrong, "wrong")];

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = KINDS.iter().find(|(kind, _)| kind == self).map_or("", |(_, name)| name);
        f.write_str(name)
    }
}

impl FromStr for Kind {
    type Err = ();

    fn from_str(text: &str) -> Result<Self, ()> {
        KINDS.iter().find(|(_, name)| *name == text).map(|(kind, _)| *kind).ok_or(())
    }
}

/// A failure: two with the same kind and place are one.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Fault {
    pub(super) kind: Kind,
    /// Where it panicked, or what is wrong.
    pub(super) place: String,
}

/// Where the first panic of a case happened and what it said, if it was in the project's code.
static OWN_PANIC: Mutex<Option<String>> = Mutex::new(None);

fn own_panic() -> MutexGuard<'static, Option<String>> {
    OWN_PANIC.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Keeps panics quiet, and remembers the place of the project's own: what readers make errors of
/// is a fault all the same, unless a library panicked.
pub(super) fn remember_panics() {
    // Readers put a hook of theirs before any other when they first catch something; ours is last.
    if let Ok(format) = format_by_id("mcap") {
        let _ = format.read(Path::new("none.mcap"), &Streams::default(), &ReadLimits::default());
    }
    set_hook(Box::new(|panic| {
        let place = panic.location().map_or(String::new(), ToString::to_string);
        if place.contains("/registry/src/") {
            return;
        }
        let message = panic.payload_as_str().unwrap_or_default();
        let text = format!("{}: {message}", short(&place)).replace(['\n', '\r', '\t'], " ");
        own_panic().get_or_insert(text);
    }));
}

/// A place in a source file without the folders of one machine.
fn short(place: &str) -> &str {
    let parts: Vec<_> = place.rmatch_indices('/').map(|(at, _)| at + 1).take(4).collect();
    parts.last().map_or(place, |at| &place[*at..])
}

/// Runs a reader on an input.
pub(super) fn judge(reader: &dyn Reader, dir: &Path, input: &[u8]) -> Result<Verdict, Fault> {
    let outcome = catch_unwind(AssertUnwindSafe(|| reader.read(dir, input)));
    if let Some(place) = own_panic().take() {
        return Err(Fault { kind: Kind::Panic, place });
    }
    match outcome {
        Ok(Verdict::Wrong(place)) => Err(Fault { kind: Kind::Wrong, place }),
        Ok(verdict) => Ok(verdict),
        Err(_) => Err(Fault { kind: Kind::Panic, place: "in a library".to_owned() }),
    }
}

impl Fault {
    /// Whether another failure is of the same cause, as far as its place tells.
    pub(super) fn is_like(&self, other: &Self) -> bool {
        // Numbers in messages differ from input to input, places and names do not.
        let words = |text: &str| -> String {
            let place = text.split(": ").next().unwrap_or_default();
            match self.kind {
                Kind::Panic => place.to_owned(),
                Kind::Wrong => text.split(" is ").next().unwrap_or_default().to_owned(),
                Kind::Crash if text.contains("memory allocation") => "memory".to_owned(),
                Kind::Crash | Kind::Hang => String::new(),
            }
        };
        self.kind == other.kind && words(&self.place) == words(&other.place)
    }
}

#[cfg(test)]
mod tests {
    use super::{Fault, Kind, short};

    #[test]
    fn kinds_are_read_as_they_are_written() {
        for kind in [Kind::Panic, Kind::Crash, Kind::Hang, Kind::Wrong] {
            assert_eq!(kind.to_string().parse(), Ok(kind));
        }
    }

    #[test]
    fn failures_at_one_place_are_one() {
        let panic = |place: &str| Fault { kind: Kind::Panic, place: place.to_owned() };
        let one = panic("src/a.rs:3:1: index 7 out of 3");
        assert!(one.is_like(&panic("src/a.rs:3:1: index 9 out of 4")));
        assert!(!one.is_like(&panic("src/a.rs:5:1: index 9 out of 4")));
        assert_eq!(short("/far/away/crates/a/src/b.rs:1:2"), "crates/a/src/b.rs:1:2");
    }
}
