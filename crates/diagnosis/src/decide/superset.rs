//! Where an object rests, in the place of single numbers that follow from it.

use std::f64::consts::SQRT_2;

use effects::{Channel, Effect, Stage, SupportPoints};

use super::found::{Choice, Progress, Refused};
use super::rules::Objection;
use super::search::Search;
use crate::cut_offs::{NAME, PUSHES_A_NUMBER};
use crate::fit::Refit;
use crate::predict::candidates::follow_from_points;
use crate::{DiagnosisError, Gain, Screen, ScreenedEffect};

/// Of four points: places and shares.
const N_NUMBERS: usize = 11;

impl Search<'_> {
    /// The model on points instead of single numbers that follow from them, if pushes that are left out
    /// of the fit are predicted better for sure; notes why not. Asked once.
    pub(super) fn on_points<'a>(
        &self,
        here: &Refit<'a>,
        screen: &Screen,
        progress: &mut Progress,
    ) -> Result<Option<Refit<'a>>, DiagnosisError> {
        let id = SupportPoints.info().id;
        let Some(effect) = self.effect(id) else { return Ok(None) };
        let carries = |id: &str| self.model.effects.iter().any(|effect| effect.id == id);
        let mut says_where =
            self.model.effects.iter().filter_map(|carried| self.effect(&carried.id));
        let is_known = says_where.any(|effect| effect.info().stages.contains(&Stage::Pressure));
        let is_asked = progress.first_screen.effects.iter().any(|one| one.id == id);
        let n_pushes = self.fitted.pushes().len();
        let sees_motion = self.fitted.channels().contains(&Channel::Motion);
        if is_asked || is_known || !sees_motion || n_pushes < PUSHES_A_NUMBER * N_NUMBERS {
            return Ok(None);
        }
        let follow: Vec<&'static str> =
            follow_from_points().into_iter().filter(|id| !carries(id)).collect();
        let found = here.borne_by(effect, &follow).map_err(Objection::from);
        let n_tests = screen.effects.iter().filter(|one| one.not_testable.is_none()).count();
        let gain = found.as_ref().map_err(Clone::clone).and_then(|there| {
            let gains = self.left_out(here, there).map_err(Objection::from)?;
            Ok(Gain::of(&gains))
        });
        let p = gain.as_ref().map_or(1.0, |gain| p_of(gain, n_tests + 1));
        progress.first_screen.effects.push(ScreenedEffect {
            id,
            not_testable: None,
            statistic: gain.as_ref().map_or(0.0, |gain| 2.0 * gain.mean.max(0.0)),
            freedom: N_NUMBERS,
            p,
            p_adjusted: p,
            coordinates: Vec::new(),
        });
        let objection = match gain {
            Err(why) => Some(why),
            Ok(gain) if !gain.is_sure() => Some(Objection::NotPredictive { gain }),
            Ok(_) => (p > NAME).then_some(Objection::NotSure { p }),
        };
        let (Ok(there), None) = (found, &objection) else {
            progress.refused.extend(objection.map(|objection| Refused { id, objection }));
            return Ok(None);
        };
        for one in progress.chosen.iter().filter(|one| follow.contains(&one.id)) {
            progress.refused.push(Refused { id: one.id, objection: Objection::Superfluous });
        }
        progress.chosen.retain(|one| !follow.contains(&one.id));
        progress.chosen.push(Choice { id, p_adjusted: p, rivals: Vec::new(), is_small: false });
        Ok(Some(there))
    }
}

/// Probability of so large a gain of any of so many effects by chance.
fn p_of(gain: &Gain, n_tests: usize) -> f64 {
    let z = if gain.se > 0.0 { gain.mean / gain.se } else { 0.0 };
    (0.5 * libm::erfc(z / SQRT_2) * n_tests as f64).min(1.0)
}
