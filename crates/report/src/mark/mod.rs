//! What can be drawn in a panel: one trait, one file for each kind.

use std::fmt::Debug;

use crate::canvas::Canvas;
use crate::color::ColorScale;
use crate::error::ReportError;
use crate::scene::{Ink, Stroke};

/// Adds builder methods over the fields of the same names.
macro_rules! builders {
    ($mark:ident: $($method:ident),+) => {
        impl $mark { $( builders!(@ $method); )+ }
    };
    (@ color) => { builders!(@ color of color); };
    (@ color of $($field:ident).+) => {
        /// Draws in this color.
        #[must_use]
        pub fn color(mut self, color: crate::color::Color) -> Self {
            self.$($field).+ = color;
            self
        }
    };
    (@ stroke) => {
        builders!(@ color of stroke.ink.color);
        /// Draws lines this wide, in px.
        #[must_use]
        pub fn width(mut self, width: f64) -> Self {
            self.stroke.width = width;
            self
        }
    };
    (@ dashed) => {
        /// Dashes the line.
        #[must_use]
        pub fn dashed(mut self) -> Self {
            self.stroke = self.stroke.dashed();
            self
        }
    };
    (@ ink) => {
        builders!(@ color of ink.color);
        /// Fills with this opacity, 0 to 1.
        #[must_use]
        pub fn opacity(mut self, opacity: f64) -> Self {
            self.ink.opacity = opacity;
            self
        }
    };
    (@ fill) => {
        /// Fills it with a color at an opacity of 0 to 1.
        #[must_use]
        pub fn fill(mut self, color: Color, opacity: f64) -> Self {
            self.fill = Some(Ink::new(color, opacity));
            self
        }
    };
    (@ label) => {
        /// Names the mark in the legend.
        #[must_use]
        pub fn label(mut self, label: &str) -> Self {
            self.label = Some(label.to_owned());
            self
        }
    };
}

pub(crate) mod arrows;
pub(crate) mod band;
pub(crate) mod bars;
pub(crate) mod box_plot;
pub(crate) mod cells;
pub(crate) mod contours;
pub(crate) mod ellipse;
pub(crate) mod error_bars;
pub(crate) mod guide;
pub(crate) mod heat_map;
pub(crate) mod histogram;
pub(crate) mod hover;
pub(crate) mod line;
pub(crate) mod note;
pub(crate) mod points;
pub(crate) mod polygon;
pub(crate) mod steps;

/// Something drawn in the data area of a panel.
pub trait Mark: Debug + Send + Sync {
    /// The kind and label, for messages.
    fn name(&self) -> String;

    /// Refuses what cannot be drawn.
    ///
    /// # Errors
    /// Non-finite values, lengths that differ, no data, or a parameter out of range.
    fn check(&self) -> Result<(), ReportError>;

    /// The part of the plane that the mark needs; called after `check`.
    fn extent(&self) -> Extent;

    /// Draws the mark; called after `check`.
    fn draw(&self, canvas: &mut Canvas<'_>);

    /// The mark's line in the legend, if it has a label.
    fn legend(&self) -> Option<LegendKey> {
        None
    }

    /// The mark's colors, if they stand for values.
    fn color_scale(&self) -> Option<ColorScale> {
        None
    }

    /// Whether logarithmic axes would distort the mark.
    fn needs_linear_axes(&self) -> bool {
        false
    }
}

/// The part of the plane that a mark needs, in axis units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    /// Lowest and highest x, if it matters.
    pub x: Option<(f64, f64)>,
    /// Lowest and highest y, if it matters.
    pub y: Option<(f64, f64)>,
    /// Where the axes leave some room: left, right, below, above.
    pub pad: [bool; 4],
}

impl Extent {
    /// The bounding box of points, with room on every side.
    pub fn of(points: impl IntoIterator<Item = [f64; 2]>) -> Self {
        let mut extent = Self { x: None, y: None, pad: [true; 4] };
        for [x, y] in points {
            extent.x = merged(extent.x, Some((x, x)));
            extent.y = merged(extent.y, Some((y, y)));
        }
        extent
    }

    /// The smallest extent that holds both; a side is left without room only if both leave it so
    /// or the one without reaches farther.
    pub(crate) fn with(self, other: Self) -> Self {
        let pad_of = |ours: Option<(f64, f64)>, theirs: Option<(f64, f64)>, side: usize| {
            let reach = |range: Option<(f64, f64)>| match (range, side % 2) {
                (None, _) => f64::NEG_INFINITY,
                (Some((low, _)), 0) => -low,
                (Some((_, high)), _) => high,
            };
            match reach(ours).total_cmp(&reach(theirs)) {
                std::cmp::Ordering::Less => other.pad[side],
                std::cmp::Ordering::Greater => self.pad[side],
                std::cmp::Ordering::Equal => self.pad[side] && other.pad[side],
            }
        };
        let pad = [0, 1, 2, 3].map(|side| {
            if side < 2 { pad_of(self.x, other.x, side) } else { pad_of(self.y, other.y, side) }
        });
        Self { x: merged(self.x, other.x), y: merged(self.y, other.y), pad }
    }
}

fn merged(a: Option<(f64, f64)>, b: Option<(f64, f64)>) -> Option<(f64, f64)> {
    match (a, b) {
        (Some(a), Some(b)) => Some((a.0.min(b.0), a.1.max(b.1))),
        (a, b) => a.or(b),
    }
}

/// A line of the legend.
#[derive(Debug, Clone, PartialEq)]
pub struct LegendKey {
    pub(crate) label: String,
    pub(crate) swatch: Swatch,
}

impl LegendKey {
    /// A swatch with its text, if there is a label.
    pub fn new(label: Option<&String>, swatch: Swatch) -> Option<Self> {
        Some(Self { label: label?.clone(), swatch })
    }
}

/// The small sample beside a legend's text.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Swatch {
    /// A short line.
    Line(Stroke),
    /// A disc of a radius in px.
    Disc(Ink, f64),
    /// A ring of a radius in px.
    Ring(Stroke, f64),
    /// A filled and/or outlined box.
    Area(Option<Ink>, Option<Stroke>),
    /// A small arrow.
    Arrow(Stroke),
}

/// `kind` with the label, as messages name a mark.
pub(crate) fn described(kind: &str, label: Option<&String>) -> String {
    label.map_or_else(|| kind.to_owned(), |label| format!("{kind} `{label}`"))
}

fn pairs<'a>(x: &'a [f64], y: &'a [f64]) -> impl Iterator<Item = [f64; 2]> + 'a {
    x.iter().zip(y).map(|(x, y)| [*x, *y])
}
