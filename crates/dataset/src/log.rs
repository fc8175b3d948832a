//! Logs of messages, whatever their container: from channels to the streams of a recording.

use std::{ops::ControlFlow, path::Path};

use nalgebra::{Isometry3, Translation3};

use crate::{
    assemble::{Assembly, RawStream, nanoseconds, wrong_time_unit},
    decode::{Decoder, MessageError, Row, Schema},
    error::DatasetError,
    format::{Inspection, StreamInfo},
    frames::Frames,
    lateness::Lateness,
    layout::Layout,
    recording::Recording,
    remark::{Remark, RemarkKind, StreamRole},
    select::choose_topics,
    settings::{Quantity, StreamSettings, Streams, TimeSource},
    transform::{Transform, unit_quaternion},
};

/// A channel of a log: one topic from one publisher.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Channel {
    pub(crate) id: u32,
    pub(crate) topic: String,
    pub(crate) type_name: String,
    pub(crate) message_encoding: String,
    pub(crate) schema_encoding: String,
    pub(crate) schema: Vec<u8>,
    /// Messages, as far as the log tells.
    pub(crate) count: u64,
}

/// A message of a log.
pub(crate) struct Message<'a> {
    pub(crate) channel: u32,
    /// Time of logging, in ns.
    pub(crate) log_time: i64,
    pub(crate) data: &'a [u8],
    /// Byte in the file at which the message, or the chunk that holds it, begins.
    pub(crate) byte: u64,
}

/// Takes messages until it breaks.
pub(crate) type Sink<'s> = dyn FnMut(&Message<'_>) -> ControlFlow<()> + 's;

/// A file of messages.
pub(crate) trait Container {
    /// The channels, by number.
    fn channels(&self) -> &[Channel];

    /// What was wrong with the file before any message was read.
    fn remarks(&self) -> &[Remark];

    /// Hands over the messages of the channels that are `wanted`, in the order of the file, and
    /// returns what had to be left out.
    fn visit(&self, wanted: &dyn Fn(u32) -> bool, sink: &mut Sink<'_>) -> Vec<Remark>;
}

/// A channel with its schema, or why that cannot be read.
pub(crate) struct ParsedChannel<'a> {
    pub(crate) info: &'a Channel,
    pub(crate) schema: Result<Schema, String>,
}

/// Reads the streams of a log.
pub(crate) fn read_log(
    path: &Path,
    sha256: String,
    container: &dyn Container,
    streams: &Streams,
) -> Result<Recording, DatasetError> {
    let channels = parse_channels(container);
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
    let mut frame_readers = if uses_frames { frame_readers(&channels) } else { Vec::new() };
    let mut frames = Frames::default();
    let wanted = |id: u32| {
        takers.iter().any(|taker| taker.decoder(id).is_some())
            || frame_readers.iter().any(|(known, _)| *known == id)
    };
    let wanted_ids: Vec<u32> =
        channels.iter().map(|channel| channel.info.id).filter(|id| wanted(*id)).collect();
    let damage = container.visit(&|id| wanted_ids.contains(&id), &mut |message| {
        for taker in &mut takers {
            taker.take(message);
        }
        for (_, decoder) in frame_readers.iter_mut().filter(|(id, _)| *id == message.channel) {
            // Damaged messages of the frames' topic are those of no stream.
            let _ = decoder.decode(message.data, &mut |row| add_frame(&mut frames, row));
        }
        ControlFlow::Continue(())
    });
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
pub(crate) fn inspect_log(container: &dyn Container) -> Inspection {
    let channels = parse_channels(container);
    let readers = frame_readers(&channels);
    let mut frames = Frames::default();
    let mut seen = vec![(0_u64, i64::MAX, i64::MIN); channels.len()];
    let damage = container.visit(&|_| true, &mut |message| {
        if let Some(i) = channels.iter().position(|channel| channel.info.id == message.channel) {
            let (count, first, last) = seen[i];
            seen[i] = (count + 1, first.min(message.log_time), last.max(message.log_time));
        }
        for (_, decoder) in readers.iter().filter(|(id, _)| *id == message.channel) {
            // A message that does not fit is reported when its stream is read.
            let _ = decoder.decode(message.data, &mut |row| add_frame(&mut frames, row));
        }
        ControlFlow::Continue(())
    });
    let streams = channels.iter().zip(seen).map(|(channel, (count, first, last))| {
        let fits = |role: &StreamRole| {
            let schema = channel.schema.as_ref().ok();
            schema.is_some_and(|schema| {
                Layout::find(schema, *role, &StreamSettings::default()).is_ok()
            })
        };
        let span = last.saturating_sub(first) as f64 / 1e9;
        StreamInfo {
            name: channel.info.topic.clone(),
            type_name: channel.info.type_name.clone(),
            encoding: channel.info.schema_encoding.clone(),
            columns: Vec::new(),
            count,
            rate_hz: (count > 1 && span > 0.0).then(|| (count - 1) as f64 / span),
            fits: StreamRole::ALL.into_iter().filter(fits).collect(),
        }
    });
    let mut remarks = container.remarks().to_vec();
    remarks.extend(damage);
    Inspection { streams: streams.collect(), frames: frames.pairs(), remarks }
}

fn parse_channels(container: &dyn Container) -> Vec<ParsedChannel<'_>> {
    let samples = json_samples(container);
    let parse = |info: &'_ Channel| {
        let sample = samples.iter().find(|(id, _)| *id == info.id);
        Schema::parse(
            &info.type_name,
            &info.message_encoding,
            &info.schema_encoding,
            &info.schema,
            sample.and_then(|(_, data)| data.as_deref()),
        )
    };
    let channels = container.channels().iter();
    channels.map(|info| ParsedChannel { info, schema: parse(info) }).collect()
}

/// The first message of each JSON channel, in which its fields are seen.
fn json_samples(container: &dyn Container) -> Vec<(u32, Option<Vec<u8>>)> {
    let json = container.channels().iter().filter(|channel| channel.message_encoding == "json");
    let mut samples: Vec<_> = json.map(|channel| (channel.id, None)).collect();
    if !samples.is_empty() {
        let ids: Vec<u32> = samples.iter().map(|(id, _)| *id).collect();
        container.visit(&|id| ids.contains(&id), &mut |message| {
            for (_, sample) in samples.iter_mut().filter(|(id, _)| *id == message.channel) {
                sample.get_or_insert_with(|| message.data.to_vec());
            }
            if samples.iter().all(|(_, sample)| sample.is_some()) {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        });
    }
    samples
}

/// Decoders of the channels that publish frames.
fn frame_readers(channels: &[ParsedChannel<'_>]) -> Vec<(u32, Decoder)> {
    let of_one = |channel: &ParsedChannel<'_>| {
        let schema = channel.schema.as_ref().ok()?;
        let layout = Layout::find(schema, StreamRole::Object, &StreamSettings::default()).ok()?;
        let frames_only = layout.is_list || channel.info.type_name.ends_with("FrameTransform");
        let decoder = frames_only.then(|| schema.compile(&layout.wanted))?.ok()?;
        Some((channel.info.id, decoder))
    };
    channels.iter().filter_map(of_one).collect()
}

fn add_frame(frames: &mut Frames, row: &Row<'_>) {
    let [x, y, z, qx, qy, qz, qw, _] = row.values;
    if let (Ok(rotation), true) = (unit_quaternion([qx, qy, qz, qw]), (x + y + z).is_finite()) {
        let pose = Isometry3::from_parts(Translation3::new(x, y, z), rotation);
        frames.add(&String::from_utf8_lossy(row.parent), &String::from_utf8_lossy(row.child), pose);
    }
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
    decoders: Vec<(u32, Decoder, bool)>,
    raw: RawStream,
    is_list: bool,
    children: Vec<String>,
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
            decoders: Vec::new(),
            raw: RawStream::new(role, topic, "byte", &settings.fields),
            is_list: false,
            children: Vec::new(),
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
            taker.decoders.push((channel.info.id, decoder, stamped));
        }
        Ok(taker)
    }

    fn decoder(&self, id: u32) -> Option<&(u32, Decoder, bool)> {
        self.decoders.iter().find(|(known, ..)| *known == id)
    }

    fn take(&mut self, message: &Message<'_>) {
        let Self { role, settings, decoders, raw, children, lateness, wrong_unit, .. } = self;
        let Some((_, decoder, stamped)) = decoders.iter().find(|(id, ..)| *id == message.channel)
        else {
            return;
        };
        let decoded = decoder.decode(message.data, &mut |row| {
            if !row.child.is_empty() && !children.iter().any(|c| c.as_bytes() == row.child) {
                children.push(String::from_utf8_lossy(row.child).into_owned());
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

    fn finish(self, path: &Path, remarks: &mut Vec<Remark>) -> Result<RawStream, DatasetError> {
        let Self { role, settings, raw, is_list, children, .. } = self;
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
                let set_aside = n_misfits;
                return Err(DatasetError::MostlyUnusable { path, stream, set_aside, total, what });
            }
            let text = format!("{n_misfits} of {total} messages set aside: first, {what}");
            let (kind, stream) = (RemarkKind::MessageSetAside, Some(role));
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
