//! Effects that no screen shows: where an object rests, in the place of single numbers that follow from it, and
//! a tip that is caught at vertices.

use std::f64::consts::SQRT_2;

use effects::{Channel, Effect, Stage, SupportPoints, VertexContact};

use super::found::{Choice, Progress, Refused};
use super::rules::Objection;
use super::search::Search;
use crate::cut_offs::{NAME, PUSHES_A_NUMBER, SIZE};
use crate::fit::Refit;
use crate::predict::candidates::follow_from_points;
use crate::{DiagnosisError, Gain, Screen};

/// Of four points: places and shares.
const N_NUMBERS: usize = 11;

impl Search<'_> {
    /// The model on points instead of single numbers that follow from them, if pushes that are left out
    /// of the fit are predicted better for sure; notes why not.
    pub(super) fn on_points<'a>(
        &self,
        here: &Refit<'a>,
        screen: &Screen,
        progress: &mut Progress,
    ) -> Result<Option<Refit<'a>>, DiagnosisError> {
        let id = SupportPoints.info().id;
        if !self.asks_for_points(progress) {
            return Ok(None);
        }
        let follow = self.following_from_points();
        let found = self.borne_by_points(here, &follow);
        let gain = found.as_ref().ok().and_then(Option::as_ref).map(|(_, gain)| *gain);
        let p = gain.map_or(1.0, |gain| p_of_points(&gain, &follow, screen, progress));
        progress.note_tried(id, N_NUMBERS, gain, p);
        let objection = match found {
            Err(why) => why,
            Ok(None) => return Ok(None),
            Ok(Some((_, gain))) if !gain.is_sure() => Objection::NotPredictive { gain },
            Ok(Some(_)) if p > NAME => Objection::NotSure { p },
            Ok(Some((there, _))) => {
                for one in progress.chosen.extract_if(.., |one| follow.contains(&one.id)) {
                    let objection = Objection::Superfluous;
                    progress.refused.push(Refused { id: one.id, objection });
                }
                let rivals = Vec::new();
                progress.chosen.push(Choice { id, p_adjusted: p, rivals, is_small: false });
                return Ok(Some(self.without_superfluous(there, progress)?));
            }
        };
        progress.refused.push(Refused { id, objection });
        Ok(None)
    }

    /// The model with a tip that is caught at vertices, if pushes that are left out of the fit are predicted
    /// better for sure: no slope and no screen shows a limit that few steps are within.
    pub(super) fn on_vertices<'a>(
        &self,
        here: &Refit<'a>,
        screen: &Screen,
        progress: &mut Progress,
    ) -> Result<Option<Refit<'a>>, DiagnosisError> {
        let id = VertexContact.info().id;
        let is_known = self.model.effects.iter().any(|carried| carried.id == id)
            || progress.chosen.iter().any(|one| one.id == id)
            || progress.was_superfluous(id);
        if is_known || !self.fitted.channels().contains(&Channel::Motion) {
            return Ok(None);
        }
        let found = self.caught_at_vertices(here);
        let gain = found.as_ref().ok().and_then(Option::as_ref).map(|(_, gain)| *gain);
        let p = gain.map_or(1.0, |gain| p_of(&gain, 1 + n_tested(screen)));
        progress.note_tried(id, 1, gain, p);
        let objection = match found {
            Err(why) => why,
            Ok(None) => return Ok(None),
            Ok(Some((_, gain))) if !gain.is_sure() => Objection::NotPredictive { gain },
            Ok(Some(_)) if p > NAME => Objection::NotSure { p },
            Ok(Some((there, _))) => {
                let is_small = there.size_against(id, &[0.0])? < SIZE;
                let choice = Choice { id, p_adjusted: p, rivals: Vec::new(), is_small };
                return Ok(Some(self.with_choice(choice, there, progress)?));
            }
        };
        progress.refused.push(Refused { id, objection });
        Ok(None)
    }

    fn caught_at_vertices<'a>(
        &self,
        here: &Refit<'a>,
    ) -> Result<Option<(Refit<'a>, Gain)>, Objection> {
        let Some(effect) = self.effect(VertexContact.info().id) else { return Ok(None) };
        let Some(there) = here.limited_by(effect)? else { return Ok(None) };
        let gains = self.left_out(here, &there)?;
        Ok(Some((there, Gain::of(&gains))))
    }

    /// Whether there are data for points, and neither the model nor the search says where the object rests.
    /// After a small effect the answer is what it was, and so it is where later effects explain what points did.
    fn asks_for_points(&self, progress: &Progress) -> bool {
        let says_where = |id: &str| {
            self.effect(id).is_some_and(|effect| effect.info().stages.contains(&Stage::Pressure))
        };
        let mut carried = self.model.effects.iter();
        let is_known = carried.any(|carried| says_where(&carried.id));
        let is_asked = progress.chosen.last().is_some_and(|one| one.is_small)
            || progress.chosen.iter().any(|one| says_where(one.id))
            || progress.was_superfluous(SupportPoints.info().id);
        !is_known
            && !is_asked
            && self.fitted.channels().contains(&Channel::Motion)
            && self.fitted.pushes().len() >= PUSHES_A_NUMBER * N_NUMBERS
    }

    /// Numbers that follow from points, but for those that the model under test has.
    fn following_from_points(&self) -> Vec<&'static str> {
        let carries = |id: &&str| self.model.effects.iter().any(|effect| effect.id == *id);
        follow_from_points().into_iter().filter(|id| !carries(id)).collect()
    }

    /// The model on points, and what clusters that are left out of the fit gain; none where points are far off.
    fn borne_by_points<'a>(
        &self,
        here: &Refit<'a>,
        follow: &[&'static str],
    ) -> Result<Option<(Refit<'a>, Gain)>, Objection> {
        let Some(effect) = self.effect(SupportPoints.info().id) else { return Ok(None) };
        let Some(there) = here.borne_by(effect, follow)? else { return Ok(None) };
        let gains = self.left_out(here, &there)?;
        Ok(Some((there, Gain::of(&gains))))
    }
}

/// Probability that points gain so much by chance: of any effect, or where it is sure that something of the
/// support is missing, and the question is what alone, that of the other.
fn p_of_points(gain: &Gain, follow: &[&str], screen: &Screen, progress: &Progress) -> f64 {
    let of_support = progress.chosen.iter().filter(|one| follow.contains(&one.id));
    let of_support = of_support.map(|one| one.p_adjusted).reduce(f64::min);
    of_support.unwrap_or_else(|| p_of(gain, 1 + n_tested(screen)))
}

fn n_tested(screen: &Screen) -> usize {
    screen.effects.iter().filter(|one| one.not_testable.is_none()).count()
}

/// Probability of so large a gain of any of so many effects by chance.
fn p_of(gain: &Gain, n_tests: usize) -> f64 {
    let z = if gain.se > 0.0 { gain.mean / gain.se } else { 0.0 };
    (0.5 * libm::erfc(z / SQRT_2) * n_tests as f64).min(1.0)
}
