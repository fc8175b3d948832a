//! Whether the pusher is where it must be while the object moves: at its outline.

use super::mistake::View;
use super::numbers::{length, quantile};
use super::{Scene, Suspicion, forces};

/// What the places of pusher and object say.
pub(super) struct Geometry {
    pub(super) suspicion: Option<Suspicion>,
    /// As which the rest can be looked at; none if nothing is known of contacts.
    pub(super) view: Option<View>,
}

/// The distance that three quarters of the moments keep is the measure.
const SHARE: f64 = 0.75;
/// A mistake has to bring the pusher so much nearer to the outline; one of a unit much more so.
const NEARER: f64 = 0.25;
const NEARER_BY_UNIT: f64 = 0.02;
/// Distances that are small in any case, over the object's size.
const NEAR: f64 = 0.03;
/// Distances that no calibration explains, over the object's size: a warning, and an error.
const FAR: f64 = 0.4;
const ELSEWHERE: f64 = 1.0;
/// Mistakes whose distances differ by less explain as much.
const AS_GOOD: f64 = 1.3;
/// By so much more moments with a possible force, one of them explains more.
const MORE_FORCES: f64 = 0.2;

/// Looks for the mistake that brings the pusher to the outline.
pub(super) fn geometry(scene: &Scene) -> Geometry {
    let recorded = View::recorded();
    let Some(distance) = distance(scene, &recorded) else {
        return Geometry { suspicion: None, view: None };
    };
    if distance <= NEAR * scene.size() {
        return Geometry { suspicion: None, view: Some(recorded) };
    }
    let measured = |view: View| Some((self::distance(scene, &view)?, view));
    let mistakes: Vec<_> = View::mistakes().into_iter().filter_map(measured).collect();
    let explains = |(at, view): &&(f64, View)| {
        *at < if view.is_unit { NEARER_BY_UNIT } else { NEARER } * distance
    };
    let least = mistakes.iter().filter(explains).map(|(at, _)| *at).fold(f64::INFINITY, f64::min);
    let as_good = mistakes.iter().filter(explains).filter(|(at, _)| *at <= AS_GOOD * least);
    let chosen = as_good.map(|(at, view)| (forces::possible(scene, view), *at, view)).reduce(
        |best, next| match (best.0, next.0) {
            (Some(of_best), Some(of_next)) if of_next > of_best + MORE_FORCES => next,
            _ => best,
        },
    );
    match chosen {
        Some((_, at, view)) => Geometry {
            suspicion: Some(Suspicion {
                what: view.what.clone(),
                evidence: format!(
                    "while the object moves, the pusher is {} from its outline (three quarters of \
                     the time, or less), and {} if that is corrected",
                    length(distance),
                    length(at)
                ),
                fix: view.fix.clone(),
                is_certain: true,
            }),
            view: Some(view.clone()),
        },
        None => unexplained(scene, distance, recorded),
    }
}

/// A pusher that is away from an object that moves, without a mistake that would explain it.
fn unexplained(scene: &Scene, distance: f64, recorded: View) -> Geometry {
    let is_certain = distance > ELSEWHERE * scene.size();
    let suspicion = (distance > FAR * scene.size()).then(|| Suspicion {
        what: "the frames of pusher and object do not fit each other, or the outline is another"
            .into(),
        evidence: format!(
            "while the object moves, the pusher is {} from its outline, and no single swap, sign \
             or unit brings it there",
            length(distance)
        ),
        fix: "check streams.robot, streams.object (transform, columns or fields) and [object]"
            .into(),
        is_certain,
    });
    Geometry { suspicion, view: (!is_certain).then_some(recorded) }
}

/// How far the pusher is from the outline while the object moves, in m.
fn distance(scene: &Scene, view: &View) -> Option<f64> {
    let gap = |(object, moment): &(usize, super::Moment)| {
        view.seen(moment, &scene.objects[*object].shape, scene.radius).contact.gap.abs()
    };
    quantile(scene.seen.iter().map(gap).collect(), SHARE)
}
