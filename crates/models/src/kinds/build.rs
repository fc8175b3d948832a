//! From a description to the model.

use std::sync::Arc;

use dataset::SupportSpec;
use effects::Effect;

use crate::kinds::physics::PhysicsModel;
use crate::physics::Physics;
use crate::{Base, Description, GpPushModel, Hybrid, ModelError, PushModel, Setup};

impl Description {
    /// Builds the model of the motion alone.
    ///
    /// # Errors
    /// `EffectsNeedMore` for a model with effects: an analytical one predicts with them as a
    /// [`crate::ChannelModel`], a hybrid as [`Description::build_in`] builds it; `NoWeights`, or
    /// `Gp` for weights that are not usable.
    pub fn build(&self) -> Result<Box<dyn PushModel>, ModelError> {
        self.built(None)
    }

    /// Builds the model in a set-up, which the effects of a hybrid act in; `own` are effects besides
    /// the catalogue's. Such a hybrid is asked about whole steps ([`crate::StepInput::of`]).
    ///
    /// # Errors
    /// As [`Description::build`].
    pub fn build_in(
        &self,
        support: SupportSpec,
        own: &[Arc<dyn Effect>],
    ) -> Result<Box<dyn PushModel>, ModelError> {
        self.built(Some(Setup { support, own: own.to_vec() }))
    }

    fn built(&self, setup: Option<Setup>) -> Result<Box<dyn PushModel>, ModelError> {
        let weights = || self.weights.as_ref().ok_or(ModelError::NoWeights);
        Ok(match &self.base {
            Base::Analytical(analytical) if self.effects.is_empty() => Box::new(analytical.clone()),
            Base::Analytical(analytical) if setup.is_some() => {
                let effects = self.effects.clone();
                Box::new(PhysicsModel(Physics::new(analytical.clone(), effects, setup)?))
            }
            Base::Analytical(_) => {
                let ids: Vec<_> = self.effects.iter().map(|effect| effect.id.as_str()).collect();
                return Err(ModelError::EffectsNeedMore { effects: ids.join(", ") });
            }
            Base::Process(_) => Box::new(GpPushModel::from_weights(weights()?)?),
            Base::Hybrid(analytical) => {
                let physics = Physics::new(analytical.clone(), self.effects.clone(), setup)?;
                Box::new(Hybrid::from_weights(physics, weights()?)?)
            }
        })
    }
}
