//! The MIT push data set as JSON: one file a push, three lists of rows.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use super::{
    find::{find_recordings, is_file_ending},
    mit_rows::{Rows, inspect_rows, recording_of_rows},
};
use crate::{
    error::DatasetError,
    format::{Inspection, LogFormat},
    limits::ReadLimits,
    map::FileBytes,
    recording::Recording,
    settings::Streams,
};

/// The MIT JSON format.
pub(crate) struct MitJsonFormat;

impl LogFormat for MitJsonFormat {
    fn id(&self) -> &'static str {
        "mit-json"
    }

    fn find(&self, dir: &Path) -> Result<Vec<PathBuf>, DatasetError> {
        let is_recording = |path: &Path| is_file_ending(path, &["json"]);
        find_recordings(dir, self.id(), "files NAME.json", &is_recording)
    }

    fn read(
        &self,
        path: &Path,
        streams: &Streams,
        limits: &ReadLimits,
    ) -> Result<Recording, DatasetError> {
        let file = FileBytes::open(path, limits)?;
        let mut sets = parse(path, file.bytes())?;
        let names: Vec<String> = sets.keys().cloned().collect();
        let mut take = |name: &str| Ok(sets.remove(name));
        recording_of_rows(path, file.sha256(), &names, streams, &mut take)
    }

    fn inspect(&self, path: &Path, limits: &ReadLimits) -> Result<Inspection, DatasetError> {
        let file = FileBytes::open(path, limits)?;
        let sets = parse(path, file.bytes())?;
        Ok(inspect_rows(sets.iter().map(|(name, rows)| (name.as_str(), rows.as_slice()))))
    }
}

fn parse(path: &Path, bytes: &[u8]) -> Result<BTreeMap<String, Rows>, DatasetError> {
    serde_json::from_slice(bytes).map_err(|error| DatasetError::Parse {
        path: path.into(),
        line: (error.line() as u64).max(1),
        what: format!(
            "{error}; expected lists of rows of four numbers under tip_pose, \
                       object_pose and ft_wrench"
        ),
    })
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::MitJsonFormat;
    use crate::{
        error::DatasetError, format::LogFormat, limits::ReadLimits, recording::Recording,
        remark::StreamRole, settings::Streams,
    };

    fn read(text: &str) -> Result<Recording, DatasetError> {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("push.json");
        fs::write(&path, text).unwrap();
        MitJsonFormat.read(&path, &Streams::default(), &ReadLimits::default())
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
