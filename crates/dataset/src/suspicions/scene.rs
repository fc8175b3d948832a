//! What is looked at of recordings.

use crate::{Manifest, ObjectSpec, PoseStream, Recording};

use super::moment::{Moment, Motion, moments, zero};
use super::track::Track;
use crate::curves::sample::quantile;

/// All that is looked at.
pub(super) struct Scene<'a> {
    pub(super) manifest: &'a Manifest,
    /// The recordings whose object is known and moves.
    pub(super) recordings: Vec<Evidence>,
    /// Moments in which an object moves and the pusher is known, with the recording's index; where
    /// forces tell, those in which the pusher presses: a fast object leaves it.
    pub(super) seen: Vec<(usize, Moment)>,
    /// The median interval between samples of the object, in s, of every recording.
    pub(super) intervals: Vec<f64>,
    /// How many moments there are in which the pusher is known.
    pub(super) n_met: usize,
}

/// One recording.
pub(super) struct Evidence {
    pub(super) object: ObjectSpec,
    pub(super) motion: Motion,
    pub(super) robot: Track,
    /// Forces on the pusher; without samples where there are none.
    pub(super) wrench: Track,
    /// Moments of the same with the streams of pusher and object exchanged.
    pub(super) exchanged: Vec<Moment>,
    /// Largest tilt of the object, and how far its yaw goes, in rad.
    pub(super) tilt: f64,
    pub(super) turn: f64,
}

impl<'a> Scene<'a> {
    /// Takes from each recording what is looked at; those of unknown shapes and without motion give
    /// nothing.
    pub(super) fn of(
        recordings: impl IntoIterator<Item = Recording>,
        manifest: &'a Manifest,
    ) -> Self {
        let (mut seen, mut intervals, mut known) = (Vec::new(), Vec::new(), Vec::new());
        for recording in recordings {
            intervals.extend(sampling_interval(&recording.object));
            let Ok(object) = manifest.object.of(&recording.name) else { continue };
            let Some(motion) = Motion::of(&recording.object) else { continue };
            let evidence = Evidence::of(&recording, object, motion);
            let zero = zero(recording.wrench.as_ref(), &evidence.motion);
            let own = moments(&evidence.motion, &evidence.robot, &evidence.wrench, zero);
            seen.extend(own.into_iter().map(|moment| (known.len(), moment)));
            known.push(evidence);
        }
        let n_met = seen.len();
        Self { manifest, recordings: known, seen: pressing(seen), intervals, n_met }
    }

    /// The object of a recording.
    pub(super) fn object(&self, recording: usize) -> &ObjectSpec {
        &self.recordings[recording].object
    }

    /// Of the pusher, in m.
    pub(super) fn radius(&self) -> f64 {
        self.manifest.pusher.radius
    }

    /// Distance from the frame's origin to the farthest vertex of a typical object, in m.
    pub(super) fn size(&self) -> f64 {
        let radii = self.recordings.iter().map(|one| one.object.shape.bounding_radius());
        quantile(radii.collect(), 0.5).unwrap_or(0.0)
    }

    /// The pusher's median speed while the object moves, in m/s.
    pub(super) fn pusher_speed(&self) -> Option<f64> {
        let of = |moment: &Moment| {
            (moment.pusher[2] - moment.pusher[0]).norm() / (moment.t[2] - moment.t[0])
        };
        quantile(self.seen.iter().map(|(_, moment)| of(moment)).collect(), 0.5)
    }

    /// Whether a stream of forces was recorded at all.
    pub(super) fn has_forces(&self) -> bool {
        self.recordings.iter().any(|one| one.wrench.span().is_some())
    }
}

impl Evidence {
    fn of(recording: &Recording, object: ObjectSpec, motion: Motion) -> Self {
        let track = |poses: &PoseStream| Track::new(&poses.t, &poses.x, &poses.y);
        let (robot, pushed) = (track(&recording.robot), track(&recording.object));
        let wrench = recording.wrench.as_ref();
        let exchanged = Motion::of(&recording.robot);
        let exchanged = exchanged.map_or(Vec::new(), |motion| motion.with(&pushed, 0.0).collect());
        let theta = || recording.object.theta.iter().copied().filter(|theta| theta.is_finite());
        let high = theta().fold(f64::NEG_INFINITY, f64::max);
        let low = theta().fold(f64::INFINITY, f64::min);
        Self {
            object,
            motion,
            robot,
            wrench: wrench.map_or_else(Track::default, |one| Track::new(&one.t, &one.fx, &one.fy)),
            exchanged,
            tilt: recording.object.max_tilt,
            turn: high - low,
        }
    }
}

/// The moments in which there is a force, if these are enough to go by; else all.
fn pressing(seen: Vec<(usize, Moment)>) -> Vec<(usize, Moment)> {
    const PRESSES: f64 = 0.3;
    const ENOUGH: f64 = 0.2;
    let force = |moment: &Moment| moment.force.map_or(0.0, |force| force.norm());
    let large = quantile(seen.iter().map(|(_, moment)| force(moment)).collect(), 0.9);
    let least = PRESSES * large.unwrap_or(0.0);
    let pressed: Vec<_> =
        seen.iter().filter(|(_, moment)| force(moment) > least).cloned().collect();
    if (pressed.len() as f64) < ENOUGH * seen.len() as f64 { seen } else { pressed }
}

/// The median interval between the samples of the object, in s.
fn sampling_interval(object: &PoseStream) -> Option<f64> {
    let mut t = object.t.clone();
    t.sort_by(f64::total_cmp);
    let intervals = t.windows(2).map(|pair| pair[1] - pair[0]).filter(|interval| *interval > 0.0);
    quantile(intervals.collect(), 0.5)
}
