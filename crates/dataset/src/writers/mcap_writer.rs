//! MCAP logs with messages in ROS 2 CDR, ROS 1, JSON or protobuf.

use std::{
    collections::BTreeMap,
    io::Cursor,
    path::{Path, PathBuf},
};

use mcap::{McapResult, WriteOptions, records::MessageHeader};
use serde_json::{Map, Value, json};

#[cfg(feature = "protobuf")]
use super::protobuf;
use super::{
    cdr::{FRAME, definition, encode, numbers},
    sample::{Sample, samples},
};
use crate::recording::Recording;
use crate::writers::writer::{RecordingWriter, make_dir};
use crate::{error::DatasetError, remark::StreamRole};

/// Writes an MCAP file a recording, its chunks compressed by zstd and with check sums.
pub(crate) struct McapWriter {
    encoding: Encoding,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Encoding {
    Ros2,
    Ros1,
    Json,
    #[cfg(feature = "protobuf")]
    Protobuf,
}

impl McapWriter {
    /// Messages as ROS 2 bags hold them.
    pub(crate) const ROS2: Self = Self { encoding: Encoding::Ros2 };
    /// Messages as converted ROS 1 bags hold them.
    pub(crate) const ROS1: Self = Self { encoding: Encoding::Ros1 };
    /// Messages in JSON.
    pub(crate) const JSON: Self = Self { encoding: Encoding::Json };
    /// Messages in protobuf.
    #[cfg(feature = "protobuf")]
    pub(crate) const PROTOBUF: Self = Self { encoding: Encoding::Protobuf };
}

impl RecordingWriter for McapWriter {
    fn id(&self) -> &'static str {
        match self.encoding {
            Encoding::Ros2 => "mcap-ros2",
            Encoding::Ros1 => "mcap-ros1",
            Encoding::Json => "mcap-json",
            #[cfg(feature = "protobuf")]
            Encoding::Protobuf => "mcap-protobuf",
        }
    }

    fn format(&self) -> &'static str {
        "mcap"
    }

    fn write(&self, recording: &Recording, dir: &Path) -> Result<PathBuf, DatasetError> {
        let path = dir.join(format!("{}.mcap", recording.name));
        let streams = samples(recording, &path, self.id())?;
        check_stamps(&streams, &path, self.id())?;
        let bytes = self.encode(&streams).map_err(|error| DatasetError::Unwritable {
            path: path.clone(),
            format: self.id(),
            what: error.to_string(),
        })?;
        make_dir(dir)?;
        output::write(&path, &bytes)?;
        Ok(path)
    }
}

impl McapWriter {
    fn encode(&self, streams: &[(StreamRole, Vec<Sample>)]) -> McapResult<Vec<u8>> {
        let profile = match self.encoding {
            Encoding::Ros2 => "ros2",
            Encoding::Ros1 => "ros1",
            Encoding::Json => "",
            #[cfg(feature = "protobuf")]
            Encoding::Protobuf => "",
        };
        // Threads of the compressor would change the bytes from machine to machine.
        let options =
            WriteOptions::new().profile(profile).library("pushlab").compression_threads(0);
        let mut writer = options.create(Cursor::new(Vec::new()))?;
        let mut channels = Vec::new();
        for (role, _) in streams {
            let (name, schema_encoding, schema) = self.schema(*role);
            let schema = writer.add_schema(name, schema_encoding, &schema)?;
            let message_encoding = match self.encoding {
                Encoding::Ros2 => "cdr",
                Encoding::Ros1 => "ros1",
                Encoding::Json => "json",
                #[cfg(feature = "protobuf")]
                Encoding::Protobuf => "protobuf",
            };
            let none = BTreeMap::new();
            channels.push(writer.add_channel(schema, topic(*role), message_encoding, &none)?);
        }
        let mut next = vec![0; streams.len()];
        while let Some(i) = earliest(streams, &next) {
            let (role, samples) = &streams[i];
            let sample = &samples[next[i]];
            let sequence = next[i] as u32;
            let time = u64::try_from(sample.time_us).unwrap_or(0) * 1000;
            let (channel_id, log_time, publish_time) = (channels[i], time, time);
            let header = MessageHeader { channel_id, sequence, log_time, publish_time };
            let message = match self.encoding {
                Encoding::Ros2 => encode(*role, sample, sequence, true),
                Encoding::Ros1 => encode(*role, sample, sequence, false),
                Encoding::Json => json_message(*role, sample).to_string().into_bytes(),
                #[cfg(feature = "protobuf")]
                Encoding::Protobuf => protobuf::encode(*role, sample),
            };
            writer.write_to_known_channel(&header, &message)?;
            next[i] += 1;
        }
        writer.finish()?;
        Ok(writer.into_inner().into_inner())
    }

    /// Name, encoding and bytes of a stream's schema.
    fn schema(&self, role: StreamRole) -> (&'static str, &'static str, Vec<u8>) {
        let wrench = role == StreamRole::Wrench;
        match self.encoding {
            Encoding::Ros2 if wrench => {
                ("geometry_msgs/msg/WrenchStamped", "ros2msg", definition(role, true).into_bytes())
            }
            Encoding::Ros2 => {
                ("geometry_msgs/msg/PoseStamped", "ros2msg", definition(role, true).into_bytes())
            }
            Encoding::Ros1 if wrench => {
                ("geometry_msgs/WrenchStamped", "ros1msg", definition(role, false).into_bytes())
            }
            Encoding::Ros1 => {
                ("geometry_msgs/PoseStamped", "ros1msg", definition(role, false).into_bytes())
            }
            #[cfg(feature = "protobuf")]
            Encoding::Protobuf => (protobuf::type_name(role), "protobuf", protobuf::schema(role)),
            Encoding::Json => {
                let name = if wrench { "WrenchStamped" } else { "PoseStamped" };
                let schema = json!({ "title": name, "type": "object" }).to_string();
                (name, "jsonschema", schema.into_bytes())
            }
        }
    }
}

/// Refuses stamps that the messages of ROS cannot hold.
pub(super) fn check_stamps(
    streams: &[(StreamRole, Vec<Sample>)],
    path: &Path,
    format: &'static str,
) -> Result<(), DatasetError> {
    let mut all = streams.iter().flat_map(|(_, samples)| samples);
    match all.find(|sample| !(0..1 << 31).contains(&sample.stamp().0)) {
        None => Ok(()),
        Some(sample) => Err(DatasetError::Unwritable {
            path: path.into(),
            format,
            what: format!("a stamp of {} s does not fit messages of ROS", sample.seconds()),
        }),
    }
}

/// The topic of a stream, as in the documentation's example.
pub(super) fn topic(role: StreamRole) -> &'static str {
    match role {
        StreamRole::Robot => "/robot/tip_pose",
        StreamRole::Object => "/vicon/object_pose",
        StreamRole::Wrench => "/ft_sensor/wrench",
    }
}

/// The stream whose next sample is the earliest; each keeps its own order.
pub(super) fn earliest(streams: &[(StreamRole, Vec<Sample>)], next: &[usize]) -> Option<usize> {
    let open = |i: &usize| next[*i] < streams[*i].1.len();
    (0..streams.len()).filter(open).min_by_key(|i| streams[*i].1[next[*i]].time_us)
}

fn json_message(role: StreamRole, sample: &Sample) -> Value {
    let (sec, nanosec) = sample.stamp();
    let numbers = numbers(role, sample);
    let parts = |names: &[&str], numbers: &[f64]| -> Value {
        let pairs = names.iter().zip(numbers);
        pairs
            .map(|(name, number)| ((*name).to_owned(), json!(number)))
            .collect::<Map<_, _>>()
            .into()
    };
    let axes = ["x", "y", "z", "w"];
    let (name, inner) = if role == StreamRole::Wrench {
        ("wrench", ["force", "torque"])
    } else {
        ("pose", ["position", "orientation"])
    };
    json!({
        "header": { "stamp": { "sec": sec, "nanosec": nanosec }, "frame_id": FRAME },
        name: { inner[0]: parts(&axes[..3], &numbers[..3]), inner[1]: parts(&axes, &numbers[3..]) },
    })
}
