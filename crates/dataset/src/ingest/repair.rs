//! Repair of streams: order, duplicates, wraps, jumps and gaps, each found, counted and named.

use std::{collections::BTreeMap, f64::consts::PI};

use planar::wrap_angle;
use serde::{Deserialize, Serialize};

use crate::curves::noise::median;
use crate::formats::assemble::LARGEST;
use crate::ingest::settings::IngestSettings;
use crate::recording::{PoseStream, WrenchStream};

/// Samples closer than this share of the median spacing are merged: a spline through two stamps
/// that nearly agree swings out between its other samples.
const CROWDED_SHARE: f64 = 0.5;
/// Farthest time from the recording's zero, in s: three hundred years.
const LAST_TIME: f64 = 1e10;
/// Turns a difference of yaw into a length, about the size of a pushed object, in m.
const YAW_ARM: f64 = 0.05;

/// The kinds of repairs and findings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum RepairKind {
    /// A sample with a value that is not finite or beyond anything physical, dropped.
    NonFinite,
    /// A stamp before that of the row before it.
    Backward,
    /// A stamp equal to another, merged with it by the mean.
    Duplicate,
    /// A stamp closer to another than half of the usual spacing, merged with it by the mean.
    Crowded,
    /// A sample that repeats the one before to the last bit amid motion, dropped: its source is
    /// slower than its stamps.
    Repeated,
    /// A turn of yaw across ±π, unwrapped.
    Wrap,
    /// A way or turn between neighboring samples beyond the limit, across a gap or beyond what the
    /// motion before or after explains; kept.
    Jump,
    /// A jump too fast for any motion; nothing is evaluated across it.
    Teleport,
    /// A time between neighboring samples beyond the limit; nothing is evaluated across it.
    Gap,
    /// A sample alone between two gaps, not used.
    Isolated,
}

/// One repair or finding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Repair {
    /// What was found.
    pub kind: RepairKind,
    /// When, on the recording's clock, in s.
    pub t: f64,
    /// How much: length of a gap or shift of a stamp in s, way of a jump in m; else 0.
    pub amount: f64,
}

/// A stream in order, with increasing stamps, and what was done to it.
///
/// - `channels`: x, y and unwrapped yaw of a pose, or fx and fy of a force.
/// - `breaks`: numbers of the samples at which a new piece begins.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct CleanStream {
    pub(crate) t: Vec<f64>,
    pub(crate) channels: Vec<Vec<f64>>,
    pub(crate) breaks: Vec<usize>,
    pub(crate) repairs: Vec<Repair>,
    pub(crate) kept_row_order: bool,
    pub(crate) n_read: usize,
}

impl CleanStream {
    /// Counts of all repairs between two times.
    pub(crate) fn counts(&self, from: f64, to: f64) -> BTreeMap<RepairKind, u32> {
        let mut counts = BTreeMap::new();
        for repair in self.repairs.iter().filter(|repair| (from..=to).contains(&repair.t)) {
            *counts.entry(repair.kind).or_default() += 1;
        }
        counts
    }

    /// Largest amount of one kind between two times, 0 if there is none.
    pub(crate) fn largest(&self, kind: RepairKind, from: f64, to: f64) -> f64 {
        self.repairs
            .iter()
            .filter(|repair| repair.kind == kind && (from..=to).contains(&repair.t))
            .fold(0.0, |largest, repair| repair.amount.max(largest))
    }

    /// Number of samples in [from, to].
    pub(crate) fn n_samples(&self, from: f64, to: f64) -> usize {
        self.range(from, to).len()
    }

    /// The numbers of the samples in [from, to].
    pub(crate) fn range(&self, from: f64, to: f64) -> std::ops::Range<usize> {
        let first = self.t.partition_point(|&t| t < from);
        first..self.t.partition_point(|&t| t <= to).max(first)
    }

    /// Longest time without a sample in [from, to], counting the ends, in s.
    pub(crate) fn longest_gap(&self, from: f64, to: f64) -> f64 {
        let inside = &self.t[self.range(from, to)];
        let mut last = from;
        let mut longest = 0.0_f64;
        for &t in inside.iter().chain(std::iter::once(&to)) {
            longest = longest.max(t - last);
            last = t;
        }
        longest
    }

    /// Time in [from, to] that lies in gaps longer than `limit`, in s.
    pub(crate) fn time_in_gaps(&self, from: f64, to: f64, limit: f64) -> f64 {
        let mut last = from;
        let mut lost = 0.0;
        for &t in self.t[self.range(from, to)].iter().chain(std::iter::once(&to)) {
            if t - last > limit {
                lost += t - last;
            }
            last = t;
        }
        lost
    }

    /// Median rate, in Hz; none for fewer than two samples.
    pub(crate) fn rate(&self) -> Option<f64> {
        median_spacing(&self.t).map(|spacing| 1.0 / spacing)
    }
}

/// Brings the object's poses into order.
pub(crate) fn repair_poses(stream: &PoseStream, settings: &IngestSettings) -> CleanStream {
    repaired(&stream.t, [&stream.x, &stream.y, &stream.theta], settings)
}

/// Brings the positions of the robot into order; its yaw, which tells nothing of a round pusher and
/// is not defined for a tool that points down, is taken as 0.
pub(crate) fn repair_positions(stream: &PoseStream, settings: &IngestSettings) -> CleanStream {
    let still = vec![0.0; stream.len()];
    repaired(&stream.t, [&stream.x, &stream.y, &still], settings)
}

fn repaired(t: &[f64], channels: [&[f64]; 3], settings: &IngestSettings) -> CleanStream {
    let mut clean = ordered(t, &channels, Some(2));
    drop_repeats(&mut clean, settings.rest.position);
    let (t, channels) = (&clean.t, &clean.channels);
    let change = |channel: usize, i: usize| channels[channel][i + 1] - channels[channel][i];
    let n = t.len().saturating_sub(1);
    let step = |i: usize| (t[i + 1] - t[i], change(0, i).hypot(change(1, i)), change(2, i).abs());
    let mut found = Vec::new();
    for i in 0..n {
        // No way is longer than along both axes; roots take time.
        let longest = change(0, i).abs() + change(1, i).abs();
        if longest <= 0.5 * settings.jump_position && change(2, i).abs() <= settings.jump_angle {
            continue;
        }
        let (dt, way, turn) = step(i);
        if way <= settings.jump_position && turn <= settings.jump_angle {
            continue;
        }
        let fast = way > settings.fastest_speed * dt || turn > settings.fastest_turn * dt;
        let explained = expected_step(&step, n, i);
        let kind = if fast {
            RepairKind::Teleport
        } else if dt > settings.longest_gap
            || way - explained.0 > settings.jump_position
            || turn - explained.1 > settings.jump_angle
        {
            RepairKind::Jump
        } else {
            continue;
        };
        found.push((i + 1, Repair { kind, t: t[i + 1], amount: way }));
    }
    for (i, repair) in found {
        clean.repairs.push(repair);
        if repair.kind == RepairKind::Teleport {
            clean.breaks.push(i);
        }
    }
    find_gaps(&mut clean, settings.longest_gap);
    clean
}

/// Way and turn of step i of n at the median rates of the steps around it.
fn expected_step(step: &impl Fn(usize) -> (f64, f64, f64), n: usize, i: usize) -> (f64, f64) {
    const EACH_SIDE: usize = 3;
    let around = i.saturating_sub(EACH_SIDE)..(i + EACH_SIDE + 1).min(n);
    let others = || around.clone().filter(|&k| k != i).map(step);
    let ways: Vec<_> = others().map(|(dt, way, _)| way / dt).collect();
    let turns: Vec<_> = others().map(|(dt, _, turn)| turn / dt).collect();
    let expected = |rates: &[f64]| step(i).0 * median(rates).unwrap_or_default();
    (expected(&ways), expected(&turns))
}

/// Brings a force stream into order.
pub(crate) fn repair_forces(stream: &WrenchStream, settings: &IngestSettings) -> CleanStream {
    let mut clean = ordered(&stream.t, &[&stream.fx, &stream.fy], None);
    find_gaps(&mut clean, settings.longest_gap);
    clean
}

/// Drops lone samples that repeat the one before while the body moves by more than `rest` to or from
/// them; longer runs are rest.
fn drop_repeats(clean: &mut CleanStream, rest: f64) {
    let [x, y, angle] = [0, 1, 2].map(|k| &clean.channels[k]);
    let way = |i: usize| (x[i] - x[i - 1]).hypot(y[i] - y[i - 1]);
    let is_still = |i: usize| x[i] == x[i - 1] && y[i] == y[i - 1] && angle[i] == angle[i - 1];
    let repeats = |&i: &usize| {
        let lone = is_still(i) && !is_still(i - 1) && !is_still(i + 1);
        lone && way(i - 1).max(way(i + 1)) > rest
    };
    let repeated: Vec<_> = (2..x.len().saturating_sub(1)).filter(repeats).collect();
    if repeated.is_empty() {
        return;
    }
    for &i in repeated.iter().rev() {
        clean.repairs.push(Repair { kind: RepairKind::Repeated, t: clean.t[i], amount: 0.0 });
    }
    for column in std::iter::once(&mut clean.t).chain(&mut clean.channels) {
        let mut index = 0..;
        column.retain(|_| index.next().is_some_and(|i| repeated.binary_search(&i).is_err()));
    }
}

fn find_gaps(clean: &mut CleanStream, longest_gap: f64) {
    for i in 1..clean.t.len() {
        let amount = clean.t[i] - clean.t[i - 1];
        if amount > longest_gap {
            clean.repairs.push(Repair { kind: RepairKind::Gap, t: clean.t[i - 1], amount });
            clean.breaks.push(i);
        }
    }
    clean.breaks.sort_unstable();
    clean.breaks.dedup();
    let mut edges = clean.breaks.clone();
    edges.insert(0, 0);
    edges.push(clean.t.len());
    for pair in edges.windows(2).filter(|pair| pair[1] == pair[0] + 1) {
        let t = clean.t[pair[0]];
        clean.repairs.push(Repair { kind: RepairKind::Isolated, t, amount: 0.0 });
    }
}

/// Drops what is not finite, orders the rest, unwraps the yaw and merges crowded stamps.
fn ordered(t: &[f64], channels: &[&[f64]], yaw: Option<usize>) -> CleanStream {
    let mut repairs = Vec::new();
    // Infinite and undefined numbers are beyond every bound as well.
    let usable =
        |i: usize| t[i].abs() <= LAST_TIME && channels.iter().all(|c| c[i].abs() <= LARGEST);
    let mut rows = Vec::with_capacity(t.len());
    let mut last = t.iter().copied().find(|t| t.abs() <= LAST_TIME).unwrap_or(0.0);
    for (i, &stamp) in t.iter().enumerate() {
        if usable(i) {
            if stamp < last {
                let amount = last - stamp;
                repairs.push(Repair { kind: RepairKind::Backward, t: stamp, amount });
            }
            last = stamp;
            rows.push(i);
        } else {
            repairs.push(Repair { kind: RepairKind::NonFinite, t: last, amount: 0.0 });
        }
    }
    let mut kept_row_order = false;
    let mut stamps: Vec<_> = rows.iter().map(|&i| t[i]).collect();
    if repairs.iter().any(|repair| repair.kind == RepairKind::Backward) {
        let mut sorted = rows.clone();
        sorted.sort_by(|&i, &j| t[i].total_cmp(&t[j]));
        kept_row_order = way(channels, yaw, &rows) < way(channels, yaw, &sorted);
        if kept_row_order {
            make_monotone(&mut stamps);
        } else {
            rows = sorted;
            stamps = rows.iter().map(|&i| t[i]).collect();
        }
    }
    let mut columns: Vec<Vec<f64>> =
        channels.iter().map(|c| rows.iter().map(|&i| c[i]).collect()).collect();
    if let Some(yaw) = yaw {
        unwrap(&stamps, &mut columns[yaw], &mut repairs);
    }
    let (stamps, columns) = merge_crowded(stamps, columns, &mut repairs);
    CleanStream {
        t: stamps,
        channels: columns,
        breaks: Vec::new(),
        repairs,
        kept_row_order,
        n_read: t.len(),
    }
}

/// Length of the way through the samples in some order.
///
/// Rows that arrive late keep their order while their stamps jitter, rows of several senders do
/// not: the order in which the body travels less is the true one.
fn way(channels: &[&[f64]], yaw: Option<usize>, order: &[usize]) -> f64 {
    let step = |i: usize, j: usize| {
        channels.iter().enumerate().map(move |(k, channel)| {
            let difference = channel[j] - channel[i];
            if Some(k) == yaw { YAW_ARM * wrap_angle(difference) } else { difference }
        })
    };
    order.windows(2).map(|p| step(p[0], p[1]).map(|d| d * d).sum::<f64>().sqrt()).sum()
}

/// The closest stamps, in least squares, that never run backward (pool adjacent violators).
fn make_monotone(stamps: &mut [f64]) {
    let mut pools: Vec<(f64, usize)> = Vec::with_capacity(stamps.len());
    for &stamp in stamps.iter() {
        let (mut mean, mut n) = (stamp, 1);
        while let Some(&(before, n_before)) = pools.last().filter(|pool| pool.0 > mean) {
            mean = (mean * n as f64 + before * n_before as f64) / (n + n_before) as f64;
            n += n_before;
            pools.pop();
        }
        pools.push((mean, n));
    }
    let pooled = pools.into_iter().flat_map(|(mean, n)| std::iter::repeat_n(mean, n));
    for (stamp, mean) in stamps.iter_mut().zip(pooled) {
        *stamp = mean;
    }
}

fn unwrap(t: &[f64], yaw: &mut [f64], repairs: &mut Vec<Repair>) {
    let mut turns = 0.0;
    for i in 1..yaw.len() {
        let raw = yaw[i] + turns;
        let unwrapped = yaw[i - 1] + wrap_angle(raw - yaw[i - 1]);
        if (raw - unwrapped).abs() > PI {
            repairs.push(Repair { kind: RepairKind::Wrap, t: t[i], amount: 0.0 });
            turns += unwrapped - raw;
        }
        yaw[i] = unwrapped;
    }
}

fn median_spacing(t: &[f64]) -> Option<f64> {
    let spacings: Vec<_> =
        t.windows(2).map(|pair| pair[1] - pair[0]).filter(|&spacing| spacing > 0.0).collect();
    median(&spacings)
}

fn merge_crowded(
    t: Vec<f64>,
    columns: Vec<Vec<f64>>,
    repairs: &mut Vec<Repair>,
) -> (Vec<f64>, Vec<Vec<f64>>) {
    let closest = CROWDED_SHARE * median_spacing(&t).unwrap_or(0.0);
    let is_crowded = |pair: &[f64]| pair[1] - pair[0] < closest || pair[1] == pair[0];
    if !t.windows(2).any(is_crowded) {
        return (t, columns);
    }
    let mut merged = Vec::with_capacity(t.len());
    let mut out = vec![Vec::with_capacity(t.len()); columns.len()];
    let mut start = 0;
    while start < t.len() {
        let mut end = start + 1;
        while end < t.len() && (t[end] - t[start] < closest || t[end] == t[start]) {
            let same = t[end] == t[end - 1];
            let kind = if same { RepairKind::Duplicate } else { RepairKind::Crowded };
            repairs.push(Repair { kind, t: t[end], amount: t[end] - t[start] });
            end += 1;
        }
        let mean = |values: &[f64]| {
            if end == start + 1 {
                values[start]
            } else {
                let first = values[start];
                first
                    + values[start..end].iter().map(|v| v - first).sum::<f64>()
                        / (end - start) as f64
            }
        };
        merged.push(mean(&t));
        for (out, column) in out.iter_mut().zip(&columns) {
            out.push(mean(column));
        }
        start = end;
    }
    (merged, out)
}
