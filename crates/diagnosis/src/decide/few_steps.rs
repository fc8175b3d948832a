//! What few steps show and no screen does, as a tip that is caught at vertices.

use effects::{Channel, EdgeRounding, Effect, PusherStiction, Role, VertexContact};
use models::Cluster;

use super::both_noises::BothNoises;
use super::found::{Choice, Progress};
use super::on_points::{N_NOISES, Unscreened, n_tested, p_of, sure};
use super::phase::DiagnosePhase;
use super::rules::{Objection, Rules};
use super::search::Search;
use crate::cut_offs::{ACTS, MOST_FAR, SIZE, SURE_NATS};
use crate::fit::{N_LIMITS, Refit};
use crate::statistics::signed_ranks::{Acted, p_of_signed_ranks};
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
            let is_untestable =
                screen.effects.iter().any(|one| one.id == id && one.not_testable.is_some());
            let mut ask = |here: &Refit<'a>| {
                let found = self.with_limit_or_far(here, id, n_tests);
                let is_seen = matches!(&found, Ok(Some(one)) if one.gain.is_sure());
                // What no size of it makes sure stays untestable.
                if is_untestable && !is_seen {
                    return None;
                }
                sure((id, about.parameters.len()), found, progress)
            };
            let found = from.plain().and_then(&mut ask).or_else(|| ask(from.here));
            let Some(Unscreened { there, p: p_adjusted, .. }) = found else { continue };
            let off = about.off(&there.rig());
            let is_small = there.size_against(id, &off)? < SIZE;
            let choice = Choice { id, p_adjusted, rivals: Vec::new(), is_small };
            return Ok(Some(self.with_choice(choice, there, progress)?));
        }
        Ok(None)
    }

    /// The model with an effect from its best limit, or from the best of its typical sizes; none where the pushes
    /// that were fitted gain less than is sure. It is one of so many tests.
    fn with_limit_or_far<'a>(
        &self,
        here: &Refit<'a>,
        id: &'static str,
        n_tests: usize,
    ) -> Result<Option<Unscreened<'a>>, Objection> {
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
        let parts = [here.left_out(&there)?, there.left_out(&there)?];
        let gain = Gain::of(&Rules::gains(self.fitted, &parts));
        let n_tests = if has_limit { n_tests * N_LIMITS } else { n_tests };
        let p = match self.p_where_it_acts((&there, effect.as_ref()), &parts)? {
            Some(p) => (p * n_tests as f64).min(1.0),
            None => p_of(&gain, n_tests),
        };
        Ok(Some(Unscreened { there, gain, p }))
    }

    /// Probability that the pushes that an effect acts on are missed by chance, and the way it acts; none where these
    /// are not few.
    ///
    /// Of few pushes no mean is sure, however much each gains. That just those are missed by far is.
    fn p_where_it_acts(
        &self,
        (there, effect): (&Refit, &dyn Effect),
        [without, with]: &[Vec<f64>; 2],
    ) -> Result<Option<f64>, DiagnosisError> {
        let about = effect.info();
        let changes = there.change_of_pushes(about.id, &about.off(&there.rig()))?;
        let acted = |push: usize| Acted { push, gains: with[push] < without[push] };
        let pushes = 0..changes.len();
        let acted: Vec<Acted> = pushes.filter(|push| changes[*push] >= ACTS).map(acted).collect();
        let are_few = acted.len() as f64 <= MOST_FAR * changes.len() as f64;
        let clusters = self.fitted.clusters_of_pushes();
        let strata = match self.fitted.cluster {
            Cluster::Push => vec![0; changes.len()],
            Cluster::Session => clusters.clone(),
        };
        let p = || p_of_signed_ranks(without, &acted, (&strata, &clusters), self.settings.seed);
        Ok((are_few && !acted.is_empty()).then(p))
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
        // Some five pushes alone, which no mean makes sure.
        is_claimed(&VertexContact, &[0.005], 3);
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
