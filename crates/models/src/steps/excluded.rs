//! Rows of a table that are not used, by reason.

use std::collections::BTreeMap;
use std::fmt;

/// The rows excluded, counted from 0, by the first reason that each had.
///
/// As text: how many by which reason, such as `3 after contact, 12 short`; empty for none.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Excluded {
    /// Rows by reason.
    pub rows: BTreeMap<ExclusionReason, Vec<usize>>,
}

/// Why a row is not an observation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ExclusionReason {
    /// The pusher has left the object.
    AfterContact,
    /// The pusher rests: its direction is not defined.
    PusherAtRest,
    /// The object's pose jumps as no contact moves it, in this row or earlier in its push.
    PoseJump,
    /// A flag of the selection, by its name in the table.
    Flag(&'static str),
}

impl Excluded {
    pub(crate) fn add(&mut self, reason: ExclusionReason, row: usize) {
        self.rows.entry(reason).or_default().push(row);
    }

    /// How many rows were excluded for any reason.
    pub fn n_rows(&self) -> usize {
        self.rows.values().map(Vec::len).sum()
    }
}

impl fmt::Display for Excluded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let count = |(reason, rows): (&_, &Vec<usize>)| format!("{} {reason}", rows.len());
        f.write_str(&self.rows.iter().map(count).collect::<Vec<_>>().join(", "))
    }
}

impl fmt::Display for ExclusionReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::AfterContact => "after contact",
            Self::PusherAtRest => "pusher at rest",
            Self::PoseJump => "after a jump of the pose that no contact makes",
            Self::Flag(name) => name,
        })
    }
}
