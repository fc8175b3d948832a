//! A watched push as pictures: the table from above, and where the end is foreseen.

use anyhow::Result;
use filter::PlanarSummary;
use planar::Pose;
use report::{Axis, Color, Drawing, Ellipse, Figure, LegendPlace, Line, Panel, Polygon};

use super::watched_push::WatchedPush;

const MM: f64 = 1e3;
/// Half axes of the ellipse that holds 90 % of a Gaussian in the plane, in standard deviations.
const REACH_90: f64 = 2.145_966_026_289_347;
/// What is left free about all, in mm.
const MARGIN: f64 = 12.0;

/// A picture for each moment.
pub(super) fn film(push: &WatchedPush) -> Result<Vec<Drawing>> {
    let last = push.frames.len().max(1) as f64;
    let drawing = |k: usize| {
        let [with, without] = push.frames[k].map(|end| {
            let sd = |axis: usize| end.covariance[(axis, axis)].max(0.0).sqrt();
            let place = MM * (sd(0) * sd(0) + sd(1) * sd(1)).sqrt();
            format!("{place:.1} mm and {:.1}°", sd(2).to_degrees())
        });
        let caption = format!(
            "After {:.0} % of the steps: the end is foreseen to {with} with what was learnt, to \
             {without} without (standard deviations of normal numbers with these regions of 90 %).",
            100.0 * k as f64 / last
        );
        Ok(Drawing::new(&picture(push, k), &caption)?)
    };
    (0..push.frames.len()).map(drawing).collect()
}

/// The picture after some steps.
pub(super) fn picture(push: &WatchedPush, k: usize) -> Figure {
    let [x, y] = ranges(push);
    let x = Axis::new("world x / mm").range(x[0], x[1]);
    let y = Axis::new("world y / mm").range(y[0], y[1]);
    let mut panel = Panel::new(x, y).equal_aspect().legend(LegendPlace::Below);
    let (now, end) = (push.poses_wb[k], push.poses_wb[push.poses_wb.len() - 1]);
    let [with, without] = push.frames[k];
    let way: Vec<[f64; 2]> = push.centers_w.iter().map(|center| (MM * center).into()).collect();
    let center = MM * push.centers_w[k];
    let pusher = Ellipse::circle(center.into(), MM * push.pusher_radius);
    panel = panel
        .with(Line::through(&way).color(Color::VERMILION).label("pusher's way"))
        .with(pusher.color(Color::VERMILION))
        .with(outline(push, &now).color(Color::INK).width(1.4).label("object, measured"))
        .with(outline(push, &end).color(Color::INK).width(0.8))
        .with(outline(push, &mean(&with)).color(Color::BLUE).width(1.4).label("end, learnt"))
        .with(
            outline(push, &mean(&without)).color(Color::ORANGE).width(1.0).label("end, not learnt"),
        );
    for (end, color) in [(without, Color::ORANGE), (with, Color::BLUE)] {
        if let Some(region) = region(&end) {
            panel = panel.with(region.color(color));
        }
    }
    Figure::single(panel).panel_size(460.0, 460.0).title(&push.name)
}

fn mean(end: &PlanarSummary) -> Pose {
    Pose::new(end.mean.x, end.mean.y, end.mean.z)
}

fn corners(push: &WatchedPush, pose: &Pose) -> Vec<[f64; 2]> {
    let corner = |corner: &nalgebra::Vector2<f64>| (MM * pose.transform_point(corner)).into();
    push.outline.iter().map(corner).collect()
}

fn outline(push: &WatchedPush, pose: &Pose) -> Polygon {
    Polygon::new(&corners(push, pose))
}

/// Where 90 % of the places are; none without spread.
fn region(end: &PlanarSummary) -> Option<Ellipse> {
    let of = |i: usize, j: usize| MM * MM * end.covariance[(i, j)];
    let covariance = [of(0, 0), of(0, 1), of(1, 1)];
    let is_wide = covariance[0] * covariance[2] - covariance[1].powi(2) > 1e-12;
    let center = [MM * end.mean.x, MM * end.mean.y];
    is_wide.then(|| Ellipse::of_covariance(center, covariance, REACH_90))
}

/// Of x and y in mm: the same for all pictures of a push.
fn ranges(push: &WatchedPush) -> [[f64; 2]; 2] {
    let (first, last) = (push.poses_wb[0], push.poses_wb[push.poses_wb.len() - 1]);
    let ends = push.frames.iter().flatten().map(mean);
    let poses = [first, last].into_iter().chain(ends);
    let points: Vec<[f64; 2]> = poses.flat_map(|pose| corners(push, &pose)).collect();
    let centers = push.centers_w.iter().map(|center| [MM * center.x, MM * center.y]);
    let all: Vec<[f64; 2]> = points.into_iter().chain(centers).collect();
    [0, 1].map(|axis| {
        let values = || all.iter().map(|point| point[axis]);
        let low = values().fold(f64::INFINITY, f64::min);
        [low - MARGIN, values().fold(f64::NEG_INFINITY, f64::max) + MARGIN]
    })
}
