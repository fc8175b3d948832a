//! Logs of messages, whatever their container: from channels to the streams of a recording.

use std::{
    collections::{BTreeMap, BTreeSet},
    ops::ControlFlow,
    path::Path,
};

use nalgebra::{Isometry3, Translation3};

use crate::formats::assemble::{Assembly, RawStream, nanoseconds, wrong_time_unit};
use crate::formats::channel::{ParsedChannel, parse_channels};
use crate::formats::container::{Container, Message};
use crate::formats::decode::{Decoder, MessageError, Row};
use crate::formats::format::{Inspection, StreamInfo};
use crate::formats::layout::Layout;
use crate::formats::select::choose_topics;
use crate::formats::stamps::Stamps;
use crate::input::limits::{Limit, ReadLimits};
use crate::recording::Recording;
use crate::recording::frames::Frames;
use crate::recording::lateness::Lateness;
use crate::recording::settings::{Quantity, StreamSettings, Streams, TimeSource};
use crate::recording::transform::{Transform, unit_quaternion};
use crate::{
    error::DatasetError,
    remark::{Remark, RemarkKind, StreamRole},
};

/// Reads the streams of a log.
pub(crate) fn read_log(
    path: &Path,
    sha256: String,
    container: &dyn Container,
    streams: &Streams,
    limits: &ReadLimits,
) -> Result<Recording, DatasetError> {
    let channels = parse_channels(path, container, limits)?;
    let topics = choose_topics(path, &channels, streams)?;
    let mut takers = Vec::new();
    for role in StreamRole::ALL {
        if let Some(topic) = &topics[role as usize] {
            takers.push(Taker::new(path, role, topic, &channels, streams.of(role))?);
        }
    }
    let uses_frames = StreamRole::ALL
        .iter()
        .any(|role| matches!(streams.of(*role).transform, Some(Transform::Tf { .. })));
    let frame_readers = if uses_frames { frame_readers(&channels) } else { BTreeMap::new() };
    let mut frames = Frames::default();
    let wanted: BTreeSet<u32> = takers
        .iter()
        .flat_map(|taker| taker.decoders.keys())
        .chain(frame_readers.keys())
        .copied()
        .collect();
    let of_channel = |id: &u32| {
        (0..takers.len()).filter(|k| takers[*k].decoders.contains_key(id)).collect::<Vec<_>>()
    };
    let takers_of: BTreeMap<u32, Vec<usize>> =
        wanted.iter().map(|id| (*id, of_channel(id))).collect();
    let damage = container.visit(&|id| wanted.contains(&id), &mut |message| {
        for taker in takers_of.get(&message.channel).into_iter().flatten() {
            let taker = &mut takers[*taker];
            taker.take(message, limits);
            taker.check(path, limits)?;
        }
        if let Some(decoder) = frame_readers.get(&message.channel) {
            // Damaged messages of the frames' topic are those of no stream.
            let _ = decoder.decode(message.data, &mut |row| add_frame(&mut frames, row, limits));
            check_frames(path, frames.len(), limits)?;
        }
        Ok(ControlFlow::Continue(()))
    })?;
    let mut assembly = Assembly { path, sha256, remarks: container.remarks().to_vec() };
    assembly.remarks.extend(damage);
    let mut parts: [Option<(RawStream, Option<Isometry3<f64>>)>; 3] = [None, None, None];
    for taker in takers {
        let role = taker.role;
        let transform = streams.of(role).transform.as_ref();
        let transform = fixed_transform(path, role, transform, &frames, &mut assembly.remarks)?;
        parts[role as usize] = Some((taker.finish(path, &mut assembly.remarks)?, transform));
    }
    let [Some((robot, robot_pose)), Some((object, object_pose)), wrench] = &parts else {
        unreachable!("both pose streams have a topic once topics are chosen")
    };
    let wrench = wrench.as_ref().map(|(raw, pose)| (raw, *pose, &streams.wrench));
    assembly.finish((robot, *robot_pose), (object, *object_pose), wrench)
}

/// What a log contains.
pub(crate) fn inspect_log(
    path: &Path,
    container: &dyn Container,
    limits: &ReadLimits,
) -> Result<Inspection, DatasetError> {
    let channels = parse_channels(path, container, limits)?;
    let readers = frame_readers(&channels);
    let mut frames = Frames::default();
    let mut seen: BTreeMap<u32, Stamps> =
        channels.iter().map(|channel| (channel.info.id, Stamps::default())).collect();
    let damage = container.visit(&|_| true, &mut |message| {
        if let Some(stamps) = seen.get_mut(&message.channel) {
            stamps.add(message.log_time);
        }
        if let Some(decoder) = readers.get(&message.channel) {
            // A message that does not fit is reported when its stream is read.
            let _ = decoder.decode(message.data, &mut |row| add_frame(&mut frames, row, limits));
            check_frames(path, frames.len(), limits)?;
        }
        Ok(ControlFlow::Continue(()))
    })?;
    let streams = channels.iter().map(|channel| {
        let stamps = &seen[&channel.info.id];
        let fits = |role: &StreamRole| {
            let schema = channel.schema.as_ref().ok();
            schema.is_some_and(|schema| {
                Layout::find(schema, *role, &StreamSettings::default()).is_ok()
            })
        };
        StreamInfo {
            name: channel.info.topic.clone(),
            type_name: channel.info.type_name.clone(),
            encoding: channel.info.schema_encoding.clone(),
            columns: Vec::new(),
            count: stamps.count,
            rate_hz: stamps.rate_hz(),
            fits: StreamRole::ALL.into_iter().filter(fits).collect(),
        }
    });
    let mut remarks = container.remarks().to_vec();
    remarks.extend(damage);
    remarks.extend(Remark::of_pauses(seen.values().filter_map(Stamps::pauses)));
    Ok(Inspection { streams: streams.collect(), frames: frames.pairs(), remarks })
}

/// Decoders of the channels that publish frames.
fn frame_readers(channels: &[ParsedChannel<'_>]) -> BTreeMap<u32, Decoder> {
    let of_one = |channel: &ParsedChannel<'_>| {
        let schema = channel.schema.as_ref().ok()?;
        let layout = Layout::find(schema, StreamRole::Object, &StreamSettings::default()).ok()?;
        let frames_only = layout.is_list || channel.info.type_name.ends_with("FrameTransform");
        let decoder = frames_only.then(|| schema.compile(&layout.wanted))?.ok()?;
        Some((channel.info.id, decoder))
    };
    channels.iter().filter_map(of_one).collect()
}

fn add_frame(frames: &mut Frames, row: &Row<'_>, limits: &ReadLimits) {
    let [x, y, z, qx, qy, qz, qw, _] = row.values;
    if let (Ok(rotation), true) = (unit_quaternion([qx, qy, qz, qw]), (x + y + z).is_finite()) {
        let pose = Isometry3::from_parts(Translation3::new(x, y, z), rotation);
        // What exceeds the limit is seen after the message.
        if frames.len() as u64 <= limits.of(Limit::Channels) {
            let [parent, child] = [row.parent, row.child].map(String::from_utf8_lossy);
            frames.add(&parent, &child, pose);
        }
    }
}

fn check_frames(path: &Path, n_frames: usize, limits: &ReadLimits) -> Result<(), DatasetError> {
    limits.check(path, Limit::Channels, || "frames".into(), n_frames as u64)
}

/// The pose of a stream's frame in the world, as given or as published in the log.
pub(crate) fn fixed_transform(
    path: &Path,
    stream: StreamRole,
    transform: Option<&Transform>,
    frames: &Frames,
    remarks: &mut Vec<Remark>,
) -> Result<Option<Isometry3<f64>>, DatasetError> {
    match transform {
        None => Ok(None),
        Some(Transform::Fixed(pose)) => Ok(Some(*pose)),
        Some(Transform::Tf { parent, child }) => {
            let found = frames.find(parent, child);
            let (pose, n_changed) = found.ok_or_else(|| DatasetError::FrameMissing {
                path: path.into(),
                stream,
                frame: format!("{parent} ← {child}"),
                available: frames.listed(),
            })?;
            if n_changed > 0 {
                remarks.push(Remark {
                    kind: RemarkKind::TransformVaries,
                    stream: Some(stream),
                    count: n_changed,
                    text: format!(
                        "{parent} ← {child} differs from its first value in {n_changed} messages; \
                         the first is used throughout"
                    ),
                });
            }
            Ok(Some(pose))
        }
    }
}

/// Collects the rows of one stream.
struct Taker<'a> {
    role: StreamRole,
    settings: &'a StreamSettings,
    decoders: BTreeMap<u32, (Decoder, bool)>,
    raw: RawStream,
    is_list: bool,
    children: BTreeSet<Vec<u8>>,
    lateness: Lateness,
    n_misfits: u64,
    first_misfit: Option<(u64, MessageError)>,
    /// What the first stamp in another unit than s says, with its byte.
    wrong_unit: Option<(u64, String)>,
}

impl<'a> Taker<'a> {
    fn new(
        path: &Path,
        role: StreamRole,
        topic: &str,
        channels: &[ParsedChannel<'_>],
        settings: &'a StreamSettings,
    ) -> Result<Self, DatasetError> {
        let mut taker = Self {
            role,
            settings,
            decoders: BTreeMap::new(),
            raw: RawStream::new(role, topic, "byte", &settings.fields),
            is_list: false,
            children: BTreeSet::new(),
            lateness: Lateness::default(),
            n_misfits: 0,
            first_misfit: None,
            wrong_unit: None,
        };
        for channel in channels.iter().filter(|channel| channel.info.topic == topic) {
            let missing = |what| DatasetError::FieldMissing {
                path: path.into(),
                stream: role,
                topic: topic.into(),
                type_name: channel.info.type_name.clone(),
                what,
            };
            let schema = channel.schema.as_ref().map_err(|what| missing(what.clone()))?;
            let layout = Layout::find(schema, role, settings).map_err(missing)?;
            let decoder = schema.compile(&layout.wanted).map_err(missing)?;
            taker.raw.has = layout.has;
            taker.is_list = layout.is_list;
            let stamped = layout.stamped && settings.time == TimeSource::Stamp;
            taker.decoders.insert(channel.info.id, (decoder, stamped));
            taker.raw.expect(channel.info.count);
        }
        Ok(taker)
    }

    fn take(&mut self, message: &Message<'_>, limits: &ReadLimits) {
        let Self { role, settings, decoders, raw, children, lateness, wrong_unit, .. } = self;
        let Some((decoder, stamped)) = decoders.get(&message.channel) else { return };
        let (most, most_children) = (limits.of(Limit::Samples), limits.of(Limit::Channels));
        let decoded = decoder.decode(message.data, &mut |row| {
            // One message may hold a list of any length: what exceeds a limit is seen afterwards.
            if raw.rows.len() as u64 > most || children.len() as u64 > most_children {
                return;
            }
            if !row.child.is_empty() && !children.contains(row.child) {
                children.insert(row.child.to_vec());
            }
            if settings.child_frame.as_ref().is_some_and(|child| child.as_bytes() != row.child) {
                return;
            }
            if *stamped && wrong_unit.is_none() {
                let what = wrong_time_unit(seconds(row, settings), *role, "fields");
                *wrong_unit = what.map(|what| (message.byte, what));
            }
            let stamp = stamp(row, settings);
            let own = *stamped && stamp != 0;
            raw.log_times_used += u64::from(!own && settings.time == TimeSource::Stamp);
            if own {
                lateness.note(stamp, message.log_time);
            }
            raw.push(if own { stamp } else { message.log_time }, &row.values, message.byte);
        });
        if let Err(error) = decoded {
            self.n_misfits += 1;
            self.first_misfit.get_or_insert((message.byte, error));
        }
    }

    /// Refuses more samples or frames than the limits allow.
    fn check(&self, path: &Path, limits: &ReadLimits) -> Result<(), DatasetError> {
        let what = || format!("samples of the {} stream", self.role);
        limits.check(path, Limit::Samples, what, self.raw.rows.len() as u64)?;
        check_frames(path, self.children.len(), limits)
    }

    fn finish(self, path: &Path, remarks: &mut Vec<Remark>) -> Result<RawStream, DatasetError> {
        let Self { role, settings, raw, is_list, children, .. } = self;
        let children: Vec<_> = children.iter().map(|name| String::from_utf8_lossy(name)).collect();
        let Self { lateness, n_misfits, first_misfit, wrong_unit, .. } = self;
        if let Some((byte, what)) = wrong_unit {
            let what = format!("{}: {what}", raw.source);
            return Err(DatasetError::Damaged { path: path.into(), byte, what });
        }
        if let Some((byte, error)) = first_misfit {
            let total = n_misfits + raw.rows.len() as u64;
            let what = format!("the message at byte {byte} does not fit its schema: {error}");
            if 2 * n_misfits > total {
                let what = format!("{what}; record {} again or name another topic", raw.source);
                let (path, stream) = (path.into(), role);
                let excluded = n_misfits;
                return Err(DatasetError::MostlyUnusable { path, stream, excluded, total, what });
            }
            let text = format!("{n_misfits} of {total} messages excluded: first, {what}");
            let (kind, stream) = (RemarkKind::MessageExcluded, Some(role));
            remarks.push(Remark { kind, stream, count: n_misfits, text });
        }
        remarks.extend(lateness.remark(role));
        match &settings.child_frame {
            Some(frame) if raw.rows.is_empty() => Err(DatasetError::FrameMissing {
                path: path.into(),
                stream: role,
                frame: frame.clone(),
                available: children.join(", "),
            }),
            None if is_list && children.len() > 1 => Err(DatasetError::FrameMissing {
                path: path.into(),
                stream: role,
                frame: format!("(none named: set streams.{role}.child_frame)"),
                available: children.join(", "),
            }),
            _ => Ok(raw),
        }
    }
}

/// The seconds of a row's stamp.
fn seconds(row: &Row<'_>, settings: &StreamSettings) -> f64 {
    settings.fields.get(&Quantity::T).map_or(row.sec, |map| map.scale * row.sec + map.offset)
}

/// The stamp of a row in ns; 0 if it is not set.
fn stamp(row: &Row<'_>, settings: &StreamSettings) -> i64 {
    nanoseconds(seconds(row, settings)).saturating_add(row.nanosec as i64)
}

/// Error for a log in which there is nothing to read at all.
pub(crate) fn nothing_to_read(path: &Path, byte: u64, what: &str) -> DatasetError {
    DatasetError::Damaged { path: path.into(), byte, what: what.into() }
}

#[cfg(test)]
mod tests;
