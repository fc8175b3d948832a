//! `model.toml`: what people read, edit, version and pass on.

use std::path::{Path, PathBuf};

use nalgebra::Matrix3;
use serde::{Deserialize, Serialize};
use serde_spanned::Spanned;
use sha2::{Digest, Sha256};

use crate::{
    Analytical, Base, CharacteristicLength, Description, Estimate, ModelError, Weights, model_kinds,
};

/// A model with its name, as it is kept in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelFile {
    /// For people.
    pub name: String,
    /// The model.
    pub description: Description,
}

impl ModelFile {
    /// The format that this release writes and reads.
    pub const SCHEMA: &str = "pushlab.model/1";

    /// Reads a model, with its weights file beside it if it has one.
    ///
    /// # Errors
    /// `Io`; `Invalid` with the line and key for what the format does not allow; `Weights` if the
    /// weights are damaged or not those that the file was written with.
    pub fn read(path: &Path) -> Result<Self, ModelError> {
        let text = read_text(path)?;
        let source = Source { path, text: &text };
        let raw: Raw = toml::from_str(&text).map_err(|error| source.syntax(&error))?;
        source.check(&raw)?;
        let weights = match &raw.learned {
            Some(learned) => Some(read_weights(&source, learned)?),
            None => None,
        };
        let base = source.base(&raw)?;
        Ok(Self { name: raw.name, description: Description { base, weights } })
    }

    /// Writes the model, and beside it its weights as `<stem>.weights.json` if it has some.
    ///
    /// Each file is written under a temporary name and renamed when it is whole, the weights first.
    ///
    /// # Errors
    /// `Io`; `Weights` if they cannot be written as JSON.
    pub fn write(&self, path: &Path) -> Result<(), ModelError> {
        let learned = match &self.description.weights {
            Some(weights) => Some(write_weights(path, weights)?),
            None => None,
        };
        let raw = RawOut {
            schema: Self::SCHEMA,
            name: &self.name,
            base: RawBase::of(&self.description.base),
            learned,
        };
        let text = toml::to_string(&raw).map_err(|error| ModelError::Weights {
            path: path.into(),
            problem: format!("cannot be written as TOML: {error}"),
        })?;
        write_whole(path, &text)
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    schema: Spanned<String>,
    name: String,
    base: Spanned<RawBase>,
    #[serde(default)]
    effects: Vec<Spanned<toml::Table>>,
    learned: Option<Spanned<RawLearned>>,
}

#[derive(Serialize)]
struct RawOut<'a> {
    schema: &'a str,
    name: &'a str,
    base: RawBase,
    #[serde(skip_serializing_if = "Option::is_none")]
    learned: Option<RawLearned>,
}

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct RawBase {
    kind: Spanned<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    limit_surface: Option<Spanned<String>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pressure: Option<Spanned<String>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    scatter_per_m: Option<Spanned<[[f64; 3]; 3]>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pusher_friction: Option<Spanned<RawEstimate>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    characteristic_length: Option<Spanned<RawEstimate>>,
}

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct RawEstimate {
    value: f64,
    #[serde(default)]
    se: f64,
    #[serde(default)]
    source: String,
}

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct RawLearned {
    weights: String,
    sha256: String,
    inputs: Vec<String>,
}

impl RawBase {
    fn of(base: &Base) -> Self {
        let text = |text: &str| Spanned::new(0..0, text.to_owned());
        let (kind, analytical) = match base {
            Base::Analytical(analytical) => ("analytical", Some(analytical)),
            Base::Gp => ("gp", None),
            Base::Hybrid(analytical) => ("hybrid", Some(analytical)),
        };
        let estimate = |estimate: &Estimate| {
            let Estimate { value, se, source } = estimate.clone();
            Spanned::new(0..0, RawEstimate { value, se, source })
        };
        let given = |model: &Analytical| match model.length() {
            CharacteristicLength::Given(length) => Some(estimate(length)),
            CharacteristicLength::UniformPressure => None,
        };
        let scatter = |model: &Analytical| {
            let rows = model.scatter().transpose().into();
            (*model.scatter() != Matrix3::zeros()).then(|| Spanned::new(0..0, rows))
        };
        let pressure = |model: &Analytical| match model.length() {
            CharacteristicLength::Given(_) => None,
            CharacteristicLength::UniformPressure => Some(text("uniform")),
        };
        Self {
            kind: text(kind),
            limit_surface: analytical.map(|_| text("ellipsoid")),
            pressure: analytical.and_then(pressure),
            scatter_per_m: analytical.and_then(scatter),
            pusher_friction: analytical.map(|model| estimate(model.pusher_friction())),
            characteristic_length: analytical.and_then(given),
        }
    }
}

/// A file's text, to name lines in it.
struct Source<'a> {
    path: &'a Path,
    text: &'a str,
}

impl Source<'_> {
    fn line(&self, offset: usize) -> usize {
        1 + self.text.bytes().take(offset).filter(|byte| *byte == b'\n').count()
    }

    fn invalid(&self, offset: usize, key: &str, problem: impl Into<String>) -> ModelError {
        let (path, line) = (self.path.into(), self.line(offset));
        ModelError::Invalid { path, line, key: key.to_owned(), problem: problem.into() }
    }

    fn syntax(&self, error: &toml::de::Error) -> ModelError {
        let offset = error.span().map_or(0, |span| span.start);
        let line = self.text[..offset.min(self.text.len())].rfind('\n').map_or(0, |at| at + 1);
        let content = self.text[line..].lines().next().unwrap_or_default();
        let key = content.split('=').next().unwrap_or_default().trim().to_owned();
        self.invalid(offset, &key, error.message())
    }

    /// Refuses what this release cannot honor.
    fn check(&self, raw: &Raw) -> Result<(), ModelError> {
        let expect = |value: &Spanned<String>, key: &str, allowed: &[&str]| {
            if allowed.contains(&value.get_ref().as_str()) {
                return Ok(());
            }
            let problem =
                format!("`{}` is not known; allowed: {}", value.get_ref(), allowed.join(", "));
            Err(self.invalid(value.span().start, key, problem))
        };
        expect(&raw.schema, "schema", &[ModelFile::SCHEMA])?;
        if let Some(effect) = raw.effects.first() {
            let id =
                effect.get_ref().get("id").and_then(toml::Value::as_str).unwrap_or("without id");
            let problem = format!("effect {id}: this release has no effects; remove the block");
            return Err(self.invalid(effect.span().start, "effects", problem));
        }
        let base = raw.base.get_ref();
        let kinds: Vec<&str> = model_kinds().iter().map(|kind| kind.id).collect();
        expect(&base.kind, "base.kind", &kinds)?;
        for (value, key, allowed) in [
            (&base.limit_surface, "base.limit_surface", "ellipsoid"),
            (&base.pressure, "base.pressure", "uniform"),
        ] {
            if let Some(value) = value {
                expect(value, key, &[allowed])?;
            }
        }
        let learns = base.kind.get_ref() != "analytical";
        match &raw.learned {
            None if learns => {
                Err(self.invalid(raw.base.span().start, "learned", "this kind needs the table"))
            }
            Some(learned) if !learns => {
                let problem = "an analytical model has no weights; remove the table";
                Err(self.invalid(learned.span().start, "learned", problem))
            }
            _ => Ok(()),
        }
    }

    fn base(&self, raw: &Raw) -> Result<Base, ModelError> {
        let base = raw.base.get_ref();
        Ok(match base.kind.get_ref().as_str() {
            "analytical" => Base::Analytical(self.analytical(&raw.base)?),
            "hybrid" => Base::Hybrid(self.analytical(&raw.base)?),
            _ => {
                let friction = base.pusher_friction.as_ref().map(Spanned::span);
                let length = base.characteristic_length.as_ref().map(Spanned::span);
                let surface = base.limit_surface.as_ref().map(Spanned::span);
                if let Some(span) = friction.or(length).or(surface) {
                    let problem = "a gp has no mechanics; remove its keys, or use kind hybrid";
                    return Err(self.invalid(span.start, "base", problem));
                }
                Base::Gp
            }
        })
    }

    fn analytical(&self, base: &Spanned<RawBase>) -> Result<Analytical, ModelError> {
        let raw = base.get_ref();
        let start = base.span().start;
        let key = "base.pusher_friction";
        let missing = |key, problem: &str| self.invalid(start, key, problem);
        let friction =
            raw.pusher_friction.as_ref().ok_or_else(|| missing(key, "is missing; give a value"))?;
        let friction = self.estimate(friction, key, 0.0)?;
        let length = match (&raw.characteristic_length, &raw.pressure) {
            (Some(length), None) => CharacteristicLength::Given(self.estimate(
                length,
                "base.characteristic_length",
                f64::MIN_POSITIVE,
            )?),
            (None, Some(_)) => CharacteristicLength::UniformPressure,
            _ => {
                let problem = "give either pressure = \"uniform\" or [base.characteristic_length]";
                return Err(missing("base.pressure", problem));
            }
        };
        let scatter = match &raw.scatter_per_m {
            None => Matrix3::zeros(),
            Some(rows) => {
                let matrix = Matrix3::from_fn(|i, j| rows.get_ref()[i][j]);
                if matrix != matrix.transpose() || matrix.symmetric_eigenvalues().min() < 0.0 {
                    let problem = "must be symmetric and positive semi-definite";
                    return Err(self.invalid(rows.span().start, "base.scatter_per_m", problem));
                }
                matrix
            }
        };
        Analytical::new(friction, length, scatter)
    }

    fn estimate(
        &self,
        raw: &Spanned<RawEstimate>,
        key: &str,
        least: f64,
    ) -> Result<Estimate, ModelError> {
        let RawEstimate { value, se, source } = raw.get_ref();
        for (name, value, least) in
            [("value", raw.get_ref().value, least), ("se", raw.get_ref().se, 0.0)]
        {
            if !(value >= least && value.is_finite()) {
                let sign = if least > 0.0 { "positive" } else { "not negative" };
                let problem = format!("must be finite and {sign}, got {value}");
                return Err(self.invalid(raw.span().start, &format!("{key}.{name}"), problem));
            }
        }
        Ok(Estimate { value: *value, se: *se, source: source.clone() })
    }
}

fn read_weights(source: &Source, learned: &Spanned<RawLearned>) -> Result<Weights, ModelError> {
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

fn write_weights(model: &Path, weights: &Weights) -> Result<RawLearned, ModelError> {
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

fn read_text(path: &Path) -> Result<String, ModelError> {
    std::fs::read_to_string(path).map_err(|source| io("read", path, source))
}

fn write_whole(path: &Path, text: &str) -> Result<(), ModelError> {
    let temporary: PathBuf = path.with_added_extension("part");
    std::fs::write(&temporary, text)
        .and_then(|()| std::fs::rename(&temporary, path))
        .map_err(|source| io("write", path, source))
}

fn io(action: &'static str, path: &Path, source: std::io::Error) -> ModelError {
    ModelError::Io { action, path: path.into(), source }
}
