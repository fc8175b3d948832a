//! `model.toml`: what people read, edit, version and pass on.

mod check;
mod effects_table;
mod raw;
mod source;
mod weights_file;

use std::path::Path;

use dataset::DatasetError;
use effects::Effect;

use self::raw::{Raw, RawBase, RawEffect, RawOut};
use self::source::Source;
use crate::{Description, ModelError, Split};

/// A model with its name, as it is kept in a file.
///
/// `docs/model.schema.json` describes the format for editors.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelFile {
    /// For people.
    pub name: String,
    /// The model.
    pub description: Description,
    /// The pushes that it was fitted to and those kept from every fit, if it was fitted to some.
    pub split: Option<Split>,
}

impl ModelFile {
    /// The format that this release writes and reads.
    pub const SCHEMA: &str = "pushlab.model/1";

    /// Reads a model, with its weights file beside it if it has one.
    ///
    /// # Errors
    /// As [`ModelFile::read_with`].
    pub fn read(path: &Path) -> Result<Self, ModelError> {
        Self::read_with(path, &[])
    }

    /// Reads a model that may carry effects of one's own besides those of the catalogue.
    ///
    /// # Errors
    /// `Io`; `Invalid` with the line and key for what the format does not allow; `Weights` if the
    /// weights are damaged or not those that the file was written with.
    pub fn read_with(path: &Path, own: &[&'static dyn Effect]) -> Result<Self, ModelError> {
        let text = read_text(path)?;
        let source = Source { path, text: &text };
        let raw: Raw = toml::from_str(&text).map_err(|error| source.syntax(&error))?;
        let base = source.base(&raw)?;
        let effects = source.effects(&raw, own)?;
        let weights = match &raw.learned {
            Some(learned) => Some(weights_file::read(&source, &base, learned)?),
            None => None,
        };
        let split = source.split(raw.split)?;
        Ok(Self { name: raw.name, description: Description { base, effects, weights }, split })
    }

    /// Writes the model, and beside it its weights as `<stem>.weights.json` if it has some.
    ///
    /// Each file is written under a temporary name and renamed when it is whole, the weights first.
    ///
    /// # Errors
    /// `Io`; `Weights` if they cannot be written as JSON.
    pub fn write(&self, path: &Path) -> Result<(), ModelError> {
        let learned = match &self.description.weights {
            Some(weights) => Some(weights_file::write(path, weights)?),
            None => None,
        };
        let base = RawBase::of(&self.description.base);
        let effects = self.description.effects.iter().map(RawEffect::of).collect();
        let (name, split) = (&self.name, self.split.as_ref());
        let raw = RawOut { schema: Self::SCHEMA, name, base, effects, learned, split };
        let text = toml::to_string(&raw).map_err(|error| ModelError::Weights {
            path: path.into(),
            problem: format!("cannot be written as TOML: {error}"),
        })?;
        write_whole(path, &text)
    }
}

fn read_text(path: &Path) -> Result<String, ModelError> {
    dataset::read_text(path).map_err(|error| match error {
        DatasetError::Io { action, path, source } => ModelError::Io { action, path, source },
        other => other.into(),
    })
}

fn write_whole(path: &Path, text: &str) -> Result<(), ModelError> {
    let temporary = path.with_added_extension("part");
    std::fs::write(&temporary, text)
        .and_then(|()| std::fs::rename(&temporary, path))
        .map_err(|source| io("write", path, source))
}

fn io(action: &'static str, path: &Path, source: std::io::Error) -> ModelError {
    ModelError::Io { action, path: path.into(), source }
}
