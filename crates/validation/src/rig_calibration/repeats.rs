//! One push over and over, on every published surface.

use std::path::Path;

use anyhow::{Context, Result};
use nalgebra::Rotation2;
use planar::{Pose, wrap_angle};
use plant::{GenerateSettings, Layout, PlannedPush, Scatter, Truth, simulate};
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

use super::Rig;
use super::described::median;
use super::put_back::put_back;
use super::row::Row;

/// Published scatter of the end of 2000 repeats of a push: position in mm, turn in °.
const PUBLISHED: [(&str, f64, f64); 4] =
    [("abs", 5.5, 3.2), ("delrin", 3.4, 1.3), ("plywood", 8.1, 4.2), ("pu", 11.7, 4.5)];
/// The push, as the program that collected the data had it (`peterkty/pnpush`): its place on the edge,
/// along the normal, its way in m, its speed in m/s. Repeats are alike for the object; on the table they
/// begin where the last one left it, or where the robot dragged it back to.
const P: f64 = 0.7;
const WAY: f64 = 0.15;
const SPEED: f64 = 0.02;
/// Repeats of one rig have seeds of their own, so many at most.
const SEEDS: u64 = 100_000;
/// Width of a mode, over the standard deviation, and its height over the highest.
const WIDTH: f64 = 0.2;
const HEIGHT: f64 = 0.1;

/// Standard deviations of the end, as medians over seeds, and the number of modes of the turn.
pub(super) fn rows(with: Option<&Path>, seeds: &[u64], n: usize) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for (surface, position, turn) in PUBLISHED {
        let rig = Rig::of(surface, with)?;
        let ends = seeds.par_iter().map(|&seed| End::of(&rig, seed, n).context(surface));
        let ends = ends.collect::<Result<Vec<_>>>()?;
        let middle = |value: fn(&End) -> f64| median(ends.iter().map(value).collect());
        let name = format!("repeats on {surface}");
        let [place, turned] = [middle(|end| end.position), middle(|end| end.turn)];
        rows.push(Row::new(format!("{name}, position / mm"), place, Some(position)));
        rows.push(Row::new(format!("{name}, turn / °"), turned, Some(turn)));
        rows.push(Row::new(format!("{name}, modes"), middle(|end| end.modes), None));
    }
    Ok(rows)
}

/// Scatter of the end of a push: root of the summed variances in mm, sd in °, modes of the turn.
struct End {
    position: f64,
    turn: f64,
    modes: f64,
}

/// The push of an object that lies there: the tip's path is planned from where the object is seen.
fn push_from(pose: &Pose) -> PlannedPush {
    PlannedPush {
        edge: 0,
        p: P,
        angle: 0.0,
        speed: SPEED,
        travel: WAY,
        place: [pose.position.x, pose.position.y, wrap_angle(pose.angle)],
        session: 0,
        repeat: "a".into(),
    }
}

impl End {
    fn of(rig: &Rig, seed: u64, n: usize) -> Result<Self> {
        let mut settings = GenerateSettings {
            nominal: rig.nominal,
            truth: Truth { texture_seed: seed, ..rig.truth.clone() },
            scatter: Scatter { site_sd: 0.0, ..rig.scatter },
            sensors: rig.sensors,
            ..GenerateSettings::default()
        };
        let (mut ends, mut pose) = (Vec::new(), Pose::default());
        for repeat in 0..n as u64 {
            settings.seed = SEEDS * seed + repeat;
            settings.design.layout = Layout::List(vec![push_from(&pose)]);
            settings.design.n_pushes = 0;
            let push = simulate(&settings)?.pop().context("a push was made")?;
            let end = push.trajectory.end_pose();
            let turned_back = Rotation2::new(-push.start.angle);
            let moved = turned_back * (end.position - push.start.position);
            let turned = (end.angle - push.start.angle).to_degrees();
            ends.push([1e3 * moved.x, 1e3 * moved.y, turned]);
            pose = put_back(&push.start, &end, &rig.truth.table_grain);
        }
        let sd = |axis: usize| {
            let mean = ends.iter().map(|end| end[axis]).sum::<f64>() / n as f64;
            let squares = ends.iter().map(|end| (end[axis] - mean).powi(2)).sum::<f64>();
            (squares / (n - 1).max(1) as f64).sqrt()
        };
        let turns: Vec<f64> = ends.iter().map(|end| end[2]).collect();
        Ok(Self { position: sd(0).hypot(sd(1)), turn: sd(2), modes: modes(&turns, sd(2)) })
    }
}

/// Number of hills in the smoothed density.
fn modes(values: &[f64], sd: f64) -> f64 {
    let (low, high) = values
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(*x), high.max(*x)));
    let width = WIDTH * sd;
    let density = |k: usize| {
        let x = low + (high - low) * k as f64 / 200.0;
        values.iter().map(|value| (-0.5 * ((x - value) / width).powi(2)).exp()).sum::<f64>()
    };
    let densities: Vec<f64> =
        std::iter::once(0.0).chain((0..=200).map(density)).chain([0.0]).collect();
    let most = densities.iter().copied().fold(0.0, f64::max);
    let is_hill =
        |part: &&[f64]| part[1] >= part[0] && part[1] > part[2] && part[1] > HEIGHT * most;
    densities.windows(3).filter(is_hill).count() as f64
}

#[cfg(test)]
mod tests {
    use super::modes;

    #[test]
    fn hills_are_counted() {
        let around = |center: f64| (0..100).map(move |k| center + 0.01 * f64::from(k % 50));
        assert_eq!(modes(&around(0.0).collect::<Vec<_>>(), 0.5), 1.0);
        let three: Vec<f64> = around(0.0).chain(around(4.0)).chain(around(8.0)).collect();
        assert_eq!(modes(&three, 3.3), 3.0);
    }
}
