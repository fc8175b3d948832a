//! A model of pushing: a rig and the effects it carries.

use std::sync::Arc;

use planar::{Pose, Wrench};

use crate::catalogue::{all, by_id_with};
use crate::effect::setting::Setting;
use crate::effect::{Effect, IntoEffect, Sliding, Snapshot, Stage};
use crate::object::spots::Spots;
use crate::{
    ContactLaw, EffectError, Geometry, MeasurementModel, Object, Rig, StepInput, Support,
    TrueOutline,
};

/// The prediction of all channels of a step, by a rig with any set of effects.
///
/// Effects act in the order of the catalogue, and those of users after them by id, whatever the
/// order in which they were added: the same set gives the same bits.
#[derive(Clone, Debug)]
pub struct PushPhysics {
    rig: Rig,
    effects: Vec<(Arc<dyn Effect>, Vec<f64>)>,
    /// For each stage, the indices of the effects that act there.
    at_stage: [Vec<usize>; Stage::ALL.len()],
}

impl PushPhysics {
    /// The rig alone.
    pub fn new(rig: Rig) -> Self {
        Self { rig, effects: Vec::new(), at_stage: Default::default() }
    }

    /// The same model with one more effect; `values` in the order of its parameters.
    ///
    /// # Errors
    /// `DuplicateEffect` if the model has it already; `WrongCount`, `OutOfRange`, `NotASwitch` for its values.
    pub fn with(mut self, effect: impl IntoEffect, values: &[f64]) -> Result<Self, EffectError> {
        let effect = effect.into_effect();
        let about = effect.info();
        about.check(values)?;
        if self.effects.iter().any(|(other, _)| other.info().id == about.id) {
            return Err(EffectError::DuplicateEffect { effect: about.id.to_owned() });
        }
        self.effects.push((effect, values.to_vec()));
        self.effects.sort_by_key(|(effect, _)| place(effect.info().id));
        for (stage, indices) in Stage::ALL.into_iter().zip(&mut self.at_stage) {
            let acts = |index: &usize| self.effects[*index].0.info().stages.contains(&stage);
            *indices = (0..self.effects.len()).filter(acts).collect();
        }
        Ok(self)
    }

    /// The same model with other values for an effect that it has.
    ///
    /// # Errors
    /// `UnknownEffect` if it has no such effect; those of its values.
    pub fn set(&mut self, id: &str, values: &[f64]) -> Result<(), EffectError> {
        let ids: Vec<_> = self.effects.iter().map(|(effect, _)| effect.info().id).collect();
        let found = self.effects.iter_mut().find(|(effect, _)| effect.info().id == id);
        let (effect, old) = found.ok_or_else(|| EffectError::UnknownEffect {
            id: id.to_owned(),
            known: ids.join(", "),
        })?;
        effect.info().check(values)?;
        old.copy_from_slice(values);
        Ok(())
    }

    /// A model from what a file says: ids and named parameters.
    ///
    /// `own` are effects besides those of the catalogue.
    ///
    /// # Errors
    /// `UnknownEffect`, `WrongParameter`, and those of [`PushPhysics::with`].
    pub fn from_settings(
        rig: Rig,
        settings: &[Setting],
        own: &[Arc<dyn Effect>],
    ) -> Result<Self, EffectError> {
        settings.iter().try_fold(Self::new(rig), |model, setting| {
            let effect = by_id_with(&setting.id, own)?;
            let values = setting.values(effect.info())?;
            model.with(effect, &values)
        })
    }

    /// What a file says of the effects, in the order in which they act.
    pub fn settings(&self) -> Vec<Setting> {
        self.effects.iter().map(|(effect, values)| Setting::new(effect.info(), values)).collect()
    }

    /// The effects with their values, in the order in which they act.
    pub fn effects(&self) -> &[(Arc<dyn Effect>, Vec<f64>)] {
        &self.effects
    }

    /// The nominal set-up.
    pub fn rig(&self) -> &Rig {
        &self.rig
    }

    /// Outline and pusher of a step, where the effects say that they are not as stated.
    ///
    /// # Errors
    /// `TooRound` for corners that do not fit on the outline.
    pub fn true_outline(&self, step: &StepInput) -> Result<TrueOutline, EffectError> {
        TrueOutline::new(step, self.geometry(step), &self.measurement(step))
    }

    pub(crate) fn acts_at(&self, stage: Stage) -> bool {
        !self.at_stage[stage as usize].is_empty()
    }

    fn at(&self, stage: Stage) -> impl Iterator<Item = (&dyn Effect, &[f64])> {
        self.at_stage[stage as usize].iter().map(|&index| {
            let (effect, values) = &self.effects[index];
            (effect.as_ref(), values.as_slice())
        })
    }

    pub(crate) fn measurement(&self, step: &StepInput) -> MeasurementModel {
        let mut model = MeasurementModel::default();
        self.at(Stage::Measurement).for_each(|(e, values)| e.measurement(values, step, &mut model));
        model
    }

    pub(crate) fn geometry(&self, step: &StepInput) -> Geometry {
        let mut geometry = Geometry::default();
        self.at(Stage::Geometry).for_each(|(e, values)| e.geometry(values, step, &mut geometry));
        geometry
    }

    pub(crate) fn contact(&self, step: &StepInput, pose_wo: &Pose) -> ContactLaw {
        let moment = Snapshot { rig: &self.rig, step, pose_wo: *pose_wo, time: 0.0 };
        let mut law = ContactLaw::rigid(self.rig.pusher_friction());
        self.at(Stage::Contact).for_each(|(e, values)| e.contact(values, &moment, &mut law));
        law
    }

    /// What the effects say an object rests on besides its area.
    ///
    /// # Errors
    /// `InvalidValue`.
    pub(crate) fn spots(&self, object: &Object) -> Result<Option<Spots>, EffectError> {
        if !self.acts_at(Stage::Pressure) {
            return Ok(None);
        }
        let mut spots = Vec::new();
        self.at(Stage::Pressure).for_each(|(e, values)| e.spots(values, object, &mut spots));
        Spots::new(&spots, object.centroid(), object.mean_distance())
    }

    pub(crate) fn support(&self, moment: &Snapshot<'_>) -> Support {
        let mut support = Support::nominal(self.rig.support_friction(), self.rig.surface_shape());
        self.at(Stage::Support).for_each(|(e, values)| e.support(values, moment, &mut support));
        support
    }

    pub(crate) fn local_friction(&self, sliding: &Sliding) -> f64 {
        self.at(Stage::Local).map(|(e, values)| e.local_friction(values, sliding)).sum()
    }

    /// The surplus with its growth by the logarithm of speed.
    pub(crate) fn local_friction_and_growth(&self, sliding: &Sliding) -> (f64, f64) {
        self.at(Stage::Local).fold((0.0, 0.0), |(sum, growth), (e, values)| {
            let surplus = e.local_friction(values, sliding);
            (sum + surplus, growth + e.local_growth(values, sliding, surplus))
        })
    }

    pub(crate) fn load(&self, moment: &Snapshot<'_>) -> Wrench {
        let mut load_w = Wrench::default();
        self.at(Stage::Load).for_each(|(e, values)| e.load(values, moment, &mut load_w));
        load_w
    }

    pub(crate) fn has_inertia(&self) -> bool {
        self.at(Stage::Dynamics).any(|(e, values)| e.has_inertia(values))
    }
}

/// Order of action: the catalogue's, then that of ids.
fn place(id: &'static str) -> (usize, &'static str) {
    let index = all().iter().position(|effect| effect.info().id == id);
    (index.unwrap_or(usize::MAX), id)
}
