//! A set in parts, as several machines ingest it, and what `merge` makes of them.

use std::fs;

use serde_json::Value;

use crate::small_set::SmallSet;

const PUSHES: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/pushes");

/// The parts of the fixtures' pushes, as files `part-1` and so on.
fn parts(set: &SmallSet, of: usize, ending: &str) -> Vec<String> {
    let part = |number| {
        let (part, table) = (format!("{number}/{of}"), format!("part-{number}.{ending}"));
        set.done(&["ingest", PUSHES, "--step", "4mm", "--part", &part, "-o", &table, "-q"]);
        table
    };
    (1..=of).map(part).collect()
}

#[test]
fn parts_merge_to_the_bytes_of_one_run() {
    for ending in ["csv", "parquet"] {
        let set = SmallSet::new();
        let (whole, merged) = (format!("whole.{ending}"), format!("merged.{ending}"));
        let ingest = ["ingest", PUSHES, "--step", "4mm", "-o", &whole];
        let one = set.done(&[&ingest[..], &["--report", "whole.json"]].concat());
        let mut parts = parts(&set, 4, ending);
        parts.reverse();
        let mut merge = vec!["merge", "-o", &merged, "--report", "merged.json"];
        merge.extend(parts.iter().map(String::as_str));
        let run = set.done(&merge);
        assert_eq!(run.stdout.replace("merged.", "whole."), one.stdout);
        for (one, other) in [(&whole, &merged), (&"whole.json".into(), &"merged.json".into())] {
            let read = |name: &String| fs::read(set.path(name)).unwrap();
            assert!(read(one) == read(other), "{one} and {other} differ");
        }
    }
}

#[test]
fn parts_that_do_not_go_together_are_refused_by_name() {
    let set = SmallSet::new();
    let parts = parts(&set, 2, "csv");
    let [one, two] = [parts[0].as_str(), parts[1].as_str()];
    let says = |arguments: &[&str], text: &str| {
        let message = set.error(arguments);
        assert!(message.contains(text), "{message}");
    };
    says(&["merge", one, "-o", "all.csv"], "part 2/2 is missing: make it by `ingest --part 2/2`");
    says(&["merge", two, two, "-o", "all.csv"], "part 2/2 is given twice");
    says(&["merge", one, two, "-o", one], "cannot write part-1.csv");
    assert!(!set.path("all.csv").exists());
    set.done(&["ingest", "set", "--part", "2/2", "-o", "other.csv", "-q"]);
    says(&["merge", one, "other.csv"], "are not of one ingest: set differs");
    set.edit("part-2.json", "\"sha256\": \"", "\"sha256\": \"0");
    says(&["merge", one, two], "part-2.csv was made otherwise than the other parts");
    set.write("part-2.json", "{}");
    says(&["merge", one, two], "part-2.json is no report of `pushlab ingest --part`");
    fs::remove_file(set.path("part-2.json")).unwrap();
    says(&["merge", one, two], "part-2.csv: its report part-2.json is not beside it");
}

#[test]
fn a_part_has_a_table_of_its_own_with_its_report_beside_it() {
    let set = SmallSet::new();
    for (arguments, text) in [
        (&["--part", "3/2", "-o", "a.csv"][..], "`3/2` is no part"),
        (&["--part", "1/2"], "--output"),
        (&["--part", "1/2", "-o", "-"], "name it by -o"),
        (&["--part", "1/2", "-o", "a.csv", "--report", "b.json"], "leave out --report"),
    ] {
        let message = set.wrong_usage(&[&["ingest", "set"], arguments].concat());
        assert!(message.contains(text), "{message}");
    }
}

/// A round of a fit over the parts of the fixtures' pushes, in files `1.json` and so on.
fn summed_up(set: &SmallSet, of: usize, round: &str) -> Vec<String> {
    let part = |number| {
        let (part, file) = (format!("{number}/{of}"), format!("{number}.json"));
        let options = ["--part", &part, "-o", &file, "--force", "-q"];
        set.done(&[&["statistics", PUSHES, "--round", round], &options[..]].concat());
        file
    };
    (1..=of).map(part).collect()
}

fn merged(set: &SmallSet, parts: &[String], options: &[&str]) -> Value {
    let parts: Vec<&str> = parts.iter().map(String::as_str).collect();
    serde_json::from_str(&set.done(&[&["merge", "--json"], options, &parts[..]].concat()).stdout)
        .unwrap()
}

#[test]
fn a_round_over_parts_tells_what_a_comparison_of_the_whole_does() {
    let set = SmallSet::new();
    set.done(&["models", "init", PUSHES, "-o", "pushes.toml"]);
    let free = ["--model", "pushes.toml", "--free", "pusher-friction"];
    let begin = ["statistics", PUSHES, "--part", "1/3", "-o", "round-0.json", "-q"];
    set.done(&[&begin[..], &free].concat());
    let parts = summed_up(&set, 3, "round-0.json");
    let one = merged(&set, &parts, &["-o", "round-1.json"]);
    // A place that is not the sample's.
    let mut parts = summed_up(&set, 3, "round-1.json");
    let found = merged(&set, &parts, &["--fitted", "fitted.toml"]);
    parts.reverse();
    let again = merged(&set, &parts, &[]);
    for key in ["errors", "fit", "round"] {
        assert_eq!(found[key], again[key], "{key}");
        assert_ne!(found[key], one[key], "{key}");
    }
    assert_eq!(found["fit"]["rounds"], 2);
    let compared = set.done(&["compare", PUSHES, "--model", "fitted.toml", "--json"]).stdout;
    let compared: Value = serde_json::from_str(&compared).unwrap();
    assert_eq!(compared["n_steps"], found["errors"]["n_steps"]);
    let channels = |found: &Value| found["channels"].as_array().unwrap().clone();
    for (one, other) in channels(&compared).iter().zip(&channels(&found["errors"])) {
        for key in ["rms", "rms_se", "bias", "bias_se"] {
            let [one, other] = [one, other].map(|of| of[key].as_f64().unwrap());
            assert!((one - other).abs() <= 1e-9 * one.abs(), "{key}: {one} {other}");
        }
    }
}

#[test]
fn statistics_that_do_not_go_together_are_refused_by_name() {
    let set = SmallSet::new();
    set.done(&["models", "init", PUSHES, "-o", "one.toml"]);
    set.write("two.toml", &(set.read("one.toml") + "\n"));
    for (model, free, file) in [
        ("one.toml", None, "a.json"),
        ("two.toml", None, "b.json"),
        ("one.toml", Some("pusher-friction"), "c.json"),
    ] {
        let free: Vec<&str> = free.into_iter().flat_map(|free| ["--free", free]).collect();
        let begin = ["statistics", PUSHES, "--model", model, "--part", "1/2", "-o", file, "-q"];
        set.done(&[&begin[..], &free].concat());
    }
    for (round, part, file) in [
        ("a.json", "1/2", "a1.json"),
        ("a.json", "2/2", "a2.json"),
        ("a.json", "1/4", "a4.json"),
        ("b.json", "2/2", "b2.json"),
        ("c.json", "2/2", "c2.json"),
    ] {
        set.done(&["statistics", PUSHES, "--round", round, "--part", part, "-o", file, "-q"]);
    }
    let says = |files: &[&str], text: &str| {
        let message = set.error(&[&["merge"], files].concat());
        assert!(message.contains(text), "{message}");
    };
    says(&["a1.json"], "part 2/2 is missing: make it by `statistics --part 2/2`, and name it too");
    says(&["a1.json", "a2.json", "a1.json"], "part 1/2 is given twice");
    says(&["a1.json", "a4.json"], "a4.json does not go with a1.json: the number of parts differs");
    says(&["a1.json", "b2.json"], "b2.json does not go with a1.json: the model differs");
    says(&["a1.json", "c2.json"], "c2.json does not go with a1.json: the place of the fit differs");
    says(&["a1.json", "a.json"], "a.json is not the statistics of a part");
    says(&["a1.json", "a2.json", "--fitted", "f.toml"], "leave out --fitted");
    set.edit("one.toml", "schema", "# other\nschema");
    let message =
        set.error(&["statistics", PUSHES, "--round", "a.json", "--part", "1/2", "-o", "x.json"]);
    assert!(
        message.contains("one.toml is not the model that these statistics began with"),
        "{message}"
    );
    for (arguments, text) in [
        (
            &["statistics", PUSHES, "--round", "a.json", "-o", "x.json"][..],
            "give --part, 1/1 for the whole",
        ),
        (&["merge", "a1.json", "t.csv"], "tables and statistics do not go together"),
        (&["merge", "a1.json", "-o", "t.csv"], "statistics what they say (.json)"),
        (&["merge", "t.csv", "--fitted", "f.toml"], "--fitted is for statistics with a fit"),
        (&["merge", "a1.json", "--report", "r.txt"], "--report is for tables"),
    ] {
        let message = set.wrong_usage(arguments);
        assert!(message.contains(text), "{message}");
    }
}
