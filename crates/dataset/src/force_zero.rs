//! The zero of the force sensor: estimated where the pusher is free by geometry.

use nalgebra::Vector2;
use serde::Serialize;

use crate::{
    ingest_settings::ContactSettings,
    noise::mean,
    repair::CleanStream,
    scene::GapSample,
};

/// What is known of the zero of the force sensor in one recording.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "state")]
pub enum ForceZero {
    /// There is no force stream.
    NoForce,
    /// The zero was found and is subtracted.
    Tared {
        /// Force read while the pusher was free, world frame, in N.
        offset_n: [f64; 2],
        /// Standard deviation of the force's noise, per axis, in N.
        noise_sd_n: f64,
        /// Number of samples it rests on.
        n_samples: usize,
    },
    /// The zero is not known: geometry alone decides on contact.
    Untared {
        /// Why.
        reason: UntaredReason,
    },
}

/// Why the zero of a force stream is not known.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case", tag = "reason")]
pub enum UntaredReason {
    /// The pusher is never far enough from the object for long enough.
    NeverFree,
    /// The force read by a free pusher changes.
    ZeroJumps {
        /// Largest change, in N.
        change_n: f64,
    },
    /// With the zero subtracted, the object would pull the pusher.
    Pulls {
        /// Mean normal force on the object over the longest stretch, negative, in N.
        normal_n: f64,
    },
    /// With the zero subtracted, no force is seen while the pusher moves the object.
    Blind,
}

/// The zero from all stretches in which the gap is above `free_gap`.
pub(crate) fn force_zero(
    wrench: Option<&CleanStream>,
    gaps: &[GapSample],
    longest_gap: f64,
    settings: &ContactSettings,
) -> ForceZero {
    let Some(wrench) = wrench else { return ForceZero::NoForce };
    let blocks = free_blocks(wrench, gaps, longest_gap, settings);
    let n_samples: usize = blocks.iter().map(|block| block.len()).sum();
    if n_samples < settings.fewest_free_samples {
        return ForceZero::Untared { reason: UntaredReason::NeverFree };
    }
    let all: Vec<_> = blocks.iter().flatten().copied().collect();
    let offset = mean_force(&all);
    let change_n = largest_change(&blocks);
    if change_n > settings.zero_jump {
        return ForceZero::Untared { reason: UntaredReason::ZeroJumps { change_n } };
    }
    let squares: f64 = all.iter().map(|force| (force - offset).norm_squared()).sum();
    let noise_sd_n = (squares / (2 * (n_samples - 1)) as f64).sqrt();
    ForceZero::Tared { offset_n: offset.into(), noise_sd_n, n_samples }
}

/// Force samples of free stretches, in blocks of some `fewest_free_samples` neighbors each.
fn free_blocks(
    wrench: &CleanStream,
    gaps: &[GapSample],
    longest_gap: f64,
    settings: &ContactSettings,
) -> Vec<Vec<Vector2<f64>>> {
    let mut blocks = Vec::new();
    let mut take = |from: f64, to: f64| {
        let range = wrench.range(from, to);
        let forces: Vec<_> =
            range.map(|i| Vector2::new(wrench.channels[0][i], wrench.channels[1][i])).collect();
        let mut chunks: Vec<_> =
            forces.chunks(settings.fewest_free_samples.max(1)).map(<[_]>::to_vec).collect();
        if let [.., before, last] = &mut chunks[..]
            && last.len() < before.len()
        {
            before.append(last);
            chunks.pop();
        }
        blocks.append(&mut chunks);
    };
    let mut start: Option<f64> = None;
    let mut last = f64::NEG_INFINITY;
    let mut seen_contact = false;
    for sample in gaps {
        let free = sample.gap > settings.free_gap;
        if let Some(from) = start.filter(|_| !free || sample.t - last > longest_gap) {
            take(from, last);
            start = None;
        }
        if free && start.is_none() {
            start = Some(sample.t + if seen_contact { settings.settle_time } else { 0.0 });
        }
        seen_contact |= !free;
        last = sample.t;
    }
    if let Some(from) = start {
        take(from, last);
    }
    blocks
}

fn mean_force(forces: &[Vector2<f64>]) -> Vector2<f64> {
    forces.iter().sum::<Vector2<f64>>() / forces.len() as f64
}

/// Largest difference between the means of two blocks, in N.
fn largest_change(blocks: &[Vec<Vector2<f64>>]) -> f64 {
    let means: Vec<_> = blocks.iter().map(|block| mean_force(block)).collect();
    let spread = |axis: usize| {
        let values = means.iter().map(|mean| mean[axis]);
        values.clone().fold(f64::MIN, f64::max) - values.fold(f64::MAX, f64::min)
    };
    if means.len() < 2 { 0.0 } else { spread(0).hypot(spread(1)) }
}

/// Mean force of a stream between two times, in N; none without samples.
pub(crate) fn mean_between(wrench: &CleanStream, from: f64, to: f64) -> Option<Vector2<f64>> {
    let range = wrench.range(from, to);
    let of = |channel: usize| mean(&wrench.channels[channel][range.clone()]);
    Some(Vector2::new(of(0)?, of(1)?))
}
