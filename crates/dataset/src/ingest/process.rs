//! One recording from streams to rows, with its part of the report.

use std::{collections::BTreeMap, path::Path};

use nalgebra::Vector2;

use crate::curves::noise::median;
use crate::ingest::contact::{Contacts, find_contacts};
use crate::ingest::first_contact::FirstContact;
use crate::ingest::force_zero::{ForceZero, mean_between};
use crate::ingest::push::{Exclusion, Push};
use crate::ingest::repair::{CleanStream, RepairKind};
use crate::ingest::report::{
    PushReport, RecordingReport, RestingNoise, StreamInPush, StreamReport,
};
use crate::ingest::scene::{Outline, Scene};
use crate::ingest::settings::IngestSettings;
use crate::ingest::steps::{StepContext, steps, template};
use crate::ingest::track::pose_noise;
use crate::input::limits::{Limit, ReadLimits};
use crate::manifest::object::ObjectSpec;
use crate::recording::Recording;
use crate::table::flags::Flags;
use crate::table::step::StepRow;
use crate::{error::DatasetError, remark::StreamRole};

/// What processing needs beside the recording.
pub(crate) struct Setup<'a> {
    pub(crate) settings: &'a IngestSettings,
    pub(crate) limits: &'a ReadLimits,
    pub(crate) pusher_radius: f64,
    pub(crate) session: Option<&'a str>,
}

/// The report of a recording that gave nothing.
pub(crate) fn unreadable(name: &str, path: &Path, error: impl ToString) -> RecordingReport {
    let excluded = Some(Exclusion::Unreadable { error: error.to_string() });
    RecordingReport { excluded, ..RecordingReport::unread(name, path) }
}

/// The rows of a recording and its report.
///
/// # Errors
/// `OverLimit` for more pushes or steps than allowed; `SplineKnots` if repair left samples without
/// order, which it does not.
pub(crate) fn process(
    recording: &Recording,
    object: &ObjectSpec,
    setup: &Setup<'_>,
) -> Result<(Vec<StepRow>, RecordingReport), DatasetError> {
    let settings = setup.settings;
    let outline = Outline { shape: &object.shape, pusher_radius: setup.pusher_radius };
    let scene = Scene::new(recording, outline, settings)?;
    let contacts = find_contacts(&scene, settings);
    let n_contacts = contacts.intervals.len() as u64;
    setup.limits.check(&recording.path, Limit::Pushes, || "pushes".into(), n_contacts)?;
    let pushes = Push::split(&scene, &contacts, settings);
    let mut report = RecordingReport {
        name: recording.name.clone(),
        path: recording.path.clone(),
        sha256: recording.sha256.clone(),
        session: setup.session.map(str::to_owned),
        nominal_force_n: None,
        excluded: None,
        remarks: recording.remarks.clone(),
        streams: stream_reports(recording, &scene),
        force_zero: contacts.zero.clone(),
        unconfirmed_contacts: contacts.n_unconfirmed,
        pauses_s: contacts.pauses.iter().map(|pause| [pause.start, pause.end]).collect(),
        passes: contacts.n_passes,
        resting_noise: resting_noise(&scene, &pushes),
        pushes: Vec::new(),
    };
    report.excluded = whole_fault(recording, &contacts, settings);
    let mut rows = Vec::new();
    let mut n_steps = 0;
    if report.excluded.is_none() {
        for (number, push) in pushes.iter().enumerate() {
            let n_before = n_steps;
            let number = number as u32;
            let made =
                one_push(recording, object, setup, &scene, &contacts, push, (number, n_before))?;
            let (mut own, push_report) = made;
            n_steps += own.len() as u64 + u64::from(push_report.steps_lost_in_gaps);
            rows.append(&mut own);
            report.pushes.push(push_report);
        }
    }
    Ok((rows, report))
}

/// A fault that concerns the whole recording.
fn whole_fault(
    recording: &Recording,
    contacts: &Contacts,
    settings: &IngestSettings,
) -> Option<Exclusion> {
    let (tilt_rad, limit_rad) = (recording.object.max_tilt, settings.largest_tilt);
    if tilt_rad > limit_rad {
        Some(Exclusion::Tilted { tilt_rad, limit_rad })
    } else if contacts.smallest_gap.is_none() {
        Some(Exclusion::NoOverlap)
    } else if contacts.intervals.is_empty() {
        Some(Exclusion::NoContact { smallest_gap_m: contacts.smallest_gap })
    } else {
        None
    }
}

fn one_push(
    recording: &Recording,
    object: &ObjectSpec,
    setup: &Setup<'_>,
    scene: &Scene<'_>,
    contacts: &Contacts,
    push: &Push,
    (number, n_before): (u32, u64),
) -> Result<(Vec<StepRow>, PushReport), DatasetError> {
    let settings = setup.settings;
    let mut report = push_report(scene, &contacts.zero, push, number, settings);
    report.excluded = push.fault(scene, settings);
    if report.excluded.is_some() {
        return Ok((Vec::new(), report));
    }
    let (force_offset, untared) = match contacts.zero {
        ForceZero::Tared { offset_n, .. } => (Vector2::from(offset_n), false),
        ForceZero::Untared { .. } => (Vector2::zeros(), true),
        ForceZero::NoForce => (Vector2::zeros(), false),
    };
    let mut flags = Flags::default();
    flags.set_if(Flags::STARTS_IN_CONTACT, push.starts_in_contact);
    flags.set_if(Flags::UNTARED, untared);
    let context = StepContext {
        path: &recording.path,
        limits: setup.limits,
        n_before,
        scene,
        settings,
        push,
        template: template(&recording.name, setup.session, &object.name, number, flags),
        epoch: recording.epoch_ns as f64 * 1e-9,
        force_offset,
        losses: &contacts.losses,
    };
    let (rows, lost) = steps(&context, &push.curves(scene, settings)?)?;
    report.steps_lost_in_gaps = lost;
    report.rows = rows.len();
    if rows.is_empty() {
        let contact_s = push.contact_end() - push.contact.start;
        report.excluded = Some(Exclusion::NoStep { contact_s, lost_in_gaps: lost });
    }
    Ok((rows, report))
}

fn push_report(
    scene: &Scene<'_>,
    zero: &ForceZero,
    push: &Push,
    number: u32,
    settings: &IngestSettings,
) -> PushReport {
    let (from, to) = (push.contact.start, push.rest.max(push.contact_end()));
    let streams = streams(scene)
        .map(|(stream, clean)| StreamInPush {
            stream,
            samples: clean.n_samples(from, to),
            longest_gap_s: clean.longest_gap(from, to),
            repairs: clean.counts(from, to),
        })
        .collect();
    let contact_end = push.contact_end();
    let quarter = 0.25 * (contact_end - from);
    let steady = |zero: Vector2<f64>| {
        median(&magnitudes(scene, zero, from + quarter, contact_end - quarter))
    };
    let (steady_force_n, peak_force_n) = match zero {
        ForceZero::Tared { offset_n, .. } => {
            let zero = Vector2::from(*offset_n);
            let all = magnitudes(scene, zero, from, contact_end);
            (steady(zero), all.into_iter().reduce(f64::max))
        }
        _ => (None, None),
    };
    // The force settles within some hundredths of a second after the stop.
    const SETTLING: f64 = 0.1;
    let resting_force_n = scene
        .wrench
        .as_ref()
        .and_then(|wrench| mean_between(wrench, push.rest.max(contact_end) + SETTLING, push.until))
        .map(|force| force.norm());
    PushReport {
        push: number,
        excluded: None,
        rows: 0,
        steps_lost_in_gaps: 0,
        contact_start_s: from,
        contact_end_s: push.contact.end,
        rest_s: push.rest,
        starts_in_contact: push.starts_in_contact,
        contact_lost: push.loses_contact(scene, settings),
        first_contact: FirstContact::of(scene, push, settings),
        streams,
        steady_force_n,
        peak_force_n,
        recorded_force_n: steady(Vector2::zeros()),
        resting_force_n,
        moving_noise: noise(&scene.object, from, contact_end),
    }
}

fn magnitudes(scene: &Scene<'_>, offset: Vector2<f64>, from: f64, to: f64) -> Vec<f64> {
    let Some(wrench) = &scene.wrench else { return Vec::new() };
    wrench
        .range(from, to)
        .map(|i| (Vector2::new(wrench.channels[0][i], wrench.channels[1][i]) - offset).norm())
        .collect()
}

fn streams<'a>(scene: &'a Scene<'_>) -> impl Iterator<Item = (StreamRole, &'a CleanStream)> {
    [
        (StreamRole::Robot, Some(&scene.robot)),
        (StreamRole::Object, Some(&scene.object)),
        (StreamRole::Wrench, scene.wrench.as_ref()),
    ]
    .into_iter()
    .filter_map(|(role, stream)| Some((role, stream?)))
}

fn stream_reports(recording: &Recording, scene: &Scene<'_>) -> Vec<StreamReport> {
    let sources = BTreeMap::from([
        (StreamRole::Robot, (recording.robot.source.as_str(), recording.robot.max_tilt)),
        (StreamRole::Object, (recording.object.source.as_str(), recording.object.max_tilt)),
        (
            StreamRole::Wrench,
            (recording.wrench.as_ref().map_or("", |wrench| wrench.source.as_str()), 0.0),
        ),
    ]);
    let always = (f64::NEG_INFINITY, f64::INFINITY);
    streams(scene)
        .map(|(stream, clean)| {
            let span_s = [
                clean.t.first().copied().unwrap_or_default(),
                clean.t.last().copied().unwrap_or_default(),
            ];
            let largest = |kind| clean.largest(kind, always.0, always.1);
            StreamReport {
                stream,
                source: sources[&stream].0.to_owned(),
                samples_read: clean.n_read,
                samples_used: clean.t.len(),
                // Filled in once the rates of the whole set are known.
                samples_due: None,
                rate_hz: clean.rate(),
                span_s,
                longest_gap_s: clean.longest_gap(span_s[0], span_s[1]),
                kept_row_order: clean.kept_row_order,
                largest_step_back_s: largest(RepairKind::Backward),
                largest_jump_m: largest(RepairKind::Jump).max(largest(RepairKind::Teleport)),
                max_tilt_rad: sources[&stream].1,
                repairs: clean.counts(always.0, always.1),
            }
        })
        .collect()
}

/// Noise over the longest stretch in which the object rests: before, between or after pushes.
fn resting_noise(scene: &Scene<'_>, pushes: &[Push]) -> Option<RestingNoise> {
    let first = *scene.object.t.first()?;
    let before = (first, pushes.first().map_or(f64::INFINITY, |push| push.contact.start));
    let after = pushes.iter().map(|push| (push.rest, push.until));
    let (from, to) = std::iter::once(before)
        .chain(after)
        .max_by_key(|&(from, to)| scene.object.n_samples(from, to))?;
    noise(&scene.object, from, to)
}

fn noise(stream: &CleanStream, from: f64, to: f64) -> Option<RestingNoise> {
    pose_noise(stream, from, to).map(|noise| RestingNoise {
        position_sd_m: noise.position,
        angle_sd_rad: noise.angle,
        n_samples: stream.n_samples(from, to),
    })
}
