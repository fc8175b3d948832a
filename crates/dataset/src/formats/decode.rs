//! Messages become rows of numbers, by a plan compiled once from the schema in the log.

mod json;
#[cfg(feature = "protobuf")]
mod protobuf;
mod ros_plan;
mod ros_schema;

use crate::input::limits::{Limit, ReadLimits};

use json::{JsonPlan, JsonSchema};
#[cfg(feature = "protobuf")]
use protobuf::{ProtobufPlan, ProtobufSchema};
use ros_plan::RosPlan;
use ros_schema::RosSchema;

/// Most numbers that a stream takes from one message, its stamp aside.
pub(crate) const N_VALUES: usize = 8;

/// What is wanted of one message or of one element of its list of transforms.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Row<'m> {
    /// Seconds of the stamp; with a fraction where the log gives one number.
    pub(crate) sec: f64,
    /// Nanoseconds of the stamp.
    pub(crate) nanosec: f64,
    /// The values, in the order of the stream's quantities.
    pub(crate) values: [f64; N_VALUES],
    /// Name of the parent frame.
    pub(crate) parent: &'m [u8],
    /// Name of the child frame.
    pub(crate) child: &'m [u8],
}

impl<'m> Row<'m> {
    fn set_number(&mut self, slot: Slot, number: f64) {
        match slot {
            Slot::Sec => self.sec = number,
            Slot::Nanosec => self.nanosec = number,
            Slot::Value(i) => self.values[i] = number,
            Slot::Parent | Slot::Child => {}
        }
    }

    fn set_text(&mut self, slot: Slot, text: &'m [u8]) {
        match slot {
            Slot::Parent => self.parent = text,
            Slot::Child => self.child = text,
            Slot::Sec | Slot::Nanosec | Slot::Value(_) => {}
        }
    }
}

/// Where in a row a field goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Slot {
    Sec,
    Nanosec,
    Value(usize),
    Parent,
    Child,
}

impl Slot {
    fn is_text(self) -> bool {
        matches!(self, Self::Parent | Self::Child)
    }
}

/// A field to take from each message: `transforms[].header.stamp.sec` into the stamp's seconds.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Wanted {
    pub(crate) slot: Slot,
    pub(crate) path: String,
}

/// Why a message does not fit its schema.
#[derive(Debug, PartialEq, thiserror::Error)]
#[error("{what} at byte {byte} of the message")]
pub(crate) struct MessageError {
    pub(crate) byte: usize,
    pub(crate) what: &'static str,
}

/// The structure of a channel's messages.
pub(crate) enum Schema {
    Ros(RosSchema),
    Json(JsonSchema),
    #[cfg(feature = "protobuf")]
    Protobuf(ProtobufSchema),
}

impl Schema {
    /// Reads a schema; JSON takes it from a `sample` message.
    ///
    /// - `encodings`: of the messages and of the schema.
    pub(crate) fn parse(
        type_name: &str,
        encodings: (&str, &str),
        schema: &[u8],
        sample: Option<&[u8]>,
        limits: &ReadLimits,
    ) -> Result<Self, String> {
        let nesting = limits.of(Limit::Nesting) as usize;
        let ros = |cdr| RosSchema::parse(type_name, schema, cdr, nesting).map(Self::Ros);
        match encodings {
            ("ros1", "ros1msg") => ros(false),
            ("cdr", "ros2msg") => ros(true),
            ("cdr", "ros2idl") => Err("schemas in ros2idl are not read; record the topic with \
                                       a ros2msg schema"
                .into()),
            ("json", _) => Ok(Self::Json(JsonSchema::parse(sample)?)),
            #[cfg(feature = "protobuf")]
            ("protobuf", "protobuf") => {
                Ok(Self::Protobuf(ProtobufSchema::parse(type_name, schema, nesting)?))
            }
            #[cfg(not(feature = "protobuf"))]
            ("protobuf", _) => Err("protobuf is not part of this build; rebuild with the feature \
                                    `protobuf`"
                .into()),
            (message_encoding, schema_encoding) => Err(format!(
                "messages in `{message_encoding}` with a schema in `{schema_encoding}` are not \
                 read; known are ros1/ros1msg, cdr/ros2msg, json and protobuf"
            )),
        }
    }

    /// At most how many fields and types a schema declares, before it is read.
    pub(crate) fn n_fields(encodings: (&str, &str), schema: &[u8]) -> u64 {
        match encodings {
            ("ros1" | "cdr", _) => {
                1 + schema.iter().filter(|byte| matches!(byte, b'\n' | b'\r')).count() as u64
            }
            #[cfg(feature = "protobuf")]
            ("protobuf", "protobuf") => protobuf::n_entries(schema),
            _ => 0,
        }
    }

    /// Whether a path leads to a number, or to a text if `text`.
    pub(crate) fn has(&self, path: &str, text: bool) -> bool {
        match self {
            Self::Ros(schema) => schema.has(path, text),
            Self::Json(schema) => schema.has(path, text),
            #[cfg(feature = "protobuf")]
            Self::Protobuf(schema) => schema.has(path, text),
        }
    }

    /// Compiles the plan that takes the wanted fields from a message.
    pub(crate) fn compile(&self, wanted: &[Wanted]) -> Result<Decoder, String> {
        if let Some(missing) = wanted.iter().find(|w| !self.has(&w.path, w.slot.is_text())) {
            return Err(format!("no field `{}`", missing.path));
        }
        Ok(match self {
            Self::Ros(schema) => Decoder::Ros(RosPlan::compile(schema, wanted)?),
            Self::Json(_) => Decoder::Json(JsonPlan::compile(wanted)),
            #[cfg(feature = "protobuf")]
            Self::Protobuf(schema) => Decoder::Protobuf(ProtobufPlan::compile(schema, wanted)?),
        })
    }
}

/// Takes the wanted fields from messages of one channel.
pub(crate) enum Decoder {
    Ros(RosPlan),
    Json(JsonPlan),
    #[cfg(feature = "protobuf")]
    Protobuf(ProtobufPlan),
}

impl Decoder {
    /// Hands each row of a message to `emit`: one, or one for each element of a wanted list.
    pub(crate) fn decode(
        &self,
        message: &[u8],
        emit: &mut dyn FnMut(&Row<'_>),
    ) -> Result<(), MessageError> {
        match self {
            Self::Ros(plan) => plan.decode(message, emit),
            Self::Json(plan) => plan.decode(message, emit),
            #[cfg(feature = "protobuf")]
            Self::Protobuf(plan) => plan.decode(message, emit),
        }
    }
}

/// The first step of a path: its name, whether it runs over a list, and the rest.
fn split_path(path: &str) -> (&str, bool, &str) {
    let (head, rest) = path.split_once('.').unwrap_or((path, ""));
    match head.strip_suffix("[]") {
        Some(name) => (name, true, rest),
        None => (head, false, rest),
    }
}
