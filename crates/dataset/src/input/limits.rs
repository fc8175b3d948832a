//! What reading one file may cost: one set of limits, and one error, for every reader.

use std::{fmt, path::Path};

use serde::{
    Deserialize, Deserializer,
    de::{DeserializeSeed, Error as _, MapAccess, Unexpected, Visitor},
};

use crate::error::DatasetError;

/// A quantity that a damaged or hostile file can drive beyond all bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Limit {
    /// Bytes of one file.
    FileBytes,
    /// Bytes that compressed parts of a recording unpack to, over one pass through it.
    UnpackedBytes,
    /// Bytes that one compressed part unpacks to, which are in memory at once.
    ChunkBytes,
    /// Samples of one stream: messages, list elements or rows.
    Samples,
    /// Topics, connections, data sets or frames of one recording.
    Channels,
    /// Bytes of the message definitions of all channels together.
    SchemaBytes,
    /// Fields and types that the message definitions of all channels declare.
    SchemaFields,
    /// Types nested in one another.
    Nesting,
    /// Columns of one table.
    Columns,
    /// Pushes of one recording.
    Pushes,
    /// Steps of one recording.
    Steps,
}

/// Key in `[limits]`, default, and largest value of each limit, in the order of [`Limit`].
const LIMITS: [(Limit, &str, u64, u64); 11] = [
    (Limit::FileBytes, "file_bytes", 1 << 38, MOST),
    (Limit::UnpackedBytes, "unpacked_bytes", 1 << 35, MOST),
    (Limit::ChunkBytes, "chunk_bytes", 1 << 30, MOST),
    (Limit::Samples, "samples", 50_000_000, MOST),
    (Limit::Channels, "channels", 10_000, MOST),
    (Limit::SchemaBytes, "schema_bytes", 1 << 26, MOST),
    (Limit::SchemaFields, "schema_fields", 1_000_000, MOST),
    // The walk through nested types is recursive.
    (Limit::Nesting, "nesting", 32, 256),
    (Limit::Columns, "columns", 10_000, MOST),
    // Steps and pushes are numbered in 32 bits.
    (Limit::Pushes, "pushes", 10_000, u32::MAX as u64),
    (Limit::Steps, "steps", 1_000_000, u32::MAX as u64),
];
/// The largest integer of TOML.
const MOST: u64 = i64::MAX as u64;

impl Limit {
    /// Every limit.
    pub const ALL: [Self; LIMITS.len()] = {
        let mut all = [Self::FileBytes; LIMITS.len()];
        let mut i = 0;
        while i < all.len() {
            all[i] = LIMITS[i].0;
            i += 1;
        }
        all
    };

    /// The key in the table `[limits]` of `dataset.toml`.
    #[must_use]
    pub fn key(self) -> &'static str {
        LIMITS[self as usize].1
    }
}

/// The most that reading one file may cost, whatever the file says of itself.
///
/// The defaults are far above any recording of pushes. A reader asks [`ReadLimits::check`] before
/// it reserves memory or goes on, so that a file that needs more is refused by name and not by the
/// operating system. A log format of a user's own may do the same.
///
/// ```
/// use dataset::{Limit, ReadLimits};
///
/// let limits = ReadLimits::default().with(Limit::Samples, 1000);
/// limits.check("tip.csv".as_ref(), Limit::Samples, || "rows".into(), 1000)?;
/// let error = limits.check("tip.csv".as_ref(), Limit::Samples, || "rows".into(), 1001);
/// assert!(error.unwrap_err().to_string().contains("[limits]"));
/// # Ok::<(), dataset::DatasetError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReadLimits {
    values: [u64; LIMITS.len()],
}

impl Default for ReadLimits {
    fn default() -> Self {
        Self { values: LIMITS.map(|(_, _, default, _)| default) }
    }
}

impl ReadLimits {
    /// The value of one limit.
    #[must_use]
    pub fn of(&self, limit: Limit) -> u64 {
        self.values[limit as usize]
    }

    /// The same limits with another value of one of them, kept within 1 and the largest allowed.
    #[must_use]
    pub fn with(mut self, limit: Limit, value: u64) -> Self {
        self.values[limit as usize] = value.clamp(1, LIMITS[limit as usize].3);
        self
    }

    /// Refuses what needs more than a limit.
    ///
    /// - `what`: what there is too much of, in the plural, e.g. `rows of robot.csv`.
    /// - `needed`: how much of it there is, as far as it is known.
    ///
    /// # Errors
    /// `OverLimit` with path, both numbers, and the key that raises the limit.
    pub fn check(
        &self,
        path: &Path,
        limit: Limit,
        what: impl FnOnce() -> String,
        needed: u64,
    ) -> Result<(), DatasetError> {
        if needed <= self.of(limit) {
            return Ok(());
        }
        Err(DatasetError::OverLimit {
            path: path.into(),
            what: what(),
            needed,
            limit: self.of(limit),
            remedy: format!(
                "if the file is sound, raise {} in [limits] of dataset.toml",
                limit.key()
            ),
        })
    }
}

impl<'de> Deserialize<'de> for ReadLimits {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_map(TableVisitor)
    }
}

struct TableVisitor;

impl<'de> Visitor<'de> for TableVisitor {
    type Value = ReadLimits;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a table of limits")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<ReadLimits, A::Error> {
        const KEYS: [&str; LIMITS.len()] = {
            let mut keys = [""; LIMITS.len()];
            let mut i = 0;
            while i < keys.len() {
                keys[i] = LIMITS[i].1;
                i += 1;
            }
            keys
        };
        let mut limits = ReadLimits::default();
        while let Some(limit) = map.next_key_seed(KeySeed(&KEYS))? {
            limits.values[limit as usize] = map.next_value_seed(ValueSeed(limit))?;
        }
        Ok(limits)
    }
}

/// Reads a key as the limit of that name.
struct KeySeed(&'static [&'static str]);

impl<'de> DeserializeSeed<'de> for KeySeed {
    type Value = Limit;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Limit, D::Error> {
        let key = String::deserialize(deserializer)?;
        let known = Limit::ALL.into_iter().find(|limit| limit.key() == key);
        known.ok_or_else(|| D::Error::unknown_field(&key, self.0))
    }
}

/// Reads a whole number from 1 to the largest that a limit may have.
struct ValueSeed(Limit);

impl<'de> DeserializeSeed<'de> for ValueSeed {
    type Value = u64;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<u64, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl Visitor<'_> for ValueSeed {
    type Value = u64;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (_, key, _, most) = LIMITS[self.0 as usize];
        write!(f, "limits.{key} as a whole number from 1 to {most}")
    }

    fn visit_i64<E: serde::de::Error>(self, value: i64) -> Result<u64, E> {
        let most = LIMITS[self.0 as usize].3;
        let found = u64::try_from(value).ok().filter(|value| (1..=most).contains(value));
        found.ok_or_else(|| E::invalid_value(Unexpected::Signed(value), &self))
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::{LIMITS, Limit, ReadLimits};
    use crate::error::DatasetError;

    fn error(text: &str) -> String {
        toml::from_str::<ReadLimits>(text).unwrap_err().message().to_owned()
    }

    #[test]
    fn each_limit_stands_at_its_own_place_and_is_read_by_its_key() {
        for (i, (limit, key, default, _)) in LIMITS.into_iter().enumerate() {
            assert_eq!((limit as usize, Limit::ALL[i], limit.key()), (i, limit, key));
            assert_eq!(ReadLimits::default().of(limit), default);
            let read: ReadLimits = toml::from_str(&format!("{key} = 7")).unwrap();
            assert_eq!(read, ReadLimits::default().with(limit, 7));
        }
    }

    #[test]
    fn a_limit_that_is_not_positive_or_not_known_is_refused() {
        for value in ["0", "-4"] {
            let expected = format!(
                "invalid value: integer `{value}`, expected limits.samples as a whole number \
                 from 1 to 9223372036854775807"
            );
            assert_eq!(error(&format!("samples = {value}")), expected);
        }
        assert!(error("samples = 1.5").contains("floating point `1.5`, expected limits.samples"));
        assert!(error("nesting = 257").contains("whole number from 1 to 256"));
        let message = error("sampels = 3");
        assert!(message.starts_with("unknown field `sampels`, expected one of `file_bytes`"));
    }

    #[test]
    fn what_needs_more_is_refused_with_both_numbers_and_the_key() {
        let limits = ReadLimits::default().with(Limit::Steps, 10);
        let check =
            |needed| limits.check(Path::new("a.csv"), Limit::Steps, || "steps".into(), needed);
        check(10).unwrap();
        let error = check(11).unwrap_err();
        assert!(matches!(error, DatasetError::OverLimit { needed: 11, limit: 10, .. }));
        assert_eq!(
            error.to_string(),
            "a.csv: at least 11 steps, more than the 10 allowed; if the file is sound, raise \
             steps in [limits] of dataset.toml"
        );
    }
}
