//! What the best model leaves over.

use effects::Origin;

use super::far_off::{Shared, shared_by_far_off};
use super::found::Found;
use super::standing::Standing;
use super::{DiagnoseSettings, Leftover};
use crate::cut_offs::{FAR_OFF, HINT, LEFT_SHARE, MISSES, NAME};
use crate::{
    Covariate, DiagnosisError, MapSettings, NoiseFloor, Observations, Predictions, Remains,
    RepeatTolerance, compare, noise_floor,
};

/// Structure in the residuals of the last model.
pub(super) struct Left {
    structure: Structure,
    /// Whether an effect that is no more than a hint explains the structure.
    is_doubted_enough: bool,
    /// Whitened root mean square of the last model, on held-out pushes.
    rms: f64,
    /// What pushes that are missed by far have in common, if anything.
    shared: Option<Shared>,
}

/// Errors whose mean differs from zero somewhere.
struct Structure {
    /// Probability of as much in noise; none where there is too little to look at.
    p: Option<f64>,
    /// Where it shows most, in words.
    sentence: Option<String>,
    /// What of the rig the region where it shows most speaks of, if it is one of speed, time or table.
    origin: Option<Origin>,
    /// Share of a number's squared error that the mean of a region explains: the largest.
    share: f64,
}

/// What of the rig a region of a covariate speaks of; of where an object is touched and how it lies much may.
fn speaks_of(covariate: Covariate) -> Option<Origin> {
    match covariate {
        Covariate::Speed => Some(Origin::Dynamics),
        Covariate::Time => Some(Origin::Time),
        Covariate::TableX | Covariate::TableY => Some(Origin::Table),
        Covariate::P
        | Covariate::Beta
        | Covariate::Edge
        | Covariate::Orientation
        | Covariate::Direction => None,
    }
}

impl Structure {
    fn of(
        predictions: &Predictions,
        observations: &Observations,
        floor: &NoiseFloor,
        settings: &DiagnoseSettings,
    ) -> Result<Self, DiagnosisError> {
        let map_settings = MapSettings { seed: settings.seed, ..MapSettings::default() };
        let comparison = compare(observations, predictions, floor, &map_settings)?;
        let p = comparison.maps.iter().map(|map| map.p_adjusted).min_by(f64::total_cmp);
        let sure = comparison.findings.iter().filter(|finding| finding.p_adjusted <= NAME);
        let share = sure.clone().map(|finding| finding.share).fold(0.0, f64::max);
        let first = sure.clone().next();
        let sentence = first.map(|finding| finding.sentence.clone());
        let conditions = first.into_iter().flat_map(|finding| &finding.conditions);
        let origin = conditions.filter_map(|one| speaks_of(one.covariate)).next();
        Ok(Self { p, sentence, origin, share })
    }

    fn is_surer_than(&self, level: f64) -> bool {
        self.p.is_some_and(|p| p <= level)
    }
}

/// Looks for structure in what the confirmed model leaves of the pushes that it was fitted to.
pub(super) fn leftover(
    found: &Found,
    (fitted, aside): (&Observations, &Observations),
    settings: &DiagnoseSettings,
) -> Result<Left, DiagnosisError> {
    let here = Standing::of(found, fitted, settings)?;
    let there = Standing::of(found, aside, settings)?;
    let floor = noise_floor(fitted, &here.predictions, &RepeatTolerance::default())?;
    let structure = Structure::of(&here.predictions, fitted, &floor, settings)?;
    let with_doubted = found.with_doubted.as_ref().map(|model| {
        let predictions = Predictions::expected(model, &settings.own, fitted)?;
        let predictions = predictions.about(here.whitening.mean());
        Structure::of(&predictions, fitted, &floor, settings)
    });
    let with_doubted = with_doubted.transpose()?;
    let is_doubted_enough = with_doubted.is_some_and(|with| !with.is_surer_than(NAME));
    let shared = shared_by_far_off([&here, &there], settings);
    let shared = shared.filter(|shared| shared.p <= NAME);
    Ok(Left { structure, is_doubted_enough, rms: found.error.after, shared })
}

impl Left {
    /// Whether something is left that matters.
    pub(super) fn is_left(&self) -> bool {
        self.has_structure() || self.shared.is_some()
    }

    fn has_structure(&self) -> bool {
        let matters = self.structure.share >= LEFT_SHARE || self.rms >= MISSES;
        self.structure.is_surer_than(NAME) && matters && !self.is_doubted_enough
    }

    /// Whether something may be left.
    pub(super) fn is_hint(&self) -> bool {
        let is_seen = self.structure.is_surer_than(HINT);
        let matters = self.structure.share >= 0.5 * LEFT_SHARE || self.rms >= MISSES;
        self.is_far_off() || is_seen && matters
    }

    /// Whether held-out pushes are missed by far more than noise, be they ever so few.
    pub(super) fn is_far_off(&self) -> bool {
        self.rms >= FAR_OFF
    }

    /// Beside what free components of each origin hold.
    pub(super) fn summary(&self, remains: Option<&Remains>) -> Leftover {
        let main = remains.and_then(Remains::main).map(|main| main.origin);
        let origin = self.origin_of_far_off().or(main).or_else(|| self.origin_of_place());
        Leftover { p: self.structure.p, covariate: self.told(), origin }
    }

    /// What of the rig is where structure shows most, if that speaks of one.
    pub(super) fn origin_of_place(&self) -> Option<Origin> {
        self.structure.origin.filter(|_| self.has_structure())
    }

    /// What of the rig makes pushes be missed by far that share something, where that is all that is told.
    pub(super) fn origin_of_far_off(&self) -> Option<Origin> {
        self.shared.as_ref().filter(|_| !self.has_structure()).map(|shared| shared.origin)
    }

    /// Where something is left, in words.
    pub(super) fn told(&self) -> Option<String> {
        let shared = || self.shared.as_ref().map(Shared::sentence);
        if self.has_structure() {
            self.structure.sentence.clone().or_else(shared)
        } else {
            shared()
        }
    }
}

#[cfg(test)]
mod tests {
    use effects::Origin;

    use super::{Left, Structure};

    fn left(p: f64, share: f64, rms: f64) -> Left {
        let sentence = Some("turns too far".to_owned());
        let structure = Structure { p: Some(p), sentence, origin: Some(Origin::Dynamics), share };
        Left { structure, is_doubted_enough: false, rms, shared: None }
    }

    #[test]
    fn structure_is_left_if_it_is_sure_and_matters() {
        assert!(left(0.01, 0.2, 1.0).is_left() && left(0.001, 0.0, 1.15).is_left());
        assert!(!left(0.02, 0.5, 1.4).is_left() && !left(0.001, 0.19, 1.14).is_left());
        let unseen = Structure { p: None, sentence: None, origin: None, share: 0.5 };
        assert!(!Left { structure: unseen, ..left(0.0, 0.5, 1.4) }.is_left());
        // What a hint explains is no structure that nothing explains.
        let doubted = Left { is_doubted_enough: true, ..left(0.001, 0.5, 1.4) };
        assert!(!doubted.is_left() && doubted.is_hint());
        assert!(left(0.05, 0.1, 1.0).is_hint() && left(0.03, 0.0, 1.2).is_hint());
        assert!(!left(0.06, 0.5, 1.4).is_hint() && !left(0.001, 0.09, 1.1).is_hint());
    }

    #[test]
    fn structure_comes_from_where_it_shows_if_nothing_else_tells() {
        assert_eq!(left(0.01, 0.2, 1.0).summary(None).origin, Some(Origin::Dynamics));
        // Not so what does not matter.
        assert_eq!(left(0.01, 0.1, 1.0).summary(None).origin, None);
    }

    #[test]
    fn pushes_that_are_missed_by_far_are_a_hint_without_any_structure() {
        let far = left(0.9, 0.0, 1.5);
        assert!(far.is_far_off() && far.is_hint() && !far.is_left());
        assert!(!left(0.9, 0.0, 1.49).is_hint());
    }
}
