//! The readers that are fuzzed: one list.

mod diagnosis;
mod endpoints;
mod ingested;
mod log_variants;
mod logs;
mod manifest;
mod model;
mod recording;
mod self_test;
mod tables;
mod weights;

use anyhow::{Context, Result};

use super::reader::Reader;

/// Every reader, by what it reads.
pub(super) const READERS: &[&dyn Reader] = &[
    &logs::McapLogs,
    &logs::Bags,
    &logs::Hdf5,
    &logs::MitJson,
    &logs::CsvFolder,
    &ingested::Ingested,
    &tables::CsvTable,
    &tables::ParquetTable,
    &tables::MappedTable,
    &endpoints::EndPoints,
    &manifest::Manifests,
    &manifest::Mappings,
    &model::Models,
    &weights::WeightsFiles,
    &diagnosis::Diagnoses,
];

/// The reader of this name.
///
/// # Errors
/// If there is none, with those there are.
pub(super) fn by_name(name: &str) -> Result<&'static dyn Reader> {
    let mut all = READERS.iter().copied().chain([&self_test::SelfTest as &dyn Reader]);
    all.find(|reader| reader.name() == name).with_context(|| {
        let names: Vec<_> = READERS.iter().map(|reader| reader.name()).collect();
        format!("no reader {name}; there are {}", names.join(", "))
    })
}
