//! Pushes of which the object's poses before and after are known, through the commands.

use std::fmt::Write as _;
use std::sync::Arc;

use effects::{Object, PushPhysics, Rig, StepInput, Surface, Track, by_id};
use nalgebra::Vector2;
use planar::{Pose, Shape, Twist, perpendicular};
use serde_json::Value;

use crate::small_set::SmallSet;

const MANIFEST: &str = r#"name = "ends"
[object]
shape = "square"
side_m = 0.09
mass_kg = 0.8
[pusher]
radius_m = 0.005
friction = 0.25
[support]
friction = 0.25
[recordings]
format = "endpoints"
"#;
const N_PUSHES: usize = 60;
/// Where the center of friction is, in m.
const OFFSET: [f64; 2] = [6e-3, -4e-3];

/// Pushes of 40 mm that begin 1 mm before the touch, some of which slide off, of a square whose center
/// of friction is off its middle; the last two are a flip of the tracking and a push of another shape.
fn pushes() -> SmallSet {
    let shape = Arc::new(Shape::square(0.09).unwrap());
    let object = Arc::new(Object::uniform(shape.clone(), 0.8).unwrap());
    let rig = Rig::new(Surface::Ellipsoid, 0.25, 0.25).unwrap();
    let offset = by_id("friction-center-offset").unwrap();
    let physics = PushPhysics::new(rig).with(offset, &OFFSET).unwrap();
    let part = |k: usize, step: f64| (k as f64 * step).fract();
    let mut text =
        "push,shape,x0_m,y0_m,theta0_rad,x1_m,y1_m,theta1_rad,tip_x0_m,tip_y0_m,tip_x1_m,\
                    tip_y1_m,speed_m_s\n"
            .to_owned();
    for k in 0..N_PUSHES {
        let pose = Pose::new(0.3 * part(k, 0.29), 0.1 * part(k, 0.83), 6.0 * part(k, 0.47));
        let (edge, p) = (k % 4, 0.05 + 0.9 * part(k, 0.618));
        let normal = shape.inward_normal_at(edge, p);
        let start = pose.transform_point(&(shape.point_at(edge, p) - 6e-3 * normal));
        let turn = Pose::new(0.0, 0.0, 1.6 * (part(k, 0.414) - 0.5));
        let along: Vector2<f64> = pose.rotate(&turn.rotate(&normal));
        let end = start + 0.04 * along;
        let step = StepInput {
            object: object.clone(),
            pusher_radius: 5e-3,
            pose_wb: pose,
            twist_wb: Twist::default(),
            track: Track::straight(start, end, 2.0),
            touching: false,
            since_contact: 0.0,
            run_up: None,
            progress: 0.5,
            session: 0,
        };
        let found = physics.predict(&step).unwrap();
        let moved = found.dx * along + found.dy * perpendicular(&along);
        // A tenth of a millimeter and a tenth of a degree of scatter.
        let scatter = |step: f64| 2.0 * (part(k, step) - 0.5);
        let after = pose.position + moved + 1e-4 * Vector2::new(scatter(0.71), scatter(0.37));
        let angle = pose.angle + found.dtheta + 2e-3 * scatter(0.91);
        let Pose { position, angle: before } = pose;
        let _ = writeln!(
            text,
            "{k},square,{},{},{before},{},{},{angle},{},{},{},{},0.02",
            position.x, position.y, after.x, after.y, start.x, start.y, end.x, end.y
        );
    }
    text += "60,square,0,0,0,0,0,1.5,-0.051,0.03,-0.041,0.03,0.02\n\
             61,hex,0,0,0,0,0,0,-0.051,0.03,-0.041,0.03,0.02\n";
    let set = SmallSet::new();
    std::fs::create_dir(set.path("ends")).unwrap();
    set.write("ends/dataset.toml", MANIFEST);
    set.write("ends/pushes.csv", &text);
    set
}

fn json(set: &SmallSet, arguments: &[&str]) -> Value {
    let run = set.done(&[arguments, &["--json"]].concat());
    serde_json::from_str(&run.stdout).unwrap()
}

#[test]
fn pushes_that_begin_inside_the_models_object_are_left_out_of_roll_outs_and_named() {
    let set = pushes();
    set.done(&["models", "init", "ends"]);
    // The pushes begin 1 mm before the touch.
    set.done(&["add", "pose-offset", "--set", "mx=0.003", "--set", "my=0", "-o", "off.toml"]);
    let simulate = ["simulate", "ends", "--model", "off.toml", "--particles", "9", "-n", "100"];
    let run = set.done(&[&simulate[..], &["-o", "out"]].concat());
    let (_, told) = run.stderr.split_once("warning: ").unwrap();
    let (n_out, told) = told.split_once(" of 60 pushes cannot be rolled out: ").unwrap();
    let (name, why) = told.split_once(" (").unwrap();
    assert!(why.contains("mm inside the object"), "{why}");
    // The object's place has a tenth of a millimeter of scatter.
    let sd = run.stderr.split_once("taken as measured to ").unwrap().1.split_once(" mm").unwrap().0;
    assert!((0.03..0.15).contains(&sd.parse::<f64>().unwrap()), "{sd}");
    let n_ends = 60 - n_out.parse::<usize>().unwrap();
    assert!(run.stdout.contains(&format!("of {n_ends} measured ends")), "{}", run.stdout);
    let alone = ["simulate", "ends", "--model", "off.toml", "--push", name, "-o", "other"];
    assert!(set.error(&alone).contains(&format!("cannot roll out {name}")));
}

#[test]
fn ends_are_ingested_compared_and_added_to_like_any_other_set() {
    let set = pushes();
    let text = set.done(&["ingest", "ends", "-o", "steps.csv"]).stdout;
    for part in [
        "60 pushes used, 2 excluded, 60 rows",
        "excluded, tracking flip: 1",
        "pushes_shape=hex: 1 pushes of hex, the set is about square",
        "push 60: the object turns by 85.9°",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    set.done(&["models", "init", "ends"]);
    let fit = ["add", "friction-center-offset", "--fit", "ends", "-o", "added.toml"];
    set.done(&fit);
    let model = set.read("added.toml");
    let mut values = model.lines().filter_map(|line| line.strip_prefix("value = "));
    let is_near =
        |wanted: f64| values.any(|value| (value.parse::<f64>().unwrap() - wanted).abs() < 5e-4);
    assert!(OFFSET.map(is_near) == [true; 2], "{model}");
    let median = |source: &[&str], model: &str| {
        let found = json(&set, &[&["compare"], source, &["--model", model]].concat());
        assert_eq!(found["n_pushes"], if model == "model.toml" { 60 } else { 15 });
        found["roll_outs"]["position"]["median"].as_f64().unwrap()
    };
    let table: &[&str] = &["steps.csv", "--manifest", "ends/dataset.toml"];
    let [before, after] = ["model.toml", "added.toml"].map(|model| median(&["ends"], model));
    assert!(before > 1.5e-3 && after < 3e-4, "{before} {after}");
    assert_eq!(median(table, "model.toml"), before);
    assert!(set.done(&["check", "ends"]).stdout.contains("friction-center-offset"));
}

#[test]
fn ends_are_suggested_reported_and_simulated_like_any_other_set() {
    let set = pushes();
    set.done(&["models", "init", "ends"]);
    let found = json(&set, &["diagnose", "ends", "-o", "diagnosis.json"]);
    assert_eq!(found["identified"], serde_json::json!(["friction-center-offset"]), "{found}");
    let suggest = ["suggest", "--from", "diagnosis.json", "-n", "15", "--force"];
    let suggested = json(&set, &suggest);
    assert_eq!(suggested["aim"], "precision");
    let pushes = suggested["pushes"].as_array().unwrap();
    assert!(pushes.len() == 15 && pushes.iter().all(|push| push["travel"] == 0.04), "{suggested}");
    // A push that is suggested tells no more than its ends do: 15 well chosen ones beside 45.
    let suggested = json(&set, &[&suggest[..], &["--for", "pusher-friction"]].concat());
    let known = &suggested["precisions"][0];
    let [so_far, expected] = ["now", "expected"].map(|key| known[key].as_f64().unwrap());
    assert!((0.65..0.95).contains(&(expected / so_far)), "{known}");
    let report = ["report", "ends", "--from", "diagnosis.json"];
    let written = json(&set, &report);
    assert_eq!((&written["n_pushes"], &written["n_played"]), (&60.into(), &60.into()));
    let page = set.read("report.html");
    assert!(page.contains("friction-center-offset") && page.contains("<title>ends: models"));
    set.done(&["add", "--from", "diagnosis.json", "-o", "added.toml"]);
    let end = |model: &str, n_most: usize| {
        let file = format!("{model}.toml");
        let simulate = ["simulate", "ends", "--particles", "20", "--model", &file, "-o", model];
        let simulated = json(&set, &[&simulate[..], &["--push", "pushes_shape=square#7"]].concat());
        let push = &simulated["pushes"][0];
        // In steps of 4 mm at the most, from the start to the only other pose that was measured.
        assert!((10..=n_most).contains(&push["moments"].as_array().unwrap().len()), "{push}");
        push["end"]["error"][0].as_f64().unwrap()
    };
    let [before, after] = ["model", "added"].map(|model| end(model, 12));
    assert!(after < 3e-4 && before > 2.0 * after, "{before} {after}");
    let poses = set.read("added/poses.csv");
    let measured =
        poses.lines().filter(|line| line.starts_with("pushes") && !line.ends_with(",,,"));
    assert_eq!(measured.count(), 2);
    // All the way, but for what takes steps.
    let ran = json(&set, &["run", "ends", "-o", "ran"]);
    let last = ran["phases"].as_array().unwrap().last().unwrap();
    assert_eq!((&last["name"], &last["state"]), (&"calibrate".into(), &"not_told".into()));
    assert_eq!(ran["model"], "ran/better.toml");
}

#[test]
fn what_ends_cannot_be_asked_is_refused_with_what_to_give() {
    let set = pushes();
    let refused = |arguments: &[&str], code: i32, says: &str| {
        let run = set.run(arguments);
        assert_eq!(run.code, Some(code), "{}", run.stderr);
        assert!(run.stderr.contains(says), "{says}: {}", run.stderr);
    };
    refused(&["ingest", "ends", "--step", "4mm"], 2, "leave out --step and --curve");
    set.done(&["models", "init", "ends"]);
    let one = "a push of which the ends are known is one";
    refused(&["compare", "ends", "--step", "4mm"], 2, one);
    refused(&["report", "ends", "--step", "4mm"], 2, one);
    let file = "ends/pushes.csv";
    for command in [
        &["ingest", file][..],
        &["report", file],
        &["models", "init", file, "-o", "other.toml"],
        &["simulate", file, "-o", "rolled"],
    ] {
        refused(command, 1, "give --preset, or the folder of a dataset.toml");
    }
    let together = ["simulate", "ends", "--correlation", "ends", "-o", "rolled"];
    refused(&together, 1, "do not tell how the errors of steps go together");
    let unknown = ["simulate", "ends", "--push", "pushes_shape=square#99", "-o", "rolled"];
    refused(&unknown, 1, "has no push pushes_shape=square#99; it has pushes_shape=square#0");
    let path = ["simulate", "arc.csv", "--preset", "mit-endpoints", "-o", "rolled"];
    set.write("arc.csv", "t_s,x_m,y_m\n");
    refused(&path, 2, "--preset are for recorded pushes");
    refused(&["ingest", "set", "--shape", "hex"], 2, "--preset");
    set.edit("ends/pushes.csv", ",0.02\n", ",2cm/s\n");
    refused(&["ingest", "ends"], 1, "pushes.csv:2: speed_m_s is `2cm/s`, expected a finite number");
}
