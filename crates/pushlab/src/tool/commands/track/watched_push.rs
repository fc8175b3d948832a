//! One push, watched step by step.

use std::time::{Duration, Instant};

use anyhow::Result;
use filter::{PlanarSummary, Simplex};
use models::{PoseSeen, PushModel, PushTracker, RecordedPush, RollOut, Watched};
use nalgebra::Vector2;
use planar::Pose;
use serde::Serialize;

/// How pushes are watched.
pub(super) struct Watching<'a> {
    pub(super) model: &'a dyn PushModel,
    /// What other pushes told.
    pub(super) others: &'a Watched,
    /// The share of the way after which the end is foreseen.
    pub(super) after: f64,
}

/// A push as it was watched.
pub(super) struct WatchedPush {
    pub(super) name: String,
    pub(super) outline: Vec<Vector2<f64>>,
    pub(super) pusher_radius: f64,
    /// Measured, at the start and after each step.
    pub(super) poses_wb: Vec<Pose>,
    /// The pusher's center at these times.
    pub(super) centers_w: Vec<Vector2<f64>>,
    /// Steps that were watched before the end was foreseen.
    pub(super) n_seen: usize,
    /// The share of the way that they are.
    pub(super) share: f64,
    pub(super) with: Foreseen,
    pub(super) without: Foreseen,
    /// The end as foreseen at the start and after each step but the last, with and without; of pushes that
    /// are drawn.
    pub(super) frames: Vec<[PlanarSummary; 2]>,
    /// How long each update took.
    pub(super) durations: Vec<Duration>,
}

/// An end as it was foreseen, beside the measured one.
#[derive(Clone, Copy, Debug, Serialize)]
pub(super) struct Foreseen {
    /// Mean and covariance in m and rad.
    pub(super) pose_wb: PlanarSummary,
    /// Distance of the measured place from the mean one, in m, and turn beyond the mean one, in rad.
    pub(super) error: [f64; 2],
    /// Level of the region on whose border the measured end is, from 0 to 1: the share of other pushes
    /// that end further in.
    pub(super) level: f64,
}

impl Watching<'_> {
    /// Watches a push from its start to its end.
    ///
    /// # Errors
    /// What the model refuses.
    pub(super) fn watch(&self, push: &RecordedPush, is_drawn: bool) -> Result<WatchedPush> {
        let settings = push.watched_settings();
        let roll_out = RollOut { model: self.model, pushed: &push.pushed, settings: &settings };
        let steps = push.path.steps(settings.step)?;
        let (n_seen, share) = RecordedPush::watched_steps(&steps, self.after);
        let start_wb = &push.poses_wb[0];
        let mut tracker =
            PushTracker::start(roll_out, start_wb, &push.path, self.others.wander, &Simplex)?;
        let seen = |k: usize| PoseSeen { pose_wb: push.poses_wb[k], sd: push.pose_sd[0] };
        let foresee = |tracker: &PushTracker<'_>, k: usize| -> Result<[PlanarSummary; 2]> {
            let without = tracker.forgetful(&seen(k))?;
            Ok([tracker.ahead(&steps[k..])?, without.ahead(&steps[k..])?])
        };
        let (mut frames, mut durations, mut ends) = (Vec::new(), Vec::new(), None);
        for (k, step) in steps.iter().enumerate() {
            if is_drawn {
                frames.push(self.scaled(foresee(&tracker, k)?));
            }
            if k == n_seen {
                ends = Some(foresee(&tracker, k)?);
                if !is_drawn {
                    break;
                }
            }
            let begin = Instant::now();
            tracker.predict(step)?;
            tracker.update(&seen(k + 1))?;
            durations.push(begin.elapsed());
        }
        let ends = match ends {
            Some(ends) => ends,
            None => foresee(&tracker, steps.len())?,
        };
        let [level, level_without] = self.others.levels(push, &ends);
        let [with, without] = self.scaled(ends);
        let centers = steps.iter().map(|step| step.end_w);
        Ok(WatchedPush {
            name: push.name.clone(),
            outline: push.pushed.shape.outline(120),
            pusher_radius: push.pushed.pusher_radius,
            poses_wb: push.poses_wb.clone(),
            centers_w: std::iter::once(push.path.start_w()).chain(centers).collect(),
            n_seen,
            share,
            with: Foreseen::of(with, push, level),
            without: Foreseen::of(without, push, level_without),
            frames,
            durations,
        })
    }

    /// With covariances such that nine in ten of the others' ends are within regions of 90 %.
    fn scaled(&self, mut ends: [PlanarSummary; 2]) -> [PlanarSummary; 2] {
        let scales = self.others.scale;
        ends.iter_mut().zip(scales).for_each(|(end, scale)| end.covariance *= scale);
        ends
    }
}

impl Foreseen {
    fn of(pose_wb: PlanarSummary, push: &RecordedPush, level: f64) -> Self {
        let end = &push.poses_wb[push.poses_wb.len() - 1];
        let off = (end.position - pose_wb.mean.xy()).norm();
        let turn = planar::wrap_angle(end.angle - pose_wb.mean.z);
        Self { pose_wb, error: [off, turn], level }
    }
}

impl WatchedPush {
    /// Its name without what no file may be called.
    pub(super) fn file_name(&self) -> String {
        let plain = |c: char| if c.is_alphanumeric() || "-_.=".contains(c) { c } else { '-' };
        self.name.chars().map(plain).collect()
    }
}
