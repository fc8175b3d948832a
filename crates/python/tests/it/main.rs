//! pytest and the notebooks, as one program of tests: `cargo test -p pushlab-python`.
//!
//! It stages the package that cargo has built, so nothing is compiled a second time, and installs what the
//! tests need in an environment of its own, `target/python`. What stands behind `--` goes to pytest.

mod environment;
mod outcome;

use std::process::{Command, ExitCode};

use crate::environment::{Environment, Missing};
use crate::outcome::Outcome;

fn main() -> ExitCode {
    let environment = match Environment::found() {
        Ok(environment) => environment,
        Err(Missing(what)) => {
            println!("The tests of the Python package did not run: {what}");
            return ExitCode::SUCCESS;
        }
    };
    match tested(&environment) {
        Ok(outcome) => {
            println!("{outcome}");
            if outcome.is_good() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
        }
        Err(error) => {
            println!("The Python package cannot be tested: {error}");
            ExitCode::FAILURE
        }
    }
}

fn tested(environment: &Environment) -> std::io::Result<Outcome> {
    let mut pytest = Command::new(&environment.python);
    pytest
        .args(["-m", "pytest", "-p", "no:cacheprovider", "--color=no"])
        .args(std::env::args_os().skip(1))
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .env("PYTHONPATH", environment.package()?)
        .env("PYTHONDONTWRITEBYTECODE", "1");
    let output = pytest.output()?;
    let text = String::from_utf8_lossy(&output.stdout);
    println!("{text}{}", String::from_utf8_lossy(&output.stderr));
    Ok(Outcome::of(&text, output.status.success()))
}
