//! `pushlab check` on a design that can tell much and on one that cannot.

use serde_json::Value;

use crate::small_set::SmallSet;

fn checked(design: &str) -> (Value, String) {
    let set = SmallSet::new();
    let arguments =
        ["generate", "-o", "made", "--pushes", "40", "--design", design, "--format", "csv"];
    set.done(&arguments);
    let run = set.done(&["check", "made", "--json"]);
    let document: Value = serde_json::from_str(&run.stdout).unwrap();
    (document.clone(), set.done(&["check", "made"]).stdout)
}

fn pairs(result: &Value) -> Vec<(String, String)> {
    let pair = |pair: &Value| {
        let id = |key: &str| pair[key].as_str().unwrap().to_owned();
        (id("one"), id("other"))
    };
    result["look_alikes"].as_array().unwrap().iter().map(pair).collect()
}

#[test]
fn a_narrow_design_leaves_effects_that_a_random_one_tells_apart() {
    let ((narrow, text), (random, _)) = (checked("narrow"), checked("random"));
    let pair = ("friction-center-offset".to_owned(), "pose-offset".to_owned());
    assert!(pairs(&narrow).contains(&pair), "{:?}", pairs(&narrow));
    assert!(!pairs(&random).contains(&pair), "{:?}", pairs(&random));
    for part in ["what cannot be told apart well", "repeats:", "channels: motion, contact force"] {
        assert!(text.contains(part), "no {part} in {text}");
    }
    for result in [&narrow, &random] {
        let effects = result["effects"].as_array().unwrap();
        assert_eq!(effects.len(), effects::tested().len());
        for effect in effects {
            let is_testable = effect["not_testable"].is_null();
            assert_eq!(is_testable, !effect["coordinates"].as_array().unwrap().is_empty());
        }
    }
}
