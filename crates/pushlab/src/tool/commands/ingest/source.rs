//! What there is to ingest: recordings, or a table of others with its mapping.

use anyhow::{Error, Result, anyhow};
use dataset::{Preset, RecordingSet, Table};

use super::Args;
use crate::tool::known::Known;
use crate::tool::opened::{Opened, open};
use crate::tool::origin::{Input, readable};

/// The input as it was recognized.
pub(super) enum Source {
    /// A recording set.
    Recordings(Box<RecordingSet>),
    /// A table of others, in our columns.
    Table {
        table: Box<Table>,
        /// Its file, and its mapping's.
        inputs: Vec<Input>,
    },
}

impl Source {
    /// Recognizes the input by the options and by what is there.
    ///
    /// # Errors
    /// If the input is neither, with the way to what was probably meant.
    pub(super) fn of(args: &Args) -> Result<Self> {
        let Args { preset, shape, mapping, .. } = args;
        let (preset, shape, mapping) = (*preset, shape.clone(), mapping.clone());
        if mapping.is_some() || preset == Some(Preset::MitTable) {
            args.refuse_step()?;
        }
        let known = Known { manifest: None, preset, shape, mapping };
        let is_ours = || known.mapping.is_none() && Table::read(&args.set).is_ok();
        if readable(&args.set)?.is_file() && is_ours() {
            return Err(is_made(args));
        }
        match open(&args.set, &known)? {
            Opened::Recordings(set) => Ok(Self::Recordings(set)),
            Opened::Table(opened) if opened.is_converted => {
                let inputs = opened.inputs;
                Ok(Self::Table { table: Box::new(opened.table), inputs })
            }
            Opened::Table(_) => Err(is_made(args)),
        }
    }
}

fn is_made(args: &Args) -> Error {
    anyhow!(
        "{} is a step table of pushlab already: `pushlab describe` tells what is in it, and other commands \
         read it; a table of others needs --mapping FILE",
        args.set.display()
    )
}
