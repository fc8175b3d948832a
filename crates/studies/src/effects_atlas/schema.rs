//! The names in docs/model.schema.json.

use anyhow::{Context, Result};
use effects::all;
use models::SurfaceKind;

/// The schema with the limit surfaces and effects that there are.
///
/// # Errors
/// A text that has no such lists.
pub(super) fn with_names(text: &str) -> Result<String> {
    let surfaces = SurfaceKind::all().map(SurfaceKind::name).chain([SurfaceKind::EFFECTIVE]);
    let surfaces = surfaces.map(|name| format!("\"{name}\""));
    let surfaces = surfaces.collect::<Vec<_>>().join(", ");
    let ids = all().iter().map(|effect| format!("\n            \"{}\"", effect.info().id));
    let ids = ids.collect::<Vec<_>>().join(",") + "\n          ";
    let text = with_list(text, "\"limit_surface\": {", &surfaces)?;
    with_list(&text, "\"id\": {", &ids)
}

/// The text with another list in the first brackets after a mark.
fn with_list(text: &str, mark: &str, list: &str) -> Result<String> {
    let start = text.find(mark).with_context(|| format!("the schema has no {mark}"))?;
    let bracket = |letter| text[start..].find(letter).map(|at| start + at);
    let (open, close) =
        bracket('[').zip(bracket(']')).with_context(|| format!("no list after {mark}"))?;
    Ok(format!("{}{list}{}", &text[..=open], &text[close..]))
}
