//! One turn of the pushes with models trained on it: what figures 6.1 to 6.5 are drawn from.

use anyhow::{Context, Result};
use models::{
    Moment, PushModel, PushParticle, RecordedPush, RollOut, RollOutSettings, StepCorrelation,
    StepErrors,
};
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

use super::ends::recorded_settings;
use super::pushes::turns;
use super::trained::{Learnt, Setting, Trained, learn};
use crate::figures::seed::SEED;

/// Models trained on one part of the pushes, and another part to be rolled out.
pub(crate) struct Scene {
    pub(super) test: Vec<RecordedPush>,
    pub(super) gp: Trained,
    pub(super) analytical: Trained,
    /// Of the Gaussian process.
    pub(super) correlation: StepCorrelation,
}

/// A push rolled out.
pub(super) struct Rolled {
    pub(super) moments: Vec<Moment>,
    /// The particles at each of them.
    pub(super) particles: Vec<Vec<PushParticle>>,
}

impl Scene {
    /// Trains on one turn of the pushes.
    ///
    /// # Errors
    /// What a fit says.
    pub(crate) fn of(pushes: &[RecordedPush], setting: &Setting) -> Result<Self> {
        let turns = turns(pushes);
        let turn = turns.first().context("pushes take turns")?;
        let mut learnt = learn(setting, turn, &["analytical", "gp"])?;
        let Learnt { trained: gp, correlation } = learnt.pop().context("a process was trained")?;
        let analytical = learnt.pop().context("a model was fitted")?.trained;
        let test = turn.test.iter().map(|push| (*push).clone()).collect();
        Ok(Self { test, gp, analytical, correlation })
    }

    /// Settings for a recorded push whose errors are held as they were measured.
    pub(super) fn held(&self, n_particles: usize) -> RollOutSettings {
        let errors = StepErrors::Held(self.correlation.clone());
        let settings = recorded_settings(self.correlation.gap);
        RollOutSettings { n_particles, seed: SEED, errors, ..settings }
    }

    /// The test push nearest to a place and an angle.
    pub(super) fn nearest(&self, [p, beta]: [f64; 2]) -> Result<&RecordedPush> {
        let off = |push: &RecordedPush| {
            let input = &push.steps[0].input;
            (input.p() - p).hypot((input.beta() - beta) / std::f64::consts::PI)
        };
        let nearest = self.test.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
        nearest.context("there are pushes to test")
    }

    /// All test pushes by a model.
    ///
    /// # Errors
    /// What the model says.
    pub(super) fn all(
        &self,
        model: &dyn PushModel,
        settings: &RollOutSettings,
    ) -> Result<Vec<Rolled>> {
        self.test.par_iter().map(|push| Rolled::of(model, push, settings)).collect()
    }
}

impl Rolled {
    /// A recorded push from its measured start.
    ///
    /// # Errors
    /// What the model says.
    pub(super) fn of(
        model: &dyn PushModel,
        push: &RecordedPush,
        settings: &RollOutSettings,
    ) -> Result<Self> {
        let settings = RollOutSettings { start_sd: push.pose_sd[0], ..settings.clone() };
        let mut particles = Vec::new();
        let roll_out = RollOut { model, pushed: &push.pushed, settings: &settings };
        let watch = |_: &Moment, now: &[PushParticle]| particles.push(now.to_vec());
        let moments = roll_out.run(&push.poses_wb[0], &push.path, watch)?;
        Ok(Self { moments, particles })
    }

    /// Places of the particles at a moment, in m.
    pub(super) fn places(&self, moment: usize) -> Vec<[f64; 2]> {
        self.particles[moment].iter().map(|particle| particle.pose_wb.position.into()).collect()
    }

    pub(super) fn last(&self) -> usize {
        self.moments.len() - 1
    }
}

/// Where and how a push begins, in words.
pub(super) fn place_of(push: &RecordedPush) -> String {
    let input = &push.steps[0].input;
    // Adding 0 leaves no "-0".
    format!("p = {:.2}, β = {:.0}°", input.p(), input.beta().to_degrees().round() + 0.0)
}
