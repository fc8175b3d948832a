//! What a model says of observed steps.

use std::sync::Arc;

use effects::Effect;
use models::{Base, ChannelModel, Description, Noise, StepInput};
use planar::Shape;

use crate::{DiagnosisError, Observations};

/// The numbers of [`effects::Channels`] for each step; none where a learnt model has no answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Predictions {
    pub(crate) values: Vec<[Option<f64>; 7]>,
}

impl Predictions {
    /// The predictions of a model, all channels or, for a learnt one, the motion; `own` are effects
    /// besides those of the catalogue.
    ///
    /// # Errors
    /// `Model` for what the model refuses.
    pub fn of(
        model: &Description,
        own: &[&'static dyn Effect],
        observations: &Observations,
    ) -> Result<Self, DiagnosisError> {
        let values = match model.base {
            Base::Analytical(_) => {
                let model = ChannelModel::new(model, observations.support, own)?;
                let inputs = observations.steps.iter().map(|step| &step.input);
                let channels = model.predict(inputs)?;
                channels.iter().map(|channels| channels.to_array().map(Some)).collect()
            }
            _ => {
                let inputs = motion_inputs(observations)?;
                let predicted = model.build()?.predict(&inputs, Noise::Excluded)?;
                let motion = |mean: nalgebra::Vector3<f64>| {
                    let mut values = [None; 7];
                    for (value, number) in values.iter_mut().zip(mean.iter()) {
                        *value = Some(*number);
                    }
                    values
                };
                predicted.iter().map(|prediction| motion(prediction.mean)).collect()
            }
        };
        Ok(Self { values })
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

fn motion_inputs(observations: &Observations) -> Result<Vec<StepInput>, DiagnosisError> {
    let mut shape: Option<Arc<Shape>> = None;
    let input = |step: &models::ChannelObservation| {
        let effects::StepInput { object, pusher_radius, pose_wb, track, .. } = &step.input;
        let shape = match &shape {
            Some(shape) if **shape == *object.shape() => shape.clone(),
            _ => shape.insert(Arc::new(object.shape().clone())).clone(),
        };
        Ok(StepInput::between(shape, *pusher_radius, pose_wb, &track.start(), &track.end())?)
    };
    observations.steps.iter().map(input).collect()
}
