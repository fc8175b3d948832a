//! The studies as a program: `cargo run -p studies -- --help`.

use std::process::ExitCode;

fn main() -> ExitCode {
    studies::main()
}
