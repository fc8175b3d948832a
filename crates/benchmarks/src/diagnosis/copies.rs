//! Sets of any size from a thousand simulated pushes.

use std::f64::consts::TAU;
use std::path::PathBuf;
use std::sync::Arc;

use anyhow::Result;
use dataset::{RecordingSet, StepRow, Table, ingest};
use diagnosis::{Observations, steady_ingest};
use planar::{Pose, Twist};
use plant::{Design, GenerateSettings, Hidden, generate};

use fixtures::made_once::{key, made_once};
use fixtures::quiet_rig;
use fixtures::workspace_root;

const N_ORIGINALS: usize = 1000;
const FOLDER: &str = "bench-diagnosis";
/// In the body's frame, so that a push is the same wherever it is laid down.
const HIDDEN: &str = "friction-center-offset: x_m=0.002, y_m=-0.001";
/// How far copies are laid down from their originals at most, along each axis, in m.
const SPREAD: f64 = 0.2;

/// The simulated pushes: kept ones, or new ones.
pub(super) fn originals() -> Result<PathBuf> {
    let settings = GenerateSettings {
        name: "pushes to copy".to_owned(),
        design: Design { n_pushes: N_ORIGINALS, ..Design::default() },
        hidden: vec![HIDDEN.parse::<Hidden>()?],
        ..quiet_rig()
    };
    let folder = workspace_root().join("target").join(FOLDER);
    made_once(&folder, &key(std::slice::from_ref(&settings))?, |folder| {
        generate(&settings, &folder.join("set"))?;
        Ok(())
    })?;
    Ok(folder.join("set"))
}

/// So many pushes with the pusher's nominal friction: the simulated ones, and then copies of all of
/// them at other places and yaws of the table.
///
/// Nothing in the simulation depends on either, so a copy is what it would give there. It shares the
/// noise of its original: a large set takes the time of one, but is no surer than the originals.
pub(super) fn copies(n_pushes: usize) -> Result<(Observations, f64)> {
    let set = RecordingSet::open(&originals()?)?;
    let (Table { rows, provenance }, _) = ingest(&set, &steady_ingest())?;
    let pushes: Vec<&[StepRow]> =
        rows.chunk_by(|a, b| (&a.recording, a.push) == (&b.recording, b.push)).collect();
    let copied = (0..n_pushes).flat_map(|index| {
        let (push, round) = (pushes[index % pushes.len()], index / pushes.len());
        let (place_ww, name) = (place(round), name(&push[0].recording, round));
        push.iter().map(move |row| StepRow { recording: name.clone(), ..laid(row, &place_ww) })
    });
    let table = Table { rows: copied.collect(), provenance };
    Ok((Observations::steady(&table, set.manifest())?, set.manifest().pusher.friction))
}

fn name(recording: &str, round: usize) -> Arc<str> {
    if round == 0 { Arc::from(recording) } else { Arc::from(format!("{recording}-{round}")) }
}

/// Where the copies of a round are laid down; the first round are the originals themselves.
fn place(round: usize) -> Pose {
    let share = |irrational: f64| (round as f64 * irrational).fract();
    let along = |irrational: f64| SPREAD * (2.0 * share(irrational) - 1.0);
    if round == 0 {
        return Pose::default();
    }
    Pose::new(along(2f64.sqrt()), along(3f64.sqrt()), TAU * share(5f64.sqrt()))
}

/// A row with all that is told in the table's frame moved.
fn laid(row: &StepRow, place_ww: &Pose) -> StepRow {
    let turned = |vector| place_ww.rotate(vector);
    let Twist { linear, angular } = row.object_twist;
    StepRow {
        object_pose: *place_ww * row.object_pose,
        object_twist: Twist { linear: turned(&linear), angular },
        pusher_start: place_ww.transform_point(&row.pusher_start),
        pusher_end: place_ww.transform_point(&row.pusher_end),
        pusher_velocity: turned(&row.pusher_velocity),
        pusher_acceleration: turned(&row.pusher_acceleration),
        contact_point: place_ww.transform_point(&row.contact_point),
        contact_normal: turned(&row.contact_normal),
        ..row.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::{laid, place};
    use dataset::StepRow;
    use nalgebra::Vector2;
    use planar::Pose;

    #[test]
    fn the_originals_stay_and_copies_lie_elsewhere() {
        let places: Vec<Pose> = (0..100).map(place).collect();
        assert_eq!(places[0], Pose::default());
        for (index, one) in places.iter().enumerate() {
            let apart = |other: &Pose| (one.position - other.position).norm() > 1e-3;
            assert!(places[..index].iter().all(apart), "{index}");
        }
    }

    #[test]
    fn the_pusher_of_a_copy_is_where_it_was_to_its_object() {
        let row = StepRow {
            object_pose: Pose::new(0.1, -0.2, 0.7),
            pusher_start: Vector2::new(0.05, -0.2),
            ..StepRow::default()
        };
        let copy = laid(&row, &place(3));
        let to_object = |row: &StepRow| row.object_pose.inverse_transform_point(&row.pusher_start);
        assert!((to_object(&row) - to_object(&copy)).norm() < 1e-15);
        assert!((row.object_pose.position - copy.object_pose.position).norm() > 0.01);
    }
}
