//! Recordings that contradict the mechanics, and those that tell little.

use serde_json::Value;

use crate::schema;
use crate::small_set::SmallSet;

/// Pushes of the simulator as CSV, whose manifest can be made wrong, with the nominal model.
fn pushes(more: &[&str]) -> SmallSet {
    let set = SmallSet::new();
    let words =
        ["generate", "-o", "pushes", "--rig", "quiet", "--format", "csv", "--seed", "5", "-q"];
    set.done(&[&words[..], more].concat());
    set.done(&["models", "init", "pushes", "-q"]);
    set
}

/// What the manifest says of a stream.
fn say(set: &SmallSet, of_stream: &str) {
    set.write("pushes/dataset.toml", &(set.read("pushes/dataset.toml") + of_stream));
}

#[test]
fn a_wrong_sign_or_unit_is_told_and_nothing_is_named() {
    for (of_stream, what, fix) in [
        (
            "\n[streams.object.columns]\ntheta = { column = \"theta_rad\", scale = -1.0 }\n",
            "the object's angle has the wrong sign",
            "scale = -1 under streams.object",
        ),
        (
            "\n[streams.wrench]\nframe = \"sensor\"\nsigns = [\"-x\", \"-y\", \"+z\"]\n",
            "wrong signs of x and y of the force",
            "signs = [\"-x\", \"-y\", \"+z\"]",
        ),
        (
            "\n[streams.robot.columns]\nx = { column = \"x_m\", scale = 1000.0 }\n\
             y = { column = \"y_m\", scale = 1000.0 }\n",
            "the pusher's positions are in mm, not m",
            "scale = 0.001 under streams.robot",
        ),
    ] {
        let set = pushes(&["--pushes", "12"]);
        say(&set, of_stream);
        let message = set.error(&["diagnose", "pushes", "-o", "d.json"]);
        assert!(message.contains("contradict the mechanics"), "{message}");
        assert!(message.contains(what) && message.contains(fix), "{message}");
        assert!(!set.exists("d.json"));
        for command in ["check", "compare", "report"] {
            let told = set.run(&[command, "pushes", "--model", "model.toml", "-q"]).stderr;
            assert!(told.starts_with(&format!("warning: {what}: ")), "{command}: {told}");
        }
    }
}

/// A table with one of its columns times a factor.
fn spoiled(table: &str, column: &str, factor: f64) -> String {
    let (mut place, mut lines) = (None, Vec::new());
    for line in table.lines() {
        let mut cells: Vec<_> = line.split(',').map(str::to_owned).collect();
        match place {
            None => place = cells.iter().position(|cell| cell == column),
            Some(place) => {
                let value: f64 = cells[place].parse().unwrap();
                cells[place] = (factor * value).to_string();
            }
        }
        lines.push(cells.join(","));
    }
    assert!(place.is_some(), "no column {column}");
    lines.join("\n") + "\n"
}

#[test]
fn a_step_table_with_a_wrong_sign_or_unit_is_told_and_nothing_is_named() {
    let set = pushes(&["--pushes", "24", "--hidden", "friction-center-offset"]);
    set.done(&["ingest", "pushes", "-o", "steps.csv", "-q"]);
    let table = set.read("steps.csv");
    let about = ["--manifest", "pushes/dataset.toml", "--model", "model.toml"];
    let run = |command: &[&str]| set.run(&[command, &about].concat());
    assert_eq!(run(&["compare", "steps.csv", "-q"]).stderr, "");
    for (column, factor, what) in [
        ("dtheta_rad", -1.0, "dtheta_rad has the wrong sign"),
        ("dtheta_rad", 180.0 / std::f64::consts::PI, "dtheta_rad is in degrees, not rad"),
        ("dy_m", -1.0, "dy_m or beta_rad has the wrong sign"),
    ] {
        set.write("wrong.csv", &spoiled(&table, column, factor));
        let refused = run(&["diagnose", "wrong.csv", "-o", "d.json"]).stderr;
        assert!(refused.contains("contradict the mechanics"), "{refused}");
        assert!(refused.contains(what) && !set.exists("d.json"), "{refused}");
        let told = run(&["compare", "wrong.csv", "-q"]).stderr;
        assert!(told.starts_with(&format!("warning: {what}")), "{told}");
    }
}

#[test]
fn what_is_right_raises_no_warning() {
    let set = pushes(&["--pushes", "12", "--hidden", "yaw-offset"]);
    let run = set.done(&["check", "pushes", "-q", "--json"]);
    let document: Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(document["suspicions"].as_array().map(Vec::len), Some(0));
    assert_eq!(run.stderr, "");
}

/// Forces in lbf are those of a table with less friction.
#[test]
fn what_may_be_wrong_and_what_is_excluded_stands_beside_each_answer() {
    let set = pushes(&["--pushes", "14"]);
    say(
        &set,
        "\n[streams.wrench.columns]\nfx = { column = \"fx_n\", scale = 0.2248 }\n\
         fy = { column = \"fy_n\", scale = 0.2248 }\n",
    );
    let object = "pushes/pushes/push-0000/object.csv";
    let before_contact: Vec<_> = set.read(object).lines().take(12).map(str::to_owned).collect();
    set.write(object, &(before_contact.join("\n") + "\n"));
    let warning = "perhaps the force is in lbf, not N";
    let answer = |command: &str| {
        let run = set.done(&[command, "pushes", "--json"]);
        assert!(run.stderr.contains("note: 1 of 14 pushes are excluded: "), "{}", run.stderr);
        assert!(run.stderr.starts_with(&format!("warning: {warning}: ")), "{}", run.stderr);
        let document = serde_json::from_str::<Value>(&run.stdout).unwrap();
        let told = document["warnings"].as_array().unwrap().iter().map(|one| one.as_str().unwrap());
        let told: Vec<_> = told.collect();
        assert!(told[0].starts_with(warning), "{told:?}");
        assert!(
            told.iter().any(|one| one.starts_with("1 of 14 pushes are excluded: ")),
            "{told:?}"
        );
        assert!(told.iter().all(|one| run.stderr.matches(one).count() == 1), "{}", run.stderr);
        document
    };
    let compared = answer("compare");
    assert_eq!(schema::fault(&compared, &schema::comparison()), None);
    let diagnosed = answer("diagnose");
    assert_eq!(schema::fault(&diagnosed, &schema::diagnosis()), None);
    for suspicions in [&compared["suspicions"], &diagnosed["suspicions"]] {
        assert_eq!(suspicions.as_array().map(Vec::len), Some(1));
        let Value::Object(one) = &suspicions[0] else { panic!("{suspicions}") };
        assert_eq!((&one["what"], &one["is_certain"]), (&warning[8..].into(), &false.into()));
    }
    assert_eq!(diagnosed["data"]["pushes_set_aside"], 1);
    let sentence = diagnosed["sentence"].as_str().unwrap();
    assert!(sentence.starts_with("Only if what may be wrong with these recordings"), "{sentence}");
}

#[test]
fn too_few_pushes_are_told_how_many_more_are_needed() {
    let set = pushes(&["--pushes", "6"]);
    let message = set.error(&["diagnose", "pushes"]);
    assert!(message.contains("at least 10 are needed: record 4 more"), "{message}");
}

#[test]
fn pushes_of_one_kind_are_told_what_they_cannot_tell() {
    let lines = "0,0.5,0,20\n".repeat(12);
    let set = SmallSet::new();
    set.write("one.csv", &format!("edge,p,angle_deg,speed_mm_s\n{lines}"));
    set.done(&["generate", "-o", "pushes", "--design", "one.csv", "-q"]);
    let told = set.done(&["check", "pushes", "-q"]).stderr;
    for part in ["one edge in one orientation", "one angle to the edge", "one place of an edge"] {
        assert!(told.contains(part), "no {part:?} in {told}");
    }
}

#[test]
fn a_set_without_contact_and_a_table_with_a_hole_are_refused_with_the_place() {
    let set = pushes(&["--pushes", "10"]);
    set.done(&["ingest", "pushes", "-o", "steps.csv", "-q"]);
    let text = set.read("steps.csv");
    let header = text.lines().position(|line| line.starts_with("recording,")).unwrap();
    let mut lines: Vec<_> = text.lines().map(str::to_owned).collect();
    let place = lines[header].split(',').position(|name| name == "dx_m").unwrap();
    let mut cells: Vec<_> = lines[header + 2].split(',').map(str::to_owned).collect();
    cells[place] = "NaN".to_owned();
    lines[header + 2] = cells.join(",");
    set.write("hole.csv", &(lines.join("\n") + "\n"));
    let message = set.error(&["diagnose", "hole.csv", "--manifest", "pushes/dataset.toml"]);
    assert!(message.contains(&format!("hole.csv:{}: dx_m is `NaN`", header + 3)), "{message}");
    // The object that rests where the pusher does not come.
    say(
        &set,
        "\n[streams.object.columns]\nx = { column = \"x_m\", scale = 1e-9, offset = 0.5 }\n\
         y = { column = \"y_m\", scale = 1e-9 }\n",
    );
    let message = set.error(&["diagnose", "pushes"]);
    assert!(message.contains("contradict the mechanics"), "{message}");
    assert!(message.contains("frames of pusher and object do not fit"), "{message}");
}

#[test]
fn a_model_with_an_unknown_effect_or_an_impossible_value_names_line_value_and_range() {
    let set = pushes(&["--pushes", "2"]);
    let model = set.read("model.toml");
    let line = model.lines().count() + 2;
    let tail = "\n[[effects]]\nid = \"table-tilt\"\n[effects.parameters.ax]\nvalue = 0.1\n\
                unit = \"m/s²\"\n[effects.parameters.ay]\nvalue = 99.0\nunit = \"m/s²\"\n";
    set.write("model.toml", &(model.clone() + &tail.replace("table-tilt", "table-tlit")));
    let message = set.error(&["diagnose", "pushes"]);
    let named = format!("model.toml:{}: effects.id: `table-tlit` is not known", line + 1);
    assert!(message.contains(&named) && message.contains("table-tilt"), "{message}");
    set.write("model.toml", &(model + tail));
    let message = set.error(&["diagnose", "pushes"]);
    let named = format!("model.toml:{}: effects.parameters.ay.value: must be from", line + 5);
    assert!(message.contains(&named) && message.contains("got 99"), "{message}");
}

#[test]
fn without_a_force_sensor_every_format_is_read() {
    for format in ["mcap-ros2", "mcap-json", "csv"] {
        let set = SmallSet::new();
        set.write("rig.toml", "[sensors.force]\nrate = 0.0\n");
        let words = ["generate", "-o", "pushes", "--settings", "rig.toml", "--pushes", "10"];
        set.done(&[&words[..], &["--format", format]].concat());
        let run = set.done(&["check", "pushes", "--json"]);
        let document: Value = serde_json::from_str(&run.stdout).unwrap();
        assert_eq!(document["channels"], serde_json::json!(["motion", "gap"]));
    }
}
