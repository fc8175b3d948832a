//! Tasks in crates of their own, which are compiled when one of them is started.

use std::env;
use std::ffi::{OsStr, OsString};
use std::process::{Command, ExitCode};

use anyhow::{Context, Result};

use crate::cargo::{cargo, line, run, workspace_root};

/// A task, the crate whose program does it, and what it does.
pub(crate) struct Starter {
    task: &'static str,
    package: &'static str,
    about: &'static str,
}

const STARTERS: &[Starter] = &[
    Starter {
        task: "bench",
        package: "benchmarks",
        about: "Time the workspace beside a reference; writes target/bench/NAME.json",
    },
    Starter {
        task: "diagnosis-trials",
        package: "validation",
        about: "Answer many recording sets with sealed truth, score the answers, write the table in docs/",
    },
    Starter {
        task: "effects-atlas",
        package: "studies",
        about: "Draw each effect's signature into docs/effects, and write docs/effects.md",
    },
    Starter {
        task: "fixtures",
        package: "fixtures",
        about: "Write the recordings in `fixtures/` anew",
    },
    Starter {
        task: "fuzz",
        package: "fuzzing",
        about: "Read damaged inputs with every reader; those on which one fails are kept",
    },
    Starter {
        task: "real-comparison",
        package: "studies",
        about: "Compares the models with public measurements and writes the page about it",
    },
    Starter {
        task: "real-data",
        package: "studies",
        about: "Runs the models on published measurements and compares with the numbers to expect",
    },
    Starter {
        task: "reproduce-figures",
        package: "studies",
        about: "Draw the thesis' figures on one offline page",
    },
    Starter {
        task: "rig-calibration",
        package: "validation",
        about: "Put a simulated rig beside what was measured on real ones",
    },
    Starter {
        task: "samples",
        package: "studies",
        about: "Compare sets that hide a known effect with the thesis' model and with the effect added, in docs/",
    },
    Starter {
        task: "simulated-and-real",
        package: "studies",
        about: "Put the simulated table of the thesis' design beside a measured one, in docs/",
    },
    Starter {
        task: "thesis-claims",
        package: "studies",
        about: "Judge the thesis' claims on real, rough and quiet pushes side by side, in docs/",
    },
];

/// The task of this name, if another crate does it.
pub(crate) fn by_task(task: &OsStr) -> Option<&'static Starter> {
    STARTERS.iter().find(|starter| starter.task == task)
}

/// What the help lists of them.
pub(crate) fn commands() -> impl Iterator<Item = clap::Command> {
    STARTERS.iter().map(|starter| clap::Command::new(starter.task).about(starter.about))
}

/// The program of a task, compiled, with these arguments, in the folder that this one was started in.
///
/// # Errors
/// A task that no crate does; a program that does not compile.
pub(crate) fn command(task: &str, arguments: &[&str]) -> Result<Command> {
    let starter = by_task(task.as_ref()).with_context(|| format!("there is no task `{task}`"))?;
    starter.compile()?;
    starter.command(arguments.iter().map(OsString::from))
}

impl Starter {
    /// Runs the task to its end and hands its exit code back.
    ///
    /// # Errors
    /// If the program does not compile, cannot be started, or was ended from outside.
    pub(crate) fn start(&self, arguments: impl Iterator<Item = OsString>) -> Result<ExitCode> {
        self.compile()?;
        let mut command = self.command(arguments)?;
        let status =
            command.status().with_context(|| format!("cannot start {}", line(&command)))?;
        let code = status.code().and_then(|code| u8::try_from(code).ok());
        let code = code.with_context(|| format!("{} ended early ({status})", line(&command)))?;
        Ok(ExitCode::from(code))
    }

    /// Compiles the program with the features of the whole workspace, so that what the tests are made
    /// of is not compiled once more for each program.
    fn compile(&self) -> Result<()> {
        run(&mut cargo(&["build", "--quiet", "--workspace", "--bin", self.package]))
    }

    /// The compiled program, which lies beside this one.
    fn command(&self, arguments: impl Iterator<Item = OsString>) -> Result<Command> {
        let this = env::current_exe().context("cannot tell where this program is")?;
        let program = format!("{}{}", self.package, env::consts::EXE_SUFFIX);
        let mut command = Command::new(this.with_file_name(program));
        let package = workspace_root().join("crates").join(self.package);
        command.env("CARGO_MANIFEST_DIR", package).arg(self.task).args(arguments);
        Ok(command)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::ffi::OsString;
    use std::fs;

    use super::{STARTERS, Starter, by_task, command};
    use crate::cargo::workspace_root;

    #[test]
    fn every_argument_is_handed_through_as_it_is() {
        let starter = by_task("fuzz".as_ref()).unwrap();
        let arguments = ["--help", "--", "-x", "a b"].map(OsString::from);
        let command = starter.command(arguments.iter().cloned()).unwrap();
        let words: Vec<_> = command.get_args().collect();
        assert!(command.get_program().to_string_lossy().contains("fuzzing"));
        assert_eq!(words[0], "fuzz");
        assert_eq!(words[1..], arguments);
        assert_eq!(command.get_current_dir(), None);
    }

    #[test]
    fn tasks_are_registered_once_and_in_order() {
        assert!(STARTERS.is_sorted_by(|a, b| a.task < b.task));
        assert!(by_task("paint".as_ref()).is_none());
        assert_eq!(command("paint", &[]).unwrap_err().to_string(), "there is no task `paint`");
    }

    /// Each program's variants, as `DiagnosisTrials(`, are the tasks that are started in it.
    #[test]
    fn every_task_is_known_to_the_program_that_does_it() {
        let packages: BTreeSet<_> = STARTERS.iter().map(|starter| starter.package).collect();
        for package in packages {
            let sources = workspace_root().join("crates").join(package).join("src");
            let variants = ["command_line.rs", "main.rs"].iter().find_map(|file| {
                let program = fs::read_to_string(sources.join(file)).ok()?;
                let (_, rest) = program.split_once("enum Task {\n")?;
                Some(rest.split_once("\n}")?.0.to_owned())
            });
            let variants = variants.unwrap();
            let names = variants.lines().filter_map(|line| line.trim().split_once('('));
            let known: BTreeSet<_> = names.map(|(name, _)| kebab(name)).collect();
            let own = STARTERS.iter().filter(|starter| starter.package == package);
            for starter in own {
                assert!(known.contains(starter.task), "{package} does not know {}", starter.task);
            }
        }
    }

    #[test]
    fn the_architecture_has_a_row_for_every_task() {
        let page = fs::read_to_string(workspace_root().join("ARCHITECTURE.md")).unwrap();
        for Starter { task, package, .. } in STARTERS {
            let is_row = |line: &str| line.contains(&format!("`{task}`")) && line.contains(package);
            assert!(page.lines().any(is_row), "{task} of {package}");
        }
    }

    /// `DiagnosisTrials` as the command line has it: `diagnosis-trials`.
    fn kebab(name: &str) -> String {
        let mut word = String::new();
        for letter in name.chars() {
            if letter.is_uppercase() && !word.is_empty() {
                word.push('-');
            }
            word.extend(letter.to_lowercase());
        }
        word
    }
}
