//! Tables of simulated steps whose ids were dropped.

use dataset::{IngestSettings, RecordingSet, Table, TableMapping, ingest};
use diagnosis::Observations;
use plant::{Design, GenerateSettings, Layout, Profile, generate};

/// Steps of pushes of one edge on a rough table.
fn steps(n_pushes: usize, travel: f64) -> Table {
    let folder = tempfile::tempdir().unwrap();
    let profile = Profile::named("rough").unwrap();
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
    ingest(&set, &IngestSettings::default()).unwrap().0
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
fn steps_of_the_same_pushes_are_runs_and_one_step_of_each_push_is_not() {
    let table = steps(300, 0.04);
    let mut independent = table.clone();
    independent.rows.retain(|row| row.step == 2);
    let found = without_ids(table);
    let runs = found.runs().expect("steps of a push share its errors");
    println!("{runs}");
    assert_eq!(found.pushes().len(), runs.n);
    assert!(runs.n < found.n_steps() / 2, "{runs}");
    let found = without_ids(independent);
    assert_eq!((found.runs(), found.pushes().len()), (None, found.n_steps()));
}
