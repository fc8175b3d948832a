//! Figure M.2: an effect's signature beside the residual, and what each effect gains.

use anyhow::Result;
use diagnosis::{
    Cell, Comparison, Covariate, MapSettings, NoiseFloor, Predictions, ResidualMap, ScreenedEffect,
    compare,
};
use report::{Axis, Cells, Color, ColoredCell, Figure, Guide, LegendPlace, Panel, Polygon, Table};

use super::study::{Stage, Study};
use crate::figures::inputs::Inputs;
use crate::figures::sketch::Sketch;

/// Number, its sign for people, unit for people, and what turns SI into it.
const NUMBERS: [(&str, &str, &str, f64); 3] = [
    ("dx", "Δx", "mm", 1e3),
    ("dy", "Δy", "mm", 1e3),
    ("dtheta", "Δθ", "°", 180.0 / std::f64::consts::PI),
];
/// Probability up to which an effect may be named.
const SURE: f64 = 0.01;
/// No probability is shown, so that a cell may have few pushes and few flips will do.
const MAPS: MapSettings = MapSettings { fewest_steps: 4, fewest_pushes: 2, n_flips: 99, seed: 7 };
/// The least gain shown, in nats.
const LEAST: f64 = 0.1;

pub(crate) fn draw(inputs: &Inputs) -> Result<Sketch> {
    let study = inputs.study()?;
    let n_named = study.stages.len() - 1;
    let mut figure = Figure::new(n_named, 3).panel_size(400.0, 330.0);
    let mut rows = Rows::default();
    for (without, with) in study.stages.iter().zip(&study.stages[1..]) {
        let Some(pair) = Pair::of(study, without, with)? else {
            figure = figure.with(Panel::new("", "")).with(Panel::new("", ""));
            figure = figure.with(gains(without, with, &mut rows));
            continue;
        };
        figure = figure.with(pair.panel(0, with)).with(pair.panel(1, with));
        figure = figure.with(gains(without, with, &mut rows));
        pair.note(with, &mut rows);
    }
    let alt = "A row for each named effect: a map of what the effect changes, the same map of what \
               the model before it misses, in the same colors, and bars of what each effect of the \
               catalogue gains beside that model.";
    Ok(Sketch::new(figure, rows.table(), &caption(study), alt))
}

fn caption(study: &Study) -> String {
    format!(
        "{} pushes; the diagnosis says: {} In each row the model has the effects of the rows above. Left: what the next \
         effect changes in the number that shows it most; middle: what the model misses there, in \
         the same colors, on all pushes. Right: twice the gain in log likelihood that one step of a \
         fit expects of each effect on the pushes to fit to, and how it falls once the effects \
         above are in; blue: adjusted p at most {SURE}; orange: the one that is added. Effects that \
         look alike gain alike: the verdict asks for more than this bar. Right of the dashed line is \
         what one free number gains in noise alone in fewer than one of a hundred sets, were the noise \
         known and independent; p is adjusted by flips of whole pushes instead.",
        study.observations.pushes().len(),
        study.sentence
    )
}

/// The signature of an effect and the residual, over the same two covariates.
pub(super) struct Pair {
    number: usize,
    over: [Covariate; 2],
    maps: [ResidualMap; 2],
}

impl Pair {
    /// Of the number and covariates over which the effect stands out most from the floor.
    pub(super) fn of(study: &Study, without: &Stage, with: &Stage) -> Result<Option<Self>> {
        let seen = &study.observations;
        let before = Predictions::of(&without.model, &[], seen)?;
        let after = Predictions::of(&with.model, &[], seen)?;
        let signature = compare(&seen.as_predicted(&after), &before, &study.floor, &MAPS)?;
        let residual = compare(seen, &before, &study.floor, &MAPS)?;
        let mut best: Option<(f64, Self)> = None;
        for (number, over) in
            (0..NUMBERS.len()).flat_map(|n| Covariate::PAIRS.map(|over| (n, over)))
        {
            let maps = [&signature, &residual].map(|found| map(found, number, over));
            let [Some(effect), Some(missed)] = maps else { continue };
            let size = shown(effect, &study.floor, number) / seen.n_steps() as f64;
            if best.as_ref().is_none_or(|(largest, _)| size > *largest) {
                best =
                    Some((size, Self { number, over, maps: [effect, missed].map(Clone::clone) }));
            }
        }
        Ok(best.map(|(_, pair)| pair))
    }

    /// The map of the signature (0) or of the residual (1).
    pub(super) fn panel(&self, which: usize, with: &Stage) -> Panel {
        let (_, sign, unit, per) = NUMBERS[self.number];
        let [x, y] = self.over.map(axis);
        let values = self.maps.iter().flat_map(|map| &map.cells).map(|cell| per * cell.mean.abs());
        let reach = values.fold(f64::MIN_POSITIVE, f64::max);
        let cell = |cell: &Cell| {
            let [x, y] = [0, 1].map(|k| cell.ranges[k].map(|end| scale(self.over[k]) * end));
            ColoredCell { x, y, value: per * cell.mean }
        };
        let cells = self.maps[which].cells.iter().map(cell).collect();
        let name = with.title().unwrap_or_default();
        let title = match which {
            0 => format!("{sign}: effect of {name}"),
            _ => format!("{sign}: observed − predicted"),
        };
        let label = format!("mean {sign} / {unit}");
        Panel::new(x, y).title(&title).with(Cells::new(cells, &label).range(-reach, reach))
    }

    pub(super) fn note(&self, with: &Stage, rows: &mut Rows) {
        for (what, map) in ["signature", "residual"].into_iter().zip(&self.maps) {
            for cell in &map.cells {
                let place = self.over.iter().zip(&cell.ranges).map(|(over, [from, to])| {
                    format!("{} {from:.4} to {to:.4} {}", over.name(), over.unit())
                });
                let place = place.collect::<Vec<_>>().join(", ");
                rows.push(with, what, map.name, &place, cell.mean, cell.n_steps as f64);
            }
        }
    }
}

fn map(found: &Comparison, number: usize, over: [Covariate; 2]) -> Option<&ResidualMap> {
    let mut maps = found.maps.iter();
    maps.find(|map| {
        map.name == NUMBERS[number].0 && map.covariates == over && !map.cells.is_empty()
    })
}

/// Sum of the squares of what a map shows of each step, over the floor's: a map that shows few steps
/// shows little.
fn shown(map: &ResidualMap, floor: &NoiseFloor, number: usize) -> f64 {
    let floor = floor.numbers[number].map_or(1.0, |floor| floor.rms);
    map.cells.iter().map(|cell| cell.n_steps as f64 * (cell.mean / floor).powi(2)).sum()
}

/// What turns a covariate's SI unit into that of its axis.
fn scale(over: Covariate) -> f64 {
    match over.unit() {
        "rad" => 1.0_f64.to_degrees(),
        "m" | "m/s" => 1e3,
        _ => 1.0,
    }
}

fn axis(over: Covariate) -> Axis {
    let axis = match over {
        Covariate::P => Axis::new("contact position p").range(0.0, 1.0),
        Covariate::Beta => Axis::new("push direction β / °").range(-90.0, 90.0),
        Covariate::Orientation => Axis::new("yaw of the object / °").range(-180.0, 180.0),
        Covariate::Direction => Axis::new("push direction on the table / °").range(-180.0, 180.0),
        Covariate::Speed => Axis::new("speed / mm/s"),
        Covariate::TableX => Axis::new("x on the table / mm"),
        Covariate::TableY => Axis::new("y on the table / mm"),
        Covariate::Time => Axis::new("share of the set"),
        _ => Axis::new("edge"),
    };
    match over {
        Covariate::Orientation | Covariate::Direction => {
            let name = |end: i32| (f64::from(end), end.to_string().replace('-', "−"));
            axis.names(&[-180, -90, 0, 90, 180].map(name))
        }
        _ => axis,
    }
}

/// Bars of every effect's gain, the largest on top.
fn gains(without: &Stage, with: &Stage, rows: &mut Rows) -> Panel {
    let tested = |effect: &&ScreenedEffect| effect.not_testable.is_none();
    let mut effects: Vec<&ScreenedEffect> = without.screen.iter().filter(tested).collect();
    effects.sort_by(|a, b| a.statistic.total_cmp(&b.statistic));
    let n = effects.len();
    let largest = effects.last().map_or(1.0, |effect| effect.statistic).max(10.0 * LEAST);
    let names: Vec<(f64, &str)> =
        effects.iter().enumerate().map(|(k, effect)| (k as f64 + 1.0, effect.id)).collect();
    let x = Axis::new("2 × gain in log likelihood").range(LEAST, 2.0 * largest).log();
    let y = Axis::new("").range(0.3, n as f64 + 0.7).names(&names);
    let mut panel = Panel::new(x, y).title("gain").legend(LegendPlace::Hidden);
    for (index, effect) in effects.iter().enumerate() {
        let (middle, end) = (index as f64 + 1.0, effect.statistic.max(LEAST));
        let color = if with.added.as_deref() == Some(effect.id) {
            Color::ORANGE
        } else if effect.p_adjusted <= SURE {
            Color::BLUE
        } else {
            Color::GRAY
        };
        rows.push(with, "gain", effect.id, "", effect.statistic, effect.p_adjusted);
        if end > LEAST {
            let (low, high) = (middle - 0.34, middle + 0.34);
            let corners = [[LEAST, low], [end, low], [end, high], [LEAST, high]];
            panel = panel.with(Polygon::new(&corners).fill(color, 1.0).color(color));
        }
    }
    // What one free number gains in noise alone, one time in a hundred of 23 effects.
    panel.with(Guide::vertical(CHANCE).dashed())
}

/// The 1 − 0.01/23 quantile of χ² with one degree of freedom.
const CHANCE: f64 = 12.4;

/// The numbers behind the figure, a line each.
#[derive(Default)]
pub(super) struct Rows {
    text: [Vec<String>; 4],
    numbers: [Vec<f64>; 2],
}

impl Rows {
    pub(super) fn push(
        &mut self,
        with: &Stage,
        what: &str,
        name: &str,
        place: &str,
        value: f64,
        of: f64,
    ) {
        let added = with.added.as_deref().unwrap_or_default();
        for (column, text) in self.text.iter_mut().zip([added, what, name, place]) {
            column.push(text.to_owned());
        }
        self.numbers[0].push(value);
        self.numbers[1].push(of);
    }

    /// A value is a mean in SI units with its number of steps, or a gain with its adjusted p.
    pub(super) fn table(self) -> Table {
        let [added, what, name, place] = &self.text;
        Table::new()
            .names("row_adds", added)
            .names("shows", what)
            .names("number_or_effect", name)
            .names("place", place)
            .column("mean_si_or_gain", &self.numbers[0])
            .column("n_steps_or_p", &self.numbers[1])
    }
}
