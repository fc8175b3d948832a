//! One push within a recording: its contact, its phases and the curves of each.

use serde::{Deserialize, Serialize};

use crate::error::DatasetError;
use crate::ingest::contact::{Contacts, pusher_onset, quiet_time, rest_in_contact, rest_time};
use crate::ingest::interval::Interval;
use crate::ingest::repair::{CleanStream, RepairKind};
use crate::ingest::scene::Scene;
use crate::ingest::settings::{Curve, IngestSettings};
use crate::ingest::track::{PoseNoise, PoseTrack, pose_noise};
use crate::table::step::Phase;

/// A push: a contact that moves the object, until the object rests or the next contact begins.
pub(crate) struct Push {
    /// From first to last contact.
    pub(crate) contact: Interval,
    /// Start of the first step: the first contact, or the first motion of a pusher that rests there.
    pub(crate) begins: f64,
    /// When the object comes to rest.
    pub(crate) rest: f64,
    /// Until when streams belong to this push: the next contact, a pause of the log, or their end.
    pub(crate) until: f64,
    /// Whether contact was there when pusher and object were first seen together, or again after a pause.
    pub(crate) starts_in_contact: bool,
}

/// Why a push, or a whole recording, gave no rows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", tag = "reason")]
#[non_exhaustive]
pub enum Exclusion {
    /// The recording could not be read.
    Unreadable {
        /// The error.
        error: String,
    },
    /// Pusher and object were never seen at the same time.
    NoOverlap,
    /// The pusher never touched the object.
    NoContact {
        /// Smallest distance between pusher and outline, in m.
        smallest_gap_m: Option<f64>,
    },
    /// The object stayed where it was.
    NoMotion,
    /// Too few object samples in contact.
    TooFewObjectSamples {
        /// Samples found.
        found: usize,
        /// Fewest allowed.
        needed: usize,
    },
    /// A stream is missing for too large a share of the contact.
    GapInContact {
        /// Share of the contact, 0 to 1.
        share: f64,
        /// Largest share allowed.
        limit: f64,
        /// Longest gap, in s.
        longest_s: f64,
    },
    /// The object jumps faster than anything moves, before it comes to rest.
    Teleport {
        /// The longest jump, in m.
        way_m: f64,
    },
    /// The object is tilted out of the plane.
    Tilted {
        /// Largest tilt, in rad.
        tilt_rad: f64,
        /// Largest allowed, in rad.
        limit_rad: f64,
    },
    /// The file is about another object.
    OtherShape {
        /// Its shape.
        shape: String,
        /// That of the manifest.
        object: String,
        /// How many pushes it has.
        pushes: usize,
    },
    /// Of a push of which the object's ends are known, the pusher's way is not.
    NoWay {
        /// Points of the way.
        points: usize,
    },
    /// From before the push to after it the object turns or moves as no contact makes it.
    TrackingFlip {
        /// How far it turns, in rad.
        turn_rad: f64,
        /// How far its center moves, in m.
        moved_m: f64,
        /// How far the pusher goes between its first and its last touch, in m.
        way_m: f64,
    },
    /// No step could be evaluated: the contact is too short, or each step ends in a gap.
    NoStep {
        /// Length of the contact, in s.
        contact_s: f64,
        /// Steps lost in gaps.
        lost_in_gaps: u32,
    },
}

/// The curves of pusher and object over one phase of a push.
pub(crate) struct PhaseCurves {
    pub(crate) phase: Phase,
    pub(crate) robot: PoseTrack,
    pub(crate) object: PoseTrack,
    pub(crate) from: f64,
    pub(crate) to: f64,
}

impl Push {
    /// The pushes of a recording, one for each contact.
    pub(crate) fn split(
        scene: &Scene<'_>,
        contacts: &Contacts,
        settings: &IngestSettings,
    ) -> Vec<Self> {
        let last = |stream: &CleanStream| stream.t.last().copied().unwrap_or(f64::NEG_INFINITY);
        let end = last(&scene.object).min(last(&scene.robot));
        let first = |stream: &CleanStream| stream.t.first().copied().unwrap_or(f64::INFINITY);
        let begin = first(&scene.object).max(first(&scene.robot));
        let (intervals, pauses) = (&contacts.intervals, &contacts.pauses);
        intervals
            .iter()
            .enumerate()
            .map(|(i, &contact)| {
                let paused = pauses.iter().map(|pause| pause.start).find(|t| *t >= contact.end);
                let until = intervals.get(i + 1).map_or(end, |next| next.start);
                let until = paused.map_or(until, |paused| until.min(paused));
                let resumed = pauses.iter().map(|pause| pause.end).rfind(|t| *t <= contact.start);
                let begin = resumed.unwrap_or(begin);
                // A pusher that presses at rest makes no steps.
                let begins = pusher_onset(scene, &contact, settings);
                let rest = rest_time(scene, contact.start, until, settings).unwrap_or(until);
                // What moves the object later is no motion of the push.
                let rest = rest_in_contact(scene, &contact, settings)
                    .filter(|_| rest > contact.end)
                    .or_else(|| quiet_time(scene, contact.end, rest, settings))
                    .unwrap_or(rest);
                let starts_in_contact = contact.start - begin < settings.longest_gap;
                Self { contact, begins, rest, until, starts_in_contact }
            })
            .collect()
    }

    /// End of the contact phase: the last contact or the object's rest.
    pub(crate) fn contact_end(&self) -> f64 {
        self.contact.end.min(self.rest)
    }

    /// Whether the pusher goes on without the object at the end of the contact.
    pub(crate) fn loses_contact(&self, scene: &Scene<'_>, settings: &IngestSettings) -> bool {
        const WINDOW: f64 = 0.03;
        let end = self.contact.end;
        let position = |t: f64| scene.robot_track.position(t);
        let ways = (position(end - WINDOW), position(end), position(end + WINDOW));
        let (Some(before), Some(at), Some(after)) = ways else { return false };
        let (way, way_on) = (at - before, after - at);
        way.norm() > settings.rest.pusher_speed * WINDOW
            && way_on.dot(&way) > 0.5 * way.norm_squared()
    }

    /// Whether a stated limit is exceeded.
    pub(crate) fn fault(&self, scene: &Scene<'_>, settings: &IngestSettings) -> Option<Exclusion> {
        let (from, to) = (self.begins, self.contact_end());
        if to <= from {
            return Some(Exclusion::NoMotion);
        }
        let found = scene.object.n_samples(from, to);
        let needed = settings.fewest_object_samples;
        let share = |stream: &CleanStream| {
            stream.time_in_gaps(from, to, settings.longest_gap) / (to - from)
        };
        let share = share(&scene.object).max(share(&scene.robot));
        let way_m = scene.object.largest(RepairKind::Teleport, from, self.rest.max(to));
        if found < needed {
            Some(Exclusion::TooFewObjectSamples { found, needed })
        } else if share > settings.largest_gap_share {
            let longest_s =
                scene.object.longest_gap(from, to).max(scene.robot.longest_gap(from, to));
            Some(Exclusion::GapInContact { share, limit: settings.largest_gap_share, longest_s })
        } else if way_m > 0.0 {
            Some(Exclusion::Teleport { way_m })
        } else {
            None
        }
    }

    /// The curves of the contact phase and, if the object moves on, of what follows.
    ///
    /// # Errors
    /// `SplineKnots` if repair left samples without order, which it does not.
    pub(crate) fn curves(
        &self,
        scene: &Scene<'_>,
        settings: &IngestSettings,
    ) -> Result<Vec<PhaseCurves>, DatasetError> {
        let mut spans = vec![(Phase::Contact, self.begins, self.contact_end())];
        if self.rest - self.contact_end() >= settings.shortest_step {
            spans.push((Phase::After, self.contact_end(), self.rest));
        }
        spans
            .into_iter()
            .map(|(phase, from, to)| {
                let robot = phase_track(&scene.robot, &scene.robot_track, from, to, settings)?;
                let object = phase_track(&scene.object, &scene.object_track, from, to, settings)?;
                let (from, to) = if matches!(settings.curve, Curve::Interpolate(_)) {
                    (from, to)
                } else {
                    common_span(scene, from, to)
                };
                Ok(PhaseCurves { phase, robot, object, from, to })
            })
            .collect()
    }
}

/// The recording's own curve, or a smooth one through the samples of one phase alone.
fn phase_track(
    stream: &CleanStream,
    whole: &PoseTrack,
    from: f64,
    to: f64,
    settings: &IngestSettings,
) -> Result<PoseTrack, DatasetError> {
    let noise = match settings.curve {
        Curve::Interpolate(_) => {
            let of_all = || pose_noise(stream, f64::NEG_INFINITY, f64::INFINITY);
            let noise = pose_noise(stream, from, to).or_else(of_all).unwrap_or_default();
            return Ok(whole.clone().with_noise(noise));
        }
        Curve::Smooth => pose_noise(stream, from, to).unwrap_or_default(),
        Curve::SmoothKnown { position_sd, angle_sd } => {
            PoseNoise { position: position_sd, angle: angle_sd }
        }
    };
    PoseTrack::new(stream, inner_samples(stream, from, to), settings.curve, noise)
}

/// The samples of a phase for a smooth curve.
///
/// First touch and stop are known to a sample only: the one next to a kink may lie beyond it.
fn inner_samples(stream: &CleanStream, from: f64, to: f64) -> std::ops::Range<usize> {
    let within = stream.range(from, to);
    if within.len() < 4 { within } else { within.start + 1..within.end - 1 }
}

/// The part of a phase that lies between samples of both streams.
fn common_span(scene: &Scene<'_>, from: f64, to: f64) -> (f64, f64) {
    let inside = |stream: &CleanStream| {
        let samples = &stream.t[inner_samples(stream, from, to)];
        (samples.first().copied().unwrap_or(to), samples.last().copied().unwrap_or(from))
    };
    let ((robot_from, robot_to), (object_from, object_to)) =
        (inside(&scene.robot), inside(&scene.object));
    (robot_from.max(object_from), robot_to.min(object_to))
}
