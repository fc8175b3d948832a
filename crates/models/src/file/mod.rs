//! `model.toml` in and out: what people read, edit, version and pass on.

mod check;
mod effects_table;
pub(crate) mod made_for;
mod raw;
mod source;
mod weights_file;

use std::path::Path;
use std::sync::Arc;

use dataset::DatasetError;
use effects::Effect;
use output::{Existing, OutputFile};

use self::made_for::MadeFor;
use self::raw::{Raw, RawBase, RawEffect, RawOut};
use self::source::Source;
use crate::{Calibration, Description, ModelError, Split};

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
    /// Object, pusher and table that it was made for; older files do not tell.
    pub made_for: Option<MadeFor>,
    /// How sure it may be of whole pushes, if that was measured.
    pub calibration: Option<Calibration>,
}

impl ModelFile {
    /// The format that this release writes and reads.
    pub const SCHEMA: &str = "pushlab.model/1";

    /// A model that was made by hand, for no rig and from no pushes.
    #[must_use]
    pub fn new(name: impl Into<String>, description: Description) -> Self {
        let (split, made_for, calibration) = (None, None, None);
        Self { name: name.into(), description, split, made_for, calibration }
    }

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
    pub fn read_with(path: &Path, own: &[Arc<dyn Effect>]) -> Result<Self, ModelError> {
        let text = read_text(path)?;
        let source = Source { path, text: &text };
        let raw: Raw = toml::from_str(&text).map_err(|error| source.syntax(&error))?;
        let base = source.base(&raw)?;
        let effects = source.effects(&raw, own)?;
        let weights = match &raw.learned {
            Some(learned) => Some(weights_file::read(&source, &base, learned)?),
            None => None,
        };
        let (split, made_for) = (source.split(raw.split)?, source.made_for(raw.made_for)?);
        let calibration = source.calibration(raw.calibration)?;
        let description = Description { base, effects, weights };
        Ok(Self { name: raw.name, description, split, made_for, calibration })
    }

    /// Writes the model, in place of one that is there, and beside it its weights if it has some.
    ///
    /// # Errors
    /// As [`Self::write_to`].
    pub fn write(&self, path: &Path) -> Result<(), ModelError> {
        self.write_to(OutputFile::new(path, Existing::Replace)?)
    }

    /// Writes the model to a place that is taken, and its weights beside it, if it has some, as
    /// `<stem>.<digest>.weights.json`.
    ///
    /// The weights are whole before the model names them, and have a name of their own for each
    /// content: wherever a run is killed, the model that is there has the weights that it was
    /// written with. Those of a model that was replaced are removed last, unless another model of
    /// the folder names them.
    ///
    /// # Errors
    /// `Output`; `Weights` if they cannot be written as JSON, or if the model goes to standard
    /// output, beside which there is no place for them; `Io` if old ones cannot be removed.
    pub fn write_to(&self, output: OutputFile) -> Result<(), ModelError> {
        let path = output.path().to_owned();
        let is_printed = output.is_standard_output();
        if is_printed && self.description.weights.is_some() {
            let problem =
                "takes no model with weights, which stand beside it; name a file".to_owned();
            return Err(ModelError::Weights { path, problem });
        }
        let replaced = if is_printed { None } else { weights_file::named_by(&path) };
        let learned = match &self.description.weights {
            Some(weights) => Some(weights_file::write(&path, weights)?),
            None => None,
        };
        let base = RawBase::of(&self.description.base);
        let effects = self.description.effects.iter().map(RawEffect::of).collect();
        let (name, split, made_for) = (&self.name, self.split.as_ref(), self.made_for.as_ref());
        let kept = learned.as_ref().map(|learned| learned.weights.clone());
        let (schema, calibration) = (Self::SCHEMA, self.calibration.as_ref());
        let raw = RawOut { schema, name, base, effects, learned, made_for, calibration, split };
        let text = toml::to_string(&raw).map_err(|error| ModelError::Weights {
            path: path.clone(),
            problem: format!("cannot be written as TOML: {error}"),
        })?;
        output.write(text)?;
        weights_file::remove(&path, replaced.filter(|name| Some(name) != kept.as_ref()))
    }
}

fn read_text(path: &Path) -> Result<String, ModelError> {
    dataset::read_text(path).map_err(|error| match error {
        DatasetError::Io { action, path, source } => ModelError::Io { action, path, source },
        other => other.into(),
    })
}

fn io(action: &'static str, path: &Path, source: std::io::Error) -> ModelError {
    ModelError::Io { action, path: path.into(), source }
}
