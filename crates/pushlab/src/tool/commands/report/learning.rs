//! How the models' Gaussian processes were learnt, and what each says of its rows without them.

use ::report::{
    Axis, Color, Drawing, Figure, Guide, Hover, LegendPlace, Line, Panel, Points, Section,
};
use anyhow::{Context, Result};
use gp_core::quantile::normal;
use gp_core::{Gp, LeaveOneOut, StartReport};
use models::{ProcessModel, ProcessReport};

use super::{Report, Tried, tag};

const OUTPUTS: [&str; 3] = ["Δx", "Δy", "Δθ"];
const LEVELS: [f64; 3] = [0.5, 0.9, 0.95];
/// Its name, what is drawn, and what one sees in it.
type Chart = (&'static str, fn(&Learnt<'_>) -> Panel, fn(&Learnt<'_>) -> String);
const CHARTS: [Chart; 4] = [
    ("optimiser", |one| one.optimisation(), |one| one.optimiser_in_words()),
    ("left-out rows", |one| one.over_predictions(), |one| one.residuals_in_words()),
    ("quantiles", |one| one.quantiles(), |one| one.quantiles_in_words()),
    ("coverage", |one| one.coverage(), |one| one.coverage_in_words()),
];
/// Rows beyond so many standard deviations are told one by one.
const FAR: f64 = 2.5;
/// Rows that are drawn; of more an even choice, and all that are far out.
const MOST_DRAWN: usize = 500;
/// Starts that end so near to the best, in nats, found the same.
const SAME: f64 = 0.1;
/// A gradient above it is no maximum's, in nats per log-parameter.
const STEEP: f64 = 0.1;
/// A covariance above it leaves fewer than six digits of the weights.
const ILL_CONDITIONED: f64 = 1e10;
/// Residuals this much smaller or larger than they should be speak against the variances.
const HONEST: [f64; 2] = [0.85, 1.2];
/// In standard deviations of a share.
const BEYOND_CHANCE: f64 = 3.0;

/// None where no model has an exact process.
///
/// # Errors
/// For weights that make no process.
pub(super) fn section(report: &Report) -> Result<Option<Section>> {
    let mut section = Section::new("learning", "How the processes were learnt").text(
        "Each output of a learnt model is a Gaussian process of its own, per meter of the pusher's way. First: \
         how far each start of the optimiser was below the best end, in nats, while it went on. \
         The others are of every row that was learnt from, predicted from all the others with the \
         hyperparameters as they are: residuals in predicted standard deviations over what was predicted, beside \
         normal quantiles, and the share of rows within intervals of a level. An honest process has them without \
         a trend, on the line, and on the diagonal.",
    );
    let mut is_any = false;
    for (index, model) in report.models.iter().enumerate() {
        let learnt = Learnt::all(model).with_context(|| format!("cannot read {}", model.name))?;
        if learnt.is_empty() {
            continue;
        }
        is_any = true;
        let rows = learnt.iter().map(Learnt::row).collect();
        let head = [
            &format!("{} – {}", tag(index), model.name),
            "rows",
            "log evidence in nats",
            "largest gradient",
            "starts that found it",
            "condition number",
            "at a bound",
            "residuals, RMS in sd",
            "within 50, 90, 95 %",
        ];
        section = section.table(&head, rows).text(&looked_at_twice(&learnt));
        // Outputs beside each other, a row for each kind of chart.
        for chart in CHARTS {
            let drawings = learnt.iter().map(|one| one.drawing(chart));
            section = section.drawings(drawings.collect::<Result<_>>()?);
        }
    }
    Ok(is_any.then_some(section))
}

/// One output.
struct Learnt<'a> {
    name: &'static str,
    gp: Gp,
    /// How it was learnt, where the weights tell.
    report: Option<&'a ProcessReport>,
    left_out: LeaveOneOut,
    /// Observed less predicted without the row, in predicted standard deviations.
    residuals: Vec<f64>,
    condition_number: f64,
}

impl<'a> Learnt<'a> {
    /// The outputs of a model; none of a model without exact processes.
    fn all(model: &'a Tried) -> Result<Vec<Self>> {
        let Some(weights) = &model.file.description.weights else { return Ok(Vec::new()) };
        let mut all = Vec::new();
        for (k, output) in weights.outputs.iter().enumerate() {
            let ProcessModel::Gp(process) = output else { return Ok(Vec::new()) };
            let gp = Gp::from_model(process)?;
            let left_out = gp.leave_one_out()?;
            let of = |i: usize| (gp.outputs()[i] - left_out.mean[i]) / left_out.variance[i].sqrt();
            let residuals = (0..gp.outputs().len()).map(of).collect();
            let report = weights.learning.as_ref().map(|reports| &reports[k]);
            let condition_number = gp.condition_number();
            let name = OUTPUTS[k];
            all.push(Self { name, gp, report, left_out, residuals, condition_number });
        }
        Ok(all)
    }

    fn starts(&self) -> &[StartReport] {
        self.report.map_or(&[], |report| &report.starts)
    }

    /// The most that a start reached, in nats.
    fn best(&self) -> f64 {
        let ends = self.starts().iter().filter_map(|start| start.history.last());
        ends.copied().fold(f64::NEG_INFINITY, f64::max)
    }

    /// Starts that found the best.
    fn found(&self) -> impl Iterator<Item = &StartReport> {
        let best = self.best();
        let is_it =
            move |start: &&StartReport| start.history.last().is_some_and(|last| best - last < SAME);
        self.starts().iter().filter(is_it)
    }

    /// The gradient where learning ended, in nats per log-parameter.
    fn gradient(&self) -> Option<f64> {
        let norms = self.found().map(|start| start.gradient_norm);
        norms.min_by(f64::total_cmp)
    }

    fn at_bound(&self) -> &[String] {
        self.report.map_or(&[], |report| &report.at_bound)
    }

    fn rms(&self) -> f64 {
        let squares: f64 = self.residuals.iter().map(|residual| residual * residual).sum();
        (squares / self.residuals.len() as f64).sqrt()
    }

    /// The share of rows within intervals of a level.
    fn share(&self, level: f64) -> f64 {
        let reach = if level < 1.0 { normal(0.5 + 0.5 * level) } else { f64::INFINITY };
        let within = |residual: &&f64| residual.abs() <= reach;
        self.residuals.iter().filter(within).count() as f64 / self.residuals.len() as f64
    }

    fn row(&self) -> Vec<String> {
        let unknown = || "not told".to_owned();
        let found = match self.starts() {
            [] => unknown(),
            starts => format!("{} of {}", self.found().count(), starts.len()),
        };
        let at_bound = match self.report {
            None => unknown(),
            Some(_) if self.at_bound().is_empty() => "none".to_owned(),
            Some(_) => self.at_bound().join(", "),
        };
        vec![
            self.name.to_owned(),
            self.residuals.len().to_string(),
            format!("{:.1}", self.gp.log_marginal_likelihood()).replace('-', "−"),
            self.gradient().map_or_else(unknown, |norm| format!("{norm:.1e}")),
            found,
            format!("{:.0e}", self.condition_number),
            at_bound,
            format!("{:.2}", self.rms()),
            LEVELS.map(|level| format!("{:.0}", 100.0 * self.share(level))).join(", ") + " %",
        ]
    }

    /// What is not as it should be.
    fn doubts(&self) -> Vec<String> {
        let mut doubts = Vec::new();
        if let Some(norm) = self.gradient().filter(|norm| *norm > STEEP) {
            doubts.push(format!("its gradient is {norm:.1} nats: learning ended before a maximum"));
        }
        if self.starts().len() > 1 && self.found().count() == 1 {
            doubts.push("one start alone found its maximum: another may be higher".to_owned());
        }
        if !self.at_bound().is_empty() {
            let names = self.at_bound().join(", ");
            doubts.push(format!("{names} ended at a bound: the rows do not tell it"));
        }
        let number = self.condition_number;
        if number > ILL_CONDITIONED {
            doubts.push(format!("its covariance has a condition number of {number:.0e}"));
        }
        let rms = self.rms();
        if !(HONEST[0]..=HONEST[1]).contains(&rms) {
            let word = if rms > 1.0 { "too small" } else { "too large" };
            doubts.push(format!("its residuals are {rms:.2} sd: variances are {word}"));
        }
        let within = self.share(0.5);
        let chance = (0.25 / self.residuals.len() as f64).sqrt();
        if within - 0.5 > BEYOND_CHANCE * chance {
            let percent = 100.0 * within;
            doubts.push(format!(
                "{percent:.0} % of its rows are within intervals of 50 %: most err less than a normal number \
                 would, and a few far more"
            ));
        }
        doubts
    }

    fn drawing(&self, (name, panel, told): Chart) -> Result<Drawing> {
        let figure = Figure::new(1, 1)
            .panel_size(300.0, 210.0)
            .named(&format!("{name}-{}", self.name))
            .with(panel(self).title(&format!("{}, {name}", self.name)));
        Ok(Drawing::new(&figure, &format!("{}: {}.", self.name, told(self)))?)
    }

    fn optimiser_in_words(&self) -> String {
        match self.starts() {
            [] => "the weights do not tell how it was learnt".to_owned(),
            starts => format!("{} of {} starts found the best", self.found().count(), starts.len()),
        }
    }

    fn residuals_in_words(&self) -> String {
        let far = self.residuals.iter().filter(|residual| residual.abs() > FAR).count();
        let (rms, n) = (self.rms(), self.residuals.len());
        format!("residuals are {rms:.2} sd large, {far} of {n} beyond {FAR}")
    }

    fn quantiles_in_words(&self) -> String {
        let [low, high] =
            [f64::min, f64::max].map(|of| self.residuals.iter().copied().fold(0.0, of));
        format!("residuals from {low:.1} to {high:.1} sd; normal numbers lie on the line")
            .replace('-', "−")
    }

    fn coverage_in_words(&self) -> String {
        let [half, most] = [0.5, 0.9].map(|level| 100.0 * self.share(level));
        format!("{half:.0} % of rows are within intervals of 50 %, {most:.0} % within 90 %")
    }

    /// Nats below the best end, over iterations.
    fn optimisation(&self) -> Panel {
        const LEAST: f64 = 1e-4;
        let best = self.best();
        let panel = Panel::new(Axis::new("iteration"), Axis::new("below the best / nats").log())
            .legend(LegendPlace::Hidden);
        let found = self.found().count();
        self.starts().iter().fold(panel, |panel, start| {
            let below = |value: &f64| (best - value).max(LEAST);
            let y: Vec<f64> = start.history.iter().map(below).collect();
            let x: Vec<f64> = (0..y.len()).map(|k| k as f64).collect();
            let is_found = start.history.last().is_some_and(|last| best - last < SAME);
            let color = if is_found || found == 0 { Color::BLUE } else { Color::GRAY };
            panel.with(Line::new(&x, &y).color(color).width(1.4))
        })
    }

    fn over_predictions(&self) -> Panel {
        let n = self.residuals.len();
        let every = n.div_ceil(MOST_DRAWN);
        let places: Vec<usize> =
            (0..n).filter(|i| i.is_multiple_of(every) || self.residuals[*i].abs() > FAR).collect();
        let at = |i: &usize| [self.left_out.mean[*i], self.residuals[*i]];
        let points: Vec<[f64; 2]> = places.iter().map(at).collect();
        let mut hover = Hover::new();
        for i in places.iter().filter(|i| self.residuals[**i].abs() > FAR) {
            let text = format!(
                "row {}: observed {:.4}\npredicted {:.4} ± {:.4}\n{:.1} sd",
                i + 1,
                self.gp.outputs()[*i],
                self.left_out.mean[*i],
                self.left_out.variance[*i].sqrt(),
                self.residuals[*i]
            );
            hover = hover.disc(at(i), 6.0, &text);
        }
        Panel::new(Axis::new("predicted, per m of way"), Axis::new("residual / sd"))
            .legend(LegendPlace::Hidden)
            .with(Guide::horizontal(0.0))
            .with(Points::at(&points).color(Color::BLUE).radius(1.6))
            .with(hover)
    }

    fn quantiles(&self) -> Panel {
        let mut sorted = self.residuals.clone();
        sorted.sort_by(f64::total_cmp);
        let n = sorted.len() as f64;
        let expected: Vec<f64> = (0..sorted.len()).map(|i| normal((i as f64 + 0.5) / n)).collect();
        let ends = [expected[0], expected[expected.len() - 1]];
        Panel::new(Axis::new("normal quantile"), Axis::new("residual / sd"))
            .legend(LegendPlace::Hidden)
            .with(Line::new(&ends, &ends).color(Color::GRAY).width(1.0))
            .with(Line::new(&expected, &sorted).color(Color::BLUE).width(1.8))
    }

    fn coverage(&self) -> Panel {
        const N: usize = 41;
        let levels: Vec<f64> = (0..N).map(|k| k as f64 / (N - 1) as f64).collect();
        let shares: Vec<f64> = levels.iter().map(|level| self.share(*level)).collect();
        let axis = |label: &str| Axis::new(label).range(0.0, 1.0);
        Panel::new(axis("level of the interval"), axis("share of rows within"))
            .legend(LegendPlace::Hidden)
            .with(Line::new(&[0.0, 1.0], &[0.0, 1.0]).color(Color::GRAY).width(1.0))
            .with(Line::new(&levels, &shares).color(Color::BLUE).width(1.8))
    }
}

/// The doubts of all outputs in a sentence or some.
fn looked_at_twice(learnt: &[Learnt<'_>]) -> String {
    let doubts = learnt.iter().flat_map(|one| {
        one.doubts().into_iter().map(move |doubt| format!("{}: {doubt}", one.name))
    });
    let doubts: Vec<String> = doubts.collect();
    match doubts[..] {
        [] => "Nothing speaks against what was learnt.".to_owned(),
        _ => format!("To be looked at twice: {}.", doubts.join("; ")),
    }
}
