//! Runs that are killed: what they write is whole or not there, and the next run clears up.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use crate::documentation::copy;
use crate::small_set::SmallSet;

/// Commands, each with what it writes: first what the others belong to.
const COMMANDS: [(&str, &[&str]); 6] = [
    ("ingest pushes -o steps.csv --report report.txt", &["steps.csv", "report.txt"]),
    ("ingest pushes -o steps.parquet", &["steps.parquet"]),
    ("generate -o made --pushes 12 --format csv", &["made", "made.truth.toml"]),
    ("train pushes --kind gp -n 60 -o gp.toml", &["gp.toml"]),
    ("simulate pushes --particles 200 -n 3 -o out", &["out"]),
    ("report pushes -o page.html", &["page.html"]),
];

/// Kills of each command; `PUSHLAB_KILLS` asks for more of them.
fn n_kills() -> u32 {
    std::env::var("PUSHLAB_KILLS").map_or(10, |text| text.parse().unwrap())
}

/// A folder with a few pushes and a model.
pub(crate) fn pushes() -> SmallSet {
    let set = SmallSet::new();
    fs::remove_dir_all(set.path("set")).unwrap();
    let from = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/pushes");
    copy(&from, &set.path("pushes"));
    for push in fs::read_dir(set.path("pushes/pushes")).unwrap().map(Result::unwrap) {
        if push.file_name().to_str().unwrap() >= "push-016" {
            fs::remove_dir_all(push.path()).unwrap();
        }
    }
    let sessions = set.read("pushes/sessions.csv");
    let kept = sessions.lines().take(1 + 16).map(|line| format!("{line}\n"));
    set.write("pushes/sessions.csv", &kept.collect::<String>());
    set.done(&["models", "init", "pushes"]);
    set
}

type Files = BTreeMap<String, Vec<u8>>;

/// Every file of a folder by its name from there on.
fn files(folder: &Path) -> Files {
    fn add(folder: &Path, prefix: &str, found: &mut Files) {
        for entry in fs::read_dir(folder).unwrap().map(Result::unwrap) {
            let name = format!("{prefix}{}", entry.file_name().to_str().unwrap());
            if entry.path().is_dir() {
                found.insert(format!("{name}/"), Vec::new());
                add(&entry.path(), &format!("{name}/"), found);
            } else {
                found.insert(name, fs::read(entry.path()).unwrap());
            }
        }
    }
    let mut found = Files::new();
    add(folder, "", &mut found);
    found
}

fn is_hidden(name: &str) -> bool {
    name.starts_with('.')
}

/// What a run that may have been killed has left: whole outputs, and files under temporary names.
fn assert_whole(set: &SmallSet, (command, outputs): (&str, &[&str]), before: &Files, done: &Files) {
    let left = files(&set.path("."));
    for (name, bytes) in left.iter().filter(|(name, _)| !is_hidden(name)) {
        let expected = done.get(name);
        assert!(expected.is_some(), "{command} left {name}");
        assert!(expected == Some(bytes), "{command} left a part of {name}");
    }
    for (name, bytes) in before {
        assert!(left.get(name) == Some(bytes), "{command} changed {name}");
    }
    // The first output is what others belong to: with it everything is there.
    if Path::exists(&set.path(outputs[0])) {
        let is_its = |name: &str| name.starts_with(outputs[0]) || outputs.len() == 1;
        for name in done.keys().filter(|name| is_its(name)) {
            assert!(left.contains_key(name), "{command} left {} without {name}", outputs[0]);
        }
    }
}

/// Removes whole outputs, and leaves what killed runs may have left.
fn remove_outputs(set: &SmallSet, before: &Files) {
    for entry in fs::read_dir(set.path(".")).unwrap().map(Result::unwrap) {
        let name = entry.file_name().into_string().unwrap();
        let is_input = before.keys().any(|known| known.split('/').next() == Some(&name));
        if is_input || is_hidden(&name) {
            continue;
        }
        let path = entry.path();
        if path.is_dir() { fs::remove_dir_all(path) } else { fs::remove_file(path) }.unwrap();
    }
}

/// Runs one command whole, then as often as asked by `disturb`, then whole again.
fn check(
    set: &SmallSet,
    (line, outputs): (&str, &[&str]),
    n: u32,
    disturb: impl Fn(u32, Duration),
) {
    let words: Vec<_> = line.split(' ').collect();
    let before = files(&set.path("."));
    let start = Instant::now();
    set.done(&words);
    let whole = start.elapsed();
    let done = files(&set.path("."));
    assert!(done.len() > before.len() && done.keys().all(|name| !is_hidden(name)), "{done:?}");
    for round in 0..n {
        remove_outputs(set, &before);
        disturb(round, whole);
        assert_whole(set, (line, outputs), &before, &done);
    }
    remove_outputs(set, &before);
    set.done(&words);
    assert!(files(&set.path(".")) == done, "{line} leaves something behind");
    remove_outputs(set, &before);
}

/// A run of a command that is killed after a time, unless it has ended before.
fn killed(mut command: Command, after: Duration) {
    command.stdout(Stdio::null()).stderr(Stdio::null());
    let mut child = command.spawn().unwrap();
    thread::sleep(after);
    child.kill().unwrap();
    child.wait().unwrap();
}

/// Numbers from 0 to 1 that are evenly spread, whichever part of them is taken.
fn spread(index: u32) -> f64 {
    (f64::from(index + 1) * 0.618_033_988_75).fract()
}

#[test]
fn a_killed_run_leaves_whole_outputs_or_none() {
    let set = pushes();
    for command in COMMANDS {
        let words: Vec<_> = command.0.split(' ').collect();
        check(&set, command, n_kills(), |round, whole| {
            killed(set.command(&words), whole.mul_f64(1.05 * spread(round)));
        });
    }
}

/// The system kills a run that makes a file longer than allowed: in the midst of writing it.
#[cfg(unix)]
#[test]
fn a_run_killed_while_it_writes_leaves_whole_outputs_or_none() {
    let set = pushes();
    for command in COMMANDS {
        check(&set, command, 8, |round, _| {
            let limit = format!("ulimit -f {}; exec \"$@\"", 4_u32.pow(round));
            let words = [env!("CARGO_BIN_EXE_pushlab")].into_iter().chain(command.0.split(' '));
            let mut shell = Command::new("sh");
            shell.args(["-c", &limit, "sh"]).args(words).current_dir(set.path("."));
            shell.stdout(Stdio::null()).stderr(Stdio::null());
            shell.status().unwrap();
        });
    }
}

#[test]
fn a_killed_run_leaves_the_old_model_with_its_weights_or_the_new_one() {
    let set = pushes();
    fn train(seed: &str) -> Vec<&str> {
        let words = ["train", "pushes", "--kind", "gp", "-n", "60", "-o", "m.toml", "--force"];
        [&words[..], &["--seed", seed]].concat()
    }
    let start = Instant::now();
    set.done(&train("1"));
    let whole = start.elapsed();
    for round in 0..n_kills() {
        let words = train(if round % 2 == 0 { "2" } else { "1" });
        killed(set.command(&words), whole.mul_f64(1.05 * spread(round)));
        set.done(&["models", "show", "m.toml", "-q"]);
    }
}
