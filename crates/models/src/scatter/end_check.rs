//! How often regions of roll-outs hold the ends of pushes.

use filter::{PlanarSummary, Weights};

use crate::{
    EndCheck, ModelError, PushModel, PushParticle, RecordedPush, RollOut, RollOutSettings,
    StepCorrelation, StepErrors,
};

impl EndCheck {
    const N_PARTICLES: usize = 200;

    /// Rolls recorded pushes out with errors that go together as it was measured: each by a model of its
    /// own, which has not seen it.
    ///
    /// # Errors
    /// As [`RollOut::run`].
    pub(crate) fn of<'a, 'm>(
        correlation: &StepCorrelation,
        pushes: impl IntoIterator<Item = (&'m dyn PushModel, &'a RecordedPush)>,
    ) -> Result<Self, ModelError> {
        let settings = RollOutSettings {
            n_particles: Self::N_PARTICLES,
            errors: StepErrors::Held(correlation.clone()),
            gap: correlation.gap,
            touching: true,
            ..RollOutSettings::default()
        };
        let (mut n_pushes, mut n_within) = (0, [0; 3]);
        for (model, push) in pushes {
            let level = push.end_level(model, &settings)?;
            n_pushes += 1;
            let counts = n_within.iter_mut().zip(Self::LEVELS);
            counts.for_each(|(count, known)| *count += usize::from(level <= known));
        }
        Ok(Self { n_pushes, n_within })
    }
}

impl RecordedPush {
    /// The level of the region of a roll-out's particles on whose border the measured end lies.
    pub(super) fn end_level(
        &self,
        model: &dyn PushModel,
        settings: &RollOutSettings,
    ) -> Result<f64, ModelError> {
        let longest = self.steps.iter().map(|step| step.input.distance()).fold(0.0, f64::max);
        let settings = RollOutSettings {
            start_sd: self.pose_sd[0],
            // Steps as they were recorded.
            step: 1.01 * longest,
            ..settings.clone()
        };
        let roll_out = RollOut { model, pushed: &self.pushed, settings: &settings };
        let mut particles: Vec<PushParticle> = Vec::new();
        roll_out.run(&self.poses_wb[0], &self.path, |_, now| particles = now.to_vec())?;
        let weights = Weights::equal(particles.len());
        let end_wb = &self.poses_wb[self.poses_wb.len() - 1];
        let measured = [end_wb.position.x, end_wb.position.y, end_wb.angle];
        let summary = PlanarSummary::of(&particles, &weights)?;
        Ok(summary.level(&particles, &weights, measured, self.pose_sd[1])?)
    }
}
