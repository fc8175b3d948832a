//! A model of pushing: a rig and the effects it carries.

use std::sync::Arc;

use planar::{Pose, Wrench};

use crate::catalogue::{all, by_id_with};
use crate::effect::setting::Setting;
use crate::effect::{Effect, IntoEffect, Snapshot, Stage};
use crate::object::sliding::{LocalFriction, Sliding, SlidingPoints};
use crate::object::spots::Spots;
use crate::{
    ContactLaw, EffectError, Geometry, MeasurementModel, Object, Rig, Spread, StepInput, Support,
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
    /// Parameters that differ from push to push, each by its effect and its place there.
    pub(super) per_push: Vec<Varying>,
    /// The same from place to place.
    pub(super) per_place: Vec<Varying>,
    /// Share of the sub-steps that a step takes.
    share_of_substeps: f64,
}

/// A parameter that differs, by its effect and its place there.
type Varying = (&'static str, usize, Spread);

/// A parameter that differs by whatever reason: its spread over pushes and places together, and the share of
/// the variance that a push keeps.
pub(crate) struct Differing {
    varying: Varying,
    pub(crate) share_of_push: f64,
}

impl PushPhysics {
    /// The rig alone.
    pub fn new(rig: Rig) -> Self {
        Self {
            rig,
            effects: Vec::new(),
            at_stage: Default::default(),
            per_push: Vec::new(),
            per_place: Vec::new(),
            share_of_substeps: 1.0,
        }
    }

    /// The same model in half as many sub-steps, for differences of predictions: what sub-steps miss is
    /// nearly the same on both sides of a difference. What effects of typical sizes change is within a tenth of
    /// what it is in all sub-steps, but for a switch and a tip that sticks more at rest.
    #[must_use]
    pub fn in_half_the_substeps(mut self) -> Self {
        self.share_of_substeps = 0.5;
        self
    }

    pub(crate) fn share_of_substeps(&self) -> f64 {
        self.share_of_substeps
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

    /// The same model, in which a parameter of one of its effects differs from push to push.
    ///
    /// # Errors
    /// `UnknownEffect`, `UnknownParameter`; `InvalidValue` for a spread that cannot be; `TwoSpreads` beside one of
    /// places in the other unit.
    pub fn with_spread(
        mut self,
        id: &str,
        parameter: &str,
        spread: Spread,
    ) -> Result<Self, EffectError> {
        let varying = self.varying(id, parameter, spread, &self.per_place)?;
        put(&mut self.per_push, varying);
        Ok(self)
    }

    /// The same model, in which a parameter of one of its effects differs from place to place of the table,
    /// faster than a step is long: every step moves as expected over places.
    ///
    /// # Errors
    /// As [`PushPhysics::with_spread`].
    pub fn with_spread_of_places(
        mut self,
        id: &str,
        parameter: &str,
        spread: Spread,
    ) -> Result<Self, EffectError> {
        let varying = self.varying(id, parameter, spread, &self.per_push)?;
        put(&mut self.per_place, varying);
        Ok(self)
    }

    /// A parameter with its spread, which adds to that of `others` if they have it.
    fn varying(
        &self,
        id: &str,
        parameter: &str,
        spread: Spread,
        others: &[Varying],
    ) -> Result<Varying, EffectError> {
        let about = self.effects[self.index_of(id)?].0.info();
        let unknown = || EffectError::UnknownParameter {
            effect: id.to_owned(),
            name: parameter.to_owned(),
            parameters: about.names(),
        };
        let index = about.parameters.iter().position(|known| known.name == parameter);
        let index = index.ok_or_else(unknown)?;
        spread.check(&about.parameters[index])?;
        let other = others.iter().find(|(effect, known, _)| (*effect, *known) == (about.id, index));
        if other.is_some_and(|(.., other)| !spread.is_like(*other)) {
            let (effect, parameter) = (id.to_owned(), parameter.to_owned());
            return Err(EffectError::TwoSpreads { effect, parameter });
        }
        Ok((about.id, index, spread))
    }

    /// How many numbers a push draws: one for each parameter that differs from push to push.
    pub fn n_drawn(&self) -> usize {
        self.drawing().count()
    }

    /// The model of one push that has drawn these standard normal numbers, in the order in which the
    /// effects act, within what a step of it allows; parameters without a number keep their values.
    pub fn drawn(&self, numbers: &[f64], step: &StepInput) -> Self {
        let mut one = self.clone();
        one.per_push.clear();
        one.draw(self.drawing().zip(numbers), step);
        one
    }

    /// The model in which these parameters are so many standard deviations from their values, and all others
    /// are the same everywhere.
    pub(crate) fn deviating(&self, by: &[Differing], numbers: &[f64], step: &StepInput) -> Self {
        let mut one = self.clone();
        one.per_push.clear();
        one.per_place.clear();
        one.draw(by.iter().map(|one| &one.varying).zip(numbers), step);
        one
    }

    fn draw<'a>(
        &mut self,
        numbers: impl Iterator<Item = (&'a Varying, &'a f64)>,
        step: &StepInput,
    ) {
        for ((id, parameter, spread), number) in numbers {
            let of = |(effect, _): &&mut (Arc<dyn Effect>, _)| effect.info().id == *id;
            if let Some((effect, values)) = self.effects.iter_mut().find(of) {
                let range = effect.range_in(*parameter, step);
                values[*parameter] = spread.at(values[*parameter], *number, range);
            }
        }
    }

    /// Every parameter that differs from push to push or from place to place, in the order in which they act.
    pub(crate) fn differing(&self) -> Vec<Differing> {
        let all = self.per_push.iter().map(|one| (one, 1.0));
        let all = all.chain(self.per_place.iter().map(|one| (one, 0.0)));
        let mut found: Vec<Differing> = Vec::new();
        for (varying, share_of_push) in all.filter(|(one, _)| !one.2.is_none()) {
            let is_same =
                |one: &&mut Differing| (one.varying.0, one.varying.1) == (varying.0, varying.1);
            match found.iter_mut().find(is_same) {
                None => found.push(Differing { varying: *varying, share_of_push }),
                Some(one) => {
                    let of_push = one.varying.2;
                    one.varying.2 = of_push.and(varying.2);
                    one.share_of_push = of_push.share_of(one.varying.2);
                }
            }
        }
        found.sort_by_key(|one| (place(one.varying.0), one.varying.1));
        found
    }

    /// Refuses values that the object or the pusher of a step does not allow.
    ///
    /// # Errors
    /// `OutOfRange`.
    pub fn check_in(&self, step: &StepInput) -> Result<(), EffectError> {
        self.effects.iter().try_for_each(|(effect, values)| {
            let about = effect.info();
            let parameters = about.parameters.iter().zip(values).enumerate();
            let mut plain = parameters.map(|(k, (parameter, value))| {
                parameter.check_within(about.id, *value, effect.range_in(k, step))
            });
            plain.try_for_each(|checked| checked)
        })
    }

    /// Whether outline and pusher differ from push to push.
    pub fn draws_outline(&self) -> bool {
        let shapes = |stage| self.at(stage).map(|(effect, _)| effect.info().id);
        let mut acting = shapes(Stage::Geometry).chain(shapes(Stage::Measurement));
        acting.any(|id| self.drawing().any(|(drawing, ..)| *drawing == id))
    }

    fn drawing(&self) -> impl Iterator<Item = &Varying> {
        self.per_push.iter().filter(|(.., spread)| !spread.is_none())
    }

    fn index_of(&self, id: &str) -> Result<usize, EffectError> {
        let found = self.effects.iter().position(|(effect, _)| effect.info().id == id);
        found.ok_or_else(|| {
            let ids: Vec<_> = self.effects.iter().map(|(effect, _)| effect.info().id).collect();
            EffectError::UnknownEffect { id: id.to_owned(), known: ids.join(", ") }
        })
    }

    /// The same model with other values for an effect that it has.
    ///
    /// # Errors
    /// `UnknownEffect` if it has no such effect; those of its values.
    pub fn set(&mut self, id: &str, values: &[f64]) -> Result<(), EffectError> {
        let index = self.index_of(id)?;
        let (effect, old) = &mut self.effects[index];
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
            let mut of_pushes = setting.per_push.iter();
            let model = of_pushes
                .try_fold(model.with(effect, &values)?, |model, (parameter, spread)| {
                    model.with_spread(&setting.id, parameter, *spread)
                })?;
            let mut of_places = setting.per_place.iter();
            of_places.try_fold(model, |model, (parameter, spread)| {
                model.with_spread_of_places(&setting.id, parameter, *spread)
            })
        })
    }

    /// What a file says of the effects, in the order in which they act.
    pub fn settings(&self) -> Vec<Setting> {
        let setting = |(effect, values): &(Arc<dyn Effect>, Vec<f64>)| {
            let about = effect.info();
            let of = |all: &[Varying]| {
                let own = all.iter().filter(|(id, ..)| *id == about.id);
                let named = |(_, parameter, spread): &Varying| {
                    (about.parameters[*parameter].name.to_owned(), *spread)
                };
                own.map(named).collect()
            };
            let (per_push, per_place) = (of(&self.per_push), of(&self.per_place));
            Setting { per_push, per_place, ..Setting::new(about, values) }
        };
        self.effects.iter().map(setting).collect()
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
    /// `OutOfRange` as [`PushPhysics::check_in`]; `TooRound` for corners that do not fit on the outline.
    pub fn true_outline(&self, step: &StepInput) -> Result<TrueOutline, EffectError> {
        self.check_in(step)?;
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

    /// Surplus and growth of points, of all effects together.
    pub(crate) fn local_friction_of_all(&self, points: &SlidingPoints) -> LocalFriction {
        let mut found = LocalFriction::default();
        self.at(Stage::Local)
            .for_each(|(e, values)| e.add_local_friction(values, points, &mut found));
        found
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

/// Puts a parameter's spread in the place of the one that it had.
fn put(all: &mut Vec<Varying>, varying: Varying) {
    all.retain(|known| (known.0, known.1) != (varying.0, varying.1));
    all.push(varying);
    all.sort_by_key(|(effect, parameter, _)| (place(effect), *parameter));
}

/// Order of action: the catalogue's, then that of ids.
fn place(id: &'static str) -> (usize, &'static str) {
    let index = all().iter().position(|effect| effect.info().id == id);
    (index.unwrap_or(usize::MAX), id)
}
