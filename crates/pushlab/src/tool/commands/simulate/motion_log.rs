//! A roll-out as an MCAP log with the schemas of Foxglove, in JSON.

use std::collections::BTreeMap;
use std::io::Cursor;

use anyhow::Result;
use mcap::records::{MessageHeader, Metadata};
use mcap::{WriteOptions, Writer};
use planar::Pose;
use serde_json::{Value, json};

use super::rolled::{Rolled, Snapshot};
use crate::tool::origin::Origin;

/// The frame that everything is in.
const FRAME: &str = "world";
/// Points on the pusher's rim.
const RIM: usize = 24;

/// A schema as Foxglove publishes it.
#[derive(Clone, Copy)]
struct Schema {
    name: &'static str,
    text: &'static str,
}

const POSE: Schema = Schema {
    name: "foxglove.PoseInFrame",
    text: include_str!("../../../../schemas/foxglove/PoseInFrame.json"),
};
const POSES: Schema = Schema {
    name: "foxglove.PosesInFrame",
    text: include_str!("../../../../schemas/foxglove/PosesInFrame.json"),
};
const SCENE: Schema = Schema {
    name: "foxglove.SceneUpdate",
    text: include_str!("../../../../schemas/foxglove/SceneUpdate.json"),
};

/// Topics with their schemas; particles and measured poses are there if the push has some.
const TOPICS: [(&str, Schema); 5] = [
    ("/robot/tip_pose", POSE),
    ("/object/pose", POSE),
    ("/object/particles", POSES),
    ("/object/outline", SCENE),
    ("/measured/pose", POSE),
];

/// The log of a push: the pusher, the mean pose, the particles, the outlines, and, of a recorded push,
/// the measured pose.
///
/// # Errors
/// If the log cannot be encoded.
pub(super) fn motion_log(rolled: &Rolled, origin: &Origin) -> Result<Vec<u8>> {
    // Threads of the compressor would change the bytes from machine to machine.
    let options = WriteOptions::new().library("pushlab").compression_threads(0);
    let mut writer = options.create(Cursor::new(Vec::new()))?;
    let is_there = [true, true, rolled.snapshots.is_some(), true, rolled.measured_wb.is_some()];
    let mut channels = Vec::new();
    for ((topic, Schema { name, text }), _) in TOPICS.iter().zip(is_there).filter(|(_, is)| *is) {
        let schema = writer.add_schema(name, "jsonschema", text.as_bytes())?;
        channels.push(writer.add_channel(schema, topic, "json", &BTreeMap::new())?);
    }
    for (index, moment) in rolled.moments.iter().enumerate() {
        let time = (1e9 * moment.time).round() as u64;
        let pusher = Pose::new(moment.pusher_w[0], moment.pusher_w[1], 0.0);
        let mean = moment.pose_wb.mean;
        let mean = Pose::new(mean.x, mean.y, mean.z);
        let mut messages = vec![pose_in_frame(time, &pusher), pose_in_frame(time, &mean)];
        messages.extend(rolled.snapshots.as_ref().map(|all| poses_in_frame(time, &all[index])));
        messages.push(outlines(time, rolled, &pusher, &mean));
        let measured = rolled.measured_wb.as_ref().and_then(|measured| measured[index]);
        messages.extend(measured.map(|measured| pose_in_frame(time, &measured)));
        for (channel_id, message) in channels.iter().zip(messages) {
            let (channel_id, sequence) = (*channel_id, index as u32);
            let header = MessageHeader { channel_id, sequence, log_time: time, publish_time: time };
            writer.write_to_known_channel(&header, message.to_string().as_bytes())?;
        }
    }
    made_by(&mut writer, origin)?;
    writer.finish()?;
    Ok(writer.into_inner().into_inner())
}

fn made_by(writer: &mut Writer<Cursor<Vec<u8>>>, origin: &Origin) -> Result<()> {
    let mut metadata = BTreeMap::from([
        ("tool".to_owned(), origin.tool.to_owned()),
        ("arguments".to_owned(), origin.command_line()),
    ]);
    for input in &origin.inputs {
        metadata.insert(format!("sha256 of {}", input.path.display()), input.sha256.clone());
    }
    Ok(writer.write_metadata(&Metadata { name: "made by".to_owned(), metadata })?)
}

fn stamp(time: u64) -> Value {
    json!({ "sec": time / 1_000_000_000, "nsec": time % 1_000_000_000 })
}

fn pose(pose: &Pose) -> Value {
    let (sin, cos) = (0.5 * pose.angle).sin_cos();
    json!({
        "position": { "x": pose.position.x, "y": pose.position.y, "z": 0.0 },
        "orientation": { "x": 0.0, "y": 0.0, "z": sin, "w": cos },
    })
}

fn pose_in_frame(time: u64, of: &Pose) -> Value {
    json!({ "timestamp": stamp(time), "frame_id": FRAME, "pose": pose(of) })
}

fn poses_in_frame(time: u64, snapshot: &Snapshot) -> Value {
    let poses: Vec<_> = snapshot.iter().map(pose).collect();
    json!({ "timestamp": stamp(time), "frame_id": FRAME, "poses": poses })
}

/// The object at its mean pose, and the pusher, each as a closed line.
fn outlines(time: u64, rolled: &Rolled, pusher: &Pose, mean: &Pose) -> Value {
    let object: Vec<[f64; 2]> = rolled.outline.iter().map(|corner| (*corner).into()).collect();
    let rim = (0..RIM).map(|k| {
        let (sin, cos) = (std::f64::consts::TAU * k as f64 / RIM as f64).sin_cos();
        [rolled.pusher_radius * cos, rolled.pusher_radius * sin]
    });
    let entity = |id: &str, at: &Pose, points: Vec<[f64; 2]>, color: [f64; 3]| {
        let points: Vec<_> =
            points.iter().map(|[x, y]| json!({ "x": x, "y": y, "z": 0.0 })).collect();
        let [r, g, b] = color;
        json!({
            "timestamp": stamp(time), "frame_id": FRAME, "id": id,
            "lifetime": { "sec": 0, "nsec": 0 }, "frame_locked": false, "metadata": [],
            "arrows": [], "cubes": [], "spheres": [], "cylinders": [], "triangles": [],
            "texts": [], "models": [],
            "lines": [{
                "type": 1, "pose": pose(at), "thickness": 2.0, "scale_invariant": true,
                "points": points, "color": { "r": r, "g": g, "b": b, "a": 1.0 },
                "colors": [], "indices": [],
            }],
        })
    };
    let entities = [
        entity("object", mean, object, [0.0, 0.45, 0.7]),
        entity("pusher", pusher, rim.collect(), [0.84, 0.37, 0.0]),
    ];
    json!({ "deletions": [], "entities": entities })
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use models::{Analytical, PushPath, Pushed, RollOutSettings};
    use nalgebra::Vector2;
    use planar::{Pose, Shape};
    use serde_json::{Value, json};

    use super::{SCENE, motion_log};
    use crate::tool::commands::simulate::method::Method;
    use crate::tool::commands::simulate::rolled::{Rolled, Task};
    use crate::tool::origin::Origin;

    /// A push of 20 mm that turns the object, beside a measured one of as many poses.
    fn rolled(matched: Option<Method>) -> Rolled {
        let pushed = Pushed {
            shape: Arc::new(Shape::square(0.09).unwrap()),
            pusher_radius: 0.005,
            object: None,
        };
        let start = Vector2::new(-0.05, 0.02);
        let task = Task {
            name: "turn".to_owned(),
            pushed,
            path: PushPath::straight(start, start + Vector2::new(0.02, 0.0), 0.02).unwrap(),
            start_wb: Pose::default(),
            measured_wb: Some(vec![Pose::new(0.1, 0.0, 0.3); 6]),
            pose_sd: [[0.0; 2]; 2],
            touching: true,
        };
        let settings = RollOutSettings { n_particles: 7, ..RollOutSettings::default() };
        task.roll_out(&Analytical::nominal(0.25).unwrap(), &settings, matched).unwrap()
    }

    /// What is wrong with a value by a JSON Schema, of the words that Foxglove uses.
    fn fault(value: &Value, schema: &Value, at: &str) -> Option<String> {
        if let Some(choices) = schema["oneOf"].as_array() {
            let is_one = choices.iter().any(|choice| choice["const"] == *value);
            return (!is_one).then(|| format!("{at}: {value} is none of the choices"));
        }
        let is_number = |least: fn(&Value) -> bool| {
            let bound = |key: &str| schema[key].as_f64().zip(value.as_f64());
            least(value)
                && bound("minimum").is_none_or(|(low, value)| value >= low)
                && bound("maximum").is_none_or(|(high, value)| value <= high)
        };
        let is_sound = match schema["type"].as_str() {
            Some("number") => is_number(Value::is_number),
            Some("integer") => is_number(|value| value.is_i64() || value.is_u64()),
            Some("string") => value.is_string(),
            Some("boolean") => value.is_boolean(),
            Some("array") => {
                let Some(items) = value.as_array() else { return Some(format!("{at}: no list")) };
                let items = items.iter().enumerate();
                let mut faults =
                    items.map(|(k, item)| fault(item, &schema["items"], &format!("{at}[{k}]")));
                return faults.find_map(|found| found);
            }
            Some("object") => return fault_of_object(value, schema, at),
            _ => false,
        };
        (!is_sound).then(|| format!("{at}: {value} is not of {schema}"))
    }

    fn fault_of_object(value: &Value, schema: &Value, at: &str) -> Option<String> {
        let Some(fields) = value.as_object() else { return Some(format!("{at}: no object")) };
        let required = schema["required"].as_array().into_iter().flatten();
        let names = required.filter_map(Value::as_str);
        let lacking = names.filter(|name| !fields.contains_key(*name));
        if let Some(name) = lacking.collect::<Vec<_>>().first() {
            return Some(format!("{at}: lacks {name}"));
        }
        fields.iter().find_map(|(name, value)| match &schema["properties"][name] {
            Value::Null => Some(format!("{at}: does not know {name}")),
            known => fault(value, known, &format!("{at}.{name}")),
        })
    }

    #[test]
    fn every_message_is_what_foxglove_publishes_under_its_name() {
        check(&rolled(None), 5);
        check(&rolled(Some(Method::Unscented)), 4);
    }

    fn check(rolled: &Rolled, n_topics: usize) {
        let log = motion_log(rolled, &Origin::new("simulate")).unwrap();
        let mut topics = std::collections::BTreeMap::<String, usize>::new();
        for message in mcap::MessageStream::new(&log).unwrap() {
            let message = message.unwrap();
            let (channel, schema) = (&message.channel, message.channel.schema.as_ref().unwrap());
            assert_eq!((&*channel.message_encoding, &*schema.encoding), ("json", "jsonschema"));
            let published: Value = serde_json::from_slice(&schema.data).unwrap();
            assert_eq!(published["title"], schema.name);
            let value: Value = serde_json::from_slice(&message.data).unwrap();
            assert_eq!(fault(&value, &published, &channel.topic), None);
            *topics.entry(channel.topic.clone()).or_default() += 1;
            if channel.topic == "/object/pose" {
                let index = message.sequence as usize;
                let mean = rolled.moments[index].pose_wb.mean;
                assert_eq!(value["pose"]["position"]["x"], mean.x);
                assert_eq!(value["pose"]["orientation"]["z"], (0.5 * mean.z).sin());
                assert_eq!(message.log_time, (1e9 * rolled.moments[index].time).round() as u64);
            }
        }
        assert_eq!(topics.len(), n_topics);
        // Viewers seek by the index at the end of a log.
        let summary = mcap::Summary::read(&log).unwrap().unwrap();
        let n_messages = summary.stats.unwrap().message_count;
        assert_eq!(n_messages, topics.values().sum::<usize>() as u64);
        assert!(!summary.chunk_indexes.is_empty() && summary.channels.len() == n_topics);
        assert!(topics.values().all(|n| *n == rolled.moments.len()), "{topics:?}");
    }

    #[test]
    fn a_message_that_departs_from_its_schema_is_found_out() {
        let schema: Value = serde_json::from_str(SCENE.text).unwrap();
        let good = json!({ "deletions": [], "entities": [] });
        assert_eq!(fault(&good, &schema, ""), None);
        let deletion = |kind: i32, nsec: i64| {
            let time = json!({ "sec": 0, "nsec": nsec });
            json!({ "deletions": [{ "timestamp": time, "type": kind, "id": "a" }], "entities": [] })
        };
        assert_eq!(fault(&deletion(1, 0), &schema, ""), None);
        for bad in [
            json!({ "deletions": [] }),
            json!({ "deletions": [], "entities": [{ "id": "a" }] }),
            json!({ "deletions": [], "entities": [], "more": 1 }),
            deletion(2, 0),
            deletion(1, -1),
            deletion(1, 1_000_000_000),
        ] {
            assert!(fault(&bad, &schema, "").is_some(), "{bad}");
        }
    }
}
