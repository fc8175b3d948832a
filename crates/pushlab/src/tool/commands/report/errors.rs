//! Errors against the noise floor, and at the end of whole pushes.

use ::report::{
    Axis, Band, Color, Drawing, ErrorBars, Figure, Hover, LegendPlace, Panel, Points, ReportError,
    Section,
};
use diagnosis::{ChannelError, FloorSource, PushEnds};
use effects::Channels;

use super::measure::{Measure, title};
use super::{Report, Tried, tag};
use crate::tool::commands::compare::widened;

/// Normal quantile of a 95 % interval.
const NORMAL_975: f64 = 1.96;

pub(super) fn section(report: &Report) -> Result<Section, ReportError> {
    let known = |name: &&str| of(report, name).next().is_some();
    let names: Vec<&str> = Channels::NAMES.into_iter().filter(known).collect();
    let drawings = names.iter().map(|name| drawing(report, name)).collect::<Result<Vec<_>, _>>()?;
    let tags: Vec<String> = (0..report.models.len()).map(tag).collect();
    let columns = |tag: &String| [tag.clone(), format!("{tag} over floor"), format!("{tag} bias")];
    let columns: Vec<String> = tags.iter().flat_map(columns).collect();
    let head: Vec<&str> = ["error of a step, RMS", "noise floor"]
        .into_iter()
        .chain(columns.iter().map(String::as_str))
        .collect();
    let ends: Vec<&str> =
        std::iter::once("at the end of a push").chain(tags.iter().map(String::as_str)).collect();
    let section = Section::new("errors", "Error against the noise floor")
        .text(&format!(
            "Root mean square of observed less predicted over a step ({}), with 95 % intervals that know \
             that the steps of one push share their errors. The gray band is the noise floor: what \
             no model can predict.",
            report.step
        ))
        .drawings(drawings)
        .table(&head, names.iter().map(|name| row(report, name)).collect())
        .text(
            "Whole pushes, from the measured start along the measured way of the pusher: how far \
             the predicted object ends from the measured one.",
        )
        .table(&ends, end_rows(report));
    let head = ["share of the steps in the model's interval of", "50 %", "90 %", "95 %", "NLPD"];
    Ok(match calibration(report) {
        Some(rows) => section.table(&head, rows),
        None => section,
    })
}

/// What the floor was learnt from.
pub(super) fn floor_source(report: &Report) -> String {
    let floor = &report.floor;
    match floor.source {
        FloorSource::Repeats => format!(
            "The noise floor is how far pushes differ from their repeats: {} repeats of {} pushes{}.",
            floor.n_repeats,
            floor.n_cells,
            widened(floor)
        ),
        _ => "The noise floor is an estimate from neighbouring steps, for there are too few \
              repeats: it is too high where a model misses something between neighbours."
            .to_owned(),
    }
}

fn of<'a>(report: &'a Report, name: &str) -> impl Iterator<Item = (usize, &'a ChannelError)> {
    let models = report.models.iter().enumerate();
    models.filter_map(move |(index, model)| {
        let error = model.comparison.channels.iter().find(|error| error.name == name)?;
        Some((index, error))
    })
}

fn drawing(report: &Report, name: &str) -> Result<Drawing, ReportError> {
    let errors: Vec<_> = of(report, name).collect();
    let measure = Measure::of(errors[0].1.unit);
    let n = report.models.len() as f64;
    let names: Vec<(f64, String)> =
        (0..report.models.len()).map(|index| (index as f64 + 1.0, tag(index))).collect();
    let floor = errors[0].1.floor;
    let top = errors
        .iter()
        .map(|(_, error)| error.rms + NORMAL_975 * error.rms_se)
        .chain(floor.map(|floor| floor.high95))
        .fold(0.0, f64::max);
    let x = Axis::new("model").range(0.4, n + 0.6).names(&names);
    let y = Axis::new(&measure.label("error")).range(0.0, (1.08 * measure.per * top).max(1e-12));
    let mut panel = Panel::new(x, y).title(title(name)).legend(LegendPlace::Hidden);
    let mut hover = Hover::new();
    if let Some(floor) = floor {
        let [low, high] = [floor.low95, floor.high95].map(|value| [measure.per * value; 2]);
        panel =
            panel.with(Band::new(&[0.4, n + 0.6], &low, &high).color(Color::GRAY).opacity(0.35));
        let text = format!(
            "noise floor: {}\n95 % interval {} to {}",
            measure.text(floor.rms),
            measure.text(floor.low95),
            measure.text(floor.high95)
        );
        hover = hover.cell([0.4, low[0]], [n + 0.6, high[0]], &text);
    }
    for (index, error) in &errors {
        let (x, rms) = ([*index as f64 + 1.0], [measure.per * error.rms]);
        let half = NORMAL_975 * measure.per * error.rms_se;
        let (low, high) = ([(rms[0] - half).max(0.0)], [rms[0] + half]);
        let color = Color::cycle(*index);
        panel = panel
            .with(ErrorBars::new(&x, &low, &high).color(color))
            .with(Points::new(&x, &rms).radius(4.0).color(color));
        let text = format!("{}: {}", report.models[*index].name, described(error, measure));
        hover = hover.cell([x[0] - 0.3, low[0]], [x[0] + 0.3, high[0]], &text);
        hover = hover.disc([x[0], rms[0]], 9.0, &text);
    }
    let ratio = |(index, error): &(usize, &ChannelError)| {
        Some(format!("{} {:.1}", tag(*index), error.over_floor?))
    };
    let ratios: Vec<String> = errors.iter().filter_map(ratio).collect();
    let caption = match ratios[..] {
        [] => "No floor is known.".to_owned(),
        _ => format!("Times the floor: {}", ratios.join(", ")),
    };
    let figure = Figure::new(1, 1).panel_size(300.0, 210.0).with(panel.with(hover));
    Drawing::new(&figure, &caption)
}

fn described(error: &ChannelError, measure: Measure) -> String {
    let mut text =
        format!("{} ± {}", measure.text(error.rms), measure.text(NORMAL_975 * error.rms_se));
    if let Some(ratio) = error.over_floor {
        text += &format!("\n{ratio:.2} times the floor");
    }
    text + &format!(
        "\nbias {}\n{} steps",
        measure.plus_minus(error.bias, NORMAL_975 * error.bias_se),
        error.n_steps
    )
}

fn row(report: &Report, name: &str) -> Vec<String> {
    let errors: Vec<_> = of(report, name).collect();
    let measure = Measure::of(errors[0].1.unit);
    let floor = errors[0].1.floor.map_or_else(
        || "unknown".to_owned(),
        |floor| {
            let [rms, low, high] =
                [floor.rms, floor.low95, floor.high95].map(|value| measure.number(value));
            format!("{rms} ({low} to {high})")
        },
    );
    let mut row = vec![measure.label(title(name)), floor];
    for index in 0..report.models.len() {
        let error = errors.iter().find(|(model, _)| *model == index);
        row.extend(match error {
            Some((_, error)) => [
                measure.number(error.rms),
                error.over_floor.map_or_else(|| "–".to_owned(), |ratio| format!("{ratio:.1}")),
                measure.error(error.bias, NORMAL_975 * error.bias_se),
            ],
            None => ["not predicted".to_owned(), "–".to_owned(), "–".to_owned()],
        });
    }
    row
}

/// How honest the models' own intervals are; none if no model has any.
fn calibration(report: &Report) -> Option<Vec<Vec<String>>> {
    let mut rows = Vec::new();
    for (index, model) in report.models.iter().enumerate() {
        for found in &model.comparison.calibration {
            let share = |k: usize| format!("{:.0} %", 100.0 * found.coverage[k].share);
            let name = format!("{} {}", tag(index), title(found.name));
            rows.push(vec![name, share(0), share(1), share(2), format!("{:.2}", found.nlpd)]);
        }
    }
    (!rows.is_empty()).then_some(rows)
}

/// How far off whole pushes end.
fn end_rows(report: &Report) -> Vec<Vec<String>> {
    let texts = |model: &Tried| match &model.ends {
        Some(PushEnds { position, angle, n_lost, .. }) => {
            let (length, turn) = (Measure::of("m"), Measure::of("rad"));
            let [mean, high] = [position.mean, position.p90].map(|value| length.text(value));
            let [turned, far] = [angle.mean, angle.p90].map(|value| turn.text(value));
            [mean, high, turned, far, format!("{n_lost}")]
        }
        None => ["–"; 5].map(str::to_owned),
    };
    let columns: Vec<[String; 5]> = report.models.iter().map(texts).collect();
    let names = [
        "distance, mean",
        "distance, exceeded in a tenth of the pushes",
        "turn, mean",
        "turn, exceeded in a tenth of the pushes",
        "pushes in which the model's object gets away",
    ];
    let row = |(k, name): (usize, &&str)| {
        let values = columns.iter().map(|column| column[k].clone());
        std::iter::once((*name).to_owned()).chain(values).collect()
    };
    names.iter().enumerate().map(row).collect()
}
