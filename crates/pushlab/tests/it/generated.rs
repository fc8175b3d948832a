//! `generate` and `effects`: simulated sets, their sealed truth, and what is refused.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use dataset::Table;
use serde_json::Value;

use crate::small_set::SmallSet;

/// Every file below a folder, by its path from there.
fn files(dir: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(dir).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if path.is_dir() {
            let below = files(&path);
            found.extend(below.into_iter().map(|(rest, bytes)| (format!("{name}/{rest}"), bytes)));
        } else {
            found.insert(name, fs::read(&path).unwrap());
        }
    }
    found
}

#[test]
fn the_same_seed_gives_the_same_bytes_with_any_number_of_threads() {
    let set = SmallSet::new();
    let run = |name: &str, more: &[&str]| {
        let out = format!("{name}/new");
        fs::create_dir(set.path(name)).unwrap();
        let hidden = "table-anisotropy: ratio=1.3, direction_deg=34";
        let common = ["generate", "-o", &out, "--hidden", hidden, "--pushes", "6", "-q"];
        set.done(&[&common[..], more].concat());
        files(&set.path(name))
    };
    let one = run("one", &["--jobs", "1"]);
    let names: Vec<_> = one.keys().map(String::as_str).collect();
    assert_eq!(names[0], "new.truth.toml");
    assert_eq!(names[1..4], ["new/dataset.toml", "new/pushes/push-0000.mcap", names[3]]);
    assert_eq!(names.len(), 6 + 3);
    assert!(one == run("two", &["--jobs", "2"]));
    let other = run("other", &["--seed", "8"]);
    assert_ne!(one["new/pushes/push-0000.mcap"], other["new/pushes/push-0000.mcap"]);
}

#[test]
fn every_push_that_is_generated_is_ingested() {
    let set = SmallSet::new();
    for (name, more) in [
        ("plain", &[][..]),
        ("tri", &["--shape", "tri1", "--format", "csv", "--speed", "50mm/s,0.1m/s"]),
        ("narrow", &["--design", "narrow", "--hidden", "table-tilt", "--format", "mit-json"]),
    ] {
        set.done(&[&["generate", "-o", name, "--rig", "quiet", "--pushes", "10"], more].concat());
        let text =
            set.done(&["ingest", name, "--step", "4mm", "-o", "steps.csv", "--force"]).stdout;
        assert!(text.contains("10 recordings, 10 pushes used, 0 excluded"), "{name}: {text}");
        assert!(Table::read(&set.path("steps.csv")).unwrap().len() > 50, "{name}");
    }
}

#[test]
fn a_list_of_pushes_is_made_as_it_stands() {
    let set = SmallSet::new();
    set.write("list.csv", "edge,p,angle_deg,speed_mm_s\n0,0.5,0,50\n1,0.25,20,100\n");
    let run = set.done(&["generate", "-o", "new", "--design", "list.csv", "--json"]);
    let document: Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(document["n_pushes"], 2);
    assert_eq!(document["made_by"]["inputs"][0]["path"], "list.csv");
    set.write("bad.csv", "edge,p,angle_deg,speed_mm_s\n0,0.5,0,50\n1,wide,20,100\n");
    let message = set.error(&["generate", "-o", "bad", "--design", "bad.csv"]);
    assert!(message.contains("bad.csv:3: p = `wide` is not a number"), "{message}");
    set.write("bad.csv", "edge,p,angle_deg,speed_mm_s\n0,0.5,0,50\n9,0.5,20,100\n");
    let message = set.error(&["generate", "-o", "bad", "--design", "bad.csv"]);
    assert!(message.contains("push push-0001") && message.contains("edge = 9"), "{message}");
    assert!(!set.exists("bad"));
}

const POLYGON: &str = r#"name = "mine"

[object]
shape = "polygon"
vertices_m = [[0.0, 0.0], [0.08, 0.0], [0.06, 0.05], [0.0, 0.06]]
mass_kg = 0.7
center_of_mass_m = [0.03, 0.03]

[pusher]
radius_m = 0.006
friction = 0.3

[support]
friction = 0.4

[recordings]
path = "pushes"
"#;

#[test]
fn a_rig_of_ones_own_is_simulated_from_its_manifest() {
    let set = SmallSet::new();
    set.write("mine.toml", POLYGON);
    set.write("oval.toml", &POLYGON.replace(
        "shape = \"polygon\"\nvertices_m = [[0.0, 0.0], [0.08, 0.0], [0.06, 0.05], [0.0, 0.06]]",
        "shape = \"ellipse\"\nsemi_axes_m = [0.05, 0.035]",
    ).replace("center_of_mass_m = [0.03, 0.03]\n", ""));
    for (file, shape) in [("mine.toml", "polygon"), ("oval.toml", "ellipse")] {
        let name = format!("twin-{shape}");
        let run = set.done(&[
            "generate", "-o", &name, "--shape", file, "--pushes", "6", "--format", "csv", "--json",
        ]);
        let document: Value = serde_json::from_str(&run.stdout).unwrap();
        assert_eq!(document["made_by"]["inputs"][0]["path"], file);
        let manifest = dataset::Manifest::read(&set.path(&format!("{name}/dataset.toml"))).unwrap();
        assert_eq!((manifest.pusher.radius, manifest.support.friction), (0.006, 0.4));
        let object = manifest.object.of("").unwrap();
        assert_eq!((object.name.as_str(), object.mass), (shape, 0.7));
        let text = set.done(&["ingest", &name, "--step", "4mm"]).stdout;
        assert!(text.contains("6 pushes used"), "{text}");
        assert!(set.read(&format!("{name}.truth.toml")).contains("coefficient = 0.4"));
    }
    set.edit("mine.toml", "mass_kg = 0.7", "mass_kg = -0.7");
    let message = set.error(&["generate", "-o", "bad", "--shape", "mine.toml"]);
    assert!(message.contains("mine.toml:6: object.mass_kg = -0.7 kg"), "{message}");
}

#[test]
fn settings_and_sessions_reach_sensors_and_scatter() {
    let set = SmallSet::new();
    set.write(
        "rig.toml",
        "[sensors.object]\nrate = 250.0\n\n[scatter]\nsupport_friction_sd = 1e-5\n\
         tip_friction_sd = 0.0\npressure_radius_sd = 0.0\npressure_center_sd = 0.0\n\
         contact_sd = 0.0\nforce_bias_sd = 0.0\n\
         session_share = 1000.0\n\n[truth.clocks]\nforce_latency = 0.25\n",
    );
    let common = ["--settings", "rig.toml", "--sessions", "3", "--pushes", "6", "--format", "csv"];
    set.done(&[&["generate", "-o", "new"][..], &common].concat());
    let object = set.read("new/pushes/push-0000/object.csv");
    let wrench = set.read("new/pushes/push-0000/wrench.csv");
    assert!(object.lines().count() > 2 * wrench.lines().count());
    assert!(wrench.starts_with("t_s,fx_n,fy_n,tz_nm\n1000.2"), "{}", &wrench[..40]);
    let truth: toml::Table = set.read("new.truth.toml").parse().unwrap();
    let frictions: Vec<f64> = truth["pushes"]
        .as_array()
        .unwrap()
        .iter()
        .map(|push| push["variation"]["support_friction"].as_float().unwrap())
        .collect();
    let apart = |a: usize, b: usize| (frictions[a] - frictions[b]).abs();
    assert!((0..3).all(|k| apart(2 * k, 2 * k + 1) < 1e-4), "{frictions:?}");
    assert!(apart(0, 2) > 1e-3 && apart(2, 4) > 1e-3, "{frictions:?}");
    set.edit("rig.toml", "rate = 250.0", "rates = 250.0");
    let message = set.error(&["generate", "-o", "bad", "--settings", "rig.toml"]);
    assert!(message.contains("rig.toml") && message.contains("line 2"), "{message}");
}

#[test]
fn a_surprise_is_told_in_the_sealed_truth_alone() {
    let set = SmallSet::new();
    fs::create_dir(set.path("out")).unwrap();
    let arguments = ["generate", "-o", "out/new", "--hidden", "surprise", "--pushes", "2"];
    let run = set.done(&[&arguments[..], &["--json"]].concat());
    let truth = set.read("out/new.truth.toml");
    let hidden = truth.split("[[hidden]]").nth(1).unwrap().split("[truth]").next().unwrap();
    let is_told = |text: &str| plant::effect_kinds().iter().any(|kind| text.contains(kind.id));
    assert!(is_told(hidden), "{hidden}");
    assert!(!is_told(&run.stdout) && !is_told(&run.stderr), "{}{}", run.stdout, run.stderr);
    for (name, bytes) in files(&set.path("out/new")) {
        assert!(!is_told(&String::from_utf8_lossy(&bytes)), "{name}");
    }
    assert!(truth.contains("\n# tool: pushlab "), "{truth}");
    assert!(truth.contains("\n# arguments: generate --hidden surprise --pushes 2 --seed 7"));
}

#[test]
fn what_cannot_be_hidden_is_answered_with_what_can() {
    let set = SmallSet::new();
    for (hidden, parts) in [
        ("table-anistropy", &["`table-anistropy` is not known", "table-anisotropy", "magnet"][..]),
        ("yaw-offset: angle=3", &["`angle` is not known", "angle_rad or angle_deg"]),
        ("table-anisotropy: ratio=9", &["ratio = 9 is not between 0.3 and 3"]),
        ("chipped-corner: size_mm=50", &["the outline cannot be worn like this"]),
    ] {
        let message = set.error(&["generate", "-o", "new", "--hidden", hidden]);
        assert!(parts.iter().all(|part| message.contains(part)), "{message}");
        assert!(!set.exists("new") && !set.exists("new.truth.toml"), "{hidden}");
    }
}

#[test]
fn what_is_there_is_kept() {
    let set = SmallSet::new();
    let manifest = set.read("set/dataset.toml");
    let message = set.error(&["generate", "-o", "set", "--pushes", "1"]);
    assert!(message.contains("cannot write set: "), "{message}");
    assert!(message.contains("not empty; choose a new one"), "{message}");
    assert_eq!(set.read("set/dataset.toml"), manifest);
    set.write("kept.truth.toml", "kept");
    let message = set.error(&["generate", "-o", "kept", "--pushes", "1"]);
    assert!(message.contains("cannot write kept.truth.toml: it exists"), "{message}");
    assert_eq!(set.read("kept.truth.toml"), "kept");
    assert!(set.error(&["generate", "-o", "."]).contains("it needs a name"));
}

#[test]
fn every_effect_is_listed_and_explained() {
    let set = SmallSet::new();
    let list = set.done(&["effects", "list"]).stdout;
    for kind in plant::effect_kinds() {
        assert!(list.contains(&format!("\n  {} ", kind.id)), "{}", kind.id);
    }
    let text = set.done(&["effects", "explain", "stream-latency"]).stdout;
    for part in ["seen in: motion, force, gap", "typically", "--hidden 'stream-latency: "] {
        assert!(text.contains(part), "no {part:?} in {text}");
    }
    // Not in the catalogue: only a simulation knows it.
    let text = set.done(&["effects", "explain", "magnet"]).stdout;
    assert!(text.starts_with("to hide it in a simulation"), "{text}");
}
