//! Parts of a page: text, figures, tables, claims, drawings, films and players.

use std::fmt::Write;
use std::path::Path;

use crate::drawing::Drawing;
use crate::error::ReportError;
use crate::html::escape;
use crate::plate::Plate;
use crate::player::Player;
use crate::region::Region;

/// What pages do beside being read, in the order in which the scripts need each other.
pub(crate) const SCRIPTS: [&str; 7] = [
    include_str!("hover.js"),
    include_str!("csv.js"),
    include_str!("slider.js"),
    include_str!("film.js"),
    include_str!("charts.js"),
    include_str!("player.js"),
    include_str!("explore.js"),
];

/// A headed part of a page, linked from its contents.
#[derive(Debug, Clone)]
pub struct Section {
    pub(crate) anchor: String,
    pub(crate) title: String,
    blocks: Vec<Block>,
}

#[derive(Debug, Clone)]
enum Block {
    Text(String),
    List(Vec<Told>),
    Figure(Box<Plate>),
    Table(Vec<String>, Vec<Vec<String>>),
    Claims(Vec<Claim>),
    /// Folded behind a line, if there is one.
    Drawings(Option<String>, Vec<Drawing>),
    Film(Vec<Drawing>),
    Player(Player),
}

/// A sentence, and the steps of pushes that it is about.
#[derive(Debug, Clone)]
struct Told {
    sentence: String,
    about: Option<Region>,
}

/// What became of a claim on the data at hand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// The data agree.
    Holds,
    /// The data disagree.
    DoesNotHold,
    /// The data cannot tell.
    NotTestable,
}

/// A claim with its value on the data at hand.
#[derive(Debug, Clone)]
pub struct Claim {
    /// What is claimed.
    pub claim: String,
    /// The value found, with unit; empty if not testable.
    pub value: String,
    /// What became of it.
    pub verdict: Verdict,
    /// Why: the criterion used, or what is missing.
    pub reason: String,
}

impl Section {
    /// An empty section; the anchor is what links name, e.g. `chapter-2`.
    pub fn new(anchor: &str, title: &str) -> Self {
        Self { anchor: anchor.to_owned(), title: title.to_owned(), blocks: Vec::new() }
    }

    /// Adds a paragraph.
    #[must_use]
    pub fn text(mut self, text: &str) -> Self {
        self.blocks.push(Block::Text(text.to_owned()));
        self
    }

    /// Adds a list of sentences.
    #[must_use]
    pub fn list(self, items: Vec<String>) -> Self {
        self.linked_list(items.into_iter().map(|item| (item, None)).collect())
    }

    /// Adds a list of sentences with the steps that each is about, which a reader follows to their
    /// cells on a map and their pushes.
    #[must_use]
    pub fn linked_list(mut self, items: Vec<(String, Option<Region>)>) -> Self {
        let told = items.into_iter().map(|(sentence, about)| Told { sentence, about });
        self.blocks.push(Block::List(told.collect()));
        self
    }

    /// Adds a figure.
    #[must_use]
    pub fn figure(mut self, plate: Plate) -> Self {
        self.blocks.push(Block::Figure(Box::new(plate)));
        self
    }

    /// Adds a table; its first column heads the rows.
    #[must_use]
    pub fn table(mut self, head: &[&str], rows: Vec<Vec<String>>) -> Self {
        let head = head.iter().map(|&cell| cell.to_owned()).collect();
        self.blocks.push(Block::Table(head, rows));
        self
    }

    /// Adds a table of claims.
    #[must_use]
    pub fn claims(mut self, claims: Vec<Claim>) -> Self {
        self.blocks.push(Block::Claims(claims));
        self
    }

    /// Adds drawings side by side, as many as the window has room for.
    #[must_use]
    pub fn drawings(mut self, drawings: Vec<Drawing>) -> Self {
        self.blocks.push(Block::Drawings(None, drawings));
        self
    }

    /// The same, folded behind a line until a reader asks for them.
    #[must_use]
    pub fn folded_drawings(mut self, line: &str, drawings: Vec<Drawing>) -> Self {
        self.blocks.push(Block::Drawings(Some(line.to_owned()), drawings));
        self
    }

    /// Adds drawings of one size that are shown one after the other, as a film; they stand below each other
    /// without scripts.
    #[must_use]
    pub fn film(mut self, pictures: Vec<Drawing>) -> Self {
        self.blocks.push(Block::Film(pictures));
        self
    }

    /// Adds a player.
    #[must_use]
    pub fn player(mut self, player: Player) -> Self {
        self.blocks.push(Block::Player(player));
        self
    }

    /// The scripts that its blocks need, by their place in [`SCRIPTS`].
    pub(crate) fn scripts(&self) -> impl Iterator<Item = usize> + '_ {
        let needed = |block: &Block| match block {
            Block::Drawings(..) => 0..3,
            Block::Table(..) | Block::Claims(_) => 1..2,
            Block::Film(_) => 0..4,
            Block::Player(_) => 4..SCRIPTS.len(),
            _ => 0..0,
        };
        self.blocks.iter().flat_map(needed)
    }

    /// The names of its drawings.
    pub(crate) fn anchors(&self) -> impl Iterator<Item = &str> {
        let drawings = self.blocks.iter().filter_map(|block| match block {
            Block::Drawings(_, drawings) | Block::Film(drawings) => Some(drawings),
            _ => None,
        });
        drawings.flatten().flat_map(Drawing::anchors)
    }

    pub(crate) fn plates(&self) -> impl Iterator<Item = &Plate> {
        self.blocks.iter().filter_map(|block| match block {
            Block::Figure(plate) => Some(plate.as_ref()),
            _ => None,
        })
    }

    pub(crate) fn push(&self, out: &mut String, folder: &Path) -> Result<(), ReportError> {
        let _ = writeln!(out, "<section id=\"{}\">\n<h2>{}</h2>", self.anchor, escape(&self.title));
        for block in &self.blocks {
            match block {
                Block::Text(text) => {
                    let _ = writeln!(out, "<p>{}</p>", escape(text));
                }
                Block::List(items) => {
                    let items: Vec<_> = items.iter().map(Told::html).collect();
                    let _ = writeln!(out, "<ul>\n<li>{}</li>\n</ul>", items.join("</li>\n<li>"));
                }
                Block::Figure(plate) => plate.push(out, folder)?,
                Block::Table(head, rows) => {
                    let rows =
                        rows.iter().map(|row| row.iter().map(|c| escape(c).into()).collect());
                    push_table(out, head.iter().map(String::as_str), rows);
                }
                Block::Claims(claims) => {
                    let rows = claims.iter().map(Claim::cells);
                    push_table(out, ["claim", "value", "verdict", "reason"], rows);
                }
                Block::Drawings(line, drawings) => push_drawings(out, line.as_deref(), drawings),
                Block::Film(pictures) => {
                    out.push_str("<div class=\"film\" data-film>\n");
                    pictures.iter().for_each(|picture| picture.push(out));
                    out.push_str("</div>\n");
                }
                Block::Player(player) => player.push(out)?,
            }
        }
        out.push_str("</section>\n");
        Ok(())
    }
}

impl Told {
    fn html(&self) -> String {
        let link = self.about.as_ref().map(Region::link).unwrap_or_default();
        format!("{}{link}", escape(&self.sentence))
    }
}

impl Claim {
    fn cells(&self) -> Vec<String> {
        let (class, verdict) = match self.verdict {
            Verdict::Holds => ("holds", "holds"),
            Verdict::DoesNotHold => ("fails", "does not hold here"),
            Verdict::NotTestable => ("open", "not testable"),
        };
        vec![
            escape(&self.claim).into(),
            escape(&self.value).into(),
            format!("<span class=\"verdict {class}\">{verdict}</span>"),
            escape(&self.reason).into(),
        ]
    }
}

fn push_drawings(out: &mut String, line: Option<&str>, drawings: &[Drawing]) {
    if let Some(line) = line {
        let _ = writeln!(out, "<details>\n<summary>{}</summary>", escape(line));
    }
    out.push_str("<div class=\"drawings\">\n");
    drawings.iter().for_each(|drawing| drawing.push(out));
    out.push_str("</div>\n");
    if line.is_some() {
        out.push_str("</details>\n");
    }
}

/// A table of cells that are HTML already; heads stay plain text.
fn push_table<'a>(
    out: &mut String,
    head: impl IntoIterator<Item = &'a str>,
    rows: impl Iterator<Item = Vec<String>>,
) {
    let head: Vec<String> = head.into_iter().map(|cell| escape(cell).into()).collect();
    let _ = write!(
        out,
        "<div class=\"scroll\" role=\"group\" aria-label=\"table\" tabindex=\"0\">\n<table>\n<thead><tr><th scope=\"col\">{}</th></tr></thead>\n\
         <tbody>\n",
        head.join("</th><th scope=\"col\">")
    );
    for row in rows {
        let mut cells = row.into_iter();
        let first = cells.next().unwrap_or_default();
        let rest: String = cells.map(|cell| format!("<td>{cell}</td>")).collect();
        let _ = writeln!(out, "<tr><th scope=\"row\">{first}</th>{rest}</tr>");
    }
    out.push_str("</tbody>\n</table>\n</div>\n");
}
