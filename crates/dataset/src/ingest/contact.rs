//! When the pusher touches the object: by force where its zero is known, confirmed by geometry.

use nalgebra::Vector2;

use crate::curves::noise::median;
use crate::ingest::force_zero::{ForceZero, UntaredReason, force_zero};
use crate::ingest::interval::Interval;
use crate::ingest::passes::without_passes;
use crate::ingest::repair::CleanStream;
use crate::ingest::scene::{GapSample, Scene};
use crate::ingest::settings::IngestSettings;
use crate::ingest::track::PoseNoise;

/// A longer time without a sample of pusher and object ends every contact, in s: the log was stopped.
const PAUSE: f64 = 1.0;
/// Samples at the end of a stretch that tell where the object lies then.
const LAST_SAMPLES: usize = 10;
/// Neighboring samples that must agree that the object has left its place: one alone is noise.
const RUN: usize = 3;

/// The contacts of one recording and what is known of its force.
pub(crate) struct Contacts {
    pub(crate) intervals: Vec<Interval>,
    /// Short losses of contact within the intervals.
    pub(crate) losses: Vec<Interval>,
    pub(crate) zero: ForceZero,
    /// Force contacts that geometry did not confirm.
    pub(crate) n_unconfirmed: usize,
    pub(crate) smallest_gap: Option<f64>,
    /// Times without a sample of pusher and object, across which no contact goes on.
    pub(crate) pauses: Vec<Interval>,
    /// How often the outline passes under the tip, or is carried past it.
    pub(crate) n_passes: usize,
}

/// Finds the contacts of a recording.
pub(crate) fn find_contacts(scene: &Scene<'_>, settings: &IngestSettings) -> Contacts {
    let gaps = scene.gaps();
    let smallest_gap = gaps.iter().map(|sample| sample.gap).reduce(f64::min);
    let pauses = scene.pauses(PAUSE);
    let (touching, losses, n_passes) = by_geometry(scene, &gaps, &pauses, settings);
    let wrench = scene.wrench.as_ref();
    let mut zero = force_zero(wrench, &gaps, settings.longest_gap, &settings.contact);
    if let (Some(wrench), ForceZero::Tared { offset_n, noise_sd_n, .. }) = (wrench, &zero) {
        let offset = Vector2::from(*offset_n);
        if let Some(normal_n) = longest_pull(scene, offset, *noise_sd_n, settings) {
            zero = ForceZero::Untared { reason: UntaredReason::Pulls { normal_n } };
        } else {
            let seen = by_force(wrench, offset, *noise_sd_n, &pauses, settings);
            let confirmed = confirm(&seen, &gaps, &touching, wrench, settings);
            let blind = touching.iter().any(|touch| {
                moves(scene, touch, settings)
                    && !confirmed.iter().any(|force| overlap(force, touch))
            });
            if blind {
                zero = ForceZero::Untared { reason: UntaredReason::Blind };
            } else {
                let n_unconfirmed = seen.len() - confirmed.len();
                let (intervals, losses) = rejoin(confirmed, settings.contact.rejoin_time);
                return Contacts {
                    intervals,
                    losses,
                    zero,
                    n_unconfirmed,
                    smallest_gap,
                    pauses,
                    n_passes,
                };
            }
        }
    }
    let (intervals, n_unconfirmed) = (touching, 0);
    Contacts { intervals, losses, zero, n_unconfirmed, smallest_gap, pauses, n_passes }
}

/// Contacts by the gap alone, each from the object's first motion on and as long as the gap stays; losses
/// within them; and how often the outline passes under the tip.
fn by_geometry(
    scene: &Scene<'_>,
    gaps: &[GapSample],
    pauses: &[Interval],
    settings: &IngestSettings,
) -> (Vec<Interval>, Vec<Interval>, usize) {
    let limits = &settings.contact;
    let levels = gaps.iter().map(|sample| (sample.t, -sample.gap));
    let touches = hysteresis(levels, pauses, -limits.touch_gap, -limits.release_gap);
    let (mut touches, losses) = rejoin(touches, limits.rejoin_time);
    for touch in &mut touches {
        touch.start = onset(scene, touch, settings);
    }
    // A log of one push has no next place to be carried to; its gap may change for a late stream's sake, or
    // for an outline's that is not the object's.
    if touches.len() < 2 && pauses.is_empty() {
        return (touches, losses, 0);
    }
    let parts: Vec<_> = touches.iter().map(|touch| without_passes(scene, touch, gaps)).collect();
    let n_passes = parts.iter().map(|(_, n)| n).sum();
    (parts.into_iter().flat_map(|(parts, _)| parts).collect(), losses, n_passes)
}

/// Contacts by the force above its noise.
fn by_force(
    wrench: &CleanStream,
    offset: Vector2<f64>,
    noise_sd: f64,
    pauses: &[Interval],
    settings: &IngestSettings,
) -> Vec<Interval> {
    let levels = (0..wrench.t.len()).map(|i| {
        let force = Vector2::new(wrench.channels[0][i], wrench.channels[1][i]);
        (wrench.t[i], (force - offset).norm())
    });
    let limits = &settings.contact;
    let on = (limits.force_on * noise_sd).max(limits.least_force);
    hysteresis(levels, pauses, on, on * limits.force_off / limits.force_on)
}

/// Keeps the force contacts during which the pusher comes within reach of the outline, as far as it
/// is within reach: sensors ring after a stop, and a mounted tool has inertia.
///
/// A contact that is on when the force stream begins, begins when geometry says so.
fn confirm(
    seen: &[Interval],
    gaps: &[GapSample],
    touching: &[Interval],
    wrench: &CleanStream,
    settings: &IngestSettings,
) -> Vec<Interval> {
    seen.iter()
        .filter_map(|interval| {
            let reached = within_reach(interval, gaps, settings)?;
            let earlier = touching.iter().find(|touch| overlap(touch, interval));
            Some(match earlier {
                Some(touch) if wrench.t.first() == Some(&interval.start) => {
                    Interval { start: touch.start.min(reached.start), ..reached }
                }
                _ => reached,
            })
        })
        .collect()
}

/// The part of an interval from the first to the last time at which the gap is small enough; where
/// the gap is not known it counts as small.
fn within_reach(
    interval: &Interval,
    gaps: &[GapSample],
    settings: &IngestSettings,
) -> Option<Interval> {
    let first = gaps.partition_point(|sample| sample.t < interval.start - settings.longest_gap);
    let after = gaps.partition_point(|sample| sample.t <= interval.end);
    let around = gaps.get(first..after)?;
    let near = |sample: &GapSample| sample.gap <= settings.contact.release_gap;
    let (from, to) = (around.iter().position(near)?, around.iter().rposition(near)?);
    let mut reached = *interval;
    if from > 0 {
        reached.start = reached.start.max(around[from].t);
    }
    if to + 1 < around.len() {
        reached.end = reached.end.min(around[to].t);
    }
    (reached.start < reached.end).then_some(reached)
}

/// Stretches that begin above `on` and end below `off`, or where a pause begins; the level crosses them on
/// straight lines.
fn hysteresis(
    levels: impl Iterator<Item = (f64, f64)>,
    pauses: &[Interval],
    on: f64,
    off: f64,
) -> Vec<Interval> {
    let mut out = Vec::new();
    let mut start: Option<f64> = None;
    let mut before: Option<(f64, f64)> = None;
    for (t, level) in levels {
        let is_pause =
            |(last, _): &(f64, f64)| pauses.iter().any(|pause| (*last..t).contains(&pause.start));
        if let Some((last, _)) = before.take_if(|last| is_pause(last)) {
            out.extend(start.take().map(|start| Interval { start, end: last }));
        }
        let crossing = |limit: f64| match before {
            Some((t0, level0)) if level0 != level => {
                t0 + ((limit - level0) / (level - level0)).clamp(0.0, 1.0) * (t - t0)
            }
            _ => t,
        };
        match start {
            None if level >= on => start = Some(crossing(on)),
            Some(from) if level < off => {
                out.push(Interval { start: from, end: crossing(off) });
                start = None;
            }
            _ => {}
        }
        before = Some((t, level));
    }
    if let (Some(start), Some((end, _))) = (start, before) {
        out.push(Interval { start, end });
    }
    out
}

/// Joins intervals that are closer than `time`; also returns the losses between them.
fn rejoin(intervals: Vec<Interval>, time: f64) -> (Vec<Interval>, Vec<Interval>) {
    let mut joined: Vec<Interval> = Vec::with_capacity(intervals.len());
    let mut losses = Vec::new();
    for interval in intervals {
        match joined.last_mut() {
            Some(last) if interval.start - last.end < time => {
                losses.push(Interval { start: last.end, end: interval.start });
                last.end = interval.end;
            }
            _ => joined.push(interval),
        }
    }
    (joined, losses)
}

fn overlap(a: &Interval, b: &Interval) -> bool {
    a.start <= b.end && b.start <= a.end
}

/// Whether the object leaves its place during an interval.
fn moves(scene: &Scene<'_>, interval: &Interval, settings: &IngestSettings) -> bool {
    object_onset(scene, interval, settings) < interval.end
}

/// When a touch begins to push.
///
/// Where the pusher touches at rest it is the pusher's first motion, else the object's: a pusher
/// that comes near crosses the limit of the gap before it touches.
fn onset(scene: &Scene<'_>, touch: &Interval, settings: &IngestSettings) -> f64 {
    let pusher = pusher_onset(scene, touch, settings);
    if pusher > touch.start { pusher } else { object_onset(scene, touch, settings) }
}

/// The last robot sample before the pusher leaves its place; the start if it moves from there on.
pub(crate) fn pusher_onset(
    scene: &Scene<'_>,
    interval: &Interval,
    settings: &IngestSettings,
) -> f64 {
    let robot = &scene.robot;
    let mut samples = robot.range(interval.start, interval.end);
    let Some(first) = samples.next() else { return interval.start };
    let place = [robot.channels[0][first], robot.channels[1][first]];
    let way = |i: usize| (robot.channels[0][i] - place[0]).hypot(robot.channels[1][i] - place[1]);
    match samples.find(|&i| way(i) > settings.rest.position) {
        None => interval.end,
        Some(i) if i <= first + 2 => interval.start,
        Some(i) => robot.t[i - 1],
    }
}

/// The last object sample before the object leaves its place.
///
/// The interval's start where there is no sample before the motion, its end if nothing moves.
fn object_onset(scene: &Scene<'_>, interval: &Interval, settings: &IngestSettings) -> f64 {
    const LOOK_BACK: f64 = 0.2;
    let object = &scene.object;
    let earlier = object.range(interval.start - LOOK_BACK, interval.start);
    let samples = object.range(interval.start, interval.end);
    let reference = if earlier.len() >= 3 {
        earlier
    } else {
        samples.start..(samples.start + 1).min(samples.end)
    };
    let Some(place) = median_pose(object, reference) else { return interval.start };
    let limit =
        rest_limit(scene.object_noise(interval.start - LOOK_BACK, interval.start), settings);
    let away =
        |i: usize| (i..i + RUN).all(|i| i >= samples.end || !within(object, i, place, limit));
    match samples.clone().find(|&i| away(i)) {
        None => interval.end,
        Some(i) if i == samples.start => interval.start,
        Some(i) => object.t[i - 1].max(interval.start),
    }
}

/// When the object comes to rest while the pusher still touches it; none if it moves to the end of that.
pub(crate) fn rest_in_contact(
    scene: &Scene<'_>,
    contact: &Interval,
    settings: &IngestSettings,
) -> Option<f64> {
    let rest = rest_time(scene, contact.start, contact.end, settings)?;
    // The last samples are at rest beside themselves in any case.
    (scene.object.n_samples(rest, contact.end) > 2 * LAST_SAMPLES).then_some(rest)
}

/// When the object comes to rest between two times: the first sample after which it stays.
pub(crate) fn rest_time(
    scene: &Scene<'_>,
    from: f64,
    to: f64,
    settings: &IngestSettings,
) -> Option<f64> {
    let object = &scene.object;
    let samples = object.range(from, to);
    let tail = samples.end.saturating_sub(LAST_SAMPLES).max(samples.start)..samples.end;
    let noise_from = object.t.get(tail.start).copied()?;
    let place = median_pose(object, tail)?;
    let limit = rest_limit(scene.object_noise(noise_from, to), settings);
    let away =
        |i: usize| (0..RUN).all(|k| i >= samples.start + k && !within(object, i - k, place, limit));
    let last_moving = samples.clone().rev().find(|&i| away(i));
    let first_resting = last_moving.map_or(samples.start, |i| i + 1).min(samples.end - 1);
    Some(object.t[first_resting])
}

/// When an object that nothing touches has come to rest: the first sample from which on it stays
/// where it is for a while.
///
/// Whatever moves its samples later is no motion of the push: trackers drift and tables shake.
pub(crate) fn quiet_time(
    scene: &Scene<'_>,
    from: f64,
    to: f64,
    settings: &IngestSettings,
) -> Option<f64> {
    const HALF_WINDOW: f64 = 0.05;
    const FEWEST: usize = 3;
    let object = &scene.object;
    object.range(from, to).map(|i| object.t[i]).find(|&t| {
        let (middle, end) = (t + HALF_WINDOW, t + 2.0 * HALF_WINDOW);
        let (early, late) = (object.range(t, middle), object.range(middle, end));
        if early.len().min(late.len()) < FEWEST {
            return false;
        }
        let limit = rest_limit(scene.object_noise(t, end), settings);
        let places = median_pose(object, early).zip(median_pose(object, late));
        places.is_some_and(|(a, b)| {
            (a[0] - b[0]).hypot(a[1] - b[1]) <= limit.position && (a[2] - b[2]).abs() <= limit.angle
        })
    })
}

fn rest_limit(noise: PoseNoise, settings: &IngestSettings) -> PoseNoise {
    PoseNoise {
        position: settings.rest.position.max(5.0 * noise.position),
        angle: settings.rest.angle.max(5.0 * noise.angle),
    }
}

fn median_pose(stream: &CleanStream, samples: std::ops::Range<usize>) -> Option<[f64; 3]> {
    let of = |channel: usize| median(&stream.channels[channel][samples.clone()]);
    Some([of(0)?, of(1)?, of(2)?])
}

fn within(stream: &CleanStream, i: usize, place: [f64; 3], limit: PoseNoise) -> bool {
    let [dx, dy, dangle] = [0, 1, 2].map(|k| stream.channels[k][i] - place[k]);
    dx.hypot(dy) <= limit.position && dangle.abs() <= limit.angle
}

/// The mean normal force over a stretch in which the object would pull the touching pusher.
///
/// A stretch counts from 20 ms and beyond the limit of a zero jump: shorter ones are the sensor's
/// ringing.
fn longest_pull(
    scene: &Scene<'_>,
    offset: Vector2<f64>,
    noise_sd: f64,
    settings: &IngestSettings,
) -> Option<f64> {
    const SHORTEST: f64 = 0.02;
    let wrench = scene.wrench.as_ref()?;
    let limit = -settings.contact.zero_jump.max(settings.contact.force_on * noise_sd);
    let mut stretch: Vec<f64> = Vec::new();
    let mut start = 0.0;
    let mut longest: Option<(f64, f64)> = None;
    for (i, &t) in wrench.t.iter().enumerate() {
        let Some((contact, pose)) = scene.contact_at(t) else { continue };
        if contact.gap > settings.contact.release_gap {
            stretch.clear();
            continue;
        }
        let on_pusher = Vector2::new(wrench.channels[0][i], wrench.channels[1][i]) - offset;
        let normal = -on_pusher.dot(&pose.rotate(&contact.normal));
        if normal > limit {
            stretch.clear();
            continue;
        }
        if stretch.is_empty() {
            start = t;
        }
        stretch.push(normal);
        if t - start >= SHORTEST && longest.is_none_or(|(length, _)| t - start > length) {
            longest = Some((t - start, stretch.iter().sum::<f64>() / stretch.len() as f64));
        }
    }
    longest.map(|(_, normal)| normal)
}
