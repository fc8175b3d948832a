#![doc = include_str!("../README.md")]

mod bench;
mod benchmark;
mod command_line;
mod contact;
mod diagnosis;
mod effects;
mod filter;
mod floor;
mod gp;
mod gp_rff;
mod gp_sparse;
mod ingest;
mod limits;
mod matching;
mod page;
mod peers;
mod plant;
mod push;
mod report;
mod stream;
mod timing;

pub use command_line::main;
