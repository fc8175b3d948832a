//! A model at its minimum.

use effects::Channels;
use models::Description;
use nalgebra::{DMatrix, DVector};

use super::descent::{BRIEF, Exactness, Minimum, Start};
use super::estimates::{descriptions, estimates};
use super::member::{Member, Part};
use super::problem::Problem;
use super::robust::Robust;
use super::search::Found;
use super::space::Space;
use super::{Fit, FitSettings};
use crate::{DiagnosisError, Observations, Whitening};

/// A model with its nuisances, and the effects asked for, at the minimum.
#[derive(Clone, Debug)]
pub(crate) struct Refit<'a> {
    pub(super) observations: &'a Observations,
    pub(super) model: &'a Description,
    pub(super) problem: Problem<'a>,
    /// The minimum without the effect that was added last.
    pub(super) before: Minimum,
    pub(super) minimum: Minimum,
    /// Added effects that were taken out again: they stand at "off".
    pub(super) dropped: Vec<&'static str>,
    /// Members that the model has without added effects.
    pub(super) n_own: usize,
}

impl<'a> Refit<'a> {
    /// The minimum over the nuisances, from where the model stands.
    ///
    /// # Errors
    /// As [`super::fit`].
    pub(crate) fn new(
        observations: &'a Observations,
        model: &'a Description,
        whitening: &'a Whitening,
        settings: &FitSettings,
    ) -> Result<Self, DiagnosisError> {
        let mut space = Space::new(observations, model, &[], settings, None)?;
        let is_in_model = |id: &str| model.effects.iter().any(|effect| effect.id == id);
        for member in space.members.iter_mut().filter(|member| !is_in_model(member.id())) {
            member.part = Part::Nuisance;
        }
        let start = space.place(|member| member.start.clone());
        let robust =
            Robust::at(&whitening.rows(), &whitening.whiten_residuals(&space.residuals(&start)?));
        let mut problem = Problem::new(space, whitening, robust);
        let minimum = problem.settle(start, None, Exactness::Sum)?;
        let (before, n_own) = (minimum.clone(), problem.space.members.len());
        Ok(Self { observations, model, problem, before, minimum, dropped: Vec::new(), n_own })
    }

    /// The same under another covariance.
    ///
    /// # Errors
    /// As a descent.
    pub(crate) fn rewhitened<'b>(
        &self,
        whitening: &'b Whitening,
    ) -> Result<Refit<'b>, DiagnosisError>
    where
        'a: 'b,
    {
        self.settled_under(whitening, Exactness::Sum)
    }

    /// The same to a hundredth of what the sum falls there.
    ///
    /// # Errors
    /// As a descent.
    pub(crate) fn roughly_rewhitened<'b>(
        &self,
        whitening: &'b Whitening,
    ) -> Result<Refit<'b>, DiagnosisError>
    where
        'a: 'b,
    {
        self.settled_under(whitening, Exactness::Rough)
    }

    fn settled_under<'b>(
        &self,
        whitening: &'b Whitening,
        exactness: Exactness,
    ) -> Result<Refit<'b>, DiagnosisError>
    where
        'a: 'b,
    {
        let slopes = self.problem.whitening.rewhitened(&self.minimum.whole, whitening);
        let mut problem: Problem<'b> = self.problem.clone();
        problem.whitening = whitening;
        let minimum = problem.settle(self.minimum.at.x.clone(), Some(slopes), exactness)?;
        let (observations, model, before) = (self.observations, self.model, minimum.clone());
        let (dropped, n_own) = (self.dropped.clone(), self.n_own);
        Ok(Refit { observations, model, problem, before, minimum, dropped, n_own })
    }

    /// The minimum without some of the effects that were asked for.
    ///
    /// # Errors
    /// As a descent.
    pub(crate) fn without(&self, ids: &[&'static str]) -> Result<Self, DiagnosisError> {
        self.settled_without(ids, Exactness::Sum)
    }

    /// The same to a hundredth of what the sum falls there without them.
    ///
    /// # Errors
    /// As a descent.
    pub(crate) fn roughly_without(&self, ids: &[&'static str]) -> Result<Self, DiagnosisError> {
        self.settled_without(ids, Exactness::Rough)
    }

    fn settled_without(
        &self,
        ids: &[&'static str],
        exactness: Exactness,
    ) -> Result<Self, DiagnosisError> {
        let (mut problem, x, slopes) = self.lacking(ids);
        let minimum = problem.settle(x, Some(slopes), exactness)?;
        Ok(self.taken_out(ids, problem, minimum))
    }

    /// The same by the weights of now, for comparisons by them.
    ///
    /// # Errors
    /// As a descent.
    pub(crate) fn briefly_without(&self, ids: &[&'static str]) -> Result<Self, DiagnosisError> {
        let (problem, x, slopes) = self.lacking(ids);
        let at = problem.stand(x)?;
        let (first, exactness) = (at.value, Exactness::Rough);
        let start = Start { at, slopes: Some(slopes), exactness };
        let mut minimum = problem.descend_briefly(start, BRIEF)?;
        if !problem.is_near(minimum.decrement, first - minimum.at.value) {
            let Minimum { at, whole, .. } = minimum;
            minimum = problem.descend(Start { at, slopes: Some(whole), exactness })?;
        }
        Ok(self.taken_out(ids, problem, minimum))
    }

    /// The start of a descent without some effects, with them at "off", and the slopes that are known there.
    fn lacking(&self, ids: &[&'static str]) -> (Problem<'a>, Vec<f64>, DMatrix<f64>) {
        let mut problem = self.problem.clone();
        let known = problem.moved();
        for own in ids.iter().filter_map(|id| problem.space.numbers_of(id)) {
            problem.frozen[own].fill(true);
        }
        let moved = problem.moved();
        let kept: Vec<usize> = (0..known.len()).filter(|k| moved.contains(&known[*k])).collect();
        let slopes = self.minimum.whole.select_columns(&kept);
        let x = self.place_with(|id| ids.contains(&id), |member| member.off.clone());
        (problem, x, slopes)
    }

    fn taken_out(&self, ids: &[&'static str], problem: Problem<'a>, minimum: Minimum) -> Self {
        let added = problem.space.members.iter().skip(self.n_own).map(|member| member.id());
        let dropped = added.filter(|id| ids.contains(id)).chain(self.dropped.iter().copied());
        let dropped = dropped.collect();
        Self { problem, before: minimum.clone(), minimum, dropped, ..*self }
    }

    /// What the sum would rise by without an effect, by the quadratic at the minimum; 0 where a bound holds
    /// one of its numbers.
    pub(crate) fn promised_without(&self, id: &str) -> f64 {
        let Minimum { at, moved, curvature, .. } = &self.minimum;
        let Some(own) = self.problem.space.numbers_of(id) else { return 0.0 };
        let off = self.place_with(|other| other == id, |member| member.off.clone());
        let columns: Option<Vec<usize>> =
            own.clone().map(|k| moved.iter().position(|other| *other == k)).collect();
        let covariance = curvature.clone().cholesky().map(|factor| factor.inverse());
        let (Some(columns), Some(covariance)) = (columns, covariance) else { return 0.0 };
        let own_covariance = covariance.select_rows(&columns).select_columns(&columns);
        let away = DVector::from_iterator(columns.len(), own.map(|k| at.x[k] - off[k]));
        own_covariance.cholesky().map_or(0.0, |factor| away.dot(&factor.solve(&away)))
    }

    /// The same minimum, found as exactly as predictions allow, with the slopes there.
    ///
    /// # Errors
    /// As a descent.
    pub(crate) fn settled(mut self) -> Result<Self, DiagnosisError> {
        self.minimum = {
            let Minimum { at, whole, .. } = self.minimum;
            self.problem.settle(at.x, Some(whole), Exactness::Estimates)?
        };
        Ok(self)
    }

    /// The same minimum, at which some of the nuisances are asked for.
    pub(crate) fn asking(&self, ids: &[&'static str]) -> Self {
        self.with_part(ids, Part::Asked)
    }

    /// The same minimum, at which a number that was asked for is a nuisance.
    pub(crate) fn not_asking(&self, id: &'static str) -> Self {
        self.with_part(&[id], Part::Nuisance)
    }

    fn with_part(&self, ids: &[&'static str], part: Part) -> Self {
        let mut other = self.clone();
        let members = &mut other.problem.space.members;
        members.iter_mut().filter(|member| ids.contains(&member.id())).for_each(|member| {
            member.part = part;
        });
        other
    }

    /// What is minimised: squares of whitened residuals with a say of their own, and of priors.
    pub(crate) fn objective(&self) -> f64 {
        self.minimum.at.value
    }

    /// The same with the say that residuals have in another model of the same covariance: sums with
    /// thresholds of their own cannot be compared.
    pub(crate) fn misfit_by(&self, other: &Self) -> f64 {
        other.problem.robust.value(&self.minimum.at.z)
    }

    /// Typical whitened residual of a push, at least 1.
    pub(crate) fn scale(&self) -> f64 {
        self.problem.robust.scale()
    }

    /// The root mean square difference of each number between two predictions of the same steps, over
    /// the standard deviation of its noise: the largest.
    pub(super) fn difference(&self, one: &[[f64; 7]], other: &[[f64; 7]]) -> f64 {
        let mut sums = [(0.0, 0_usize); Channels::NAMES.len()];
        for (step, number, sd) in self.problem.whitening.sd() {
            let change = (one[step][number] - other[step][number]) / sd;
            sums[number].0 += change * change;
            sums[number].1 += 1;
        }
        let rms = sums.into_iter().map(|(sum, n)| (sum / n.max(1) as f64).sqrt());
        rms.fold(0.0, f64::max)
    }

    /// The nominal set-up.
    pub(crate) fn rig(&self) -> effects::Rig {
        self.problem.space.rig()
    }

    /// Where an effect stands, if it is moved.
    pub(crate) fn values_of(&self, id: &str) -> Option<Vec<f64>> {
        let mut members = self.problem.space.shares(&self.minimum.at.x);
        members.find(|(member, _)| member.id() == id).map(|(member, own)| member.values(own))
    }

    /// Whether an effect is moved as a nuisance.
    pub(crate) fn has(&self, id: &str) -> bool {
        self.problem.space.numbers_of(id).is_some()
    }

    /// What the values of one effect change against others, with all else where it is.
    ///
    /// # Errors
    /// What a prediction refuses.
    pub(crate) fn size_against(&self, id: &str, values: &[f64]) -> Result<f64, DiagnosisError> {
        let x = self.place_with(|other| other == id, |_| values.to_vec());
        let space = &self.problem.space;
        Ok(self.difference(&space.residuals(&self.minimum.at.x)?, &space.residuals(&x)?))
    }

    /// How far each push's numbers change at most between other values of one effect and those here, over the
    /// standard deviation of their noise.
    ///
    /// # Errors
    /// What a prediction refuses.
    pub(crate) fn change_of_pushes(
        &self,
        id: &str,
        values: &[f64],
    ) -> Result<Vec<f64>, DiagnosisError> {
        let x = self.place_with(|other| other == id, |_| values.to_vec());
        let space = &self.problem.space;
        let (one, other) = (space.residuals(&self.minimum.at.x)?, space.residuals(&x)?);
        let mut largest: Vec<f64> = vec![0.0; self.observations.pushes.len()];
        for (step, number, sd) in self.problem.whitening.sd() {
            let push = self.observations.push_of[step];
            let change = (one[step][number] - other[step][number]).abs() / sd;
            largest[push] = largest[push].max(change);
        }
        Ok(largest)
    }

    /// The minimum's place with other values of some effects.
    pub(super) fn place_with(
        &self,
        is_other: impl Fn(&'static str) -> bool,
        values: impl Fn(&Member) -> Vec<f64>,
    ) -> Vec<f64> {
        let members = self.problem.space.shares(&self.minimum.at.x);
        let of = |(member, own): (&Member, &[f64])| match is_other(member.id()) {
            true => member.place(&values(member)),
            false => own.to_vec(),
        };
        members.flat_map(of).collect()
    }

    /// Each push's part of the sum when the numbers are fitted without its cluster, in one step; with
    /// the say that residuals have in `other`.
    ///
    /// # Errors
    /// `OneCluster` if the others leave a number open.
    pub(crate) fn left_out(&self, other: &Self) -> Result<Vec<f64>, DiagnosisError> {
        let Minimum { at, slopes, .. } = &self.minimum;
        let rows = self.problem.whitening.rows();
        let mut z = at.z.clone();
        for (cluster, pushes) in self.observations.pushes_of_clusters().iter().enumerate() {
            let rows: Vec<usize> = pushes.iter().flat_map(|push| rows[*push].clone()).collect();
            let without = self.problem.without(&self.minimum, pushes);
            let without = without.ok_or_else(|| self.observations.alone_determines(cluster))?;
            match without.z {
                Some(there) => rows.iter().for_each(|row| z[*row] = there[*row]),
                None => {
                    let change = slopes.select_rows(&rows) * without.shift;
                    rows.iter().zip(change.iter()).for_each(|(row, change)| z[*row] += change);
                }
            }
        }
        Ok(other.problem.robust.of_pushes(&z))
    }

    /// The model with what was asked for, and the same with its nuisances.
    ///
    /// # Errors
    /// `Flat`; `Model`.
    pub(crate) fn descriptions(&self) -> Result<[Description; 2], DiagnosisError> {
        let mut found = descriptions(&self.problem, &self.found(), self.observations, self.model)?;
        for description in &mut found {
            description.effects.retain(|effect| !self.dropped.contains(&effect.id.as_str()));
        }
        Ok(found)
    }

    /// Estimates that people read.
    ///
    /// # Errors
    /// As [`super::fit`].
    pub(crate) fn fit(&self, settings: &FitSettings) -> Result<Fit, DiagnosisError> {
        estimates(&self.problem, &self.found(), self.observations, self.model, settings)
    }

    fn found(&self) -> Found {
        Found { before: self.before.clone(), after: self.minimum.clone() }
    }
}

#[cfg(test)]
mod tests {
    use effects::by_id;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::Refit;
    use crate::synthetic::{NOISE, normal, pushed_with, recorded, white};
    use crate::{FitSettings, Predictions};

    #[test]
    fn what_an_effect_is_missed_by_is_promised_and_found_briefly() {
        let id = "table-tilt";
        // From hardly there to a common size, in m/s².
        for size in [0.003, 0.01, 0.05] {
            let (observations, model, _) = pushed_with((id, &[size, 0.0]), 3);
            let whitening = white(&observations);
            let settings = FitSettings::default();
            let here = Refit::new(&observations, &model, &whitening, &settings).unwrap();
            let with = here.with(&here.trial(by_id(id).unwrap()).unwrap()).unwrap();
            let rise = |without: &Refit| without.misfit_by(&with) - with.objective();
            let [exact, brief] =
                [with.without(&[id]).unwrap(), with.briefly_without(&[id]).unwrap()];
            let (exact, brief, promised) = (rise(&exact), rise(&brief), with.promised_without(id));
            assert!((brief - exact).abs() < 1.0 + 0.1 * exact, "{size}: {brief} for {exact}");
            let ratio = (1.0 + promised) / (1.0 + exact);
            assert!(ratio > 0.5 && ratio < 5.0, "{size}: {promised} for {exact}");
        }
    }

    #[test]
    fn a_number_that_is_asked_for_no_more_stays_where_it_is_and_open() {
        let id = "pressure-radius";
        let (observations, model, _) = pushed_with((id, &[1.2]), 3);
        let (whitening, settings) = (white(&observations), FitSettings::default());
        let here = Refit::new(&observations, &model, &whitening, &settings).unwrap();
        let again = here.asking(&[id]).not_asking(id);
        assert_eq!(again.objective(), here.objective());
        let nuisance = |of: &Refit| {
            let fit = of.fit(&settings).unwrap();
            assert!(fit.effects.iter().all(|effect| effect.id != id));
            fit.nuisances.iter().find(|one| one.id == id).map(|one| one.value).unwrap()
        };
        assert_eq!(nuisance(&again), nuisance(&here));
        assert!((nuisance(&again) - 1.2).abs() < 0.05, "{}", nuisance(&again));
    }

    #[test]
    fn a_model_refitted_as_it_is_loses_nothing_by_the_same_thresholds() {
        let (mut observations, model) = recorded(1);
        let predicted = Predictions::of(&model, &[], &observations).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let push_of = observations.push_of.clone();
        let steps = observations.steps.iter_mut().zip(predicted.steps());
        for ((step, predicted), push) in steps.zip(push_of) {
            // Twice the noise that is expected, and every fourth push far off.
            let sd = if push % 4 == 0 { 40.0 } else { 2.0 };
            for (number, value) in step.observed.iter_mut().enumerate() {
                let made = predicted[number].map(|at| at + sd * NOISE[number] * normal(&mut rng));
                *value = value.and(made);
            }
        }
        let whitening = white(&observations);
        let settings = FitSettings::default();
        let here = Refit::new(&observations, &model, &whitening, &settings).unwrap();
        let again = here.without(&[]).unwrap();
        let loss = again.misfit_by(&here) - here.objective();
        assert!(loss.abs() < 1.0, "{loss}");
        // Thresholds of their own make as much of it as an effect would.
        let apparent = again.objective() - here.objective();
        assert!(apparent.abs() > 20.0, "{apparent}");
    }
}
