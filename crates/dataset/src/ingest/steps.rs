//! From a push to rows: step boundaries, motion, contact and force over each step.

use std::{path::Path, sync::Arc};

use nalgebra::Vector2;
use planar::{Contact, Feature, Pose, perpendicular, wrap_angle};

use crate::error::DatasetError;
use crate::ingest::interval::Interval;
use crate::ingest::push::{PhaseCurves, Push};
use crate::ingest::scene::Scene;
use crate::ingest::settings::{IngestSettings, StepLength};
use crate::ingest::track::PoseNoise;
use crate::input::limits::{Limit, ReadLimits};
use crate::table::flags::Flags;
use crate::table::step::{ContactForce, Phase, StepForce, StepRow};

/// What the rows of one push have in common.
pub(crate) struct StepContext<'a> {
    /// The recording, for messages.
    pub(crate) path: &'a Path,
    pub(crate) limits: &'a ReadLimits,
    /// Steps of the pushes before this one.
    pub(crate) n_before: u64,
    pub(crate) scene: &'a Scene<'a>,
    pub(crate) settings: &'a IngestSettings,
    pub(crate) push: &'a Push,
    /// Row with names, session, number of the push, and flags of the whole push set.
    pub(crate) template: StepRow,
    /// Zero of the log's clock: seconds to add to the recording's own times.
    pub(crate) epoch: f64,
    /// Force read by the free pusher; zero where it is not known.
    pub(crate) force_offset: Vector2<f64>,
    /// Short losses of contact.
    pub(crate) losses: &'a [Interval],
}

/// Pusher and object at the boundary between two steps.
struct Moment {
    t: f64,
    contact: Contact,
    object: Pose,
    pusher: Vector2<f64>,
    sd: PoseNoise,
}

/// The rows of a push, and how many steps were lost because a stream was in a gap at their ends.
///
/// # Errors
/// `OverLimit` for more steps than a recording may have.
pub(crate) fn steps(
    context: &StepContext<'_>,
    curves: &[PhaseCurves],
) -> Result<(Vec<StepRow>, u32), DatasetError> {
    let mut rows: Vec<StepRow> = Vec::new();
    let mut lost = 0;
    for curves in curves {
        let bounds = boundaries(context, curves, rows.len() as u64 + u64::from(lost))?;
        let moments: Vec<_> = bounds.into_iter().map(|t| context.moment(curves, t)).collect();
        for pair in moments.windows(2) {
            let ends = pair[0].as_ref().zip(pair[1].as_ref());
            match ends.and_then(|(start, end)| context.row(curves, start, end)) {
                Some(row) => rows.push(StepRow { step: rows.len() as u32 + lost, ..row }),
                None => lost += 1,
            }
        }
    }
    Ok((rows, lost))
}

/// Times between steps; a rest too short for a step of its own is left out.
///
/// - `n_before`: steps of the same push before these.
fn boundaries(
    context: &StepContext<'_>,
    curves: &PhaseCurves,
    n_before: u64,
) -> Result<Vec<f64>, DatasetError> {
    let (from, to) = (curves.from, curves.to);
    let check = |n: u64| {
        let what = || {
            let push = context.template.push;
            format!("steps up to {to:.3} s, where push {push} ends (does its clock jump?)")
        };
        let n = context.n_before.saturating_add(n_before).saturating_add(n);
        context.limits.check(context.path, Limit::Steps, what, n)
    };
    let mut bounds = vec![from];
    match (context.settings.step, curves.phase) {
        (StepLength::Time(length), _) => {
            let n = ((to - from) / length + 1e-9).floor().max(0.0) as u64;
            check(n)?;
            bounds.extend((1..=n).map(|k| from + k as f64 * length));
        }
        (StepLength::Distance(length), Phase::Contact) => {
            for time in times_at_ways(context, curves, length, &check)? {
                if time - bounds[bounds.len() - 1] >= context.settings.least_step_time {
                    bounds.push(time);
                }
            }
        }
        (StepLength::Distance(_), Phase::After) => {}
    }
    let last = bounds[bounds.len() - 1];
    if to - last >= context.settings.shortest_step {
        bounds.push(to);
    }
    Ok(bounds)
}

/// When the pusher has gone each multiple of a way, along lines between its samples.
fn times_at_ways(
    context: &StepContext<'_>,
    curves: &PhaseCurves,
    length: f64,
    check: &dyn Fn(u64) -> Result<(), DatasetError>,
) -> Result<Vec<f64>, DatasetError> {
    let robot = &context.scene.robot;
    let stamps = robot.range(curves.from, curves.to).map(|i| robot.t[i]);
    let mut times = Vec::new();
    let mut before = curves.robot.position(curves.from).map(|position| (curves.from, position));
    let mut way = 0.0;
    for t in stamps.chain([curves.to]) {
        let Some(position) = curves.robot.position(t) else { continue };
        if let Some((t0, position0)) = before {
            let step = (position - position0).norm();
            while step > 0.0 && way + step >= length * (times.len() + 1) as f64 {
                let share = (length * (times.len() + 1) as f64 - way) / step;
                times.push(t0 + share * (t - t0));
                check(times.len() as u64)?;
            }
            way += step;
        }
        before = Some((t, position));
    }
    Ok(times)
}

impl StepContext<'_> {
    /// Everything at a boundary; none if a stream has no curve there.
    fn moment(&self, curves: &PhaseCurves, t: f64) -> Option<Moment> {
        let PhaseCurves { robot, object, .. } = curves;
        let (contact, pose) = self.scene.outline.contact(robot, object, t)?;
        Some(Moment { t, contact, object: pose, pusher: robot.position(t)?, sd: object.sd(t)? })
    }

    /// The row of one step; none if a stream has no curve within it.
    fn row(&self, curves: &PhaseCurves, start: &Moment, end: &Moment) -> Option<StepRow> {
        let scene = self.scene;
        let Moment { t: t0, contact: start, object: pose0, pusher: pusher0, sd: sd0 } = start;
        let Moment { t: t1, contact: end, object: pose1, pusher: pusher1, sd: sd1 } = end;
        let (t0, t1) = (*t0, *t1);
        let dt = match self.settings.step {
            StepLength::Time(length) if (t1 - t0 - length).abs() < 1e-9 => length,
            _ => t1 - t0,
        };
        let velocity = (pusher1 - pusher0) / dt;
        let half = curves.robot.position(0.5 * (t0 + t1)).unwrap_or(0.5 * (pusher0 + pusher1));
        let acceleration = 4.0 * (pusher0 - 2.0 * half + pusher1) / (dt * dt);
        let speed = velocity.norm();
        let at_rest = speed < self.settings.rest.pusher_speed;
        let edge_normal = pose0.rotate(&scene.outline.shape.inward_normal_at(start.edge, start.p));
        let along = if at_rest { edge_normal } else { velocity / speed };
        let beta = if at_rest { 0.0 } else { angle_between(&edge_normal, &along) };
        let moves_away = !at_rest && pose0.rotate(&start.normal).dot(&along) < 0.0;
        let moved = pose1.position - pose0.position;
        let curvature =
            if at_rest { 0.0 } else { planar::cross(&velocity, &acceleration) / speed.powi(3) };
        Some(StepRow {
            phase: curves.phase,
            t: self.epoch + t0,
            dt,
            n_samples: scene.object.n_samples(t0, t1) as u32,
            edge: start.edge as u32,
            p: start.p,
            beta,
            speed,
            object_pose: *pose0,
            object_twist: curves.object.twist(t0)?,
            pusher_start: *pusher0,
            pusher_end: *pusher1,
            pusher_velocity: velocity,
            pusher_acceleration: acceleration,
            path_curvature: curvature,
            contact_point: pose0.transform_point(&start.point),
            contact_normal: pose0.rotate(&start.normal),
            dx: moved.dot(&along),
            dy: moved.dot(&perpendicular(&along)),
            dtheta: pose1.angle - pose0.angle,
            force: self.force(curves, t0, t1),
            gap_start: start.gap,
            gap_end: end.gap,
            slip: scene.outline.way(start, end),
            since_contact: t0 - self.push.contact.start,
            start_position_sd: sd0.position,
            start_angle_sd: sd0.angle,
            end_position_sd: sd1.position,
            end_angle_sd: sd1.angle,
            flags: self.flags(curves, (t0, t1), (start, end), moves_away, at_rest),
            ..self.template.clone()
        })
    }

    fn flags(
        &self,
        curves: &PhaseCurves,
        (t0, t1): (f64, f64),
        (start, end): (&Contact, &Contact),
        moves_away: bool,
        at_rest: bool,
    ) -> Flags {
        let (scene, settings) = (self.scene, self.settings);
        let near = |contact: &Contact| {
            let distance = scene.outline.vertex_distance(contact);
            distance.is_some_and(|distance| distance < settings.vertex_distance)
        };
        // A curve that is fitted to the contact alone begins a sample later.
        let begun = scene.robot_track.position(self.push.contact.start);
        let way = begun.zip(curves.robot.position(t0)).map(|(from, to)| (to - from).norm());
        let early = t0 - self.push.contact.start < settings.first_touch_time
            || way.is_some_and(|way| way < settings.first_touch_way);
        let in_contact = curves.phase == Phase::Contact;
        let lost = self.losses.iter().any(|loss| loss.start < t1 && loss.end > t0)
            || start.gap > settings.contact.release_gap
            || end.gap > settings.contact.release_gap;
        let overlap = start.gap.min(end.gap) < -settings.penetration;
        let short = match settings.step {
            StepLength::Time(length) => t1 - t0 < 0.999 * length,
            StepLength::Distance(length) => {
                let way = curves.robot.position(t0).zip(curves.robot.position(t1));
                way.is_some_and(|(from, to)| (to - from).norm() < 0.9 * length)
            }
        };
        let mut flags = self.template.flags;
        flags.set_if(Flags::VERTEX, start.feature == Feature::Vertex);
        flags.set_if(Flags::NEAR_VERTEX, near(start) || near(end));
        flags.set_if(Flags::FIRST_TOUCH, in_contact && early);
        flags.set_if(Flags::CONTACT_LOST, in_contact && lost);
        flags.set_if(Flags::OBJECT_GAP, !curves.object.connects(t0, t1));
        flags.set_if(Flags::ROBOT_GAP, !curves.robot.connects(t0, t1));
        flags.set_if(Flags::EDGE_CHANGED, start.edge != end.edge);
        flags.set_if(Flags::SHORT, short);
        flags.set_if(Flags::PENETRATION, overlap);
        flags.set_if(Flags::MOVING_AWAY, moves_away);
        flags.set_if(Flags::PUSHER_AT_REST, at_rest);
        flags
    }

    /// Force on the object in the contact frame; none where the stream or a curve has a gap.
    fn force(&self, curves: &PhaseCurves, t0: f64, t1: f64) -> Option<StepForce> {
        let wrench = self.scene.wrench.as_ref()?;
        if wrench.longest_gap(t0, t1) > self.settings.longest_gap {
            return None;
        }
        let at = |t: f64| {
            let on_pusher = self.scene.force_at(t, self.settings.longest_gap)? - self.force_offset;
            let (contact, pose) = self.scene.outline.contact(&curves.robot, &curves.object, t)?;
            let normal = pose.rotate(&contact.normal);
            let on_object = -on_pusher;
            Some(ContactForce {
                normal: on_object.dot(&normal),
                tangential: on_object.dot(&perpendicular(&normal)),
            })
        };
        let (start, end) = (at(t0)?, at(t1)?);
        let mut sum = ContactForce::default();
        let mut before = (t0, start);
        for t in wrench.range(t0, t1).map(|i| wrench.t[i]).chain([t1]) {
            // Inside a gap of the object's stream the mean bridges the missing normals.
            let Some(force) = at(t) else { continue };
            let weight = 0.5 * (t - before.0) / (t1 - t0);
            sum.normal += weight * (before.1.normal + force.normal);
            sum.tangential += weight * (before.1.tangential + force.tangential);
            before = (t, force);
        }
        Some(StepForce { mean: sum, start, end })
    }
}

/// Angle from one vector to another, counter-clockwise positive, in (−π, π].
fn angle_between(from: &Vector2<f64>, to: &Vector2<f64>) -> f64 {
    wrap_angle(to.y.atan2(to.x) - from.y.atan2(from.x))
}

/// A row that carries the names of a recording and nothing else.
pub(crate) fn template(
    recording: &str,
    session: Option<&str>,
    shape: &str,
    push: u32,
    flags: Flags,
) -> StepRow {
    StepRow {
        recording: Arc::from(recording),
        session: session.map(Arc::from),
        shape: Arc::from(shape),
        push,
        flags,
        ..StepRow::default()
    }
}
