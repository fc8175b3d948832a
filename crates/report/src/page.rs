//! One offline HTML page: sections, and where they come from.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::Path;

use crate::error::ReportError;
use crate::files::{check_name, write};
use crate::html::escape;
use crate::plate::Plate;
use crate::section::{SCRIPTS, Section};

/// A page in sections, written as one `index.html` that needs no network.
#[derive(Debug, Clone)]
pub struct Page {
    title: String,
    lead: String,
    sections: Vec<Section>,
    provenance: Provenance,
}

/// What made a page.
#[derive(Debug, Clone, Default)]
pub struct Provenance {
    /// The tool and its version.
    pub tool: String,
    /// The arguments it was called with.
    pub arguments: String,
    /// The seed of its random streams.
    pub seed: Option<u64>,
    /// Name and SHA-256 of each input.
    pub inputs: Vec<(String, String)>,
}

/// Lets the page show only what it holds itself: no request to anywhere.
const POLICY: &str = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; \
                      script-src 'unsafe-inline'; base-uri 'none'; form-action 'none'";
/// Inputs above which a page folds their list.
const MANY_INPUTS: usize = 8;

impl Page {
    /// An empty page; the lead is one paragraph under the title.
    pub fn new(title: &str, lead: &str, provenance: Provenance) -> Self {
        let (title, lead) = (title.to_owned(), lead.to_owned());
        Self { title, lead, sections: Vec::new(), provenance }
    }

    /// Adds a section.
    #[must_use]
    pub fn with(mut self, section: Section) -> Self {
        self.sections.push(section);
        self
    }

    /// Writes `index.html` into the folder; figures may lie in it or below.
    ///
    /// # Errors
    /// An anchor twice or with other characters than letters, digits, `.`, `_`, `-`; a figure
    /// outside the folder; a folder that cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(), ReportError> {
        write(&folder.join("index.html"), self.html(folder)?.as_bytes())
    }

    /// The page as HTML text without files beside it.
    ///
    /// # Errors
    /// As [`Page::html`]; a [`Plate`] needs files.
    pub fn single_file(&self) -> Result<String, ReportError> {
        match self.sections.iter().flat_map(Section::plates).next() {
            Some(plate) => Err(ReportError::NotAlone { name: plate.anchor().to_owned() }),
            None => self.html(Path::new("")),
        }
    }

    /// The page as HTML text with links relative to the folder.
    ///
    /// # Errors
    /// As [`Page::write`], but for the writing.
    pub fn html(&self, folder: &Path) -> Result<String, ReportError> {
        self.check()?;
        let title = escape(&self.title);
        let mut out = format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\">\n\
             <title>{title}</title>\n<style>\n{}</style>\n</head>\n<body>\n<main>\n\
             <header>\n<h1>{title}</h1>\n<p class=\"lead\">{}</p>\n</header>\n",
            include_str!("page.css"),
            escape(&self.lead)
        );
        self.push_contents(&mut out);
        for section in &self.sections {
            section.push(&mut out, folder)?;
        }
        self.provenance.push(&mut out);
        out.push_str("</main>\n");
        for script in self.sections.iter().flat_map(Section::scripts).collect::<BTreeSet<_>>() {
            let _ = writeln!(out, "<script>\n{}</script>", SCRIPTS[script]);
        }
        out.push_str("</body>\n</html>\n");
        Ok(out)
    }

    fn check(&self) -> Result<(), ReportError> {
        let mut seen = BTreeSet::from(["contents", "provenance"]);
        let anchors = self.sections.iter().flat_map(|section| {
            let plates = section.plates().map(Plate::anchor);
            std::iter::once(section.anchor.as_str()).chain(plates).chain(section.anchors())
        });
        for anchor in anchors {
            check_name(anchor)?;
            if !seen.insert(anchor) {
                return Err(ReportError::Duplicate { name: anchor.to_owned() });
            }
        }
        Ok(())
    }

    fn push_contents(&self, out: &mut String) {
        out.push_str("<nav id=\"contents\" aria-label=\"Contents\">\n<ol>\n");
        for section in &self.sections {
            let _ =
                write!(out, "<li><a href=\"#{}\">{}</a>", section.anchor, escape(&section.title));
            let plates: Vec<String> = section
                .plates()
                .map(|p| format!("<a href=\"#{}\">{}</a>", p.anchor(), escape(p.title())))
                .collect();
            if !plates.is_empty() {
                let _ = write!(out, "\n<ul>\n<li>{}</li>\n</ul>\n", plates.join("</li>\n<li>"));
            }
            out.push_str("</li>\n");
        }
        out.push_str("<li><a href=\"#provenance\">Provenance</a></li>\n</ol>\n</nav>\n");
    }
}

impl Provenance {
    fn push(&self, out: &mut String) {
        let seed = self.seed.map_or_else(|| "none".to_owned(), |seed| seed.to_string());
        let _ = write!(
            out,
            "<footer id=\"provenance\">\n<h2>Provenance</h2>\n<dl>\n<dt>Tool</dt><dd>{}</dd>\n\
             <dt>Arguments</dt><dd><code>{}</code></dd>\n<dt>Seed</dt><dd>{seed}</dd>\n",
            escape(&self.tool),
            escape(&self.arguments)
        );
        let n = self.inputs.len();
        if n > MANY_INPUTS {
            // Thousands of them are one text, as `sha256sum --check` reads it.
            let line =
                |(name, hash): &(String, String)| format!("{}  {}\n", escape(hash), escape(name));
            let lines: String = self.inputs.iter().map(line).collect();
            let _ = writeln!(
                out,
                "</dl>\n<details>\n<summary>{n} inputs with their SHA-256</summary>\n\
                 <pre class=\"inputs\">{lines}</pre>\n</details>\n</footer>"
            );
            return;
        }
        for (name, hash) in &self.inputs {
            let _ = writeln!(
                out,
                "<dt>{}</dt><dd>SHA-256 <code class=\"hash\">{}</code></dd>",
                escape(name),
                escape(hash)
            );
        }
        let _ = writeln!(out, "</dl>\n</footer>");
    }
}
