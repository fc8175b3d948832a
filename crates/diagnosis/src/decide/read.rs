//! `diagnosis.json`, read and checked.

use std::path::Path;

use dataset::read_text;
use serde::Deserialize;

use super::answer::Diagnosis;
use crate::DiagnosisError;

/// What every document of ours begins with.
#[derive(Deserialize)]
struct Head {
    schema: Option<String>,
}

impl Diagnosis {
    /// Reads a diagnosis that [`crate::diagnose`] gave and a tool wrote as JSON.
    ///
    /// # Errors
    /// `Dataset`; `NoDiagnosis` with line and column where it is no JSON or not of the form, and with
    /// what it is where it is another document.
    pub fn read(path: &Path) -> Result<Self, DiagnosisError> {
        let text = read_text(path)?;
        let refused = |place: String, what: String| DiagnosisError::NoDiagnosis {
            path: path.into(),
            place,
            what,
        };
        let at = |error: serde_json::Error, what: &str| {
            let message = error.to_string();
            // The place stands before the message, as everywhere else.
            let message = message.split(" at line ").next().unwrap_or_default();
            let place = format!(":{}:{}", error.line(), error.column());
            refused(place, format!("{what}: {message}"))
        };
        let head: serde_json::Value =
            serde_json::from_str(&text).map_err(|error| at(error, "no JSON"))?;
        let schema = Head::deserialize(head).ok().and_then(|head| head.schema);
        check_schema(schema.as_deref()).map_err(|what| refused(String::new(), what))?;
        serde_json::from_str(&text).map_err(|error| at(error, "no diagnosis"))
    }
}

/// Refuses documents of another kind or version.
fn check_schema(schema: Option<&str>) -> Result<(), String> {
    let known = Diagnosis::SCHEMA;
    let remedy = format!("`pushlab diagnose SET -o diagnosis.json` writes `{known}`");
    let Some(schema) = schema else { return Err(format!("it has no `schema`; {remedy}")) };
    let kind = |schema: &str| schema.split('/').next().map(str::to_owned);
    if kind(schema) != kind(known) {
        return Err(format!("it is a `{schema}`; {remedy}"));
    }
    if schema != known {
        let what = format!("it is of version `{schema}`, and this release reads `{known}`");
        return Err(format!("{what}; diagnose the set anew"));
    }
    Ok(())
}
