//! Tables of simulated steps whose ids were dropped.

use dataset::{Curve, IngestSettings, RecordingSet, StepLength, Table, TableMapping, ingest};
use diagnosis::Observations;
use plant::{Design, GenerateSettings, Layout, Profile, generate};

/// Steps of pushes of one edge, each of so long a time, in s.
fn steps(rig: &str, n_pushes: usize, travel: f64, time: f64) -> Table {
    let folder = tempfile::tempdir().unwrap();
    let profile = Profile::named(rig).unwrap();
    let nominal = profile.nominal();
    let settings = GenerateSettings {
        truth: profile.truth(&nominal),
        scatter: profile.scatter(),
        sensors: profile.sensors(),
        nominal,
        design: Design {
            layout: Layout::Narrow { edge: 1 },
            n_pushes,
            travel,
            ..Design::default()
        },
        format: "csv".into(),
        ..GenerateSettings::default()
    };
    generate(&settings, &folder.path().join("set")).unwrap();
    let set = RecordingSet::open(&folder.path().join("set")).unwrap();
    let step = StepLength::Time(time);
    let settings = IngestSettings { step, curve: Curve::Smooth, ..IngestSettings::default() };
    ingest(&set, &settings).unwrap().0
}

/// The same rows as a table of others, with one row a push.
fn without_ids(mut table: Table) -> Observations {
    let recording = "table".into();
    for (row, step) in table.rows.iter_mut().enumerate() {
        (step.recording, step.push, step.step) = (std::sync::Arc::clone(&recording), row as u32, 0);
    }
    Observations::of_mapped(&table, &TableMapping::mit_table().unwrap()).unwrap()
}

#[test]
fn steps_of_the_same_pushes_are_runs() {
    let found = without_ids(steps("rough", 60, 0.04, 0.05));
    let runs = found.runs().expect("steps of a push share its errors");
    assert_eq!(found.pushes().len(), runs.n);
    assert!(runs.n < found.n_steps() / 4, "{runs}");
}

#[test]
fn one_step_of_each_push_is_no_run() {
    let mut table = steps("quiet", 300, 0.012, 0.2);
    table.rows.retain(|row| row.step == 1);
    let found = without_ids(table);
    assert!(found.n_steps() > 250);
    assert_eq!((found.runs(), found.pushes().len()), (None, found.n_steps()));
}
