//! `pushlab compare` on the fixture pushes, which hide nothing.

use std::path::Path;

use serde_json::Value;

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
    let result = &document["result"];
    let changes = result["against"]["changes"].as_array().unwrap();
    let names: Vec<_> = changes.iter().map(|change| change["name"].as_str().unwrap()).collect();
    let all = ["dx", "dy", "dtheta", "force_normal", "force_tangential", "gap_start", "gap_end"];
    assert_eq!(names, all);
    let turn = &changes[2];
    let [change, se] = ["square_change", "square_change_se"].map(|key| turn[key].as_f64().unwrap());
    assert!(change > 2.0 * se, "{turn}");
    assert_eq!(result["n_pushes"], 60);
    assert_eq!(document["inputs"].as_array().unwrap().len(), 2 + 2 + 60);
    let text = set.done(&arguments).stdout;
    for part in ["error of a step, RMS", "dtheta", "floor", "worst pushes", "against nominal"] {
        assert!(text.contains(part), "no {part} in {text}");
    }
    let again = set.done(&[&arguments[..], &["--json", "--jobs", "1"]].concat());
    assert_eq!(run.stdout, again.stdout);
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
