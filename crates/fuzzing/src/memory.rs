//! The memory that a worker may have, so that a reader that wants more ends it.

use anyhow::Result;

/// Address space of a worker beyond what it has when its work begins, in bytes: for a reader of 64 KiB of
/// input thousands of times as much.
pub(super) const MEMORY_LIMIT: u64 = 1 << 30;

/// Refuses this process more memory than the limit beside what it has by now: code, threads, and what libraries
/// reserve for good, which for a product of matrices is twice the last cache of the machine a thread.
///
/// # Errors
/// If the system does not let it, or does not tell what the process has.
#[cfg(unix)]
pub(super) fn limit() -> Result<()> {
    use rustix::process::{Resource, Rlimit, setrlimit};
    let limit = Some(reserved()? + MEMORY_LIMIT);
    Ok(setrlimit(Resource::As, Rlimit { current: limit, maximum: limit })?)
}

/// Elsewhere there is no limit: what takes too long is found all the same.
#[cfg(not(unix))]
pub(super) fn limit() -> Result<()> {
    Ok(())
}

/// Address space of this process, in bytes.
#[cfg(target_os = "linux")]
fn reserved() -> Result<u64> {
    use anyhow::Context;
    let path = "/proc/self/status";
    let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {path}"))?;
    let line = text.lines().find_map(|line| line.strip_prefix("VmSize:"));
    let kilobytes =
        line.and_then(|line| line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok());
    Ok(1024 * kilobytes.with_context(|| format!("no size of the process in {path}"))?)
}

/// Other systems do not tell: there code and threads count as well.
#[cfg(all(unix, not(target_os = "linux")))]
fn reserved() -> Result<u64> {
    Ok(0)
}
