#![doc = include_str!("../README.md")]
#![forbid(unsafe_code)]

mod axis;
mod canvas;
mod color;
mod data;
mod error;
mod figure;
mod files;
mod font;
mod frame;
mod grid;
mod html;
mod legend;
#[macro_use]
mod mark;
mod page;
mod panel;
mod raster;
mod scene;
mod space;
mod style;
mod svg;
mod ticks;

pub use axis::Axis;
pub use canvas::Canvas;
pub use color::{Color, ColorMap, ColorScale};
pub use data::{Data, Table};
pub use error::ReportError;
pub use figure::{Cell, Figure};
pub use files::Drawn;
pub use grid::Grid;
pub use legend::LegendPlace;
pub use mark::arrows::Arrows;
pub use mark::band::Band;
pub use mark::bars::Bars;
pub use mark::box_plot::BoxPlot;
pub use mark::contours::Contours;
pub use mark::ellipse::Ellipse;
pub use mark::error_bars::ErrorBars;
pub use mark::guide::Guide;
pub use mark::heat_map::HeatMap;
pub use mark::histogram::Histogram;
pub use mark::line::Line;
pub use mark::note::Note;
pub use mark::points::Points;
pub use mark::polygon::Polygon;
pub use mark::steps::Steps;
pub use mark::{Extent, LegendKey, Mark, Swatch};
pub use page::{Claim, Page, Plate, Provenance, Section, Verdict};
pub use panel::Panel;
pub use scene::{Anchor, Ink, Stroke};
pub use space::arrows::SpatialArrows;
pub use space::curve::Curve;
pub use space::surface::Surface;
pub use space::view::View;
pub use space::{Body, Piece, Space};
