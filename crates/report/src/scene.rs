//! The flat list of shapes, in px, that both the SVG and the PNG are made of.

use crate::color::Color;

/// Everything that is drawn, in painting order.
#[derive(Debug, Clone)]
pub(crate) struct Scene {
    pub(crate) width: f64,
    pub(crate) height: f64,
    pub(crate) shapes: Vec<Shape>,
}

#[derive(Debug, Clone)]
pub(crate) enum Shape {
    Path {
        rings: Vec<Vec<[f64; 2]>>,
        closed: bool,
        fill: Option<Ink>,
        stroke: Option<Stroke>,
    },
    Dots {
        centers: Vec<[f64; 2]>,
        radius: f64,
        ink: Ink,
    },
    Text(Text),
    Image(Image),
    /// A region without ink whose text a page shows on demand.
    Spot {
        ring: Vec<[f64; 2]>,
        text: String,
        /// Which cell of a map it is; empty for another region.
        cell: Vec<usize>,
    },
    ClipStart(Rect),
    ClipEnd,
}

/// A color with an opacity from 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ink {
    pub(crate) color: Color,
    pub(crate) opacity: f64,
}

impl Ink {
    /// The color at an opacity from 0 (nothing) to 1.
    pub const fn new(color: Color, opacity: f64) -> Self {
        Self { color, opacity }
    }
}

impl From<Color> for Ink {
    fn from(color: Color) -> Self {
        Self::new(color, 1.0)
    }
}

/// How a line is drawn; width and dash (on, off) in px.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stroke {
    pub(crate) ink: Ink,
    pub(crate) width: f64,
    pub(crate) dash: Option<[f64; 2]>,
}

impl Stroke {
    /// A solid line of a width in px.
    pub fn new(ink: impl Into<Ink>, width: f64) -> Self {
        Self { ink: ink.into(), width, dash: None }
    }

    /// The same line dashed.
    pub fn dashed(mut self) -> Self {
        self.dash = Some([6.0, 4.0]);
        self
    }
}

#[derive(Debug, Clone)]
pub(crate) struct Text {
    pub(crate) at: [f64; 2],
    pub(crate) content: String,
    pub(crate) size: f64,
    pub(crate) bold: bool,
    pub(crate) anchor: Anchor,
    pub(crate) upward: bool,
    pub(crate) color: Color,
    pub(crate) halo: bool,
}

impl Text {
    pub(crate) fn new(at: [f64; 2], content: &str, size: f64) -> Self {
        Self {
            at,
            content: content.to_owned(),
            size,
            bold: false,
            anchor: Anchor::Middle,
            upward: false,
            color: Color::INK,
            halo: false,
        }
    }
}

/// Which point of a text its position is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// The left end.
    Start,
    /// The middle.
    Middle,
    /// The right end.
    End,
}

#[derive(Debug, Clone)]
pub(crate) struct Image {
    pub(crate) rect: Rect,
    pub(crate) columns: usize,
    pub(crate) rows: usize,
    /// Rows from the top, not premultiplied.
    pub(crate) rgba: Vec<u8>,
    pub(crate) pixelated: bool,
}

/// A rectangle in px, y downward.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rect {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) width: f64,
    pub(crate) height: f64,
}

impl Rect {
    pub(crate) fn right(&self) -> f64 {
        self.x + self.width
    }

    pub(crate) fn bottom(&self) -> f64 {
        self.y + self.height
    }

    pub(crate) fn center(&self) -> [f64; 2] {
        [self.x + 0.5 * self.width, self.y + 0.5 * self.height]
    }

    pub(crate) fn contains(&self, point: [f64; 2]) -> bool {
        (self.x..=self.right()).contains(&point[0]) && (self.y..=self.bottom()).contains(&point[1])
    }

    pub(crate) fn corners(&self) -> Vec<[f64; 2]> {
        let (left, top, right, bottom) = (self.x, self.y, self.right(), self.bottom());
        vec![[left, top], [right, top], [right, bottom], [left, bottom]]
    }
}

impl Scene {
    pub(crate) fn new(width: f64, height: f64) -> Self {
        Self { width, height, shapes: Vec::new() }
    }

    pub(crate) fn line(&mut self, from: [f64; 2], to: [f64; 2], stroke: Stroke) {
        self.path(vec![from, to], false, None, Some(stroke));
    }

    pub(crate) fn path(
        &mut self,
        points: Vec<[f64; 2]>,
        closed: bool,
        fill: Option<Ink>,
        stroke: Option<Stroke>,
    ) {
        self.shapes.push(Shape::Path { rings: vec![points], closed, fill, stroke });
    }

    pub(crate) fn rect(&mut self, rect: &Rect, fill: Option<Ink>, stroke: Option<Stroke>) {
        self.path(rect.corners(), true, fill, stroke);
    }

    pub(crate) fn text(&mut self, text: Text) {
        self.shapes.push(Shape::Text(text));
    }

    /// A rough size of the SVG of the shapes from `first` on, in bytes.
    pub(crate) fn svg_weight(&self, first: usize) -> usize {
        let weigh = |shape: &Shape| match shape {
            Shape::Path { rings, .. } => 55 + 10 * rings.iter().map(Vec::len).sum::<usize>(),
            Shape::Dots { centers, ink, .. } if ink.opacity < 1.0 => 60 * centers.len(),
            Shape::Dots { centers, .. } => 70 + 15 * centers.len(),
            _ => 0,
        };
        self.shapes[first..].iter().map(weigh).sum()
    }
}
