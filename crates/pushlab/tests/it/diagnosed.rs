//! `pushlab add --from`: what a diagnosis names, in a model.

use std::path::Path;
use std::sync::OnceLock;

use serde_json::{Value, json};

use crate::small_set::SmallSet;

/// The fixture pushes, whose object stands on a uniform patch, with the nominal model, the same with
/// λ fitted, and the diagnosis that says so.
pub(crate) fn diagnosed() -> (SmallSet, Value) {
    let set = SmallSet::new();
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/pushes");
    crate::documentation::copy(&from, &set.path("pushes"));
    set.done(&["models", "init", "pushes"]);
    static FITTED: OnceLock<String> = OnceLock::new();
    let fit = || {
        set.done(&["add", "limit-surface-shape", "--fit", "pushes", "-o", "fitted.toml"]);
        set.read("fitted.toml")
    };
    set.write("fitted.toml", FITTED.get_or_init(fit));
    let fitted: toml::Value = toml::from_str(&set.read("fitted.toml")).unwrap();
    let is_shape = |effect: &&toml::Value| effect["id"].as_str() == Some("limit-surface-shape");
    let effect = fitted["effects"].as_array().unwrap().iter().find(is_shape).unwrap();
    let lambda = &effect["parameters"]["lambda"];
    let [value, se] = ["value", "se"].map(|key| lambda[key].as_float().unwrap());
    let motion = json!({ "dx_m": 1e-4, "dy_m": 1e-4, "dtheta_rad": 1e-3 });
    let finding = |id: &str, grade: &str, why: &str, parameters: Value| {
        json!({ "id": id, "grade": grade, "p_adjusted": 0.001, "gap_closed": 0.9,
                "log_density_gain": { "mean": 40.0, "se": 9.0 }, "parameters": parameters,
                "rivals": [], "why": why })
    };
    let parameter = |name: &str, unit: &str, [value, se]: [f64; 2]| {
        json!({ "name": name, "unit": unit, "off": 0.0, "estimate": value, "se": se,
                "low95": value - 2.0 * se, "high95": value + 2.0 * se,
                "detection_limit": 0.1 })
    };
    let tilt = json!([parameter("ax", "m/s²", [0.1, 0.01]), parameter("ay", "m/s²", [0.0, 0.01])]);
    let diagnosis = json!({
        "schema": "pushlab.diagnosis/2", "verdict": "identified", "identified": ["limit-surface-shape"],
        "ambiguous": [["table-tilt", "inertia"]], "effective": [], "sentence": "Missing: the limit surface's shape.",
        "error": { "before": 2.0, "after": 1.1, "floor": 1.0, "gap_closed": 0.9,
                   "unit": "whitened RMS", "before_si": motion, "after_si": motion,
                   "floor_si": motion },
        "split": serde_json::to_value(&fitted["split"]).unwrap(),
        "effects": [
            finding("limit-surface-shape", "identified", "",
                    json!([parameter("lambda", "1", [value, se])])),
            finding("table-tilt", "ambiguous", "", tilt),
            finding("inertia", "ambiguous", "", json!([])),
            finding("stream-latency", "hint", "it may be chance", json!([])),
        ],
        "leftover": { "p": 0.5, "covariate": null },
        "noise": { "source": "repeats", "n_cells": 3 },
        "data": { "pushes_used": 60, "pushes_set_aside": 0, "pushes_fitted": 45, "pushes_confirming": 15, "steps": 600 },
    });
    set.write("d.json", &diagnosis.to_string());
    (set, diagnosis)
}

#[test]
fn what_a_diagnosis_names_is_added_and_compared_on_the_pushes_that_confirmed_it() {
    let (set, diagnosis) = diagnosed();
    let added = set.done(&["add", "--from", "d.json", "-o", "better.toml"]);
    assert!(added.stderr.contains("note:"), "no model is named in it: {}", added.stderr);
    let models = ["fitted.toml", "better.toml"].map(|name| {
        let model: toml::Value = toml::from_str(&set.read(name)).unwrap();
        let effects = model["effects"].as_array().unwrap().clone();
        let shape =
            effects.into_iter().find(|effect| effect["id"].as_str() != Some("support-friction"));
        let lambda = shape.unwrap()["parameters"]["lambda"].clone();
        (lambda["value"].clone(), lambda["se"].clone(), model["split"].clone())
    });
    assert_eq!(models[0], models[1]);
    assert!(set.read("better.toml").contains("diagnosed by a diagnosis on 45 pushes"));
    let compare =
        ["compare", "pushes", "--model", "better.toml", "--against", "model.toml", "--json"];
    let compared: Value = serde_json::from_str(&set.done(&compare).stdout).unwrap();
    let compared = &compared;
    assert_eq!(
        (&compared["part"]["pushes"], &compared["n_pushes"]),
        (&json!("confirm"), &json!(15))
    );
    let turn = &compared["against"]["changes"][2];
    let [before, after] = ["before", "after"].map(|key| turn[key].as_f64().unwrap());
    assert!(after < 0.5 * before, "{turn}");
    // A member of a group is added where it is asked for, beside what is there.
    let tilt = ["add", "table-tilt", "--from", "d.json", "--model", "better.toml", "-o", "c.toml"];
    assert_eq!(set.done(&tilt).stderr, "");
    let tilted: toml::Value = toml::from_str(&set.read("c.toml")).unwrap();
    assert_eq!(tilted["effects"][1]["parameters"]["ax"]["se"].as_float(), Some(0.01));
    assert_eq!(tilted["split"]["confirm"].as_array().unwrap().len(), 15);
    set.done(&["add", "--all", "--from", "d.json", "-o", "all.toml"]);
    let all: toml::Value = toml::from_str(&set.read("all.toml")).unwrap();
    let ids = all["effects"].as_array().unwrap().iter().map(|effect| effect["id"].as_str());
    assert!(ids.eq([Some("limit-surface-shape"), Some("table-tilt")]), "{all}");
    refused(&set, diagnosis);
}

#[test]
fn what_differs_from_push_to_push_is_carried_with_all_the_rest() {
    let (set, mut diagnosis) = diagnosed();
    let scatter = |id: &str, unit: &str, sd: f64, share: f64| {
        json!({ "effect": id, "unit": unit, "sd": sd, "low95": 0.5 * sd, "high95": 2.0 * sd,
                "share": share })
    };
    diagnosis["noise"]["push_to_push"] = json!([
        scatter("friction-center-offset", "m", 4e-3, 0.4),
        scatter("support-friction", "1", 0.02, 0.3),
        scatter("pusher-friction", "1", 0.03, 0.2),
        scatter("contact-bias", "m", 1e-4, 0.01),
    ]);
    set.write("d.json", &diagnosis.to_string());
    let added = set.done(&["add", "--all", "--from", "d.json", "-o", "all.toml"]);
    assert!(added.stderr.contains("pushlab add support-friction --fit SET --per-push"));
    assert!(added.stdout.contains("friction-center-offset dy, sd per push: 0.004 m"));
    let all: toml::Value = toml::from_str(&set.read("all.toml")).unwrap();
    let effect = |id: &str| {
        let mut effects = all["effects"].as_array().unwrap().iter();
        effects.find(|effect| effect["id"].as_str() == Some(id))
    };
    assert!(effect("support-friction").is_none() && effect("contact-bias").is_none(), "{all}");
    // About the value that the model has already.
    let friction = &effect("pusher-friction").unwrap()["parameters"]["friction"];
    assert_eq!(friction["value"].as_float(), Some(0.25));
    // Nothing is named, but that pushes differ.
    (diagnosis["identified"], diagnosis["ambiguous"]) = (json!([]), json!([]));
    set.write("d.json", &diagnosis.to_string());
    set.done(&["add", "--all", "--from", "d.json", "-o", "scatter.toml"]);
    // What a model gave to sessions is a part of what differs between pushes, and not beside it.
    let of_pushes = "friction.per_push]\nsd = 0.03\n";
    let of_sessions = "\n[effects.parameters.friction.per_session]\nsd = 0.2\n";
    set.write("sessions.toml", &set.read("scatter.toml"));
    set.edit("sessions.toml", of_pushes, &format!("{of_pushes}{of_sessions}"));
    set.done(&["add", "--all", "--from", "d.json", "--model", "sessions.toml", "-o", "again.toml"]);
    assert!(!set.read("again.toml").contains("per_session"));
    let simulate = ["simulate", "pushes", "--particles", "200", "-n", "15", "--json"];
    let held = |model: &str, correlation: &[&str]| -> u64 {
        let out = format!("out-{model}-{}", correlation.len());
        let words = [&["--model", model, "-o", &out], correlation].concat();
        let run = set.done(&[&simulate[..], &words].concat());
        let result: Value = serde_json::from_str(&run.stdout).unwrap();
        result["coverage"][1]["n_within"].as_u64().unwrap()
    };
    let as_it_is = ["--correlation", "none"];
    let plain = ["simulate", "pushes", "-n", "1", "--particles", "9", "-o", "p"];
    let plain = set.done(&[&plain[..], &as_it_is].concat()).stdout;
    assert!(plain.contains("`pushlab add --all --from DIAGNOSIS`"), "{plain}");
    // Of 15 ends, those within the 90 % region.
    assert!(held("scatter.toml", &as_it_is) > 9 && held("model.toml", &as_it_is) == 0);
    // Other pushes of the set tell how sure both may be.
    assert!(held("scatter.toml", &[]) > 9 && held("model.toml", &[]) > 9);
}

#[test]
fn the_page_tells_where_the_rest_comes_from_and_what_speaks_against_a_cause() {
    let (set, mut diagnosis) = diagnosed();
    let gain = |mean: f64| json!({ "mean": mean, "se": 10.0 });
    let origin = |origin: &str, mean: f64, at: Value| json!({ "origin": origin, "gain": gain(mean), "alone": 0.6, "last_in": 0.4, "at": at });
    diagnosis["remains"] = json!({
        "gain": gain(100.0), "share": 0.25, "smooth": gain(5.0),
        "origins": [origin("support", 60.0, json!("at p > 0.8")), origin("table", 3.0, Value::Null)],
    });
    // What is hardly seen is in no list of names, and is added with all the others.
    (diagnosis["verdict"], diagnosis["identified"]) = ("ambiguous".into(), json!([]));
    diagnosis["effects"][0]["small"] = true.into();
    diagnosis["effects"][1]["why"] = "its size differs by 40 % over yaw".into();
    set.write("d.json", &diagnosis.to_string());
    set.done(&["report", "pushes", "--from", "d.json"]);
    let page = set.read("report.html");
    for part in [
        "they take off 25 % of the squared error",
        "gains nothing sure",
        "60 ± 10",
        "at p &gt; 0.8",
        "its size differs by 40 % over yaw",
        "there, hardly seen",
    ] {
        assert!(page.contains(part), "no {part}");
    }
    // No share of what is not sure.
    assert_eq!((page.matches("60 %").count(), page.matches("40 %").count()), (1, 2));
    set.done(&["add", "--all", "--from", "d.json", "-o", "all.toml"]);
    assert_eq!(set.read("all.toml").matches("id = \"limit-surface-shape\"").count(), 1);
}

#[test]
fn the_page_shows_what_is_missing_beside_what_the_model_misses() {
    let (set, mut diagnosis) = diagnosed();
    diagnosis["sentence"] = "Missing: </script><script>alert(1)</script>".into();
    set.write("d.json", &diagnosis.to_string());
    let report = ["report", "pushes", "--from", "d.json", "--force"];
    set.done(&report);
    let page = set.read("report.html");
    for part in [
        "id=\"diagnosis\"",
        "What is missing",
        "effect changes<",
        "model misses<",
        "1 limit-surface-shape",
        "The diagnosis does not tell the values of inertia",
        "it may be chance",
        "--from d.json",
        "nothing beyond chance",
    ] {
        assert!(page.contains(part), "no {part}");
    }
    assert!(!page.contains("<script>alert(1)"));
    set.done(&[&report[..], &["--model", "fitted.toml"]].concat());
    assert!(set.read("report.html").contains("limit-surface-shape is in the page"));
    diagnosis["split"]["set"] = "0123".into();
    set.write("d.json", &diagnosis.to_string());
    assert!(set.error(&report).contains("is about other recordings than pushes"));
}

/// What cannot be added is told, and nothing is written.
fn refused(set: &SmallSet, diagnosis: Value) {
    let error = |words: &[&str]| {
        let message = set.error(&[&["add", "--from", "d.json", "-o", "e.toml"], words].concat());
        assert!(!set.exists("e.toml"));
        message
    };
    for (words, says) in [
        (&["table-anisotropy"][..], "the model that was diagnosed has it already"),
        (&["stream-latency"], "is a hint alone (it may be chance)"),
        (&["inertia"], "does not tell the values of inertia"),
        (&["--model", "better.toml"], "already in the model"),
    ] {
        let message = error(words);
        assert!(message.contains(says), "{message}");
    }
    set.wrong_usage(&["add", "-o", "e.toml"]);
    set.wrong_usage(&["add", "table-tilt", "--from", "d.json", "--fit", "pushes", "-o", "e.toml"]);
    let change = |pointer: &str, value: Value| {
        let mut other = diagnosis.clone();
        *other.pointer_mut(pointer).unwrap() = value;
        set.write("d.json", &other.to_string());
    };
    let mut other = diagnosis.clone();
    (other["identified"], other["ambiguous"]) = (json!([]), json!([]));
    other["effective"] = json!(["limit-surface-shape"]);
    set.write("d.json", &other.to_string());
    assert!(error(&[]).contains("`pushlab add --all --from …` adds what lowers it"));
    change("/identified", json!([]));
    assert!(error(&[]).contains("one of table-tilt, inertia; name the one to add"));
    change("/effects/0/parameters/0/estimate", json!(7.0));
    assert!(error(&[]).contains("lambda must be within"));
    change("/split/set", json!("0123456789abcdef"));
    assert!(error(&["--model", "fitted.toml", "table-tilt"]).contains("to other recordings"));
    change("/schema", json!("pushlab.diagnosis/1"));
    assert!(error(&[]).contains("this release reads `pushlab.diagnosis/2`"));
    set.write("d.json", "{\"schema\": \"pushlab.diagnosis/2\"\n\"identified\": []}");
    assert!(error(&[]).contains("d.json:2:1: no JSON: expected `,` or `}`"));
}
