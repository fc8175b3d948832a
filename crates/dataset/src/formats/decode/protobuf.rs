//! Messages in protobuf, walked on the wire by field numbers of the schema in the log.

use prost_reflect::{DescriptorPool, FieldDescriptor, Kind, MessageDescriptor};

use super::{MessageError, Row, Slot, Wanted, split_path};
use crate::input::caught::caught_text;

/// The message type of a protobuf channel.
pub(crate) struct ProtobufSchema {
    message: MessageDescriptor,
    /// How deep types may be nested.
    nesting: usize,
}

/// Parts of a file descriptor set that hold named parts in turn.
#[derive(Clone, Copy)]
enum Part {
    Set,
    File,
    Message,
    Other,
}

/// How many messages, fields and names a file descriptor set declares, before it is read.
pub(super) fn n_entries(set: &[u8]) -> u64 {
    let mut n = 0_u64;
    let mut parts = vec![(Part::Set, set)];
    while let Some((part, mut bytes)) = parts.pop() {
        while let Some((number, wire)) = next_field(&mut bytes) {
            let Wire::Bytes(inner) = wire else { continue };
            n += 1;
            let inner_part = match (part, number) {
                (Part::Set, 1) => Part::File,
                (Part::File, 4) | (Part::Message, 3) => Part::Message,
                // Enumerations, services, and where in its source each part stood.
                (Part::File, 5 | 6 | 9) | (Part::Message, 4) => Part::Other,
                _ => continue,
            };
            parts.push((inner_part, inner));
        }
    }
    n
}

impl ProtobufSchema {
    pub(crate) fn parse(type_name: &str, schema: &[u8], nesting: usize) -> Result<Self, String> {
        // A damaged set can make the library panic.
        let pool = caught_text(|| DescriptorPool::decode(schema));
        let pool = pool
            .and_then(|pool| pool.map_err(|error| error.to_string()))
            .map_err(|error| format!("the schema is no FileDescriptorSet: {error}"))?;
        let message = pool.get_message_by_name(type_name);
        let message = message.ok_or_else(|| format!("the schema does not define {type_name}"))?;
        Ok(Self { message, nesting })
    }

    /// Whether a path leads to a number, or to a text if `text`.
    pub(crate) fn has(&self, path: &str, text: bool) -> bool {
        let (mut message, mut rest) = (self.message.clone(), path);
        loop {
            let (name, is_list, tail) = split_path(rest);
            let Some(field) = message.get_field_by_name(name) else { return false };
            if is_list != field.is_list() || field.is_map() {
                return false;
            }
            match (field.kind(), tail.is_empty()) {
                (Kind::Message(inner), false) => (message, rest) = (inner, tail),
                (Kind::Message(_) | Kind::Bytes, _) | (_, false) => return false,
                (Kind::String, true) => return text,
                (_, true) => return !text,
            }
        }
    }
}

/// The wanted fields of a protobuf channel.
pub(crate) struct ProtobufPlan {
    root: Node,
    rows_in_list: bool,
}

/// The wanted fields of one message type, by field number.
#[derive(Default)]
struct Node {
    fields: Vec<(u32, Target)>,
}

enum Target {
    Number(NumberKind, Slot),
    Text(Slot),
    Message { node: Node, is_list: bool },
}

#[derive(Clone, Copy)]
enum NumberKind {
    Double,
    Float,
    Varint { signed: bool },
    Zigzag,
    Fixed { signed: bool },
}

/// A field as it stands on the wire.
enum Wire<'m> {
    Varint(u64),
    Eight([u8; 8]),
    Bytes(&'m [u8]),
    Four([u8; 4]),
}

impl ProtobufPlan {
    pub(crate) fn compile(schema: &ProtobufSchema, wanted: &[Wanted]) -> Result<Self, String> {
        let mut root = Node::default();
        for Wanted { slot, path } in wanted {
            root.add(&schema.message, path, *slot, schema.nesting)?;
        }
        Ok(Self { root, rows_in_list: wanted.iter().any(|w| w.path.contains("[]")) })
    }

    pub(crate) fn decode(
        &self,
        message: &[u8],
        emit: &mut dyn FnMut(&Row<'_>),
    ) -> Result<(), MessageError> {
        let mut row = Row::default();
        self.root.walk(message, message.len(), &mut row, emit)?;
        if !self.rows_in_list {
            emit(&row);
        }
        Ok(())
    }
}

impl Node {
    fn add(
        &mut self,
        message: &MessageDescriptor,
        path: &str,
        slot: Slot,
        depth_left: usize,
    ) -> Result<(), String> {
        let (name, is_list, rest) = split_path(path);
        let field = message.get_field_by_name(name).ok_or_else(|| format!("no field `{name}`"))?;
        let depth_left = depth_left.checked_sub(1).ok_or_else(|| {
            format!("`{path}` is nested too deep; raise nesting in [limits] of dataset.toml")
        })?;
        let number = field.number();
        match field.kind() {
            Kind::Message(inner) => {
                let place = self.fields.iter().position(|(known, _)| *known == number);
                let place = place.unwrap_or_else(|| {
                    self.fields.push((number, Target::Message { node: Self::default(), is_list }));
                    self.fields.len() - 1
                });
                if let (_, Target::Message { node, .. }) = &mut self.fields[place] {
                    node.add(&inner, rest, slot, depth_left)?;
                }
            }
            Kind::String => self.fields.push((number, Target::Text(slot))),
            _ => self.fields.push((number, Target::Number(number_kind(&field)?, slot))),
        }
        Ok(())
    }

    /// Walks one message; `total` is the length of the outermost one, for the errors' byte.
    fn walk<'m>(
        &self,
        mut bytes: &'m [u8],
        total: usize,
        row: &mut Row<'m>,
        emit: &mut dyn FnMut(&Row<'_>),
    ) -> Result<(), MessageError> {
        while !bytes.is_empty() {
            let (number, wire) = next_field(&mut bytes).ok_or(MessageError {
                byte: total.saturating_sub(bytes.len()),
                what: "no valid protobuf field",
            })?;
            for (_, target) in self.fields.iter().filter(|(wanted, _)| *wanted == number) {
                match (target, &wire) {
                    (Target::Number(kind, slot), _) => {
                        let value = kind.value(&wire).ok_or(MessageError {
                            byte: total.saturating_sub(bytes.len()),
                            what: "a number of another wire type than its schema's",
                        })?;
                        row.set_number(*slot, value);
                    }
                    (Target::Text(slot), Wire::Bytes(text)) => row.set_text(*slot, text),
                    (Target::Message { node, is_list: false }, Wire::Bytes(inner)) => {
                        node.walk(inner, total, row, emit)?;
                    }
                    (Target::Message { node, is_list: true }, Wire::Bytes(inner)) => {
                        let mut element = *row;
                        node.walk(inner, total, &mut element, emit)?;
                        emit(&element);
                    }
                    _ => {
                        return Err(MessageError {
                            byte: total.saturating_sub(bytes.len()),
                            what: "a field of another wire type than its schema's",
                        });
                    }
                }
            }
        }
        Ok(())
    }
}

impl NumberKind {
    fn value(self, wire: &Wire<'_>) -> Option<f64> {
        Some(match (self, wire) {
            (Self::Double, Wire::Eight(bytes)) => f64::from_le_bytes(*bytes),
            (Self::Float, Wire::Four(bytes)) => f64::from(f32::from_le_bytes(*bytes)),
            (Self::Varint { signed: true }, Wire::Varint(n)) => n.cast_signed() as f64,
            (Self::Varint { signed: false }, Wire::Varint(n)) => *n as f64,
            (Self::Zigzag, Wire::Varint(n)) => {
                ((n >> 1).cast_signed() ^ -(n & 1).cast_signed()) as f64
            }
            (Self::Fixed { signed: true }, Wire::Eight(bytes)) => i64::from_le_bytes(*bytes) as f64,
            (Self::Fixed { signed: false }, Wire::Eight(bytes)) => {
                u64::from_le_bytes(*bytes) as f64
            }
            (Self::Fixed { signed: true }, Wire::Four(bytes)) => {
                f64::from(i32::from_le_bytes(*bytes))
            }
            (Self::Fixed { signed: false }, Wire::Four(bytes)) => {
                f64::from(u32::from_le_bytes(*bytes))
            }
            _ => return None,
        })
    }
}

fn number_kind(field: &FieldDescriptor) -> Result<NumberKind, String> {
    Ok(match field.kind() {
        Kind::Double => NumberKind::Double,
        Kind::Float => NumberKind::Float,
        Kind::Int32 | Kind::Int64 | Kind::Enum(_) => NumberKind::Varint { signed: true },
        Kind::Uint32 | Kind::Uint64 | Kind::Bool => NumberKind::Varint { signed: false },
        Kind::Sint32 | Kind::Sint64 => NumberKind::Zigzag,
        Kind::Sfixed32 | Kind::Sfixed64 => NumberKind::Fixed { signed: true },
        Kind::Fixed32 | Kind::Fixed64 => NumberKind::Fixed { signed: false },
        Kind::String | Kind::Bytes | Kind::Message(_) => {
            return Err(format!("`{}` is no number", field.name()));
        }
    })
}

/// The next field of a message; none if the bytes are no field.
fn next_field<'m>(bytes: &mut &'m [u8]) -> Option<(u32, Wire<'m>)> {
    let tag = varint(bytes)?;
    let wire = match tag & 7 {
        0 => Wire::Varint(varint(bytes)?),
        1 => Wire::Eight(*bytes.split_off(..8)?.first_chunk()?),
        2 => {
            let length = usize::try_from(varint(bytes)?).ok()?;
            Wire::Bytes(bytes.split_off(..length)?)
        }
        5 => Wire::Four(*bytes.split_off(..4)?.first_chunk()?),
        _ => return None,
    };
    Some((u32::try_from(tag >> 3).ok()?, wire))
}

fn varint(bytes: &mut &[u8]) -> Option<u64> {
    let mut value = 0_u64;
    for shift in (0..64).step_by(7) {
        let (&byte, rest) = bytes.split_first()?;
        *bytes = rest;
        value |= u64::from(byte & 0x7f) << shift;
        if byte < 0x80 {
            return Some(value);
        }
    }
    None
}

#[cfg(test)]
mod tests;
