//! An analytical model with its effects goes in, one function of the parameters that a fit may move
//! comes out, and the fit.

pub(crate) mod channel_model;
pub(crate) mod fit;
pub(crate) mod nominal;
pub(crate) mod orthogonal;

use std::sync::Arc;

use dataset::SupportSpec;
use effects::{Channels, Effect, EffectInfo, Rig, Role, TrueOutline, by_id_with};
use nalgebra::{Matrix3, Vector3};

use crate::{
    Analytical, Base, ChannelModel, CharacteristicLength, Description, Estimate, ModelEffect,
    ModelError, MotionOverPushes, Pushed, StepInput, SurfaceKind,
};

/// The physics of a hybrid: the motion of steps, and what moves it.
#[derive(Clone, Debug)]
pub(crate) struct Physics {
    pub(crate) base: Analytical,
    pub(crate) effects: Vec<ModelEffect>,
    setup: Option<Setup>,
}

/// The set-up that effects act in.
#[derive(Clone, Debug)]
pub struct Setup {
    /// The table.
    pub support: SupportSpec,
    /// Effects besides those of the catalogue.
    pub own: Vec<Arc<dyn Effect>>,
}

/// A parameter that a fit may move: its value is a function of a number u that is 0 here and of
/// order 1 where it is another one.
#[derive(Clone, Debug)]
pub(crate) struct Free {
    /// Such as `pusher-friction` or `table-tilt ax`.
    pub(crate) name: String,
    /// The same in short, for messages.
    pub(crate) label: &'static str,
    place: Place,
}

#[derive(Clone, Debug)]
enum Place {
    /// μp eᵘ.
    Friction(f64),
    /// c eᵘ, in m.
    Length(f64),
    /// A coordinate of an effect, of which u is the number of secants; within its range.
    Effect { effect: usize, coordinate: usize, at: f64, secant: f64, range: (f64, f64) },
}

/// To either side, for slopes: far enough to reach over the kinks of sticking and sliding.
pub(crate) const DIFFERENCE: f64 = 0.02;
/// μp and c are not moved by more than a factor of e².
const FARTHEST: f64 = 2.0;

impl Free {
    /// The number nearest to `u` whose value is within its range.
    fn within(&self, u: f64) -> f64 {
        match self.place {
            Place::Effect { at, secant, range: (low, high), .. } => {
                let moved = at + u * secant;
                if (low..=high).contains(&moved) {
                    u
                } else {
                    (moved.clamp(low, high) - at) / secant
                }
            }
            Place::Friction(_) | Place::Length(_) => u,
        }
    }
}

impl Physics {
    /// The physics of a base with effects, which need a set-up.
    ///
    /// # Errors
    /// `EffectsNeedMore` for effects without one; `Effects` for what they refuse.
    pub(crate) fn new(
        base: Analytical,
        effects: Vec<ModelEffect>,
        setup: Option<Setup>,
    ) -> Result<Self, ModelError> {
        let physics = Self { base, effects, setup };
        if !physics.effects.is_empty() {
            physics.channels()?;
        }
        Ok(physics)
    }

    /// (Δx, Δy, Δθ) of each step, in m, m and rad: expected where parameters differ from push to push.
    pub(crate) fn outputs(&self, steps: &[&StepInput]) -> Result<Vec<Vector3<f64>>, ModelError> {
        if self.effects.is_empty() {
            return self.base.outputs(steps.iter().copied());
        }
        Ok(motions(&self.channels()?.predict(self.whole(steps)?)?))
    }

    /// The same of pushes that have drawn these numbers.
    pub(crate) fn drawn_outputs(
        &self,
        steps: &[&StepInput],
        draws: &[&[f64]],
    ) -> Result<Vec<Vector3<f64>>, ModelError> {
        if self.n_drawn() == 0 {
            return self.outputs(steps);
        }
        let pairs = self.whole(steps)?.into_iter().zip(draws.iter().copied());
        Ok(motions(&self.channels()?.predict_drawn(pairs)?))
    }

    /// How many numbers a push draws.
    pub(crate) fn n_drawn(&self) -> usize {
        let n_of = |effect: &ModelEffect| {
            let setting = effect.setting();
            setting.per_push.values().filter(|spread| !spread.is_none()).count()
        };
        self.effects.iter().map(n_of).sum()
    }

    /// (Δx, Δy, Δθ) of each step, expected, and what the parameters that differ from push to push leave
    /// open of it.
    pub(crate) fn over_pushes(
        &self,
        steps: &[&StepInput],
    ) -> Result<Vec<MotionOverPushes>, ModelError> {
        if self.n_drawn() == 0 {
            let known = |mean| (mean, Matrix3::zeros());
            return Ok(self.outputs(steps)?.into_iter().map(known).collect());
        }
        self.channels()?.motion_over_pushes(self.whole(steps)?)
    }

    fn whole<'a>(
        &self,
        steps: &[&'a StepInput],
    ) -> Result<Vec<&'a effects::StepInput>, ModelError> {
        steps.iter().map(|step| step.whole().ok_or_else(|| self.needs_more())).collect()
    }

    /// Outline and pusher as the effects have them.
    pub(crate) fn true_outline(&self, pushed: &Pushed) -> Result<TrueOutline, ModelError> {
        if self.effects.is_empty() {
            return Ok(pushed.stated());
        }
        let object = pushed.object.as_ref().ok_or_else(|| self.needs_more())?;
        self.channels()?.true_outline(object, pushed.pusher_radius)
    }

    /// The same of a push that has drawn these numbers; none where all pushes have the same.
    pub(crate) fn drawn_outline(
        &self,
        pushed: &Pushed,
        draw: &[f64],
    ) -> Result<Option<TrueOutline>, ModelError> {
        if self.n_drawn() == 0 {
            return Ok(None);
        }
        let object = pushed.object.as_ref().ok_or_else(|| self.needs_more())?;
        self.channels()?.drawn_outline(object, pushed.pusher_radius, draw)
    }

    /// What a fit to such steps may move: μp, on an ellipsoid c, and the numbers of the effects.
    ///
    /// An effect that says the same as μp or c stands for it; switches and references are not moved.
    pub(crate) fn free(&self, step: &StepInput) -> Result<Vec<Free>, ModelError> {
        let carries = |id: &str| self.effects.iter().any(|effect| effect.id == id);
        let mut free = Vec::new();
        if !carries("pusher-friction") {
            let place = Place::Friction(self.base.pusher_friction().value.max(1e-3));
            free.push(Free { name: "pusher-friction".to_owned(), label: "mu_p", place });
        }
        if self.base.surface() == SurfaceKind::Ellipsoid && !carries("pressure-radius") {
            let place = Place::Length(self.base.characteristic_length(step));
            free.push(Free { name: "characteristic-length".to_owned(), label: "c", place });
        }
        for (index, effect) in self.effects.iter().enumerate() {
            let about = self.info(effect)?;
            let values = effect.setting().values(about)?;
            let here = about.to_coordinates(&values);
            let whole = step.whole().ok_or_else(|| self.needs_more())?;
            let coordinates = self.effect(effect)?.coordinates_in(&self.rig(step)?, whole);
            let is_fixed =
                |k: &usize| matches!(about.parameters[*k].role, Role::Switch | Role::Reference);
            let moving = (0..here.len()).filter(|k| !is_fixed(k));
            free.extend(moving.map(|k| {
                let effects::Coordinate { name, secant, range, .. } = coordinates[k];
                let (effect, coordinate, at) = (index, k, here[k]);
                let (name, label) = (format!("{} {name}", about.id), name);
                Free { name, label, place: Place::Effect { effect, coordinate, at, secant, range } }
            }));
        }
        Ok(free)
    }

    /// The physics with its free parameters moved by u.
    pub(crate) fn moved(&self, free: &[Free], u: &[f64]) -> Result<Self, ModelError> {
        let (mut friction, mut length) =
            (self.base.pusher_friction().clone(), self.base.length().clone());
        let mut effects = self.effects.clone();
        for (Free { place, .. }, u) in free.iter().zip(u) {
            let factor = u.clamp(-FARTHEST, FARTHEST).exp();
            match place {
                Place::Friction(at) => friction.value = at * factor,
                Place::Length(at) => {
                    length = CharacteristicLength::Given(Estimate::exact(at * factor, ""));
                }
                Place::Effect { effect, coordinate, at, secant, range } => {
                    let about = self.info(&effects[*effect])?;
                    let values = effects[*effect].setting().values(about)?;
                    let mut coordinates = about.to_coordinates(&values);
                    coordinates[*coordinate] = (at + u * secant).clamp(range.0, range.1);
                    set(&mut effects[*effect], about, &about.from_coordinates(&coordinates));
                }
            }
        }
        let base = Analytical::new(friction, length, *self.base.scatter())?;
        let base = base.with_surface(self.base.surface())?;
        Ok(Self { base, effects, setup: self.setup.clone() })
    }

    /// Change of the outputs by the unit of each u, by secants: one list of steps a parameter.
    pub(crate) fn jacobian(
        &self,
        free: &[Free],
        steps: &[&StepInput],
    ) -> Result<Vec<Vec<Vector3<f64>>>, ModelError> {
        let column = |k: usize| {
            let at = |size: f64| {
                let mut u = vec![0.0; free.len()];
                u[k] = size;
                self.moved(free, &u)?.outputs(steps)
            };
            // To one side where the range ends.
            let (high, low) = (free[k].within(DIFFERENCE), free[k].within(-DIFFERENCE));
            let (above, below) = (at(high)?, at(low)?);
            let slope =
                |(above, below): (&Vector3<f64>, &Vector3<f64>)| (above - below) / (high - low);
            Ok(above.iter().zip(&below).map(slope).collect())
        };
        (0..free.len()).map(column).collect()
    }

    /// Notes the standard errors of free parameters whose u has them, and where they come from.
    pub(crate) fn with_errors(
        mut self,
        free: &[Free],
        sd_u: &[f64],
        source: &str,
    ) -> Result<Self, ModelError> {
        let mut friction = self.base.pusher_friction().clone();
        let mut length = self.base.length().clone();
        let known = |value: f64, se: f64| Estimate { value, se, source: source.to_owned() };
        for (index, (Free { place, .. }, sd)) in free.iter().zip(sd_u).enumerate() {
            match place {
                Place::Friction(_) => friction = known(friction.value, friction.value * sd),
                Place::Length(_) => {
                    if let CharacteristicLength::Given(Estimate { value, .. }) = length {
                        length = CharacteristicLength::Given(known(value, value * sd));
                    }
                }
                // The parameters that a coordinate moves take its error, added in squares.
                Place::Effect { effect, .. } => {
                    let mut u = vec![0.0; free.len()];
                    u[index] = *sd;
                    let there = self.moved(free, &u)?.effects.swap_remove(*effect);
                    let is_first = !free[..index].iter().any(
                        |other| matches!(&other.place, Place::Effect { effect: e, .. } if e == effect),
                    );
                    for (name, estimate) in &mut self.effects[*effect].parameters {
                        let change = there.parameters[name].value - estimate.value;
                        let before = if is_first { 0.0 } else { estimate.se };
                        *estimate = known(estimate.value, before.hypot(change));
                    }
                }
            }
        }
        let base = Analytical::new(friction, length, *self.base.scatter())?;
        self.base = base.with_surface(self.base.surface())?;
        Ok(self)
    }

    /// Smallest and largest value of a parameter that all of these steps allow.
    pub(crate) fn range_in(
        &self,
        effect: &ModelEffect,
        parameter: &str,
        steps: &[&StepInput],
    ) -> Result<(f64, f64), ModelError> {
        let effect = self.effect(effect)?;
        let index = effect.info().parameters.iter().position(|known| known.name == parameter);
        let range = index.map_or((f64::NEG_INFINITY, f64::INFINITY), |index| {
            let whole = steps.iter().filter_map(|step| step.whole());
            let one = whole.map(|step| effect.range_in(index, step));
            let all = effect.info().parameters[index].range;
            one.fold(all, |all, one| (all.0.max(one.0), all.1.min(one.1)))
        });
        Ok(range)
    }

    fn effect(&self, effect: &ModelEffect) -> Result<&Arc<dyn Effect>, ModelError> {
        let own = self.setup.as_ref().map_or(&[][..], |setup| &setup.own);
        Ok(by_id_with(&effect.id, own)?)
    }

    fn info(&self, effect: &ModelEffect) -> Result<&EffectInfo, ModelError> {
        Ok(self.effect(effect)?.info())
    }

    fn rig(&self, step: &StepInput) -> Result<Rig, ModelError> {
        let whole = step.whole().ok_or_else(|| self.needs_more())?;
        Ok(self.channels()?.physics(&whole.object)?.rig().clone())
    }

    fn channels(&self) -> Result<ChannelModel, ModelError> {
        let setup = self.setup.as_ref().ok_or_else(|| self.needs_more())?;
        let (base, effects) = (Base::Analytical(self.base.clone()), self.effects.clone());
        ChannelModel::new(&Description { base, effects, weights: None }, setup.support, &setup.own)
    }

    fn needs_more(&self) -> ModelError {
        let ids: Vec<_> = self.effects.iter().map(|effect| effect.id.as_str()).collect();
        ModelError::EffectsNeedMore { effects: ids.join(", ") }
    }
}

fn motions(channels: &[Channels]) -> Vec<Vector3<f64>> {
    channels.iter().map(|found| Vector3::new(found.dx, found.dy, found.dtheta)).collect()
}

fn set(effect: &mut ModelEffect, about: &EffectInfo, values: &[f64]) {
    for (parameter, value) in about.parameters.iter().zip(values) {
        if let Some(estimate) = effect.parameters.get_mut(parameter.name) {
            estimate.value = *value;
        }
    }
}
