//! The weights beside a model file, under its checksum.

use std::fs;
use std::io::ErrorKind;
use std::path::Path;

use serde_spanned::Spanned;
use sha2::{Digest, Sha256};

use super::raw::{RawLearned, new};
use super::source::Source;
use super::{io, read_text};
use crate::{Base, ModelError, ProcessKind, StepFeatures, Weights};

/// How a weights file ends, and digits of its checksum that stand before that.
const ENDING: &str = "weights.json";
const SHOWN: usize = 12;

/// Reads the weights that a model file of this base names.
///
/// # Errors
/// `Invalid` for inputs or a process that the weights do not have, `Io`, and `Weights` for another
/// checksum or content.
pub(super) fn read(
    source: &Source,
    base: &Base,
    learned: &Spanned<RawLearned>,
) -> Result<Weights, ModelError> {
    let RawLearned { weights: name, sha256, process, inputs, .. } = learned.get_ref();
    let start = learned.span().start;
    if StepFeatures::by_names(inputs).is_none() {
        let known: Vec<_> = StepFeatures::ALL.map(StepFeatures::names).into();
        let problem = format!("must be one of {known:?}, got {inputs:?}");
        return Err(source.invalid(start, "learned.inputs", problem));
    }
    let kind = kind(source, base, process.as_ref())?;
    let path = source.path.with_file_name(name);
    let text = read_text(&path)?;
    let damaged = |problem: String| ModelError::Weights { path: path.clone(), problem };
    let found = digest(&text);
    if found != *sha256 {
        return Err(damaged(format!(
            "has SHA-256 {found}, the model was written with {sha256}; train it again, or bring \
             back the file that was written with it"
        )));
    }
    let weights: Weights = serde_json::from_str(&text)
        .map_err(|error| damaged(format!("is not readable: {error}")))?;
    if !Weights::READABLE.contains(&weights.schema.as_str()) {
        let readable = Weights::READABLE.join(", ");
        let problem = format!("has schema {}, this release reads {readable}", weights.schema);
        return Err(damaged(problem));
    }
    if weights.inputs != *inputs {
        let problem = format!("must be those of the weights, {:?}", weights.inputs);
        return Err(source.invalid(start, "learned.inputs", problem));
    }
    match weights.outputs.iter().find(|process| process.kind() != kind) {
        Some(process) => {
            let (found, kind) = (process.kind().id(), kind.id());
            Err(damaged(format!("holds processes of kind {found}, the model is of kind {kind}")))
        }
        None => Ok(weights),
    }
}

/// The kind of process that the file promises.
fn kind(
    source: &Source,
    base: &Base,
    process: Option<&Spanned<String>>,
) -> Result<ProcessKind, ModelError> {
    let key = "learned.process";
    match (base, process) {
        (Base::Process(kind), None) => Ok(*kind),
        (Base::Process(kind), Some(process)) => {
            source.expect(process, key, &[kind.id()])?;
            Ok(*kind)
        }
        (_, None) => Ok(ProcessKind::default()),
        (_, Some(process)) => {
            let allowed = ProcessKind::ALL.map(ProcessKind::id);
            ProcessKind::by_id(process.get_ref())
                .ok_or_else(|| source.unknown(process, key, &allowed))
        }
    }
}

/// Writes the weights beside the model file `model`.
///
/// # Errors
/// `Io`; `Weights` if they cannot be written as JSON.
pub(super) fn write(model: &Path, weights: &Weights) -> Result<RawLearned, ModelError> {
    let text = serde_json::to_string(weights).map_err(|error| ModelError::Weights {
        path: model.into(),
        problem: format!("cannot be written as JSON: {error}"),
    })?;
    let sha256 = digest(&text);
    let path = model.with_extension(format!("{}.{ENDING}", &sha256[..SHOWN]));
    output::write(&path, &text)?;
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let beside = weights.orthogonal_discrepancy.as_ref();
    Ok(RawLearned {
        weights: name,
        sha256,
        process: beside.map(|_| new(weights.kind().id().to_owned())),
        inputs: weights.inputs.clone(),
        unexplained: beside.map(|beside| beside.unexplained),
    })
}

/// The weights that the model file at a path names, if it is one that names some of its own.
pub(super) fn named_by(model: &Path) -> Option<String> {
    let file: toml::Table = fs::read_to_string(model).ok()?.parse().ok()?;
    let name = file.get("learned")?.get("weights")?.as_str()?;
    let rest = name.strip_prefix(model.file_stem()?.to_str()?)?;
    let is_own = rest.starts_with('.') && rest.ends_with(ENDING) && !rest.contains(['/', '\\']);
    is_own.then(|| name.to_owned())
}

/// Removes weights beside the model file `model`, unless another model of the folder names them.
///
/// # Errors
/// `Io`.
pub(super) fn remove(model: &Path, name: Option<String>) -> Result<(), ModelError> {
    let Some(name) = name else { return Ok(()) };
    let folder = match model.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    };
    for entry in fs::read_dir(folder).map_err(|source| io("read", folder, source))? {
        let other = entry.map_err(|source| io("read", folder, source))?.path();
        let is_model = other.extension().is_some_and(|ending| ending == "toml");
        if is_model && fs::read_to_string(&other).is_ok_and(|text| text.contains(&name)) {
            return Ok(());
        }
    }
    let path = model.with_file_name(name);
    match fs::remove_file(&path) {
        Err(source) if source.kind() != ErrorKind::NotFound => Err(io("remove", &path, source)),
        _ => Ok(()),
    }
}

fn digest(text: &str) -> String {
    format!("{:x}", Sha256::digest(text))
}
