//! The memory that a worker may have, so that a reader that wants more ends it.

use anyhow::Result;

/// Address space of a worker, in bytes: its own code and threads, and for a reader of 64 KiB of
/// input thousands of times as much.
pub(super) const MEMORY_LIMIT: u64 = 1 << 30;

/// Refuses this process more memory than the limit.
///
/// # Errors
/// If the system does not let it.
#[cfg(unix)]
pub(super) fn limit() -> Result<()> {
    use rustix::process::{Resource, Rlimit, setrlimit};
    let limit = Some(MEMORY_LIMIT);
    Ok(setrlimit(Resource::As, Rlimit { current: limit, maximum: limit })?)
}

/// Elsewhere there is no limit: what takes too long is found all the same.
#[cfg(not(unix))]
pub(super) fn limit() -> Result<()> {
    Ok(())
}
