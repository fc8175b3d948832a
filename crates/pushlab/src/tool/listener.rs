//! A program that runs commands, in place of a person at a terminal.

/// Who hears what a command says beside its result.
///
/// Its functions are called on whichever thread the work is.
pub trait Listener: Send + Sync {
    /// A warning or a note, which is in the document as well.
    fn tell(&self, text: &str);

    /// `done` of `total` pieces are done, `what` says of what: `recordings read:`.
    fn progress(&self, what: &str, done: usize, total: usize);

    /// What the work is at, where nobody can count its pieces.
    fn phase(&self, phase: &str);

    /// Whether nobody wants the result any more; asked each time that something was told.
    fn is_stopped(&self) -> bool;
}

/// What a command prints.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Printed {
    /// What `--json` prints; empty for a command without a result of its own (`man`).
    pub document: String,
    /// What a terminal shows, without colors.
    pub text: String,
}
