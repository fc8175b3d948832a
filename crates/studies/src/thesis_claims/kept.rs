//! Claims as they were judged the last time, below `target/`.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use report::{Claim, Verdict};
use serde::{Deserialize, Serialize};

/// A claim as it is kept.
#[derive(Serialize, Deserialize)]
struct Kept {
    claim: String,
    value: String,
    /// None if the data cannot tell.
    holds: Option<bool>,
    reason: String,
}

/// Keeps claims.
///
/// # Errors
/// A file that cannot be written.
pub(super) fn write(path: &Path, claims: &[Claim]) -> Result<()> {
    let kept = |claim: &Claim| Kept {
        claim: claim.claim.clone(),
        value: claim.value.clone(),
        holds: match claim.verdict {
            Verdict::Holds => Some(true),
            Verdict::DoesNotHold => Some(false),
            Verdict::NotTestable => None,
        },
        reason: claim.reason.clone(),
    };
    let kept: Vec<Kept> = claims.iter().map(kept).collect();
    if let Some(folder) = path.parent() {
        fs::create_dir_all(folder)
            .with_context(|| format!("cannot create {}", folder.display()))?;
    }
    Ok(output::write(path, serde_json::to_string_pretty(&kept)?)?)
}

/// The claims that were kept.
///
/// # Errors
/// A file that is not there, or is no list of claims.
pub(super) fn read(path: &Path) -> Result<Vec<Claim>> {
    let context = || format!("cannot read {}; judge without --only", path.display());
    let text = fs::read_to_string(path).with_context(context)?;
    let kept: Vec<Kept> = serde_json::from_str(&text).with_context(context)?;
    let claim = |Kept { claim, value, holds, reason }| {
        let verdict = match holds {
            Some(true) => Verdict::Holds,
            Some(false) => Verdict::DoesNotHold,
            None => Verdict::NotTestable,
        };
        Claim { claim, value, verdict, reason }
    };
    Ok(kept.into_iter().map(claim).collect())
}

#[cfg(test)]
mod tests {
    use report::{Claim, Verdict};

    use super::{read, write};

    #[test]
    fn claims_are_read_as_they_were_kept() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("below/claims.json");
        assert!(read(&path).unwrap_err().to_string().contains("without --only"));
        let claim = |verdict| Claim {
            claim: "1. \"μs\"".into(),
            value: "2".into(),
            verdict,
            reason: "by a rule".into(),
        };
        let claims = [Verdict::Holds, Verdict::DoesNotHold, Verdict::NotTestable].map(claim);
        write(&path, &claims).unwrap();
        let again = read(&path).unwrap();
        assert_eq!(format!("{again:?}"), format!("{claims:?}"));
    }
}
