//! What commands write: nothing that exists is replaced unasked, no input is replaced at all, and
//! what cannot be written is told before the work.

use std::collections::BTreeSet;
use std::fs;

use crate::diagnosed::diagnosed;
use crate::killed::pushes;
use crate::small_set::{Run, SmallSet};

/// A command that writes a file to the place of OUT.
struct Writes {
    words: &'static str,
    ending: &'static str,
    /// What it reads, or would take for a part of that.
    inputs: &'static [&'static str],
}

/// Every command with an output file that has a name of its own.
const FILES: [Writes; 15] = [
    Writes {
        words: "models init pushes -o OUT",
        ending: "toml",
        inputs: &["pushes/dataset.toml", "pushes/pushes/new.toml"],
    },
    Writes {
        words: "ingest pushes -o OUT",
        ending: "csv",
        inputs: &["pushes/sessions.csv", ROBOT, "pushes/pushes/new.csv"],
    },
    Writes { words: "ingest pushes --report OUT", ending: "json", inputs: &[INSIDE] },
    Writes {
        words: "ingest theirs.csv --mapping mapping.toml -o OUT",
        ending: "csv",
        inputs: &["theirs.csv"],
    },
    Writes { words: "compare pushes -o OUT", ending: "json", inputs: &[INSIDE] },
    Writes { words: "diagnose pushes -o OUT", ending: "json", inputs: &[INSIDE] },
    Writes { words: "diagnose pushes --confirm other -o OUT", ending: "json", inputs: &[OTHER] },
    Writes { words: "fit pushes --free pusher-friction -o OUT", ending: "toml", inputs: MODELS },
    Writes { words: "add inertia --set kappa=1 -o OUT", ending: "toml", inputs: &["model.toml"] },
    Writes { words: "add --from d.json -o OUT", ending: "toml", inputs: &["model.toml"] },
    Writes { words: "add table-tilt --fit pushes -o OUT", ending: "toml", inputs: MODELS },
    Writes {
        words: "suggest pushes --from d.json --model model.toml -o OUT",
        ending: "csv",
        inputs: &["pushes/sessions.csv", ROBOT],
    },
    Writes { words: "train pushes --kind hybrid -o OUT", ending: "toml", inputs: MODELS },
    Writes {
        words: "train table/steps.csv --kind gp -o OUT",
        ending: "toml",
        inputs: &["table/dataset.toml"],
    },
    Writes {
        words: "report pushes --from d.json -o OUT",
        ending: "html",
        inputs: &["pushes/pushes/push-000/page.html"],
    },
];

const MODELS: &[&str] = &["model.toml", "pushes/dataset.toml"];
const ROBOT: &str = "pushes/pushes/push-000/robot.csv";
const INSIDE: &str = "pushes/pushes/push-000/answer.json";
const OTHER: &str = "other/pushes/push-000/answer.json";

/// Commands that write a folder.
const FOLDERS: [&str; 3] =
    ["simulate pushes -o OUT", "generate -o OUT --shape pushes/dataset.toml", "demo -o OUT"];

fn words<'a>(command: &'a str, out: &'a str) -> Vec<&'a str> {
    command.split(' ').map(|word| if word == "OUT" { out } else { word }).collect()
}

/// Files for every command, and recordings on which no work can succeed: what is refused is refused
/// before it.
fn unworkable() -> SmallSet {
    let (set, _) = diagnosed();
    crate::documentation::copy(&set.path("pushes"), &set.path("other"));
    set.done(&["ingest", "pushes", "-o", "steps.csv"]);
    fs::create_dir(set.path("table")).unwrap();
    fs::copy(set.path("pushes/dataset.toml"), set.path("table/dataset.toml")).unwrap();
    fs::rename(set.path("steps.csv"), set.path("table/steps.csv")).unwrap();
    set.write("theirs.csv", "a,b\n1,2\n");
    let mapping = set.done(&["init", ".", "--preset", "mit-table", "-o", "-"]).stdout;
    set.write("mapping.toml", &mapping);
    for recordings in ["pushes/pushes", "other/pushes"] {
        for push in fs::read_dir(set.path(recordings)).unwrap() {
            fs::write(push.unwrap().path().join("robot.csv"), "no recording").unwrap();
        }
    }
    set
}

fn names(set: &SmallSet) -> BTreeSet<String> {
    let entries = fs::read_dir(set.path(".")).unwrap();
    entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}

fn assert_refused(set: &SmallSet, arguments: &[&str], says: &str) {
    let before = names(set);
    let message = set.error(arguments);
    assert!(message.contains(says), "{arguments:?}: {message}");
    assert_eq!(names(set), before, "{arguments:?}");
}

#[test]
fn what_is_there_is_replaced_only_by_force() {
    let set = unworkable();
    for Writes { words: command, ending, .. } in FILES {
        let there = format!("there.{ending}");
        set.write(&there, "mine");
        let says = format!("{there}: it exists; name another file, or replace it with --force");
        assert_refused(&set, &words(command, &there), &says);
        assert_eq!(set.read(&there), "mine", "{command}");
    }
    assert_refused(&set, &["init", "pushes"], "dataset.toml: it exists");
    fs::create_dir(set.path("full")).unwrap();
    set.write("full/note", "mine");
    for command in FOLDERS {
        assert_refused(&set, &words(command, "full"), "full: the folder is not empty");
        assert_eq!(set.read("full/note"), "mine", "{command}");
    }
}

#[test]
fn inputs_are_not_replaced_even_by_force() {
    let set = unworkable();
    for Writes { words: command, inputs, ending } in FILES {
        for &input in inputs {
            let bytes = fs::read(set.path(input)).ok();
            let forced = [&words(command, input)[..], &["--force"]].concat();
            assert_refused(&set, &forced, "belongs to the input");
            let dotted = format!("./pushes/../{input}");
            let forced = [&words(command, &dotted)[..], &["--force"]].concat();
            assert_refused(&set, &forced, "belongs to the input");
            assert_eq!(fs::read(set.path(input)).ok(), bytes, "{command}: {input}");
            // To replace one name of a recording's file leaves the recording as it is.
            if bytes.is_none() || input == ROBOT {
                continue;
            }
            let linked = format!("linked.{ending}");
            fs::hard_link(set.path(input), set.path(&linked)).unwrap();
            let forced = [&words(command, &linked)[..], &["--force"]].concat();
            assert_refused(&set, &forced, "belongs to the input");
            fs::remove_file(set.path(&linked)).unwrap();
        }
    }
    for command in &FOLDERS[..1] {
        assert_refused(&set, &words(command, "pushes/pushes/out"), "belongs to the input");
        assert_refused(&set, &words(command, "pushes/pushes/push-000/out"), "belongs to the input");
    }
}

#[cfg(unix)]
#[test]
fn a_link_to_an_input_is_the_input() {
    let set = unworkable();
    std::os::unix::fs::symlink("model.toml", set.path("link.toml")).unwrap();
    let model = set.read("model.toml");
    for command in ["fit pushes --free pusher-friction -o OUT", "add inertia --set kappa=1 -o OUT"]
    {
        let forced = [&words(command, "link.toml")[..], &["--force"]].concat();
        assert_refused(&set, &forced, "link.toml: it belongs to the input model.toml");
    }
    assert_eq!(set.read("model.toml"), model);
}

#[test]
fn an_output_is_not_put_among_recordings_that_it_looks_like() {
    let set = SmallSet::written_by("mit-json");
    for name in ["push-0.json", "push-1.json"] {
        fs::rename(set.path(&format!("set/pushes/{name}")), set.path(&format!("set/{name}")))
            .unwrap();
    }
    set.edit("set/dataset.toml", "path = \"pushes\"", "path = \".\"");
    set.done(&["ingest", "set", "-o", "set/steps.csv", "--report", "report.json"]);
    let report = ["ingest", "set", "--report", "set/report.json"];
    assert_refused(&set, &report, "set/report.json: it would be taken for a recording, as set/");
}

#[test]
fn what_cannot_be_written_is_told_before_the_work() {
    let set = unworkable();
    for Writes { words: command, ending, .. } in FILES {
        let folder = format!("folder.{ending}");
        fs::create_dir_all(set.path(&folder)).unwrap();
        assert_refused(&set, &words(command, &folder), "it is a folder; name a file");
        let nowhere = format!("none/a.{ending}");
        assert_refused(&set, &words(command, &nowhere), "there is no folder none; make it first");
        let below = format!("model.toml/a.{ending}");
        assert_refused(&set, &words(command, &below), "there is no folder model.toml");
        let protected = format!("protected.{ending}");
        set.write(&protected, "mine");
        let mut permissions = fs::metadata(set.path(&protected)).unwrap().permissions();
        permissions.set_readonly(true);
        fs::set_permissions(set.path(&protected), permissions).unwrap();
        let forced = [&words(command, &protected)[..], &["--force"]].concat();
        assert_refused(&set, &forced, "it is read-only");
        if cfg!(target_os = "linux") {
            // Not even the superuser makes files there.
            let nowhere = format!("/proc/a.{ending}");
            assert_refused(&set, &words(command, &nowhere), &format!("cannot write {nowhere}"));
        }
    }
    for command in FOLDERS {
        assert_refused(&set, &words(command, "d.json"), "it is a file; name a new folder");
        assert_refused(&set, &words(command, "none/out"), "there is no folder none; make it first");
        assert_refused(&set, &words(command, "."), "it needs a name");
        if cfg!(target_os = "linux") {
            assert_refused(&set, &words(command, "/proc/out"), "cannot write /proc/out");
        }
    }
}

#[test]
fn no_output_hides_behind_a_word_without_option() {
    let set = unworkable();
    set.write("results.json", "mine");
    let message = set.wrong_usage(&["diagnose", "pushes", "results.json"]);
    assert!(message.contains("unexpected argument 'results.json'"), "{message}");
    let message = set.wrong_usage(&["diagnose", "pushes", "--json", "results.json"]);
    assert!(message.contains("unexpected argument 'results.json'"), "{message}");
    assert_eq!(set.read("results.json"), "mine");
}

#[test]
fn by_force_an_output_is_replaced_whole() {
    let set = SmallSet::new();
    set.done(&["ingest", "set", "-o", "first.csv", "--report", "report.txt"]);
    let forced = ["ingest", "set", "-o", "steps.csv", "--report", "report.txt", "--force"];
    set.write("steps.csv", &"mine".repeat(10_000));
    set.done(&forced);
    assert_eq!(set.read("steps.csv"), set.read("first.csv"));
    set.write("set/dataset.toml", "mine");
    set.done(&["init", "set", "--force"]);
    assert!(set.read("set/dataset.toml").contains("shape = \"TODO\""));
    let names: Vec<_> = names(&set).into_iter().collect();
    assert_eq!(names, ["first.csv", "report.txt", "set", "steps.csv"]);
}

#[test]
fn weights_belong_to_their_model_and_go_with_it() {
    let (set, _) = diagnosed();
    let train = |seed: &str, more: &[&str]| {
        let words = ["train", "pushes", "--kind", "rff", "--seed", seed, "-o", "m.toml"];
        set.done(&[&words[..], more].concat());
    };
    let weights = || -> Vec<String> {
        names(&set).into_iter().filter(|name| name.ends_with(".weights.json")).collect()
    };
    train("1", &[]);
    let first = weights();
    fs::copy(set.path("m.toml"), set.path("copy.toml")).unwrap();
    train("2", &["--force"]);
    assert_eq!(weights().len(), 2, "the copy still needs the first ones");
    set.done(&["models", "show", "copy.toml"]);
    fs::remove_file(set.path("copy.toml")).unwrap();
    train("1", &["--force"]);
    assert_eq!(weights(), first, "nobody needs the second ones");
    set.done(&["models", "show", "m.toml"]);
}

/// Runs a command twice at a time.
fn pair(set: &SmallSet, arguments: &[&str]) -> [Run; 2] {
    let start = || {
        let mut command = set.command(arguments);
        command.stdout(std::process::Stdio::piped()).stderr(std::process::Stdio::piped());
        command.spawn().unwrap()
    };
    [start(), start()].map(|child| Run::of(child.wait_with_output().unwrap()))
}

#[test]
fn of_two_runs_at_a_time_one_wins_and_the_other_says_so() {
    let set = pushes();
    set.done(&["ingest", "pushes", "-o", "once.csv"]);
    let once = set.read("once.csv");
    let lost = ["another run is writing it", "it exists", "the folder is not empty"];
    let assert_one_wins = |arguments: &[&str]| {
        let runs = pair(&set, arguments);
        let codes = runs.each_ref().map(|run| run.code);
        assert!(codes == [Some(0), Some(1)] || codes == [Some(1), Some(0)], "{codes:?}");
        for run in runs.iter().filter(|run| run.code == Some(1)) {
            assert!(lost.iter().any(|says| run.stderr.contains(says)), "{}", run.stderr);
        }
    };
    for round in 0..10 {
        let out = format!("{round}.csv");
        assert_one_wins(&["ingest", "pushes", "-o", &out]);
        assert_eq!(set.read(&out), once);
        for run in pair(&set, &["ingest", "pushes", "-o", "forced.csv", "--force"]) {
            let is_beaten = run.stderr.contains("another run is writing it");
            assert!(run.code == Some(0) || is_beaten, "{}", run.stderr);
        }
        assert_eq!(set.read("forced.csv"), once);
    }
    assert_one_wins(&["models", "init", "pushes", "-o", "m.toml"]);
    assert_one_wins(&["add", "inertia", "--set", "kappa=1", "-o", "better.toml"]);
    assert_one_wins(&["report", "pushes", "-o", "page.html"]);
    assert_one_wins(&["simulate", "pushes", "-n", "2", "--particles", "50", "-o", "out"]);
    assert_one_wins(&["generate", "-o", "made", "--pushes", "2"]);
    let hidden: Vec<_> = names(&set).into_iter().filter(|name| name.starts_with('.')).collect();
    assert!(hidden.is_empty(), "{hidden:?}");
}
