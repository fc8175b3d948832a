//! Known bytes, laws and damage of the ROS decoder.

use proptest::prelude::{any, prop, prop_assert, prop_assert_eq, proptest};

use super::{RosPlan, Step};
use crate::formats::decode::{MessageError, Row, Slot, Wanted, ros_schema::RosSchema};

const SCHEMA: &str = "bool flag\nstring name\nfloat64 x\nEmpty nothing\nuint8[] raw\n\
    Item[] items\nint16 last\n===\nMSG: p/Empty\n===\nMSG: p/Item\nstring child\nfloat32 y\n";

fn wanted(fields: &[(Slot, &str)]) -> Vec<Wanted> {
    fields.iter().map(|&(slot, path)| Wanted { slot, path: path.into() }).collect()
}

fn plan(cdr: bool, fields: &[(Slot, &str)]) -> RosPlan {
    let schema = RosSchema::parse("p/Message", SCHEMA.as_bytes(), cdr, 32).unwrap();
    RosPlan::compile(&schema, &wanted(fields)).unwrap()
}

fn rows(plan: &RosPlan, message: &[u8]) -> Result<Vec<(f64, f64, Vec<u8>)>, MessageError> {
    let mut rows = Vec::new();
    plan.decode(message, &mut |row: &Row<'_>| {
        rows.push((row.values[0], row.values[1], row.child.to_vec()));
    })?;
    Ok(rows)
}

const FLAT: &[(Slot, &str)] = &[(Slot::Value(0), "x"), (Slot::Value(1), "last")];
const LISTED: &[(Slot, &str)] =
    &[(Slot::Value(0), "x"), (Slot::Value(1), "items[].y"), (Slot::Child, "items[].child")];

/// The same message by hand: flag, "ab", x = 1.5, nothing, raw of 3, two items, last = -2.
fn ros1_message() -> Vec<u8> {
    let mut m = vec![1, 2, 0, 0, 0, b'a', b'b'];
    m.extend(1.5_f64.to_le_bytes());
    m.extend([3, 0, 0, 0, 7, 8, 9, 2, 0, 0, 0]);
    m.extend([1, 0, 0, 0, b'u']);
    m.extend(0.25_f32.to_le_bytes());
    m.extend([2, 0, 0, 0, b'v', b'w']);
    m.extend((-4.0_f32).to_le_bytes());
    m.extend((-2_i16).to_le_bytes());
    m
}

/// The same in CDR: numbers aligned, strings with a final zero, a byte for the empty struct.
fn cdr_message(big_endian: bool) -> Vec<u8> {
    let mut m = Vec::new();
    let pad = |m: &mut Vec<u8>, align: usize| m.resize(m.len().next_multiple_of(align), 0);
    let number = |m: &mut Vec<u8>, little: &[u8]| {
        pad(m, little.len());
        if big_endian {
            m.extend(little.iter().rev());
        } else {
            m.extend(little);
        }
    };
    m.push(1);
    number(&mut m, &3_u32.to_le_bytes());
    m.extend(b"ab\0");
    number(&mut m, &1.5_f64.to_le_bytes());
    m.push(0);
    number(&mut m, &3_u32.to_le_bytes());
    m.extend([7, 8, 9]);
    number(&mut m, &2_u32.to_le_bytes());
    for (child, y) in [(&b"u\0"[..], 0.25_f32), (b"vw\0", -4.0)] {
        number(&mut m, &(child.len() as u32).to_le_bytes());
        m.extend(child);
        number(&mut m, &y.to_le_bytes());
    }
    number(&mut m, &(-2_i16).to_le_bytes());
    let mut message = vec![0, u8::from(!big_endian), 0, 0];
    message.append(&mut m);
    message
}

#[test]
fn ros1_and_cdr_of_both_byte_orders_decode_alike() {
    for (cdr, message) in
        [(false, ros1_message()), (true, cdr_message(false)), (true, cdr_message(true))]
    {
        let flat = rows(&plan(cdr, FLAT), &message).unwrap();
        assert_eq!(flat, [(1.5, -2.0, vec![])]);
        let listed = rows(&plan(cdr, LISTED), &message).unwrap();
        assert_eq!(listed, [(1.5, 0.25, b"u".to_vec()), (1.5, -4.0, b"vw".to_vec())]);
    }
}

#[test]
fn every_number_kind_is_read_with_its_sign() {
    let text = "int8 a\nuint8 b\nint16 c\nuint16 d\nint32 e\nuint32 f\nint64 g\nuint64 h\n";
    let schema = RosSchema::parse("p/N", text.as_bytes(), false, 32).unwrap();
    let names = ["a", "b", "c", "d", "e", "f", "g", "h"];
    let fields: Vec<_> = names.iter().enumerate().map(|(i, n)| (Slot::Value(i), *n)).collect();
    let plan = RosPlan::compile(&schema, &wanted(&fields)).unwrap();
    let mut values = [0.0; 8];
    plan.decode(&[0xff; 30], &mut |row| values = row.values).unwrap();
    let expected = [-1.0, 255.0, -1.0, 65535.0, -1.0, 4294967295.0, -1.0, u64::MAX as f64];
    assert_eq!(values, expected);
}

#[test]
fn fixed_arrays_of_any_kind_are_passed_over() {
    let text = "wstring w\nstring[2] s\nfloat64[36] covariance\nItem[2] items\nint64[] list\n\
                float64 x\n===\nMSG: p/Item\nuint8 a\nfloat64 b\n";
    let schema = RosSchema::parse("p/M", text.as_bytes(), true, 32).unwrap();
    let plan = RosPlan::compile(&schema, &wanted(&[(Slot::Value(0), "x")])).unwrap();
    let mut m = vec![2, 0, 0, 0, 1, 0, 1, 0, 1, 0, 0, 0, 0, 0, 0, 0, 2, 0, 0, 0, b'a', 0];
    m.resize(24, 0);
    m.resize(24 + 36 * 8 + 2 * 16, 0);
    m.extend([0, 0, 0, 0, 0, 0, 0, 0]);
    m.extend(2.5_f64.to_le_bytes());
    let message: Vec<u8> = [0, 1, 0, 0].into_iter().chain(m).collect();
    assert_eq!(rows(&plan, &message).unwrap(), [(2.5, 0.0, vec![])]);
}

#[test]
fn nothing_behind_the_last_wanted_field_is_walked() {
    let plan = plan(false, &[(Slot::Value(0), "x")]);
    assert_eq!(plan.steps.len(), 3);
    assert_eq!(plan.steps[0], Step::Skip { align: 1, size: 1 });
}

#[test]
fn damaged_lengths_are_errors_with_their_byte() {
    let mut message = cdr_message(false);
    message[8..12].copy_from_slice(&u32::MAX.to_le_bytes());
    let error = rows(&plan(true, FLAT), &message).unwrap_err();
    assert_eq!(error.to_string(), "a length beyond the message's end at byte 12 of the message");
    let error = rows(&plan(true, FLAT), &[0, 9, 0, 0, 1]).unwrap_err();
    assert_eq!(error.what, "an encapsulation other than plain CDR");
    assert_eq!(rows(&plan(true, FLAT), &[0, 1]).unwrap_err().what, "no CDR header");
}

#[test]
fn a_type_that_is_missing_or_endless_is_an_error() {
    let compile = |text: &str| {
        let schema = RosSchema::parse("p/M", text.as_bytes(), true, 32).unwrap();
        RosPlan::compile(&schema, &wanted(&[(Slot::Value(0), "x")])).err().unwrap()
    };
    assert_eq!(
        compile("other/Thing thing\nfloat64 x\n"),
        "the schema uses type other/Thing but does not define it"
    );
    assert!(compile("M again\nfloat64 x\n").contains("nested more than 32 deep"));
}

proptest! {
    #[test]
    fn random_bytes_never_panic(message in prop::collection::vec(any::<u8>(), 0..200), cdr: bool) {
        for fields in [FLAT, LISTED] {
            if let Ok(rows) = rows(&plan(cdr, fields), &message) {
                prop_assert!(rows.len() <= message.len());
            }
        }
    }

    #[test]
    fn a_cut_message_is_an_error(cut in 1_usize..20, big_endian: bool) {
        let whole = cdr_message(big_endian);
        let cut_off = &whole[..whole.len() - cut];
        prop_assert!(rows(&plan(true, FLAT), cut_off).is_err());
        prop_assert_eq!(rows(&plan(true, FLAT), &whole).unwrap().len(), 1);
    }

    #[test]
    fn random_schemas_never_panic(text in "[a-z0-9_/\\[\\]<=# \n]{0,120}", cdr: bool) {
        if let Ok(schema) = RosSchema::parse("p/M", text.as_bytes(), cdr, 32) {
            let _ = RosPlan::compile(&schema, &wanted(&[(Slot::Value(0), "x")]));
        }
    }
}

/// A schema of `n` types that hold the next one twice, the last of them two numbers.
fn doubled(n: usize, cdr: bool) -> RosSchema {
    let mut text = String::new();
    for i in 0..n - 1 {
        let next = i + 1;
        text += &format!("T{next} a\nT{next} b\n===\nMSG: p/T{next}\n");
    }
    text += "uint8 a\nstring b\n";
    RosSchema::parse("p/T0", text.as_bytes(), cdr, 32).unwrap()
}

/// Compiled one by one, 31 types would give 2³¹ steps.
#[test]
fn types_that_hold_others_twice_are_compiled_once() {
    let path = format!("{}b.a", "b.".repeat(29));
    let plan = RosPlan::compile(&doubled(31, false), &wanted(&[(Slot::Value(0), &path)])).unwrap();
    assert!(plan.steps.len() <= 32 * super::REPEATED, "{}", plan.steps.len());
    for cdr in [false, true] {
        let wanted = wanted(&[(Slot::Value(0), "b.b.b.a")]);
        let plan = RosPlan::compile(&doubled(4, cdr), &wanted).unwrap();
        // Eight leaves, a number and a text each; the wanted number is the last one.
        let mut message = if cdr { vec![0, 1, 0, 0] } else { Vec::new() };
        let header = message.len();
        let mut last = 0;
        for leaf in 0..8 {
            last = message.len();
            message.push(leaf);
            if cdr {
                message.resize(header + (message.len() - header).next_multiple_of(4), 0);
            }
            let length = leaf as u32 + 1;
            message.extend(length.to_le_bytes());
            message.extend(vec![0; length as usize]);
        }
        assert_eq!(rows(&plan, &message).unwrap(), [(7.0, 0.0, vec![])]);
        assert!(rows(&plan, &message[..last]).is_err());
    }
}

#[test]
fn fields_of_one_name_are_not_followed_more_than_once() {
    let text = "T a\nT a\n===\nMSG: p/T\nfloat64 x\nfloat64 x\n";
    let schema = RosSchema::parse("p/M", text.as_bytes(), false, 32).unwrap();
    let plan = RosPlan::compile(&schema, &wanted(&[(Slot::Value(0), "a.x")])).unwrap();
    assert_eq!(plan.steps.len(), 1);
}

#[test]
fn nesting_beyond_the_limit_is_refused_with_its_setting() {
    let chain = |n: usize, nesting: usize| {
        let types = (1..n).map(|i| format!("T{i} next\n===\nMSG: p/T{i}\n")).collect::<String>();
        let text = format!("uint8 x\n{types}uint8 end\n");
        let schema = RosSchema::parse("p/T0", text.as_bytes(), false, nesting).unwrap();
        RosPlan::compile(&schema, &wanted(&[(Slot::Value(0), "x")])).map(|_| ())
    };
    assert_eq!(chain(5, 5), Ok(()));
    let message = chain(6, 5).unwrap_err();
    assert_eq!(
        message,
        "type p/T5 is nested more than 5 deep; if it should be, raise nesting in [limits] of \
         dataset.toml"
    );
    assert!(chain(100_000, 256).is_err());
}
