//! Whether the stream of forces has the clock of the poses.

use nalgebra::Vector2;

use super::mistake::View;
use super::scene::{Evidence, Scene};
use super::{Check, Find, Suspicion};
use crate::curves::sample::quantile;

pub(super) const CHECK: Check = Check {
    id: "force-clock",
    looks_at: "by how much the mean force in motion differs from that before any, with its times shifted",
    names: "a stream of forces that is seconds late or early, or of another clock",
    find: Find::Forces(find),
};

/// Shorter shifts, in s, are latencies, which a diagnosis measures.
pub(super) const SHORTEST: f64 = 0.25;
/// Shifts that are looked at to either side, in s.
const FARTHEST: f64 = 6.0;
/// Seconds between two shifts.
const STEP: f64 = 0.02;
/// Share of the largest difference below which forces without a shift are late. Where all is right,
/// 32 measured pushes of half a second, whose pusher stays in touch afterwards, keep 0.68 and longer
/// or simulated ones 0.78 and more. With their forces 0.1 s late the former keep 0.32, and from
/// 0.25 s on nothing.
const KEPT: f64 = 0.5;
/// Share of the recordings whose pushes have forces.
const KNOWN: f64 = 0.5;

/// How forces would fit the object's motion best.
pub(super) struct Alignment {
    /// By how much their stamps are later than those of the object, in s.
    pub(super) later: f64,
    /// The difference of means without a shift, over the one with it.
    kept: f64,
}

fn find(scene: &Scene<'_>, _: &View) -> Option<Suspicion> {
    if !scene.has_forces() {
        return None;
    }
    let n = scene.recordings.iter().filter(|one| one.wrench.span().is_some()).count();
    let missing = scene.recordings.iter().filter(|one| {
        one.wrench.span().is_some() && one.wrench.mean(one.motion.moving.iter().copied()).is_none()
    });
    let missing = missing.count();
    let found = alignment(scene);
    let shifted = found.filter(|found| found.later.abs() >= SHORTEST && found.kept < KEPT);
    let is_apart = missing as f64 > KNOWN * n as f64;
    if shifted.is_none() && !is_apart {
        return None;
    }
    let (what, fix) = match &shifted {
        Some(Alignment { later, .. }) => (
            format!(
                "the stream of forces is {:.2} s {}",
                later.abs(),
                if *later > 0.0 { "late" } else { "early" }
            ),
            format!(
                "set t with offset = {:.2} under streams.wrench.columns (or fields), or time = \
                 \"log\" if the stamps are of another clock",
                -later
            ),
        ),
        None => (
            "the stream of forces is of another clock".to_owned(),
            "set t with scale and offset under streams.wrench.columns (or fields), or time = \
             \"log\""
                .to_owned(),
        ),
    };
    let kept = shifted.map_or(String::new(), |found| {
        format!(
            "; force in motion and before it differ by {:.0} % of what they do with the shift",
            100.0 * found.kept
        )
    });
    let evidence = format!("in {missing} of {n} recordings no force is known in motion{kept}");
    Some(Suspicion { what, evidence, fix, is_certain: true })
}

/// The shift of the forces with which motion and rest differ most; none without forces.
pub(super) fn alignment(scene: &Scene<'_>) -> Option<Alignment> {
    let known: Vec<&Evidence> =
        scene.recordings.iter().filter(|one| one.wrench.span().is_some()).collect();
    let starts = known.iter().filter_map(|one| Some(one.wrench.span()?[0] - one.motion.span[0]));
    let centers = [Some(0.0), quantile(starts.collect(), 0.5)];
    let difference = |later: f64| known.iter().map(|one| one_difference(one, later)).sum::<f64>();
    let n = (FARTHEST / STEP) as i32;
    let shifts = centers.into_iter().flatten().flat_map(|center| {
        // The smaller shift first: of two that are as good it is the likelier one.
        (0..=2 * n).map(move |k| {
            let size = STEP * f64::from((k + 1) / 2);
            center + if k % 2 == 0 { size } else { -size }
        })
    });
    let measured = shifts.map(|later| (later, difference(later)));
    let (later, most) = measured.reduce(|a, b| if b.1 > a.1 { b } else { a })?;
    (most > 0.0).then(|| Alignment { later, kept: difference(0.0) / most })
}

/// The size of the difference of the mean forces in motion and before any, in N, with the force's
/// stamps so many seconds later; 0 where one of them is not known.
fn one_difference(one: &Evidence, later: f64) -> f64 {
    let moved = |[from, to]: [f64; 2]| [from + later, to + later];
    let moving = one.wrench.mean(one.motion.moving.iter().copied().map(moved));
    let resting = one.wrench.mean(one.motion.before().into_iter().map(moved));
    match (moving, resting) {
        (Some(moving), Some(resting)) => Vector2::norm(&(moving - resting)),
        _ => 0.0,
    }
}
