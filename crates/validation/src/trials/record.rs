//! What a finished trial leaves: one line of JSON.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::{File, OpenOptions};
use std::io::{BufRead, BufReader, Write};
use std::path::Path;

use anyhow::{Context, Result};
use diagnosis::{
    Diagnosis, ErrorFall, Grade, Leftover, ParameterFinding, PushScatter, Remains, Verdict,
};
use serde::{Deserialize, Serialize};

use super::case::{Case, Family, Setup};
use super::truth::{TrueEffect, Truth};
use super::variant::Variant;

/// One finished trial.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Record {
    pub(super) case: String,
    pub(super) family: Family,
    /// The effect that it is about; several are joined by +.
    pub(super) about: String,
    pub(super) seed: u64,
    /// Name of the surface of the model under test.
    pub(super) surface: String,
    pub(super) setup: Setup,
    /// Times the nameable size, of the first hidden effect; none for typical sizes.
    pub(super) multiple: Option<f64>,
    /// Largest change of one of a step's numbers by the first hidden effect, over its noise, where
    /// the oracle knows it.
    pub(super) visibility: Option<f64>,
    /// Documented look-alikes that explain the first hidden effect, too, where the oracle knows it.
    #[serde(default)]
    pub(super) alike: Vec<String>,
    /// From the sealed file, read after the answer.
    pub(super) truth: Vec<TrueEffect>,
    /// From there as well: what the pushes share beside it.
    #[serde(default)]
    pub(super) drawn: Vec<TrueEffect>,
    /// Of the diagnosis alone, in s.
    pub(super) seconds: f64,
    pub(super) outcome: Outcome,
    pub(super) variants: BTreeMap<Variant, Outcome>,
    /// Error of a step with the model that was found, over that before, on other pushes of the rig.
    pub(super) fresh: Option<f64>,
    /// Root mean square errors of Δx, Δy (m) and Δθ (rad) that noise alone leaves a true model.
    pub(super) floor: Option<[f64; 3]>,
    /// Effects added by hand, and the share of the gap that each closes.
    pub(super) closed_by_hand: Vec<(String, f64)>,
}

/// The answer, or why there is none.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Outcome {
    Answer(Box<Answer>),
    /// An error, a panic or a time-out.
    Failed(String),
}

/// The part of a diagnosis that is scored or explains the score.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Answer {
    pub(super) verdict: Verdict,
    pub(super) identified: Vec<String>,
    pub(super) ambiguous: Vec<Vec<String>>,
    pub(super) effective: Vec<String>,
    pub(super) sentence: String,
    pub(super) error: ErrorFall,
    pub(super) leftover: Leftover,
    #[serde(default)]
    pub(super) remains: Option<Remains>,
    /// What differs from push to push, the most first.
    #[serde(default)]
    pub(super) push_to_push: Vec<PushScatter>,
    pub(super) effects: Vec<Told>,
}

/// What the answer tells of one effect.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Told {
    pub(super) id: String,
    pub(super) grade: Grade,
    /// Whether it is there and hardly seen.
    #[serde(default)]
    pub(super) small: bool,
    pub(super) p: Option<f64>,
    pub(super) gain: Option<[f64; 2]>,
    pub(super) why: String,
    pub(super) rivals: Vec<String>,
    pub(super) parameters: Vec<ParameterFinding>,
}

impl Record {
    /// A trial without an answer.
    pub(super) fn failed(case: &Case, why: String, truth: Truth, seconds: f64) -> Self {
        Self {
            case: case.name.clone(),
            family: case.family,
            about: case.about.clone(),
            seed: case.seed,
            surface: case.surface.name().to_owned(),
            setup: case.setup,
            multiple: case.multiple(),
            visibility: None,
            alike: Vec::new(),
            truth: truth.hidden,
            drawn: truth.drawn,
            seconds,
            outcome: Outcome::Failed(why),
            variants: BTreeMap::new(),
            fresh: None,
            floor: None,
            closed_by_hand: Vec::new(),
        }
    }
}

impl From<Diagnosis> for Answer {
    fn from(found: Diagnosis) -> Self {
        let told = |effect: diagnosis::EffectFinding| Told {
            id: effect.id,
            grade: effect.grade,
            small: effect.small,
            p: effect.p_adjusted,
            gain: effect.log_density_gain.map(|gain| [gain.mean, gain.se]),
            why: effect.why,
            rivals: effect.rivals,
            parameters: effect.parameters,
        };
        Self {
            verdict: found.verdict,
            identified: found.identified,
            ambiguous: found.ambiguous,
            effective: found.effective,
            sentence: found.sentence,
            error: found.error,
            leftover: found.leftover,
            remains: found.remains,
            push_to_push: found.noise.push_to_push,
            effects: found.effects.into_iter().map(told).collect(),
        }
    }
}

impl Told {
    /// Whether there is more to tell than a limit.
    pub(super) fn is_told(&self) -> bool {
        !matches!(self.grade, Grade::BelowDetectionLimit | Grade::NotTestable)
    }
}

impl Answer {
    /// Every effect that is named or in a group.
    pub(super) fn claimed(&self) -> BTreeSet<&str> {
        let groups = self.ambiguous.iter().flatten().map(String::as_str);
        self.named().chain(groups).collect()
    }

    /// The same without what is hardly seen.
    pub(super) fn verdict(&self) -> BTreeSet<&str> {
        let groups = self.ambiguous.iter().flatten();
        self.identified.iter().chain(groups).map(String::as_str).collect()
    }

    /// Every effect that is named, what is hardly seen, too.
    pub(super) fn named(&self) -> impl Iterator<Item = &str> {
        let is_named = |effect: &&Told| effect.small && effect.grade == Grade::Identified;
        let small = self.effects.iter().filter(is_named).map(|effect| effect.id.as_str());
        self.identified.iter().map(String::as_str).chain(small)
    }

    pub(super) fn told(&self, id: &str) -> Option<&Told> {
        self.effects.iter().find(|effect| effect.id == id)
    }
}

impl Outcome {
    pub(super) fn answer(&self) -> Option<&Answer> {
        match self {
            Self::Answer(answer) => Some(answer),
            Self::Failed(_) => None,
        }
    }

    /// As `named table-tilt` or `failed: …`.
    pub(super) fn text(&self) -> String {
        let answer = match self {
            Self::Failed(why) => return format!("failed: {why}"),
            Self::Answer(answer) => answer,
        };
        let verdict = serde_json::to_string(&answer.verdict).unwrap_or_default();
        let mut text = verdict.trim_matches('"').replace('_', " ");
        if !answer.identified.is_empty() {
            text += &format!(" {}", answer.identified.join(" + "));
        }
        if !answer.effective.is_empty() {
            text += &format!(" (effective: {})", answer.effective.join(", "));
        }
        for group in &answer.ambiguous {
            text += &format!(" (one of {})", group.join(", "));
        }
        text
    }
}

/// The records of a file; a last line that was cut off is passed over. None if there is no file.
///
/// # Errors
/// A file that cannot be read; another line that is no record.
pub(super) fn read(path: &Path) -> Result<Vec<Record>> {
    let Ok(file) = File::open(path) else { return Ok(Vec::new()) };
    let lines: Vec<String> = BufReader::new(file).lines().collect::<Result<_, _>>()?;
    let mut records = Vec::new();
    for (index, line) in lines.iter().enumerate() {
        match serde_json::from_str(line) {
            Ok(record) => records.push(record),
            Err(_) if index + 1 == lines.len() => {}
            Err(error) => {
                let place = format!("{}:{}", path.display(), index + 1);
                return Err(error).context(format!("{place} is no record; remove the line"));
            }
        }
    }
    Ok(records)
}

/// Adds a record to a file.
///
/// # Errors
/// A file that cannot be written.
pub(super) fn append(path: &Path, record: &Record) -> Result<()> {
    let line = serde_json::to_string(record)? + "\n";
    let mut file = OpenOptions::new().create(true).append(true).open(path)?;
    file.write_all(line.as_bytes()).with_context(|| format!("cannot write {}", path.display()))
}
