//! Whether the streams of pusher and object have one clock.

use super::force_clock::SHORTEST;
use super::mistake::View;
use super::numbers::length;
use super::places::{NEAR, NEARER, SHARE, distance};
use super::scene::Scene;
use super::{Check, Explanation, Find, Suspicion, force_clock};
use crate::curves::sample::quantile;

pub(super) const CHECK: Check = Check {
    id: "stream-clock",
    looks_at: "the same distance with the pusher's times shifted, and whether the streams meet in time",
    names: "a stream of poses that is seconds late or early",
    find: Find::Places(find),
};

/// Shifts that are looked at to either side of where streams begin or end together, in s.
const FARTHEST: f64 = 6.0;
/// Way of the object in a latency, over its size, from which that is told as well.
const WIDE: f64 = 0.2;
/// Distances with the shift that are near, over the object's size.
const NEAR_SHIFTED: f64 = 0.06;
/// Way of the object between two shifts, over its size.
const WAY: f64 = 0.03;
/// Seconds between two shifts, at least and at most.
const STEP: (f64, f64) = (2e-3, 0.05);
/// Moments that are looked at for each shift.
const MOST_MOMENTS: usize = 150;
/// Share of the moments for which the pusher has to be known.
const KNOWN: f64 = 0.5;

fn find(scene: &Scene<'_>) -> Option<Explanation> {
    let n_moments: usize = scene.recordings.iter().map(|one| one.motion.len()).sum();
    let is_met = scene.n_met as f64 >= KNOWN * n_moments as f64;
    let recorded = if is_met { distance(scene, &View::recorded()) } else { None };
    if n_moments == 0 || recorded.is_some_and(|distance| distance <= NEAR * scene.size()) {
        return None;
    }
    let Some((later, at)) = best(scene, n_moments) else {
        return recorded.is_none().then(|| apart(scene, n_moments));
    };
    let is_near = at <= NEAR_SHIFTED * scene.size();
    let is_nearer = recorded.is_none_or(|distance| at <= NEARER * distance);
    let is_long = later.abs() >= SHORTEST;
    let is_wide = object_speed(scene).is_some_and(|v| v * later.abs() >= WIDE * scene.size());
    if !is_near || !is_nearer || !(is_long || is_wide) {
        return recorded.is_none().then(|| apart(scene, n_moments));
    }
    let was = match recorded {
        Some(distance) => format!("the pusher is {} from its outline", length(distance)),
        None => "the pusher is not known".to_owned(),
    };
    let (what, fix) = words(scene, later);
    let evidence = format!(
        "while the object moves, {was} (three quarters of the time, or less), and {} from it with the \
         pusher's stream shifted by {:.2} s",
        length(at),
        -later
    );
    let suspicion = Suspicion { what, evidence, fix, is_certain: is_long };
    Some(Explanation { distance: at, suspicion: Some(suspicion), view: None })
}

/// Which stream is late, as far as the forces tell, and what to correct.
fn words(scene: &Scene<'_>, later: f64) -> (String, String) {
    let force = force_clock::alignment(scene).map(|found| found.later);
    let is_with = |shift: f64| force.is_some_and(|force| (force - shift).abs() < SHORTEST);
    let late = |shift: f64| if shift > 0.0 { "late" } else { "early" };
    let seconds = later.abs();
    let fix = |stream: &str, offset: f64| {
        format!(
            "set t with offset = {offset:.2} under streams.{stream}.columns (or fields), or time = \
             \"log\" if the stamps are of another clock"
        )
    };
    match (is_with(0.0), is_with(later)) {
        (true, false) => {
            let how = late(later);
            let what =
                format!("the pusher's stream is {seconds:.2} s {how} against object and force");
            (what, fix("robot", -later))
        }
        (false, true) => {
            let how = late(-later);
            let what =
                format!("the object's stream is {seconds:.2} s {how} against pusher and force");
            (what, fix("object", later))
        }
        _ => {
            let what = format!(
                "the pusher's stream is {seconds:.2} s {} against the object's, or the object's {}",
                late(later),
                late(-later)
            );
            (what, fix("robot", -later) + "; or of streams.object the other way round")
        }
    }
}

/// Streams that share no time, and no shift that brings them together.
fn apart(scene: &Scene<'_>, n_moments: usize) -> Explanation {
    let spans = |of: &dyn Fn(&super::scene::Evidence) -> Option<[f64; 2]>, end: usize| {
        quantile(scene.recordings.iter().filter_map(|one| Some(of(one)?[end])).collect(), 0.5)
            .unwrap_or(f64::NAN)
    };
    let robot = |one: &super::scene::Evidence| one.robot.span();
    let object = |one: &super::scene::Evidence| Some(one.motion.span);
    let suspicion = Suspicion {
        what: "the streams of pusher and object are of different clocks".into(),
        evidence: format!(
            "in {} of {n_moments} moments in which the object moves, the pusher's stream has no \
             samples; typically that lasts from {:.1} to {:.1} s, and the object's from {:.1} to \
             {:.1} s",
            n_moments - scene.n_met,
            spans(&robot, 0),
            spans(&robot, 1),
            spans(&object, 0),
            spans(&object, 1),
        ),
        fix:
            "set t with scale and offset under streams.robot.columns or streams.object.columns (or \
              fields), or time = \"log\""
                .into(),
        is_certain: true,
    };
    Explanation { distance: scene.size(), suspicion: Some(suspicion), view: None }
}

/// The shift with which the pusher is nearest to the outline, in s, and how near, in m.
fn best(scene: &Scene<'_>, n_moments: usize) -> Option<(f64, f64)> {
    let stops = scene
        .recordings
        .iter()
        .filter_map(|one| Some(one.robot.stop()? - one.motion.moving.last()?[1]));
    let centers = [Some(0.0), quantile(stops.collect(), 0.5)];
    let step = (WAY * scene.size() / object_speed(scene)?).clamp(STEP.0, STEP.1);
    let n = (FARTHEST / step).ceil() as i32;
    let stride = n_moments.div_ceil(MOST_MOMENTS).max(1);
    let measured = |later: f64| Some((later, shifted(scene, later, stride)?));
    let around = |center: f64, step: f64, n: i32| {
        (-n..=n).filter_map(move |k| measured(center + step * f64::from(k)))
    };
    let nearest = |a: (f64, f64), b: (f64, f64)| if b.1 < a.1 { b } else { a };
    let coarse = centers.into_iter().flatten().flat_map(|center| around(center, step, n));
    let (coarse, _) = coarse.reduce(nearest)?;
    around(coarse, 0.1 * step, 10).reduce(nearest)
}

/// How far the pusher is from the outline with its times shifted, in m; none if it is not known.
fn shifted(scene: &Scene<'_>, later: f64, stride: usize) -> Option<f64> {
    let (mut gaps, mut n) = (Vec::new(), 0);
    for one in &scene.recordings {
        for (t, pose) in one.motion.places().step_by(stride) {
            n += 1;
            let Some(pusher) = one.robot.at(t + later) else { continue };
            let center = pose.inverse_transform_point(&pusher);
            gaps.push(one.object.shape.contact(&center, scene.radius()).gap.abs());
        }
    }
    if (gaps.len() as f64) < KNOWN * f64::from(n) {
        return None;
    }
    quantile(gaps, SHARE)
}

/// Median speed of the object while it moves, in m/s.
fn object_speed(scene: &Scene<'_>) -> Option<f64> {
    let speeds = scene.recordings.iter().flat_map(|one| one.motion.speeds());
    quantile(speeds.collect(), 0.5).filter(|speed| *speed > 0.0)
}
