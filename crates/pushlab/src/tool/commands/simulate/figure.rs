//! A push rolled out as a figure: the table from above, and the angle over time.

use report::{
    Axis, Band, Color, ColorMap, Ellipse, Figure, LegendPlace, Line, Panel, Points, Polygon,
};

use super::rolled::Rolled;

const MM: f64 = 1e3;
/// Moments whose outline and particles are drawn.
const N_SHOWN: usize = 5;
/// Half axes of the ellipse that holds 95 % of a Gaussian in the plane, in standard deviations.
const REACH_95: f64 = 2.447_746_830_680_816;

/// The figure of a push.
pub(super) fn figure(rolled: &Rolled) -> Figure {
    Figure::new(1, 2)
        .panel_size(420.0, 420.0)
        .with(top_view(rolled))
        .with(angle(rolled))
        .title(&rolled.name)
}

fn shown(rolled: &Rolled) -> Vec<usize> {
    let last = rolled.moments.len() - 1;
    let n = N_SHOWN.min(last + 1).max(2);
    let mut shown: Vec<_> = (0..n).map(|k| k * last / (n - 1)).collect();
    shown.dedup();
    shown
}

fn top_view(rolled: &Rolled) -> Panel {
    let mut panel = Panel::new(Axis::new("world x / mm"), Axis::new("world y / mm"))
        .equal_aspect()
        .legend(LegendPlace::Below);
    let shown = shown(rolled);
    for (k, index) in shown.iter().enumerate() {
        let shade = ColorMap::Viridis.at(0.8 * k as f64 / (shown.len() - 1).max(1) as f64);
        let mean = rolled.moments[*index].pose_wb.mean;
        let pose = planar::Pose::new(mean.x, mean.y, mean.z);
        let corners: Vec<[f64; 2]> = rolled
            .outline
            .iter()
            .map(|corner| (MM * pose.transform_point(corner)).into())
            .collect();
        let outline = Polygon::new(&corners).color(shade).width(1.4);
        let label = k == shown.len() - 1;
        panel = panel.with(if label { outline.label("object, mean pose") } else { outline });
        if let Some(snapshots) = &rolled.snapshots {
            let poses = snapshots[*index].iter();
            let places: Vec<[f64; 2]> = poses.map(|pose| (MM * pose.position).into()).collect();
            let cloud = Points::at(&places).color(shade).radius(1.3);
            panel = panel.with(if label { cloud.label("particles") } else { cloud });
        }
    }
    if let Some(ellipse) = last_region(rolled) {
        panel = panel.with(ellipse);
    }
    let way: Vec<[f64; 2]> =
        rolled.path.points().iter().map(|(_, place)| (MM * place).into()).collect();
    panel = panel.with(Line::through(&way).color(Color::VERMILION).label("pusher's center"));
    match &rolled.measured_wb {
        Some(measured) => {
            let way: Vec<[f64; 2]> =
                measured.iter().flatten().map(|pose| (MM * pose.position).into()).collect();
            panel.with(Line::through(&way).color(Color::INK).width(1.8).label("measured"))
        }
        None => panel,
    }
}

/// Where 95 % of a Gaussian with the last covariance would be; none without spread.
fn last_region(rolled: &Rolled) -> Option<Ellipse> {
    let last = rolled.moments.last()?.pose_wb;
    let of = |i: usize, j: usize| MM * MM * last.covariance[(i, j)];
    let covariance = [of(0, 0), of(0, 1), of(1, 1)];
    let center = [MM * last.mean.x, MM * last.mean.y];
    let is_wide = covariance[0] * covariance[2] - covariance[1].powi(2) > 1e-12;
    let region = || Ellipse::of_covariance(center, covariance, REACH_95);
    is_wide.then(|| region().color(Color::BLUE).label("95 % of the places"))
}

fn angle(rolled: &Rolled) -> Panel {
    let times: Vec<f64> = rolled.moments.iter().map(|moment| moment.time).collect();
    let quantile = |k: usize| -> Vec<f64> {
        rolled.quantiles.iter().map(|quantiles| quantiles[k][2].to_degrees()).collect()
    };
    let (low, middle, high) = (quantile(0), quantile(1), quantile(2));
    let band = match &rolled.snapshots {
        Some(_) => "95 % of the particles",
        None => "95 % of the Gaussian",
    };
    let panel = Panel::new(Axis::new("time / s"), Axis::new("angle / °"))
        .legend(LegendPlace::Below)
        .with(Band::new(&times, &low, &high).label(band))
        .with(Line::new(&times, &middle).color(Color::BLUE).label("median"));
    match &rolled.measured_wb {
        Some(measured) => {
            // Counted from the median, for the measured angle may have any turn.
            let near = |(pose, (time, middle)): (&Option<planar::Pose>, (&f64, &f64))| {
                let beyond = planar::wrap_angle(pose.as_ref()?.angle - middle.to_radians());
                Some((*time, middle + beyond.to_degrees()))
            };
            let found = measured.iter().zip(times.iter().zip(&middle)).filter_map(near);
            let (times, angles): (Vec<f64>, Vec<f64>) = found.unzip();
            panel.with(Line::new(&times, &angles).color(Color::INK).label("measured"))
        }
        None => panel,
    }
}
