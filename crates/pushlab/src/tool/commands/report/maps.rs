//! Mean residuals over covariates: profiles over one, maps over two.

use ::report::{
    Axis, Band, Cells, CellsOf, Color, ColoredCell, Drawing, Figure, Guide, Hover, LegendPlace,
    Line, Panel, Region, ReportError, Section, Table,
};
use diagnosis::{Cell, Covariate, ResidualMap};
use effects::Channels;

use super::measure::{Measure, covariate, key, range_text, rounded, shown_range, title};
use super::{Report, Tried, tag};

/// Probability below which a map is shown as structure.
pub(super) const SURE: f64 = 0.05;
/// Profiles and maps that are shown without being asked for, of each kind.
pub(super) const MOST_OPEN: usize = 6;
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
         nothing depended on anything. A click on a cell, or the arrow keys and Enter, lists its pushes and \
         leads to them; of two models the maps lie over each other, the first on the left of the slider.",
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
    for map in report.models.iter().flat_map(|model| &model.found.maps) {
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
    let map = |(index, model): (usize, &'a Tried)| {
        let mut maps = model.found.maps.iter();
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
        let planes = maps.into_iter().filter(|(_, map)| !map.cells.is_empty()).collect::<Vec<_>>();
        let frame = Frame::of(kind, &planes);
        let plane = |(index, map): &(usize, &ResidualMap)| frame.plane(report, kind, *index, map);
        let mut planes = planes.iter().map(plane).collect::<Result<Vec<_>, _>>()?.into_iter();
        // Two of them lie over each other.
        match (planes.next(), planes.next(), planes.next()) {
            (Some(before), Some(after), None) => drawings.push(before.before(after)),
            (first, second, third) => {
                drawings.extend(first.into_iter().chain(second).chain(third).chain(planes));
            }
        }
    }
    Ok(drawings)
}

/// The axis of a covariate; edges have names, and what has an end of its own shows all of it.
pub(super) fn axis(over: Covariate, low: f64, high: f64) -> Axis {
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

pub(super) fn ends(ranges: impl Iterator<Item = [f64; 2]>) -> [f64; 2] {
    let merge = |[a, b]: [f64; 2], [c, d]: [f64; 2]| [a.min(c), b.max(d)];
    ranges.fold([f64::INFINITY, f64::NEG_INFINITY], merge)
}

/// Where a cell is, in words.
pub(super) fn place(over: &[Covariate], cell: &Cell) -> String {
    let one = |(over, ends): (&Covariate, &[f64; 2])| {
        let gap = if *over == Covariate::Edge { "" } else { ":" };
        format!("{}{gap} {}", covariate(*over), range_text(*over, *ends))
    };
    over.iter().zip(&cell.ranges).map(one).collect::<Vec<_>>().join("\n")
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
    let [left, right] = ends(cells().map(|cell| shown_range(over, cell.ranges[0])));
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
    let mut texts: Vec<([f64; 2], String, &[usize])> = Vec::new();
    for (index, map) in maps {
        let color = Color::cycle(*index);
        for cell in &map.cells {
            let x = shown_range(over, cell.ranges[0]);
            let [mean, from, to] =
                [cell.mean, cell.low95, cell.high95].map(|v| [measure.per * v; 2]);
            panel = panel
                .with(Band::new(&x, &from, &to).color(color).opacity(0.25))
                .with(Line::new(&x, &mean).color(color).width(2.2));
            let text = format!("{}: {}", tag(*index), value(cell, measure));
            match texts.iter_mut().find(|(known, ..)| *known == x) {
                Some((_, texts, _)) => *texts += &format!("\n{text}"),
                None => {
                    let text = format!("{}\n{text}", place(&kind.over, cell));
                    let is_of_all = report.models[*index].is_of_all;
                    texts.push((x, text, if is_of_all { &cell.indices } else { &[] }));
                }
            }
        }
    }
    let spots = texts.iter().fold(Hover::new(), |spots, (x, text, cell)| {
        spots.cell_of([x[0], low], [x[1], high], text, cell)
    });
    let figure = Figure::new(1, 1).panel_size(310.0, 225.0).with(panel.with(spots));
    let drawing = Drawing::new(&figure, &probabilities(report, maps))?;
    linked(report, drawing.anchor(&anchor(0, kind.name, &kind.over)), kind, maps)
}

fn probabilities(report: &Report, maps: &[(usize, &ResidualMap)]) -> String {
    let one = |(index, map): &(usize, &ResidualMap)| {
        let p = map.p_adjusted;
        if report.models.len() > 1 { format!("{} {p:.3}", tag(*index)) } else { format!("{p:.3}") }
    };
    format!("p: {}", maps.iter().map(one).collect::<Vec<_>>().join(", "))
}

/// What the maps of all models share, so that they can lie over each other.
struct Frame {
    x: [f64; 2],
    y: [f64; 2],
    /// The value of the strongest color.
    reach: f64,
}

impl Frame {
    fn of(kind: &Kind, maps: &[(usize, &ResidualMap)]) -> Self {
        let cells = || maps.iter().flat_map(|(_, map)| &map.cells);
        let along =
            |axis: usize| ends(cells().map(|cell| shown_range(kind.over[axis], cell.ranges[axis])));
        let largest = cells().map(|cell| cell.mean.abs()).fold(0.0, f64::max);
        let reach = (Measure::of(kind.unit).per * largest).max(1e-12);
        Self { x: along(0), y: along(1), reach }
    }

    /// Means of one model over two covariates.
    fn plane(
        &self,
        report: &Report,
        kind: &Kind,
        index: usize,
        map: &ResidualMap,
    ) -> Result<Drawing, ReportError> {
        let measure = Measure::of(kind.unit);
        let (x, y) = (kind.over[0], kind.over[1]);
        let colored = |cell: &Cell| ColoredCell {
            x: shown_range(x, cell.ranges[0]),
            y: shown_range(y, cell.ranges[1]),
            value: measure.per * cell.mean,
        };
        let cells: Vec<ColoredCell> = map.cells.iter().map(colored).collect();
        let mut hover = Hover::new();
        for (cell, source) in cells.iter().zip(&map.cells) {
            let text = format!("{}\n{}", place(&kind.over, source), value(source, measure));
            let corners = ([cell.x[0], cell.y[0]], [cell.x[1], cell.y[1]]);
            let cell: &[usize] = match report.models[index].is_of_all {
                true => &source.indices,
                false => &[],
            };
            hover = hover.cell_of(corners.0, corners.1, &text, cell);
        }
        let label = measure.label("mean residual");
        let panel = Panel::new(axis(x, self.x[0], self.x[1]), axis(y, self.y[0], self.y[1]))
            .title(title(kind.name))
            .with(Cells::new(cells, &label).range(-self.reach, self.reach))
            .with(hover);
        let name = format!("{} of {}", title(kind.name), tag(index));
        let figure = Figure::new(1, 1).panel_size(310.0, 240.0).named(&name).with(panel);
        let maps = [(index, map)];
        let caption = format!("{}: p {:.3}", tag(index), map.p_adjusted);
        let drawing =
            Drawing::new(&figure, &caption)?.anchor(&anchor(index, kind.name, &kind.over));
        linked(report, drawing, kind, &maps)
    }
}

/// What links call the map of a model; the profiles of all models are one.
fn anchor(model: usize, name: &str, over: &[Covariate]) -> String {
    let over: Vec<&str> = over.iter().map(|over| key(*over)).collect();
    match over[..] {
        [one] => format!("map-{name}-{one}"),
        _ => format!("map-{}-{name}-{}", tag(model), over.join("-")),
    }
}

/// The steps of a finding as the page links them; none where its cells are not those of all pushes.
pub(super) fn region_of(
    report: &Report,
    model: usize,
    name: &str,
    cells: &[(Covariate, Vec<usize>)],
) -> Option<Region> {
    let tried = report.models.get(model).filter(|tried| tried.is_of_all)?;
    let over: Vec<Covariate> = cells.iter().map(|(over, _)| *over).take(2).collect();
    // A third covariate narrows what was found over two; some maps are there over one alone.
    let is_drawn = |over: &[Covariate]| {
        let mut maps = tried.found.maps.iter();
        maps.any(|map| {
            map.name == name && map.covariates == over && !map.cells.is_empty() && is_shown(map)
        })
    };
    let anchor = match over[..] {
        [_, ..] if is_drawn(&over) => anchor(model, name, &over),
        [one, ..] if is_drawn(&[one]) => anchor(model, name, &[one]),
        _ => "maps".to_owned(),
    };
    let cells = cells.iter().map(|(over, cells)| (key(*over).to_owned(), cells.clone())).collect();
    Some(Region { model, number: name.to_owned(), cells, anchor })
}

/// Whether the page has a map.
fn is_shown(map: &ResidualMap) -> bool {
    map.covariates.len() == 1 || map.p_adjusted <= SURE || is_over_place(map)
}

/// Whether a map is one of the motion over place and angle.
pub(super) fn is_over_place(map: &ResidualMap) -> bool {
    map.covariates == PLACE && MOTION.contains(&map.name)
}

/// The drawing with links to the steps of its cells, and the numbers behind it.
fn linked(
    report: &Report,
    drawing: Drawing,
    kind: &Kind,
    maps: &[(usize, &ResidualMap)],
) -> Result<Drawing, ReportError> {
    let drawing = drawing.data(&table(kind, maps))?;
    // Cells of a part of the pushes may be others than those of all, by which steps are told.
    let models = maps.iter().map(|(index, _)| *index);
    let models: Vec<usize> = models.filter(|index| report.models[*index].is_of_all).collect();
    if models.is_empty() {
        return Ok(drawing);
    }
    Ok(drawing.cells_of(CellsOf {
        models,
        number: kind.name.to_owned(),
        over: kind.over.iter().map(|over| key(*over).to_owned()).collect(),
    }))
}

/// The cells of some models' maps.
fn table(kind: &Kind, maps: &[(usize, &ResidualMap)]) -> Table {
    let measure = Measure::of(kind.unit);
    let cells = || maps.iter().flat_map(|(index, map)| map.cells.iter().map(|cell| (*index, cell)));
    let column = |value: &dyn Fn(&Cell) -> f64| -> Vec<f64> {
        cells().map(|(_, cell)| rounded(value(cell))).collect()
    };
    let models: Vec<String> = cells().map(|(index, _)| tag(index)).collect();
    let mut table = Table::new().names("model", &models);
    for (axis, over) in kind.over.iter().enumerate() {
        for (end, what) in ["from", "to"].into_iter().enumerate() {
            let value = |cell: &Cell| shown_range(*over, cell.ranges[axis])[end];
            table = table.column(&format!("{}, {what}", covariate(*over)), &column(&value));
        }
    }
    let label = measure.label(&format!("mean residual of the {}", title(kind.name)));
    table
        .column(&label, &column(&|cell| measure.per * cell.mean))
        .column("from (95 %)", &column(&|cell| measure.per * cell.low95))
        .column("to (95 %)", &column(&|cell| measure.per * cell.high95))
        .column("RMS", &column(&|cell| measure.per * cell.rms))
        .column("steps", &column(&|cell| cell.n_steps as f64))
        .column("pushes", &column(&|cell| cell.n_pushes as f64))
}
