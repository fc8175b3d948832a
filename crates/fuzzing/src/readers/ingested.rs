//! From a set's recordings to its table.

use std::fs;
use std::path::Path;

use anyhow::Result;
use dataset::{IngestSettings, RecordingSet, ingest};

use super::super::reader::{Reader, Verdict};
use super::manifest::MANIFEST;
use super::recording::{push, written};
use super::tables::wrong;

/// A set of one recording in JSON, whose numbers may be any.
pub(super) struct Ingested;

impl Reader for Ingested {
    fn name(&self) -> &'static str {
        "ingest"
    }

    fn corpus(&self, dir: &Path) -> Result<Vec<Vec<u8>>> {
        Ok(vec![written("mit-json", &push(80), dir)?])
    }

    fn tokens(&self) -> &'static [&'static str] {
        &["[0,0,0,0],", "[1700000000.5,0,0,0],", "[1e9,1e9,1e9,1e9],", "[1700000000.5,1e-9,0,7],"]
    }

    fn read(&self, dir: &Path, input: &[u8]) -> Verdict {
        let files = [("dataset.toml", MANIFEST.as_bytes()), ("push.json", input)];
        for (name, bytes) in files {
            if let Err(error) = fs::write(dir.join(name), bytes) {
                return Verdict::Wrong(format!("scratch is not usable: {error}"));
            }
        }
        let read = RecordingSet::open(dir).and_then(|set| ingest(&set, &IngestSettings::default()));
        Verdict::of(read, |(table, _)| wrong(table))
    }
}
