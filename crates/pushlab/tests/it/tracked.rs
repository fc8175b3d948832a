//! Pushes that are watched, through the command.

use std::path::Path;

use serde_json::Value;

use crate::documentation::{COMMAND_LINE, copy, keys, page};
use crate::small_set::SmallSet;

const FIXTURE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/pushes");
/// What differs from push to push; how the fixture's pushes differ is measured.
const VARIED: &str = r#"
[[effects]]
id = "friction-center-offset"
[effects.parameters]
dx = { value = 0.0, per_push = { sd = 0.002 } }
dy = { value = 0.0, per_push = { sd = 0.002 } }
[[effects]]
id = "force-bias"
[effects.parameters]
fx = { value = 0.0, per_push = { sd = 0.1 } }
fy = { value = 0.0 }
turn = { value = 0.0 }
"#;

#[test]
fn watched_pushes_end_nearer_to_where_they_were_foreseen() {
    let set = SmallSet::new();
    copy(Path::new(FIXTURE), &set.path("pushes"));
    set.done(&["models", "init", "pushes"]);
    let nothing = set.run(&["track", "pushes", "-o", "out"]);
    assert_eq!(nothing.code, Some(1));
    assert!(nothing.stderr.contains("nothing differs from push to push"), "{}", nothing.stderr);
    assert!(!set.path("out").exists());
    set.write("varied.toml", &(set.read("model.toml") + VARIED));
    let arguments = ["track", "pushes", "--model", "varied.toml", "--films", "1", "--json", "-o"];
    let run = set.done(&[&arguments[..], &["out"]].concat());
    let document: Value = serde_json::from_str(&run.stdout).unwrap();
    let page = page(COMMAND_LINE);
    let mut found = Vec::new();
    keys(&document, &mut found);
    for key in found {
        assert!(page.contains(&format!("`{key}`")), "no `{key}` on the page");
    }
    let pushes = document["pushes"].as_array().unwrap();
    assert_eq!(pushes.len(), 30, "every second push is watched, the others tell");
    assert_eq!(document["others"]["n_pushes"], 30);
    // A step of a short push is more than a third of it.
    assert!(pushes.iter().all(|push| (0.333..1.0).contains(&push["share"].as_f64().unwrap())));
    let error = |which: &str, k: usize| document[which]["rms_error"][k].as_f64().unwrap();
    for k in 0..2 {
        assert!(error("with", k) < 0.9 * error("without", k), "{}", run.stdout);
    }
    let held = &document["with"]["coverage"][2];
    assert!(held["n_within"].as_u64().unwrap() >= 21, "{held}");
    let html = set.read("out/index.html");
    assert!(html.contains("data-film") && !html.contains("https://"));
    let name = pushes[0]["name"].as_str().unwrap().replace('#', "-");
    assert!(set.read(&format!("out/{name}.svg")).starts_with("<svg"));
    // Any number of threads says the same.
    let mut alone = set.command(&[&arguments[..], &["again"]].concat());
    let alone = alone.env("RAYON_NUM_THREADS", "1").output().unwrap();
    assert!(alone.status.success());
    let again = set.read("again/track.json").replace("\"again\"", "\"out\"");
    assert_eq!(again, set.read("out/track.json"));
}
