//! A file of any log format goes in, a recording comes out: one file for each format.

pub(crate) mod assemble;
pub(crate) mod channel;
pub(crate) mod container;
pub(crate) mod decode;
pub(crate) mod end_points;
pub(crate) mod format;
pub(crate) mod layout;
pub(crate) mod list;
pub(crate) mod log;
pub(crate) mod select;
pub(crate) mod stamps;

#[cfg(feature = "bag")]
mod bag;
#[cfg(feature = "bag")]
mod bag_record;
mod csv_folder;
mod find;
mod mcap_ahead;
mod mcap_damage;
mod mcap_log;
mod mcap_record;
#[cfg(feature = "hdf5")]
mod mit_hdf5;
mod mit_json;
mod mit_rows;
mod row_losses;
mod timed_rows;

#[cfg(feature = "bag")]
pub(crate) use bag::BagFormat;
pub(crate) use csv_folder::CsvFormat;
pub(crate) use end_points::EndPointsFormat;
pub(crate) use mcap_log::McapFormat;
#[cfg(feature = "hdf5")]
pub(crate) use mit_hdf5::MitHdf5Format;
pub(crate) use mit_json::MitJsonFormat;
pub(crate) use mit_rows::default_data_set;
