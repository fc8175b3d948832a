//! A push rolled out, with all that is written of it.

use anyhow::Result;
use filter::{PlanarSummary, Weights};
use models::{
    ContactGap, Moment, PushModel, PushParticle, PushPath, Pushed, RollOut, RollOutSettings,
    StepErrors,
};
use nalgebra::Vector2;
use planar::Pose;
use serde::Serialize;

use super::method::Method;

/// Poses of some of the particles.
pub(super) type Snapshot = Vec<Pose>;

/// Most particles that are drawn or logged of a moment.
const MOST_SHOWN: usize = 500;
/// The quantiles that are told.
pub(super) const PROBABILITIES: [f64; 3] = [0.025, 0.5, 0.975];

/// What is to be rolled out.
pub(super) struct Task {
    pub(super) name: String,
    pub(super) pushed: Pushed,
    pub(super) path: PushPath,
    pub(super) start_wb: Pose,
    /// Of a recorded push, at the start and after each step, or at its ends alone.
    pub(super) measured_wb: Option<Vec<Pose>>,
    /// Of the measured start and end: in m, and in rad.
    pub(super) pose_sd: [[f64; 2]; 2],
    /// Whether it starts in contact, whatever its poses say.
    pub(super) touching: bool,
}

/// A push rolled out.
pub(super) struct Rolled {
    pub(super) name: String,
    pub(super) outline: Vec<Vector2<f64>>,
    pub(super) pusher_radius: f64,
    pub(super) path: PushPath,
    pub(super) moments: Vec<Moment>,
    /// Of x, y in m and angle in rad at each moment, by [`PROBABILITIES`].
    pub(super) quantiles: Vec<Vec<[f64; 3]>>,
    /// At each moment; none without particles.
    pub(super) snapshots: Option<Vec<Snapshot>>,
    /// Of a recorded push at each moment, where it was measured.
    pub(super) measured_wb: Option<Vec<Option<Pose>>>,
    /// Of a recorded push.
    pub(super) end: Option<MeasuredEnd>,
}

/// Where a recorded push ended among the particles.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct MeasuredEnd {
    /// Measured pose: x, y in m, angle in rad.
    pub(super) pose_wb: [f64; 3],
    /// Its distance from the mean place, in m, and the turn beyond the mean one, in rad.
    pub(super) error: [f64; 2],
    /// Level of the region of the particles on whose border it is, from 0 to 1.
    pub(super) level: f64,
}

/// What is known of the object at every moment of a push.
struct Motion {
    moments: Vec<Moment>,
    quantiles: Vec<Vec<[f64; 3]>>,
    snapshots: Option<Vec<Snapshot>>,
    /// Of the region on whose border the measured end is, if there is one.
    level: f64,
}

impl Task {
    /// Rolls out by particles, or by a method without.
    ///
    /// # Errors
    /// What the model or the path does not allow.
    pub(super) fn roll_out(
        self,
        model: &dyn PushModel,
        settings: &RollOutSettings,
        matched: Option<Method>,
    ) -> Result<Rolled> {
        let (start_sd, touching) = (self.pose_sd[0], self.touching);
        let settings = RollOutSettings { start_sd, touching, ..settings.clone() };
        let roll_out = RollOut { model, pushed: &self.pushed, settings: &settings };
        let Motion { moments, quantiles, snapshots, level } = match matched {
            Some(method) => self.matched(&roll_out, method)?,
            None => self.by_particles(&roll_out)?,
        };
        let mean = moments[moments.len() - 1].pose_wb.mean;
        let end = self.measured_end().map(|end| MeasuredEnd {
            pose_wb: place(&end),
            error: [(end.position - mean.xy()).norm(), planar::wrap_angle(end.angle - mean.z)],
            level,
        });
        Ok(Rolled {
            name: self.name,
            outline: self.pushed.shape.outline(120),
            pusher_radius: model.true_outline(&self.pushed)?.pusher_radius(),
            path: self.path,
            measured_wb: self.measured_wb.map(|poses| at_moments(&poses, moments.len())),
            moments,
            quantiles,
            snapshots,
            end,
        })
    }

    fn measured_end(&self) -> Option<Pose> {
        self.measured_wb.as_ref().and_then(|poses| poses.last()).copied()
    }

    fn by_particles(&self, roll_out: &RollOut<'_>) -> Result<Motion> {
        let n_particles = roll_out.settings.n_particles;
        let weights = Weights::equal(n_particles);
        let every = n_particles.div_ceil(MOST_SHOWN).max(1);
        let (mut quantiles, mut snapshots) = (Vec::new(), Vec::new());
        let (mut failed, mut level) = (Ok(()), 0.0);
        let end = self.measured_end();
        let watch = |moment: &Moment, particles: &[PushParticle]| {
            snapshots.push(particles.iter().step_by(every).map(|one| one.pose_wb).collect());
            let summary = &moment.pose_wb;
            match summary.quantiles(particles, &weights, &PROBABILITIES) {
                Ok(found) => quantiles.push(found.into_iter().map(Into::into).collect()),
                Err(error) => failed = Err(error),
            }
            match end.map(|end| summary.level(particles, &weights, place(&end), self.pose_sd[1])) {
                Some(Ok(found)) => level = found,
                Some(Err(error)) => failed = Err(error),
                None => {}
            }
        };
        let moments = roll_out.run(&self.start_wb, &self.path, watch)?;
        failed?;
        Ok(Motion { moments, quantiles, snapshots: Some(snapshots), level })
    }

    /// Events are those of the model's mean way.
    fn matched(&self, roll_out: &RollOut<'_>, method: Method) -> Result<Motion> {
        let mixtures = roll_out.matched(&self.start_wb, &self.path, method.matching(), 1)?;
        let alone = RollOutSettings {
            n_particles: 1,
            errors: StepErrors::None,
            start_sd: [0.0; 2],
            gap: ContactGap { sd: 0.0, ..roll_out.settings.gap },
            ..roll_out.settings.clone()
        };
        let alone = RollOut { settings: &alone, ..*roll_out };
        let mut moments = alone.run(&self.start_wb, &self.path, |_, _| {})?;
        let (mut quantiles, mut level) = (Vec::new(), 0.0);
        for (moment, mixture) in moments.iter_mut().zip(mixtures) {
            moment.pose_wb = PlanarSummary::of_gaussian(&mixture.moments()?)?;
            let found = moment.pose_wb.gaussian_quantiles(&PROBABILITIES)?;
            quantiles.push(found.into_iter().map(Into::into).collect());
            if let Some(end) = self.measured_end() {
                level = moment.pose_wb.gaussian_level(place(&end), self.pose_sd[1]);
            }
        }
        Ok(Motion { moments, quantiles, snapshots: None, level })
    }
}

/// The measured pose at each of so many moments: at the first and the last where there are no others.
fn at_moments(poses: &[Pose], n_moments: usize) -> Vec<Option<Pose>> {
    if poses.len() == n_moments {
        return poses.iter().copied().map(Some).collect();
    }
    let mut found = vec![None; n_moments];
    if let ([first, .., last], [start, .., end]) = (poses, found.as_mut_slice()) {
        (*start, *end) = (Some(*first), Some(*last));
    }
    found
}

fn place(pose: &Pose) -> [f64; 3] {
    [pose.position.x, pose.position.y, pose.angle]
}

impl Rolled {
    /// The share of the pushed particle steps at which the model was asked beyond its training.
    pub(super) fn unseen(&self) -> f64 {
        let sum = |count: fn(&Moment) -> usize| self.moments.iter().map(count).sum::<usize>();
        let pushed = sum(|moment| moment.events.pushed);
        if pushed == 0 { 0.0 } else { sum(|moment| moment.events.unseen) as f64 / pushed as f64 }
    }

    /// Its name without what no file may be called.
    pub(super) fn file_name(&self) -> String {
        let plain = |c: char| if c.is_alphanumeric() || "-_.=".contains(c) { c } else { '-' };
        self.name.chars().map(plain).collect()
    }
}
