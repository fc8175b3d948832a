//! The weights beside a model file, under its checksum.

use std::path::Path;

use serde_spanned::Spanned;
use sha2::{Digest, Sha256};

use super::raw::RawLearned;
use super::source::Source;
use super::{read_text, write_whole};
use crate::{ModelError, Weights};

/// Reads the weights that a model file names.
///
/// # Errors
/// `Invalid` for other inputs than ours, `Io`, and `Weights` for another checksum or content.
pub(super) fn read(source: &Source, learned: &Spanned<RawLearned>) -> Result<Weights, ModelError> {
    let RawLearned { weights: name, sha256, inputs } = learned.get_ref();
    let start = learned.span().start;
    if inputs != &Weights::INPUTS {
        let problem = format!("must be {:?}, got {inputs:?}", Weights::INPUTS);
        return Err(source.invalid(start, "learned.inputs", problem));
    }
    let path = source.path.with_file_name(name);
    let text = read_text(&path)?;
    let damaged = |problem: String| ModelError::Weights { path: path.clone(), problem };
    let found = digest(&text);
    if found != *sha256 {
        return Err(damaged(format!("has SHA-256 {found}, the model was written with {sha256}")));
    }
    let weights: Weights = serde_json::from_str(&text)
        .map_err(|error| damaged(format!("is not readable: {error}")))?;
    if weights.schema != Weights::SCHEMA {
        let problem =
            format!("has schema {}, this release reads {}", weights.schema, Weights::SCHEMA);
        return Err(damaged(problem));
    }
    Ok(weights)
}

/// Writes the weights beside the model file `model`.
///
/// # Errors
/// `Io`; `Weights` if they cannot be written as JSON.
pub(super) fn write(model: &Path, weights: &Weights) -> Result<RawLearned, ModelError> {
    let path = model.with_extension("weights.json");
    let text = serde_json::to_string(weights).map_err(|error| ModelError::Weights {
        path: path.clone(),
        problem: format!("cannot be written as JSON: {error}"),
    })?;
    write_whole(&path, &text)?;
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let inputs = Weights::INPUTS.map(str::to_owned).to_vec();
    Ok(RawLearned { weights: name, sha256: digest(&text), inputs })
}

fn digest(text: &str) -> String {
    Sha256::digest(text).iter().map(|byte| format!("{byte:02x}")).collect()
}
