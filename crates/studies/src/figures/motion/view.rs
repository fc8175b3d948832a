//! Pushes seen from above, in mm.

use models::{Moment, PushPath};
use nalgebra::Vector2;
use planar::{Pose, Shape};
use report::{Axis, Color, ColorMap, LegendPlace, Line, Panel, Points, Polygon};

pub(super) const MM: f64 = 1e3;

/// An empty view of the table.
pub(super) fn table(title: &str) -> Panel {
    Panel::new(Axis::new("world x / mm"), Axis::new("world y / mm"))
        .equal_aspect()
        .title(title)
        .legend(LegendPlace::Below)
}

/// The outline of an object at a pose.
pub(super) fn outline(shape: &Shape, pose_wb: &Pose, color: Color) -> Polygon {
    let corners: Vec<[f64; 2]> = shape
        .outline(120)
        .iter()
        .map(|corner| (MM * pose_wb.transform_point(corner)).into())
        .collect();
    Polygon::new(&corners).color(color).width(1.4)
}

/// A way through places in m.
pub(super) fn way(places: impl IntoIterator<Item = Vector2<f64>>, color: Color) -> Line {
    let places: Vec<[f64; 2]> = places.into_iter().map(|place| (MM * place).into()).collect();
    Line::through(&places).color(color).width(1.8)
}

/// The pusher's way.
pub(super) fn pusher(path: &PushPath) -> Line {
    way(path.points().iter().map(|(_, place)| *place), Color::VERMILION).label("pusher's center")
}

/// A cloud of places in m.
pub(super) fn cloud(places: &[[f64; 2]], color: Color) -> Points {
    let places: Vec<[f64; 2]> = places.iter().map(|[x, y]| [MM * x, MM * y]).collect();
    Points::at(&places).color(color).radius(1.2)
}

/// Dark for the first of `n`, light (but visible on white) for the last.
pub(super) fn shade(k: usize, n: usize) -> Color {
    ColorMap::Viridis.at(0.85 * k as f64 / (n.max(2) - 1) as f64)
}

/// The mean pose at a moment.
pub(super) fn mean_pose(moment: &Moment) -> Pose {
    let mean = moment.pose_wb.mean;
    Pose::new(mean.x, mean.y, mean.z)
}
