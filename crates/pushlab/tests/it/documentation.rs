//! The pages show what the tool prints, and name what its results hold.

use std::fs;
use std::path::Path;

use dataset::{Column, Flags, columns};
use serde_json::Value;

use crate::small_set::SmallSet;

const PROJECT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

pub(crate) const COMMAND_LINE: &str = "command-line.md";
const TUTORIAL: &str = "tutorial-recordings.md";
const COMPARISON: &str = "tutorial-compare.md";

pub(crate) fn page(name: &str) -> String {
    fs::read_to_string(Path::new(PROJECT).join("docs").join(name)).unwrap()
}

pub(crate) fn copy(from: &Path, to: &Path) {
    if from.is_dir() {
        fs::create_dir_all(to).unwrap();
        for entry in fs::read_dir(from).unwrap() {
            let name = entry.unwrap().file_name();
            copy(&from.join(&name), &to.join(&name));
        }
    } else {
        fs::copy(from, to).unwrap();
    }
}

/// The page with the output of each `$ pushlab` line in place of what stands below it.
///
/// What stands below a `$ cat FILE` is written to that file: so the user edited it.
fn with_true_output(page: &str, set: &SmallSet) -> String {
    let (mut text, mut in_session) = (String::new(), false);
    let mut edited: Option<(&str, String)> = None;
    for line in page.lines() {
        let ends = in_session && line == "```";
        in_session = line == "```console" || (in_session && !ends);
        let command = line.strip_prefix("$ pushlab ").filter(|_| in_session);
        if (ends || line.starts_with("$ "))
            && let Some((name, content)) = edited.take()
        {
            set.write(name, &content);
        }
        if let Some((_, content)) = &mut edited {
            *content += &format!("{line}\n");
        }
        let is_kept = !in_session || line == "```console" || line.starts_with("$ ");
        if is_kept || edited.is_some() {
            text += &format!("{line}\n");
        }
        if let Some(name) = line.strip_prefix("$ cat ").filter(|_| in_session) {
            edited = Some((name, String::new()));
        }
        if let Some(command) = command {
            let run = set.run(&words(command));
            text += if run.code == Some(0) { &run.stdout } else { &run.stderr };
        }
    }
    text
}

/// The words of a command; those within single quotes belong together.
fn words(command: &str) -> Vec<&str> {
    let parts = command.split('\'').enumerate();
    let words = parts.flat_map(|(index, part)| {
        let is_quoted = index % 2 == 1;
        let separator = if is_quoted { '\'' } else { ' ' };
        part.split(separator).filter(move |word| is_quoted || !word.is_empty())
    });
    words.collect()
}

#[test]
fn the_sessions_on_the_pages_are_what_the_tool_prints() {
    for name in [COMMAND_LINE, TUTORIAL, COMPARISON] {
        let set = SmallSet::new();
        for fixture in ["pushes", "formats/mcap-ros2"] {
            copy(&Path::new(PROJECT).join("fixtures").join(fixture), &set.path(fixture));
        }
        let page = page(name);
        let printed = with_true_output(&page, &set);
        if page != printed {
            let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
            fs::write(&path, &printed).unwrap();
            let differ =
                page.lines().zip(printed.lines()).find(|(shown, printed)| shown != printed);
            panic!("{differ:?}; {name} as it should be: {}", path.display());
        }
    }
}

#[test]
fn every_column_and_flag_is_on_the_page() {
    let page = page(TUTORIAL);
    for Column { name, unit, meaning, .. } in columns() {
        let row = format!("| `{name}` | {unit} | {meaning} |\n");
        assert!(page.contains(&row), "no line {row}");
    }
    for (_, flag) in Flags::ALL {
        assert!(page.contains(&format!("`{flag}`")), "no `{flag}`");
    }
}

/// Names of the fields; keys of maps by reason, stream, shape or flag are data.
pub(crate) fn keys(value: &Value, found: &mut Vec<String>) {
    const MAPS: [&str; 8] =
        ["excluded", "rates_hz", "repairs", "untared", "phases", "shapes", "flags", "settings"];
    match value {
        Value::Object(fields) => {
            for (key, value) in fields {
                found.push(key.clone());
                if !MAPS.contains(&key.as_str()) {
                    keys(value, found);
                }
            }
        }
        Value::Array(values) => values.iter().for_each(|value| keys(value, found)),
        _ => {}
    }
}

#[test]
fn every_key_of_the_results_is_on_the_page() {
    let set = SmallSet::new();
    set.done(&["ingest", "set", "-o", "steps.csv"]);
    set.done(&["models", "init", "set"]);
    copy(&Path::new(PROJECT).join("fixtures/pushes"), &set.path("pushes"));
    let page = page(COMMAND_LINE);
    for arguments in [
        &["init", "set", "-o", "draft.toml"][..],
        &["inspect", "set"],
        &["ingest", "set"],
        &["describe", "steps.csv"],
        &["models", "show"],
        &["models", "list"],
        &["effects", "list"],
        &["effects", "explain", "table-anisotropy"],
        &["generate", "-o", "simulated", "--pushes", "1"],
        &["compare", "pushes", "--against", "model.toml"],
        &["add", "limit-surface-shape", "--fit", "pushes", "-o", "better.toml"],
        &["train", "pushes", "--kind", "hybrid", "--residual-kind", "rff", "-o", "hybrid.toml"],
        &["models", "show", "hybrid.toml"],
        &["simulate", "pushes", "--particles", "20", "-n", "1", "-o", "rolled"],
        &["report", "pushes"],
    ] {
        let run = set.done(&[arguments, &["--json"]].concat());
        let mut document: Value = serde_json::from_str(&run.stdout).unwrap();
        let name = document["schema"].as_str().unwrap()["pushlab.".len()..].to_owned();
        let words = document["made_by"]["arguments"].as_array().unwrap().iter();
        let words: Vec<_> = words.map(|word| word.as_str().unwrap()).collect();
        let command = name.strip_suffix("/1").unwrap().replace('-', " ");
        assert!(words.join(" ").starts_with(&command), "{arguments:?}: {name}");
        assert!(document["warnings"].is_array(), "{arguments:?}");
        // Recordings of a report and histograms have their keys in the crate's documentation.
        for pointer in ["/report/recordings", "/report/summary/coverage"] {
            if let Some(value) = document.pointer_mut(pointer) {
                value.take();
            }
        }
        if let Some(coverage) = document.pointer_mut("/coverage") {
            coverage.take();
        }
        let mut found = Vec::new();
        keys(&document, &mut found);
        for key in found {
            assert!(page.contains(&format!("`{key}`")), "{arguments:?}: no `{key}` on the page");
        }
    }
}
