//! Loads that an object at rest has to hold.

use mechanics::MechanicsError;
use nalgebra::Vector3;

use crate::EffectError;
use crate::effect::Stage;
use crate::predict::holding::overload;
use crate::predict::instant::{ForceBalance, Memory};

/// Speed of an object that is about to rest, in m/s: below what any law of friction resolves.
const SLOW: f64 = 1e-12;

impl ForceBalance<'_> {
    /// Refuses an object that must rest under a load which the friction in force cannot hold.
    ///
    /// # Errors
    /// `SlidesByItself`.
    pub(crate) fn refuse_sliding_by_itself(&self, memory: &mut Memory) -> Result<(), EffectError> {
        if self.external == Vector3::zeros() {
            return Ok(());
        }
        let level = if self.is_quadric() && !self.physics.acts_at(Stage::Local) {
            let (wrench, normal) = self.external_and_normal();
            let level = wrench.dot(&normal).sqrt();
            (level >= 1.0).then_some(level)
        } else {
            self.overload(SLOW, memory)?
        };
        level.map_or(Ok(()), |level| Err(MechanicsError::SlidesByItself { level }.into()))
    }

    /// How far the external load is beyond the friction of motions of a speed, in m/s; none within.
    pub(crate) fn overload(
        &self,
        speed: f64,
        memory: &mut Memory,
    ) -> Result<Option<f64>, EffectError> {
        let length = self.length();
        let (wrench, guess) = self.external_and_normal();
        let motion = |t: &Vector3<f64>| speed * Vector3::new(t.x, t.y, t.z / length);
        let friction = self.friction(self.local(&motion(&guess)), memory)?;
        let load = |t: &Vector3<f64>| -> Result<Vector3<f64>, EffectError> {
            let (load, _) = friction.load(&motion(t))?;
            Ok(Vector3::new(load.x, load.y, load.z / length))
        };
        overload(load, &wrench, &guess)
    }

    /// The external load and the motion that it has on the ellipsoid, both with turns as lengths.
    fn external_and_normal(&self) -> (Vector3<f64>, Vector3<f64>) {
        let torque = self.external.z / self.length();
        let force = self.external.xy();
        let along = self.support.tensor_o.exp(-2.0) * force;
        (Vector3::new(force.x, force.y, torque), Vector3::new(along.x, along.y, torque))
    }
}
