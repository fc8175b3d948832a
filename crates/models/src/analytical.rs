//! The analytical model: the quasi-static push on an ellipsoidal limit surface.

use mechanics::{Ellipsoid, PathSettings, Pusher, Slider, StraightPath, push_along};
use nalgebra::Matrix3;
use planar::Pose;
use serde::{Deserialize, Serialize};

use crate::error::{not_negative, positive};
use crate::{Base, Description, Estimate, ModelError, Noise, PushModel, StepInput, StepPrediction};

/// The quasi-static push of an object on an ellipsoid about its centroid, integrated over the step.
///
/// Two parameters: the pusher's friction μp, and the characteristic length c = Mmax/Fmax, which
/// follows from uniform pressure unless it is given.
#[derive(Clone, Debug, PartialEq)]
pub struct Analytical {
    pusher_friction: Estimate,
    length: CharacteristicLength,
    scatter: Matrix3<f64>,
}

/// Where the characteristic length c = Mmax/Fmax comes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum CharacteristicLength {
    /// The mean distance of the outline's area to its centroid.
    UniformPressure,
    /// A length for one object, in m.
    Given(Estimate),
}

impl Analytical {
    /// The nominal model: μp from the manifest, c from uniform pressure, no scatter.
    ///
    /// # Errors
    /// `InvalidValue` if μp is negative or not finite.
    pub fn nominal(pusher_friction: f64) -> Result<Self, ModelError> {
        Self::new(
            Estimate::exact(pusher_friction, "manifest"),
            CharacteristicLength::UniformPressure,
            Matrix3::zeros(),
        )
    }

    /// A model with the given parameters.
    ///
    /// `scatter` is the covariance of an observed step about the prediction, per meter of the
    /// pusher's way squared: for a way d the predicted covariance is d² · scatter.
    ///
    /// # Errors
    /// `InvalidValue` if μp or a variance is negative, c not positive, or one of them not finite.
    pub fn new(
        pusher_friction: Estimate,
        length: CharacteristicLength,
        scatter: Matrix3<f64>,
    ) -> Result<Self, ModelError> {
        not_negative("pusher friction", pusher_friction.value, "(dimensionless)")?;
        if let CharacteristicLength::Given(length) = &length {
            positive("characteristic length", length.value, "m")?;
        }
        for variance in scatter.diagonal().iter() {
            not_negative("variance of the scatter", *variance, "(m or rad per m)²")?;
        }
        Ok(Self { pusher_friction, length, scatter })
    }

    /// The coefficient of friction between pusher and object.
    pub fn pusher_friction(&self) -> &Estimate {
        &self.pusher_friction
    }

    /// Where c comes from.
    pub fn length(&self) -> &CharacteristicLength {
        &self.length
    }

    /// The covariance of an observed step about the prediction, per meter of way squared.
    pub fn scatter(&self) -> &Matrix3<f64> {
        &self.scatter
    }

    /// c for the object of a step, in m.
    pub fn characteristic_length(&self, step: &StepInput) -> f64 {
        match &self.length {
            CharacteristicLength::UniformPressure => {
                step.shape().mean_distance(&step.shape().centroid())
            }
            CharacteristicLength::Given(length) => length.value,
        }
    }

    /// The motion of B over the step, its end seen from its start.
    ///
    /// # Errors
    /// `Mechanics` for what the mechanics refuse.
    pub fn motion(&self, step: &StepInput) -> Result<Pose, ModelError> {
        let surface = Ellipsoid::new(1.0, self.characteristic_length(step))?;
        let center = step.shape().centroid();
        let slider = Slider {
            shape: step.shape(),
            surface: &surface,
            pose_bs: Pose::new(center.x, center.y, 0.0),
        };
        let pusher = Pusher { radius: step.pusher_radius(), friction: self.pusher_friction.value };
        // Quasi-static motion does not know time: the pusher moves at 1 m/s.
        let path = StraightPath {
            start_w: step.start_b(),
            velocity_w: step.direction_b(),
            duration: step.distance(),
        };
        let origin = Pose::new(0.0, 0.0, 0.0);
        Ok(push_along(&slider, &pusher, &path, &origin, &PathSettings::default())?.pose_wb)
    }
}

impl PushModel for Analytical {
    fn kind(&self) -> &'static str {
        "analytical"
    }

    fn predict(
        &self,
        steps: &[StepInput],
        noise: Noise,
    ) -> Result<Vec<StepPrediction>, ModelError> {
        let predict = |step: &StepInput| {
            let covariance = match noise {
                Noise::Included => self.scatter * step.distance().powi(2),
                Noise::Excluded => Matrix3::zeros(),
            };
            Ok(StepPrediction { mean: step.outputs(&self.motion(step)?), covariance })
        };
        steps.iter().map(predict).collect()
    }

    fn describe(&self) -> Result<Description, ModelError> {
        Ok(Description { base: Base::Analytical(self.clone()), weights: None })
    }
}
