//! How the tool talks: help, wrong usage, colors, closed pipes.

use std::process::Stdio;

use crate::small_set::{Run, SmallSet};

#[test]
fn help_lists_every_command() {
    let set = SmallSet::new();
    let help = set.done(&["--help"]).stdout;
    let list = help.split("Commands:\n").nth(1).unwrap().split("\n\n").next().unwrap();
    assert_eq!(
        list,
        "  demo         Hide an effect in simulated recordings, find it, add it, and watch the error fall
  run          Go all the way from recordings to a better model, and a report of it
  init         Write a commented dataset.toml from what a folder of recordings holds
  inspect      Tell what raw recordings contain: topics, types, columns, samples, rates, frames
  ingest       Turn recordings into a step table, with a report of every repair [alias: table]
  merge        Put the parts of a set together that were ingested, or summed up, apart
  describe     Tell what a step table holds: rows, shapes, flags, coverage, and what made it
  models       Write, show and list models
  effects      List and explain effects: what models can carry, and what `generate` can hide
  generate     Simulate pushes and write them as a recording set that can hide an effect
  check        Tell what a set can and cannot show, before any model is fitted to it
  compare      Tell how wrong a model is on recordings, where, and how wrong it may be at best
  statistics   Sum up what a part of a set says of a model, for sets too large for one machine
  diagnose     Name the physical effect that a model lacks, or say that these recordings cannot tell
  fit          Fit nominal parameters, or effects that a model carries, to recordings
  add          Add effects to a model: what a diagnosis names, or one with values by hand or fitted
  calibrate    Measure how sure a model may be of whole pushes, and keep it in the model's file
  suggest      Tell which pushes to do next: those that decide between rivals, or measure a name
  train        Train a model on a part of the pushes, alone or on what physics leaves over
  simulate     Roll pushes out by a model: where the object goes, and how sure that is
  track        Watch pushes, and foresee their ends by what their beginnings tell
  report       Show how models do on recordings: one HTML page, to be read without a network
  completions  Print a completion script for a shell
  man          Write a manual page for each command
  help         Print this message or the help of the given subcommand(s)"
    );
    assert!(
        help.ends_with(
            "Exit codes: 0 done, 1 the input or the computation failed, 2 wrong usage.\n"
        )
    );
    let version = set.done(&["--version"]).stdout;
    assert_eq!(version, concat!("pushlab ", env!("CARGO_PKG_VERSION"), "\n"));
}

#[test]
fn wrong_usage_names_what_is_allowed() {
    let set = SmallSet::new();
    for (arguments, part) in [
        (&[][..], "Usage: pushlab"),
        (&["ingset"], "'ingest'"),
        (&["ingest"], "<SET>"),
        (&["ingest", "set", "--step", "200"], "such as 200ms, 0.2s or 4mm"),
        (&["ingest", "set", "--step", "-4mm"], "-0.004 m is not within 0.0001 to 10 m"),
        (&["ingest", "set", "--curve", "straight"], "interpolate, smooth"),
        (&["ingest", "set", "--preset", "mit"], "mit-push, mit-rig-2015, mit-table"),
        (&["ingest", "set", "-o", "steps.xlsx"], ".csv or .parquet"),
        (&["ingest", "set", "--report", "report.pdf"], ".txt or .json"),
        (&["ingest", "set", "--jobs", "0"], "1..=1024"),
        (&["ingest", "set", "--shape", "hex"], "--preset <NAME>"),
        (&["ingest", "set", "--mapping", "m.toml", "--step", "1s"], "cannot be used with"),
        (&["describe", "steps.xlsx"], ".csv or .parquet"),
        (&["--color", "sometimes", "inspect", "set"], "auto, always, never"),
        (&["models", "init"], "<SET>"),
        (&["completions", "cmd"], "bash"),
        (&["effects", "explain", "table-tlit"], "'table-tilt'"),
        (&["simulate", "set"], "--output <DIR>"),
        (&["simulate", "set", "-o", "out", "--particles", "0"], "1..=1000000"),
        (&["track", "set", "-o", "out", "--after", "1"], "a number between 0 and 1"),
        (&["simulate", "p.csv", "-o", "out", "--object", "1,2"], "such as 0,-20,45"),
        (&["generate"], "--output <DIR>"),
        (&["generate", "-o", "new", "--pushes", "0"], "1..=1000000"),
        (&["generate", "-o", "new", "--shape", "rect9"], "rect1, rect2, rect3"),
        (&["generate", "-o", "new", "--format", "xlsx"], "mcap-ros2, mcap-ros1"),
        (
            &["generate", "-o", "new", "--design", "grid"],
            "random, thesis, narrow, repeats or a FILE.csv",
        ),
        (&["generate", "-o", "new", "--speed", "20"], "such as 20mm/s"),
        (&["generate", "-o", "new", "--sessions", "0"], "1..=1000000"),
    ] {
        let message = set.wrong_usage(arguments);
        assert!(message.contains(part), "{arguments:?}: no {part:?} in {message}");
    }
    set.write("list.csv", "edge,p,angle_deg,speed_mm_s\n0,0.5,0,50\n");
    for (option, value) in [("--speed", "20mm/s"), ("--sessions", "2")] {
        let list = ["generate", "-o", "new", "--design", "list.csv", option, value];
        assert!(set.wrong_usage(&list).contains(&format!("leave out {option}")));
    }
    set.write("theirs.csv", "c,phi_rad\n");
    let message =
        set.wrong_usage(&["ingest", "theirs.csv", "--preset", "mit-table", "--step", "1s"]);
    assert!(message.contains("leave out --step"), "{message}");
}

#[test]
fn colors_appear_on_demand_only() {
    let set = SmallSet::new();
    let plain = set.done(&["inspect", "set"]).stdout;
    assert!(!plain.contains('\u{1b}'));
    let colored = set.done(&["inspect", "set", "--color", "always"]).stdout;
    assert!(colored.contains("\u{1b}[1mset/pushes/push-0\u{1b}[0m"), "{colored:?}");
    let mut command = set.command(&["inspect", "set"]);
    let run = Run::of(command.env("NO_COLOR", "1").env("CLICOLOR_FORCE", "1").output().unwrap());
    assert_eq!(run.stdout, plain);
    let failed = set.run(&["--color=always", "inspect", "nowhere"]).stderr;
    assert!(failed.starts_with("\u{1b}[1m\u{1b}[31merror:\u{1b}[0m "), "{failed:?}");
    assert!(set.done(&["--color=always", "--help"]).stdout.contains('\u{1b}'));
}

#[test]
fn a_reader_that_leaves_is_no_failure() {
    let set = SmallSet::new();
    for arguments in [
        &["inspect", "set"][..],
        &["ingest", "set", "--json"],
        &["ingest", "set", "-o", "-"],
        &["--help"],
    ] {
        let mut child =
            set.command(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let run = Run::of(child.wait_with_output().unwrap());
        assert_eq!((run.code, run.stderr.as_str()), (Some(0), ""), "{arguments:?}");
    }
}

#[test]
fn more_is_said_on_demand_and_beside_the_result() {
    let set = SmallSet::new();
    let plain = set.done(&["inspect", "set"]);
    let verbose = set.done(&["inspect", "set", "-v"]);
    assert_eq!((verbose.stdout, plain.stderr), (plain.stdout, String::new()));
    let lines: Vec<_> = verbose.stderr.lines().collect();
    assert!(lines[0].starts_with("read set/pushes/push-0/"), "{lines:?}");
    assert!(lines.last().unwrap().starts_with("done in "), "{lines:?}");
    let message = set.wrong_usage(&["inspect", "set", "-v", "-q"]);
    assert!(message.contains("cannot be used with"), "{message}");
}

#[test]
fn help_is_as_wide_as_the_terminal() {
    let set = SmallSet::new();
    let widest = |columns: &str| {
        let mut command = set.command(&["compare", "--help"]);
        let run = Run::of(command.env("COLUMNS", columns).output().unwrap());
        let (text, _) = run.stdout.split_once("Examples:").unwrap();
        text.lines().map(|line| line.chars().count()).max().unwrap()
    };
    assert!(widest("60") <= 60, "{}", widest("60"));
    assert!((80..=100).contains(&widest("200")), "{}", widest("200"));
}

#[test]
fn seeds_are_as_large_as_files_can_hold() {
    let set = SmallSet::new();
    let largest = i64::MAX.to_string();
    set.done(&["generate", "-n", "1", "--seed", &largest, "-o", "new"]);
    assert!(set.read("new.truth.toml").contains(&largest));
    let message = set.wrong_usage(&["generate", "--seed", "9223372036854775808", "-o", "more"]);
    assert!(message.contains("9223372036854775807"), "{message}");
}

#[test]
fn every_command_has_a_manual_page() {
    let set = SmallSet::new();
    set.done(&["man", "-o", "man"]);
    for name in ["pushlab", "pushlab-compare", "pushlab-models-init", "pushlab-effects-explain"] {
        let page = set.read(&format!("man/{name}.1"));
        assert!(page.contains(".SH SYNOPSIS") && page.contains("\\-\\-json"), "{name}");
    }
}

#[test]
fn completions_know_the_commands() {
    let set = SmallSet::new();
    for shell in ["bash", "zsh", "fish"] {
        let script = set.done(&["completions", shell]).stdout;
        assert!(script.contains("ingest") && script.contains("mit-rig-2015"), "{shell}");
    }
}
