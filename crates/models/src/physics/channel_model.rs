//! All channels of a step, by an analytical model with effects in a set-up.

use std::sync::Arc;

use dataset::SupportSpec;
use effects::{
    Channels, Effect, EffectError, Object, Predicted, PressureRadius, PushPhysics, Rig, Setting,
    StepInput, Surface, Track, TrueOutline,
};
use nalgebra::{Matrix3, Vector2, Vector3};
use planar::{Pose, Twist};
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};

use crate::{Analytical, Base, CharacteristicLength, Description, ModelError, SurfaceKind};

/// The expected motion of a step and its covariance over pushes.
pub type MotionOverPushes = (Vector3<f64>, Matrix3<f64>);
/// The expected motion of a step, and deviations of pushes from it: the sum of their squares is the covariance.
pub type MotionsOfPushes = (Vector3<f64>, Vec<Vector3<f64>>);

/// Draws that are not worth another thread.
const FEW: usize = 2;

/// An analytical model with its effects on a table: motion, contact force and contact gap.
///
/// The limit surface is that of the base model; a given characteristic length acts as the effect
/// `pressure-radius` does.
#[derive(Clone, Debug)]
pub struct ChannelModel {
    base: Analytical,
    settings: Vec<Setting>,
    own: Vec<Arc<dyn Effect>>,
    support: SupportSpec,
}

impl ChannelModel {
    /// The model of a description on a nominal table; `own` are effects besides the catalogue's.
    ///
    /// # Errors
    /// `MotionAlone` for a learnt model; `Effects` for what the effects refuse, such as a table
    /// without friction or an effect that is there twice.
    pub fn new(
        description: &Description,
        support: SupportSpec,
        own: &[Arc<dyn Effect>],
    ) -> Result<Self, ModelError> {
        let base = match &description.base {
            Base::Analytical(base) => base.clone(),
            Base::Process(kind) => return Err(ModelError::MotionAlone { kind: kind.id() }),
            Base::Hybrid(_) => return Err(ModelError::MotionAlone { kind: "hybrid" }),
        };
        let settings = description.effects.iter().map(crate::ModelEffect::setting).collect();
        let model = Self { base, settings, own: own.to_vec(), support };
        model.with_effects(model.rig(Surface::Ellipsoid)?)?;
        Ok(model)
    }

    /// The physics for one object.
    ///
    /// # Errors
    /// `Effects` for a surface or a length that the object cannot have, or for `pressure-radius`
    /// beside a given characteristic length, which say the same.
    pub fn physics(&self, object: &Object) -> Result<PushPhysics, ModelError> {
        let physics = self.with_effects(self.rig(self.surface(object)?)?)?;
        match self.base.length() {
            CharacteristicLength::UniformPressure => Ok(physics),
            CharacteristicLength::Given(length) => {
                let ratio = length.value / object.mean_distance();
                Ok(physics.with(PressureRadius, &[ratio])?)
            }
        }
    }

    /// All channels of each step, in their order; expected where parameters differ from push to push.
    ///
    /// # Errors
    /// As [`ChannelModel::physics`], and what the mechanics refuse.
    pub fn predict<'a>(
        &self,
        steps: impl IntoIterator<Item = &'a StepInput>,
    ) -> Result<Vec<Channels>, ModelError> {
        self.of_each(steps, PushPhysics::predict)
    }

    /// The poses of the object at times of each step, in s from its start, expected where parameters differ from push
    /// to push ([`PushPhysics::predict_path`]).
    ///
    /// # Errors
    /// As [`ChannelModel::predict`].
    pub fn predict_paths(
        &self,
        steps: &[(StepInput, Vec<f64>)],
    ) -> Result<Vec<Vec<Pose>>, ModelError> {
        let physics =
            self.of_each(steps.iter().map(|(step, _)| step), |physics, _| Ok(physics.clone()))?;
        let of = |(physics, (step, times)): (&PushPhysics, &(StepInput, Vec<f64>))| {
            Ok(physics.predict_path(step, times)?)
        };
        physics.par_iter().zip(steps).map(of).collect()
    }

    /// All channels of each step given the standard normal numbers that its push has drawn
    /// ([`PushPhysics::drawn`]).
    ///
    /// # Errors
    /// As [`ChannelModel::predict`].
    pub fn predict_drawn<'a>(
        &self,
        steps: impl IntoIterator<Item = (&'a StepInput, &'a [f64])>,
    ) -> Result<Vec<Channels>, ModelError> {
        let steps: Vec<_> = steps.into_iter().collect();
        let physics =
            self.of_each(steps.iter().map(|(step, _)| *step), |physics, _| Ok(physics.clone()))?;
        // Each draw has mechanics of its own, which take long where masses are accelerated.
        let one = |(physics, (step, draw)): (&PushPhysics, &(&StepInput, &[f64]))| {
            Ok(physics.drawn(draw, step).predict(step)?)
        };
        physics.par_iter().zip(&steps).with_min_len(FEW).map(one).collect()
    }

    /// The motion of each step, (Δx, Δy, Δθ) in m, m and rad: expected, and its covariance by the
    /// parameters that differ from push to push.
    ///
    /// # Errors
    /// As [`ChannelModel::predict`].
    pub fn motion_over_pushes<'a>(
        &self,
        steps: impl IntoIterator<Item = &'a StepInput>,
    ) -> Result<Vec<MotionOverPushes>, ModelError> {
        let over_pushes = |(mean, deviations): MotionsOfPushes| {
            (mean, deviations.iter().map(|off| off * off.transpose()).sum())
        };
        Ok(self.motions_of_pushes(steps)?.into_iter().map(over_pushes).collect())
    }

    /// The motion of each step, (Δx, Δy, Δθ) in m, m and rad: expected, and deviations from it by the parameters
    /// that differ from push to push, each for the same values of every step; none where no parameter does.
    ///
    /// # Errors
    /// As [`ChannelModel::predict`].
    pub fn motions_of_pushes<'a>(
        &self,
        steps: impl IntoIterator<Item = &'a StepInput>,
    ) -> Result<Vec<MotionsOfPushes>, ModelError> {
        self.of_each(steps, |physics, step| {
            let Predicted { mean, deviations } = physics.predict_over_pushes(step)?;
            let motions =
                deviations.iter().map(|[dx, dy, dtheta, ..]| Vector3::new(*dx, *dy, *dtheta));
            Ok((Vector3::new(mean.dx, mean.dy, mean.dtheta), motions.collect()))
        })
    }

    fn of_each<'a, T>(
        &self,
        steps: impl IntoIterator<Item = &'a StepInput>,
        mut of: impl FnMut(&PushPhysics, &StepInput) -> Result<T, EffectError>,
    ) -> Result<Vec<T>, ModelError> {
        let mut known: Vec<(Arc<Object>, PushPhysics)> = Vec::new();
        let mut one = |step: &StepInput| {
            let found = known.iter().position(|(object, _)| Arc::ptr_eq(object, &step.object));
            let index = match found {
                Some(index) => index,
                None => {
                    known.push((step.object.clone(), self.physics(&step.object)?));
                    known.len() - 1
                }
            };
            Ok(of(&known[index].1, step)?)
        };
        steps.into_iter().map(&mut one).collect()
    }

    /// Outline and pusher as the effects have them at the start of a push in the middle of a set.
    ///
    /// - `pusher_radius`: as stated, in m.
    ///
    /// # Errors
    /// `Effects` for corners that do not fit on the outline.
    pub fn true_outline(
        &self,
        object: &Arc<Object>,
        pusher_radius: f64,
    ) -> Result<TrueOutline, ModelError> {
        let physics = self.with_effects(self.rig(Surface::Ellipsoid)?)?;
        Ok(physics.true_outline(&resting(object, pusher_radius))?)
    }

    /// The same of a push that has drawn these numbers; none where all pushes have the same.
    ///
    /// # Errors
    /// As [`ChannelModel::true_outline`].
    pub(crate) fn drawn_outline(
        &self,
        object: &Arc<Object>,
        pusher_radius: f64,
        draw: &[f64],
    ) -> Result<Option<TrueOutline>, ModelError> {
        let physics = self.with_effects(self.rig(Surface::Ellipsoid)?)?;
        if !physics.draws_outline() {
            return Ok(None);
        }
        let start = resting(object, pusher_radius);
        Ok(Some(physics.drawn(draw, &start).true_outline(&start)?))
    }

    /// Center of friction, in m, frame of the outline, and characteristic length c, in m, of an object.
    ///
    /// # Errors
    /// As [`ChannelModel::physics`].
    pub fn center_and_length(
        &self,
        object: &Arc<Object>,
    ) -> Result<(Vector2<f64>, f64), ModelError> {
        Ok(self.physics(object)?.center_and_length(&resting(object, 0.0))?)
    }

    fn with_effects(&self, rig: Rig) -> Result<PushPhysics, EffectError> {
        PushPhysics::from_settings(rig, &self.settings, &self.own)
    }

    fn rig(&self, surface: Surface) -> Result<Rig, EffectError> {
        let SupportSpec { friction, gravity } = self.support;
        Rig::new(surface, self.base.pusher_friction().value, friction)?.with_gravity(gravity)
    }

    fn surface(&self, object: &Object) -> Result<Surface, ModelError> {
        let kind = self.base.surface();
        Ok(match kind {
            SurfaceKind::Ellipsoid => Surface::Ellipsoid,
            SurfaceKind::UniformPatch => Surface::UniformPatch,
            SurfaceKind::Points { .. } | SurfaceKind::Listed(_) | SurfaceKind::Effective(_) => {
                let force = self.support.friction * object.mass() * self.support.gravity;
                Surface::Given(kind.in_body(object.shape(), force)?)
            }
        })
    }
}

/// An object at the start of a push in the middle of a set.
fn resting(object: &Arc<Object>, pusher_radius: f64) -> StepInput {
    StepInput {
        object: object.clone(),
        pusher_radius,
        pose_wb: Pose::default(),
        twist_wb: Twist::default(),
        track: Track::straight(Vector2::zeros(), Vector2::x(), 1.0),
        touching: true,
        since_contact: 0.0,
        run_up: None,
        progress: 0.5,
        session: 0,
    }
}
