//! `pushlab run`: all the way from recordings to a report.

use std::path::Path;

use serde_json::Value;

use crate::documentation::{COMMAND_LINE, copy, keys, page};
use crate::small_set::SmallSet;

/// What the fixtures' manifest states of them.
const STATED: [&str; 6] = [
    "object.shape=square",
    "object.side_m=0.09",
    "object.mass_kg=0.8374",
    "pusher.radius_m=0.00475",
    "pusher.friction=0.25",
    "support.friction=0.25",
];
const MADE: [&str; 8] = [
    "steps.csv",
    "model.toml",
    "comparison.json",
    "diagnosis.json",
    "better.toml",
    "comparison-better.json",
    "report.html",
    "calibrated.toml",
];

/// The fixture pushes without what no recording tells.
fn raw() -> SmallSet {
    let set = SmallSet::new();
    copy(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/pushes"), &set.path("raw"));
    std::fs::remove_file(set.path("raw/dataset.toml")).unwrap();
    set
}

fn run<'a>(stated: &[&'a str], more: &[&'a str]) -> Vec<&'a str> {
    let stated = stated.iter().flat_map(|one| ["--set", one]);
    ["run", "raw", "-o", "out"].into_iter().chain(stated).chain(more.iter().copied()).collect()
}

/// What became of each phase.
fn states(document: &Value) -> Vec<&str> {
    let phases = document["phases"].as_array().unwrap().iter();
    phases.map(|phase| phase["state"].as_str().unwrap()).collect()
}

#[test]
fn raw_recordings_go_all_the_way_and_again_where_something_is_gone() {
    let set = raw();
    let first = set.done(&run(&STATED, &[]));
    assert!(first.stdout.contains("limit-surface-shape"), "{}", first.stdout);
    assert!(first.stdout.contains("\nreport   out/report.html\nnext     pushlab "));
    assert!(first.stderr.contains("5 of 9, diagnose\n"), "{}", first.stderr);
    // Each file is what its command makes of the same.
    for (arguments, made) in [
        (&["ingest", "raw", "-o", "again.csv"][..], "steps.csv"),
        (&["models", "init", "raw", "-o", "again.toml"], "model.toml"),
        (&["compare", "raw", "--model", "out/model.toml", "-o", "again.json"], "comparison.json"),
    ] {
        set.done(arguments);
        assert_eq!(set.read(arguments.last().unwrap()), set.read(&format!("out/{made}")), "{made}");
    }
    let made = || MADE.map(|name| set.read(&format!("out/{name}")));
    let before = made();
    let again = |more: &[&str]| -> Value {
        serde_json::from_str(&set.done(&run(&STATED, &[&["--json"], more].concat())).stdout)
            .unwrap()
    };
    assert_eq!(states(&again(&[])), ["unchanged"; 9]);
    for name in ["better.toml", "report.html"] {
        std::fs::remove_file(set.path(&format!("out/{name}"))).unwrap();
    }
    let mut document = again(&[]);
    let [done, unchanged] = ["done", "unchanged"];
    let expected = [[unchanged; 5].as_slice(), &[done, unchanged, done, unchanged]].concat();
    // The better model is the same again, so that nothing is compared again.
    assert_eq!(states(&document), expected);
    assert_eq!(made(), before);
    assert_eq!(document["schema"], "pushlab.run/1");
    assert_eq!(document["verdict"], "identified");
    assert_eq!(document["model"], "out/calibrated.toml");
    // Its keys are those of a diagnosis.
    let error = document["error"].take();
    assert!(error["after"].as_f64().unwrap() < error["before"].as_f64().unwrap(), "{error}");
    let (page, mut found) = (page(COMMAND_LINE), Vec::new());
    keys(&document, &mut found);
    for key in found {
        assert!(page.contains(&format!("`{key}`")), "no `{key}` on the page");
    }
}

#[test]
fn all_that_is_missing_is_named_at_once_and_nothing_is_written() {
    let set = raw();
    let message = set.error(&run(&STATED[2..3], &[]));
    for key in ["object.shape", "pusher.radius_m", "pusher.friction", "support.friction"] {
        assert!(message.contains(&format!("\n  {key} ")), "{key}: {message}");
        assert!(message.contains(&format!(" --set {key}=…")), "{key}: {message}");
    }
    assert!(message.contains("-o out --set object.mass_kg=0.8374 --set object.shape=…"));
    // The outline tells what says how large it is.
    let message = set.error(&run(&["object.shape=rectangle"], &[]));
    assert!(message.contains("\n  object.width_m ") && message.contains("\n  object.height_m "));
    let message =
        set.error(&run(&[&STATED[..1], &["object.side_m=90"], &STATED[2..]].concat(), &[]));
    assert!(message.contains("object.side_m = 90"), "{message}");
    assert!(!set.exists("out") && !set.exists("raw/dataset.toml"));
    set.wrong_usage(&run(&["mass_kg=1"], &[]));
}

#[test]
fn what_cannot_be_written_is_refused_before_anything_is_asked() {
    let set = raw();
    std::fs::create_dir_all(set.path("out/report.html")).unwrap();
    let message = set.error(&run(&[], &[]));
    assert!(message.contains("out/report.html: it is a folder"), "{message}");
    std::fs::remove_dir(set.path("out/report.html")).unwrap();
    set.write("out/model.toml", "name = \"by hand\"\n");
    let message = set.error(&run(&[], &[]));
    assert!(message.contains("out/model.toml: it is there, and not as"), "{message}");
    assert_eq!(set.read("out/model.toml"), "name = \"by hand\"\n");
    let message = set.error(&["run", "raw", "-o", "no/out"]);
    assert!(message.contains("there is no folder no"), "{message}");
    let message = set.error(&["run", "raw", "-o", "raw/pushes/push-000"]);
    assert!(message.contains("cannot write raw/pushes/push-000/"), "{message}");
    assert!(!set.exists("raw/dataset.toml") && !set.exists("out/steps.csv"));
}

#[test]
fn a_run_that_fails_goes_on_from_there() {
    let set = SmallSet::new();
    // Two pushes make no comparison.
    let failed = ["run", "set", "-o", "out"];
    let message = set.error(&failed);
    assert!(message.contains("the same command goes on from here"), "{message}");
    assert!(message.contains("1 of 9, init: set/dataset.toml tells all\n"), "{message}");
    let message = set.error(&failed);
    assert!(message.contains("3 of 9, models init: skipped, out/model.toml"), "{message}");
    assert!(message.contains("4 of 9, compare\n"), "{message}");
    // Of what was made from other recordings all is made again, but not what somebody wrote since.
    set.edit("set/dataset.toml", "friction = 0.25", "friction = 0.2");
    let message = set.error(&failed);
    assert!(message.contains("wrote out/steps.csv"), "{message}");
    set.edit("out/model.toml", "name", "# mine\nname");
    let message = set.error(&failed);
    assert!(message.contains("replace it with --force"), "{message}");
    let message = set.error(&["run", "set", "-o", "out", "--force"]);
    assert!(message.contains("wrote out/model.toml"), "{message}");
    let message = set.error(&["run", "set", "-o", "out", "--set", "object.mass_kg=3"]);
    assert!(message.contains("has object.mass_kg = 0.8"), "{message}");
}
