//! `sessions.csv`: which recordings were measured together, and which repeat one another.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::{Path, PathBuf},
};

use crate::input::map::read_text;
use crate::table::column::column_place;
use crate::{
    error::DatasetError,
    remark::{Remark, RemarkKind},
};

/// Name of the file within a recording set.
pub(crate) const SESSIONS_NAME: &str = "sessions.csv";

/// Names that a remark has room for.
const MOST_NAMES: usize = 3;

/// Session and repeat of each recording that the file names.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sessions {
    path: PathBuf,
    of_recording: BTreeMap<String, Session>,
}

impl Sessions {
    /// What the file says of a recording.
    pub(crate) fn get(&self, recording: &str) -> Option<&Session> {
        self.of_recording.get(recording)
    }

    /// Rows without a recording, and recordings without a row.
    ///
    /// # Errors
    /// `SessionsOfOthers` if no row has a recording: the names are not those of the set.
    pub(crate) fn remarks(&self, recordings: &[String]) -> Result<Vec<Remark>, DatasetError> {
        let known: BTreeSet<&str> = recordings.iter().map(String::as_str).collect();
        let rows = self.of_recording.keys().map(String::as_str);
        let (with, without): (Vec<&str>, Vec<&str>) = rows.partition(|row| known.contains(row));
        if let (true, Some(row)) = (with.is_empty(), without.first()) {
            return Err(DatasetError::SessionsOfOthers {
                path: self.path.clone(),
                rows: without.len(),
                row: (*row).to_owned(),
                recording: recordings.first().cloned().unwrap_or_default(),
            });
        }
        let missing = recordings.iter().map(String::as_str);
        let missing =
            missing.filter(|name| !self.of_recording.contains_key(*name) && !with.is_empty());
        let missing: Vec<&str> = missing.collect();
        let file = self.path.display();
        let remark = |kind, names: &[&str], what: String| {
            let more = if names.len() > MOST_NAMES { ", …" } else { "" };
            let first = names[..names.len().min(MOST_NAMES)].join(", ");
            let (count, text) = (names.len() as u64, format!("{what} ({first}{more})"));
            (count > 0).then_some(Remark { kind, stream: None, count, text })
        };
        let unknown = format!(
            "{} of {} rows of {file} name no recording of this set and are not used",
            without.len(),
            self.of_recording.len()
        );
        let of_none = format!(
            "{} of {} recordings have no row in {file}, so they have no session",
            missing.len(),
            recordings.len()
        );
        let unknown = remark(RemarkKind::SessionUnknown, &without, unknown);
        Ok(unknown
            .into_iter()
            .chain(remark(RemarkKind::SessionMissing, &missing, of_none))
            .collect())
    }
}

/// What is known of one recording.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Session {
    /// Name of the measuring session.
    pub session: String,
    /// Name of the group of repeats that the recording belongs to; empty if it repeats nothing.
    pub repeat: String,
}

/// Reads the file if it is there; each recording may be named once.
pub(crate) fn read_sessions(dir: &Path) -> Result<Sessions, DatasetError> {
    let path = dir.join(SESSIONS_NAME);
    if !path.exists() {
        return Ok(Sessions::default());
    }
    let fail = |error: csv::Error| DatasetError::Parse {
        path: path.clone(),
        line: error.position().map_or(1, csv::Position::line),
        what: error.to_string(),
    };
    let text = read_text(&path)?;
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
    let header = reader.headers().map_err(fail)?.clone();
    let place = |column: &str| column_place(&path, column, header.iter());
    let places = [place("recording")?, place("session")?, place("repeat")?];
    let mut sessions = BTreeMap::new();
    for record in reader.records() {
        let record = record.map_err(fail)?;
        let [recording, session, repeat] =
            places.map(|place| record.get(place).unwrap_or_default().to_owned());
        let entry = Session { session, repeat };
        if sessions.insert(recording.clone(), entry).is_some() {
            return Err(DatasetError::Parse {
                path: path.clone(),
                line: record.position().map_or(1, csv::Position::line),
                what: format!("recording {recording} is named twice; name it once"),
            });
        }
    }
    Ok(Sessions { path, of_recording: sessions })
}

#[cfg(test)]
mod tests {
    use super::read_sessions;

    fn error(text: &str) -> String {
        let dir = tempfile::tempdir().unwrap();
        std::fs::write(dir.path().join("sessions.csv"), text).unwrap();
        let message = read_sessions(dir.path()).unwrap_err().to_string();
        message.replace(dir.path().to_str().unwrap(), "SET")
    }

    #[test]
    fn recordings_are_grouped() {
        let dir = tempfile::tempdir().unwrap();
        assert!(read_sessions(dir.path()).unwrap().get("push-0").is_none());
        let text = "recording,session,repeat\npush-0, monday ,a\npush-1,monday,\n";
        std::fs::write(dir.path().join("sessions.csv"), text).unwrap();
        let sessions = read_sessions(dir.path()).unwrap();
        assert_eq!(sessions.get("push-0").unwrap().session, "monday");
        assert_eq!(sessions.get("push-1").unwrap().repeat, "");
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        assert_eq!(
            error("recording,sesion,repeat\n"),
            "SET/sessions.csv: no column `session`; the table has: recording, sesion, repeat"
        );
        assert_eq!(
            error("recording,session,repeat\na,1,\na,2,\n"),
            "SET/sessions.csv:3: recording a is named twice; name it once"
        );
    }
}
