//! The zero of the force sensor: estimated where the pusher is free by geometry.

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use crate::curves::noise::{NORMAL_SD_OVER_MAD, mean, median};
use crate::ingest::repair::CleanStream;
use crate::ingest::scene::GapSample;
use crate::ingest::settings::ContactSettings;

/// What is known of the zero of the force sensor in one recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
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
    let runs = free_runs(wrench, gaps, longest_gap, settings);
    let all: Vec<_> = runs.iter().flatten().copied().collect();
    let n_samples = all.len();
    let Some(offset) = median_force(&all).filter(|_| n_samples >= settings.fewest_free_samples)
    else {
        return ForceZero::Untared { reason: UntaredReason::NeverFree };
    };
    let change_n = largest_change(&runs, settings.fewest_free_samples);
    if change_n > settings.zero_jump {
        return ForceZero::Untared { reason: UntaredReason::ZeroJumps { change_n } };
    }
    let misses: Vec<_> = all
        .iter()
        .flat_map(|force| [force.x - offset.x, force.y - offset.y])
        .map(f64::abs)
        .collect();
    let noise_sd_n = NORMAL_SD_OVER_MAD * median(&misses).unwrap_or_default();
    ForceZero::Tared { offset_n: offset.into(), noise_sd_n, n_samples }
}

/// Force samples of each stretch in which the pusher is free.
fn free_runs(
    wrench: &CleanStream,
    gaps: &[GapSample],
    longest_gap: f64,
    settings: &ContactSettings,
) -> Vec<Vec<Vector2<f64>>> {
    let mut runs = Vec::new();
    let mut take = |from: f64, to: f64| {
        let range = wrench.range(from, to);
        runs.push(
            range.map(|i| Vector2::new(wrench.channels[0][i], wrench.channels[1][i])).collect(),
        );
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
    runs
}

/// The median of each component: ringing after a stop is short and does not count.
fn median_force(forces: &[Vector2<f64>]) -> Option<Vector2<f64>> {
    let of = |axis: usize| median(&forces.iter().map(|force| force[axis]).collect::<Vec<_>>());
    Some(Vector2::new(of(0)?, of(1)?))
}

/// Largest difference between the forces of two stretches, or of the halves of one, in N.
fn largest_change(runs: &[Vec<Vector2<f64>>], fewest: usize) -> f64 {
    let levels: Vec<_> = runs
        .iter()
        .flat_map(|run| run.chunks(run.len().div_ceil(2).max(fewest).max(1)))
        .filter(|part| part.len() >= fewest)
        .filter_map(median_force)
        .collect();
    let apart = |a: &Vector2<f64>| levels.iter().map(|b| (a - b).norm()).fold(0.0, f64::max);
    levels.iter().map(apart).fold(0.0, f64::max)
}

/// Mean force of a stream between two times, in N; none without samples.
pub(crate) fn mean_between(wrench: &CleanStream, from: f64, to: f64) -> Option<Vector2<f64>> {
    let range = wrench.range(from, to);
    let of = |channel: usize| mean(&wrench.channels[channel][range.clone()]);
    Some(Vector2::new(of(0)?, of(1)?))
}
