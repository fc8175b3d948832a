//! The benchmarks as a program: `cargo run -p benchmarks -- --help`.

use std::process::ExitCode;

fn main() -> ExitCode {
    benchmarks::main()
}
