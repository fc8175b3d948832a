//! Recording sets as they lie on disk.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use dataset::{IngestSettings, RecordingSet, Table, ingest};
use plant::{
    Design, GenerateReport, GenerateSettings, Hidden, Layout, PlannedPush, PlantError, Profile,
    PushedObject, Scatter, Sensors, SetOutput, generate,
};

fn small() -> GenerateSettings {
    let design = Design {
        n_pushes: 6,
        n_sessions: 2,
        repeat_share: 0.5,
        n_repeated: 1,
        travel: 0.03,
        ..Design::default()
    };
    GenerateSettings { design, ..GenerateSettings::default() }
}

fn made(settings: &GenerateSettings, dir: &Path) -> GenerateReport {
    generate(settings, &dir.join("set")).expect("a set")
}

/// Every file below a folder, by its path from there.
fn files(dir: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut open = vec![dir.to_owned()];
    while let Some(folder) = open.pop() {
        for entry in fs::read_dir(&folder).expect("a folder") {
            let path = entry.expect("an entry").path();
            if path.is_dir() {
                open.push(path);
            } else {
                let name =
                    path.strip_prefix(dir).expect("a path below").to_string_lossy().into_owned();
                found.insert(name, fs::read(&path).expect("a file"));
            }
        }
    }
    found
}

fn table(dir: &Path) -> Table {
    let set = RecordingSet::open(&dir.join("set")).expect("a set");
    ingest(&set, &IngestSettings::default()).expect("a table").0
}

#[test]
fn one_thread_and_three_write_the_same_bytes() {
    let run = |threads: usize| {
        let dir = tempfile::tempdir().unwrap();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| made(&small(), dir.path()));
        files(dir.path())
    };
    let (one, three) = (run(1), run(3));
    assert_eq!(one.len(), 6 + 3);
    assert!(one == three);
}

#[test]
fn every_push_is_told_with_their_number() {
    let dir = tempfile::tempdir().unwrap();
    let told = std::sync::Mutex::new(Vec::new());
    let out = SetOutput::new(&dir.path().join("set")).unwrap();
    plant::generate_each(&small(), out, |n| told.lock().unwrap().push(n)).unwrap();
    assert_eq!(told.into_inner().unwrap(), [6; 6]);
}

#[test]
fn an_impact_does_not_tip_what_a_steady_push_does_not_and_a_high_push_tips() {
    let rough = Profile::named("rough").unwrap().settings();
    let design = Design { speeds: vec![0.4], ..small().design };
    let fast = GenerateSettings { design, ..rough };
    let dir = tempfile::tempdir().unwrap();
    let report = made(&fast, dir.path());
    assert_eq!((report.n_pushes, report.not_made), (6, Vec::new()));
    // Friction of a quarter of the weight, at 0.3 m, is beyond the rim at 45 mm.
    let mut high = fast;
    high.truth.tip.height = 0.3;
    let refused = generate(&high, &tempfile::tempdir().unwrap().path().join("set"));
    let refused = format!("{:?}", refused.unwrap_err());
    assert!(refused.contains("tips over"), "{refused}");
}

#[test]
fn another_seed_gives_other_pushes() {
    let run = |seed: u64| {
        let dir = tempfile::tempdir().unwrap();
        made(&GenerateSettings { seed, ..small() }, dir.path());
        files(dir.path())["set/pushes/push-0000.mcap"].clone()
    };
    assert_ne!(run(7), run(8));
}

#[test]
fn every_format_is_read_back_to_the_same_table() {
    let mut rows: Option<Vec<(f64, f64)>> = None;
    for writer in dataset::all_writers() {
        let dir = tempfile::tempdir().unwrap();
        made(&GenerateSettings { format: writer.id().into(), ..small() }, dir.path());
        let table = table(dir.path());
        let own: Vec<_> = table.rows.iter().map(|row| (row.dx, row.dtheta)).collect();
        assert!(own.len() > 6 * 4, "{}: {} rows", writer.id(), own.len());
        match &rows {
            None => rows = Some(own),
            Some(first) => {
                assert_eq!(own.len(), first.len(), "{}", writer.id());
                for (a, b) in own.iter().zip(first) {
                    // A yaw goes through a quaternion in some formats.
                    assert!((a.0 - b.0).abs() < 1e-9 && (a.1 - b.1).abs() < 1e-9);
                }
            }
        }
    }
}

#[test]
fn sessions_and_repeats_are_told_and_repeats_repeat() {
    let dir = tempfile::tempdir().unwrap();
    made(&small(), dir.path());
    let sessions = fs::read_to_string(dir.path().join("set/sessions.csv")).unwrap();
    assert_eq!(sessions.lines().next(), Some("recording,session,repeat"));
    assert_eq!(sessions.matches(",session-0,").count(), 3);
    assert_eq!(sessions.matches(",session-1,").count(), 3);
    assert_eq!(sessions.matches(",repeat-0\n").count(), 3);
    let set = RecordingSet::open(&dir.path().join("set")).unwrap();
    assert_eq!(set.session("push-0000").unwrap().session, "session-0");
    let pushes = plant::simulate(&small()).unwrap();
    let repeats: Vec<_> = pushes.iter().filter(|push| !push.plan.repeat.is_empty()).collect();
    let ends: Vec<_> = repeats.iter().map(|push| push.trajectory.end_pose()).collect();
    let apart = (ends[0].position - ends[1].position).norm();
    assert!(apart > 1e-6 && apart < 3e-3, "{apart}");
}

#[test]
fn the_truth_is_sealed_beside_the_set_and_a_surprise_is_only_there() {
    let dir = tempfile::tempdir().unwrap();
    let report = made(&GenerateSettings { hidden: vec![Hidden::Surprise], ..small() }, dir.path());
    let sealed = fs::read_to_string(&report.sealed_truth).unwrap();
    let truth: toml::Table = sealed.parse().unwrap();
    let id = truth["hidden"][0]["id"].as_str().unwrap();
    assert!(plant::effect_kinds().iter().any(|kind| kind.id == id));
    assert_eq!(truth["pushes"].as_array().unwrap().len(), 6);
    assert!(!format!("{report:?}").contains(id));
    for (name, bytes) in files(&dir.path().join("set")) {
        assert!(!String::from_utf8_lossy(&bytes).contains(id), "{name}");
    }
}

#[test]
fn a_surprise_is_possible_on_any_object() {
    let object = PushedObject::Mit { name: "ellip1".into() };
    for seed in 0..60 {
        let design = Design { n_pushes: 1, repeat_share: 0.0, travel: 0.001, ..Design::default() };
        let hidden = vec![Hidden::Surprise, Hidden::Surprise];
        let object = object.clone();
        let settings = GenerateSettings { object, hidden, design, seed, ..small() };
        plant::simulate(&settings).unwrap();
    }
}

#[test]
fn logs_with_faults_are_still_read() {
    let dir = tempfile::tempdir().unwrap();
    made(&GenerateSettings { sensors: Sensors::dirty(), ..small() }, dir.path());
    assert!(table(dir.path()).rows.len() > 10);
}

#[test]
fn the_thesis_design_is_eleven_places_nine_angles_four_edges_and_five_speeds() {
    let grid = Design { layout: Layout::Thesis, n_pushes: 25, ..Design::default() };
    let pushes = plant::simulate(&GenerateSettings { design: grid, ..small() }).unwrap();
    assert_eq!(pushes.len(), 25);
    let speeds: std::collections::BTreeSet<_> =
        pushes.iter().map(|push| (1e3 * push.plan.speed).round() as i64).collect();
    assert!(speeds.iter().all(|speed| [20, 50, 100, 200, 400].contains(speed)));
    assert!(speeds.len() > 2);
}

#[test]
fn a_grid_at_one_speed_has_a_fifth_of_the_pushes() {
    let design =
        Design { layout: Layout::Thesis, n_pushes: 3, speeds: vec![0.05], ..small().design };
    let pushes = plant::simulate(&GenerateSettings { design, ..small() }).unwrap();
    assert!(pushes.iter().all(|push| push.plan.speed == 0.05));
}

#[test]
fn impossible_sensors_scatter_and_pushes_are_named() {
    let refuse = |settings: GenerateSettings| plant::simulate(&settings).unwrap_err().to_string();
    let mut sensors = Sensors::default();
    sensors.object.rate = 0.0;
    let message = refuse(GenerateSettings { sensors, ..small() });
    assert!(message.contains("sensors.object.rate = 0 Hz"), "{message}");
    sensors = Sensors::default();
    sensors.force.late_share = 2.0;
    let message = refuse(GenerateSettings { sensors, ..small() });
    assert!(message.contains("sensors.force.late_share = 2"), "{message}");
    let scatter = Scatter { contact_sd: -1.0, ..Scatter::default() };
    let message = refuse(GenerateSettings { scatter, ..small() });
    assert!(message.contains("scatter.contact_sd = -1 m"), "{message}");
    let plan = plant::simulate(&small()).unwrap()[0].plan.clone();
    let far = PlannedPush { edge: 7, ..plan.clone() };
    let design = Design { layout: Layout::List(vec![plan, far]), n_pushes: 0, ..Design::default() };
    let error = plant::simulate(&GenerateSettings { design, ..small() }).unwrap_err();
    assert!(matches!(&error, PlantError::Push { name, .. } if name == "push-0001"), "{error}");
}

#[test]
fn a_list_is_pushed_as_it_stands() {
    let push = PlannedPush {
        edge: 2,
        p: 0.25,
        angle: 0.1,
        speed: 0.05,
        travel: 0.02,
        place: [0.1, 0.0, 1.0],
        session: 3,
        repeat: "a".into(),
    };
    let layout = Layout::List(vec![push.clone(); 2]);
    let design = Design { layout, n_pushes: 0, ..Design::default() };
    let pushes = plant::simulate(&GenerateSettings { design, ..small() }).unwrap();
    assert!(pushes.iter().all(|made| made.plan == push));
}

#[test]
fn every_shape_and_layout_makes_pushes() {
    for name in ["rect3", "tri1", "ellip2", "hex", "butter"] {
        let object = PushedObject::Mit { name: name.into() };
        for layout in [Layout::Rich, Layout::Thesis, Layout::Narrow { edge: 0 }, Layout::Repeats] {
            let design = Design { layout, n_pushes: 3, travel: 0.01, ..Design::default() };
            let settings = GenerateSettings { object: object.clone(), design, ..small() };
            let pushes =
                plant::simulate(&settings).unwrap_or_else(|error| panic!("{name}: {error:?}"));
            assert!(!pushes.is_empty(), "{name}");
        }
    }
}

#[test]
fn what_cannot_be_made_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    let refuse =
        |settings: GenerateSettings| generate(&settings, &dir.path().join("new")).unwrap_err();
    let error = refuse(GenerateSettings { format: "mcap".into(), ..small() });
    assert!(error.to_string().contains("mcap-ros2"), "{error}");
    let design = Design { n_pushes: 0, ..Design::default() };
    let error = refuse(GenerateSettings { design, ..small() });
    assert!(matches!(error, PlantError::Design { .. }));
    let object = PushedObject::Mit { name: "rect9".into() };
    assert!(matches!(refuse(GenerateSettings { object, ..small() }), PlantError::Dataset(_)));
    let hidden = vec!["chipped-corner: size_mm=50".parse().unwrap()];
    assert!(matches!(refuse(GenerateSettings { hidden, ..small() }), PlantError::Wear { .. }));
    fs::create_dir(dir.path().join("full")).unwrap();
    fs::write(dir.path().join("full/note"), "mine").unwrap();
    let error = generate(&small(), &dir.path().join("full")).unwrap_err();
    assert!(error.to_string().contains("full: the folder is not empty"), "{error}");
    // A truth is neither put into the set nor written over another one.
    let error = generate(&small(), Path::new(".")).unwrap_err();
    assert!(error.to_string().starts_with("cannot write .: it needs a name"), "{error}");
    fs::write(dir.path().join("kept.truth.toml"), "kept").unwrap();
    let error = generate(&small(), &dir.path().join("kept")).unwrap_err();
    assert!(error.to_string().contains("kept.truth.toml: it exists"), "{error}");
    assert!(!dir.path().join("kept").exists());
}
