//! DejaVu Sans: text widths and glyph outlines.

use std::sync::OnceLock;

use tiny_skia::{Path, PathBuilder};
use ttf_parser::{Face, OutlineBuilder};

/// The families named in the SVG; Verdana shares DejaVu's widths where that is not installed.
pub(crate) const FAMILIES: &str = "DejaVu Sans,Verdana,Geneva,sans-serif";

fn face(bold: bool) -> &'static Face<'static> {
    static FACES: OnceLock<[Face<'static>; 2]> = OnceLock::new();
    let parse = |bytes| Face::parse(bytes, 0).expect("the bundled DejaVu fonts are whole");
    &FACES.get_or_init(|| [parse(dejavu::sans::regular()), parse(dejavu::sans::bold())])
        [usize::from(bold)]
}

/// Width of a line of text, in px, at a font size in px.
pub(crate) fn text_width(text: &str, size: f64, bold: bool) -> f64 {
    let face = face(bold);
    let units: u32 = text.chars().map(|c| u32::from(advance(face, c))).sum();
    f64::from(units) * size / f64::from(face.units_per_em())
}

/// The text broken at spaces into lines of at most `width` px, as far as its words allow.
pub(crate) fn wrap(text: &str, size: f64, bold: bool, width: f64) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split(' ') {
        if let Some(line) = lines.last_mut() {
            let longer = format!("{line} {word}");
            if text_width(&longer, size, bold) <= width {
                *line = longer;
                continue;
            }
        }
        lines.push(word.to_owned());
    }
    if text.is_empty() { Vec::new() } else { lines }
}

/// Outline of a line of text that starts at the origin, in px, y downward.
pub(crate) fn text_outline(text: &str, size: f64, bold: bool) -> Option<Path> {
    let face = face(bold);
    let scale = size as f32 / f32::from(face.units_per_em());
    let mut pen = Pen { path: PathBuilder::new(), x: 0.0, scale };
    for c in text.chars() {
        face.outline_glyph(face.glyph_index(c).unwrap_or_default(), &mut pen);
        pen.x += scale * f32::from(advance(face, c));
    }
    pen.path.finish()
}

fn advance(face: &Face<'_>, c: char) -> u16 {
    let glyph = face.glyph_index(c).unwrap_or_default();
    face.glyph_hor_advance(glyph).unwrap_or(face.units_per_em())
}

struct Pen {
    path: PathBuilder,
    x: f32,
    scale: f32,
}

impl Pen {
    fn at(&self, x: f32, y: f32) -> (f32, f32) {
        (self.x + self.scale * x, -self.scale * y)
    }
}

impl OutlineBuilder for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.path.move_to(x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.path.line_to(x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let ((x1, y1), (x, y)) = (self.at(x1, y1), self.at(x, y));
        self.path.quad_to(x1, y1, x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let ((x1, y1), (x2, y2), (x, y)) = (self.at(x1, y1), self.at(x2, y2), self.at(x, y));
        self.path.cubic_to(x1, y1, x2, y2, x, y);
    }

    fn close(&mut self) {
        self.path.close();
    }
}

#[cfg(test)]
mod tests {
    use super::{text_outline, text_width, wrap};

    #[test]
    fn width_covers_the_outline() {
        for text in ["Δx in mm", "10⁻³", "−0.25", "β / °"] {
            let outline = text_outline(text, 12.0, false).expect("these glyphs exist");
            let width = text_width(text, 12.0, false);
            let reach = f64::from(outline.bounds().right());
            assert!((0.0..3.0).contains(&(width - reach)), "{text}: {width} {reach}");
        }
    }

    #[test]
    fn wrapped_lines_fit_and_lose_no_word() {
        let text = "error of the predicted displacement against the time step";
        let lines = wrap(text, 12.0, false, 150.0);
        assert!(lines.len() > 1 && lines.iter().all(|l| text_width(l, 12.0, false) <= 150.0));
        assert_eq!(lines.join(" "), text);
        assert!(wrap("", 12.0, false, 150.0).is_empty());
    }

    #[test]
    fn bold_text_is_wider() {
        assert!(text_width("force", 12.0, true) > text_width("force", 12.0, false));
    }
}
