//! Mean residuals over covariates: profiles over one, maps over two.

use ::report::{
    Axis, Band, Cells, Color, ColoredCell, Drawing, Figure, Guide, Hover, LegendPlace, Line, Panel,
    ReportError, Section,
};
use diagnosis::{Cell, Covariate, ResidualMap};
use effects::Channels;

use super::measure::{Measure, covariate, title};
use super::{Report, tag};

/// Probability below which a map is shown as structure.
const SURE: f64 = 0.05;
/// Profiles and maps that are shown without being asked for, of each kind.
const MOST_OPEN: usize = 6;
/// Numbers whose maps over p and β are always shown.
const MOTION: [&str; 3] = ["dx", "dy", "dtheta"];
const PLACE: [Covariate; 2] = [Covariate::P, Covariate::Beta];

pub(super) fn section(report: &Report) -> Result<Section, ReportError> {
    let all: Vec<Kind> = kinds(report);
    let (singles, pairs): (Vec<_>, Vec<_>) = all.iter().partition(|kind| kind.over.len() == 1);
    let sure = |kind: &&&Kind| kind.p <= SURE;
    let open: Vec<&Kind> = singles.iter().filter(sure).take(MOST_OPEN).copied().collect();
    let place: Vec<&Kind> = pairs
        .iter()
        .filter(|kind| kind.over == PLACE && MOTION.contains(&kind.name))
        .copied()
        .collect();
    let mut section = Section::new("maps", "Where the errors depend on something").text(
        "Mean of observed less predicted over a step, with 95 % intervals, where there is enough \
         data. The p of a map is the probability of means that differ as much in any of the maps if \
         nothing depended on anything.",
    );
    section = if open.is_empty() {
        section.text("No profile has structure beyond chance.")
    } else {
        section.text("The surest profiles:").drawings(drawings(report, &open)?)
    };
    if !place.is_empty() {
        section = section.text("Over place and angle of the push:");
        section = section.drawings(drawings(report, &place)?);
    }
    let mut names: Vec<&str> = Vec::new();
    all.iter().for_each(|kind| {
        if !names.contains(&kind.name) {
            names.push(kind.name);
        }
    });
    let rank =
        |name: &&str| Channels::NAMES.iter().position(|known| known == name).unwrap_or(usize::MAX);
    names.sort_by_key(rank);
    for name in names {
        let rest = |kind: &&&Kind| {
            kind.name == name
                && !open.iter().chain(&place).any(|shown| std::ptr::eq(*shown, **kind))
                && (kind.over.len() == 1 || kind.p <= SURE)
        };
        let rest: Vec<&Kind> = singles.iter().chain(&pairs).filter(rest).copied().collect();
        if !rest.is_empty() {
            let line = format!("All other profiles and maps of the {}", title(name));
            section = section.folded_drawings(&line, drawings(report, &rest)?);
        }
    }
    Ok(section)
}

/// A number over some covariates, for every model.
struct Kind {
    name: &'static str,
    unit: &'static str,
    over: Vec<Covariate>,
    /// The smallest probability of any model.
    p: f64,
}

/// Everything that is mapped, the surest of the first model first.
fn kinds(report: &Report) -> Vec<Kind> {
    let mut kinds: Vec<Kind> = Vec::new();
    for map in report.models.iter().flat_map(|model| &model.comparison.maps) {
        let over = &map.covariates;
        match kinds.iter_mut().find(|kind| kind.name == map.name && kind.over == *over) {
            Some(kind) => kind.p = kind.p.min(map.p_adjusted),
            None => {
                let (over, p) = (over.clone(), map.p_adjusted);
                kinds.push(Kind { name: map.name, unit: map.unit, over, p });
            }
        }
    }
    kinds
}

/// The map of each model that has it, by its index.
fn of<'a>(report: &'a Report, kind: &Kind) -> Vec<(usize, &'a ResidualMap)> {
    let models = report.models.iter().enumerate();
    let map = |(index, model): (usize, &'a super::Tried)| {
        let mut maps = model.comparison.maps.iter();
        let map = maps.find(|map| map.name == kind.name && map.covariates == kind.over)?;
        Some((index, map))
    };
    models.filter_map(map).collect()
}

fn drawings(report: &Report, kinds: &[&Kind]) -> Result<Vec<Drawing>, ReportError> {
    let mut drawings = Vec::new();
    for kind in kinds {
        let maps = of(report, kind);
        if kind.over.len() == 1 {
            drawings.push(profile(report, kind, &maps)?);
            continue;
        }
        let measure = Measure::of(kind.unit);
        let values = maps.iter().flat_map(|(_, map)| &map.cells).map(|cell| cell.mean.abs());
        let reach = (measure.per * values.fold(0.0, f64::max)).max(1e-12);
        for (index, map) in maps.into_iter().filter(|(_, map)| !map.cells.is_empty()) {
            drawings.push(plane(report, kind, index, map, reach)?);
        }
    }
    Ok(drawings)
}

/// The axis of a covariate; edges have names, and what has an end of its own shows all of it.
fn axis(over: Covariate, low: f64, high: f64) -> Axis {
    let (low, high) = match over {
        Covariate::P | Covariate::Time => (0.0, 1.0),
        Covariate::Beta => (-90.0, 90.0),
        Covariate::Orientation | Covariate::Direction => (-180.0, 180.0),
        _ => (low, high),
    };
    let axis = Axis::new(covariate(over)).range(low, high);
    if over == Covariate::Edge {
        let names: Vec<(f64, String)> =
            (0..=high.max(0.0) as u32).map(|edge| (f64::from(edge), edge.to_string())).collect();
        return axis.names(&names);
    }
    axis
}

/// The range of a cell in the units of its axis; a cell without width gets one.
fn shown_range(over: Covariate, cell: &Cell, index: usize) -> [f64; 2] {
    let [from, to] = cell.ranges[index].map(|end| Measure::of(over.unit()).per * end);
    if from < to {
        return [from, to];
    }
    let half = (0.02 * from.abs()).max(1e-3);
    [from - half, to + half]
}

fn ends(ranges: impl Iterator<Item = [f64; 2]>) -> [f64; 2] {
    let merge = |[a, b]: [f64; 2], [c, d]: [f64; 2]| [a.min(c), b.max(d)];
    ranges.fold([f64::INFINITY, f64::NEG_INFINITY], merge)
}

/// Where a cell is, in words.
fn place(over: &[Covariate], cell: &Cell) -> String {
    let one = |(index, over): (usize, &Covariate)| {
        let [from, to] = shown_range(*over, cell, index);
        let number = |value: f64| {
            format!("{value:.3}").trim_end_matches('0').trim_end_matches('.').replace('-', "−")
        };
        if *over == Covariate::Edge {
            return format!("edge {:.0}", 0.5 * (from + to));
        }
        format!("{}: {} to {}", covariate(*over), number(from), number(to))
    };
    over.iter().enumerate().map(one).collect::<Vec<_>>().join("\n")
}

fn value(cell: &Cell, measure: Measure) -> String {
    let half = 0.5 * (cell.high95 - cell.low95);
    let mean = measure.plus_minus(cell.mean, half);
    format!("{mean}\n{} steps of {} pushes", cell.n_steps, cell.n_pushes)
}

/// Means of every model over one covariate.
fn profile(
    report: &Report,
    kind: &Kind,
    maps: &[(usize, &ResidualMap)],
) -> Result<Drawing, ReportError> {
    let (measure, over) = (Measure::of(kind.unit), kind.over[0]);
    let cells = || maps.iter().flat_map(|(_, map)| &map.cells);
    let [left, right] = ends(cells().map(|cell| shown_range(over, cell, 0)));
    let [low, high] =
        ends(cells().map(|cell| [measure.per * cell.low95, measure.per * cell.high95]));
    let [low, high] = [low.min(0.0), high.max(0.0)];
    let room = 0.06 * (high - low).max(1e-9);
    let (low, high) = (low - room, high + room);
    let y = Axis::new(&measure.label("mean residual")).range(low, high);
    let mut panel = Panel::new(axis(over, left, right), y)
        .title(title(kind.name))
        .legend(LegendPlace::Hidden)
        .with(Guide::horizontal(0.0));
    let mut texts: Vec<([f64; 2], String)> = Vec::new();
    for (index, map) in maps {
        let color = Color::cycle(*index);
        for cell in &map.cells {
            let x = shown_range(over, cell, 0);
            let [mean, from, to] =
                [cell.mean, cell.low95, cell.high95].map(|v| [measure.per * v; 2]);
            panel = panel
                .with(Band::new(&x, &from, &to).color(color).opacity(0.25))
                .with(Line::new(&x, &mean).color(color).width(2.2));
            let text = format!("{}: {}", tag(*index), value(cell, measure));
            match texts.iter_mut().find(|(known, _)| *known == x) {
                Some((_, texts)) => *texts += &format!("\n{text}"),
                None => texts.push((x, format!("{}\n{text}", place(&kind.over, cell)))),
            }
        }
    }
    let spots = texts
        .iter()
        .fold(Hover::new(), |spots, (x, text)| spots.cell([x[0], low], [x[1], high], text));
    let figure = Figure::new(1, 1).panel_size(310.0, 225.0).with(panel.with(spots));
    Drawing::new(&figure, &probabilities(report, maps))
}

fn probabilities(report: &Report, maps: &[(usize, &ResidualMap)]) -> String {
    let one = |(index, map): &(usize, &ResidualMap)| {
        let p = map.p_adjusted;
        if report.models.len() > 1 { format!("{} {p:.3}", tag(*index)) } else { format!("{p:.3}") }
    };
    format!("p: {}", maps.iter().map(one).collect::<Vec<_>>().join(", "))
}

/// Means of one model over two covariates.
fn plane(
    report: &Report,
    kind: &Kind,
    index: usize,
    map: &ResidualMap,
    reach: f64,
) -> Result<Drawing, ReportError> {
    let measure = Measure::of(kind.unit);
    let (x, y) = (kind.over[0], kind.over[1]);
    let colored = |cell: &Cell| ColoredCell {
        x: shown_range(x, cell, 0),
        y: shown_range(y, cell, 1),
        value: measure.per * cell.mean,
    };
    let cells: Vec<ColoredCell> = map.cells.iter().map(colored).collect();
    let [left, right] = ends(cells.iter().map(|cell| cell.x));
    let [low, high] = ends(cells.iter().map(|cell| cell.y));
    let mut hover = Hover::new();
    for (cell, source) in cells.iter().zip(&map.cells) {
        let text = format!("{}\n{}", place(&kind.over, source), value(source, measure));
        hover = hover.cell([cell.x[0], cell.y[0]], [cell.x[1], cell.y[1]], &text);
    }
    let label = measure.label("mean residual");
    let panel = Panel::new(axis(x, left, right), axis(y, low, high))
        .title(&format!("{} of {}", title(kind.name), tag(index)))
        .with(Cells::new(cells, &label).range(-reach, reach))
        .with(hover);
    let figure = Figure::new(1, 1).panel_size(310.0, 240.0).with(panel);
    Drawing::new(&figure, &probabilities(report, &[(index, map)]))
}
