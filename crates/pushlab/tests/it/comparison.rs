//! `pushlab compare` on the fixture pushes, which hide nothing.

use std::path::Path;

use serde_json::Value;

use crate::schema;
use crate::small_set::SmallSet;

const ANISOTROPY: &str = "
[[effects]]
id = \"table-anisotropy\"
[effects.parameters.ratio]
value = 1.3
[effects.parameters.direction]
value = 0.6
unit = \"rad\"
";

/// The sixty pushes with their nominal model and one that claims a grain that is not there.
pub(crate) fn pushes() -> SmallSet {
    let set = SmallSet::new();
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/pushes");
    crate::documentation::copy(&from, &set.path("pushes"));
    set.done(&["models", "init", "pushes"]);
    set.write("grain.toml", &(set.read("model.toml") + ANISOTROPY));
    set
}

#[test]
fn a_wrong_effect_raises_the_error_and_the_page_says_so() {
    let set = pushes();
    let arguments = ["compare", "pushes", "--model", "grain.toml", "--against", "model.toml"];
    let run = set.done(&[&arguments[..], &["--json"]].concat());
    let document: Value = serde_json::from_str(&run.stdout).unwrap();
    let result = &document;
    assert_eq!(schema::fault(result, &schema::comparison()), None);
    let changes = result["against"]["changes"].as_array().unwrap();
    let names: Vec<_> = changes.iter().map(|change| change["name"].as_str().unwrap()).collect();
    let all = ["dx", "dy", "dtheta", "force_normal", "force_tangential", "gap_start", "gap_end"];
    assert_eq!(names, all);
    let turn = &changes[2];
    let [change, se] = ["square_change", "square_change_se"].map(|key| turn[key].as_f64().unwrap());
    assert!(change > 2.0 * se, "{turn}");
    assert_eq!(result["n_pushes"], 60);
    let nominal = set.done(&["compare", "pushes", "--json"]);
    let nominal: Value = serde_json::from_str(&nominal.stdout).unwrap();
    let median = |result: &Value| {
        let ends = &result["roll_outs"];
        assert_eq!(ends["pushes"].as_array().unwrap().len(), 60);
        ends["position"]["median"].as_f64().unwrap()
    };
    let (wrong, right) = (median(result), median(&nominal));
    assert!(right < 1e-3 && 2.0 * right < wrong, "{right} {wrong}");
    assert_eq!(document["made_by"]["inputs"].as_array().unwrap().len(), 2 + 2 + 60);
    let text = set.done(&arguments).stdout;
    for part in [
        "error of a step, RMS",
        "dtheta",
        "floor",
        "error of a step, RMS (5 mm of smoothed motion, away from vertices)",
        "error at the end of a push",
        "where it fails",
        "worst pushes",
        "against nominal",
    ] {
        assert!(text.contains(part), "no {part} in {text}");
    }
    let again = set.done(&[&arguments[..], &["--json", "--jobs", "1"]].concat());
    assert_eq!(run.stdout, again.stdout);
}

#[test]
fn a_step_table_is_compared_as_its_recordings_are() {
    let set = pushes();
    set.done(&["ingest", "pushes", "-o", "steps.csv"]);
    let channels = |arguments: &[&str]| {
        let run = set.done(&[&["compare"], arguments, &["--json"]].concat());
        let mut document: Value = serde_json::from_str(&run.stdout).unwrap();
        document["channels"].take()
    };
    let of_table = channels(&["steps.csv", "--manifest", "pushes/dataset.toml"]);
    assert_eq!(of_table, channels(&["pushes", "--step", "200ms"]));
    let message = set.error(&["compare", "steps.csv"]);
    assert!(message.contains("does not tell what was pushed"), "{message}");
    std::fs::copy(set.path("pushes/dataset.toml"), set.path("dataset.toml")).unwrap();
    assert_eq!(of_table, channels(&["steps.csv"]));
}

/// One-step pushes in which the object always moves by half of the pusher's way.
#[test]
fn what_a_table_of_others_cannot_tell_is_said() {
    let set = pushes();
    let mut table = "c,phi_rad,dx_c_m,dy_c_m_sign_flipped,dtheta_rad\n".to_owned();
    for k in 0..200 {
        let (c, phi) = (f64::from(k % 20) / 20.0, f64::from(k % 7) / 7.0 - 0.4);
        table += &format!("{c},{phi},0.002,0.0,{}\n", 0.01 * (c - 0.5));
    }
    set.write("table.csv", &table);
    let arguments = ["compare", "table.csv", "--preset", "mit-table"];
    let run = set.done(&[&arguments[..], &["--json"]].concat());
    let document: Value = serde_json::from_str(&run.stdout).unwrap();
    let result = &document;
    assert_eq!(schema::fault(result, &schema::comparison()), None);
    assert_eq!(result["floor"]["source"], "neighbours");
    assert!(result["roll_outs"].is_null());
    let said: Vec<_> =
        result["not_asked"].as_array().unwrap().iter().map(|what| what.as_str().unwrap()).collect();
    assert_eq!(
        said,
        [
            "not measured or not predicted: force_normal, force_tangential, gap_start, gap_end",
            "not known of a step: orientation, direction, table x, table y, order of the pushes",
            "the same in every step: speed, edge",
            "no roll-outs: every push is one step",
        ]
    );
    let found = result["findings"].as_array().unwrap();
    assert!(found.iter().any(|one| one["sentence"].as_str().unwrap().starts_with("moves")));
    // As little can a fit tell what acts along directions of the table.
    for id in ["table-anisotropy", "table-tilt", "friction-gradient"] {
        let says = "because it depends on how the object lies on the table, and its orientation is not \
                    known; measure the object's pose on the table";
        let fit = ["add", id, "--fit", "table.csv", "--preset", "mit-table", "-o", "added.toml"];
        for more in [&[][..], &["--per-push"]] {
            let refused = set.error(&[&fit[..], more].concat());
            assert!(
                refused.contains(says) && refused.contains(&format!("{id} is not testable")),
                "{refused}"
            );
        }
    }
    let refused = set.error(&["compare", "table.csv"]);
    assert!(refused.contains("give --preset mit-table, or --mapping FILE"), "{refused}");
}

#[test]
fn every_step_is_written_with_what_was_measured_and_predicted() {
    let set = pushes();
    let words = ["compare", "pushes", "--model", "model.toml"];
    let compared = set.done(&[&words[..], &["-o", "residuals.csv", "--json"]].concat());
    let compared: Value = serde_json::from_str(&compared.stdout).unwrap();
    let text = set.read("residuals.csv");
    assert!(text.starts_with("# tool: pushlab"), "{text}");
    let mut rows = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
    let head = rows.headers().unwrap().clone();
    let at = |name: &str| head.iter().position(|known| known == name).unwrap();
    let [part, turn] = ["part", "dtheta_residual_rad"].map(at);
    let rows: Vec<csv::StringRecord> = rows.into_records().map(Result::unwrap).collect();
    assert_eq!(compared["n_steps"], rows.len());
    assert!(rows.iter().all(|row| &row[part] == "all"));
    let squares = rows.iter().map(|row| row[turn].parse::<f64>().unwrap().powi(2));
    let rms = (squares.sum::<f64>() / rows.len() as f64).sqrt();
    let told = compared["channels"][2]["rms"].as_f64().unwrap();
    assert!((rms - told).abs() < 1e-12, "{rms} {told}");
    set.done(&[&words[..], &["-o", "residuals.parquet"]].concat());
    let refused = set.error(&[&words[..], &["-o", "residuals.csv"]].concat());
    assert!(refused.contains("--force"), "{refused}");
}

#[test]
fn what_cannot_be_compared_is_refused_with_the_reason() {
    let set = pushes();
    set.edit("grain.toml", "1.3", "9.0");
    let message = set.error(&["compare", "pushes", "--model", "grain.toml"]);
    assert!(message.contains("effects.parameters.ratio.value: must be from"), "{message}");
    let message = set.error(&["compare", "set", "--model", "model.toml"]);
    assert!(message.contains("2 pushes have steps to compare, at least 3"), "{message}");
    let message = set.error(&["compare", "pushes", "--model", "missing.toml"]);
    assert!(message.contains("cannot read missing.toml"), "{message}");
}
