//! `-o -`: an output on standard output, where nothing else is.

use std::collections::BTreeSet;
use std::fs;

use crate::diagnosed::diagnosed;
use crate::small_set::SmallSet;

/// Every kind of output that is one file of text, and how the file ends.
const PRINTED: [(&str, &str); 10] = [
    ("init pushes -o OUT", "toml"),
    ("models init pushes -o OUT", "toml"),
    ("ingest pushes -o OUT", "csv"),
    ("ingest pushes --report OUT", "txt"),
    ("compare pushes -o OUT", "json"),
    ("add inertia --set kappa=1 -o OUT", "toml"),
    ("add --from d.json -o OUT", "toml"),
    ("fit pushes --free pusher-friction -o OUT", "toml"),
    ("suggest pushes --from d.json --model model.toml -n 1 -o OUT", "csv"),
    ("report pushes -o OUT", "html"),
];

fn words<'a>(command: &'a str, out: &'a str) -> Vec<&'a str> {
    command.split(' ').map(|word| if word == "OUT" { out } else { word }).collect()
}

fn names(set: &SmallSet) -> BTreeSet<String> {
    let entries = fs::read_dir(set.path(".")).unwrap();
    entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}

#[test]
fn a_minus_prints_the_bytes_of_the_file_and_nothing_else() {
    let (set, _) = diagnosed();
    for (index, (command, ending)) in PRINTED.into_iter().enumerate() {
        let file = format!("out{index}.{ending}");
        set.done(&words(command, &file));
        let before = names(&set);
        let run = set.done(&words(command, "-"));
        assert!(run.stdout == set.read(&file), "{command}");
        assert!(!run.stderr.contains("wrote"), "{command}: {}", run.stderr);
        assert_eq!(names(&set), before, "{command}");
        let both = set.wrong_usage(&[&words(command, "-")[..], &["--json"]].concat());
        assert!(both.contains("one output alone can be standard output"), "{both}");
    }
    let both = set.wrong_usage(&["ingest", "pushes", "-o", "-", "--report", "-"]);
    assert!(both.contains("one output alone"), "{both}");
}

#[test]
fn what_is_more_than_one_file_of_text_is_not_printed() {
    let set = SmallSet::new();
    for command in ["simulate set -o -", "generate -o -", "demo -o -", "run set -o -", "man -o -"] {
        let message = set.wrong_usage(&words(command, "-"));
        assert!(message.contains("a folder cannot go to standard output"), "{message}");
    }
    let message = set.wrong_usage(&["train", "set", "--kind", "gp", "-o", "-"]);
    assert!(message.contains("expected a file that ends in .toml"), "{message}");
}
