//! Figure M.1: the analytical model against the measurements, and where it fails.

use anyhow::Result;
use diagnosis::{
    Cell, ChannelError, Comparison, MapSettings, Observations, Predictions, RepeatTolerance,
    compare, noise_floor,
};
use models::{Analytical, PushModel};
use report::{
    Axis, Band, Color, ColorMap, Figure, HeatMap, LegendPlace, Line, Panel, Points, Table,
};

use crate::figures::inputs::Inputs;
use crate::figures::sketch::Sketch;
use crate::held_out::quantile;
use crate::residual_grid::{grid, largest};

/// Number, its sign for people, unit for people, and what turns SI into it.
const NUMBERS: [(&str, &str, &str, f64); 3] = [
    ("dx", "Δx", "mm", 1e3),
    ("dy", "Δy", "mm", 1e3),
    ("dtheta", "Δθ", "°", 180.0 / std::f64::consts::PI),
];
/// Points that a panel shows; more hide each other.
const MOST_POINTS: usize = 1500;
/// Findings in the caption.
const MOST_FINDINGS: usize = 4;

pub(crate) fn draw(inputs: &Inputs) -> Result<Sketch> {
    let observations = inputs.observations()?;
    let model = Analytical::nominal(inputs.pusher()?.friction)?.describe()?;
    let predictions = Predictions::of(&model, &[], &observations)?;
    let floor = noise_floor(&observations, &predictions, &RepeatTolerance::default())?;
    let found = compare(&observations, &predictions, &floor, &MapSettings::default())?;
    let mut figure = Figure::new(2, 3).panel_size(360.0, 290.0);
    for (k, number) in NUMBERS.iter().enumerate() {
        figure = figure.with(against(&observations, &predictions, &found, k, number));
    }
    let white = |cell: &Cell| cell.over_floor;
    let range = largest(&found, &NUMBERS.map(|number| number.0), white);
    for (name, sign, _, _) in NUMBERS {
        let panel = Panel::new("contact position p", "push direction β / °");
        let panel = panel.title(&format!("{sign}: observed less predicted"));
        figure = figure.with(match grid(&found, name, white) {
            Some(grid) => {
                let map = HeatMap::new(grid, "mean over the floor").map(ColorMap::Diverging);
                panel.with(map.range(-range, range))
            }
            None => panel,
        });
    }
    let alt = "Above, three clouds of measured over predicted motion about the diagonal, with the \
               band of the noise floor. Below, three maps of the mean residual over contact \
               position and push direction.";
    Ok(Sketch::new(figure, table(&found), &caption(&found), alt))
}

/// What was observed over what was predicted, with the floor about the diagonal.
fn against(
    observations: &Observations,
    predictions: &Predictions,
    found: &Comparison,
    k: usize,
    (name, sign, unit, per): &(&str, &str, &str, f64),
) -> Panel {
    let pairs = predictions.steps().iter().zip(observations.steps());
    let pairs =
        pairs.filter_map(|(values, step)| Some([per * values[k]?, per * step.observed[k]?]));
    let pairs: Vec<[f64; 2]> = pairs.collect();
    let at = |share| quantile(pairs.iter().flatten().copied().collect(), share);
    let room = 0.03 * (at(1.0) - at(0.0));
    let ends = [at(0.0) - room, at(1.0) + room];
    let every = pairs.len().div_ceil(MOST_POINTS).max(1);
    let shown: Vec<[f64; 2]> = pairs.into_iter().step_by(every).collect();
    let error = found.channels.iter().find(|error| error.name == *name);
    let space = if *unit == "°" { "" } else { " " };
    let title = error.map_or_else(String::new, |error| {
        let size = format!("{sign}: error {:.2}{space}{unit}", per * error.rms);
        match error.over_floor {
            Some(ratio) => format!("{size}, {ratio:.1} × floor"),
            None => size,
        }
    });
    let axis = |what: &str| Axis::new(&format!("{what} {sign} / {unit}")).range(ends[0], ends[1]);
    let points = Points::at(&shown).radius(1.6).opacity(0.5).color(Color::BLUE).label("a step");
    let panel = Panel::new(axis("predicted"), axis("measured")).title(&title).with(points);
    let panel = match error.and_then(|error| error.floor) {
        Some(floor) => {
            let half = 2.0 * per * floor.rms;
            let band = Band::new(&ends, &ends.map(|x| x - half), &ends.map(|x| x + half));
            panel.with(band.color(Color::ORANGE).opacity(0.45).label("± 2 floors"))
        }
        None => panel,
    };
    panel.with(Line::new(&ends, &ends).color(Color::INK).width(1.0)).legend(LegendPlace::TopLeft)
}

fn caption(found: &Comparison) -> String {
    let said: Vec<String> = found
        .findings
        .iter()
        .filter(|finding| ["m", "rad"].contains(&finding.unit) && !finding.name.starts_with("gap"))
        .take(MOST_FINDINGS)
        .map(|finding| finding.sentence.clone())
        .collect();
    let where_ = match said.len() {
        0 => "nowhere more than chance".to_owned(),
        _ => said.join("; "),
    };
    format!(
        "The analytical model with nominal parameters on {} steps of {} pushes. Above: measured over \
         predicted, with the scatter of {} (band). Below: the mean residual over that floor, where a \
         cell has enough steps of enough pushes. In words, the model {where_}.",
        found.n_steps,
        found.n_pushes,
        match found.floor.source {
            diagnosis::FloorSource::Repeats => "repeated pushes",
            diagnosis::FloorSource::Neighbours => "neighbouring pushes, an estimate,",
        }
    )
}

/// The cells of the three maps.
fn table(found: &Comparison) -> Table {
    let over = [diagnosis::Covariate::P, diagnosis::Covariate::Beta];
    let maps = found
        .maps
        .iter()
        .filter(|map| map.covariates == over && NUMBERS.iter().any(|number| number.0 == map.name));
    let cells: Vec<(&str, &Cell)> =
        maps.flat_map(|map| map.cells.iter().map(|cell| (map.name, cell))).collect();
    let of = |value: &dyn Fn(&Cell) -> f64| {
        cells.iter().map(|(_, cell)| value(cell)).collect::<Vec<_>>()
    };
    let floor_of = |name: &str| -> Option<&ChannelError> {
        found.channels.iter().find(|error| error.name == name)
    };
    let floors: Vec<f64> = cells
        .iter()
        .map(|(name, _)| floor_of(name).and_then(|error| error.floor).map_or(0.0, |f| f.rms))
        .collect();
    Table::new()
        .names("number", &cells.iter().map(|(name, _)| *name).collect::<Vec<_>>())
        .column("p_from", &of(&|cell| cell.ranges[0][0]))
        .column("p_to", &of(&|cell| cell.ranges[0][1]))
        .column("beta_from_deg", &of(&|cell| cell.ranges[1][0].to_degrees()))
        .column("beta_to_deg", &of(&|cell| cell.ranges[1][1].to_degrees()))
        .column("n_steps", &of(&|cell| cell.n_steps as f64))
        .column("mean_si", &of(&|cell| cell.mean))
        .column("low95_si", &of(&|cell| cell.low95))
        .column("high95_si", &of(&|cell| cell.high95))
        .column("rms_si", &of(&|cell| cell.rms))
        .column("floor_si", &floors)
}
