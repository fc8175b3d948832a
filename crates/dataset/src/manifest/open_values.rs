//! What a manifest, or a mapping, leaves open about the rig: all of it at once, so that one look fills it in.

use planar::MIT_NAMES;
use toml::de::{DeTable, DeValue};

use crate::error::DatasetError;
use crate::manifest::text::Source;

/// What a draft has in the place of a value that no recording can tell.
const OPEN: &str = "TODO";

/// Keys that have to be there, as table and key, with what they hold.
const NEEDED: [(&str, &str, &str); 4] = [
    ("object", "shape", "square, rectangle, polygon, ellipse or an MIT object"),
    ("pusher", "radius_m", "in m"),
    ("pusher", "friction", "nominal, pusher-object"),
    ("support", "friction", "nominal, object-table"),
];

/// The dimensions of a shape.
fn dimensions(shape: &str) -> &'static [&'static str] {
    match shape {
        "square" => &["side_m"],
        "rectangle" => &["width_m", "height_m"],
        "polygon" => &["vertices_m"],
        "ellipse" => &["semi_axes_m"],
        _ => &[],
    }
}

impl Source<'_> {
    /// Refuses a text that leaves more than one value open; the reader of each tells more of a single one.
    ///
    /// # Errors
    /// `Parse` with the line of the first that stands there, and the others.
    pub(super) fn refuse_open_values(&self) -> Result<(), DatasetError> {
        // What is no TOML is told by the reader.
        let Ok(table) = DeTable::parse(self.text()) else { return Ok(()) };
        let table = table.get_ref();
        let value = |part: &str, key: &str| match table.get(part).map(|part| part.get_ref()) {
            Some(DeValue::Table(part)) => part.get(key),
            _ => None,
        };
        let mut first = None;
        let mut open = Vec::new();
        let mut ask = |part: &str, key: &str, what: &str| match value(part, key) {
            Some(found) => {
                let is_open = matches!(found.get_ref(), DeValue::String(text) if text == OPEN);
                if is_open {
                    let line = self.line(&found.span());
                    first = first.or(Some(line));
                    open.push(format!("{part}.{key} in line {line} ({what})"));
                }
            }
            None => open.push(format!("{part}.{key} ({what}), which is missing")),
        };
        let shape = match value("object", "shape").map(|shape| shape.get_ref()) {
            Some(DeValue::String(shape)) => shape.as_ref(),
            _ => OPEN,
        };
        for (part, key, what) in NEEDED {
            ask(part, key, what);
            if key == "shape" {
                dimensions(shape).iter().for_each(|key| ask(part, key, "in m"));
                if shape != "by-file-name" && !MIT_NAMES.contains(&shape) {
                    let is_known = if shape == OPEN { ", but of an MIT object" } else { "" };
                    ask(part, "mass_kg", &format!("in kg{is_known}"));
                }
            }
        }
        match open.len() {
            0 | 1 => Ok(()),
            n => Err(self.fail(
                first.unwrap_or(1),
                format!("{n} values are still to be filled in: {}", open.join(", ")),
            )),
        }
    }
}
