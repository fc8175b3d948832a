//! `pushlab suggest`: the suggested pushes, made on the simulated rig, tell rivals apart.

use std::collections::BTreeSet;

use dataset::{Manifest, RecordingSet, StepRow, Table, ingest};
use diagnosis::{
    Aim, FitSettings, NoiseModel, Observations, Separation, SuggestSettings, SuggestedPush,
    fit_with_noise, steady_ingest, suggest,
};
use models::{Analytical, Base, Description, SurfaceKind};
use nalgebra::Vector2;
use plant::{Design, GenerateSettings, Layout, PlannedPush, generate};
use serde_json::{Value, json};

use crate::diagnosed::diagnosed;

const RIVALS: [&str; 2] = ["table-anisotropy", "body-anisotropy"];
/// Hidden: the first of the rivals.
const HIDDEN: &str = "table-anisotropy: ratio=1.005, direction_deg=20";

/// Steps of some pushes on the table with the hidden effect, on a rig with a cheap camera and
/// without force sensor.
fn made(design: Design, seed: u64) -> (Table, Manifest) {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("set");
    let hidden = vec![HIDDEN.parse().unwrap()];
    let mut settings = GenerateSettings { design, hidden, seed, ..GenerateSettings::default() };
    (settings.sensors.object.noise_sd, settings.sensors.object.yaw_noise_sd) = (3e-4, 5e-3);
    generate(&settings, &out).unwrap();
    let set = RecordingSet::open(&out).unwrap();
    let (mut table, _) = ingest(&set, &steady_ingest()).unwrap();
    table.rows.iter_mut().for_each(|row| row.force = None);
    (table, set.manifest().clone())
}

/// The pushes so far with further ones.
fn together(so_far: &(Table, Manifest), further: &[SuggestedPush]) -> Observations {
    let (mut all, manifest) = so_far.clone();
    let (further, _) = made(list(further), 6);
    all.rows.extend(further.rows.into_iter().map(|row| {
        let recording = format!("further-{}", row.recording).into();
        StepRow { recording, ..row }
    }));
    Observations::steady(&all, &manifest).unwrap()
}

fn planned(push: &SuggestedPush) -> PlannedPush {
    let SuggestedPush { edge, p, angle, speed, travel, pose_wb, repeat, .. } = push.clone();
    let place = [pose_wb.position.x, pose_wb.position.y, pose_wb.angle];
    PlannedPush { edge, p, angle, speed, travel, place, session: 0, repeat }
}

fn list(pushes: &[SuggestedPush]) -> Design {
    let layout = Layout::List(pushes.iter().map(planned).collect());
    Design { layout, n_pushes: 0, ..Design::default() }
}

fn model() -> Description {
    let analytical = Analytical::nominal(0.25).unwrap().with_surface(SurfaceKind::UniformPatch);
    Description { base: Base::Analytical(analytical.unwrap()), effects: vec![], weights: None }
}

/// By how much twice the log likelihood of the true rival is larger, both fitted to these pushes.
fn ratio(observations: &Observations) -> f64 {
    let settings = FitSettings { resemblances: false, ..FitSettings::default() };
    let noise = NoiseModel::learn(&model(), &[], observations).unwrap();
    let misfit = RIVALS.map(|rival| {
        let fit = fit_with_noise(observations, &model(), &[rival], &noise, &settings).unwrap();
        let whitening = noise.whitening(&fit.with_nuisances, &[], observations).unwrap();
        fit.whitened_rms[1].powi(2) * whitening.n_numbers() as f64 + whitening.log_determinant()
    });
    misfit[1] - misfit[0]
}

#[test]
fn suggested_pushes_tell_rivals_apart_better_than_random_ones() {
    let layout = Layout::Narrow { edge: 0 };
    let narrow = Design { layout, n_pushes: 16, ..Design::default() };
    let so_far = made(narrow, 5);
    let before = Observations::steady(&so_far.0, &so_far.1).unwrap();
    let aim = Aim::Rivals(vec![RIVALS.map(str::to_owned).to_vec()]);
    let settings = SuggestSettings { n_candidates: 150, ..SuggestSettings::default() };
    let found = suggest(&before, &model(), &[], &aim, &settings).unwrap();
    let Separation { now, expected, with_random, .. } = found.separations[0].clone();
    let stride = found.feasible.len() / 4;
    let random = found.feasible.iter().step_by(stride).take(4);
    let random: Vec<_> = random.flat_map(|push| vec![push.clone(); 5]).collect();
    assert_eq!((found.pushes.len(), random.len()), (20, 20));
    let before = ratio(&before);
    let [suggested, random] =
        [&found.pushes, &random].map(|further| ratio(&together(&so_far, further)));
    eprintln!(
        "2Δ log L: {before:.0} so far, {suggested:.0} with suggested, {random:.0} with random"
    );
    eprintln!("in sd, as told: {now:.1}, {expected:.1}, {with_random:.1}");
    assert!(suggested > 6.0 && suggested > random, "{before} {suggested} {random}");
    assert!(expected > with_random && with_random > now, "{now} {expected} {with_random}");
}

#[test]
fn the_list_is_made_on_the_simulated_rig_and_has_the_path_for_a_robot() {
    let (set, mut diagnosis) = diagnosed();
    diagnosis["ambiguous"] = json!([]);
    set.write("d.json", &diagnosis.to_string());
    let words = [
        "suggest",
        "pushes",
        "--from",
        "d.json",
        "--model",
        "model.toml",
        "-n",
        "7",
        "--repeats",
        "3",
    ];
    let run = set.done(&[&words[..], &["-o", "s.csv", "--json"]].concat());
    let result = serde_json::from_str::<Value>(&run.stdout).unwrap();
    assert_eq!(
        (&result["aim"], result["pushes"].as_array().unwrap().len()),
        (&"precision".into(), 7)
    );
    let told = &result["precisions"][0];
    let [now, expected] = ["now", "expected"].map(|key| told[key].as_f64().unwrap());
    assert!(expected < now && told["name"] == "lambda", "{told}");
    let list = set.read("s.csv");
    let again = set.done(&[&words[..], &["-o", "t.csv", "--jobs", "1", "--json"]].concat());
    assert_eq!(list, set.read("t.csv"));
    let again = serde_json::from_str::<Value>(&again.stdout).unwrap();
    assert_eq!(result["pushes"], again["pushes"]);
    let names: BTreeSet<&str> = result["pushes"]
        .as_array()
        .unwrap()
        .iter()
        .map(|push| push["repeat"].as_str().unwrap())
        .collect();
    assert_eq!(names.len(), 3);
    let made =
        ["generate", "-o", "twin", "--shape", "pushes/dataset.toml", "--design", "s.csv", "--json"];
    let made: Value = serde_json::from_str(&set.done(&made).stdout).unwrap();
    assert_eq!(made["n_pushes"], 7);
    let pushes = plant::read_push_list(&set.path("s.csv")).unwrap();
    for (push, told) in pushes.iter().zip(result["pushes"].as_array().unwrap()) {
        let path = told["path_w"].as_array().unwrap().iter().map(|point| {
            let [x, y] = [0, 1].map(|axis| point[axis].as_f64().unwrap());
            Vector2::new(x, y)
        });
        let [start, touch, end] = path.collect::<Vec<_>>()[..] else { panic!("{told}") };
        // The plant comes along the same line to the same end, from its own distance.
        let theirs = push.path(&object(), 0.00475, 10.0, [0.2, 0.3]);
        let direction = Vector2::from(theirs.direction);
        let their_end = Vector2::from(theirs.start) + theirs.length * direction;
        assert!((their_end - end).norm() < 2e-4, "{their_end} {end}");
        assert!(((end - touch).norm() - push.travel).abs() < 1e-9);
        assert!(planar::cross(&(touch - start), &direction).abs() < 1e-4 && start != touch);
    }
}

/// From the recordings' table, whose manifest is named; then by the diagnosis alone.
#[test]
fn what_was_known_of_the_table_is_kept_in_the_command() {
    let (set, mut diagnosis) = diagnosed();
    diagnosis["ambiguous"] = json!([]);
    set.done(&["ingest", "pushes", "-o", "steps.csv", "-q"]);
    let known = ["--manifest", "pushes/dataset.toml"];
    let of_table = ["diagnose", "steps.csv", "--model", "model.toml", "--seed", "7"];
    let arguments = [&of_table[..], &known].concat();
    diagnosis["made_by"] = json!({ "tool": "pushlab", "arguments": arguments, "inputs": [] });
    set.write("d.json", &diagnosis.to_string());
    let few = ["--from", "d.json", "-n", "1", "--repeats", "1", "--force", "--json"];
    for named in [&["steps.csv", "--manifest", "pushes/dataset.toml"][..], &[]] {
        let run = set.done(&[&["suggest"], named, &few].concat());
        let made: Value = serde_json::from_str(&run.stdout).unwrap();
        let words: Vec<_> = made["made_by"]["arguments"]
            .as_array()
            .unwrap()
            .iter()
            .map(|one| one.as_str().unwrap())
            .collect();
        let n = words.windows(2).filter(|pair| *pair == known).count();
        assert_eq!(n, 1, "{words:?}");
        assert!(set.read("suggested.csv").contains("--manifest pushes/dataset.toml"));
    }
}

/// The object of the fixture pushes.
fn object() -> planar::Shape {
    planar::Shape::square(0.09).unwrap()
}

#[test]
fn what_cannot_be_suggested_is_told() {
    let (set, mut diagnosis) = diagnosed();
    let from = ["suggest", "--from", "d.json"];
    let error = |words: &[&str]| set.error(&[&from[..], words].concat());
    assert!(error(&[]).contains("does not tell which set it is about; name it"));
    assert!(error(&["set"]).contains("does not tell which model it is about"));
    let of_pushes = ["pushes", "--model", "model.toml", "--for"];
    let tight = ["table-tilt", "--area", "0,1,0,1"];
    assert!(error(&[&of_pushes[..], &tight].concat()).contains("within 1 × 1 mm"));
    (diagnosis["ambiguous"], diagnosis["identified"], diagnosis["effects"]) =
        (json!([]), json!([]), json!([]));
    set.write("d.json", &diagnosis.to_string());
    assert!(error(&of_pushes[..3]).contains("no rivals, no named effect and no hint"));
    diagnosis["split"]["set"] = "0123".into();
    set.write("d.json", &diagnosis.to_string());
    assert!(error(&of_pushes[..3]).contains("is about other recordings than pushes"));
    set.wrong_usage(&[&from[..], &["--area", "1,0,0,1"]].concat());
    set.wrong_usage(&[&from[..], &of_pushes, &["table-grain"]].concat());
    assert!(!set.exists("suggested.csv"));
}
