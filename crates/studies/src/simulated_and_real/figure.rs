//! The picture beside the page: outputs over β at three places, and the learning curves.

use models::StepObservation;
use report::{Axis, Band, Color, ErrorBars, Figure, LegendPlace, Line, Panel, Points};

use super::described::{COUNTS, Described, OUTPUTS};

/// Middles of the bands of p, and half of their width.
const PLACES: [f64; 3] = [0.2, 0.5, 0.8];
const HALF_WIDTH: f64 = 0.07;
/// Bins of β, in °.
const LOW: f64 = -75.0;
const WIDTH: f64 = 15.0;
const N_BINS: usize = 10;
/// Bins with fewer steps are not drawn.
const FEWEST: usize = 5;
const COLORS: [Color; 3] = [Color::BLUE, Color::GREEN, Color::VERMILION];

/// Draws the measured (points) over the simulated (lines) outputs.
pub(super) fn draw(tables: [&[StepObservation]; 2], described: &[Described; 2]) -> Figure {
    let mut figure = Figure::new(2, 2).panel_size(420.0, 300.0);
    for (k, (name, unit, scale)) in OUTPUTS.iter().enumerate() {
        let mut panel = Panel::new("push direction β / °", format!("{name} / {unit}").as_str())
            .title(name)
            .legend(LegendPlace::Below);
        for (place, color) in PLACES.into_iter().zip(COLORS) {
            let [measured, simulated] =
                tables.map(|steps| bins(steps, place, |step| scale * step.outputs[k]));
            let [x, mean, low, high] = &simulated;
            panel = panel
                .with(Band::new(x, low, high).color(color))
                .with(Line::new(x, mean).color(color).label(&format!("p = {place}")));
            let [x, mean, low, high] = &measured;
            panel = panel
                .with(ErrorBars::new(x, low, high).color(color))
                .with(Points::new(x, mean).color(color).radius(3.0));
        }
        figure = figure.with(panel);
    }
    figure.with(curves(described))
}

/// Middle of each bin of β, mean of a value near one place, and one standard deviation to either
/// side.
fn bins(
    steps: &[StepObservation],
    place: f64,
    value: impl Fn(&StepObservation) -> f64,
) -> [Vec<f64>; 4] {
    let mut columns: [Vec<f64>; 4] = Default::default();
    for bin in 0..N_BINS {
        let from = LOW + WIDTH * bin as f64;
        let inside = steps.iter().filter(|step| {
            (step.input.p() - place).abs() < HALF_WIDTH
                && (from..from + WIDTH).contains(&step.input.beta().to_degrees())
        });
        let values: Vec<f64> = inside.map(&value).collect();
        let n = values.len() as f64;
        if values.len() < FEWEST {
            continue;
        }
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (n - 1.0);
        let sd = variance.sqrt();
        let row = [from + 0.5 * WIDTH, mean, mean - sd, mean + sd];
        columns.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
    }
    columns
}

fn curves(described: &[Described; 2]) -> Panel {
    let counts = COUNTS.map(|count| count as f64);
    let y = Axis::new("error (NMSE)").log();
    let mut panel = Panel::new(Axis::new("training steps").log(), y)
        .title("learning curves")
        .legend(LegendPlace::Below);
    for (data, is_measured) in described.iter().zip([true, false]) {
        for (name, values, color) in [
            ("GP", &data.gp_nmse, Color::BLUE),
            ("hybrid", &data.hybrid_nmse, Color::VERMILION),
            ("analytical", &[data.fitted_nmse; 5], Color::GREEN),
        ] {
            let line = Line::new(&counts, values).color(color);
            let line = line.label(&format!("{name}, {}", data.name));
            panel = panel.with(if is_measured { line } else { line.dashed() });
            panel = panel.with(Points::new(&counts, values).color(color).radius(2.5));
        }
    }
    panel
}
