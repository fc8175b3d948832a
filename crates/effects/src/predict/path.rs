//! Where the object is on the way of a step.

use planar::Pose;

use crate::predict::forward::Forward;
use crate::{EffectError, PushPhysics, StepInput, deviations};

impl PushPhysics {
    /// Measured poses of the object at times of a step, in s from its start in rising order, expected where parameters
    /// differ from push to push: at the end as [`Self::predict`] has it, between sub-steps on a line.
    ///
    /// # Errors
    /// As [`Self::predict`].
    pub fn predict_path(&self, step: &StepInput, times: &[f64]) -> Result<Vec<Pose>, EffectError> {
        let differing = self.differing();
        let mut mean = vec![step.pose_wb; times.len()];
        for (weight, numbers) in deviations(differing.len()) {
            let trail = match differing.is_empty() {
                true => self.trail(step)?,
                false => self.deviating(&differing, &numbers, step).trail(step)?,
            };
            let start = trail[0].1;
            for (mean, time) in mean.iter_mut().zip(times) {
                let there = at(&trail, *time);
                mean.position += weight * (there.position - start.position);
                mean.angle += weight * (there.angle - start.angle);
            }
        }
        Ok(mean)
    }

    /// Times and measured poses, at the start and after each sub-step.
    fn trail(&self, step: &StepInput) -> Result<Vec<(f64, Pose)>, EffectError> {
        step.validate()?;
        self.check_in(step)?;
        let spots = self.spots(&step.object)?;
        let mut trail = Vec::new();
        let forward = Forward::new(self, step, spots.as_ref())?;
        forward.run_past(|now| trail.push((now.time, now.measured_pose())))?;
        Ok(trail)
    }
}

impl Forward<'_> {
    /// Pose of the tracked frame, in W.
    pub(crate) fn measured_pose(&self) -> Pose {
        self.measured(&self.pose_wo)
    }

    /// The same where the outline is elsewhere.
    pub(crate) fn measured(&self, pose_wo: &Pose) -> Pose {
        self.measurement.in_cameras(&(*pose_wo * self.pose_ob))
    }
}

/// The pose at a time, on the line between the moments about it.
fn at(trail: &[(f64, Pose)], time: f64) -> Pose {
    let after = trail.partition_point(|(moment, _)| *moment < time).min(trail.len() - 1);
    let ((early, before), (late, pose)) = (trail[after.saturating_sub(1)], trail[after]);
    if late <= time || late <= early {
        return pose;
    }
    let share = (time - early) / (late - early);
    Pose {
        position: before.position + share * (pose.position - before.position),
        angle: before.angle + share * (pose.angle - before.angle),
    }
}
