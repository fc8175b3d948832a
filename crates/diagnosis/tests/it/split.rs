//! Holding pushes out, on the fixture pushes.

use std::collections::BTreeSet;

use dataset::{IngestSettings, Manifest, RecordingSet, StepRow, Table, ingest};
use diagnosis::{
    DiagnosisError, FloorSource, MapSettings, Observations, Predictions, RepeatTolerance, compare,
    noise_floor, split,
};
use models::{Analytical, Cluster, PushModel, Split};

fn recorded() -> (Table, Manifest) {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/pushes");
    let set = RecordingSet::open(folder.as_ref()).unwrap();
    (ingest(&set, &IngestSettings::default()).unwrap().0, set.manifest().clone())
}

fn of_recordings(table: &Table, keep: impl Fn(&StepRow) -> bool) -> Table {
    let rows = table.rows.iter().filter(|row| keep(row)).cloned().collect();
    Table { rows, provenance: table.provenance.clone() }
}

fn sorted(names: &[String]) -> BTreeSet<&String> {
    names.iter().collect()
}

#[test]
fn a_quarter_of_the_pushes_is_set_aside_by_the_seed_alone() {
    let (table, manifest) = recorded();
    let observations = Observations::of(&table, &manifest).unwrap();
    let Split { fit, confirm, cluster, .. } = split(&observations, 7).unwrap();
    assert_eq!((fit.len(), confirm.len(), cluster), (45, 15, Cluster::Push));
    assert_eq!(sorted(&[fit.as_slice(), &confirm].concat()).len(), 60);
    let names: Vec<_> =
        observations.part(&confirm).unwrap().pushes().iter().map(ToString::to_string).collect();
    assert_eq!(names, confirm);
    let n_steps = |part: &[String]| observations.part(part).unwrap().n_steps();
    assert_eq!(n_steps(&fit) + n_steps(&confirm), observations.n_steps());
    assert_ne!(split(&observations, 8).unwrap().confirm, confirm);
    let mut backwards = table.clone();
    backwards.rows.sort_by(|a, b| b.recording.cmp(&a.recording));
    let backwards = split(&Observations::of(&backwards, &manifest).unwrap(), 7).unwrap();
    assert_eq!(sorted(&backwards.confirm), sorted(&confirm));
}

#[test]
fn sessions_stay_whole_where_there_are_many() {
    let (mut table, manifest) = recorded();
    let session = |row: &StepRow| row.recording[5..].parse::<u32>().unwrap() % 15;
    for row in &mut table.rows {
        row.session = Some(format!("day {}", session(row)).into());
    }
    let observations = Observations::of(&table, &manifest).unwrap();
    let parts = split(&observations, 7).unwrap();
    assert_eq!(parts.cluster, Cluster::Session);
    for names in [&parts.fit, &parts.confirm] {
        let part = observations.part(names).unwrap();
        let model = Analytical::nominal(0.25).unwrap().describe().unwrap();
        let predictions = Predictions::of(&model, &[], &part).unwrap();
        let floor = noise_floor(&part, &predictions, &RepeatTolerance::default()).unwrap();
        let found = compare(&part, &predictions, &floor, &MapSettings::default()).unwrap();
        assert_eq!(found.cluster, Cluster::Session);
    }
    let sessions = |names: &[String]| -> BTreeSet<u32> {
        names.iter().map(|name| name[5..8].parse::<u32>().unwrap() % 15).collect()
    };
    let (fit, confirm) = (sessions(&parts.fit), sessions(&parts.confirm));
    assert!(fit.is_disjoint(&confirm) && fit.len() == 11 && confirm.len() == 4);
}

#[test]
fn repeats_are_spread_so_that_both_parts_have_a_floor() {
    let (mut table, manifest) = recorded();
    let repeated: Vec<StepRow> =
        table.rows.iter().filter(|row| &*row.recording == "push-010").cloned().collect();
    for k in 0..12 {
        let copy = |row: &StepRow| StepRow { recording: format!("copy-{k}").into(), ..row.clone() };
        table.rows.extend(repeated.iter().map(copy));
    }
    let observations = Observations::of(&table, &manifest).unwrap();
    for seed in 0..8 {
        let parts = split(&observations, seed).unwrap();
        for names in [&parts.fit, &parts.confirm] {
            let part = observations.part(names).unwrap();
            let model = Analytical::nominal(0.25).unwrap().describe().unwrap();
            let predictions = Predictions::of(&model, &[], &part).unwrap();
            let floor = noise_floor(&part, &predictions, &RepeatTolerance::default()).unwrap();
            assert_eq!(floor.source, FloorSource::Repeats, "{seed}: {floor:?}");
        }
    }
}

#[test]
fn a_split_is_of_its_recordings_and_of_enough_pushes() {
    let (table, manifest) = recorded();
    let observations = Observations::of(&table, &manifest).unwrap();
    let parts = split(&observations, 7).unwrap();
    assert!(observations.are_of(&parts));
    let mut edited = table.clone();
    edited.provenance.push("source", "sha256 00 dataset.toml");
    assert!(Observations::of(&edited, &manifest).unwrap().are_of(&parts));
    edited.provenance.push("source", "sha256 00 pushes/push-060.csv");
    assert!(!Observations::of(&edited, &manifest).unwrap().are_of(&parts));
    let few = of_recordings(&table, |row| &*row.recording < "push-009");
    let refused = split(&Observations::of(&few, &manifest).unwrap(), 7);
    assert!(matches!(refused, Err(DiagnosisError::TooFewPushes { n_pushes: 9, needed: 10, .. })));
    let enough = of_recordings(&table, |row| &*row.recording < "push-010");
    assert_eq!(split(&Observations::of(&enough, &manifest).unwrap(), 7).unwrap().confirm.len(), 3);
    let nobody = observations.part(&["push-000#1".to_owned()]);
    assert!(matches!(nobody, Err(DiagnosisError::TooFewPushes { n_pushes: 0, .. })));
}
