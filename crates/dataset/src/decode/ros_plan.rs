//! The plan that walks ROS messages: numbers to take and bytes to pass over.

use super::{
    MessageError, Row, Slot, Wanted,
    ros_schema::{Count, FieldKind, MAX_DEPTH, NumberKind, RosSchema},
    split_path,
};

/// A schema compiled for the wanted fields; decoding allocates nothing.
pub(crate) struct RosPlan {
    steps: Vec<Step>,
    cdr: bool,
    /// Whether rows come from the elements of a list and not from the message as a whole.
    rows_in_list: bool,
}

#[derive(Debug, PartialEq)]
enum Step {
    /// Passes over bytes that begin at a multiple of `align`.
    Skip { align: usize, size: usize },
    /// Takes a number.
    Number { kind: NumberKind, slot: Slot },
    /// Takes a string, or passes over it.
    Text { slot: Option<Slot> },
    /// Passes over a string of 16-bit units, as Cyclone DDS and Fast CDR 2 write it.
    WideText,
    /// Passes over a counted list of elements of fixed size.
    SkipList { align: usize, size: usize },
    /// Walks a list; the count is on the wire if none is given.
    Each { count: Option<usize>, steps: Vec<Step>, emits: bool },
}

/// A wanted path, as far as it is still to be followed.
type Wish<'a> = (&'a str, Slot);

impl RosPlan {
    /// Compiles the plan; every wanted path must be in the schema.
    pub(crate) fn compile(schema: &RosSchema, wanted: &[Wanted]) -> Result<Self, String> {
        let wishes: Vec<Wish<'_>> = wanted.iter().map(|w| (w.path.as_str(), w.slot)).collect();
        let mut steps = Vec::new();
        compile_struct(schema, 0, &wishes, 0, &mut steps)?;
        let needed = steps.iter().rposition(Step::yields).map_or(0, |last| last + 1);
        steps.truncate(needed);
        let rows_in_list = wanted.iter().any(|w| w.path.contains("[]"));
        Ok(Self { steps, cdr: schema.cdr, rows_in_list })
    }

    /// Hands each row of a message to `emit`.
    pub(crate) fn decode(
        &self,
        message: &[u8],
        emit: &mut dyn FnMut(&Row<'_>),
    ) -> Result<(), MessageError> {
        let mut cursor = Cursor::new(message, self.cdr)?;
        let mut row = Row::default();
        cursor.run(&self.steps, &mut row, emit)?;
        if !self.rows_in_list {
            emit(&row);
        }
        Ok(())
    }
}

impl Step {
    /// Whether the step takes something and does not only pass over bytes.
    fn yields(&self) -> bool {
        match self {
            Self::Number { .. } => true,
            Self::Text { slot } => slot.is_some(),
            Self::Each { emits, .. } => *emits,
            Self::Skip { .. } | Self::WideText | Self::SkipList { .. } => false,
        }
    }
}

fn compile_struct(
    schema: &RosSchema,
    type_index: usize,
    wishes: &[Wish<'_>],
    depth: usize,
    steps: &mut Vec<Step>,
) -> Result<(), String> {
    if depth >= MAX_DEPTH {
        return Err(format!(
            "type {} is nested more than {MAX_DEPTH} deep",
            schema.type_name(type_index)
        ));
    }
    let fields = schema.fields(type_index);
    if fields.is_empty() && schema.cdr {
        push_skip(steps, 1, 1);
    }
    for field in fields {
        let inner: Vec<Wish<'_>> = wishes
            .iter()
            .filter_map(|&(path, slot)| {
                let (name, is_list, rest) = split_path(path);
                (name == field.name && is_list == (field.count != Count::One))
                    .then_some((rest, slot))
            })
            .collect();
        match field.count {
            Count::One => compile_one(schema, &field.kind, &inner, depth, steps)?,
            Count::Fixed(count) => {
                compile_list(schema, &field.kind, &inner, depth, Some(count), steps)?;
            }
            Count::Sequence => compile_list(schema, &field.kind, &inner, depth, None, steps)?,
        }
    }
    Ok(())
}

fn compile_one(
    schema: &RosSchema,
    kind: &FieldKind,
    wishes: &[Wish<'_>],
    depth: usize,
    steps: &mut Vec<Step>,
) -> Result<(), String> {
    match kind {
        FieldKind::Number(number) => match wishes {
            [] => push_skip(steps, alignment(schema, *number), number.size()),
            [(_, slot)] => steps.push(Step::Number { kind: *number, slot: *slot }),
            _ => return Err("one field cannot serve as two quantities".into()),
        },
        FieldKind::Text => steps.push(Step::Text { slot: wishes.first().map(|wish| wish.1) }),
        FieldKind::WideText => steps.push(Step::WideText),
        FieldKind::Struct(inner) => compile_struct(schema, *inner, wishes, depth + 1, steps)?,
        FieldKind::Undefined(name) => {
            return Err(format!("the schema uses type {name} but does not define it"));
        }
    }
    Ok(())
}

fn compile_list(
    schema: &RosSchema,
    kind: &FieldKind,
    wishes: &[Wish<'_>],
    depth: usize,
    count: Option<usize>,
    steps: &mut Vec<Step>,
) -> Result<(), String> {
    let mut body = Vec::new();
    compile_one(schema, kind, wishes, depth, &mut body)?;
    match (body.as_slice(), count) {
        // Elements without bytes leave only their count.
        ([], None) => push_skip(steps, if schema.cdr { 4 } else { 1 }, 4),
        ([], Some(_)) | (_, Some(0)) => {}
        (&[Step::Skip { align, size }], Some(count)) if size % align == 0 => {
            let total = size.checked_mul(count).ok_or("an array of the schema is too large")?;
            push_skip(steps, align, total);
        }
        (&[Step::Skip { align, size }], None) if size % align == 0 => {
            steps.push(Step::SkipList { align, size });
        }
        _ => steps.push(Step::Each { count, emits: !wishes.is_empty(), steps: body }),
    }
    Ok(())
}

fn alignment(schema: &RosSchema, number: NumberKind) -> usize {
    if schema.cdr { number.size() } else { 1 }
}

/// Appends bytes to pass over, joined with the step before where the alignment allows.
fn push_skip(steps: &mut Vec<Step>, align: usize, size: usize) {
    if let Some(Step::Skip { align: last_align, size: last }) = steps.last_mut()
        && *last_align == align
        && last.is_multiple_of(align)
        && let Some(sum) = last.checked_add(size)
    {
        *last = sum;
    } else {
        steps.push(Step::Skip { align, size });
    }
}

/// A place in a message; alignment counts from the end of the CDR header.
struct Cursor<'m> {
    bytes: &'m [u8],
    at: usize,
    header: usize,
    big_endian: bool,
    align_mask: usize,
}

impl<'m> Cursor<'m> {
    fn new(message: &'m [u8], cdr: bool) -> Result<Self, MessageError> {
        if !cdr {
            return Ok(Self { bytes: message, at: 0, header: 0, big_endian: false, align_mask: 0 });
        }
        let big_endian = match message {
            [0, 0, _, _, ..] => true,
            [0, 1, _, _, ..] => false,
            [_, _, _, _, ..] => {
                return Err(MessageError {
                    byte: 0,
                    what: "an encapsulation other than plain CDR",
                });
            }
            _ => return Err(MessageError { byte: 0, what: "no CDR header" }),
        };
        Ok(Self { bytes: &message[4..], at: 0, header: 4, big_endian, align_mask: 7 })
    }

    fn run(
        &mut self,
        steps: &[Step],
        row: &mut Row<'m>,
        emit: &mut dyn FnMut(&Row<'_>),
    ) -> Result<(), MessageError> {
        for step in steps {
            match step {
                Step::Skip { align, size } => {
                    self.align(*align);
                    self.take(*size)?;
                }
                Step::Number { kind, slot } => {
                    let number = self.number(*kind)?;
                    row.set_number(*slot, number);
                }
                Step::Text { slot } => {
                    let length = self.count()?;
                    let text = self.take(length)?;
                    if let Some(slot) = slot {
                        row.set_text(*slot, text.strip_suffix(b"\0").unwrap_or(text));
                    }
                }
                Step::WideText => self.skip_list(2, 2)?,
                Step::SkipList { align, size } => self.skip_list(*align, *size)?,
                Step::Each { count, steps, emits } => {
                    let count = match count {
                        Some(count) => *count,
                        None => self.count()?,
                    };
                    for _ in 0..count {
                        self.run(steps, row, emit)?;
                        if *emits {
                            emit(row);
                        }
                    }
                }
            }
        }
        Ok(())
    }

    fn skip_list(&mut self, align: usize, size: usize) -> Result<(), MessageError> {
        let count = self.count()?;
        if count > 0 {
            self.align(align);
            let total = count.checked_mul(size).ok_or(self.too_short())?;
            self.take(total)?;
        }
        Ok(())
    }

    /// A count on the wire, which must not exceed the bytes that are left.
    fn count(&mut self) -> Result<usize, MessageError> {
        let count = self.number(NumberKind::U32)? as usize;
        if count > self.bytes.len() - self.at { Err(self.too_short()) } else { Ok(count) }
    }

    fn number(&mut self, kind: NumberKind) -> Result<f64, MessageError> {
        self.align(kind.size());
        Ok(match kind {
            NumberKind::U8 => f64::from(self.array::<1>()?[0]),
            NumberKind::I8 => f64::from(i8::from_le_bytes(self.array()?)),
            NumberKind::U16 => f64::from(u16::from_le_bytes(self.array()?)),
            NumberKind::I16 => f64::from(i16::from_le_bytes(self.array()?)),
            NumberKind::U32 => f64::from(u32::from_le_bytes(self.array()?)),
            NumberKind::I32 => f64::from(i32::from_le_bytes(self.array()?)),
            NumberKind::U64 => u64::from_le_bytes(self.array()?) as f64,
            NumberKind::I64 => i64::from_le_bytes(self.array()?) as f64,
            NumberKind::F32 => f64::from(f32::from_le_bytes(self.array()?)),
            NumberKind::F64 => f64::from_le_bytes(self.array()?),
        })
    }

    /// The next bytes in little-endian order.
    fn array<const N: usize>(&mut self) -> Result<[u8; N], MessageError> {
        let rest = self.bytes.get(self.at..).and_then(<[u8]>::first_chunk);
        let mut array = *rest.ok_or(self.too_short())?;
        self.at += N;
        if self.big_endian {
            array.reverse();
        }
        Ok(array)
    }

    /// Moves on to a multiple of `align`, a power of two; ROS 1 does not align.
    fn align(&mut self, align: usize) {
        let mask = (align - 1) & self.align_mask;
        self.at = (self.at + mask) & !mask;
    }

    fn take(&mut self, n: usize) -> Result<&'m [u8], MessageError> {
        let taken = self.at.checked_add(n).and_then(|end| self.bytes.get(self.at..end));
        let taken = taken.ok_or(self.too_short())?;
        self.at += n;
        Ok(taken)
    }

    fn too_short(&self) -> MessageError {
        MessageError { byte: self.header + self.at, what: "a length beyond the message's end" }
    }
}

#[cfg(test)]
mod tests;
