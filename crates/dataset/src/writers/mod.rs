//! A recording goes in, a file comes out that the format of the same kind reads: one file for each.

pub(crate) mod list;
pub(crate) mod writer;

#[cfg(feature = "bag")]
mod bag_writer;
mod cdr;
mod csv_writer;
mod mcap_writer;
#[cfg(feature = "hdf5")]
mod mit_hdf5_writer;
mod mit_json_writer;
#[cfg(feature = "protobuf")]
mod protobuf;
mod sample;

#[cfg(feature = "bag")]
pub(crate) use bag_writer::BagWriter;
pub(crate) use csv_writer::CsvWriter;
pub(crate) use mcap_writer::McapWriter;
#[cfg(feature = "hdf5")]
pub(crate) use mit_hdf5_writer::MitHdf5Writer;
pub(crate) use mit_json_writer::MitJsonWriter;
