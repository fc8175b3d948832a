//! What an effect changes beside what a model misses, where that shows most.

use ::report::{
    Axis, Band, Cells, CellsOf, Color, ColoredCell, Drawing, Figure, Guide, Hover, LegendPlace,
    Line, Panel, ReportError, Table,
};
use anyhow::Result;
use diagnosis::{
    Cell, Comparison, Diagnosis, MapSettings, NoiseFloor, Observations, Predictions, ResidualMap,
    compare,
};

use super::super::Tried;
use super::super::maps::{axis, ends, place};
use super::super::measure::{Measure, covariate, key, rounded, shown_range, title};
use crate::tool::commands::add::diagnosed_effect;

/// Drawings, and what there is to say where one is missing.
pub(in crate::tool::commands::report) struct Signatures {
    pub(super) drawings: Vec<Drawing>,
    pub(super) notes: Vec<String>,
}

/// Effects that are shown.
const MOST: usize = 4;
/// Flips that a map needs to be made at all.
const FEW_FLIPS: usize = 99;
/// A map over fewer covariates is shown if it has this share of what the best one shows.
const SIMPLER: f64 = 0.8;

impl Signatures {
    /// Of the effects that a diagnosis claims, or holds possible, beside what a model misses: on all
    /// pushes, for the few that confirm fill few cells.
    ///
    /// # Errors
    /// If the model with an effect cannot predict these pushes.
    pub(in crate::tool::commands::report) fn of(
        found: &Diagnosis,
        tried: &Tried,
        observations: &Observations,
        floor: &NoiseFloor,
    ) -> Result<Self> {
        let groups = found.ambiguous.iter().flatten();
        let named = found.identified.iter().chain(groups).chain(&found.effective);
        let (mut drawings, mut notes) = (Vec::new(), Vec::new());
        let model = &tried.file.description;
        let base = Predictions::of(model, &[], observations)?;
        let own = match tried.is_of_all {
            true => None,
            false => Some(compare(observations, &base, floor, &MapSettings::default())?),
        };
        let missed = own.as_ref().unwrap_or(&tried.found);
        // The means of what an effect changes are asked for, and not how sure they are.
        let settings = MapSettings { n_flips: FEW_FLIPS, ..MapSettings::default() };
        for id in named.take(MOST) {
            if model.effects.iter().any(|effect| effect.id == *id) {
                notes.push(format!(
                    "{id} is in the page's first model already: its signature would be beside what \
                     that model misses."
                ));
                continue;
            }
            let Ok(effect) = diagnosed_effect(found, id) else {
                notes
                    .push(format!("The diagnosis does not tell the values of {id}: no signature."));
                continue;
            };
            let mut with = model.clone();
            with.effects.push(effect);
            let with = Predictions::of(&with, &[], observations)?;
            let expected = observations.as_predicted(&with);
            let changed = compare(&expected, &base, floor, &settings)?;
            match strongest(&changed, missed) {
                Some([changed, missed]) => drawings.push(drawn(id, changed, missed)?),
                None => notes.push(format!(
                    "Too few pushes in any cell of a map to draw what {id} changes."
                )),
            }
        }
        Ok(Self { drawings, notes })
    }
}

/// The map in which most of what an effect changes is seen, of what it changes and of what is missed.
fn strongest<'a>(changed: &'a Comparison, missed: &'a Comparison) -> Option<[&'a ResidualMap; 2]> {
    let mut best: Option<(f64, [&ResidualMap; 2])> = None;
    let n_axes = |maps: &[&ResidualMap; 2]| maps[0].covariates.len();
    for map in changed.maps.iter().filter(|map| !map.cells.is_empty()) {
        let twin = missed.maps.iter().find(|one| {
            one.name == map.name && one.covariates == map.covariates && !one.cells.is_empty()
        });
        let Some(twin) = twin else { continue };
        let (score, maps) = (seen(map, missed), [map, twin]);
        let is_better = best.as_ref().is_none_or(|(least, known)| {
            let worth = |n: usize, score: f64| if n == 1 { score / SIMPLER } else { score };
            worth(n_axes(&maps), score) > worth(n_axes(known), *least)
        });
        if is_better {
            best = Some((score, maps));
        }
    }
    best.map(|(_, maps)| maps)
}

/// How much of what an effect changes of a number a map shows: over its steps, the squared means of
/// cells, in noise floors, less what means of so few pushes come to by chance.
fn seen(map: &ResidualMap, missed: &Comparison) -> f64 {
    // Drift and turn are sideways motion and turn, in another sense.
    let name = match map.name {
        "drift" => "dy",
        "turn" => "dtheta",
        name => name,
    };
    let channel = missed.channels.iter().find(|channel| channel.name == name);
    let floor = channel.map(|channel| channel.floor.map_or(channel.rms, |floor| floor.rms));
    let Some(floor) = floor.filter(|floor| *floor > 0.0) else { return 0.0 };
    let shown = |cell: &Cell| {
        let within = (cell.rms.powi(2) - cell.mean.powi(2)).max(0.0);
        cell.n_steps as f64 * (cell.mean.powi(2) - within / cell.n_pushes as f64)
    };
    map.cells.iter().map(shown).sum::<f64>() / floor.powi(2)
}

/// Both as lines over one covariate, or as maps over two that lie over each other.
fn drawn(id: &str, changed: &ResidualMap, missed: &ResidualMap) -> Result<Drawing, ReportError> {
    if changed.covariates.len() == 1 {
        return profile(id, changed, missed);
    }
    let maps = [changed, missed];
    let measure = Measure::of(changed.unit);
    let cells = || maps.iter().flat_map(|map| &map.cells);
    let along = |axis: usize| {
        ends(cells().map(|cell| shown_range(changed.covariates[axis], cell.ranges[axis])))
    };
    let reach = measure.per * cells().map(|cell| cell.mean.abs()).fold(0.0, f64::max);
    let frame = Frame { x: along(0), y: along(1), reach: reach.max(1e-12) };
    let of_effect = frame.plane(&format!("left: what {id} changes"), changed)?;
    Ok(of_effect.before(frame.plane("right: what the model misses", missed)?))
}

fn profile(id: &str, changed: &ResidualMap, missed: &ResidualMap) -> Result<Drawing, ReportError> {
    let (measure, over) = (Measure::of(changed.unit), changed.covariates[0]);
    let scaled = |value: f64| measure.per * value;
    let cells = || changed.cells.iter().chain(&missed.cells);
    let [left, right] = ends(cells().map(|cell| shown_range(over, cell.ranges[0])));
    let of_missed = missed.cells.iter().map(|cell| [scaled(cell.low95), scaled(cell.high95)]);
    let of_changed = changed.cells.iter().map(|cell| [scaled(cell.mean); 2]);
    let [low, high] = ends(of_missed.chain(of_changed));
    let (low, high) = (low.min(0.0), high.max(0.0));
    let room = 0.06 * (high - low).max(1e-9);
    let (low, high) = (low - room, high + room);
    let y = Axis::new(&measure.label("mean")).range(low, high);
    let mut panel = Panel::new(axis(over, left, right), y)
        .title(title(changed.name))
        .legend(LegendPlace::Below)
        .with(Guide::horizontal(0.0));
    let mut hover = Hover::new();
    for (index, cell) in missed.cells.iter().enumerate() {
        let x = shown_range(over, cell.ranges[0]);
        let [mean, from, to] = [cell.mean, cell.low95, cell.high95].map(|value| [scaled(value); 2]);
        let line = Line::new(&x, &mean).color(Color::INK).width(2.2);
        panel = panel
            .with(Band::new(&x, &from, &to).color(Color::GRAY).opacity(0.3))
            .with(if index == 0 { line.label("model misses") } else { line });
    }
    for (index, cell) in changed.cells.iter().enumerate() {
        let x = shown_range(over, cell.ranges[0]);
        let line = Line::new(&x, &[scaled(cell.mean); 2]).color(Color::VERMILION).width(2.6);
        panel = panel.with(if index == 0 { line.label("effect changes") } else { line });
        let miss = missed.cells.iter().find(|one| one.indices == cell.indices);
        let miss = miss.map(|one| {
            let half = 0.5 * (one.high95 - one.low95);
            format!("\nthe model misses {}", measure.plus_minus(one.mean, half))
        });
        let text = format!(
            "{}\n{id} changes {}{}\n{} steps of {} pushes",
            place(&changed.covariates, cell),
            measure.signed(cell.mean),
            miss.unwrap_or_default(),
            cell.n_steps,
            cell.n_pushes
        );
        hover = hover.cell_of([x[0], low], [x[1], high], &text, &cell.indices);
    }
    let figure = Figure::new(1, 1).panel_size(310.0, 270.0).named(id).with(panel.with(hover));
    let caption = format!("{id}: {}", title(changed.name));
    linked(Drawing::new(&figure, &caption)?, changed)
}

/// What both maps share.
struct Frame {
    x: [f64; 2],
    y: [f64; 2],
    reach: f64,
}

impl Frame {
    fn plane(&self, caption: &str, map: &ResidualMap) -> Result<Drawing, ReportError> {
        let measure = Measure::of(map.unit);
        let over = [map.covariates[0], map.covariates[1]];
        let mut hover = Hover::new();
        let mut cells = Vec::new();
        for cell in &map.cells {
            let [x, y] = [0, 1].map(|axis| shown_range(over[axis], cell.ranges[axis]));
            cells.push(ColoredCell { x, y, value: measure.per * cell.mean });
            let text = format!(
                "{}\n{}\n{} steps of {} pushes",
                place(&over, cell),
                measure.signed(cell.mean),
                cell.n_steps,
                cell.n_pushes
            );
            hover = hover.cell_of([x[0], y[0]], [x[1], y[1]], &text, &cell.indices);
        }
        let [x, y] = [(over[0], self.x), (over[1], self.y)].map(|(o, [a, b])| axis(o, a, b));
        let panel = Panel::new(x, y)
            .title(title(map.name))
            .with(Cells::new(cells, &measure.label("mean")).range(-self.reach, self.reach))
            .with(hover);
        let figure = Figure::new(1, 1).panel_size(310.0, 260.0).named(title(map.name)).with(panel);
        linked(Drawing::new(&figure, caption)?, map)
    }
}

/// With links to the steps of each cell, and with its numbers.
fn linked(drawing: Drawing, map: &ResidualMap) -> Result<Drawing, ReportError> {
    let measure = Measure::of(map.unit);
    let column = |value: &dyn Fn(&Cell) -> f64| -> Vec<f64> {
        map.cells.iter().map(|cell| rounded(value(cell))).collect()
    };
    let mut table = Table::new();
    for (axis, over) in map.covariates.iter().enumerate() {
        for (end, what) in ["from", "to"].into_iter().enumerate() {
            let value = |cell: &Cell| shown_range(*over, cell.ranges[axis])[end];
            table = table.column(&format!("{}, {what}", covariate(*over)), &column(&value));
        }
    }
    let label = measure.label(&format!("mean of the {}", title(map.name)));
    let table = table
        .column(&label, &column(&|cell| measure.per * cell.mean))
        .column("steps", &column(&|cell| cell.n_steps as f64));
    let over = map.covariates.iter().map(|over| key(*over).to_owned()).collect();
    let cells_of = CellsOf { models: vec![0], number: map.name.to_owned(), over };
    Ok(drawing.data(&table)?.cells_of(cells_of))
}
