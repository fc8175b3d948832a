//! The committed recordings: every format gives the same table.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use dataset::{
    IngestReport, IngestSettings, NamedColumn, Phase, RecordingSet, StepRow, Table, all_writers,
    ingest, write_columns,
};

/// Formats hold the same decimal numbers, but a yaw may be stored as a quaternion and a stamp as
/// seconds and nanoseconds: both come back within 1e-15 of their size. Rates, differences over the
/// 10 ms between samples, magnify that by some 1e3.
const SAME: f64 = 1e-9;

fn fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures")
}

fn table(folder: &str) -> (Table, IngestReport) {
    let set = RecordingSet::open(&fixtures().join(folder)).unwrap();
    ingest(&set, &IngestSettings::default()).unwrap()
}

fn numbers(row: &StepRow) -> Vec<f64> {
    let force = row.force.unwrap();
    let pose = row.object_pose;
    vec![
        row.t,
        row.dt,
        row.p,
        row.beta,
        row.speed,
        pose.position.x,
        pose.position.y,
        pose.angle,
        row.object_twist.linear.x,
        row.object_twist.linear.y,
        row.object_twist.angular,
        row.pusher_start.x,
        row.pusher_end.y,
        row.pusher_acceleration.x,
        row.path_curvature,
        row.dx,
        row.dy,
        row.dtheta,
        force.mean.normal,
        force.start.tangential,
        force.end.normal,
        row.gap_start,
        row.gap_end,
        row.slip,
        row.end_position_sd,
    ]
}

#[test]
fn every_format_gives_the_same_table() {
    let (csv, _) = table("pushes");
    for writer in all_writers().iter().filter(|writer| writer.id() != "csv") {
        let (other, _) = table(&format!("formats/{}", writer.id()));
        let names: BTreeSet<_> = other.rows.iter().map(|row| row.recording.clone()).collect();
        assert_eq!(names.len(), 6, "{}", writer.id());
        let same: Vec<_> = csv.rows.iter().filter(|row| names.contains(&row.recording)).collect();
        assert_eq!(same.len(), other.len(), "{}", writer.id());
        for (a, b) in same.into_iter().zip(&other.rows) {
            let place = format!("{}: {} step {}", writer.id(), a.recording, a.step);
            assert_eq!(
                (&a.recording, a.step, a.phase, a.edge, a.n_samples, &a.session, a.flags),
                (&b.recording, b.step, b.phase, b.edge, b.n_samples, &b.session, b.flags),
                "{place}"
            );
            for (k, (x, y)) in numbers(a).into_iter().zip(numbers(b)).enumerate() {
                assert!((x - y).abs() <= SAME * x.abs().max(1.0), "{place}, number {k}: {x} {y}");
            }
        }
    }
}

/// Contact begins at the planned place of each push: its grid is p in tenths and β in 20°.
#[test]
fn every_push_is_used_and_touches_where_it_was_aimed() {
    let (table, report) = table("pushes");
    assert_eq!((report.summary.pushes_used, report.summary.tared), (60, 60));
    assert!(report.summary.excluded.is_empty(), "{:?}", report.summary.excluded);
    let (mut p_off, mut beta_off) = (Vec::new(), Vec::new());
    for first in table.rows.iter().filter(|row| row.step == 0 && row.phase == Phase::Contact) {
        p_off.push((first.p * 10.0 - (first.p * 10.0).round()).abs() / 10.0);
        let steps = first.beta.to_degrees() / 20.0;
        beta_off.push(20.0 * (steps - steps.round()).abs());
    }
    assert_eq!(p_off.len(), 60);
    p_off.sort_by(f64::total_cmp);
    beta_off.sort_by(f64::total_cmp);
    // 0.5 mm of the 90 mm edge and 0.3° in the median.
    assert!(p_off[30] < 0.5 / 90.0 && beta_off[30] < 0.3, "{p_off:?} {beta_off:?}");
}

/// The object bears at most μ·m·g, and nearly that when it hardly turns.
#[test]
fn the_steady_force_is_that_of_friction() {
    let (_, report) = table("pushes");
    let steady = report.summary.steady_force_n.unwrap();
    let whole = 0.25 * 0.8374 * 9.81;
    assert!(steady.high < whole + 0.05 && steady.high > whole - 0.05, "{steady:?}");
    assert!(steady.median > 0.6 * whole, "{steady:?}");
}

#[test]
fn columns_of_a_table_are_those_of_its_file() {
    let (table, _) = table("pushes");
    let dir = tempfile::tempdir().unwrap();
    let [whole, by_columns] = ["whole.csv", "columns.csv"].map(|name| dir.path().join(name));
    table.write(&whole).unwrap();
    let columns: Vec<_> = table
        .columns()
        .map(|column| NamedColumn {
            name: column.name.to_owned(),
            cells: column.cells(&table.rows),
        })
        .collect();
    let output = output::OutputFile::new(&by_columns, output::Existing::Refuse).unwrap();
    write_columns(output, &columns, &table.provenance).unwrap();
    let text = |path: &Path| std::fs::read_to_string(path).unwrap();
    assert_eq!(text(&whole), text(&by_columns));
    // The column of ways is of whole pushes alone.
    assert_eq!(columns.len() + 1, dataset::columns().len());
}
