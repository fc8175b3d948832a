//! A roll-out as an MCAP log with the schemas of Foxglove, in JSON.

use std::collections::BTreeMap;
use std::io::Cursor;

use anyhow::Result;
use mcap::records::{MessageHeader, Metadata};
use mcap::{WriteOptions, Writer};
use planar::Pose;
use serde_json::{Value, json};

use super::rolled::{Rolled, Snapshot};
use crate::origin::Origin;

/// The frame that everything is in.
const FRAME: &str = "world";
/// Points on the pusher's rim.
const RIM: usize = 24;

/// A topic with the name of its schema and what the schema describes.
const TOPICS: [(&str, &str); 5] = [
    ("/robot/tip_pose", "foxglove.PoseInFrame"),
    ("/object/pose", "foxglove.PoseInFrame"),
    ("/object/particles", "foxglove.PosesInFrame"),
    ("/object/outline", "foxglove.SceneUpdate"),
    ("/measured/pose", "foxglove.PoseInFrame"),
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
    let n_topics = TOPICS.len() - usize::from(rolled.measured_wb.is_none());
    let mut channels = Vec::new();
    for (topic, name) in &TOPICS[..n_topics] {
        let schema = writer.add_schema(name, "jsonschema", schema(name).to_string().as_bytes())?;
        channels.push(writer.add_channel(schema, topic, "json", &BTreeMap::new())?);
    }
    for (index, (moment, snapshot)) in rolled.moments.iter().zip(&rolled.snapshots).enumerate() {
        let time = (1e9 * moment.time).round() as u64;
        let pusher = Pose::new(moment.pusher_w[0], moment.pusher_w[1], 0.0);
        let mean = moment.pose_wb.mean;
        let mean = Pose::new(mean.x, mean.y, mean.z);
        let mut messages = vec![
            pose_in_frame(time, &pusher),
            pose_in_frame(time, &mean),
            poses_in_frame(time, snapshot),
            outlines(time, rolled, &pusher, &mean),
        ];
        if let Some(measured) = &rolled.measured_wb {
            messages.push(pose_in_frame(time, &measured[index]));
        }
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

/// The fields of a schema that are used here, as JSON Schema.
fn schema(name: &str) -> Value {
    let object = |title: &str, properties: Value| json!({ "title": title, "type": "object", "properties": properties });
    let list = |items: Value| json!({ "type": "array", "items": items });
    let (number, text) = (json!({ "type": "number" }), json!({ "type": "string" }));
    let integer = json!({ "type": "integer", "minimum": 0 });
    let time = object("time", json!({ "sec": integer, "nsec": integer }));
    let vector = object("foxglove.Vector3", json!({ "x": number, "y": number, "z": number }));
    let quaternion = object(
        "foxglove.Quaternion",
        json!({ "x": number, "y": number, "z": number, "w": number }),
    );
    let pose = object("foxglove.Pose", json!({ "position": vector, "orientation": quaternion }));
    let properties = match name {
        "foxglove.PoseInFrame" => json!({ "timestamp": time, "frame_id": text, "pose": pose }),
        "foxglove.PosesInFrame" => {
            json!({ "timestamp": time, "frame_id": text, "poses": list(pose) })
        }
        _ => {
            let color = object(
                "foxglove.Color",
                json!({ "r": number, "g": number, "b": number, "a": number }),
            );
            let line = object(
                "foxglove.LinePrimitive",
                json!({
                    "type": integer, "pose": pose, "thickness": number,
                    "scale_invariant": { "type": "boolean" }, "points": list(vector),
                    "color": color, "colors": list(color), "indices": list(integer.clone()),
                }),
            );
            let none = || list(json!({ "type": "object" }));
            let entity = object(
                "foxglove.SceneEntity",
                json!({
                    "timestamp": time, "frame_id": text, "id": text,
                    "lifetime": object("duration", json!({ "sec": integer, "nsec": integer })),
                    "frame_locked": { "type": "boolean" }, "metadata": none(), "arrows": none(),
                    "cubes": none(), "spheres": none(), "cylinders": none(),
                    "lines": list(line), "triangles": none(), "texts": none(), "models": none(),
                }),
            );
            json!({ "deletions": none(), "entities": list(entity) })
        }
    };
    object(name, properties)
}
