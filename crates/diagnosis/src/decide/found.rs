//! What a search has found.

use effects::Origin;
use models::Description;

use super::ErrorFall;
use super::constancy::Varies;
use super::raised::Raised;
use super::rules::Objection;
use crate::noise::widely_differing::At;
use crate::{EffectFit, Gain, NoiseModel, Screen, ScreenedEffect};

/// What a search found.
pub(super) struct Found {
    /// The screen of the model under test.
    pub(super) first_screen: Screen,
    /// The screen of the last model.
    pub(super) last_screen: Screen,
    /// What the held-out pushes confirm, in the order of adding.
    pub(super) accepted: Vec<Accepted>,
    /// Effects that passed the screen, and what speaks against them.
    pub(super) refused: Vec<Refused>,
    /// The noise, learnt beside the last model.
    pub(super) noise: NoiseModel,
    /// Where the last model was linearised.
    pub(super) at: At,
    /// The error on the held-out pushes.
    pub(super) error: ErrorFall,
    /// What they miss by more with all that is claimed than by the model under test.
    pub(super) raised: Option<Raised>,
    /// The model with what is confirmed.
    pub(super) description: Description,
    /// The same with the nuisances, for predictions.
    pub(super) with_nuisances: Description,
    /// The same with what the held-out pushes hint at without confirming it; none without a hint.
    pub(super) with_doubted: Option<Description>,
}

/// An effect that was added and is confirmed.
#[derive(Clone)]
pub(super) struct Accepted {
    pub(super) id: &'static str,
    pub(super) p_adjusted: f64,
    /// Effects that explain as much.
    pub(super) rivals: Vec<&'static str>,
    /// The effect as fitted beside all others.
    pub(super) effect: EffectFit,
    /// What pushes that no fit has seen lose without it, all others fitted anew.
    pub(super) gain: Gain,
    /// What the mean square of the whitened error rises by without it.
    pub(super) square: f64,
    /// Share of the gap to the floor that opens without it.
    pub(super) gap_closed: Option<f64>,
    /// Over what its size differs.
    pub(super) varies: Option<Varies>,
    /// What held-out pushes miss by more with it.
    pub(super) raised: Option<Raised>,
    /// What of the rig it comes from; none of an effect that no list has.
    pub(super) origin: Option<Origin>,
    /// What it changes is hardly seen.
    pub(super) is_small: bool,
}

/// An effect that passed the screen and was not added.
pub(super) struct Refused {
    pub(super) id: &'static str,
    pub(super) objection: Objection,
}

/// An effect that obeys every rule so far.
#[derive(Clone)]
pub(super) struct Choice {
    pub(super) id: &'static str,
    pub(super) p_adjusted: f64,
    pub(super) rivals: Vec<&'static str>,
    /// What it changes is hardly seen, though it is there.
    pub(super) is_small: bool,
}

/// How far a search has come.
pub(super) struct Progress {
    pub(super) chosen: Vec<Choice>,
    pub(super) refused: Vec<Refused>,
    pub(super) first_screen: Screen,
}

impl Progress {
    /// How many of the effects chosen are small, or are not.
    pub(super) fn n_chosen(&self, is_small: bool) -> usize {
        self.chosen.iter().filter(|one| one.is_small == is_small).count()
    }

    /// The effect that was chosen last, if it is not small.
    pub(super) fn last_large(&self) -> Option<&'static str> {
        self.chosen.last().filter(|one| !one.is_small).map(|one| one.id)
    }

    /// Notes what was found of an effect that no screen shows.
    pub(super) fn note_tried(
        &mut self,
        id: &'static str,
        freedom: usize,
        gain: Option<Gain>,
        p: f64,
    ) {
        self.refused.retain(|one| one.id != id);
        self.first_screen.effects.retain(|one| one.id != id);
        self.first_screen.effects.push(ScreenedEffect {
            id,
            not_testable: None,
            statistic: gain.map_or(0.0, |gain| 2.0 * gain.mean.max(0.0)),
            freedom,
            p,
            p_adjusted: p,
            coordinates: Vec::new(),
        });
    }

    /// Whether an effect was taken out again because later ones explain what it did.
    pub(super) fn was_superfluous(&self, id: &str) -> bool {
        let mut refused = self.refused.iter();
        refused.any(|one| one.id == id && one.objection == Objection::Superfluous)
    }
}

pub(super) fn ids(chosen: &[Choice]) -> Vec<&'static str> {
    chosen.iter().map(|one| one.id).collect()
}
