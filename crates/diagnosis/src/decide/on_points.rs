//! Points on which an object rests, which no screen shows, in the place of single numbers that follow from them.

use std::f64::consts::SQRT_2;

use effects::{Channel, Effect, Stage, SupportPoints};

use super::both_noises::BothNoises;
use super::found::{Choice, Progress, Refused};
use super::phase::DiagnosePhase;
use super::rules::Objection;
use super::search::Search;
use crate::cut_offs::{NAME, PUSHES_A_NUMBER};
use crate::fit::Refit;
use crate::predict::candidates::follow_from_points;
use crate::{DiagnosisError, Gain, Screen};

/// Points that are tried at most, and at least.
const N_POINTS: [usize; 2] = [4, 3];
/// Covariances under which what no screen shows is asked for.
pub(super) const N_NOISES: usize = 2;

impl Search<'_> {
    /// The model on points instead of single numbers that follow from them, if pushes that are left out
    /// of the fit are predicted better for sure; notes why not.
    pub(super) fn on_points<'a>(
        &self,
        from: &BothNoises<'_, 'a>,
        screen: &Screen,
        progress: &mut Progress,
    ) -> Result<Option<Refit<'a>>, DiagnosisError> {
        if !self.asks_for_points(progress) {
            return Ok(None);
        }
        let follow = self.following_from_points();
        let mut found = self.sure_points(from.here, &follow, screen, progress);
        if found.is_none()
            && let Some(plain) = from.plain()
        {
            found = self.sure_points(plain, &follow, screen, progress);
        }
        let Some(Unscreened { there, p: p_adjusted, .. }) = found else { return Ok(None) };
        for one in progress.chosen.extract_if(.., |one| follow.contains(&one.id)) {
            progress.refused.push(Refused { id: one.id, objection: Objection::Superfluous });
        }
        let id = SupportPoints.info().id;
        let choice = Choice { id, p_adjusted, rivals: Vec::new(), is_small: false };
        Ok(Some(self.with_choice(choice, there, progress)?))
    }

    fn sure_points<'a>(
        &self,
        here: &Refit<'a>,
        follow: &[&'static str],
        screen: &Screen,
        progress: &mut Progress,
    ) -> Option<Unscreened<'a>> {
        let n_points = self.n_points()?;
        let found = self.borne_by_points(here, n_points, follow).map(|found| {
            let (there, gain) = found?;
            let p = p_of_points(&gain, follow, screen, progress);
            Some(Unscreened { there, gain, p })
        });
        sure((SupportPoints.info().id, n_numbers(n_points)), found, progress)
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
            && self.n_points().is_some()
    }

    /// As many points as there are pushes for; none for fewer than three, on which no object rests.
    fn n_points(&self) -> Option<usize> {
        let n_most = self.fitted.pushes().len() / PUSHES_A_NUMBER;
        N_POINTS.into_iter().find(|n_points| n_numbers(*n_points) <= n_most)
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
        n_points: usize,
        follow: &[&'static str],
    ) -> Result<Option<(Refit<'a>, Gain)>, Objection> {
        let Some(effect) = self.effect(SupportPoints.info().id) else { return Ok(None) };
        self.tell(DiagnosePhase::Refitting { effect: effect.info().id });
        let Some(there) = here.borne_by(effect, n_points, follow)? else { return Ok(None) };
        let gains = self.left_out(here, &there)?;
        Ok(Some((there, Gain::of(&gains))))
    }
}

/// Places of points, and their shares of the weight.
fn n_numbers(n_points: usize) -> usize {
    3 * n_points - 1
}

/// The model with an effect that no screen shows.
pub(super) struct Unscreened<'a> {
    pub(super) there: Refit<'a>,
    /// What clusters gain that are left out of the fit.
    pub(super) gain: Gain,
    /// Probability of it by chance, of any effect.
    pub(super) p: f64,
}

/// What was found of an effect of so many numbers if gain and probability are sure; notes both, and what speaks
/// against it.
pub(super) fn sure<'a>(
    (id, n_numbers): (&'static str, usize),
    found: Result<Option<Unscreened<'a>>, Objection>,
    progress: &mut Progress,
) -> Option<Unscreened<'a>> {
    let told = found.as_ref().ok().and_then(Option::as_ref).map(|found| (found.gain, found.p));
    progress.note_tried(id, n_numbers, told.map(|(gain, _)| gain), told.map_or(1.0, |(_, p)| p));
    let objection = match found {
        Err(why) => why,
        Ok(None) => return None,
        Ok(Some(Unscreened { gain, .. })) if !gain.is_sure() => Objection::NotPredictive { gain },
        Ok(Some(Unscreened { p, .. })) if p > NAME => Objection::NotSure { p },
        Ok(found) => return found,
    };
    progress.refused.push(Refused { id, objection });
    None
}

/// Probability that points gain so much by chance: of any effect, or where it is sure that something of the
/// support is missing, and the question is what alone, that of the other.
fn p_of_points(gain: &Gain, follow: &[&str], screen: &Screen, progress: &Progress) -> f64 {
    let of_support = progress.chosen.iter().filter(|one| follow.contains(&one.id));
    let of_support = of_support.map(|one| one.p_adjusted).reduce(f64::min);
    of_support.unwrap_or_else(|| p_of(gain, N_NOISES + n_tested(screen)))
}

pub(super) fn n_tested(screen: &Screen) -> usize {
    screen.effects.iter().filter(|one| one.not_testable.is_none()).count()
}

/// Probability of so large a gain of any of so many effects by chance.
pub(super) fn p_of(gain: &Gain, n_tests: usize) -> f64 {
    // Where every cluster gains as much as counts there is no standard error, and nothing is surer.
    let z = if gain.mean > 0.0 { gain.mean / gain.se } else { 0.0 };
    (0.5 * libm::erfc(z / SQRT_2) * n_tests as f64).min(1.0)
}

#[cfg(test)]
mod tests {
    use effects::{Effect, SupportPoints};

    use super::p_of;
    use crate::synthetic::pushed_with;
    use crate::{DiagnoseSettings, Gain, diagnose};

    #[test]
    fn what_every_session_gains_as_much_as_counts_is_no_chance() {
        let [all, most, none] = [[1e3; 11].as_slice(), &[1e3, 9.0, 8.0], &[0.0; 11]]
            .map(|gains| p_of(&Gain::of(gains), 20));
        assert_eq!((all, none), (0.0, 1.0));
        assert!(most > 0.0 && most < 1e-3, "{most}");
    }

    #[test]
    fn three_feet_are_named_by_fewer_pushes_than_four_points_take() {
        let about = SupportPoints.info();
        let mut feet = vec![0.0; about.parameters.len()];
        feet[..9].copy_from_slice(&[0.030, 0.025, 0.30, -0.035, 0.010, 0.45, 0.005, -0.035, 0.25]);
        let (all, model, _) = pushed_with((about.id, &feet), 1);
        // Of 44, 33 are fitted to.
        let names: Vec<String> = all.pushes().iter().take(44).map(ToString::to_string).collect();
        let observations = all.part(&names).unwrap();
        let found = diagnose(&observations, &model, &DiagnoseSettings::default()).unwrap();
        let found = found.diagnosis;
        assert_eq!(found.identified, [about.id], "{}", found.sentence);
        let told = found.effects.iter().find(|told| told.id == about.id).unwrap();
        let n_points = told.parameters.iter().filter(|one| one.unit == "m").count() / 2;
        assert_eq!(n_points, 3, "{:?}", told.parameters);
    }
}
