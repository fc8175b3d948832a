//! The step table: rows with the record of what made them, and their files.

pub(crate) mod column;
pub(crate) mod columns_file;
pub(crate) mod coverage;
pub(crate) mod csv;
pub(crate) mod file;
pub(crate) mod flags;
pub(crate) mod kind;
pub(crate) mod named_column;
#[cfg(feature = "parquet")]
pub(crate) mod parquet;
#[cfg(feature = "parquet")]
pub(crate) mod parquet_pages;
#[cfg(feature = "parquet")]
pub(crate) mod parquet_read;
pub(crate) mod step;
pub(crate) mod wrench_twist;
pub(crate) mod writer;

use crate::table::step::StepRow;

/// Steps of pushes, in the order of recordings, pushes and time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    /// One row a step.
    pub rows: Vec<StepRow>,
    /// What made the rows.
    pub provenance: Provenance,
}

/// What a table was made of and by what: pairs that every file of it carries.
///
/// Keys have no colon and no line break, values no line break; `source` occurs once a file, with
/// its SHA-256 and path.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Provenance {
    /// Keys and values, in the order of writing.
    pub entries: Vec<(String, String)>,
}

impl Provenance {
    /// Adds a pair; line breaks become spaces and colons of the key become dashes.
    pub fn push(&mut self, key: &str, value: &str) {
        let one_line = |text: &str| text.replace(['\r', '\n'], " ").trim().to_owned();
        self.entries.push((one_line(key).replace(':', "-"), one_line(value)));
    }

    /// The first value under a key.
    #[must_use]
    pub fn get(&self, key: &str) -> Option<&str> {
        self.entries.iter().find(|(known, _)| known == key).map(|(_, value)| value.as_str())
    }
}

impl Table {
    /// Number of rows.
    #[must_use]
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether there is no row.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }
}
