#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod array;
mod commands;
mod failure;
mod interruptible;
mod model;
mod module;
mod particle_filter;
mod posterior;
mod recordings;
mod steps;
