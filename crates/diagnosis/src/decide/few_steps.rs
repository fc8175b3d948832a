//! What few steps show and no screen does, as a tip that is caught at vertices.

use effects::{Channel, EdgeRounding, Effect, PusherStiction, Role, VertexContact};

use super::both_noises::BothNoises;
use super::found::{Choice, Progress};
use super::on_points::{N_NOISES, n_tested, p_of, sure};
use super::phase::DiagnosePhase;
use super::rules::Objection;
use super::search::Search;
use crate::cut_offs::{SIZE, SURE_NATS};
use crate::fit::Refit;
use crate::{DiagnosisError, Gain, Screen};

/// Effects that few steps show.
const N_FEW_STEPS: usize = 3;

impl Search<'_> {
    /// The model with an effect that few steps show and no slope, if pushes that are left out of the fit are predicted
    /// better for sure: a tip that is caught at vertices, for a limit has none; corners that are round, for a small
    /// rounding ends before anything is read; and a tip that sticks harder than it slides, for at "off" only pushes
    /// at the edge of sliding would change.
    pub(super) fn on_few_steps<'a>(
        &self,
        from: &BothNoises<'_, 'a>,
        screen: &Screen,
        progress: &mut Progress,
    ) -> Result<Option<Refit<'a>>, DiagnosisError> {
        for about in [VertexContact.info(), EdgeRounding.info(), PusherStiction.info()] {
            let id = about.id;
            let is_known = self.model.effects.iter().any(|carried| carried.id == id)
                || progress.chosen.iter().any(|one| one.id == id)
                || progress.was_superfluous(id);
            if is_known || !self.fitted.channels().contains(&Channel::Motion) {
                continue;
            }
            let n_tests = N_NOISES * N_FEW_STEPS + n_tested(screen);
            let p = |gain: &Gain, _: &Progress| p_of(gain, n_tests);
            let is_untestable =
                screen.effects.iter().any(|one| one.id == id && one.not_testable.is_some());
            let mut ask = |here: &Refit<'a>| {
                let found = self.with_limit_or_far(here, id);
                let is_seen = matches!(&found, Ok(Some((_, gain))) if gain.is_sure());
                // What no size of it makes sure stays untestable.
                if is_untestable && !is_seen {
                    return None;
                }
                sure((id, about.parameters.len()), found, p, progress)
            };
            let found = from.plain().and_then(&mut ask).or_else(|| ask(from.here));
            let Some((there, p_adjusted)) = found else { continue };
            let off = about.off(&there.rig());
            let is_small = there.size_against(id, &off)? < SIZE;
            let choice = Choice { id, p_adjusted, rivals: Vec::new(), is_small };
            return Ok(Some(self.with_choice(choice, there, progress)?));
        }
        Ok(None)
    }

    /// The model with an effect from its best limit, or from the best of its typical sizes; none where the pushes
    /// that were fitted gain less than is sure.
    fn with_limit_or_far<'a>(
        &self,
        here: &Refit<'a>,
        id: &'static str,
    ) -> Result<Option<(Refit<'a>, Gain)>, Objection> {
        let Some(effect) = self.effect(id) else { return Ok(None) };
        self.tell(DiagnosePhase::Refitting { effect: id });
        let has_limit = effect.info().parameters.iter().any(|one| one.role == Role::Threshold);
        let found = match has_limit {
            true => here.limited_by(effect)?,
            false => here.far_from_off(effect)?,
        };
        let Some(there) = found else { return Ok(None) };
        if 0.5 * (here.misfit_by(&there) - there.objective()) < SURE_NATS {
            return Ok(None);
        }
        let gains = self.left_out(here, &there)?;
        Ok(Some((there, Gain::of(&gains))))
    }
}

#[cfg(test)]
mod tests {
    use effects::{EdgeRounding, Effect, PusherStiction, VertexContact};

    use crate::synthetic::pushed_with;
    use crate::{DiagnoseSettings, diagnose};

    /// What is hidden is named, with an interval that holds its first number.
    fn is_claimed(effect: &dyn Effect, truth: &[f64], seed: u64) {
        let id = effect.info().id;
        let (observations, model, _) = pushed_with((id, truth), seed);
        let found = diagnose(&observations, &model, &DiagnoseSettings::default()).unwrap();
        let told = found.diagnosis.effects.iter().find(|told| told.id == id).unwrap();
        assert!(told.log_density_gain.is_some_and(|gain| gain.is_sure()), "{told:?}");
        let first = &told.parameters[0];
        let ends = first.low95.zip(first.high95);
        assert!(ends.is_some_and(|(low, high)| low < truth[0] && truth[0] < high), "{first:?}");
        assert!(found.description.effects.iter().any(|carried| carried.id == id));
    }

    #[test]
    fn a_tip_that_is_caught_at_vertices_is_claimed_with_its_limit() {
        // Farther than is met, for the recorded steps begin away from vertices.
        is_claimed(&VertexContact, &[0.007], 3);
    }

    #[test]
    fn round_corners_are_claimed_with_their_size_though_small_ones_end_before_anything_is_read() {
        is_claimed(&EdgeRounding, &[0.008], 2);
        is_claimed(&EdgeRounding, &[0.012], 2);
    }

    #[test]
    fn a_tip_that_sticks_harder_than_it_slides_is_claimed_with_its_size() {
        is_claimed(&PusherStiction, &[1.6, 1e-3], 2);
    }
}
