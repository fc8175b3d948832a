//! The command-line tool: words of a command line go in, files and what is printed come out, for its program and
//! for others.

mod command_line;
mod commands;
mod destination;
mod diagnosis_file;
mod document;
mod failure;
mod file_ending;
mod fitting;
mod global;
mod heard;
mod in_process;
mod known;
mod listener;
mod opened;
mod origin;
mod people;
mod program;
mod progress;
mod recorded_steps;
mod rig;
mod some_of;
mod speed;
mod step_kind;
mod step_size;
mod step_source;
mod suspected;
mod table_summary;
mod terminal;
mod unexplained;
mod whole_pushes;
mod wrong_usage;

pub use in_process::{CommandError, explained, run};
pub use listener::{Listener, Printed};
pub use program::program;
