//! `diagnosis.json`, as other commands read it.

use std::path::Path;

use anyhow::{Result, ensure};
use diagnosis::Diagnosis;

use crate::tool::origin::{Input, Origin, readable};

/// Reads a diagnosis, and notes it as an input.
///
/// # Errors
/// If it is a folder, and as [`Diagnosis::read`].
pub(crate) fn read(path: &Path, origin: &mut Origin) -> Result<Diagnosis> {
    let file = path.display();
    ensure!(readable(path)?.is_file(), "{file} is a folder; name the file of a diagnosis");
    let found = Diagnosis::read(path)?;
    origin.inputs.push(Input::file(path)?);
    Ok(found)
}

/// Whether a diagnosis names something by which the error falls, for `pushlab add --all`.
pub(crate) fn lowers_the_error(found: &Diagnosis) -> bool {
    let Diagnosis { identified, effective, ambiguous, .. } = found;
    !identified.is_empty() || !effective.is_empty() || !ambiguous.is_empty()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::read;
    use crate::tool::origin::Origin;

    #[test]
    fn what_is_no_diagnosis_is_refused_with_its_place() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("d.json");
        let message = |bytes: &[u8]| {
            std::fs::write(&path, bytes).unwrap();
            let error = read(&path, &mut Origin::new("add")).unwrap_err();
            format!("{error:#}").replace(dir.path().to_str().unwrap(), "DIR")
        };
        for (bytes, says) in [
            (&b"{\"schema\": \xff}"[..], "DIR/d.json: byte 11: no text in UTF-8"),
            (b"{\n\"schema\": ,", "DIR/d.json:2:11: no JSON: expected value"),
            (b"", "DIR/d.json:1:0: no JSON: EOF"),
            (b"[1]", "it has no `schema`"),
            (
                b"{\"schema\": \"pushlab.result/1\"}",
                "it is a `pushlab.result/1`; `pushlab diagnose",
            ),
            (b"{\"schema\": \"pushlab.diagnosis/9\"}", "this release reads `pushlab.diagnosis/2`"),
            (
                b"{\"schema\": \"pushlab.diagnosis/2\"}",
                "d.json:1:33: no diagnosis: missing field `verdict`",
            ),
        ] {
            let message = message(bytes);
            assert!(message.contains(says), "{message}");
        }
        let message = format!("{:#}", read(Path::new("/"), &mut Origin::new("add")).unwrap_err());
        assert!(message.contains("is a folder"), "{message}");
    }
}
