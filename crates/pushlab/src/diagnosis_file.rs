//! `diagnosis.json`, as other commands read it.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, anyhow, bail, ensure};
use diagnosis::Diagnosis;
use serde_json::Value;

use crate::origin::{Input, Origin, readable};

/// Reads a diagnosis, and notes it as an input.
///
/// # Errors
/// With the byte where the file is no text, with line and column where it is no JSON or not of the
/// form, and with what it is where it is another document.
pub(crate) fn read(path: &Path, origin: &mut Origin) -> Result<Diagnosis> {
    let file = path.display();
    ensure!(readable(path)?.is_file(), "{file} is a folder; name the file of a diagnosis");
    let bytes = fs::read(path).with_context(|| format!("cannot read {file}"))?;
    let text = std::str::from_utf8(&bytes).map_err(|error| {
        anyhow!("{file} is no diagnosis: byte {} is no text", error.valid_up_to())
    })?;
    let at = |error: serde_json::Error, what: &str| {
        let (line, column) = (error.line(), error.column());
        let message = error.to_string();
        // The place stands before the message, as everywhere else.
        let message = message.split(" at line ").next().unwrap_or_default();
        anyhow!("{file}:{line}:{column}: {what}: {message}")
    };
    let value: Value = serde_json::from_str(text).map_err(|error| at(error, "no JSON"))?;
    check_schema(&value).with_context(|| format!("{file} is no diagnosis that can be read"))?;
    let found = serde_json::from_str(text).map_err(|error| at(error, "no diagnosis"))?;
    origin.inputs.push(Input::file(path)?);
    Ok(found)
}

/// Refuses documents of another kind or version.
fn check_schema(value: &Value) -> Result<()> {
    let known = Diagnosis::SCHEMA;
    let Some(schema) = value.get("schema").and_then(Value::as_str) else {
        bail!("it has no `schema`; `pushlab diagnose SET -o diagnosis.json` writes `{known}`")
    };
    let kind = |schema: &str| schema.split('/').next().map(str::to_owned);
    ensure!(
        kind(schema) == kind(known),
        "it is a `{schema}`; `pushlab diagnose SET -o diagnosis.json` writes `{known}`"
    );
    ensure!(
        schema == known,
        "it is of version `{schema}`, and this release reads `{known}`; diagnose the set anew"
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::read;
    use crate::origin::Origin;

    #[test]
    fn what_is_no_diagnosis_is_refused_with_its_place() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("d.json");
        let message = |bytes: &[u8]| {
            std::fs::write(&path, bytes).unwrap();
            let error = read(&path, &mut Origin::new([])).unwrap_err();
            format!("{error:#}").replace(dir.path().to_str().unwrap(), "DIR")
        };
        for (bytes, says) in [
            (&b"{\"schema\": \xff}"[..], "DIR/d.json is no diagnosis: byte 11 is no text"),
            (b"{\n\"schema\": ,", "DIR/d.json:2:11: no JSON: expected value"),
            (b"", "DIR/d.json:1:0: no JSON: EOF"),
            (b"[1]", "it has no `schema`"),
            (
                b"{\"schema\": \"pushlab.result/1\"}",
                "it is a `pushlab.result/1`; `pushlab diagnose",
            ),
            (b"{\"schema\": \"pushlab.diagnosis/9\"}", "this release reads `pushlab.diagnosis/1`"),
            (
                b"{\"schema\": \"pushlab.diagnosis/1\"}",
                "d.json:1:33: no diagnosis: missing field `verdict`",
            ),
        ] {
            let message = message(bytes);
            assert!(message.contains(says), "{message}");
        }
        let message = format!("{:#}", read(Path::new("/"), &mut Origin::new([])).unwrap_err());
        assert!(message.contains("is a folder"), "{message}");
    }
}
