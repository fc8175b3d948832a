//! A reader with every kind of failure, to see that each is found.

use std::path::Path;

use anyhow::Result;

use super::super::reader::{Reader, Verdict};

/// Fails in the way that the first letter of `PAMLW` in its input says.
pub(super) struct SelfTest;

impl Reader for SelfTest {
    fn name(&self) -> &'static str {
        "self-test"
    }

    fn corpus(&self, _: &Path) -> Result<Vec<Vec<u8>>> {
        Ok(vec![b"nothing here fails".to_vec(), vec![0, 1, 2, 200, 201, 202]])
    }

    fn tokens(&self) -> &'static [&'static str] {
        &["P", "A", "M", "L", "W", "O"]
    }

    fn read(&self, _: &Path, input: &[u8]) -> Verdict {
        let Some(fault) = input.iter().find(|byte| b"PAMLWO".contains(byte)) else {
            return if input.is_ascii() { Verdict::Accepted } else { Verdict::Refused };
        };
        match fault {
            b'P' => panic!("as asked"),
            b'A' => std::process::abort(),
            // Kept in sight, so that it is not left out as useless.
            b'M' => drop(std::hint::black_box(vec![1_u8; 4 << 30])),
            b'O' => drop(std::hint::black_box(input.len() as u32 - u32::MAX)),
            b'L' => loop {
                std::thread::park();
            },
            _ => return Verdict::Wrong("number is NaN at 0".to_owned()),
        }
        Verdict::Accepted
    }
}
