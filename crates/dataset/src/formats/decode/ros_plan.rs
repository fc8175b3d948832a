//! The plan that walks ROS messages: numbers to take and bytes to pass over.

use std::rc::Rc;

use super::{
    MessageError, Row, Slot, Wanted,
    ros_schema::{Count, FieldKind, NumberKind, RosSchema},
    split_path,
};

/// Longest plan of a type that is repeated wherever the type stands; a longer one is shared.
const REPEATED: usize = 4;

/// A schema compiled for the wanted fields; decoding allocates nothing.
pub(crate) struct RosPlan {
    steps: Vec<Step>,
    cdr: bool,
    /// Whether rows come from the elements of a list and not from the message as a whole.
    rows_in_list: bool,
}

#[derive(Clone, Debug, PartialEq)]
enum Step {
    /// Passes over bytes that begin at a multiple of `align`.
    Skip { align: usize, size: usize },
    /// Takes a number.
    Number { kind: NumberKind, slot: Slot },
    /// Takes numbers of 64 bits that follow each other.
    Numbers64(Vec<Slot>),
    /// Takes a string, or passes over it.
    Text { slot: Option<Slot> },
    /// Passes over a string of 16-bit units, as Cyclone DDS and Fast CDR 2 write it.
    WideText,
    /// Passes over a counted list of elements of fixed size.
    SkipList { align: usize, size: usize },
    /// Walks a list; the count is on the wire if none is given.
    Each { count: Option<usize>, steps: Rc<[Step]>, emits: bool },
    /// Walks a type of which nothing is wanted.
    Pass(Rc<[Step]>),
}

/// A wanted path, as far as it is still to be followed.
type Wish<'a> = (&'a str, Slot);

impl RosPlan {
    /// Compiles the plan; every wanted path must be in the schema.
    pub(crate) fn compile(schema: &RosSchema, wanted: &[Wanted]) -> Result<Self, String> {
        let wishes: Vec<Wish<'_>> = wanted.iter().map(|w| (w.path.as_str(), w.slot)).collect();
        let mut steps = Vec::new();
        let mut compiler = Compiler { schema, passed: vec![None; schema.n_types()] };
        compiler.compile_struct(0, &wishes, 0, &mut steps)?;
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
            Self::Number { .. } | Self::Numbers64(_) => true,
            Self::Text { slot } => slot.is_some(),
            Self::Each { emits, .. } => *emits,
            Self::Skip { .. } | Self::WideText | Self::SkipList { .. } | Self::Pass(_) => false,
        }
    }
}

/// Compiles a schema, each type of which nothing is wanted only once: types that hold others twice,
/// one in the other, would double the plan with each.
struct Compiler<'s> {
    schema: &'s RosSchema,
    /// What passes over each type, and how many types are nested in it, itself included.
    passed: Vec<Option<(Rc<[Step]>, usize)>>,
}

impl Compiler<'_> {
    /// Appends the steps of a type and returns how many types are nested in it, itself included.
    fn compile_struct(
        &mut self,
        type_index: usize,
        wishes: &[Wish<'_>],
        depth: usize,
        steps: &mut Vec<Step>,
    ) -> Result<usize, String> {
        let known = self.passed[type_index].as_ref().filter(|_| wishes.is_empty());
        if depth + known.map_or(1, |(_, height)| *height) > self.schema.nesting {
            return Err(format!(
                "type {} is nested more than {} deep; if it should be, raise nesting in [limits] \
                 of dataset.toml",
                self.schema.type_name(type_index),
                self.schema.nesting
            ));
        }
        if let Some((body, height)) = known {
            append(steps, body);
            return Ok(*height);
        }
        if !wishes.is_empty() {
            return self.compile_fields(type_index, wishes, depth, steps);
        }
        let mut body = Vec::new();
        let height = self.compile_fields(type_index, wishes, depth, &mut body)?;
        let body: Rc<[Step]> = body.into();
        append(steps, &body);
        self.passed[type_index] = Some((body, height));
        Ok(height)
    }

    fn compile_fields(
        &mut self,
        type_index: usize,
        wishes: &[Wish<'_>],
        depth: usize,
        steps: &mut Vec<Step>,
    ) -> Result<usize, String> {
        let schema = self.schema;
        let fields = schema.fields(type_index);
        if fields.is_empty() && schema.cdr {
            push_skip(steps, 1, 1);
        }
        let mut height = 1;
        // Of several fields of one name the first is taken.
        let mut left = wishes.to_vec();
        for field in fields {
            let mut inner: Vec<Wish<'_>> = Vec::new();
            left.retain(|&(path, slot)| {
                let (name, is_list, rest) = split_path(path);
                let is_here = name == field.name && is_list == (field.count != Count::One);
                inner.extend(is_here.then_some((rest, slot)));
                !is_here
            });
            let below = match field.count {
                Count::One => self.compile_one(&field.kind, &inner, depth, steps)?,
                Count::Fixed(count) => {
                    self.compile_list(&field.kind, &inner, depth, Some(count), steps)?
                }
                Count::Sequence => self.compile_list(&field.kind, &inner, depth, None, steps)?,
            };
            height = height.max(1 + below);
        }
        Ok(height)
    }

    fn compile_one(
        &mut self,
        kind: &FieldKind,
        wishes: &[Wish<'_>],
        depth: usize,
        steps: &mut Vec<Step>,
    ) -> Result<usize, String> {
        match kind {
            FieldKind::Number(number) => match wishes {
                [] => push_skip(steps, alignment(self.schema, *number), number.size()),
                [(_, slot)] => push_number(steps, *number, *slot),
                _ => return Err("one field cannot serve as two quantities".into()),
            },
            FieldKind::Text => steps.push(Step::Text { slot: wishes.first().map(|wish| wish.1) }),
            FieldKind::WideText => steps.push(Step::WideText),
            FieldKind::Struct(inner) => {
                return self.compile_struct(*inner, wishes, depth + 1, steps);
            }
            FieldKind::Undefined(name) => {
                return Err(format!("the schema uses type {name} but does not define it"));
            }
        }
        Ok(0)
    }

    fn compile_list(
        &mut self,
        kind: &FieldKind,
        wishes: &[Wish<'_>],
        depth: usize,
        count: Option<usize>,
        steps: &mut Vec<Step>,
    ) -> Result<usize, String> {
        let mut body = Vec::new();
        let below = self.compile_one(kind, wishes, depth, &mut body)?;
        match (body.as_slice(), count) {
            // Elements without bytes leave only their count.
            ([], None) => push_skip(steps, if self.schema.cdr { 4 } else { 1 }, 4),
            ([], Some(_)) | (_, Some(0)) => {}
            (&[Step::Skip { align, size }], Some(count)) if size % align == 0 => {
                let total = size.checked_mul(count).ok_or("an array of the schema is too large")?;
                push_skip(steps, align, total);
            }
            (&[Step::Skip { align, size }], None) if size % align == 0 => {
                steps.push(Step::SkipList { align, size });
            }
            _ => steps.push(Step::Each { count, emits: !wishes.is_empty(), steps: body.into() }),
        }
        Ok(below)
    }
}

/// Appends the steps that pass over a type.
fn append(steps: &mut Vec<Step>, body: &Rc<[Step]>) {
    if body.len() > REPEATED {
        steps.push(Step::Pass(Rc::clone(body)));
        return;
    }
    for step in body.iter() {
        match step {
            Step::Skip { align, size } => push_skip(steps, *align, *size),
            other => steps.push(other.clone()),
        }
    }
}

fn alignment(schema: &RosSchema, number: NumberKind) -> usize {
    if schema.cdr { number.size() } else { 1 }
}

/// Appends a number, joined with those before it.
fn push_number(steps: &mut Vec<Step>, kind: NumberKind, slot: Slot) {
    match (kind, steps.last_mut()) {
        (NumberKind::F64, Some(Step::Numbers64(slots))) => slots.push(slot),
        (NumberKind::F64, _) => steps.push(Step::Numbers64(vec![slot])),
        _ => steps.push(Step::Number { kind, slot }),
    }
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
                Step::Numbers64(slots) => {
                    self.align(8);
                    let rest = self.bytes.get(self.at..).unwrap_or_default();
                    for (slot, number) in slots.iter().zip(rest.as_chunks::<8>().0) {
                        let bits = u64::from_le_bytes(*number);
                        let bits = if self.big_endian { bits.swap_bytes() } else { bits };
                        row.set_number(*slot, f64::from_bits(bits));
                    }
                    let n_there = (rest.len() / 8).min(slots.len());
                    self.at += 8 * n_there;
                    if n_there < slots.len() {
                        return Err(self.too_short());
                    }
                }
                Step::Text { slot } => {
                    let length = self.count()?;
                    let text = self.take(length)?;
                    if let Some(slot) = slot {
                        row.set_text(*slot, text.strip_suffix(b"\0").unwrap_or(text));
                    }
                }
                Step::Pass(steps) => self.run(steps, row, emit)?,
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
