//! `cargo xtask test`: every test and doctest of the workspace, and their closing total.

use std::fmt;
use std::io::{self, BufRead, BufReader, Read, Write};
use std::iter;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::{Mutex, mpsc};
use std::thread;

use anyhow::{Context, Result, ensure};
use serde_json::Value;

use crate::cargo::cargo;
use crate::packages::{Target, packages};

/// The task's name and help.
pub(crate) fn task() -> clap::Command {
    clap::Command::new("test")
        .about("Run every test and doctest of the workspace and print their total")
}

/// Runs unit tests as soon as they are compiled and integration tests once everything is, as many at once
/// as there are cores, and prints what each said when it ends; the last line on standard output is
/// `N passed, N failed`.
///
/// # Errors
/// When a test fails, when something does not compile, or when nothing ran.
pub(crate) fn run() -> Result<()> {
    let total = Mutex::new(Total::default());
    let (queue, programs) = mpsc::channel();
    let programs = Mutex::new(programs);
    let next = || programs.lock().expect("no thread panics").recv();
    let work = || -> Result<()> {
        iter::from_fn(|| next().ok())
            .try_for_each(|program: Program| program.run(&total, io::stdout()))
    };
    let ended: Result<()> = thread::scope(|scope| {
        let n_workers = thread::available_parallelism().map_or(1, usize::from);
        let workers: Vec<_> = (0..n_workers).map(|_| scope.spawn(work)).collect();
        let compiled = compile(|program| queue.send(program).context("no thread is left"));
        drop(queue);
        let doctests = compiled.and_then(|()| Program::doctests()?.run(&total, io::stdout()));
        workers
            .into_iter()
            .map(|worker| worker.join().expect("no thread panics"))
            .chain([doctests])
            .collect()
    });
    let total = total.into_inner().expect("no thread panics");
    println!("{total}");
    ended.and_then(|()| judge(&total))
}

/// Compiles the workspace and hands each test program over when it can be run.
fn compile(ready: impl Fn(Program) -> Result<()>) -> Result<()> {
    let arguments = ["test", "--workspace", "--no-run", "--message-format=json-render-diagnostics"];
    let mut compiler =
        cargo(&arguments).stdout(Stdio::piped()).spawn().context("cannot start cargo test")?;
    let messages = compiler.stdout.take().context("cargo test has no standard output")?;
    let last = compiled(BufReader::new(messages), &ready)?;
    let status = compiler.wait().context("cannot wait for cargo test")?;
    ensure!(status.success(), "the tests do not compile: see the messages above");
    last.into_iter().try_for_each(ready)
}

/// Hands unit tests over as cargo tells of them and returns the integration tests: these run programs of
/// their packages, which cargo may compile after them.
fn compiled(messages: impl BufRead, ready: impl Fn(Program) -> Result<()>) -> Result<Vec<Program>> {
    let mut last = Vec::new();
    for line in messages.lines() {
        let line = line.context("cannot read what cargo compiled")?;
        let message: Value = serde_json::from_str(&line)
            .with_context(|| format!("cargo compiled, and told of it with {line:?}"))?;
        match Program::of(&message) {
            Some(program) if Target(&message["target"]).is("test") => last.push(program),
            Some(program) => ready(program)?,
            None => {}
        }
    }
    Ok(last)
}

/// Something that runs tests.
struct Program {
    name: String,
    command: Command,
}

impl Program {
    /// The program that a message of cargo tells of, if it is one with tests.
    fn of(message: &Value) -> Option<Self> {
        let program =
            message["executable"].as_str().filter(|_| message["profile"]["test"] == true)?;
        let package = Path::new(message["manifest_path"].as_str()?).parent()?;
        let source = Target(&message["target"]).root().strip_prefix(package).ok()?;
        let name = format!("{}: {}", package.file_name()?.display(), source.display());
        let mut command = Command::new(program);
        command.current_dir(package).env("CARGO_MANIFEST_DIR", package);
        Some(Self { name, command })
    }

    /// Those of the libraries that have some: cargo would compile the others for them, too. One that other
    /// programs load is there already, and without it others would be compiled again, with fewer features.
    fn doctests() -> Result<Self> {
        let mut command = cargo(&["test", "--workspace", "--doc", "--no-fail-fast"]);
        for package in packages()? {
            let mut targets = package.targets();
            if !targets.any(|target| target.has_doctests() || target.is("cdylib")) {
                command.args(["--exclude", package.name()]);
            }
        }
        Ok(Self { name: "doctests".to_owned(), command })
    }

    /// Runs it to its end, prints its output in one piece and adds it up.
    fn run(mut self, total: &Mutex<Total>, mut out: impl Write) -> Result<()> {
        eprintln!("     Running {}", self.name);
        let (mut reader, writer) = io::pipe()?;
        self.command.stdout(writer.try_clone()?).stderr(writer);
        let mut child =
            self.command.spawn().with_context(|| format!("cannot start {}", self.name))?;
        // Its ends of the pipe would keep it open.
        drop(self.command);
        let mut output = Vec::new();
        reader.read_to_end(&mut output)?;
        let status = child.wait()?;
        let mut total = total.lock().expect("no thread panics");
        writeln!(out, "== {}", self.name)?;
        out.write_all(&output)?;
        total.add(&output);
        if !status.success() {
            total.broken.push(self.name);
        }
        Ok(())
    }
}

/// Sums of the runner's `test result:` lines.
#[derive(Debug, Default, PartialEq)]
struct Total {
    passed: usize,
    failed: usize,
    ignored: usize,
    /// Programs that ended with an error.
    broken: Vec<String>,
}

impl Total {
    fn add(&mut self, output: &[u8]) {
        String::from_utf8_lossy(output).lines().for_each(|line| self.add_line(line));
    }

    fn add_line(&mut self, line: &str) {
        let Some(counts) = line.strip_prefix("test result: ") else { return };
        let words: Vec<_> = counts.split_whitespace().collect();
        for pair in words.windows(2) {
            let Ok(count) = pair[0].parse::<usize>() else { continue };
            match pair[1] {
                "passed;" => self.passed += count,
                "failed;" => self.failed += count,
                "ignored;" => self.ignored += count,
                _ => {}
            }
        }
    }
}

impl fmt::Display for Total {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.ignored > 0 {
            writeln!(formatter, "{} ignored", self.ignored)?;
        }
        write!(formatter, "{} passed, {} failed", self.passed, self.failed)
    }
}

fn judge(total: &Total) -> Result<()> {
    let Total { passed, failed, broken, .. } = total;
    ensure!(broken.is_empty() && *failed == 0, "{failed} failed, in {}", broken.join(", "));
    ensure!(*passed > 0, "no test ran");
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;
    use std::process::Command;
    use std::sync::Mutex;

    use anyhow::Result;
    use proptest::test_runner::{Config, RngSeed};

    use super::{Program, Total, compiled, judge};

    const OUTPUT: &str = "\nrunning 3 tests\ntest a ... ok\n\
        test result: ok. 3 passed; 0 failed; 1 ignored; 0 measured; 0 filtered out; finished in 0.01s\n\
        \ntest result: FAILED. 4 passed; 2 failed; 0 ignored; 0 measured; 9 filtered out\n\
        a test that prints test result: ok. 50 passed; counts for nothing\n";

    #[test]
    fn the_total_sums_the_result_lines_only() {
        let mut total = Total::default();
        total.add(OUTPUT.as_bytes());
        assert_eq!(total, Total { passed: 7, failed: 2, ignored: 1, ..Total::default() });
    }

    #[test]
    fn the_last_line_states_passed_and_failed() {
        let total = Total { passed: 7, failed: 2, ignored: 1, ..Total::default() };
        assert_eq!(total.to_string().lines().last(), Some("7 passed, 2 failed"));
    }

    #[test]
    fn libraries_that_say_so_have_no_doctests() {
        let doctests = Program::doctests().unwrap();
        let words: Vec<_> =
            doctests.command.get_args().map(|word| word.to_string_lossy()).collect();
        let is_left_out = |name: &str| words.windows(2).any(|two| two == ["--exclude", name]);
        assert!(is_left_out("studies") && !is_left_out("pushlab-planar"), "{words:?}");
        assert!(!is_left_out("pushlab-python"), "{words:?}");
    }

    #[test]
    fn integration_tests_wait_for_the_programs_that_they_run() {
        let artifact = |kind: &str, name: &str, is_test: bool| {
            serde_json::json!({
                "reason": "compiler-artifact",
                "package_id": "path+file:///w/a#0.1.0",
                "manifest_path": "/w/a/Cargo.toml",
                "target": {
                    "kind": [kind], "crate_types": ["bin"], "name": name, "edition": "2024",
                    "src_path": format!("/w/a/{name}.rs"),
                    "doctest": false, "doc": false, "test": true,
                },
                "profile": {
                    "opt_level": "1", "debuginfo": 0, "debug_assertions": true,
                    "overflow_checks": true, "test": is_test,
                },
                "features": [], "filenames": [], "executable": format!("/w/target/{name}"),
                "fresh": false,
            })
        };
        let of_cargo = [
            artifact("test", "it", true),
            artifact("lib", "lib", true),
            artifact("bin", "main", false),
            artifact("bin", "main", true),
        ];
        let messages = of_cargo.map(|line| format!("{line}\n")).concat();
        let first = RefCell::new(Vec::new());
        let ready = |program: Program| -> Result<()> {
            first.borrow_mut().push(program.name);
            Ok(())
        };
        let last = compiled(messages.as_bytes(), ready).unwrap();
        assert_eq!(first.into_inner(), ["a: lib.rs", "a: main.rs"]);
        assert_eq!(last.into_iter().map(|it| it.name).collect::<Vec<_>>(), ["a: it.rs"]);
    }

    #[test]
    fn a_program_is_told_in_one_piece_and_counted() {
        let total = Mutex::new(Total::default());
        let run = |script: &str| {
            let mut command = Command::new("sh");
            command.args(["-c", script]);
            let mut out = Vec::new();
            Program { name: "a: src/lib.rs".to_owned(), command }.run(&total, &mut out).unwrap();
            String::from_utf8(out).unwrap()
        };
        let told = run("echo 'test result: ok. 3 passed; 0 failed;'; echo why >&2");
        assert_eq!(told, "== a: src/lib.rs\ntest result: ok. 3 passed; 0 failed;\nwhy\n");
        assert!(judge(&total.lock().unwrap()).is_ok());
        run("echo 'test result: FAILED. 1 passed; 2 failed;'; exit 101");
        let total = total.into_inner().unwrap();
        assert_eq!((total.passed, total.failed), (4, 2));
        assert_eq!(judge(&total).unwrap_err().to_string(), "2 failed, in a: src/lib.rs");
    }

    /// One that is killed prints no result.
    #[test]
    fn only_a_run_with_passing_tests_and_no_failure_succeeds() {
        let killed =
            Total { passed: 1, broken: vec!["a: src/lib.rs".to_owned()], ..Total::default() };
        assert_eq!(judge(&killed).unwrap_err().to_string(), "0 failed, in a: src/lib.rs");
        assert_eq!(judge(&Total::default()).unwrap_err().to_string(), "no test ran");
    }

    /// As `.cargo/config.toml` says.
    #[test]
    fn laws_of_random_inputs_meet_the_same_inputs_on_every_run() {
        let config = Config::default();
        assert_eq!(config.rng_seed, RngSeed::Fixed(7));
        assert!(config.failure_persistence.is_none());
    }
}
