//! A part of a set's recordings, for work that several processes or machines share.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::error::DatasetError;

/// One of so many parts of a set: recordings that follow each other by name, as many as in the others or one
/// more. Written `3/8`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub struct Part {
    of: usize,
    number: usize,
}

impl Part {
    /// The `number`-th part, from 1, `of` so many.
    ///
    /// # Errors
    /// `Parts` unless 1 ≤ `number` ≤ `of`.
    pub fn new(number: usize, of: usize) -> Result<Self, DatasetError> {
        match (1..=of).contains(&number) {
            true => Ok(Self { of, number }),
            false => Err(not_a_part(&format!("{number}/{of}"))),
        }
    }

    /// Which part it is, from 1.
    #[must_use]
    pub fn number(self) -> usize {
        self.number
    }

    /// How many parts there are.
    #[must_use]
    pub fn of(self) -> usize {
        self.of
    }

    /// Which of `n` recordings it has.
    #[must_use]
    pub fn range(self, n: usize) -> Range<usize> {
        let until = |parts: usize| (parts as u128 * n as u128 / self.of as u128) as usize;
        until(self.number - 1)..until(self.number)
    }
}

impl fmt::Display for Part {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

impl FromStr for Part {
    type Err = DatasetError;

    fn from_str(text: &str) -> Result<Self, DatasetError> {
        let numbers = text.split_once('/');
        let numbers =
            numbers.and_then(|(i, n)| Some((i.trim().parse().ok()?, n.trim().parse().ok()?)));
        numbers.map_or_else(|| Err(not_a_part(text)), |(number, of)| Self::new(number, of))
    }
}

impl TryFrom<String> for Part {
    type Error = DatasetError;

    fn try_from(text: String) -> Result<Self, DatasetError> {
        text.parse()
    }
}

impl From<Part> for String {
    fn from(part: Part) -> Self {
        part.to_string()
    }
}

fn not_a_part(text: &str) -> DatasetError {
    DatasetError::Parts {
        what: format!("`{text}` is no part: write 1/8 for the first of eight, up to 8/8"),
    }
}

#[cfg(test)]
mod tests {
    use super::Part;
    use proptest::prelude::{prop_assert, prop_assert_eq, proptest};

    proptest! {
        #[test]
        fn parts_hold_every_recording_once_and_about_as_many(n in 0_usize..500, of in 1_usize..40) {
            let parts: Vec<_> = (1..=of).map(|i| Part::new(i, of).unwrap().range(n)).collect();
            let all: Vec<usize> = parts.iter().cloned().flatten().collect();
            prop_assert_eq!(all, (0..n).collect::<Vec<_>>());
            let sizes = || parts.iter().map(ExactSizeIterator::len);
            prop_assert!(sizes().max() <= sizes().min().map(|least| least + 1));
        }
    }

    #[test]
    fn a_part_is_written_as_it_is_read_and_others_are_refused() {
        assert_eq!("3/8".parse::<Part>().unwrap().to_string(), "3/8");
        assert_eq!(serde_json::from_str::<Part>("\"1/1\"").unwrap(), Part::new(1, 1).unwrap());
        for text in ["0/8", "9/8", "3", "3/", "/8", "-1/8", "1/0", "a/b", "1/2/3"] {
            let error = text.parse::<Part>().unwrap_err().to_string();
            assert!(error.starts_with(&format!("`{text}` is no part")), "{error}");
        }
    }
}
