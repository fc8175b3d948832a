//! The fuzzing task as a program: it finds every kind of failure, and kept inputs stay mended.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

fn fuzzing(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_fuzzing")).arg("fuzz").args(arguments).output().unwrap()
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

#[test]
fn every_kept_input_is_read_or_refused() {
    let kept = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fixtures/fuzz");
    let output = fuzzing(&["--replay", "--keep", kept.to_str().unwrap()]);
    assert!(output.status.success(), "{}", text(&output));
}

/// The reader of the self-test fails in the way that a letter of its input says.
#[test]
fn panics_crashes_hangs_memory_and_forbidden_values_are_found_and_made_small() {
    let kept = tempfile::tempdir().unwrap();
    let keep = kept.path().to_str().unwrap();
    let output =
        fuzzing(&["--reader", "self-test", "--cases", "600", "--time-limit", "1", "--keep", keep]);
    let said = text(&output);
    assert_eq!(output.status.code(), Some(1), "{said}");
    for kind in ["panic: ", "crash: ", "hang: ", "wrong: number is NaN", "memory allocation of"] {
        assert!(said.contains(kind), "{kind}: {said}");
    }
    assert!(said.contains("attempt to subtract with overflow"), "{said}");
    let inputs = fs::read_dir(kept.path().join("self-test")).unwrap();
    let mut small: Vec<_> = inputs.map(|file| fs::read(file.unwrap().path()).unwrap()).collect();
    small.sort();
    assert_eq!(small, [b"A", b"L", b"M", b"O", b"P", b"W"]);
}

#[test]
fn kept_inputs_that_fail_are_named_with_what_went_wrong() {
    let kept = tempfile::tempdir().unwrap();
    let folder = kept.path().join("self-test");
    fs::create_dir(&folder).unwrap();
    for (input, says) in [("P", "panic"), ("A", "crash"), ("M", "memory"), ("W", "wrong")] {
        fs::write(folder.join("input"), input).unwrap();
        let keep = kept.path().to_str().unwrap();
        let output = fuzzing(&["--replay", "--reader", "self-test", "--keep", keep]);
        let said = text(&output);
        assert!(!output.status.success() && said.contains(says), "{input}: {said}");
    }
    fs::write(folder.join("input"), "nothing").unwrap();
    let keep = kept.path().to_str().unwrap();
    assert!(fuzzing(&["--replay", "--reader", "self-test", "--keep", keep]).status.success());
}

#[test]
fn a_case_is_the_same_on_every_run() {
    let one = |case: &str| {
        let arguments = ["--reader", "table-csv", "--seed", "7", "--case", case];
        let output = fuzzing(&arguments);
        assert!(output.status.success(), "{}", text(&output));
        text(&output)
    };
    assert_eq!(one("12"), one("12"));
    assert_ne!(one("12"), one("13"));
}
