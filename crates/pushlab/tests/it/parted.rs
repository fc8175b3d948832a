//! A set in parts, as several machines ingest it, and what `merge` makes of them.

use std::fs;

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
