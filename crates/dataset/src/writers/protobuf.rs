//! Messages in protobuf: poses as `foxglove.PoseInFrame`, forces in a message of the same make.

use prost_reflect::{
    prost::Message,
    prost_types::{
        DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet,
        field_descriptor_proto::{Label, Type},
    },
};

use super::{
    cdr::{FRAME, numbers},
    sample::Sample,
};
use crate::remark::StreamRole;

/// The message type of a stream.
pub(super) fn type_name(role: StreamRole) -> &'static str {
    if role == StreamRole::Wrench { "pushlab.WrenchInFrame" } else { "foxglove.PoseInFrame" }
}

/// The schema of a stream: its file and those that it needs, as a `FileDescriptorSet`.
pub(super) fn schema(role: StreamRole) -> Vec<u8> {
    let double = |name: &'static str, number| field(name, number, Type::Double, None);
    let of = |name: &'static str, number, kind| field(name, number, Type::Message, Some(kind));
    let time = FileDescriptorProto {
        package: Some("google.protobuf".into()),
        message_type: vec![message(
            "Timestamp",
            vec![field("seconds", 1, Type::Int64, None), field("nanos", 2, Type::Int32, None)],
        )],
        ..file("google/protobuf/timestamp.proto")
    };
    let axes = || vec![double("x", 1), double("y", 2), double("z", 3)];
    let mut quaternion = axes();
    quaternion.push(double("w", 4));
    let parts = FileDescriptorProto {
        package: Some("foxglove".into()),
        message_type: vec![
            message("Vector3", axes()),
            message("Quaternion", quaternion),
            message(
                "Pose",
                vec![
                    of("position", 1, ".foxglove.Vector3"),
                    of("orientation", 2, ".foxglove.Quaternion"),
                ],
            ),
        ],
        ..file("foxglove/Pose.proto")
    };
    let (package, name) = type_name(role).split_once('.').unwrap_or_default();
    let mut fields = vec![
        of("timestamp", 1, ".google.protobuf.Timestamp"),
        field("frame_id", 2, Type::String, None),
    ];
    fields.extend(match role {
        StreamRole::Wrench => {
            vec![of("force", 3, ".foxglove.Vector3"), of("torque", 4, ".foxglove.Vector3")]
        }
        StreamRole::Robot | StreamRole::Object => vec![of("pose", 3, ".foxglove.Pose")],
    });
    let own = FileDescriptorProto {
        package: Some(package.into()),
        dependency: vec!["google/protobuf/timestamp.proto".into(), "foxglove/Pose.proto".into()],
        message_type: vec![message(name, fields)],
        ..file(&format!("{package}/{name}.proto"))
    };
    FileDescriptorSet { file: vec![time, parts, own] }.encode_to_vec()
}

fn file(name: &str) -> FileDescriptorProto {
    let syntax = Some("proto3".into());
    FileDescriptorProto { name: Some(name.into()), syntax, ..FileDescriptorProto::default() }
}

fn message(name: &str, field: Vec<FieldDescriptorProto>) -> DescriptorProto {
    DescriptorProto { name: Some(name.into()), field, ..DescriptorProto::default() }
}

fn field(name: &str, number: i32, kind: Type, of: Option<&str>) -> FieldDescriptorProto {
    FieldDescriptorProto {
        name: Some(name.into()),
        number: Some(number),
        label: Some(Label::Optional.into()),
        r#type: Some(kind.into()),
        type_name: of.map(String::from),
        ..FieldDescriptorProto::default()
    }
}

/// The bytes of a message; every field is written, zeros too.
pub(super) fn encode(role: StreamRole, sample: &Sample) -> Vec<u8> {
    let (sec, nanosec) = sample.stamp();
    let numbers = numbers(role, sample);
    let mut stamp = vec![1 << 3];
    varint(&mut stamp, sec.cast_unsigned());
    stamp.push(2 << 3);
    varint(&mut stamp, u64::from(nanosec));
    let mut bytes = Vec::with_capacity(120);
    nested(&mut bytes, 1, &stamp);
    nested(&mut bytes, 2, FRAME.as_bytes());
    let (first, second) = (doubles(&numbers[..3]), doubles(&numbers[3..]));
    if role == StreamRole::Wrench {
        nested(&mut bytes, 3, &first);
        nested(&mut bytes, 4, &second);
    } else {
        let mut pose = Vec::with_capacity(80);
        nested(&mut pose, 1, &first);
        nested(&mut pose, 2, &second);
        nested(&mut bytes, 3, &pose);
    }
    bytes
}

fn doubles(numbers: &[f64]) -> Vec<u8> {
    let fields = numbers.iter().zip(1_u8..);
    fields
        .flat_map(|(number, field)| [vec![field << 3 | 1], number.to_le_bytes().to_vec()].concat())
        .collect()
}

fn nested(bytes: &mut Vec<u8>, field: u8, inner: &[u8]) {
    bytes.push(field << 3 | 2);
    varint(bytes, inner.len() as u64);
    bytes.extend(inner);
}

fn varint(bytes: &mut Vec<u8>, mut value: u64) {
    while value >= 0x80 {
        bytes.push(value as u8 | 0x80);
        value >>= 7;
    }
    bytes.push(value as u8);
}

#[cfg(test)]
mod tests {
    use prost_reflect::{DescriptorPool, DynamicMessage};

    use super::{Sample, encode, schema, type_name};
    use crate::remark::StreamRole;

    #[test]
    fn the_reference_decoder_reads_what_is_written() {
        let sample = Sample { time_us: 1_500_000_000_250_000, values: [0.25, -0.5, 0.0] };
        for role in StreamRole::ALL {
            let pool = DescriptorPool::decode(schema(role).as_slice()).unwrap();
            let descriptor = pool.get_message_by_name(type_name(role)).unwrap();
            let message =
                DynamicMessage::decode(descriptor, encode(role, &sample).as_slice()).unwrap();
            let text = serde_json::to_string(&message).unwrap();
            assert!(text.contains("2017-07-14T02:40:00.25"), "{text}");
            assert!(text.contains(r#""x":0.25,"y":-0.5"#), "{text}");
            let is_force = role == StreamRole::Wrench;
            assert_eq!(text.contains(r#""force""#), is_force, "{text}");
            assert_eq!(text.contains(r#""w":1.0"#), !is_force, "{text}");
        }
    }
}
