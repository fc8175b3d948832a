//! `pushlab demo`.

use serde_json::Value;

use crate::small_set::SmallSet;

#[test]
fn the_demo_names_what_was_hidden_and_leaves_a_report() {
    let set = SmallSet::new();
    let demo = ["demo", "-o", "story", "--seed", "3", "--pushes", "48", "--hidden"];
    let run = set.done(&[&demo[..], &["friction-center-offset"]].concat());
    let commands = run.stdout.lines().filter(|line| line.starts_with("$ pushlab"));
    assert_eq!(commands.count(), 7, "{}", run.stdout);
    let (before, truth) = run.stdout.split_once("The truth, sealed until now: ").unwrap();
    let words = before.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(words.contains("offset of the center of friction"), "{before}");
    assert!(truth.starts_with("friction-center-offset: x = "), "{truth}");
    for name in ["model.toml", "diagnosis.json", "better.toml", "report.html"] {
        assert!(set.exists(&format!("story/{name}")), "{name}");
    }
    assert!(set.error(&demo[..5]).contains("story: the folder is not empty"));
    // The same question gives the same answer, on one thread as on all.
    let ask = ["diagnose", "story/pushes", "--model", "story/model.toml", "-o", "again.json"];
    set.done(&[&ask[..], &["--jobs", "1"]].concat());
    let [first, again] = ["story/diagnosis.json", "again.json"].map(|name| {
        let mut answer: Value = serde_json::from_str(&set.read(name)).unwrap();
        answer["made_by"].take();
        answer["next"].take();
        answer
    });
    assert_eq!(first, again);
}

#[test]
fn the_demo_answers_programs_alone() {
    let set = SmallSet::new();
    let demo = ["demo", "-o", "story", "--seed", "7", "--pushes", "48", "--hidden", "table-tilt"];
    let run = set.done(&[&demo[..], &["--json"]].concat());
    let found: Value = serde_json::from_str(&run.stdout).unwrap();
    let found = &found;
    assert_eq!(found["hidden"][0]["id"], "table-tilt");
    let named = found["identified"].as_array().unwrap();
    assert!(named.contains(&"table-tilt".into()), "{found}");
    assert_eq!(run.stderr.lines().filter(|line| line.contains("error")).count(), 0);
}
