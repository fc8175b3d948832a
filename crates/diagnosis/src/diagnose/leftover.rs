//! What the best model leaves over.

use super::rules::Rules;
use super::search::Found;
use super::{DiagnoseSettings, Leftover};
use crate::{
    DiagnosisError, MapSettings, Observations, Predictions, RepeatTolerance, compare, noise_floor,
};

/// Structure in the residuals of the last model.
pub(super) struct Left {
    /// Probability of as much structure in noise; none where there is too little to look at.
    pub(super) p: Option<f64>,
    /// Where it shows most, in words.
    pub(super) sentence: Option<String>,
    /// Whitened root mean square of the last model.
    rms: f64,
}

/// Whitened error of a model that leaves something, where its structure is not told in words.
const MISSES: f64 = 1.25;

/// Looks for structure in what the confirmed model leaves of the pushes that it was fitted to.
pub(super) fn leftover(
    found: &Found,
    fitted: &Observations,
    settings: &DiagnoseSettings,
) -> Result<Left, DiagnosisError> {
    let predictions = Predictions::of(&found.with_nuisances, &settings.own, fitted)?;
    let floor = noise_floor(fitted, &predictions, &RepeatTolerance::default())?;
    let map_settings = MapSettings { seed: settings.seed, ..MapSettings::default() };
    let comparison = compare(fitted, &predictions, &floor, &map_settings)?;
    let p = comparison.maps.iter().map(|map| map.p_adjusted).min_by(f64::total_cmp);
    let mut sure = comparison.findings.iter().filter(|finding| finding.p_adjusted <= Rules::NAME);
    let sentence = sure.next().map(|finding| finding.sentence.clone());
    Ok(Left { p, sentence, rms: found.error.after })
}

impl Left {
    /// Whether something is left that matters.
    pub(super) fn is_left(&self) -> bool {
        let is_sure = self.p.is_some_and(|p| p <= Rules::NAME);
        is_sure && (self.sentence.is_some() || self.rms >= MISSES)
    }

    pub(super) fn summary(&self) -> Leftover {
        Leftover { p: self.p, covariate: self.sentence.clone().filter(|_| self.is_left()) }
    }
}
