//! Pushes of which the object's ends alone are known: a row each.

use std::path::Path;
use std::sync::Arc;

use nalgebra::Vector2;
use planar::{Contact, Pose, cross, perpendicular, wrap_angle};

use crate::curves::noise::median;
use crate::ingest::push::Exclusion;
use crate::ingest::report::{PushReport, RecordingReport};
use crate::ingest::scene::Outline;
use crate::ingest::settings::IngestSettings;
use crate::manifest::object::ObjectSpec;
use crate::manifest::recording_set::RecordingSet;
use crate::recording::whole_push::{EndPoints, WholePush, WholePushes};
use crate::table::flags::Flags;
use crate::table::step::{ContactForce, StepForce, StepRow};

/// Rows and report of each recording in a file of end points.
pub(crate) fn whole_pushes(
    set: &RecordingSet,
    path: &Path,
    found: EndPoints,
    settings: &IngestSettings,
) -> Vec<(Vec<StepRow>, RecordingReport)> {
    let EndPoints { sha256, sets } = found;
    let of = |pushes: WholePushes| {
        let mut report = RecordingReport::unread(&pushes.recording, path);
        let object = match set.manifest().object.of(&pushes.recording) {
            Ok(object) => object,
            Err(error) => {
                report.excluded = Some(Exclusion::Unreadable { error: error.to_string() });
                return (Vec::new(), report);
            }
        };
        if let Some(shape) = pushes.shape.filter(|shape| *shape != object.name) {
            let (object, pushes) = (object.name, pushes.pushes.len());
            report.excluded = Some(Exclusion::OtherShape { shape, object, pushes });
            return (Vec::new(), report);
        }
        report.sha256.clone_from(&sha256);
        report.session = set.session(&report.name).map(|session| session.session.clone());
        let outline = Outline { shape: &object.shape, pusher_radius: set.manifest().pusher.radius };
        let rig = Rig { outline, object: &object, settings };
        let mut rows = Vec::new();
        for push in pushes.pushes {
            let (row, push_report) = rig.push(&push, &report);
            rows.extend(row);
            report.pushes.push(push_report);
        }
        (rows, report)
    };
    sets.into_iter().map(of).collect()
}

struct Rig<'a> {
    outline: Outline<'a>,
    object: &'a ObjectSpec,
    settings: &'a IngestSettings,
}

/// How closely a touch is found, in m.
const TOUCH: f64 = 1e-6;
/// A way this near to its simpler form is that, in m.
const STRAIGHT: f64 = 1.5e-4;
/// Nearer than this to the outline, a pusher may have touched it, in m: outlines and poses are not exact.
const NEAR: f64 = 6e-3;
/// Less turn, in rad, is never taken for an error of tracking.
const LEAST_FLIP: f64 = std::f64::consts::FRAC_PI_4;
/// A pusher further from the outline at the end has left it, in m.
const LEFT: f64 = 2e-3;
/// Of its usual size, at which a force is taken to move the object.
const PRESSES: f64 = 0.5;
/// Samples in a row that have to press.
const IN_A_ROW: usize = 3;

impl Rig<'_> {
    fn push(&self, push: &WholePush, recording: &RecordingReport) -> (Option<StepRow>, PushReport) {
        let mut report = push_report(push.push);
        let row = self.way(push).and_then(|way| {
            self.fault(push, &way).map_or_else(|| Ok(self.row(push, &way, recording)), Err)
        });
        match row {
            Ok(row) => {
                report.rows = 1;
                (report.contact_start_s, report.contact_end_s) = (row.t, row.t + row.dt);
                report.rest_s = report.contact_end_s;
                report.starts_in_contact = row.flags.contains(Flags::STARTS_IN_CONTACT);
                report.contact_lost = row.gap_end > LEFT;
                report.steady_force_n = usual_force(&push.force);
                (Some(row), report)
            }
            Err(reason) => {
                report.excluded = Some(reason);
                (None, report)
            }
        }
    }

    /// The pusher's way, of few points.
    fn way(&self, push: &WholePush) -> Result<Vec<(f64, Vector2<f64>)>, Exclusion> {
        let points = &push.tip;
        let duration =
            points.last().zip(points.first()).map_or(0.0, |(last, first)| last.0 - first.0);
        let way: f64 = points.windows(2).map(|pair| (pair[1].1 - pair[0].1).norm()).sum();
        if !(duration >= 1e-9 && way > 0.0) {
            return Err(Exclusion::NoWay { points: points.len() });
        }
        Ok(simpler(points))
    }

    fn contact(&self, pose: &Pose, center_w: &Vector2<f64>) -> Contact {
        let Outline { shape, pusher_radius } = self.outline;
        shape.contact(&pose.inverse_transform_point(center_w), pusher_radius)
    }

    /// A motion that no contact makes.
    ///
    /// While a pusher goes on by L it turns an object by L/(2 c) at most, with c of its limit surface;
    /// twice that with c of uniform pressure is no push of any pressure that feet have.
    fn fault(&self, push: &WholePush, way: &[(f64, Vector2<f64>)]) -> Option<Exclusion> {
        let (start, end) = (&push.object_start, &push.object_end);
        let turn_rad = wrap_angle(end.angle - start.angle);
        let center = self.outline.shape.centroid();
        let moved_m = (end.transform_point(&center) - start.transform_point(&center)).norm();
        let near = |pose: &Pose, point: &Vector2<f64>| self.contact(pose, point).gap < NEAR;
        let points = finely(way);
        let first = points.iter().position(|point| near(start, point));
        let last = points.iter().rposition(|point| near(end, point));
        let way_m: f64 = match (first, last) {
            (Some(first), Some(last)) if first < last => {
                points[first..=last].windows(2).map(|pair| (pair[1] - pair[0]).norm()).sum()
            }
            _ => 0.0,
        };
        let length = self.outline.shape.mean_distance(&center);
        let is_flip = turn_rad.abs() > LEAST_FLIP && turn_rad.abs() > way_m / length;
        let is_jump = first.is_none() && moved_m > NEAR;
        (is_flip || is_jump).then_some(Exclusion::TrackingFlip { turn_rad, moved_m, way_m })
    }

    fn row(
        &self,
        push: &WholePush,
        way: &[(f64, Vector2<f64>)],
        recording: &RecordingReport,
    ) -> StepRow {
        let (start, end) = (way[0], way[way.len() - 1]);
        let (pose, dt) = (&push.object_start, end.0 - start.0);
        let velocity = (end.1 - start.1) / dt;
        let speed = velocity.norm();
        let touch = self.first_touch(pose, way);
        let contact = self.contact(pose, &touch.1);
        let edge_normal =
            pose.rotate(&self.outline.shape.inward_normal_at(contact.edge, contact.p));
        let at_rest = speed < self.settings.rest.pusher_speed;
        let along = if at_rest { edge_normal } else { velocity / speed };
        let beta =
            if at_rest { 0.0 } else { cross(&edge_normal, &along).atan2(edge_normal.dot(&along)) };
        let moved = push.object_end.position - pose.position;
        let last = self.contact(&push.object_end, &end.1);
        let gap_start = self.contact(pose, &start.1).gap;
        let mut flags = Flags::WHOLE_PUSH;
        flags.set_if(Flags::STARTS_IN_CONTACT, gap_start <= TOUCH);
        flags.set_if(Flags::PUSHER_AT_REST, at_rest);
        let inner = &way[1..way.len() - 1];
        StepRow {
            recording: Arc::from(recording.name.as_str()),
            session: push.session.as_deref().or(recording.session.as_deref()).map(Arc::from),
            push: push.push,
            t: push.t + start.0,
            dt,
            n_samples: 2,
            shape: Arc::from(self.object.name.as_str()),
            edge: contact.edge as u32,
            p: contact.p,
            beta,
            speed,
            object_pose: *pose,
            pusher_start: start.1,
            pusher_end: end.1,
            pusher_way: inner.iter().map(|(t, point)| (t - start.0, *point)).collect(),
            pusher_velocity: velocity,
            contact_point: pose.transform_point(&contact.point),
            contact_normal: pose.rotate(&contact.normal),
            dx: along.dot(&moved),
            dy: perpendicular(&along).dot(&moved),
            dtheta: wrap_angle(push.object_end.angle - pose.angle),
            force: self.force(push, touch.0, end.0),
            gap_start,
            gap_end: last.gap,
            slip: self.outline.way(&contact, &last),
            flags,
            ..StepRow::default()
        }
    }

    /// Time and place of the first touch of the resting object, or of the start where there is none.
    ///
    /// No point of the outline is nearer than the gap, so that a way as long as the gap meets none.
    fn first_touch(&self, pose: &Pose, way: &[(f64, Vector2<f64>)]) -> (f64, Vector2<f64>) {
        for pair in way.windows(2) {
            let length = (pair[1].1 - pair[0].1).norm();
            let mut gone = 0.0;
            while gone < length {
                let t = pair[0].0 + gone / length * (pair[1].0 - pair[0].0);
                let point = between(pair[0], pair[1], t);
                let gap = self.contact(pose, &point).gap;
                if gap <= TOUCH {
                    return (t, point);
                }
                gone += gap;
            }
        }
        way[0]
    }

    /// The mean force from its onset on, in the frame of the contact with an object that moves evenly
    /// from its first touch on.
    fn force(&self, push: &WholePush, touch: f64, to: f64) -> Option<StepForce> {
        let from = onset(&push.force, self.settings.contact.least_force).unwrap_or(touch);
        let forces: Vec<ContactForce> = push
            .force
            .iter()
            .filter(|(t, _)| (from..=to).contains(t))
            .map(|(t, force)| {
                let share = ((t - touch) / (to - touch)).clamp(0.0, 1.0);
                let pose = part(&push.object_start, &push.object_end, share);
                let center = at(&push.tip, *t);
                let normal = pose.rotate(&self.contact(&pose, &center).normal);
                let tangential = perpendicular(&normal).dot(force);
                ContactForce { normal: normal.dot(force), tangential }
            })
            .collect();
        let n = forces.len() as f64;
        let mean = |of: fn(&ContactForce) -> f64| forces.iter().map(of).sum::<f64>() / n;
        Some(StepForce {
            mean: ContactForce { normal: mean(|f| f.normal), tangential: mean(|f| f.tangential) },
            start: *forces.first()?,
            end: *forces.last()?,
        })
    }
}

/// A share of the way from one pose to another, both position and the shorter turn.
fn part(start: &Pose, end: &Pose, share: f64) -> Pose {
    Pose {
        position: start.position + share * (end.position - start.position),
        angle: start.angle + share * wrap_angle(end.angle - start.angle),
    }
}

fn between(a: (f64, Vector2<f64>), b: (f64, Vector2<f64>), t: f64) -> Vector2<f64> {
    a.1 + (t - a.0) / (b.0 - a.0) * (b.1 - a.1)
}

/// Where the pusher is at a time.
fn at(points: &[(f64, Vector2<f64>)], t: f64) -> Vector2<f64> {
    let next = points.partition_point(|(time, _)| *time <= t).clamp(1, points.len() - 1);
    let [a, b] = [points[next - 1], points[next]];
    between(a, b, t.clamp(a.0, b.0))
}

/// The median size of the force over the second half of its samples, in N.
fn usual_force(force: &[(f64, Vector2<f64>)]) -> Option<f64> {
    let late: Vec<f64> = force[force.len() / 2..].iter().map(|(_, force)| force.norm()).collect();
    median(&late)
}

/// When the force reaches half of what it is usually, in s; none where it is too small to tell.
fn onset(force: &[(f64, Vector2<f64>)], least: f64) -> Option<f64> {
    let usual = usual_force(force).filter(|usual| *usual > 2.0 * least)?;
    let presses = |samples: &[(f64, Vector2<f64>)]| {
        samples.iter().all(|(_, force)| force.norm() >= PRESSES * usual)
    };
    force.windows(IN_A_ROW).find(|samples| presses(samples)).map(|samples| samples[0].0)
}

/// The points without which a way would be off by more than allowed (Douglas & Peucker, in time).
fn simpler(points: &[(f64, Vector2<f64>)]) -> Vec<(f64, Vector2<f64>)> {
    let mut kept = vec![false; points.len()];
    let mut open = vec![(0, points.len() - 1)];
    (kept[0], kept[points.len() - 1]) = (true, true);
    while let Some((first, last)) = open.pop() {
        let off =
            |k: usize| (points[k].1 - between(points[first], points[last], points[k].0)).norm();
        let farthest = (first + 1..last).max_by(|a, b| off(*a).total_cmp(&off(*b)));
        if let Some(farthest) = farthest.filter(|k| off(*k) > STRAIGHT) {
            kept[farthest] = true;
            open.extend([(first, farthest), (farthest, last)]);
        }
    }
    points.iter().zip(kept).filter(|(_, is_kept)| *is_kept).map(|(point, _)| *point).collect()
}

/// The places of a way, with more of them where they are far apart.
fn finely(points: &[(f64, Vector2<f64>)]) -> Vec<Vector2<f64>> {
    const STEP: f64 = 5e-4;
    const MOST: f64 = 1e4;
    let mut fine = vec![points[0].1];
    for pair in points.windows(2) {
        let way = pair[1].1 - pair[0].1;
        let n = (way.norm() / STEP).ceil().clamp(1.0, MOST);
        fine.extend((1..=n as u32).map(|k| pair[0].1 + f64::from(k) / n * way));
    }
    fine
}

fn push_report(push: u32) -> PushReport {
    PushReport {
        push,
        excluded: None,
        rows: 0,
        steps_lost_in_gaps: 0,
        contact_start_s: 0.0,
        contact_end_s: 0.0,
        rest_s: 0.0,
        starts_in_contact: false,
        contact_lost: false,
        first_contact: None,
        streams: Vec::new(),
        steady_force_n: None,
        peak_force_n: None,
        recorded_force_n: None,
        resting_force_n: None,
        moving_noise: None,
    }
}
