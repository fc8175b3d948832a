//! Measurements whose frames, signs or units contradict the mechanics.

use anyhow::{Result, bail};
use dataset::{RecordingSet, SUSPECTED_RECORDINGS, Suspicion, suspicions};
use diagnosis::{Coverage, Observations};

use crate::tool::terminal::Terminal;

/// What contradicts the mechanics in some of a set's recordings, evenly over it; those that cannot
/// be read are left to the ingest.
pub(crate) fn suspected(set: &RecordingSet) -> Vec<Suspicion> {
    let all = set.recordings();
    let stride = all.len().div_ceil(SUSPECTED_RECORDINGS).max(1);
    let read = all.iter().step_by(stride).filter_map(|path| set.read(path).ok());
    suspicions(read, set.manifest())
}

/// Tells what pushes of few kinds cannot show.
pub(crate) fn warn_of_narrowness(observations: &Observations, terminal: &Terminal) {
    for sentence in Coverage::of(observations).cannot_tell() {
        terminal.warn(sentence);
    }
}

/// Tells people before anything else.
pub(crate) fn warn(suspicions: &[Suspicion], terminal: &Terminal) {
    for suspicion in suspicions {
        terminal.warn(suspicion);
    }
}

/// Refuses measurements from which nothing can be concluded; warns of others.
///
/// # Errors
/// If a suspicion is certain.
pub(crate) fn refuse(suspicions: &[Suspicion], terminal: &Terminal) -> Result<()> {
    if !suspicions.iter().any(|suspicion| suspicion.is_certain) {
        warn(suspicions, terminal);
        return Ok(());
    }
    let told: Vec<_> = suspicions.iter().map(|one| format!("\n  {one}")).collect();
    bail!(
        "these measurements contradict the mechanics, so nothing is concluded from them:{}",
        told.concat()
    );
}
