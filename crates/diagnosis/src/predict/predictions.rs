//! What a model says of observed steps.

use std::sync::Arc;

use effects::{Effect, by_id_with};
use models::{
    Analytical, Base, ChannelModel, CharacteristicLength, Description, Estimate, ModelError, Noise,
};
use rayon::iter::ParallelIterator;
use rayon::slice::ParallelSlice;

use crate::{DiagnosisError, Observations};

/// The numbers of [`effects::Channels`] for each step; none where a learnt model has no answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Predictions {
    pub(crate) values: Vec<[Option<f64>; 7]>,
    /// Of an observation about its value, where the model claims one.
    pub(crate) variances: Vec<[Option<f64>; 7]>,
}

impl Predictions {
    /// The predictions of a model, all channels or, for a learnt one, the motion; `own` are effects
    /// besides those of the catalogue.
    ///
    /// A variance is what the model itself claims: of a learnt one its posterior with noise, of an
    /// analytical one with fitted scatter that scatter, and what the standard errors of its
    /// parameters leave open (as if they were independent, by secants over ± one).
    ///
    /// # Errors
    /// `Model` for what the model refuses.
    pub fn of(
        model: &Description,
        own: &[Arc<dyn Effect>],
        observations: &Observations,
    ) -> Result<Self, DiagnosisError> {
        match &model.base {
            Base::Analytical(base) => Self::of_analytical(model, base, own, observations),
            _ => Self::of_learnt(model, own, observations),
        }
    }

    /// The same without variances of an analytical model, whose number of predictions grows with its parameters.
    ///
    /// # Errors
    /// As [`Predictions::of`].
    pub(crate) fn expected(
        model: &Description,
        own: &[Arc<dyn Effect>],
        observations: &Observations,
    ) -> Result<Self, DiagnosisError> {
        match &model.base {
            Base::Analytical(_) => Ok(Self::of_channels(&channels(model, own, observations)?)),
            _ => Self::of_learnt(model, own, observations),
        }
    }

    /// All numbers of each step, without variances.
    pub(crate) fn of_channels(values: &[[f64; 7]]) -> Self {
        let values: Vec<_> = values.iter().map(|values| values.map(Some)).collect();
        Self { variances: vec![[None; 7]; values.len()], values }
    }

    /// The same with means of the noise added, one for each step; themselves where it has none.
    pub(crate) fn about(mut self, means: Option<&[[f64; 7]]>) -> Self {
        let Some(means) = means else { return self };
        for (values, mean) in self.values.iter_mut().zip(means) {
            *values = std::array::from_fn(|k| values[k].map(|value| value + mean[k]));
        }
        self
    }

    fn of_analytical(
        model: &Description,
        base: &Analytical,
        own: &[Arc<dyn Effect>],
        observations: &Observations,
    ) -> Result<Self, DiagnosisError> {
        let predict = |model: &Description| channels(model, own, observations);
        let values = predict(model)?;
        let mut variances = vec![[0.0; 7]; values.len()];
        for Uncertain { ends, widths } in uncertain(model, base, own)? {
            // The mechanics may refuse an end: then the secant is on one side alone.
            let [low, high] = ends.map(|end| predict(&end));
            let (low, high, width) = match (low, high) {
                (Ok(low), Ok(high)) => (low, high, widths[0] + widths[1]),
                (Ok(low), Err(_)) if widths[0] > 0.0 => (low, values.clone(), widths[0]),
                (Err(_), Ok(high)) if widths[1] > 0.0 => (values.clone(), high, widths[1]),
                // A number that nothing bounds says nothing of the prediction's width.
                _ => continue,
            };
            for (variance, (low, high)) in variances.iter_mut().zip(low.iter().zip(&high)) {
                (0..7).for_each(|k| variance[k] += ((high[k] - low[k]) / width).powi(2));
            }
        }
        // Standard errors without noise are no prediction of an observation.
        let claimed = |(step, own): (usize, &[f64; 7])| {
            let square = observations.way(step).powi(2);
            std::array::from_fn(|k| {
                let noise = if k < 3 { base.scatter()[(k, k)] * square } else { 0.0 };
                (noise > 0.0).then_some(own[k] + noise)
            })
        };
        Ok(Self {
            values: values.iter().map(|values| values.map(Some)).collect(),
            variances: variances.iter().enumerate().map(claimed).collect(),
        })
    }

    fn of_learnt(
        model: &Description,
        own: &[Arc<dyn Effect>],
        observations: &Observations,
    ) -> Result<Self, DiagnosisError> {
        let inputs = observations.motion_inputs()?;
        let model = model.build_in(observations.support, own)?;
        let predicted = model.predict(&inputs, Noise::Included)?;
        let motion = |values: [f64; 3]| std::array::from_fn(|k| values.get(k).copied());
        let variance = |k: usize, of: &models::StepPrediction| of.covariance[(k, k)];
        Ok(Self {
            values: predicted.iter().map(|of| motion(of.mean.into())).collect(),
            variances: predicted
                .iter()
                .map(|of| motion([variance(0, of), variance(1, of), variance(2, of)]))
                .collect(),
        })
    }

    /// The numbers of each step.
    pub fn steps(&self) -> &[[Option<f64>; 7]] {
        &self.values
    }

    /// Observed less predicted, where both are there.
    pub(crate) fn residuals(
        &self,
        observations: &Observations,
    ) -> Result<Vec<[Option<f64>; 7]>, DiagnosisError> {
        let (n_predictions, n_steps) = (self.values.len(), observations.n_steps());
        if n_predictions != n_steps {
            return Err(DiagnosisError::OtherSteps { n_predictions, n_steps });
        }
        let of = |(values, step): (&[Option<f64>; 7], &models::ChannelObservation)| {
            std::array::from_fn(|k| Some(step.observed[k]? - values[k]?))
        };
        Ok(self.values.iter().zip(&observations.steps).map(of).collect())
    }
}

/// The channels of each step by an analytical model.
fn channels(
    model: &Description,
    own: &[Arc<dyn Effect>],
    observations: &Observations,
) -> Result<Vec<[f64; 7]>, ModelError> {
    /// Steps that one worker predicts at a time.
    const AT_A_TIME: usize = 32;
    let model = ChannelModel::new(model, observations.support, own)?;
    let some = |steps: &[models::ChannelObservation]| {
        let channels = model.predict(steps.iter().map(|step| &step.input))?;
        Ok(channels.iter().map(effects::Channels::to_array).collect::<Vec<_>>())
    };
    let all = observations.steps.par_chunks(AT_A_TIME).map(some);
    Ok(all.collect::<Result<Vec<_>, ModelError>>()?.concat())
}

/// The model with one of its numbers a standard error lower and higher, or as far as its range goes.
struct Uncertain {
    ends: [Description; 2],
    /// How far the ends are, in standard errors.
    widths: [f64; 2],
}

/// One for each number of a model that has a standard error.
fn uncertain(
    model: &Description,
    base: &Analytical,
    own: &[Arc<dyn Effect>],
) -> Result<Vec<Uncertain>, ModelError> {
    let mut all = Vec::new();
    let with_base = |friction: Estimate, length: CharacteristicLength| {
        let moved = Analytical::new(friction, length, *base.scatter())?;
        let base = moved.with_surface(base.surface())?;
        Ok(Description { base: Base::Analytical(base), ..model.clone() })
    };
    let friction = base.pusher_friction();
    let of_friction = |moved| with_base(moved, base.length().clone());
    all.extend(Uncertain::of(friction, (0.0, f64::INFINITY), of_friction)?);
    if let CharacteristicLength::Given(length) = base.length() {
        let of_length = |moved| with_base(friction.clone(), CharacteristicLength::Given(moved));
        all.extend(Uncertain::of(length, (LEAST_LENGTH * length.value, f64::INFINITY), of_length)?);
    }
    for (index, effect) in model.effects.iter().enumerate() {
        let about = by_id_with(&effect.id, own)?.info();
        for parameter in about.parameters {
            let Some(estimate) = effect.parameters.get(parameter.name) else { continue };
            let of_effect = |moved| {
                let mut model = model.clone();
                model.effects[index].parameters.insert(parameter.name.to_owned(), moved);
                Ok(model)
            };
            all.extend(Uncertain::of(estimate, parameter.range, of_effect)?);
        }
    }
    Ok(all)
}

/// Least length of a secant's end, as a share of its value.
const LEAST_LENGTH: f64 = 0.1;

impl Uncertain {
    /// None for a number without a standard error.
    fn of(
        estimate: &Estimate,
        (least, most): (f64, f64),
        with: impl Fn(Estimate) -> Result<Description, ModelError>,
    ) -> Result<Option<Self>, ModelError> {
        let Estimate { value, se, .. } = *estimate;
        let [low, high] = [(value - se).max(least), (value + se).min(most)];
        if se <= 0.0 || high <= low {
            return Ok(None);
        }
        let moved = |value| with(Estimate { value, ..estimate.clone() });
        let widths = [(value - low) / se, (high - value) / se];
        Ok(Some(Self { ends: [moved(low)?, moved(high)?], widths }))
    }
}

impl Observations {
    /// The same steps as a model would have them, without noise: with its predictions in the place
    /// of what was observed. What it does not predict is not observed.
    #[must_use]
    pub fn as_predicted(&self, predictions: &Predictions) -> Self {
        let mut all = self.clone();
        for (step, predicted) in all.steps.iter_mut().zip(&predictions.values) {
            for (observed, predicted) in step.observed.iter_mut().zip(predicted) {
                *observed = observed.and(*predicted);
            }
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::{Predictions, uncertain};
    use crate::synthetic::made;
    use models::{Analytical, Base, Description, Estimate, ModelEffect, PushModel};
    use nalgebra::Matrix3;

    /// A model whose tilt is known to ± `se`, with scatter.
    fn tilted(se: f64) -> Description {
        let plain = Analytical::nominal(0.25).unwrap();
        let scatter = Matrix3::identity() * 1e-8;
        let friction = plain.pusher_friction().clone();
        let base = Analytical::new(friction, plain.length().clone(), scatter).unwrap();
        let mut model = base.describe().unwrap();
        let known = |value, se| Estimate { value, se, source: String::new() };
        let parameters = [("ax", known(0.05, se)), ("ay", known(0.0, 0.0))];
        let parameters = parameters.map(|(name, value)| (name.to_owned(), value)).into();
        model.effects = vec![ModelEffect::new("table-tilt", parameters)];
        model
    }

    fn widest(se: f64) -> f64 {
        let (observations, ..) = made(0, |_| 0.0);
        let found = Predictions::of(&tilted(se), &[], &observations).unwrap();
        let variances = found.variances.iter().map(|of| of[2].unwrap());
        variances.fold(0.0, f64::max)
    }

    #[test]
    fn what_is_not_well_known_widens_a_prediction() {
        let scatter = 1e-8 * 0.004_f64.powi(2);
        let [none, little, more] = [0.0, 0.001, 0.002].map(widest);
        assert!((none / scatter - 1.0).abs() < 1e-6, "{none}");
        assert!(((more - none) / (little - none) / 4.0 - 1.0).abs() < 0.05);
    }

    #[test]
    fn what_is_hardly_known_at_all_is_asked_within_its_range() {
        let model = tilted(1e3);
        let Base::Analytical(base) = &model.base else { unreachable!("it was made analytical") };
        let all = uncertain(&model, base, &[]).unwrap();
        let ends: Vec<f64> =
            all[0].ends.iter().map(|end| end.effects[0].parameters["ax"].value).collect();
        let (low, high) = effects::by_id("table-tilt").unwrap().info().parameters[0].range;
        assert_eq!((all.len(), ends), (1, vec![low, high]));
        assert!(widest(1e3).is_finite());
    }
}
