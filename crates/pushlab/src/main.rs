//! The command-line tool `pushlab`.

use std::process::ExitCode;

fn main() -> ExitCode {
    pushlab::program()
}
