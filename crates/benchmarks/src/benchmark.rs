//! What a benchmark is, and what may be asked of it.

use anyhow::Result;

use crate::timing::Row;

/// What is timed, what `size` counts and what the reference is, in one line; and how.
pub(crate) struct Benchmark {
    pub(crate) name: &'static str,
    pub(crate) about: &'static str,
    pub(crate) rows: fn(&Sizes) -> Result<Vec<Row>>,
}

/// Sizes that are measured.
#[derive(clap::Args)]
pub(crate) struct Sizes {
    /// Sizes of the sets that are diagnosed
    #[arg(long, value_delimiter = ',', value_name = "N", default_value = "100,1000,10000,100000")]
    pub(crate) pushes: Vec<usize>,
}
