//! Streams from logs held in memory: frames, misfits, named children.

use std::path::Path;

use serde_json::{Value, json};

use super::{inspect_log, read_log};
use crate::formats::container::Channel;
use crate::formats::container::{Container, Message, Sink};
use crate::input::limits::{Limit, ReadLimits};
use crate::recording::Recording;
use crate::recording::settings::Streams;
use crate::{
    error::DatasetError,
    remark::{Remark, RemarkKind, StreamRole},
};

/// JSON messages by topic.
struct Memory {
    channels: Vec<Channel>,
    messages: Vec<(u32, String)>,
}

impl Memory {
    fn new(messages: &[(&str, Value)]) -> Self {
        let mut memory = Self { channels: Vec::new(), messages: Vec::new() };
        for (topic, message) in messages {
            let known = memory.channels.iter().position(|channel| channel.topic == *topic);
            let id = known.unwrap_or_else(|| {
                let message_encoding = "json".into();
                let topic = (*topic).into();
                let id = memory.channels.len() as u32;
                memory.channels.push(Channel { id, topic, message_encoding, ..Channel::default() });
                memory.channels.len() - 1
            });
            memory.channels[id].count += 1;
            memory.messages.push((id as u32, message.to_string()));
        }
        memory
    }

    fn read(&self, settings: &str) -> Result<Recording, DatasetError> {
        self.read_within(settings, &ReadLimits::default())
    }

    fn read_within(&self, settings: &str, limits: &ReadLimits) -> Result<Recording, DatasetError> {
        let streams: Streams = toml::from_str(settings).unwrap();
        read_log(Path::new("log"), String::new(), self, &streams, limits)
    }
}

impl Container for Memory {
    fn channels(&self) -> &[Channel] {
        &self.channels
    }

    fn remarks(&self) -> &[Remark] {
        &[]
    }

    fn visit(
        &self,
        wanted: &dyn Fn(u32) -> bool,
        sink: &mut Sink<'_>,
    ) -> Result<Vec<Remark>, DatasetError> {
        for (i, (channel, message)) in self.messages.iter().enumerate() {
            let data = message.as_bytes();
            let message =
                Message { channel: *channel, log_time: 7_000_000_000, data, byte: i as u64 };
            if wanted(*channel) && sink(&message)?.is_break() {
                break;
            }
        }
        Ok(Vec::new())
    }
}

fn stamp() -> Value {
    json!({"stamp": {"sec": 6, "nanosec": 0}, "frame_id": "world"})
}

fn quarter_turn() -> Value {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    json!({"x": 0, "y": 0, "z": half, "w": half})
}

fn pose(x: f64) -> Value {
    json!({"header": stamp(), "pose": {
        "position": {"x": x, "y": 0, "z": 0}, "orientation": {"x": 0, "y": 0, "z": 0, "w": 1}}})
}

fn transform(parent: &str, child: &str, x: f64) -> Value {
    let mut header = stamp();
    header["frame_id"] = parent.into();
    json!({"header": header, "child_frame_id": child, "transform": {
        "translation": {"x": x, "y": 0, "z": 0}, "rotation": quarter_turn()}})
}

fn tf(transforms: &[Value]) -> Value {
    json!({ "transforms": transforms })
}

#[test]
fn poses_are_moved_by_the_logs_own_frames() {
    let frames = tf(&[transform("map", "viconworld", 2.0), transform("map", "base", 5.0)]);
    let memory =
        Memory::new(&[("/tip", pose(0.1)), ("/vicon/block", pose(0.5)), ("/tf", frames.clone())]);
    let settings = "[object]\ntransform = { tf_parent = \"map\", tf_child = \"viconworld\" }\n";
    let recording = memory.read(settings).unwrap();
    assert_eq!(recording.robot.x, [0.1]);
    assert!((recording.object.x[0] - 2.0).abs() < 1e-12);
    assert!((recording.object.y[0] - 0.5).abs() < 1e-12);
    assert!((recording.object.theta[0] - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    assert_eq!((recording.remarks.as_slice(), recording.epoch_ns), (&[][..], 6_000_000_000));
    let pairs = inspect_log(Path::new("log"), &memory, &ReadLimits::default()).unwrap().frames;
    assert_eq!(pairs, [("map".into(), "base".into()), ("map".into(), "viconworld".into())]);
    let error = memory.read(&settings.replace("\"map\"", "\"world\"")).unwrap_err();
    assert!(matches!(error, DatasetError::FrameMissing { stream: StreamRole::Object, .. }));
    assert_eq!(
        error.to_string(),
        "log: no frame `world ← viconworld` for the object stream; the recording has: \
         map ← base, map ← viconworld"
    );
    let moved = tf(&[transform("map", "viconworld", 2.1)]);
    let messages =
        [("/tip", pose(0.1)), ("/vicon/block", pose(0.5)), ("/tf", frames), ("/tf", moved)];
    let remarks = Memory::new(&messages).read(settings).unwrap().remarks;
    assert_eq!((remarks[0].kind, remarks[0].count), (RemarkKind::TransformVaries, 1));
}

#[test]
fn one_child_of_a_list_of_transforms_is_taken() {
    let both = tf(&[transform("map", "tip", 1.0), transform("map", "block", 2.0)]);
    let memory = Memory::new(&[("/tf", both)]);
    let settings = "[robot]\ntopic = \"/tf\"\nchild_frame = \"tip\"\n\
                    [object]\ntopic = \"/tf\"\nchild_frame = \"block\"\n";
    let recording = memory.read(settings).unwrap();
    assert_eq!((recording.robot.x[0], recording.object.x[0]), (1.0, 2.0));
    let error = memory.read(&settings.replace("\"block\"", "\"hex\"")).unwrap_err();
    assert_eq!(
        error.to_string(),
        "log: no frame `hex` for the object stream; the recording has: block, tip"
    );
    let error = memory.read(&settings.replace("child_frame = \"block\"", "")).unwrap_err();
    assert!(error.to_string().contains("none named: set streams.object.child_frame"), "{error}");
}

#[test]
fn messages_that_do_not_fit_are_set_aside_and_counted() {
    let broken = json!({"header": stamp(), "pose": {}});
    let mut messages = vec![("/tip", pose(0.1)), ("/block", pose(0.2)), ("/block", pose(0.3))];
    messages.push(("/block", broken.clone()));
    let recording = Memory::new(&messages).read("").unwrap();
    assert_eq!(recording.object.x, [0.2, 0.3]);
    let remark = &recording.remarks[0];
    assert_eq!((remark.kind, remark.count), (RemarkKind::MessageExcluded, 1));
    assert!(remark.text.starts_with("1 of 3 messages excluded: first, the message at byte 3"));
    messages.extend([("/block", broken.clone()), ("/block", broken)]);
    let error = Memory::new(&messages).read("").unwrap_err();
    assert!(matches!(error, DatasetError::MostlyUnusable { excluded: 3, total: 5, .. }), "{error}");
}

#[test]
fn messages_that_arrive_late_are_named() {
    let mut early = pose(0.1);
    early["header"]["stamp"]["sec"] = json!(5);
    let log = Memory::new(&[("/tip", pose(0.0)), ("/vicon", pose(0.0)), ("/vicon", early)]);
    let recording = log.read("").unwrap();
    let [remark] = &recording.remarks[..] else { panic!("{:?}", recording.remarks) };
    assert_eq!((remark.kind, remark.stream), (RemarkKind::Late, Some(StreamRole::Object)));
    assert!(remark.text.contains("1 of 2 messages") && remark.text.contains("at most 1000 ms"));
}

#[test]
fn more_samples_or_frames_than_allowed_are_refused() {
    let tips = tf(&[transform("map", "tip", 1.0), transform("map", "tip", 2.0)]);
    let memory = Memory::new(&[("/tf", tips), ("/vicon", pose(0.5)), ("/vicon", pose(0.6))]);
    let settings = "[robot]\ntopic = \"/tf\"\nchild_frame = \"tip\"\n";
    let error = |limit, most| {
        let limits = ReadLimits::default().with(limit, most);
        memory.read_within(settings, &limits).map(|_| ()).map_err(|error| error.to_string())
    };
    assert_eq!(error(Limit::Samples, 2), Ok(()));
    // Both come in one message.
    let message = error(Limit::Samples, 1).unwrap_err();
    assert!(message.starts_with("log: at least 2 samples of the robot stream"), "{message}");
    assert!(message.contains("raise samples in [limits] of dataset.toml"), "{message}");
    assert_eq!(error(Limit::Channels, 1), Ok(()));
    let both = tf(&[transform("map", "tip", 1.0), transform("map", "block", 2.0)]);
    let memory = Memory::new(&[("/tf", both), ("/vicon", pose(0.5))]);
    let limits = ReadLimits::default().with(Limit::Channels, 1);
    let message = memory.read_within(settings, &limits).unwrap_err().to_string();
    assert!(message.starts_with("log: at least 2 frames"), "{message}");
    let message = inspect_log(Path::new("log"), &memory, &limits).unwrap_err().to_string();
    assert!(message.starts_with("log: at least 2 frames"), "{message}");
}
