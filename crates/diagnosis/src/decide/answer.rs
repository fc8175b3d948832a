//! The answer to "which effect is missing?", for people and programs.

use dataset::Suspicion;
use effects::Origin;
use models::{Cluster, Split};
use serde::{Deserialize, Serialize};

use super::push_scatter::PushScatter;
use crate::cut_offs::HINT;
use crate::{FloorSource, Gain, NoiseModel, Observations, Remains, Runs};

/// What a diagnosis found; written and read as `diagnosis.json` (docs/diagnosis.schema.json).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Diagnosis {
    /// Name and version of this format.
    pub schema: String,
    /// What made it, where a tool did.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub made_by: Option<MadeBy>,
    /// What a tool told beside the answer.
    #[serde(default)]
    pub warnings: Vec<String>,
    /// What may be claimed.
    pub verdict: Verdict,
    /// Effects that are missing, in the order of adding.
    pub identified: Vec<String>,
    /// Groups of effects of which one is missing and these data cannot tell which.
    pub ambiguous: Vec<Vec<String>>,
    /// Effects that lower the error on held-out pushes, though another cause may be behind it.
    pub effective: Vec<String>,
    /// The answer in words.
    pub sentence: String,
    /// The error before and after, on held-out pushes.
    pub error: ErrorFall,
    /// Which pushes were fitted and which confirm.
    pub split: Split,
    /// Every effect that was asked for, those claimed first.
    pub effects: Vec<EffectFinding>,
    /// What the best model leaves over.
    pub leftover: Leftover,
    /// What of the rig the error that the effects leave comes from; none of fewer than eight clusters,
    /// and where a fifth of them holds all that is known of some number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub remains: Option<Remains>,
    /// Where the noise was learnt.
    pub noise: NoiseOrigin,
    /// What was used.
    pub data: DataUsed,
    /// What of the recordings may be wrong, where a tool looked at them: the verdict holds only if
    /// none of it is.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub suspicions: Vec<Suspicion>,
    /// What to do next, as commands of the tool that made it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub next: Vec<String>,
}

impl Diagnosis {
    /// The format that this release writes and reads.
    pub const SCHEMA: &str = "pushlab.diagnosis/2";
}

/// What a diagnosis may claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The effects in `identified` are missing.
    Identified,
    /// One effect of each group in `ambiguous` is missing.
    Ambiguous,
    /// The effects in `effective` lower the error, though another cause may be behind it.
    Effective,
    /// The model fails in a way that no effect of the library explains.
    Unexplained,
    /// Nothing is missing that these data could show.
    NoneFound,
    /// There are hints, and no more.
    Inconclusive,
}

/// An error before and after the claimed effects are added.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ErrorFall {
    /// Root mean square of whitened residuals of the model under test, with what a manifest leaves open
    /// fitted.
    pub before: f64,
    /// Of the model with the claimed effects, likewise.
    pub after: f64,
    /// Of a perfect model.
    pub floor: f64,
    /// (before − after)/(before − floor); none where before − floor is below twice its error.
    pub gap_closed: Option<f64>,
    /// What the numbers are.
    pub unit: String,
    /// Root mean square error of a step of the model under test as it is, in SI units.
    pub before_si: MotionError,
    /// Of that with the claimed effects.
    pub after_si: MotionError,
    /// Of a perfect model.
    pub floor_si: MotionError,
}

/// Root mean square errors of a step's motion and force; none where no floor is known, or no force was measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MotionError {
    /// Along the body's x, in m.
    pub dx_m: Option<f64>,
    /// Along the body's y, in m.
    pub dy_m: Option<f64>,
    /// Of the turn, in rad.
    pub dtheta_rad: Option<f64>,
    /// Of the force along the inward normal at the contact, in N.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force_normal_n: Option<f64>,
    /// Of the force along the tangent, in N.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force_tangential_n: Option<f64>,
}

impl MotionError {
    /// Of Δx, Δy, Δθ, normal and tangential force, in SI units.
    pub(super) fn of(
        [dx_m, dy_m, dtheta_rad, force_normal_n, force_tangential_n]: [Option<f64>; 5],
    ) -> Self {
        Self { dx_m, dy_m, dtheta_rad, force_normal_n, force_tangential_n }
    }
}

/// What was found of one effect.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EffectFinding {
    /// Its id.
    pub id: String,
    /// What may be said of it.
    pub grade: Grade,
    /// Whether it is there and hardly seen: it changes every number of a step by less than 0.3 of its
    /// noise, and is not known to close a twentieth of the gap. The model carries it; the verdict and the
    /// lists of names leave it out.
    #[serde(default)]
    pub small: bool,
    /// Probability of as strong a sign of any effect where none is missing; none if not tested. By
    /// flips of the signs of whole clusters; of a nominal number that is claimed by its estimate and
    /// standard error, times the number of effects asked for.
    pub p_adjusted: Option<f64>,
    /// Share of the gap to the floor that opens without it, on held-out pushes.
    pub gap_closed: Option<f64>,
    /// Log predictive density that pushes lose without it, in nats: those held out, and each cluster fitted
    /// to by a fit to the others.
    pub log_density_gain: Option<Gain>,
    /// Its parameters as fitted.
    pub parameters: Vec<ParameterFinding>,
    /// Effects that these data can hardly tell from it.
    pub rivals: Vec<String>,
    /// Why it has its grade, and what else is to be known.
    pub why: String,
}

impl EffectFinding {
    /// Whether there is a sign of it that is more than chance makes.
    pub fn is_seen(&self) -> bool {
        self.p_adjusted.is_some_and(|p| p <= HINT)
    }
}

/// What may be said of an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Grade {
    /// It is missing.
    Identified,
    /// A member of a group in `ambiguous`.
    Ambiguous,
    /// It lowers the error on held-out pushes, though another cause may be behind it.
    Effective,
    /// A hint.
    Hint,
    /// Not seen, with a limit to its size.
    BelowDetectionLimit,
    /// These data cannot show it.
    NotTestable,
}

/// What was found of a parameter.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ParameterFinding {
    /// Its name.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// Its value when the effect is not there.
    pub off: Option<f64>,
    /// The best value.
    pub estimate: Option<f64>,
    /// Its standard error, from whole clusters; 0 for a switch.
    pub se: Option<f64>,
    /// Lower end of the 95 % interval.
    pub low95: Option<f64>,
    /// Upper end.
    pub high95: Option<f64>,
    /// The size that these data would show with 90 % probability.
    pub detection_limit: Option<f64>,
}

/// Structure in the residuals of the best model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Leftover {
    /// Probability of as much structure in noise.
    pub p: Option<f64>,
    /// Over what it shows most, in words; none where there is none.
    pub covariate: Option<String>,
    /// What of the rig most of it comes from: by what the pushes share that are missed by far, where that is
    /// all that is told, else by what can be predicted of it, else by the speed, time or place on the table
    /// where it shows. None where none tells.
    #[serde(default)]
    pub origin: Option<Origin>,
}

impl NoiseOrigin {
    pub(super) fn of(noise: &NoiseModel, push_to_push: Vec<PushScatter>) -> Self {
        let source = match noise.source {
            FloorSource::Repeats => "repeats",
            FloorSource::Neighbours => "neighbours",
        };
        Self { source: source.to_owned(), n_cells: noise.n_cells, push_to_push }
    }
}

/// Where the noise was learnt, and what of the rig differs from push to push.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NoiseOrigin {
    /// `repeats` or `neighbours`.
    pub source: String,
    /// Groups of repeated pushes.
    pub n_cells: usize,
    /// Parameters of effects that differ from push to push, what scatters the motion most first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub push_to_push: Vec<PushScatter>,
}

/// What was used of a set.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DataUsed {
    /// Pushes with steps that were used.
    pub pushes_used: usize,
    /// Pushes without.
    #[serde(rename = "pushes_set_aside")]
    pub pushes_excluded: usize,
    /// Pushes that fits used: of a large set a part of those of the split.
    pub pushes_fitted: usize,
    /// Pushes that confirmed, likewise.
    pub pushes_confirming: usize,
    /// Steps used.
    pub steps: usize,
    /// Which rows are taken for steps of one push, where rows have no ids.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub runs: Option<Runs>,
    /// What is taken for independent among the pushes fitted to; none in answers of releases that
    /// did not tell.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clusters_fitted: Option<Clusters>,
    /// The same among those that confirmed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clusters_confirming: Option<Clusters>,
    /// Clusters to fit to that lack for an adjusted probability of 0.01, without which no effect is
    /// named.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clusters_missing: Option<usize>,
}

/// What is taken for independent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Clusters {
    /// What shares errors.
    pub kind: Cluster,
    /// How many there are.
    pub n: usize,
}

impl Clusters {
    pub(super) fn of(observations: &Observations) -> Self {
        Self { kind: observations.cluster, n: observations.n_clusters() }
    }
}

/// What made an answer.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MadeBy {
    /// Name and version.
    pub tool: String,
    /// The command.
    pub arguments: Vec<String>,
    /// The files that were read.
    pub inputs: Vec<MadeFrom>,
}

/// A file that was read.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MadeFrom {
    /// Where.
    pub path: String,
    /// In lower-case hexadecimal digits.
    pub sha256: String,
}
