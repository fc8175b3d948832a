//! The protobuf decoder against the reference encoder, and damage.

use proptest::prelude::{any, prop, prop_assert, proptest};
use prost_reflect::{
    DynamicMessage,
    prost::Message,
    prost_types::{
        DescriptorProto, FieldDescriptorProto, FileDescriptorProto, FileDescriptorSet,
        MessageOptions,
        field_descriptor_proto::{Label, Type},
    },
};

use super::{ProtobufPlan, ProtobufSchema};
use crate::formats::decode::{Row, Slot, Wanted};

fn field(
    name: &str,
    number: i32,
    kind: Type,
    of: Option<&str>,
    list: bool,
) -> FieldDescriptorProto {
    FieldDescriptorProto {
        name: Some(name.into()),
        number: Some(number),
        label: Some(if list { Label::Repeated } else { Label::Optional }.into()),
        r#type: Some(kind.into()),
        type_name: of.map(String::from),
        ..Default::default()
    }
}

fn schema() -> ProtobufSchema {
    ProtobufSchema::parse("p.Thing", &set().encode_to_vec(), 32).unwrap()
}

fn set() -> FileDescriptorSet {
    let message = |name: &str, field: Vec<_>| DescriptorProto {
        name: Some(name.into()),
        field,
        ..Default::default()
    };
    let file = FileDescriptorProto {
        name: Some("thing.proto".into()),
        package: Some("p".into()),
        syntax: Some("proto3".into()),
        message_type: vec![
            message(
                "Item",
                vec![
                    field("child", 1, Type::String, None, false),
                    field("y", 2, Type::Float, None, false),
                    field("s", 3, Type::Sint32, None, false),
                ],
            ),
            message(
                "Thing",
                vec![
                    field("seconds", 1, Type::Int64, None, false),
                    field("items", 2, Type::Message, Some(".p.Item"), true),
                    field("one", 3, Type::Message, Some(".p.Item"), false),
                    field("f", 4, Type::Fixed32, None, false),
                ],
            ),
        ],
        ..Default::default()
    };
    FileDescriptorSet { file: vec![file] }
}

fn plan(fields: &[(Slot, &str)]) -> ProtobufPlan {
    let wanted: Vec<_> =
        fields.iter().map(|&(slot, path)| Wanted { slot, path: path.into() }).collect();
    ProtobufPlan::compile(&schema(), &wanted).unwrap()
}

fn message() -> Vec<u8> {
    let text = r#"{"seconds": "-5", "f": 7, "one": {"y": 0.5, "s": -3},
                   "items": [{"child": "a", "y": 1.25}, {"child": "b", "y": 2.5}]}"#;
    let mut json = serde_json::Deserializer::from_str(text);
    DynamicMessage::deserialize(schema().message, &mut json).unwrap().encode_to_vec()
}

#[test]
fn the_plan_reads_what_the_reference_encoder_writes() {
    let fields = [
        (Slot::Sec, "seconds"),
        (Slot::Value(0), "one.y"),
        (Slot::Value(1), "one.s"),
        (Slot::Value(2), "f"),
    ];
    let mut seen = Vec::new();
    plan(&fields).decode(&message(), &mut |row| seen.push((row.sec, row.values))).unwrap();
    assert_eq!(seen, [(-5.0, [0.5, -3.0, 7.0, 0.0, 0.0, 0.0, 0.0, 0.0])]);
}

#[test]
fn each_element_of_a_list_is_a_row() {
    let mut rows = Vec::new();
    plan(&[(Slot::Value(0), "items[].y"), (Slot::Child, "items[].child")])
        .decode(&message(), &mut |row: &Row<'_>| rows.push((row.values[0], row.child.to_vec())))
        .unwrap();
    assert_eq!(rows, [(1.25, b"a".to_vec()), (2.5, b"b".to_vec())]);
}

#[test]
fn paths_follow_the_schema() {
    let schema = schema();
    assert!(schema.has("items[].y", false) && schema.has("one.child", true));
    assert!(!schema.has("items.y", false) && !schema.has("one", false));
    assert!(!schema.has("one.child", false) && !schema.has("nothing", false));
    assert!(ProtobufSchema::parse("p.Thing", b"\xff", 32).is_err());
}

/// A set that defines the options of messages anew: the library reads its own by that definition,
/// writes them, and takes for granted that it can read what it wrote.
#[test]
fn a_damaged_schema_that_makes_the_library_panic_is_an_error() {
    let message = |name: &str, field: Vec<_>, options| DescriptorProto {
        name: Some(name.into()),
        field,
        options,
        ..Default::default()
    };
    let options = MessageOptions { deprecated: Some(true), ..Default::default() };
    let file = FileDescriptorProto {
        name: Some("m.proto".into()),
        package: Some("google.protobuf".into()),
        syntax: Some("proto3".into()),
        message_type: vec![
            message("MessageOptions", vec![field("deprecated", 3, Type::Bool, None, true)], None),
            message("M", vec![field("x", 1, Type::Double, None, false)], Some(options)),
        ],
        ..Default::default()
    };
    let set = FileDescriptorSet { file: vec![file] };
    let parsed = ProtobufSchema::parse("google.protobuf.M", &set.encode_to_vec(), 32);
    let error = parsed.err().unwrap();
    let begin = "the schema is no FileDescriptorSet: called `Result::unwrap()` on an `Err` value";
    assert!(error.starts_with(begin), "{error}");
}

#[test]
fn the_parts_of_a_schema_are_counted_before_it_is_read() {
    // The file with name, package, syntax and two messages with a name and three or four
    // fields: all that has a length on the wire.
    assert_eq!(super::n_entries(&set().encode_to_vec()), 1 + 5 + (1 + 3) + (1 + 4));
    let nested = |n: usize| {
        (0..n).fold(Vec::new(), |inner: Vec<u8>, _| {
            let length = inner.len();
            [vec![0x1a, length as u8 & 0x7f | 0x80, (length >> 7) as u8], inner].concat()
        })
    };
    let deep = nested(4000);
    let message = [vec![0x22, deep.len() as u8 & 0x7f | 0x80, (deep.len() >> 7) as u8], deep];
    let message = message.concat();
    let head = vec![0x0a, message.len() as u8 & 0x7f | 0x80, (message.len() >> 7) as u8];
    let set = [head, message].concat();
    assert_eq!(super::n_entries(&set), 4002);
    assert!(ProtobufSchema::parse("M", &set, 32).is_err());
}

proptest! {
    #[test]
    fn damaged_messages_never_panic(random in prop::collection::vec(any::<u8>(), 0..60),
                                    at in 0..30_usize, byte in any::<u8>()) {
        let plan = plan(&[(Slot::Value(0), "items[].y"), (Slot::Sec, "seconds")]);
        let mut damaged = message();
        let at = at % damaged.len();
        damaged[at] = byte;
        for bytes in [&random, &damaged] {
            let mut n = 0;
            let _ = plan.decode(bytes, &mut |_| n += 1);
            prop_assert!(n <= bytes.len());
        }
    }
}
