//! `pushlab diagnose` on recordings whose truth is known.

use serde_json::{Value, json};

use crate::schema;
use crate::small_set::SmallSet;

/// A set with something hidden in it, or nothing, and the nominal model.
fn generated(hidden: &[&str], more: &[&str]) -> SmallSet {
    let set = SmallSet::new();
    let hidden = hidden.iter().flat_map(|effect| ["--hidden", effect]);
    let words = ["generate", "pushes", "--seed", "11", "--pushes", "72", "--design", "random"];
    let words: Vec<&str> = words.into_iter().chain(hidden).chain(more.iter().copied()).collect();
    set.done(&words);
    set.done(&["models", "init", "pushes"]);
    set
}

fn diagnosed(set: &SmallSet) -> Value {
    let run = set.done(&["diagnose", "pushes", "-o", "diagnosis.json", "--json"]);
    let found: Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(schema::fault(&found, &schema::diagnosis()), None);
    assert_eq!(serde_json::from_str::<Value>(&set.read("diagnosis.json")).unwrap(), found);
    found
}

fn effect<'a>(found: &'a Value, id: &str) -> &'a Value {
    found["effects"].as_array().unwrap().iter().find(|effect| effect["id"] == id).unwrap()
}

#[test]
fn a_hidden_effect_is_named_with_its_size_and_closes_the_gap() {
    let set = generated(&["table-anisotropy: ratio=1.3, direction_deg=34"], &[]);
    let found = diagnosed(&set);
    assert_eq!(found["verdict"], "named", "{}", found["sentence"]);
    let named: Vec<&str> =
        found["named"].as_array().unwrap().iter().map(|id| id.as_str().unwrap()).collect();
    assert_eq!(named, ["table-anisotropy", "limit-surface-shape"]);
    let anisotropy = effect(&found, "table-anisotropy");
    assert_eq!(anisotropy["status"], "present");
    for (index, truth) in [(0, 1.3), (1, 34_f64.to_radians())] {
        let parameter = &anisotropy["parameters"][index];
        let [low, high] = ["low95", "high95"].map(|end| parameter[end].as_f64().unwrap());
        // The simulator's push is not the model's to better than one percent.
        let tolerance = 0.01 * truth;
        assert!(low - tolerance < truth && truth < high + tolerance, "{parameter}");
        assert!(high - low < 0.1 * truth, "{parameter}");
    }
    let error = &found["error"];
    let [before, after] = ["before", "after"].map(|key| error[key].as_f64().unwrap());
    assert!(before > 3.0 && after < 1.5, "{error}");
    assert!(error["gap_closed"].as_f64().unwrap() > 0.85, "{error}");
    // The same question gives the same bytes.
    let first = set.read("diagnosis.json");
    diagnosed(&set);
    assert_eq!(set.read("diagnosis.json"), first);
}

#[test]
fn nothing_is_named_where_nothing_is_missing() {
    let set = generated(&[], &[]);
    set.done(&["add", "limit-surface-shape", "--set", "lambda=1", "-o", "patch.toml"]);
    let run = set.done(&["diagnose", "pushes", "--model", "patch.toml", "--json"]);
    let found: Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!((&found["named"], &found["one_of"]), (&json!([]), &json!([])));
    let verdict = found["verdict"].as_str().unwrap();
    assert!(["none_found", "weak"].contains(&verdict), "{}", found["sentence"]);
    let after = found["error"]["after"].as_f64().unwrap();
    assert!((0.7..1.4).contains(&after), "{after}");
    assert!(effect(&found, "table-anisotropy")["status"] != "present");
}

#[test]
fn what_a_diagnosis_cannot_start_from_is_told() {
    let set = SmallSet::new();
    let message = set.error(&["diagnose", "set"]);
    assert!(message.contains("model.toml") && message.contains("models init"), "{message}");
    set.done(&["models", "init", "set"]);
    let message = set.error(&["diagnose", "set"]);
    assert!(message.contains("pushes"), "{message}");
}

#[test]
fn a_second_set_confirms_what_is_fitted_to_all_of_the_first() {
    let set = SmallSet::new();
    let hidden = "table-anisotropy: ratio=1.3, direction_deg=34";
    for (name, seed, pushes) in [("one", "11", "48"), ("two", "12", "16")] {
        set.done(&["generate", name, "--hidden", hidden, "--seed", seed, "--pushes", pushes]);
    }
    set.done(&["models", "init", "one"]);
    set.done(&["add", "limit-surface-shape", "--set", "lambda=1", "-o", "patch.toml"]);
    let words = ["diagnose", "one", "--model", "patch.toml", "--confirm"];
    let run = set.done(&[&words[..], &["two", "-o", "d.json", "--json"]].concat());
    let found: Value = serde_json::from_str(&run.stdout).unwrap();
    assert_eq!(schema::fault(&found, &schema::diagnosis()), None);
    assert_eq!(found["named"], json!(["table-anisotropy"]), "{}", found["sentence"]);
    let split = &found["split"];
    let n = |part: &str| split[part].as_array().unwrap().len();
    assert_eq!((n("fit"), n("confirm"), &found["data"]["pushes_used"]), (48, 16, &json!(64)));
    assert!(split["confirm_set"] != split["set"]);
    set.done(&["add", "--from", "d.json", "--model", "patch.toml", "-o", "better.toml"]);
    let against = ["--model", "better.toml", "--against", "patch.toml", "--json"];
    let compared = set.done(&[&["compare", "two"], &against[..]].concat());
    let compared: Value = serde_json::from_str(&compared.stdout).unwrap();
    assert_eq!(compared["result"]["n_pushes"], 16);
    let turn = &compared["result"]["against"]["changes"][2];
    let [before, after] = ["before", "after"].map(|key| turn[key].as_f64().unwrap());
    assert!(after < 0.5 * before, "{turn}");
    // No push of the first set is unseen, none may be in both, and the rig has to be the same.
    assert!(set.error(&[&["compare", "one"], &against[..]].concat()).contains("no fit has seen"));
    assert!(set.error(&["diagnose", "one", "--model", "better.toml"]).contains("--confirm"));
    let refused = |second: &str| set.error(&[&words[..], &[second]].concat());
    assert!(refused("one").contains("is in one, too"));
    set.done(&["generate", "other", "--shape", "tri1", "--pushes", "8"]);
    assert!(refused("other").contains("its object has another outline"));
}
