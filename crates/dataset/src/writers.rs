//! One file for each way to write recordings.

mod cdr;
mod csv_writer;
mod mcap_writer;
mod mit_json_writer;
mod sample;

pub(crate) use csv_writer::CsvWriter;
pub(crate) use mcap_writer::McapWriter;
pub(crate) use mit_json_writer::MitJsonWriter;
