//! What to type after a diagnosis.

use std::path::Path;

use anyhow::Result;
use diagnosis::{Diagnosis, Grade};

/// Commands that follow from a diagnosis: what lowers the error is added and looked at, and pushes that
/// would decide what is open are asked for.
///
/// # Errors
/// A path that no shell can be given.
pub(super) fn next_commands(
    found: &Diagnosis,
    source: &[String],
    model: &Path,
    answer: &Path,
) -> Result<Vec<String>> {
    let [model, answer] = [model, answer].map(|path| path.display().to_string());
    let typed = |words: &[&str]| shlex::try_join(["pushlab"].iter().chain(words).copied());
    let mut next = Vec::new();
    let lowers = [&found.identified, &found.effective].iter().any(|ids| !ids.is_empty());
    if lowers || !found.ambiguous.is_empty() {
        next.push(typed(&[
            "add",
            "--all",
            "--from",
            &answer,
            "--model",
            &model,
            "-o",
            "better.toml",
        ])?);
        let source = source.iter().map(String::as_str);
        let compare: Vec<&str> = std::iter::once("compare")
            .chain(source)
            .chain(["--model", "better.toml", "--against", &model])
            .collect();
        next.push(typed(&compare)?);
    }
    let is_open = |effect: &diagnosis::EffectFinding| {
        matches!(effect.grade, Grade::Ambiguous | Grade::Effective | Grade::Hint)
    };
    if found.effects.iter().any(is_open) {
        next.push(typed(&["suggest", "--from", &answer])?);
    }
    Ok(next)
}
