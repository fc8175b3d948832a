//! A model as a function of the numbers that a fit moves.

use std::ops::Range;
use std::sync::Arc;

use effects::{
    Channel, Effect, EffectInfo, Nuisance, Object, PressureRadius, PushPhysics, PusherFriction,
    Rig, Setting, Stage, StepInput, all, by_id_with,
};
use models::{
    Analytical, Base, ChannelModel, CharacteristicLength, Description, Estimate, ModelEffect,
};
use rayon::prelude::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};

use super::free_spread::FreeSpread;
use super::member::{Member, Part};
use super::nearby::Nearby;
use super::{FitSettings, SupportPointsFit, field, supports};
use crate::{DiagnosisError, Observations};

/// A model whose effects stand at any place, on observed steps.
#[derive(Clone, Debug)]
pub(super) struct Space<'a> {
    observations: &'a Observations,
    /// One an object.
    physics: Vec<PushPhysics>,
    object_of: Vec<usize>,
    /// In the order in which they act.
    pub(super) members: Vec<Member>,
    /// By how much a parameter differs, as one more number at the end of a place.
    pub(super) spread: Option<FreeSpread>,
    /// Where pushes differ, what is known of expectations from a place nearby; none: they are worked out anew at
    /// each place.
    nearby: Option<Nearby>,
}

impl<'a> Space<'a> {
    /// The model with the effects asked for, those that it carries with a standard error, and the
    /// nuisances. What says where the object rests starts from a model that is near, if there is one.
    ///
    /// # Errors
    /// `Model` for what the model or an effect refuses.
    pub(super) fn new(
        observations: &'a Observations,
        model: &Description,
        asked: &[&str],
        settings: &FitSettings,
        near: Option<&Description>,
    ) -> Result<Self, DiagnosisError> {
        let model = unfolded(model, observations)?;
        let bare = Description { effects: Vec::new(), ..model.clone() };
        let object = |step: &models::ChannelObservation| step.input.object.clone();
        let first = observations.steps.first().map(object);
        let first = first.ok_or_else(|| observations.too_few(0, 1))?;
        let rig =
            ChannelModel::new(&bare, observations.support, &[])?.physics(&first)?.rig().clone();
        let mut ids: Vec<&str> = asked.to_vec();
        ids.extend(model.effects.iter().map(|effect| effect.id.as_str()));
        ids.extend(nuisances(&ids, settings));
        let (mut members, mut seen) = (Vec::new(), Vec::new());
        for id in ids {
            let effect = by_id_with(id, &settings.own).map_err(models::ModelError::from)?;
            let about = effect.info();
            if !seen.contains(&about.id) {
                seen.push(about.id);
                let carried = model.effects.iter().find(|carried| carried.id == id);
                let is_open = shows_in_every_force(about) && observations.show(about.reaches);
                let wish = match asked.contains(&id) {
                    true => Some(Part::Asked),
                    false => is_open.then_some(Part::Carried),
                };
                let found = member(effect, wish, carried, &rig, settings)?;
                let known = near.unwrap_or(&model).effects.iter().find(|effect| effect.id == id);
                let known = known.and_then(|effect| effect.setting().values(about).ok());
                let steps = observations.steps.iter().map(|step| &step.input);
                let found = found.map(|member| member.inside(steps, &rig));
                let start =
                    |member| with_start(member, known, settings.points, observations, &first);
                members.extend(found.map(start));
            }
        }
        let started = |member: &Member| {
            let carried = model.effects.iter().find(|carried| carried.id == member.id());
            let mut effect = ModelEffect::from(Setting::new(member.effect.info(), &member.start));
            if let Some(carried) = carried {
                effect.per_push.clone_from(&carried.per_push);
                effect.per_session.clone_from(&carried.per_session);
                effect.per_place.clone_from(&carried.per_place);
            }
            effect
        };
        let is_fixed = |carried: &&ModelEffect| members.iter().all(|m| m.id() != carried.id);
        let mut effects: Vec<_> = model.effects.iter().filter(is_fixed).cloned().collect();
        effects.extend(members.iter().map(started));
        let whole = Description { effects, ..model };
        let whole = ChannelModel::new(&whole, observations.support, &settings.own)?;
        let (mut objects, mut physics, mut object_of) = (Vec::<Arc<Object>>::new(), vec![], vec![]);
        for step in observations.steps.iter().map(object) {
            let known = objects.iter().position(|object| Arc::ptr_eq(object, &step));
            object_of.push(known.unwrap_or(objects.len()));
            if known.is_none() {
                physics.push(whole.physics(&step)?);
                objects.push(step);
            }
        }
        let order = physics[0].effects().iter().map(|(effect, _)| effect.info().id);
        let order: Vec<_> = order.collect();
        members.sort_by_key(|member| order.iter().position(|id| *id == member.id()));
        Ok(Self { observations, physics, object_of, members, spread: None, nearby: None })
    }

    /// The same with one more effect, at "off"; one that is a nuisance loses its prior.
    pub(super) fn with(&self, effect: &Arc<dyn Effect>) -> Result<Self, DiagnosisError> {
        self.with_on(effect, SupportPointsFit::default())
    }

    /// The same; points on which the object rests are so many.
    pub(super) fn with_on(
        &self,
        effect: &Arc<dyn Effect>,
        points: SupportPointsFit,
    ) -> Result<Self, DiagnosisError> {
        let mut other = self.clone();
        let rig = self.physics[0].rig().clone();
        let off = effect.info().off(&rig);
        let steps = self.observations.steps.iter().map(|step| &step.input);
        if let Some(known) = other.members.iter_mut().find(|m| m.id() == effect.info().id) {
            *known = Member::new(effect, Part::Asked, &known.start, &rig).inside(steps, &rig);
            return Ok(other);
        }
        for physics in &mut other.physics {
            *physics = physics.clone().with(effect, &off).map_err(models::ModelError::from)?;
        }
        let member = Member::new(effect, Part::Asked, &off, &rig).inside(steps, &rig);
        let object = &self.observations.steps[0].input.object;
        other.members.push(with_start(member, None, points, self.observations, object));
        Ok(other)
    }

    /// The nominal set-up of the first object.
    pub(super) fn rig(&self) -> Rig {
        self.physics[0].rig().clone()
    }

    pub(super) fn n_steps(&self) -> usize {
        self.observations.n_steps()
    }

    /// The numbers of an effect, if it is moved.
    pub(super) fn numbers_of(&self, id: &str) -> Option<Range<usize>> {
        let index = self.members.iter().position(|member| member.id() == id)?;
        let first = self.first(index);
        Some(first..first + self.members[index].len())
    }

    /// Each member with its share of a place.
    pub(super) fn shares<'x>(&self, x: &'x [f64]) -> impl Iterator<Item = (&Member, &'x [f64])> {
        let mut rest = x;
        self.members.iter().map(move |member| {
            let (own, others) = rest.split_at(member.len());
            rest = others;
            (member, own)
        })
    }

    /// The square of the size of the spread, if it is moved.
    pub(super) fn spread_at(&self, x: &[f64]) -> Option<f64> {
        self.spread.as_ref().and(x.last().copied())
    }

    /// Index of a member's first number.
    pub(super) fn first(&self, member: usize) -> usize {
        self.members[..member].iter().map(Member::len).sum()
    }

    /// The place at which every member has the values that `of` tells.
    pub(super) fn place(&self, of: impl Fn(&Member) -> Vec<f64>) -> Vec<f64> {
        self.members.iter().flat_map(|member| member.place(&of(member))).collect()
    }

    /// The numbers, of the member whose first one is given, that are sizes which mean nothing where it is off.
    pub(super) fn scales(&self, first: usize) -> Vec<usize> {
        let mut members = (0..self.members.len()).filter(|index| self.first(*index) == first);
        let member = members.find(|index| self.members[*index].len() > 0);
        let own = member.map_or_else(Vec::new, |index| self.members[index].scales());
        own.into_iter().map(|k| first + k).collect()
    }

    /// A number of every coordinate, in their order.
    pub(super) fn of_each<T>(
        &self,
        of: impl Fn(&Member) -> Vec<T>,
        of_spread: impl Fn(&FreeSpread) -> T,
    ) -> Vec<T> {
        self.members.iter().flat_map(of).chain(self.spread.iter().map(of_spread)).collect()
    }

    /// Lets the prior of a field hold against errors of a typical size, in that of the noise: what the model
    /// misses from push to push is no friction of the table.
    pub(super) fn hold_against(&mut self, errors: f64) {
        let fields = self.members.iter_mut().filter(|m| field::is_field(m.effect.info()));
        fields.for_each(|member| member.noise = errors);
    }

    /// The noise of the members, for each of their strains.
    pub(super) fn noise_of_strains(&self, x: &[f64]) -> Vec<f64> {
        let of = |(member, own): (&Member, &[f64])| {
            vec![member.noise; member.prior_residual(&member.values(own)).len()]
        };
        self.shares(x).flat_map(of).collect()
    }

    /// The strains of the priors at a place.
    pub(super) fn strains(&self, x: &[f64]) -> Vec<f64> {
        self.shares(x)
            .flat_map(|(member, own)| member.prior_residual(&member.values(own)))
            .collect()
    }

    /// Where pushes differ, keeps what that changes of each step at a place: beside it, only what bends the motion of a
    /// step is asked for anew. False, and nothing done, where all pushes are the same or by how much they differ
    /// is moved itself.
    ///
    /// - `sd`: standard deviations of the noise of each step's numbers.
    ///
    /// # Errors
    /// What a prediction refuses.
    pub(super) fn stay_near(
        &mut self,
        x: &[f64],
        sd: &[(usize, usize, f64)],
    ) -> Result<bool, DiagnosisError> {
        let is_free = self.spread.is_some();
        if is_free || self.physics.iter().all(|physics| physics.of_typical_push().is_none()) {
            return Ok(false);
        }
        let physics = self.physics_at(x)?;
        let steps = self.observations.steps.par_iter().zip(&self.object_of);
        let parts =
            steps.map(|(step, object)| physics[*object].predict_parts(&step.input, |_| true));
        let parts: Result<Vec<_>, effects::EffectError> = parts.collect();
        self.nearby = Some(Nearby::new(&parts.map_err(models::ModelError::from)?, sd));
        Ok(true)
    }

    /// Observed less predicted at a place; 0 for what is not observed.
    ///
    /// # Errors
    /// What a prediction refuses.
    pub(super) fn residuals(&self, x: &[f64]) -> Result<Vec<[f64; 7]>, DiagnosisError> {
        let physics = self.physics_at(x)?;
        let predict = |(index, step): (usize, &StepInput)| {
            let physics = &physics[self.object_of[index]];
            match &self.nearby {
                Some(nearby) => nearby.predict(physics, index, step),
                None => Ok(physics.predict(step)?.to_array()),
            }
        };
        let steps = self.observations.steps.par_iter().enumerate();
        let residuals = steps.map(|(index, step)| {
            let predicted = predict((index, &step.input))?;
            let observed = step.observed.iter().zip(predicted);
            let mut residuals = [0.0; 7];
            for (residual, (observed, predicted)) in residuals.iter_mut().zip(observed) {
                *residual = observed.map_or(0.0, |observed| observed - predicted);
            }
            Ok(residuals)
        });
        Ok(residuals
            .collect::<Result<_, effects::EffectError>>()
            .map_err(models::ModelError::from)?)
    }

    /// The physics of each object at a place.
    fn physics_at(&self, x: &[f64]) -> Result<Vec<PushPhysics>, DiagnosisError> {
        let mut physics = self.physics.clone();
        for (member, own) in self.shares(x) {
            let values = member.values(own);
            for physics in &mut physics {
                physics.set(member.id(), &values).map_err(models::ModelError::from)?;
            }
        }
        if let (Some(spread), Some(square)) = (&self.spread, self.spread_at(x)) {
            let with = |physics| spread.put(physics, square);
            let differing = physics.into_iter().map(with).collect::<Result<_, _>>();
            physics = differing.map_err(models::ModelError::from)?;
        }
        Ok(physics)
    }
}

/// The ids of what nobody knows exactly, beside effects with other ids: where it is said where the weight
/// rests, its mean distance follows.
fn nuisances(ids: &[&str], settings: &FitSettings) -> Vec<&'static str> {
    let says_where = |id: &&str| {
        let effect = by_id_with(id, &settings.own);
        effect.is_ok_and(|effect| effect.info().stages.contains(&Stage::Pressure))
    };
    let has_spots = ids.iter().any(says_where);
    let follows = |about: &EffectInfo| has_spots && about.id == PressureRadius.info().id;
    let known = all().iter().chain(&settings.own).map(|effect| effect.info());
    let is_open = |about: &&EffectInfo| about.nuisance != Nuisance::No && !follows(about);
    known.filter(is_open).map(|about| about.id).collect()
}

/// A member that says where the object rests, or how the table rubs where pushes were: from what is known or
/// else from where the motions say that it does.
fn with_start(
    member: Member,
    known: Option<Vec<f64>>,
    points: SupportPointsFit,
    observations: &Observations,
    object: &Arc<Object>,
) -> Member {
    let known = known.filter(|values| *values != member.off);
    if member.part == Part::Asked && field::is_field(member.effect.info()) {
        return field::on_its_table(member, known, observations);
    }
    if !member.is_moved_mixture() {
        return member;
    }
    let found = known.or_else(|| supports::start(member.effect.as_ref(), points.n, observations));
    let values = found.unwrap_or_else(|| member.typical.clone());
    member.starting_from(values, object, points.by_statics)
}

/// Whether an effect that nobody knows well changes nothing but the force, so that every force shows
/// it: it is moved and written wherever there are forces.
fn shows_in_every_force(about: &EffectInfo) -> bool {
    matches!(about.nuisance, Nuisance::Free { .. }) && about.reaches == [Channel::Force]
}

/// What a fit does with an effect; none for one that stays as it is.
fn member(
    effect: &Arc<dyn Effect>,
    wish: Option<Part>,
    carried: Option<&ModelEffect>,
    rig: &effects::Rig,
    settings: &FitSettings,
) -> Result<Option<Member>, DiagnosisError> {
    let about = effect.info();
    let start = match carried {
        Some(carried) => carried.setting().values(about).map_err(models::ModelError::from)?,
        None => about.off(rig),
    };
    let se = |name: &str| carried.and_then(|c| c.parameters.get(name)).map_or(0.0, |e| e.se);
    let se: Vec<f64> = about.parameters.iter().map(|parameter| se(parameter.name)).collect();
    let is_estimate = se.iter().any(|se| *se > 0.0);
    let tolerance = settings.tolerances.of(about);
    let part = match (wish, carried, tolerance) {
        (Some(part), ..) => part,
        (_, Some(_), _) if is_estimate => Part::Carried,
        (_, _, Some(_)) => Part::Nuisance,
        _ => return Ok(None),
    };
    let member = Member::new(effect, part, &start, rig);
    Ok(Some(match (part, tolerance) {
        (Part::Nuisance, Some(tolerance)) if tolerance.is_finite() => {
            member.with_prior(&vec![tolerance; start.len()])
        }
        _ if is_estimate && settings.priors => member.with_prior(&se),
        _ => member,
    }))
}

/// The model with its friction and characteristic length as effects, as fits move them.
fn unfolded(
    model: &Description,
    observations: &Observations,
) -> Result<Description, DiagnosisError> {
    let Base::Analytical(base) = &model.base else {
        return Ok(model.clone());
    };
    let mut model = model.clone();
    let has = |model: &Description, id: &str| model.effects.iter().any(|effect| effect.id == id);
    if let CharacteristicLength::Given(length) = base.length()
        && !has(&model, PressureRadius.info().id)
    {
        let uniform = observations.steps[0].input.object.mean_distance();
        let Estimate { value, se, source } = length.clone();
        let ratio = Estimate { value: value / uniform, se: se / uniform, source };
        model.effects.push(one_parameter(&PressureRadius, ratio));
        let nominal = Analytical::new(
            base.pusher_friction().clone(),
            CharacteristicLength::UniformPressure,
            *base.scatter(),
        )?;
        model.base = Base::Analytical(nominal.with_surface(base.surface())?);
    }
    if base.pusher_friction().se > 0.0 && !has(&model, PusherFriction.info().id) {
        model.effects.push(one_parameter(&PusherFriction, base.pusher_friction().clone()));
    }
    Ok(model)
}

fn one_parameter(effect: &dyn Effect, estimate: Estimate) -> ModelEffect {
    let about = effect.info();
    let name = about.parameters[0].name.to_owned();
    ModelEffect::new(about.id, [(name, estimate)].into())
}
