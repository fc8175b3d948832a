#![doc = include_str!("../README.md")]

mod case;
mod fuzz;
mod keep;
mod memory;
mod minimize;
mod mutate;
mod reader;
mod readers;
mod scratch;
mod table;
mod watch;
mod worker;

pub use fuzz::{Args, WorkerArgs, run, work};
