//! A model at its minimum with effects that no slope leads to: where the object rests, in the place of numbers
//! that follow from it, and limits.

use std::sync::Arc;

use effects::Effect;

use super::descent::{BRIEF, Exactness, Start};
use super::problem::Problem;
use super::{Refit, SupportPointsFit};
use crate::DiagnosisError;
use crate::cut_offs::FAR_ABOVE;

impl<'a> Refit<'a> {
    /// The minimum with an effect that says where the object rests, from where the motions say that it does, on so
    /// many points; effects in `instead` are off. None if a brief descent ends far above this model.
    ///
    /// # Errors
    /// As a descent.
    pub(crate) fn borne_by(
        &self,
        effect: &Arc<dyn Effect>,
        n_points: usize,
        instead: &[&'static str],
    ) -> Result<Option<Self>, DiagnosisError> {
        let Problem { space, whitening, robust, .. } = &self.problem;
        let points = SupportPointsFit { n: n_points, ..SupportPointsFit::default() };
        let space_on = space.with_on(effect, points)?;
        let mut problem = Problem::new(space_on, whitening, robust.clone());
        for (k, frozen) in self.problem.frozen.iter().enumerate() {
            problem.frozen[k] |= *frozen;
        }
        let follows: Vec<&'static str> =
            instead.iter().copied().filter(|id| self.has(id)).collect();
        for own in follows.iter().filter_map(|id| problem.space.numbers_of(id)) {
            problem.frozen[own].fill(true);
        }
        let mut x = self.place_with(|id| follows.contains(&id), |member| member.off.clone());
        for member in problem.space.members.iter().skip(space.members.len()) {
            x.extend(member.place(&member.start));
        }
        let start = Start { at: problem.stand(x)?, slopes: None, exactness: Exactness::Rough };
        let brief = problem.descend_briefly(start, BRIEF)?;
        if brief.at.value > FAR_ABOVE * self.objective() {
            return Ok(None);
        }
        let mut there = self.clone();
        there.minimum = problem.settle(brief.at.x, Some(brief.whole), Exactness::Mixture)?;
        there.before = self.minimum.clone();
        there.problem = problem;
        there.dropped.extend(follows);
        Ok(Some(there))
    }

    /// The minimum with an effect whose number is a limit that steps are on one side of; none where no limit
    /// lowers the sum.
    ///
    /// # Errors
    /// As a descent.
    pub(crate) fn limited_by(
        &self,
        effect: &Arc<dyn Effect>,
    ) -> Result<Option<Self>, DiagnosisError> {
        let Problem { space, whitening, robust, frozen, .. } = &self.problem;
        let mut problem = Problem::new(space.with(effect)?, whitening, robust.clone());
        problem.frozen[..frozen.len()].copy_from_slice(frozen);
        let mut off = self.minimum.at.x.clone();
        for member in problem.space.members.iter().skip(space.members.len()) {
            off.extend(member.place(&member.off));
        }
        let limited = problem.limited(off.clone())?;
        if limited == off {
            return Ok(None);
        }
        let mut there = self.clone();
        // The strains of the effect's priors follow those that are known, and no slope changes them.
        let n_rows = whitening.n_numbers() + problem.space.strains(&limited).len();
        let slopes = self.minimum.whole.clone().resize_vertically(n_rows, 0.0);
        there.minimum = problem.settle(limited, Some(slopes), Exactness::Sum)?;
        there.before = self.minimum.clone();
        there.problem = problem;
        Ok(Some(there))
    }
}

#[cfg(test)]
mod tests {
    use effects::{Effect, SupportPoints, by_id};

    use crate::FitSettings;
    use crate::cut_offs::APART;
    use crate::fit::Refit;
    use crate::synthetic::{pushed_with, white};

    #[test]
    fn points_end_where_no_slope_leads_further() {
        let id = SupportPoints.info().id;
        let mut truth = vec![0.0; SupportPoints.info().parameters.len()];
        truth[..9].copy_from_slice(&[0.030, 0.025, 0.30, -0.035, 0.010, 0.45, 0.005, -0.035, 0.25]);
        // A descent by slopes that were carried along alone leaves 10 of the second.
        for seed in [2, 5] {
            let (observations, model, _) = pushed_with((id, &truth), seed);
            let whitening = white(&observations);
            let here = Refit::new(&observations, &model, &whitening, &FitSettings::default());
            let points = here.unwrap().borne_by(by_id(id).unwrap(), 4, &["pressure-radius"]);
            let points = points.unwrap().unwrap();
            let lower = points.clone().settled().unwrap();
            let left = points.misfit_by(&lower) - lower.objective();
            assert!(left < APART * lower.scale().powi(2), "seed {seed}: {left}");
        }
    }
}
