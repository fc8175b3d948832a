//! Every command takes every kind of input, and says of each what the same pushes say.

use serde_json::Value;

use crate::comparison::pushes;
use crate::small_set::SmallSet;

/// The sixty pushes as recordings, as a table in both forms, as one that a stranger has, with and without ids
/// of pushes, and as one of the stranger's that was converted.
fn inputs() -> SmallSet {
    let set = pushes();
    std::fs::create_dir(set.path("beside")).unwrap();
    std::fs::copy(set.path("pushes/dataset.toml"), set.path("beside/dataset.toml")).unwrap();
    set.done(&["ingest", "pushes", "-o", "beside/steps.csv", "-q"]);
    set.done(&["ingest", "pushes", "-o", "steps.parquet", "-q"]);
    let text = set.read("beside/steps.csv");
    let mut lines = text.lines().filter(|line| !line.starts_with('#'));
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let place = |name: &str| names.iter().position(|known| *known == name).unwrap();
    let ids = ["step", "t_s", "object_x_m", "object_y_m", "object_theta_rad"];
    let steps = ["edge", "p", "beta_rad", "dt_s", "speed_m_s", "dx_m", "dy_m", "dtheta_rad"];
    let header =
        |columns: &[&str]| columns.iter().map(|name| format!("their_{name}")).collect::<Vec<_>>();
    let mut whole = header(&[&["push"], &ids[..], &steps[..]].concat()).join(",") + "\n";
    let mut single = header(&steps).join(",") + "\n";
    for line in lines {
        let cells: Vec<&str> = line.split(',').collect();
        let of = |columns: &[&str]| {
            columns.iter().map(|name| cells[place(name)]).collect::<Vec<_>>().join(",")
        };
        let push = cells[place("recording")].trim_start_matches("push-");
        whole += &format!("{push},{},{}\n", of(&ids), of(&steps));
        single += &(of(&steps) + "\n");
    }
    set.write("whole.csv", &whole);
    set.write("single.csv", &single);
    let manifest = set.read("pushes/dataset.toml");
    let rig = &manifest[manifest.find("[object]").unwrap()..manifest.find("[recordings]").unwrap()];
    let mapping = |columns: &[&str]| {
        let columns: Vec<_> =
            columns.iter().map(|name| format!("{name} = \"their_{name}\"\n")).collect();
        format!(
            "schema = \"pushlab.table-mapping/1\"\nname = \"theirs\"\n{rig}\n[columns]\n{}",
            columns.concat()
        )
    };
    set.write("whole.toml", &mapping(&[&["push"], &ids[..], &steps[..]].concat()));
    set.write("single.toml", &mapping(&steps));
    set.done(&["ingest", "single.csv", "--mapping", "single.toml", "-o", "converted.csv", "-q"]);
    set
}

const INPUTS: [&[&str]; 8] = [
    &["pushes"],
    &["pushes/dataset.toml"],
    &["beside/steps.csv"],
    &["steps.parquet", "--manifest", "pushes/dataset.toml"],
    &["whole.csv", "--mapping", "whole.toml"],
    &["single.csv", "--mapping", "single.toml"],
    &["converted.csv", "--manifest", "single.toml"],
    &["converted.csv", "--mapping", "single.toml"],
];

fn result(set: &SmallSet, command: &[&str], input: &[&str], rest: &[&str]) -> Value {
    serde_json::from_str(&set.done(&[command, input, rest, &["--json"]].concat()).stdout).unwrap()
}

#[test]
fn a_nominal_model_is_the_same_whatever_tells_the_rig() {
    let set = inputs();
    let mut models = Vec::new();
    let mappings: [&[&str]; 2] = [&["single.toml"], &["--mapping", "whole.toml"]];
    for input in INPUTS.into_iter().chain(mappings) {
        set.done(&[&["models", "init"], input, &["-o", "of.toml", "--force"]].concat());
        let mut model: toml::Table = set.read("of.toml").parse().unwrap();
        // Names and sources are each input's own.
        model.remove("name");
        model["made_for"].as_table_mut().unwrap().remove("set");
        let base = model["base"].as_table_mut().unwrap();
        base["pusher_friction"].as_table_mut().unwrap().remove("source");
        models.push(model);
    }
    assert!(models.iter().all(|model| *model == models[0]), "{models:#?}");
    assert_eq!(models[0]["made_for"]["object"]["mass_kg"].as_float(), Some(0.8374));
}

#[test]
fn every_input_is_checked_compared_and_fitted_to() {
    let set = inputs();
    for input in INPUTS {
        let compared = result(&set, &["compare"], input, &[]);
        let n_steps = compared["n_steps"].as_u64().unwrap();
        assert!(n_steps > 400, "{input:?}: {n_steps}");
    }
    for input in [INPUTS[3], INPUTS[4], INPUTS[6]] {
        let fitted = ["--free", "pusher-friction", "-o", "fitted.toml", "--force"];
        let fitted = result(&set, &["fit"], input, &fitted);
        let friction = fitted["effects"][0]["parameters"][0]["value"].as_f64().unwrap();
        assert!((friction - 0.25).abs() < 0.03, "{input:?}: {friction}");
    }
    for input in [INPUTS[0], INPUTS[2], INPUTS[4], INPUTS[5]] {
        let checked = result(&set, &["check"], input, &[]);
        assert_eq!(checked["duration"].is_null(), input[0] == "single.csv", "{input:?}");
        let unknown = checked["unknown"].as_array().unwrap();
        assert_eq!(unknown.is_empty(), input[0] != "single.csv", "{input:?}");
    }
}

#[test]
fn whole_pushes_of_tables_are_rolled_out_as_those_of_their_recordings() {
    let set = inputs();
    let ends = |input: &[&str]| {
        let rest = ["--particles", "20", "-n", "3", "-o", "out"];
        let found = result(&set, &["simulate"], input, &rest);
        std::fs::remove_dir_all(set.path("out")).unwrap();
        let pushes = found["pushes"].as_array().unwrap();
        pushes.iter().map(|push| push["end"]["error"].clone()).collect::<Vec<_>>()
    };
    let of_recordings = ends(INPUTS[0]);
    assert_eq!(of_recordings.len(), 3);
    for input in [INPUTS[1], INPUTS[2], INPUTS[3]] {
        assert_eq!(ends(input), of_recordings, "{input:?}");
    }
    assert_eq!(ends(INPUTS[4]).len(), 3);
    for input in [INPUTS[5], INPUTS[7]] {
        let message = set.error(&[&["simulate"], input, &["-o", "out"]].concat());
        let told = ["does not tell which of its rows follow", "no push, step, t_s, object_x_m"];
        assert!(told.iter().all(|part| message.contains(part)), "{message}");
        assert!(message.contains("pushlab compare"), "{message}");
    }
    let message = set.wrong_usage(&["simulate", "beside/steps.csv", "--step", "4mm", "-o", "out"]);
    assert!(message.contains("the steps of a table are made"), "{message}");
}

#[test]
fn what_an_input_lacks_is_said_with_what_to_do() {
    let set = inputs();
    for command in [&["models", "init"][..], &["check"], &["compare"], &["report"]] {
        let told = |input: &[&str], parts: &[&str]| {
            let message = set.error(&[command, input].concat());
            assert!(parts.iter().all(|part| message.contains(part)), "{command:?}: {message}");
        };
        let output = command.len() == 2;
        let force: &[&str] = if output { &["--force"] } else { &[] };
        let plain = |input: &'static str| [&[input], force].concat();
        told(&plain("single.csv"), &["needs a mapping of its columns", "--mapping FILE"]);
        told(&plain("steps.parquet"), &["does not tell what was pushed", "--manifest"]);
        if !output {
            told(&["whole.toml"], &["give the table, with --mapping whole.toml"]);
        }
        let parquet = [&["model.toml", "--mapping", "single.toml"], force].concat();
        told(&parquet, &["model.toml"]);
    }
    set.done(&["init", "pushes/pushes", "-o", "draft.toml", "-q"]);
    let message = set.error(&["models", "init", "draft.toml", "-o", "of.toml"]);
    for part in
        ["3 values are still", "object.shape in line", "object.mass_kg", "pusher.radius_m in line"]
    {
        assert!(message.contains(part), "{message}");
    }
    let message = set.wrong_usage(&["models", "init", "-o", "of.toml"]);
    assert!(message.contains("<SET>") || message.contains("[SET]"), "{message}");
    let both = ["compare", "pushes", "--manifest", "pushes/dataset.toml"];
    assert!(set.wrong_usage(&both).contains("a set has its own"));
}
