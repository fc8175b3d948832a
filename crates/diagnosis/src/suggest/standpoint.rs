//! A model as fitted to the pushes so far, and the numbers of it that stay free.

use std::sync::Arc;

use effects::{Effect, Role, by_id_with};
use models::Description;
use nalgebra::DMatrix;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::SuggestSettings;
use crate::predict::candidates::Candidates;
use crate::predict::error_shapes::push_directions;
use crate::predict::secants::{Direction, Linearisation};
use crate::{
    DiagnosisError, FitSettings, NoiseModel, Observations, Tolerances, Whitening, fit_with_noise,
};

/// A model with effects, refitted, and its free numbers.
#[derive(Clone, Debug)]
pub(super) struct Standpoint {
    /// With the nuisances at their estimates.
    pub(super) description: Description,
    /// What stays free, and then effects that the model does not have.
    pub(super) free: Vec<Free>,
    own: Vec<Arc<dyn Effect>>,
}

/// A number that stays free.
#[derive(Clone, Debug)]
pub(super) struct Free {
    pub(super) effect: &'static str,
    pub(super) name: &'static str,
    pub(super) unit: &'static str,
    pub(super) direction: Direction,
    /// What is believed of it beforehand: standard deviation.
    pub(super) prior_sd: f64,
}

/// A standpoint's predictions of some steps, with whitened slopes a push.
pub(super) struct View {
    pub(super) predicted: Vec<[f64; 7]>,
    pub(super) whitening: Whitening,
    /// Times the prior's standard deviation; a row for each number of the push.
    pub(super) slopes: Vec<DMatrix<f64>>,
}

impl Standpoint {
    /// The model with some effects, fitted.
    ///
    /// # Errors
    /// Those of fits.
    pub(super) fn fitted(
        observations: &Observations,
        model: &Description,
        ids: &[&str],
        noise: &NoiseModel,
        settings: &SuggestSettings,
    ) -> Result<Self, DiagnosisError> {
        let (own, tolerances) = (settings.own.clone(), settings.tolerances);
        let known = FitSettings { own: own.clone(), tolerances, ..FitSettings::default() };
        let fit_settings = FitSettings { resemblances: false, ..known };
        let fit = fit_with_noise(observations, model, ids, noise, &fit_settings)?;
        let description = fit.with_nuisances;
        let candidates = Candidates::of(&description, &own, observations)?;
        let free = free(&candidates, &tolerances);
        Ok(Self { description, free, own })
    }

    /// The same with a view on some effects that it does not have.
    ///
    /// # Errors
    /// `Model` for an effect that nobody knows.
    pub(super) fn with_absent(
        &self,
        ids: &[String],
        all: &Observations,
    ) -> Result<Self, DiagnosisError> {
        let mut other = self.clone();
        let candidates = Candidates::of(&self.description, &self.own, all)?;
        for id in ids {
            let effect = by_id_with(id, &self.own).map_err(models::ModelError::from)?;
            let id = effect.info().id;
            if other.free.iter().any(|free| free.effect == id) {
                continue;
            }
            let found = candidates.effects.iter().find(|one| one.effect.info().id == id);
            let numbers = found.map_or(0..0, |one| one.coordinates.clone());
            other
                .free
                .extend(numbers.map(|k| numbered(&candidates, id, k, candidates.prior_sd[k])));
        }
        Ok(other)
    }

    /// How some steps look from here.
    ///
    /// # Errors
    /// What the model refuses.
    pub(super) fn view(
        &self,
        observations: &Observations,
        noise: &NoiseModel,
    ) -> Result<View, DiagnosisError> {
        let of_push = push_directions(&self.description)?;
        let directions: Vec<Direction> =
            of_push.iter().chain(self.free.iter().map(|free| &free.direction)).cloned().collect();
        let linearisation =
            Linearisation::of(&self.description, &self.own, observations, &directions)?;
        let whitening = noise.whitening_at(observations, &linearisation)?;
        let slopes = |push: usize| {
            let entries = whitening.entries(push);
            let columns = DMatrix::from_fn(entries.len(), self.free.len(), |row, k| {
                let (step, number) = entries[row];
                self.free[k].prior_sd * linearisation.slopes[of_push.len() + k][step][number]
            });
            whitening.whiten_columns(push, columns)
        };
        let slopes = (0..observations.pushes.len()).into_par_iter().map(slopes).collect();
        Ok(View { predicted: linearisation.predicted, whitening, slopes })
    }
}

/// The numbers of effects in the model, and of those that no manifest knows exactly; not switches.
fn free(candidates: &Candidates, tolerances: &Tolerances) -> Vec<Free> {
    let mut free = Vec::new();
    for candidate in &candidates.effects {
        let about = candidate.effect.info();
        let tolerance = tolerances.of(about);
        if tolerance.is_none() && !candidate.is_in_model {
            continue;
        }
        for k in candidate.coordinates.clone() {
            let coordinate = candidates.directions[k].coordinate;
            if about.parameters[coordinate].role != Role::Switch {
                let known = tolerance.filter(|tolerance| tolerance.is_finite());
                let prior_sd = known.unwrap_or(candidates.prior_sd[k]);
                free.push(numbered(candidates, about.id, k, prior_sd));
            }
        }
    }
    free
}

fn numbered(candidates: &Candidates, effect: &'static str, k: usize, prior_sd: f64) -> Free {
    let ((name, unit), direction) = (candidates.names[k], candidates.directions[k].clone());
    Free { effect, name, unit, direction, prior_sd }
}
