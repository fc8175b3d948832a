//! Particles that carry what neighboring steps share, rather than draw it.

use filter::{
    Gaussian, LinearMeasurement, LinearMotion, MotionModel, ParticleFilter, RaoBlackwellized,
    Settings,
};
use nalgebra::{DMatrix, DVector, Vector3};
use planar::Pose;
use rand::Rng;

use super::{PushMotion, PushParticle, RollOut, StepErrors};
use crate::{ModelError, PathStep, PushPath, StepCorrelation};

/// One step of a path as a motion of particles of which each carries a Gaussian over the numbers that
/// neighboring steps share ([`StepErrors::Held`]): a Rao–Blackwellised filter's motion.
///
/// A pose is not linear in the one before, but in these numbers it is: so poses are drawn, and each draw
/// tells the particle's Gaussian what it was.
#[derive(Clone, Debug)]
pub struct CarriedMotion<'a> {
    motion: PushMotion<'a>,
    correlation: &'a StepCorrelation,
    kept: f64,
}

/// What of a share is left open where none is, for numbers that are known exactly.
const LEAST_SHARE: f64 = 1e-9;

impl<'a> RollOut<'a> {
    /// Particles at the start that carry Gaussians, for a filter of one's own.
    ///
    /// # Errors
    /// As [`RollOut::start`].
    pub fn start_carried(
        &self,
        start_wb: &Pose,
        path: &PushPath,
    ) -> Result<ParticleFilter<'static, RaoBlackwellized<PushParticle>>, ModelError> {
        let gaussian = Gaussian::independent(DVector::zeros(3), &[1.0; 3])?;
        let drawn = self.start(start_wb, path)?;
        let carried = |drawn: &PushParticle| RaoBlackwellized {
            drawn: drawn.clone(),
            gaussian: gaussian.clone(),
        };
        let settings = Settings { seed: self.settings.seed, ..Settings::default() };
        Ok(ParticleFilter::new(drawn.particles().iter().map(carried).collect(), settings)?)
    }

    /// One step as a motion of such particles; none where steps share nothing.
    ///
    /// # Errors
    /// As [`RollOut::motion`].
    pub fn carried_motion(&self, step: &PathStep) -> Result<Option<CarriedMotion<'a>>, ModelError> {
        let StepErrors::Held(correlation) = &self.settings.errors else { return Ok(None) };
        let Self { model, pushed, settings } = *self;
        let outline = model.true_outline(pushed)?;
        let motion = PushMotion { model, pushed, outline, settings, step: *step };
        let kept = correlation.kept(step.distance());
        Ok(Some(CarriedMotion { motion, correlation, kept }))
    }
}

impl CarriedMotion<'_> {
    /// What a draw says of the numbers: whitened = s (√held · numbers + √own · noise).
    fn told(
        &self,
        state: &RaoBlackwellized<PushParticle>,
        whitened: &Vector3<f64>,
    ) -> Result<Gaussian, ModelError> {
        let size = state.drawn.size;
        let root = |shares: &[f64; 3], k: usize| size * (shares[k] + LEAST_SHARE).sqrt();
        let own = [0, 1, 2].map(|k| root(&self.correlation.own, k));
        let held = DVector::from_fn(3, |k, _| root(&self.correlation.held, k));
        let noise = Gaussian::independent(DVector::zeros(3), &own)?;
        let drawn = DVector::from_column_slice(whitened.as_slice());
        let told = LinearMeasurement::new(drawn, DMatrix::from_diagonal(&held), noise)?;
        Ok(state.gaussian.updated(&told)?.posterior)
    }
}

impl MotionModel for CarriedMotion<'_> {
    type State = RaoBlackwellized<PushParticle>;
    type Error = ModelError;

    fn advance(&self, states: &mut [Self::State], random: &mut dyn Rng) -> Result<(), ModelError> {
        let draw = |state: &Self::State, random: &mut dyn Rng| {
            let held = state.gaussian.sample(random);
            let held = Vector3::new(held[0], held[1], held[2]);
            PushParticle { held, ..state.drawn.clone() }
        };
        let mut drawn: Vec<PushParticle> =
            states.iter().map(|state| draw(state, &mut *random)).collect();
        let mut draws = vec![None; states.len()];
        self.motion.advance_each(&mut drawn, random, |index, draw| {
            draws[index] = Some(draw.whitened());
        })?;
        let new = (1.0 - self.kept * self.kept).sqrt();
        let new = Gaussian::independent(DVector::zeros(3), &[new; 3])?;
        let forget = LinearMotion::new(self.kept * DMatrix::identity(3, 3), new)?;
        for ((state, drawn), draw) in states.iter_mut().zip(drawn).zip(draws) {
            let known = match draw {
                Some(whitened) => self.told(state, &whitened)?,
                None => state.gaussian.clone(),
            };
            *state =
                RaoBlackwellized { drawn, gaussian: known.predicted(&forget)?.state().clone() };
        }
        Ok(())
    }
}
