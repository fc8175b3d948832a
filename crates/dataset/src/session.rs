//! `sessions.csv`: which recordings were measured together, and which repeat one another.

use std::{collections::BTreeMap, path::Path};

use crate::{column::column_place, error::DatasetError, map::read_text};

/// Name of the file within a recording set.
pub(crate) const SESSIONS_NAME: &str = "sessions.csv";

/// Session and repeat of each recording that the file names.
pub(crate) type Sessions = BTreeMap<String, Session>;

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
        return Ok(Sessions::new());
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
    let mut sessions = Sessions::new();
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
    Ok(sessions)
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
        assert!(read_sessions(dir.path()).unwrap().is_empty());
        let text = "recording,session,repeat\npush-0, monday ,a\npush-1,monday,\n";
        std::fs::write(dir.path().join("sessions.csv"), text).unwrap();
        let sessions = read_sessions(dir.path()).unwrap();
        assert_eq!(sessions["push-0"].session, "monday");
        assert_eq!(sessions["push-1"].repeat, "");
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
