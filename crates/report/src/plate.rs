//! A figure on a page.

use std::fmt::Write;
use std::path::Path;

use crate::error::ReportError;
use crate::files::Drawn;
use crate::html::escape;

/// A figure with what a reader needs beside it.
#[derive(Debug, Clone)]
pub struct Plate {
    drawn: Drawn,
    caption: String,
    alt: String,
    command: String,
}

impl Plate {
    /// A drawn figure with what one sees in it and the command that makes it; the caption is also
    /// the text for those who cannot see the picture, unless [`Plate::alt`] gives another.
    pub fn new(drawn: Drawn, caption: &str, command: &str) -> Self {
        let (alt, command) = (caption.to_owned(), command.to_owned());
        Self { drawn, caption: caption.to_owned(), alt, command }
    }

    /// Describes the picture itself for those who cannot see it.
    #[must_use]
    pub fn alt(mut self, alt: &str) -> Self {
        alt.clone_into(&mut self.alt);
        self
    }

    pub(crate) fn anchor(&self) -> &str {
        &self.drawn.name
    }

    pub(crate) fn title(&self) -> &str {
        &self.drawn.title
    }

    pub(crate) fn push(&self, out: &mut String, folder: &Path) -> Result<(), ReportError> {
        let drawn = &self.drawn;
        let below = drawn.folder.strip_prefix(folder).map_err(|_| ReportError::Outside {
            path: drawn.path("svg"),
            folder: folder.to_owned(),
        })?;
        let mut links = Vec::new();
        for extension in ["svg", "png", drawn.data_extension] {
            let parts = below.iter().map(|part| part.to_string_lossy().into_owned());
            let file = format!("{}.{extension}", drawn.name);
            let path: Vec<String> = parts.chain([file]).map(|part| percent(&part)).collect();
            let name = extension.to_uppercase();
            links.push(format!("<a href=\"{}\">{name}</a>", escape(&path.join("/"))));
        }
        let _ = writeln!(
            out,
            "<figure id=\"{}\">\n<h3>{}</h3>\n<div class=\"plate\" role=\"img\" \
             aria-label=\"{}\">\n{}</div>\n<figcaption>\n<p>{}</p>\n\
             <p class=\"made\"><code>{}</code> <span>{}</span></p>\n</figcaption>\n</figure>",
            drawn.name,
            escape(&drawn.title),
            escape(&self.alt),
            drawn.svg,
            escape(&self.caption),
            escape(&self.command),
            links.join(" · ")
        );
        Ok(())
    }
}

/// A path component as it stands in a link.
fn percent(part: &str) -> String {
    let mut out = String::new();
    for byte in part.bytes() {
        if byte.is_ascii_alphanumeric() || b"-._~".contains(&byte) {
            out.push(char::from(byte));
        } else {
            let _ = write!(out, "%{byte:02X}");
        }
    }
    out
}
