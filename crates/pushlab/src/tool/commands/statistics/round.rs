//! What the parts of a set share while they are summed up, and what each of them says.

use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use dataset::{Part, read_text};
use diagnosis::{ErrorGrid, ErrorSums, FitPlace, NormalEquations};
use gp_core::{GpError, Mergeable};
use models::ModelFile;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::tool::origin::{Input, TOOL};

/// What every part has to know.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::tool::commands) struct Round {
    /// Name of the set.
    pub(in crate::tool::commands) set: String,
    pub(in crate::tool::commands) model: Input,
    pub(in crate::tool::commands) grid: ErrorGrid,
    /// Where a fit stands, if there is one.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub(in crate::tool::commands) fit: Option<FitPlace>,
}

/// What a part of a set says.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(in crate::tool::commands) struct OfPart {
    pub(in crate::tool::commands) part: Part,
    pub(in crate::tool::commands) round: Round,
    pub(in crate::tool::commands) statistics: Statistics,
}

/// Sums over steps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::tool::commands) struct Statistics {
    pub(in crate::tool::commands) errors: ErrorSums,
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub(in crate::tool::commands) equations: Option<NormalEquations>,
}

#[derive(Deserialize)]
struct Document {
    made_by: MadeBy,
}

#[derive(Deserialize)]
struct MadeBy {
    tool: String,
}

#[derive(Deserialize)]
struct OfRound {
    round: Round,
}

impl Round {
    /// Reads what `statistics` wrote of a sample, or `merge` of the round before.
    ///
    /// # Errors
    /// If the file cannot be read, is another one, or of another release.
    pub(super) fn read(path: &Path) -> Result<Self> {
        let content: OfRound =
            read(path, "what parts share: give what `statistics` or `merge` wrote")?;
        Ok(content.round)
    }

    /// Its model, if that is the one that it began with.
    ///
    /// # Errors
    /// If it cannot be read, or is another one now.
    pub(in crate::tool::commands) fn model(&self) -> Result<ModelFile> {
        let Input { path, sha256 } = &self.model;
        ensure!(
            Input::file(path)?.sha256 == *sha256,
            "{} is not the model that these statistics began with; put that one back, or begin anew",
            path.display()
        );
        Ok(ModelFile::read(path)?)
    }

    /// How another one differs, if it does.
    fn difference(&self, other: &Self) -> Option<&'static str> {
        let differs = [
            ("set", self.set != other.set),
            ("model", self.model.sha256 != other.model.sha256),
            ("place of the fit", self.fit != other.fit),
            ("sample", self != other),
        ];
        differs.into_iter().find(|(_, differs)| *differs).map(|(what, _)| what)
    }
}

impl OfPart {
    /// Reads the statistics of a part.
    ///
    /// # Errors
    /// If the file cannot be read, is another one, or of another release.
    pub(in crate::tool::commands) fn read(path: &Path) -> Result<Self> {
        read(path, "the statistics of a part, which `statistics --round` writes")
    }

    /// Refuses one that does not go with this one.
    ///
    /// # Errors
    /// With the names of both and what differs.
    pub(in crate::tool::commands) fn goes_with(
        &self,
        own: &Path,
        (path, other): (&Path, &Self),
    ) -> Result<()> {
        let of = self.part.of() != other.part.of();
        let differs =
            of.then_some("number of parts").or_else(|| self.round.difference(&other.round));
        let (own, path) = (own.display(), path.display());
        match differs {
            Some(what) => {
                bail!("{path} does not go with {own}: the {what} differs; make all parts alike")
            }
            None => Ok(()),
        }
    }
}

impl Mergeable for Statistics {
    fn merge(&mut self, other: &Self) -> Result<(), GpError> {
        self.errors.merge(&other.errors)?;
        match (&mut self.equations, &other.equations) {
            (Some(own), Some(other)) => own.merge(other),
            (None, None) => Ok(()),
            _ => Err(GpError::Incompatible { what: "sums" }),
        }
    }
}

fn read<T: DeserializeOwned>(path: &Path, what: &str) -> Result<T> {
    let file = path.display();
    let text = read_text(path)?;
    let is_not = || format!("{file} is not {what}");
    let Document { made_by: MadeBy { tool } } = serde_json::from_str(&text).with_context(is_not)?;
    ensure!(
        tool == TOOL,
        "{file} was made by {tool}, this is {TOOL}: use one release for all of a set"
    );
    serde_json::from_str(&text).with_context(is_not)
}
