//! Laws of a screen, on the recorded fixture pushes.

use std::path::Path;

use dataset::{Manifest, RecordingSet, Table, ingest};
use diagnosis::{NoiseModel, Observations, Screen, ScreenSettings, screen, steady_ingest};
use models::{Analytical, PushModel};
use nalgebra::Vector2;
use planar::Pose;

pub(crate) fn recorded() -> (Table, Manifest) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/pushes");
    let set = RecordingSet::open(&path).unwrap();
    (ingest(&set, &steady_ingest()).unwrap().0, set.manifest().clone())
}

fn screened(table: &Table, manifest: &Manifest) -> Screen {
    let observations = Observations::steady(table, manifest).unwrap();
    let model = Analytical::nominal(manifest.pusher.friction).unwrap().describe().unwrap();
    let noise = NoiseModel::learn(&model, &[], &observations).unwrap();
    screen(&model, &[], &observations, &noise, &ScreenSettings::default()).unwrap()
}

/// Statistics by effect.
fn statistics(found: &Screen) -> Vec<(&'static str, f64)> {
    let mut list: Vec<_> = found.effects.iter().map(|e| (e.id, e.statistic)).collect();
    list.sort_by_key(|(id, _)| *id);
    list
}

fn assert_near(one: &Screen, other: &Screen, within: f64) {
    for ((id, a), (_, b)) in statistics(one).into_iter().zip(statistics(other)) {
        assert!((a - b).abs() <= within * (1.0 + a.abs()), "{id}: {a} {b}");
    }
}

#[test]
fn the_order_of_pushes_changes_nothing() {
    let (table, manifest) = recorded();
    let mut other = table.clone();
    let mut pushes: Vec<_> = table.rows.chunk_by(|a, b| a.recording == b.recording).collect();
    pushes.reverse();
    other.rows = pushes.concat();
    let (one, other) = (screened(&table, &manifest), screened(&other, &manifest));
    // Variances are found within a tenth of a standard error.
    assert_near(&one, &other, 0.02);
}

/// By a quarter, which swaps the axes along which secants are taken. Between them the secants of a
/// vector or a grain see other kinks of sticking and sliding, and statistics differ by a quarter.
#[test]
fn a_world_turned_by_a_quarter_changes_nothing() {
    let (table, manifest) = recorded();
    let turn = Pose::new(0.0, 0.0, std::f64::consts::FRAC_PI_2);
    let mut other = table.clone();
    for row in &mut other.rows {
        row.object_pose = turn * row.object_pose;
        row.object_twist.linear = turn.rotate(&row.object_twist.linear);
        let of_world: [&mut Vector2<f64>; 6] = [
            &mut row.pusher_start,
            &mut row.pusher_end,
            &mut row.pusher_velocity,
            &mut row.pusher_acceleration,
            &mut row.contact_point,
            &mut row.contact_normal,
        ];
        of_world.into_iter().for_each(|vector| *vector = turn.rotate(vector));
    }
    let (one, other) = (screened(&table, &manifest), screened(&other, &manifest));
    assert_near(&one, &other, 0.02);
}

/// The fixture's pusher of 4.75 mm, stated as a point: only its gap has to be measured anew.
#[test]
fn the_radius_of_a_pusher_that_is_stated_as_a_point_is_what_is_missing() {
    let (mut table, mut manifest) = recorded();
    for row in &mut table.rows {
        row.gap_start += manifest.pusher.radius;
        row.gap_end += manifest.pusher.radius;
    }
    manifest.pusher.radius = 0.0;
    let found = screened(&table, &manifest);
    let first = &found.effects[0];
    assert_eq!(first.id, "pusher-radius", "{:?}", statistics(&found));
    assert!(first.statistic > 100.0, "{}", first.statistic);
}
