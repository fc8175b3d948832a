//! Whether the pusher is where it must be while the object moves: at its outline.

use super::mistake::View;
use super::numbers::length;
use super::scene::Scene;
use super::{Check, Explanation, Find, Suspicion, force_direction};
use crate::curves::sample::quantile;

pub(super) const CHECK: Check = Check {
    id: "places",
    looks_at: "the distance of the pusher from the outline while the object moves",
    names: "the single swap or sign of axes, or unit of lengths or angles, that brings the pusher to \
            the outline",
    find: Find::Places(find),
};

/// The distance that three quarters of the moments keep is the measure.
pub(super) const SHARE: f64 = 0.75;
/// A mistake has to bring the pusher so much nearer to the outline.
pub(super) const NEARER: f64 = 0.25;
/// One of a unit much more so, or to what is near anyway: what shrinks everything shrinks distances.
const NEARER_BY_UNIT: f64 = 0.02;
const NEAR_BY_UNIT: f64 = 0.05;
/// Distances that a unit makes, over the object's size: smaller ones have a cause of their own.
const FAR_BY_UNIT: f64 = 0.12;
/// Distances that are small in any case, over the object's size.
pub(super) const NEAR: f64 = 0.03;
/// Mistakes whose distances differ by less explain as much.
const AS_GOOD: f64 = 1.3;
/// By so much more moments with a possible force, one of them explains more.
const MORE_FORCES: f64 = 0.2;

fn find(scene: &Scene<'_>) -> Option<Explanation> {
    let recorded = View::recorded();
    let distance = distance(scene, &recorded)?;
    if distance <= NEAR * scene.size() {
        return Some(Explanation { distance, suspicion: None, view: Some(recorded) });
    }
    let measured = |view: View| Some((self::distance(scene, &view)?, view));
    let mistakes: Vec<_> = View::mistakes().into_iter().filter_map(measured).collect();
    let explains = |(at, view): &&(f64, View)| {
        let is_near = *at < NEAR_BY_UNIT * view.outline_scale() * scene.size();
        match view.is_unit {
            true => {
                let is_far = distance > FAR_BY_UNIT * scene.size();
                *at < NEARER_BY_UNIT * distance || (is_far && is_near && *at < NEARER * distance)
            }
            false => *at < NEARER * distance,
        }
    };
    let least = mistakes.iter().filter(explains).map(|(at, _)| *at).fold(f64::INFINITY, f64::min);
    let as_good = mistakes.iter().filter(explains).filter(|(at, _)| *at <= AS_GOOD * least);
    let chosen = as_good.map(|(at, view)| (force_direction::possible(scene, view), *at, view));
    let (_, at, view) = chosen.reduce(|best, next| match (best.0, next.0) {
        (Some(of_best), Some(of_next)) if of_next > of_best + MORE_FORCES => next,
        _ => best,
    })?;
    let suspicion = Suspicion {
        what: view.what.clone(),
        evidence: evidence(distance, at),
        fix: view.fix.clone(),
        is_certain: true,
    };
    Some(Explanation { distance: at, suspicion: Some(suspicion), view: Some(view.clone()) })
}

/// What a mistake that is put right does to the distance of the pusher.
pub(super) fn evidence(distance: f64, corrected: f64) -> String {
    format!(
        "while the object moves, the pusher is {} from its outline (three quarters of the time, or \
         less), and {} if that is corrected",
        length(distance),
        length(corrected)
    )
}

/// How far the pusher is from the outline while the object moves, in m.
pub(super) fn distance(scene: &Scene<'_>, view: &View) -> Option<f64> {
    let gap = |(object, moment): &(usize, super::moment::Moment)| {
        view.seen(moment, &scene.object(*object).shape, scene.radius()).contact.gap.abs()
    };
    quantile(scene.seen.iter().map(gap).collect(), SHARE)
}
