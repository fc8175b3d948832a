//! How a valid input is damaged: bits, bytes, lengths, numbers, pieces and lines.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sha2::{Digest, Sha256};

/// An input may grow to this many bytes: what a reader does with large ones is not tested here.
const LARGEST: usize = 1 << 16;
/// Most changes of one input.
const MOST_CHANGES: u32 = 6;

/// Numbers at which counts, lengths and signs turn over.
const INTEGERS: [u64; 20] = [
    0,
    1,
    2,
    3,
    4,
    7,
    8,
    16,
    0x7f,
    0x80,
    0xff,
    0x100,
    0x7fff,
    0xffff,
    0x7fff_ffff,
    0x8000_0000,
    0xffff_ffff,
    0x7fff_ffff_ffff_ffff,
    0x8000_0000_0000_0000,
    u64::MAX,
];
/// Numbers in text that readers of numbers may stumble over.
const NUMBERS: [&str; 26] = [
    "0",
    "-0",
    "1",
    "-1",
    "2.5",
    "1e308",
    "-1e308",
    "1e309",
    "1e-308",
    "5e-324",
    "NaN",
    "inf",
    "-inf",
    "4294967295",
    "4294967296",
    "2147483648",
    "-2147483649",
    "18446744073709551616",
    "9007199254740993",
    "1e18",
    "1e-9",
    "0x10",
    "",
    "-",
    "1e",
    ".",
];

/// The input number `index` of a reader under a seed: one of the corpus, damaged.
pub(super) fn case(
    reader: &str,
    seed: u64,
    index: u64,
    corpus: &[Vec<u8>],
    tokens: &[&str],
) -> Vec<u8> {
    let mut random = stream(reader, seed, index);
    let mut input = corpus[random.random_range(0..corpus.len())].clone();
    // Few changes reach far into a reader, many find what one alone does not.
    let n_changes = 1 + random.random_range(0..MOST_CHANGES).min(random.random_range(0..8));
    for _ in 0..n_changes {
        change(&mut input, corpus, tokens, &mut random);
    }
    input.truncate(LARGEST);
    input
}

/// Random numbers of one case, the same on every machine.
fn stream(reader: &str, seed: u64, index: u64) -> ChaCha8Rng {
    let words = [reader.as_bytes(), &seed.to_le_bytes(), &index.to_le_bytes()].concat();
    ChaCha8Rng::from_seed(Sha256::digest(words).into())
}

fn change(input: &mut Vec<u8>, corpus: &[Vec<u8>], tokens: &[&str], random: &mut ChaCha8Rng) {
    if input.is_empty() {
        input.push(random.random());
        return;
    }
    let is_text = input.iter().take(256).all(|byte| byte.is_ascii());
    let kind = random.random_range(0..if is_text { 16 } else { 11 });
    match kind {
        0 => {
            let at = random.random_range(0..input.len());
            input[at] ^= 1 << random.random_range(0..8);
        }
        1 => {
            let at = random.random_range(0..input.len());
            input[at] = random.random();
        }
        2 => input.truncate(random.random_range(0..input.len())),
        3 => {
            let piece = piece(input, random);
            input.drain(piece);
        }
        4 => {
            let piece = piece(input, random);
            let copy = input[piece.clone()].to_vec();
            input.splice(piece.end..piece.end, copy);
        }
        5 => overwrite(input, random),
        6 => splice(input, corpus, random),
        7 | 8 => integer(input, random),
        9 => varint(input, random),
        10 => token(input, tokens, random),
        11 | 12 => number(input, random),
        13 => token(input, tokens, random),
        _ => lines(input, random),
    }
}

/// A piece of an input, short more often than long.
fn piece(input: &[u8], random: &mut ChaCha8Rng) -> std::ops::Range<usize> {
    let start = random.random_range(0..input.len());
    let longest = 1 << random.random_range(0..12);
    start..input.len().min(start + random.random_range(1..=longest))
}

/// Copies a piece over another place.
fn overwrite(input: &mut [u8], random: &mut ChaCha8Rng) {
    let piece = piece(input, random);
    let to = random.random_range(0..=input.len() - piece.len());
    input.copy_within(piece, to);
}

/// The beginning of one input with the end of another.
fn splice(input: &mut Vec<u8>, corpus: &[Vec<u8>], random: &mut ChaCha8Rng) {
    let other = &corpus[random.random_range(0..corpus.len())];
    input.truncate(random.random_range(0..=input.len()));
    // Formats with places in them go on better where they left off.
    let from = if random.random_bool(0.5) {
        input.len().min(other.len())
    } else {
        random.random_range(0..=other.len())
    };
    input.extend_from_slice(&other[from..]);
}

/// Writes an integer of 1, 2, 4 or 8 bytes: a special one, or what was there a little changed.
fn integer(input: &mut [u8], random: &mut ChaCha8Rng) {
    let width = (1_usize << random.random_range(0..4)).min(input.len());
    let at = random.random_range(0..=input.len() - width);
    let field = &mut input[at..at + width];
    let mut bytes = [0; 8];
    bytes[..width].copy_from_slice(field);
    let value = match random.random_range(0..4) {
        0 => u64::from_le_bytes(bytes).wrapping_add(random.random_range(1..=16)),
        1 => u64::from_le_bytes(bytes).wrapping_sub(random.random_range(1..=16)),
        _ => INTEGERS[random.random_range(0..INTEGERS.len())],
    };
    field.copy_from_slice(&value.to_le_bytes()[..width]);
    if random.random_bool(0.1) {
        field.reverse();
    }
}

/// Writes an integer of seven bits a byte, as Thrift and Protobuf have them.
fn varint(input: &mut Vec<u8>, random: &mut ChaCha8Rng) {
    let mut value = INTEGERS[random.random_range(0..INTEGERS.len())];
    let mut bytes = Vec::new();
    while value >= 0x80 {
        bytes.push(value as u8 | 0x80);
        value >>= 7;
    }
    bytes.push(value as u8);
    let at = random.random_range(0..input.len());
    let end = if random.random_bool(0.5) { at + 1 } else { input.len().min(at + bytes.len()) };
    input.splice(at..end, bytes);
}

fn token(input: &mut Vec<u8>, tokens: &[&str], random: &mut ChaCha8Rng) {
    if tokens.is_empty() {
        return overwrite(input, random);
    }
    let word = tokens[random.random_range(0..tokens.len())].as_bytes();
    let at = random.random_range(0..=input.len());
    let end = if random.random_bool(0.5) { at } else { input.len().min(at + word.len()) };
    input.splice(at..end, word.iter().copied());
}

/// Replaces a number in text.
fn number(input: &mut Vec<u8>, random: &mut ChaCha8Rng) {
    let is_part = |byte: &u8| byte.is_ascii_digit() || b".+-eE".contains(byte);
    let from = random.random_range(0..input.len());
    let Some(digit) = input[from..].iter().position(u8::is_ascii_digit) else { return };
    let at = from + digit;
    let start = input[..at].iter().rposition(|byte| !is_part(byte)).map_or(0, |before| before + 1);
    let end = input[at..].iter().position(|byte| !is_part(byte)).map_or(input.len(), |n| at + n);
    let word = NUMBERS[random.random_range(0..NUMBERS.len())];
    input.splice(start..end, word.bytes());
}

/// Doubles, removes or swaps lines.
fn lines(input: &mut Vec<u8>, random: &mut ChaCha8Rng) {
    let mut lines: Vec<&[u8]> = input.split_inclusive(|byte| *byte == b'\n').collect();
    let at = random.random_range(0..lines.len());
    let other = random.random_range(0..lines.len());
    match random.random_range(0..3) {
        0 => lines.insert(other, lines[at]),
        1 => drop(lines.remove(at)),
        _ => lines.swap(at, other),
    }
    *input = lines.concat();
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::{LARGEST, case};

    #[test]
    fn a_case_is_a_function_of_reader_seed_and_number() {
        let corpus = [b"a,b\n1,2\n3,4\n".to_vec(), vec![0, 159, 146, 150, 4, 0, 0, 0]];
        let of = |reader, seed, index| case(reader, seed, index, &corpus, &["a"]);
        assert_eq!(of("csv", 7, 12), of("csv", 7, 12));
        let distinct = |cases: Vec<Vec<u8>>| cases.into_iter().collect::<BTreeSet<_>>().len();
        assert!(distinct((0..2000).map(|index| of("csv", 7, index)).collect()) > 1500);
        assert!((0..20).any(|index| of("csv", 7, index) != of("csv", 8, index)));
        assert!((0..20).any(|index| of("csv", 7, index) != of("bag", 7, index)));
    }

    #[test]
    fn inputs_stay_small_and_an_empty_one_is_allowed() {
        let corpus = [vec![7; 60_000], Vec::new()];
        let cases = (0..2000).map(|index| case("bag", 1, index, &corpus, &[]));
        let lengths: Vec<_> = cases.map(|input| input.len()).collect();
        assert!(lengths.iter().all(|length| *length <= LARGEST));
        assert!(lengths.iter().any(|length| *length > 60_000));
    }
}
