//! The MIT push data set as JSON: one file a push, three lists of rows.

use std::{collections::BTreeMap, fmt, path::Path};

use serde::{
    Deserializer,
    de::{DeserializeSeed, MapAccess, SeqAccess, Visitor},
};

use super::mit_rows::{Rows, inspect_rows, recording_of_rows};
use crate::error::DatasetError;
use crate::formats::format::{Inspection, LogFormat};
use crate::input::caught::caught;
use crate::input::limits::{Limit, ReadLimits};
use crate::input::map::FileBytes;
use crate::recording::Recording;
use crate::recording::settings::Streams;

/// The MIT JSON format.
pub(crate) struct MitJsonFormat;

impl LogFormat for MitJsonFormat {
    fn id(&self) -> &'static str {
        "mit-json"
    }

    fn endings(&self) -> &'static [&'static str] {
        &["json"]
    }

    fn read(
        &self,
        path: &Path,
        streams: &Streams,
        limits: &ReadLimits,
    ) -> Result<Recording, DatasetError> {
        caught(path, || {
            let file = FileBytes::open(path, limits)?;
            let mut sets = parse(path, file.bytes(), limits)?;
            let names: Vec<String> = sets.keys().cloned().collect();
            let mut take = |name: &str| Ok(sets.remove(name));
            recording_of_rows(path, file.sha256(), &names, streams, &mut take)
        })
    }

    fn inspect(&self, path: &Path, limits: &ReadLimits) -> Result<Inspection, DatasetError> {
        caught(path, || {
            let file = FileBytes::open(path, limits)?;
            let sets = parse(path, file.bytes(), limits)?;
            Ok(inspect_rows(sets.iter().map(|(name, rows)| (name.as_str(), rows.as_slice()))))
        })
    }
}

fn parse(
    path: &Path,
    bytes: &[u8],
    limits: &ReadLimits,
) -> Result<BTreeMap<String, Rows>, DatasetError> {
    let mut refused = None;
    let mut budget = Budget { path, limits, refused: &mut refused };
    let mut json = serde_json::Deserializer::from_slice(bytes);
    let parsed = SetsSeed(&mut budget).deserialize(&mut json);
    let parsed = parsed.and_then(|sets| json.end().map(|()| sets));
    parsed.map_err(|error| {
        refused.unwrap_or_else(|| DatasetError::Parse {
            path: path.into(),
            line: (error.line() as u64).max(1),
            what: format!(
                "{error}; expected lists of rows of four numbers under tip_pose, object_pose and \
                 ft_wrench"
            ),
        })
    })
}

/// Refuses, while a file is read, what is more than the limits allow.
struct Budget<'b> {
    path: &'b Path,
    limits: &'b ReadLimits,
    refused: &'b mut Option<DatasetError>,
}

impl Budget<'_> {
    fn check<E: serde::de::Error>(&mut self, limit: Limit, n: usize) -> Result<(), E> {
        let what = if limit == Limit::Channels { "data sets" } else { "rows of a data set" };
        let checked = self.limits.check(self.path, limit, || what.to_owned(), n as u64);
        checked.map_err(|error| E::custom(self.refused.insert(error)))
    }
}

/// Reads the object of data sets.
struct SetsSeed<'s, 'b>(&'s mut Budget<'b>);

impl<'de> DeserializeSeed<'de> for SetsSeed<'_, '_> {
    type Value = BTreeMap<String, Rows>;

    fn deserialize<D: Deserializer<'de>>(self, json: D) -> Result<Self::Value, D::Error> {
        json.deserialize_map(self)
    }
}

impl<'de> Visitor<'de> for SetsSeed<'_, '_> {
    type Value = BTreeMap<String, Rows>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an object of data sets")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
        let mut sets = BTreeMap::new();
        while let Some(name) = map.next_key::<String>()? {
            let rows = map.next_value_seed(RowsSeed(self.0))?;
            sets.insert(name, rows);
            self.0.check(Limit::Channels, sets.len())?;
        }
        Ok(sets)
    }
}

/// Reads the list of rows of one data set.
struct RowsSeed<'s, 'b>(&'s mut Budget<'b>);

impl<'de> DeserializeSeed<'de> for RowsSeed<'_, '_> {
    type Value = Rows;

    fn deserialize<D: Deserializer<'de>>(self, json: D) -> Result<Rows, D::Error> {
        json.deserialize_seq(self)
    }
}

impl<'de> Visitor<'de> for RowsSeed<'_, '_> {
    type Value = Rows;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a list of rows")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Rows, A::Error> {
        let mut rows = Rows::new();
        while let Some(row) = list.next_element()? {
            rows.push(row);
            self.0.check(Limit::Samples, rows.len())?;
        }
        Ok(rows)
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::MitJsonFormat;
    use crate::formats::format::LogFormat;
    use crate::input::limits::{Limit, ReadLimits};
    use crate::recording::Recording;
    use crate::recording::settings::Streams;
    use crate::{error::DatasetError, remark::StreamRole};

    fn read(text: &str) -> Result<Recording, DatasetError> {
        read_within(text, &ReadLimits::default())
    }

    fn read_within(text: &str, limits: &ReadLimits) -> Result<Recording, DatasetError> {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("push.json");
        fs::write(&path, text).unwrap();
        MitJsonFormat.read(&path, &Streams::default(), limits)
    }

    #[test]
    fn more_rows_or_data_sets_than_allowed_are_refused() {
        let text = r#"{"tip_pose": [[5,0,0,0], [6,1,2,3]], "object_pose": [[6,0,0,9]]}"#;
        let limits = ReadLimits::default().with(Limit::Samples, 2).with(Limit::Channels, 2);
        read_within(text, &limits).unwrap();
        for (limit, what) in
            [(Limit::Samples, "rows of a data set"), (Limit::Channels, "data sets")]
        {
            let error = read_within(text, &limits.clone().with(limit, 1)).unwrap_err();
            assert!(matches!(error, DatasetError::OverLimit { needed: 2, limit: 1, .. }));
            assert!(
                error.to_string().contains(&format!("push.json: at least 2 {what}")),
                "{error}"
            );
        }
    }

    #[test]
    fn rows_become_streams_as_they_are() {
        let recording = read(
            r#"{"tip_pose": [[5.5, 0.1, 0.2, 0.3], [5.25, 1, 2, 3]],
                "object_pose": [[6.0, 0.4, 0.5, 9.0]], "ft_wrench": [[5.125, 1, 2, 3]]}"#,
        )
        .unwrap();
        assert_eq!(recording.name, "push");
        assert_eq!(recording.epoch_ns, 5_000_000_000);
        assert_eq!(recording.robot.t, [0.5, 0.25]);
        assert_eq!(recording.robot.theta, [0.3, 3.0]);
        assert_eq!(recording.object.theta, [9.0]);
        let wrench = recording.wrench.unwrap();
        assert_eq!((wrench.fx[0], wrench.fy[0], wrench.tz[0]), (1.0, 2.0, 3.0));
        assert_eq!(recording.remarks, []);
        assert_eq!(recording.sha256.len(), 64);
    }

    #[test]
    fn a_file_without_forces_is_whole() {
        let recording = read(r#"{"tip_pose": [[1,0,0,0]], "object_pose": [[1,0,0,0]]}"#).unwrap();
        assert_eq!(recording.wrench, None);
    }

    #[test]
    fn a_missing_data_set_lists_what_is_there() {
        let error = read(r#"{"tip_pose": [[1,0,0,0]], "vicon": []}"#).unwrap_err();
        assert!(matches!(error, DatasetError::TopicMissing { stream: StreamRole::Object, .. }));
        let message = error.to_string();
        assert!(
            message.ends_with(
                "no `object_pose` for the object stream; set \
                                   streams.object.topic to one of: tip_pose, vicon"
            ),
            "{message}"
        );
    }

    #[test]
    fn an_empty_stream_and_a_wrong_row_are_errors() {
        let error = read(r#"{"tip_pose": [], "object_pose": [[1,0,0,0]]}"#).unwrap_err();
        assert!(matches!(error, DatasetError::NoSamples { stream: StreamRole::Robot, .. }));
        let error = read("{\"tip_pose\": [[1,0,0,0],\n [1,2]]}").unwrap_err();
        assert!(matches!(error, DatasetError::Parse { line: 2, .. }), "{error}");
        let message = error.to_string();
        assert!(message.contains("push.json:2:") && message.contains("rows of four numbers"));
        let error = read("{\"tip_pose\": [[1,NaN,0,0]]}").unwrap_err();
        assert!(matches!(error, DatasetError::Parse { line: 1, .. }), "{error}");
        assert!(matches!(read("").unwrap_err(), DatasetError::Parse { line: 1, .. }));
    }
}
