//! Figure M.3: the error on held-out pushes, as one identified effect after the other is added.

use anyhow::{Context, Result};
use diagnosis::{Comparison, MapSettings, Predictions, Whitening, compare};
use models::Description;
use report::{Axis, Bars, Color, ErrorBars, Figure, Guide, LegendPlace, Panel, Table};

use super::study::{Stage, Study};
use crate::figures::inputs::Inputs;
use crate::figures::sketch::Sketch;

/// Number, what it is for people, unit for people, and what turns SI into it.
const NUMBERS: [(&str, &str, &str, f64); 5] = [
    ("dx", "Δx", "mm", 1e3),
    ("dy", "Δy", "mm", 1e3),
    ("dtheta", "Δθ", "°", 180.0 / std::f64::consts::PI),
    ("force_normal", "normal force", "N", 1.0),
    ("force_tangential", "tangential force", "N", 1.0),
];
const WIDTH: f64 = 0.6;

pub(crate) fn draw(inputs: &Inputs) -> Result<Sketch> {
    let study = inputs.study()?;
    let whole = all_channels(study)?;
    let found = study.stages.iter().map(|stage| compared(study, &stage.model));
    let found = found.collect::<Result<Vec<_>>>()?;
    let mut shown = vec![whole];
    for (name, title, unit, per) in NUMBERS {
        let errors = found.iter().map(|one| {
            let channel = one.channels.iter().find(|channel| channel.name == name)?;
            Some((per * channel.rms, per * channel.rms_se))
        });
        let Some(errors) = errors.collect::<Option<Vec<_>>>() else { continue };
        let number = effects::Channels::NAMES.iter().position(|known| *known == name);
        let floor = number.and_then(|number| study.floor.numbers[number]);
        let floor = floor.map(|floor| per * floor.rms);
        shown.push(Shown { name, title, unit, bars: Bar::all(errors), floor });
    }
    let columns = 3;
    let mut figure = Figure::new(shown.len().div_ceil(columns), columns).panel_size(340.0, 240.0);
    figure = figure.title(&added(study));
    for one in &shown {
        figure = figure.with(one.panel());
    }
    let alt = "Bars of the error of each channel of a step, of the nominal model and with every effect \
               added, beside a line at the noise floor.";
    Ok(Sketch::new(figure, table(study, &shown), &caption(study, &shown), alt))
}

/// The error of all channels together, in units of their noise.
pub(super) fn all_channels(study: &Study) -> Result<Shown> {
    let last = study.stages.last().context("there is at least the nominal model")?;
    let whitening = last.noise.whitening(&last.model, &[], &study.aside)?;
    let white = study.stages.iter().map(|stage| whitened(study, &stage.model, &whitening));
    let bars = Bar::all(white.collect::<Result<Vec<_>>>()?);
    Ok(Shown { name: "whitened", title: "all channels", unit: "", bars, floor: Some(1.0) })
}

/// What the bars' numbers stand for.
pub(super) fn added(study: &Study) -> String {
    let titles = study.stages.iter().filter_map(Stage::title).enumerate();
    titles.map(|(k, title)| format!("+ {} {title}", k + 1)).collect::<Vec<_>>().join(",  ")
}

fn caption(study: &Study, shown: &[Shown]) -> String {
    let ends = [shown[0].bars.first(), shown[0].bars.last()].map(|bar| bar.map_or(0.0, |b| b.rms));
    format!(
        "Root mean square errors of a step on {} held-out pushes: of the nominal model, and with one \
         identified effect more in each bar, fitted to the other {} pushes. Nominal values are fitted \
         in every model. Whiskers are one standard error, from whole pushes; the dashed line is the \
         noise floor. Over all channels, in units of their noise, the error is {:.2} before and {:.2} \
         after.",
        study.aside.pushes().len(),
        study.observations.pushes().len() - study.aside.pushes().len(),
        ends[0],
        ends[1]
    )
}

/// One channel under each model.
pub(super) struct Shown {
    name: &'static str,
    title: &'static str,
    unit: &'static str,
    pub(super) bars: Vec<Bar>,
    floor: Option<f64>,
}

/// An error with its standard error.
pub(super) struct Bar {
    pub(super) rms: f64,
    pub(super) se: f64,
}

impl Bar {
    fn all(errors: Vec<(f64, f64)>) -> Vec<Self> {
        errors.into_iter().map(|(rms, se)| Self { rms, se }).collect()
    }
}

impl Shown {
    pub(super) fn panel(&self) -> Panel {
        let n = self.bars.len();
        let name = |k: usize| if k == 0 { "nominal".to_owned() } else { format!("+ {k}") };
        let names: Vec<(f64, String)> = (0..n).map(|k| (k as f64, name(k))).collect();
        let x = Axis::new("").range(-0.6, n as f64 - 0.4).names(&names);
        let ends = self.bars.iter().map(|bar| bar.rms + bar.se);
        let top = ends.fold(self.floor.unwrap_or(0.0), f64::max);
        let y = match self.unit {
            "" => "RMS error / noise".to_owned(),
            unit => format!("RMS error / {unit}"),
        };
        let y = Axis::new(&y).range(0.0, 1.08 * top);
        let mut panel = Panel::new(x, y).title(self.title).legend(LegendPlace::Hidden);
        for (k, Bar { rms, se }) in self.bars.iter().enumerate() {
            let (x, color) = ([k as f64], if k == 0 { Color::GRAY } else { Color::BLUE });
            panel = panel.with(Bars::new(&x, &[*rms], WIDTH).color(color));
            panel = panel.with(ErrorBars::new(&x, &[rms - se], &[rms + se]).color(Color::INK));
        }
        match self.floor {
            Some(floor) => {
                panel.with(Guide::horizontal(floor).color(Color::ORANGE).width(1.8).dashed())
            }
            None => panel,
        }
    }
}

fn compared(study: &Study, model: &Description) -> Result<Comparison> {
    let predictions = Predictions::of(model, &[], &study.aside)?;
    // No map is shown.
    let settings = MapSettings { n_flips: 99, ..MapSettings::default() };
    Ok(compare(&study.aside, &predictions, &study.floor, &settings)?)
}

/// Root mean square of the residuals as the last model's noise whitens them, with its error from
/// whole pushes.
fn whitened(study: &Study, model: &Description, whitening: &Whitening) -> Result<(f64, f64)> {
    let predictions = Predictions::of(model, &[], &study.aside)?;
    let steps = predictions.steps().iter().zip(study.aside.steps());
    let residuals: Vec<[f64; 7]> = steps
        .map(|(told, step)| {
            std::array::from_fn(|k| {
                step.observed[k].zip(told[k]).map_or(0.0, |(seen, told)| seen - told)
            })
        })
        .collect();
    let white = whitening.whiten_residuals(&residuals);
    let pushes = whitening.rows();
    let sums: Vec<f64> =
        pushes.iter().map(|rows| white.rows(rows.start, rows.len()).norm_squared()).collect();
    let n = whitening.n_numbers() as f64;
    let square = sums.iter().sum::<f64>() / n;
    let variance: f64 = pushes
        .iter()
        .zip(&sums)
        .map(|(rows, sum)| (sum - square * rows.len() as f64).powi(2))
        .sum::<f64>();
    Ok((square.sqrt(), 0.5 * variance.sqrt() / n / square.sqrt()))
}

fn table(study: &Study, shown: &[Shown]) -> Table {
    let each = || {
        shown.iter().flat_map(|one| one.bars.iter().zip(&study.stages).map(move |pair| (one, pair)))
    };
    let added = |stage: &Stage| stage.added.clone().unwrap_or_default();
    Table::new()
        .names("number", &each().map(|(one, _)| one.name).collect::<Vec<_>>())
        .names("unit", &each().map(|(one, _)| one.unit).collect::<Vec<_>>())
        .names("added", &each().map(|(_, (_, stage))| added(stage)).collect::<Vec<_>>())
        .column("rms", &each().map(|(_, (bar, _))| bar.rms).collect::<Vec<_>>())
        .column("rms_se", &each().map(|(_, (bar, _))| bar.se).collect::<Vec<_>>())
        .column("floor", &each().map(|(one, _)| one.floor.unwrap_or(0.0)).collect::<Vec<_>>())
}
