//! What a model says of observed steps.

use effects::Effect;
use models::{
    Analytical, Base, ChannelModel, CharacteristicLength, Description, Estimate, ModelError, Noise,
};

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
        own: &[&'static dyn Effect],
        observations: &Observations,
    ) -> Result<Self, DiagnosisError> {
        match &model.base {
            Base::Analytical(base) => Self::of_analytical(model, base, own, observations),
            _ => Self::of_learnt(model, own, observations),
        }
    }

    fn of_analytical(
        model: &Description,
        base: &Analytical,
        own: &[&'static dyn Effect],
        observations: &Observations,
    ) -> Result<Self, DiagnosisError> {
        let predict = |model: &Description| -> Result<Vec<[f64; 7]>, ModelError> {
            let model = ChannelModel::new(model, observations.support, own)?;
            let channels = model.predict(observations.steps.iter().map(|step| &step.input))?;
            Ok(channels.iter().map(effects::Channels::to_array).collect())
        };
        let values = predict(model)?;
        let mut variances = vec![[0.0; 7]; values.len()];
        for ends in secants(model, base) {
            // A value at the end of its range has a secant on one side alone.
            let [low, high] = ends.map(|end| predict(&end?));
            let (low, high, width) = match (low, high) {
                (Ok(low), Ok(high)) => (low, high, 2.0),
                (Ok(low), Err(_)) => (low, values.clone(), 1.0),
                (Err(_), Ok(high)) => (values.clone(), high, 1.0),
                (Err(error), Err(_)) => return Err(error.into()),
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
        own: &[&'static dyn Effect],
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

/// The model with each of its uncertain parameters a standard error lower and higher.
fn secants(model: &Description, base: &Analytical) -> Vec<[Result<Description, ModelError>; 2]> {
    let mut ends = Vec::new();
    let moved = |estimate: &Estimate, sign: f64| Estimate {
        value: estimate.value + sign * estimate.se,
        ..estimate.clone()
    };
    let surface = base.surface();
    let with_base = |friction: Estimate, length: CharacteristicLength| {
        let base = Analytical::new(friction, length, *base.scatter())?;
        let base = base.with_surface(surface)?;
        Ok(Description { base: Base::Analytical(base), ..model.clone() })
    };
    let friction = base.pusher_friction();
    if friction.se > 0.0 {
        ends.push([-1.0, 1.0].map(|sign| with_base(moved(friction, sign), base.length().clone())));
    }
    if let CharacteristicLength::Given(length) = base.length()
        && length.se > 0.0
    {
        let given = |sign| CharacteristicLength::Given(moved(length, sign));
        ends.push([-1.0, 1.0].map(|sign| with_base(friction.clone(), given(sign))));
    }
    for (index, effect) in model.effects.iter().enumerate() {
        for (name, estimate) in effect.parameters.iter().filter(|(_, known)| known.se > 0.0) {
            let end = |sign: f64| {
                let mut model = model.clone();
                model.effects[index].parameters.insert(name.clone(), moved(estimate, sign));
                Ok(model)
            };
            ends.push([end(-1.0), end(1.0)]);
        }
    }
    ends
}
