//! What reading a log had to replace, skip or warn about, counted and named.

use std::fmt;

use serde::{Deserialize, Serialize};

/// One finding of a reader; a recording without faults has none.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Remark {
    /// What was found.
    pub kind: RemarkKind,
    /// The stream it concerns; none if it concerns the whole file.
    pub stream: Option<StreamRole>,
    /// How many samples, messages or chunks are concerned.
    pub count: u64,
    /// The finding in words, with byte or line where one applies.
    pub text: String,
}

impl Remark {
    /// That a log was stopped, by the number of pauses of each stream and the longest in s: where one stream alone
    /// pauses, the log went on.
    pub(crate) fn of_pauses(streams: impl Iterator<Item = (u64, f64)>) -> Option<Self> {
        let (count, longest) = streams.min_by(|a, b| a.0.cmp(&b.0))?;
        let times = if count == 1 { "once".to_owned() } else { format!("{count} times") };
        let text = format!(
            "the log pauses {times} for more than 1 s, {longest:.1} s at the longest: it may hold several \
             pushes, and is cut there when it is ingested"
        );
        (count > 0).then_some(Self { kind: RemarkKind::Paused, stream: None, count, text })
    }
}

/// The kinds of findings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum RemarkKind {
    /// Messages without a stamp of their own took the time at which they were logged.
    LogTimeUsed,
    /// Messages reached the log long after their own stamps.
    Late,
    /// A damaged chunk was left out.
    ChunkSkipped,
    /// The file ends before its proper end.
    Truncated,
    /// The index at the end of the file is missing or damaged; the file was scanned instead.
    NoIndex,
    /// The file carries no check sums, so that damage could go unseen.
    NoChecksums,
    /// Messages that do not fit their own schema were excluded.
    MessageExcluded,
    /// Rows whose quaternion is far from unit length were excluded.
    QuaternionExcluded,
    /// Rows with a value that is not finite were excluded.
    NonFiniteExcluded,
    /// Rows with a value beyond anything physical were excluded.
    OutOfRangeExcluded,
    /// The robot's orientation was never published (all quaternions zero); its yaw is 0.
    NoOrientation,
    /// The body is tilted out of the plane by more than the stated limit.
    Tilted,
    /// A transform that was read from the log as fixed varies within the log.
    TransformVaries,
    /// The log was stopped for a while.
    Paused,
    /// Recordings of another format, or in another folder, are not read.
    NotRead,
    /// Rows of `sessions.csv` name no recording of the set.
    SessionUnknown,
    /// Recordings are not in `sessions.csv`, though others are.
    SessionMissing,
}

/// The three streams of a recording.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StreamRole {
    /// Poses of the pusher.
    Robot,
    /// Poses of the object.
    Object,
    /// Forces on the pusher.
    Wrench,
}

impl StreamRole {
    /// All roles, in the order in which streams are chosen.
    pub const ALL: [Self; 3] = [Self::Robot, Self::Object, Self::Wrench];

    /// The name used in `dataset.toml` and in file names.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Robot => "robot",
            Self::Object => "object",
            Self::Wrench => "wrench",
        }
    }
}

impl fmt::Display for StreamRole {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
