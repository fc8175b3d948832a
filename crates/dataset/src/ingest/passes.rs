//! Touches that no rigid push makes: the outline passes under a lifted tip, or is carried past it.

use crate::ingest::interval::Interval;
use crate::ingest::scene::{GapSample, Scene};

/// While a rigid object is pushed its gap to the tip stays; noise and play are less than this, in m.
const PLAY: f64 = 1e-3;
/// Where it changes by more, the tip is over the object or the object is moved by something else, in m.
const PASS: f64 = 5e-3;

/// The parts of a touch in which the gap stays as it is at their start, and how often it leaves that by more
/// than any push explains.
///
/// What is left over before or after such a passage has to have a way of the pusher of its own.
pub(crate) fn without_passes(
    scene: &Scene<'_>,
    touch: &Interval,
    gaps: &[GapSample],
) -> (Vec<Interval>, usize) {
    let first = gaps.partition_point(|sample| sample.t < touch.start);
    let samples = &gaps[first..gaps.partition_point(|sample| sample.t <= touch.end)];
    let (mut parts, mut n_passes) = (Vec::new(), 0);
    let mut from = 0;
    while let Some(start) = samples.get(from) {
        let off = |sample: &GapSample| (sample.gap - start.gap).abs();
        let passed = samples[from..].iter().position(|sample| off(sample) > PASS);
        let begin = if from == 0 { touch.start } else { start.t };
        let Some(passed) = passed.map(|passed| from + passed) else {
            let part = Interval { start: begin, end: touch.end };
            parts.extend(is_push(scene, &part, n_passes > 0).then_some(part));
            break;
        };
        n_passes += 1;
        let stays = samples[from..passed].iter().rposition(|sample| off(sample) <= PLAY);
        let end = samples[from + stays.unwrap_or(0)].t;
        let part = Interval { start: begin, end };
        parts.extend(is_push(scene, &part, true).then_some(part));
        let back = samples[passed..].iter().position(|sample| off(sample) <= PLAY);
        from = passed + back.unwrap_or(samples.len());
    }
    if samples.is_empty() {
        parts.push(*touch);
    }
    (parts, n_passes)
}

/// Whether a part beside a passage is long enough to be a push.
fn is_push(scene: &Scene<'_>, part: &Interval, is_beside_pass: bool) -> bool {
    let ends = [part.start, part.end].map(|t| scene.robot_track.position(t));
    let way = match ends {
        [Some(start), Some(end)] => (end - start).norm(),
        _ => 0.0,
    };
    !is_beside_pass || way > PASS
}
