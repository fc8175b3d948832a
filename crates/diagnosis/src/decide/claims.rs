//! What may be claimed.

use super::Verdict;
use super::found::Found;
use super::leftover::Left;

/// What may be claimed of a set.
pub(super) struct Claims {
    pub(super) verdict: Verdict,
    /// Effects that are claimed, and groups of which one is.
    pub(super) named: Vec<&'static str>,
    pub(super) groups: Vec<Vec<&'static str>>,
    /// Whether something is left that no effect explains.
    pub(super) is_left: bool,
}

/// Share of the gap that a name has to close beside what is left.
const HALF: f64 = 0.5;

/// The verdict.
pub(super) fn claims(found: &Found, left: &Left) -> Claims {
    let alone = found.accepted.iter().filter(|one| one.rivals.is_empty());
    let mut named: Vec<&'static str> = alone.map(|one| one.id).collect();
    let shared = found.accepted.iter().filter(|one| !one.rivals.is_empty());
    let mut groups: Vec<Vec<&'static str>> =
        shared.map(|one| [&[one.id], one.rivals.as_slice()].concat()).collect();
    let is_left = left.is_left();
    let closes = found.error.gap_closed.is_none_or(|closed| closed >= HALF);
    let is_doubted = found.refused.iter().any(|refused| refused.objection.is_hint());
    let has_hint = is_doubted || left.is_hint();
    let verdict = if is_left && (found.accepted.is_empty() || !closes) {
        Verdict::StructureUnexplained
    } else if !named.is_empty() {
        Verdict::Named
    } else if !groups.is_empty() {
        Verdict::OneOf
    } else if has_hint {
        Verdict::Weak
    } else {
        Verdict::NoneFound
    };
    if verdict == Verdict::StructureUnexplained {
        named.clear();
        groups.clear();
    }
    Claims { verdict, named, groups, is_left }
}
