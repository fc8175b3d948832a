//! A recording made ready for questions: repaired streams, curves and the object's outline.

use nalgebra::Vector2;
use planar::{Contact, Pose, Shape};

use crate::curves::spline::EndCondition;
use crate::error::DatasetError;
use crate::ingest::interval::Interval;
use crate::ingest::repair::{CleanStream, repair_forces, repair_poses, repair_positions};
use crate::ingest::settings::{Curve, IngestSettings};
use crate::ingest::track::{PoseNoise, PoseTrack, pose_noise};
use crate::recording::Recording;

/// One recording with its streams in order.
pub(crate) struct Scene<'a> {
    pub(crate) robot: CleanStream,
    pub(crate) object: CleanStream,
    pub(crate) wrench: Option<CleanStream>,
    pub(crate) robot_track: PoseTrack,
    pub(crate) object_track: PoseTrack,
    pub(crate) outline: Outline<'a>,
}

/// The object's outline and the pusher that meets it.
#[derive(Clone, Copy)]
pub(crate) struct Outline<'a> {
    pub(crate) shape: &'a Shape,
    pub(crate) pusher_radius: f64,
}

/// The gap between pusher and outline, sampled at the robot's stamps.
pub(crate) struct GapSample {
    pub(crate) t: f64,
    pub(crate) gap: f64,
}

impl<'a> Scene<'a> {
    /// Repairs the streams and lays curves through the whole of them.
    ///
    /// # Errors
    /// `SplineKnots` if repair left samples without order, which it does not.
    pub(crate) fn new(
        recording: &Recording,
        outline: Outline<'a>,
        settings: &IngestSettings,
    ) -> Result<Self, DatasetError> {
        let robot = repair_positions(&recording.robot, settings);
        let object = repair_poses(&recording.object, settings);
        let wrench = recording.wrench.as_ref().map(|wrench| repair_forces(wrench, settings));
        let curve = match settings.curve {
            Curve::Interpolate(ends) => Curve::Interpolate(ends),
            Curve::Smooth | Curve::SmoothKnown { .. } => Curve::Interpolate(EndCondition::Natural),
        };
        // The noise belongs to a phase of a push and is estimated with it.
        let track = |stream: &CleanStream| {
            PoseTrack::new(stream, 0..stream.t.len(), curve, PoseNoise::default())
        };
        let (robot_track, object_track) = (track(&robot)?, track(&object)?);
        Ok(Self { robot, object, wrench, robot_track, object_track, outline })
    }

    /// Where the pusher is nearest to the outline, in the body frame, and the object's pose.
    pub(crate) fn contact_at(&self, t: f64) -> Option<(Contact, Pose)> {
        self.outline.contact(&self.robot_track, &self.object_track, t)
    }

    /// The gap at every robot stamp at which it is defined.
    pub(crate) fn gaps(&self) -> Vec<GapSample> {
        let gap = |(t, place): (f64, Vector2<f64>)| {
            let contact = self.outline.contact_of(&place, &self.object_track.pose(t)?);
            Some(GapSample { t, gap: contact.gap })
        };
        self.robot_track.knots().filter_map(gap).collect()
    }

    /// Times of `shortest` (s) to a day without a sample of either body, between their first and last; over
    /// more a clock jumped.
    pub(crate) fn pauses(&self, shortest: f64) -> Vec<Interval> {
        const DAY: f64 = 86_400.0;
        let mut stamps: Vec<f64> = self.robot.t.iter().chain(&self.object.t).copied().collect();
        stamps.sort_unstable_by(f64::total_cmp);
        let between = stamps.windows(2).filter(|pair| {
            let time = pair[1] - pair[0];
            time > shortest && time < DAY
        });
        between.map(|pair| Interval { start: pair[0], end: pair[1] }).collect()
    }

    /// Force on the pusher at a time, by a line between neighbors; none in a gap.
    pub(crate) fn force_at(&self, t: f64, longest_gap: f64) -> Option<Vector2<f64>> {
        let wrench = self.wrench.as_ref()?;
        let i = wrench.t.partition_point(|&stamp| stamp <= t);
        if i == 0 || (i == wrench.t.len() && wrench.t[i - 1] < t) {
            return None;
        }
        let i = i.min(wrench.t.len() - 1);
        if i == 0 || wrench.t[i] - wrench.t[i - 1] > longest_gap {
            return None;
        }
        let b = (t - wrench.t[i - 1]) / (wrench.t[i] - wrench.t[i - 1]);
        let between = |k: usize| {
            let channel = &wrench.channels[k];
            (1.0 - b) * channel[i - 1] + b * channel[i]
        };
        Some(Vector2::new(between(0), between(1)))
    }

    /// Noise of the object's samples between two times; without enough of them, of all.
    pub(crate) fn object_noise(&self, from: f64, to: f64) -> PoseNoise {
        pose_noise(&self.object, from, to)
            .or_else(|| pose_noise(&self.object, f64::NEG_INFINITY, f64::INFINITY))
            .unwrap_or_default()
    }
}

impl Outline<'_> {
    /// Where the pusher is nearest to the outline, in the body frame, and the object's pose.
    pub(crate) fn contact(
        &self,
        robot: &PoseTrack,
        object: &PoseTrack,
        t: f64,
    ) -> Option<(Contact, Pose)> {
        let pose = object.pose(t)?;
        Some((self.contact_of(&robot.position(t)?, &pose), pose))
    }

    /// The same of a pusher and an object whose places are known.
    fn contact_of(&self, pusher: &Vector2<f64>, pose: &Pose) -> Contact {
        self.shape.contact(&pose.inverse_transform_point(pusher), self.pusher_radius)
    }

    /// Way along the outline from edge 0, p 0 to the contact, in m.
    pub(crate) fn arc_length(&self, contact: &Contact) -> f64 {
        match self.shape {
            Shape::Polygon(polygon) => polygon
                .edges()
                .take(contact.edge + 1)
                .enumerate()
                .map(|(i, (a, b))| (b - a).norm() * if i == contact.edge { contact.p } else { 1.0 })
                .sum(),
            Shape::Ellipse(ellipse) => contact.p * ellipse.perimeter(),
        }
    }

    /// The shorter way along the outline from one contact to another, larger p positive, in m.
    pub(crate) fn way(&self, from: &Contact, to: &Contact) -> f64 {
        let perimeter = self.shape.perimeter();
        let way = self.arc_length(to) - self.arc_length(from);
        way - perimeter * (way / perimeter).round()
    }

    /// Distance along the edge from the contact to the nearer vertex, in m; none where smooth.
    pub(crate) fn vertex_distance(&self, contact: &Contact) -> Option<f64> {
        match self.shape {
            Shape::Polygon(polygon) => {
                let (a, b) = polygon.edges().nth(contact.edge)?;
                Some((b - a).norm() * contact.p.min(1.0 - contact.p))
            }
            Shape::Ellipse(_) => None,
        }
    }
}
