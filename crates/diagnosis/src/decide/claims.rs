//! What may be claimed.

use super::Verdict;
use super::constancy::Varies;
use super::found::Found;
use super::leftover::Left;
use crate::{EffectFit, ParameterFit};

/// What may be claimed of a set.
pub(super) struct Claims {
    pub(super) verdict: Verdict,
    /// Effects that are missing, and groups of which one is.
    pub(super) identified: Vec<&'static str>,
    pub(super) groups: Vec<Vec<&'static str>>,
    /// Effects that lower the error, and why another cause may be behind it.
    pub(super) effective: Vec<(&'static str, String)>,
    /// Whether something is left that no effect explains.
    pub(super) is_left: bool,
}

/// Share of the gap that has to close, where something is left, for what closes it to be the cause.
const HALF: f64 = 0.5;
const MUCH_LEFT: &str = "most of the error is left, and what causes that may cause this, too";

/// Half-width of a place's interval, in the mean distance of the pressure, from which other places do as
/// well.
const WIDE: f64 = 0.2;

/// What is known of where an object rests, where its places are not.
fn wide_places(effect: &EffectFit) -> Option<String> {
    let [x, y, c] = effect.follows.as_slice() else { return None };
    let half = |one: &ParameterFit| one.interval.map(|ends| 0.5 * (ends.high95 - ends.low95));
    let places = effect.parameters.iter().filter(|one| one.unit == "m" && one.value != 0.0);
    let widest = places.filter_map(half).fold(0.0, f64::max);
    let told = |one: &ParameterFit| {
        let half = half(one).map_or(String::new(), |half| format!(" ± {:.1}", 1e3 * half));
        format!("{:.1}{half}", 1e3 * one.value)
    };
    (widest > WIDE * c.value).then(|| {
        format!(
            "points elsewhere have nearly the same friction. What is known: the center of friction at \
             x {} mm and y {} mm, and the mean distance c of the pressure from it, {} mm",
            told(x),
            told(y),
            told(c)
        )
    })
}

/// The verdict.
pub(super) fn claims(found: &Found, left: &Left) -> Claims {
    let is_left = left.is_left();
    let is_much_left = is_left || left.is_far_off();
    let closes = found.error.gap_closed.is_none_or(|closed| closed >= HALF);
    let (mut identified, mut groups, mut effective) = (Vec::new(), Vec::new(), Vec::new());
    for one in &found.accepted {
        // One of a group may vary where another of it does not.
        let varies = one.varies.as_ref().filter(|_| one.rivals.is_empty());
        let doubt = varies.map(Varies::sentence).or_else(|| wide_places(&one.effect));
        let doubt = doubt.or_else(|| (is_much_left && !closes).then(|| MUCH_LEFT.to_owned()));
        match doubt {
            Some(why) => effective.push((one.id, why)),
            None if one.rivals.is_empty() => identified.push(one.id),
            None => groups.push([&[one.id], one.rivals.as_slice()].concat()),
        }
    }
    let is_doubted = found.refused.iter().any(|refused| refused.objection.is_hint());
    let verdict = if !identified.is_empty() {
        Verdict::Identified
    } else if !groups.is_empty() {
        Verdict::Ambiguous
    } else if !effective.is_empty() {
        Verdict::Effective
    } else if is_left {
        Verdict::Unexplained
    } else if is_doubted || left.is_hint() {
        Verdict::Inconclusive
    } else {
        Verdict::NoneFound
    };
    Claims { verdict, identified, groups, effective, is_left }
}
