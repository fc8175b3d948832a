//! Physics alone on the one-step pushes: feet, caught tips and scatter, in folds of whole runs.

use std::fmt::Write;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use dataset::{ObjectChoice, StepRow, TableMapping};
use diagnosis::{FitSettings, MotionErrors, Observations, fit_per_push};
use effects::{Effect, FrictionCenterOffset, Setting};
use models::{
    Analytical, ChannelModel, ChannelObservation, Description, ModelEffect, PushModel,
    StepSelection,
};
use report::{Color, Ellipse, Figure, Panel, Points, Polygon};

use super::plain_fit::{feet, fitted};

/// Which rows of a table without ids are steps of one push: `runs.csv` beside it, a line for each row.
#[derive(serde::Deserialize)]
struct Run {
    row: usize,
    run: u32,
    fold: usize,
}

/// What is added one after the other, and the words for it.
const STEPS: [(&str, &[&str]); 4] = [
    ("μp and c fitted", &["pusher-friction", "pressure-radius"]),
    ("four support points instead of c", &["pusher-friction", "support-points"]),
    ("and the tip caught at a vertex", &["pusher-friction", "support-points", "vertex-contact"]),
    ("and a center of friction that differs from push to push", &[]),
];
const TAILS: f64 = 4.0;

/// What is left of the errors with everything up to one of [`STEPS`], on pushes that no fit has seen.
#[derive(Clone, Copy, Default)]
struct Left {
    squares: [f64; 3],
    /// Sums of log densities over three channels: with normal errors, and with Student's t.
    densities: [f64; 2],
}

/// The study.
pub(super) struct Supports {
    n: usize,
    variances: [f64; 3],
    left: [Left; STEPS.len()],
    /// The points of each fold: x and y in m, and the share.
    feet: Vec<Vec<[f64; 3]>>,
    outline: Vec<[f64; 2]>,
    /// Of each fold: standard deviation of the center of friction from push to push and from place to place, in m.
    spreads: Vec<[f64; 2]>,
}

struct Table {
    mapping: TableMapping,
    observations: Observations,
    steps: Vec<ChannelObservation>,
    /// Of each row's push.
    names: Vec<String>,
}

impl Supports {
    /// Fits in each fold to the others, one addition after the other.
    ///
    /// # Errors
    /// Files that cannot be read; what a fit says.
    pub(super) fn of(table: &Path) -> Result<Self> {
        let runs = table.with_file_name("runs.csv");
        let mut reader = csv::Reader::from_path(&runs)
            .with_context(|| format!("cannot read {}", runs.display()))?;
        let mut folds: Vec<Run> = reader.deserialize().collect::<Result<_, _>>()?;
        let table = Table::read(table, &runs, &mut folds)?;
        let outline = table.steps[0].input.object.shape().outline(4);
        let mut found = Self {
            n: table.steps.len(),
            variances: table.variances(),
            left: Default::default(),
            feet: Vec::new(),
            outline: outline.iter().map(|place| [place.x, place.y]).collect(),
            spreads: Vec::new(),
        };
        let n_folds = 1 + folds.iter().map(|run| run.fold).max().unwrap_or_default();
        for fold in 0..n_folds {
            let (held, train): (Vec<usize>, Vec<usize>) =
                (0..folds.len()).partition(|row| folds[*row].fold == fold);
            found.add(&table, &train, &held)?;
            println!("fold {} of {n_folds}", fold + 1);
        }
        Ok(found)
    }

    fn add(&mut self, table: &Table, train: &[usize], held: &[usize]) -> Result<()> {
        let (fitted_to, tested) = (table.part(train)?, table.part(held)?);
        let mut model = Analytical::nominal(table.mapping.pusher.friction)?.describe()?;
        for (step, (_, free)) in STEPS.iter().enumerate() {
            model = match free.is_empty() {
                true => {
                    let about = FrictionCenterOffset.info();
                    model.effects.push(ModelEffect::from(Setting::new(about, &[0.0, 0.0])));
                    let settings = FitSettings {
                        priors: false,
                        resemblances: false,
                        ..FitSettings::default()
                    };
                    let found = fit_per_push(&fitted_to, &model, about.id, &settings)?;
                    let sd = |spread| match spread {
                        effects::Spread::Sd(sd) | effects::Spread::RelativeSd(sd) => sd,
                    };
                    self.spreads.push([found.per_push, found.per_place].map(sd));
                    found.fit.description
                }
                false => fitted(&fitted_to, model, free)?,
            };
            let left = &mut self.left[step];
            for (square, more) in left.squares.iter_mut().zip(table.squares(&model, held)?) {
                *square += more;
            }
            for (sum, tails) in left.densities.iter_mut().zip([None, Some(TAILS)]) {
                let errors = MotionErrors::learn(&fitted_to, &model, &[], tails)?;
                *sum += errors.log_densities(&tested, &model, &[])?.iter().sum::<f64>();
            }
        }
        self.feet.extend(feet(&model));
        Ok(())
    }

    /// The section of the page.
    pub(super) fn text(&self) -> String {
        let mut text = HEAD.to_owned();
        for ((name, _), left) in STEPS.iter().zip(&self.left) {
            let of = |k: usize| left.squares[k] / self.n as f64 / self.variances[k];
            let mean = (0..3).map(of).sum::<f64>() / 3.0;
            let [normal, student] = left.densities.map(|sum| sum / (3 * self.n) as f64);
            let [dx, dy, dtheta] = [0, 1, 2].map(of);
            let _ = writeln!(
                text,
                "| {name} | {mean:.4} | {dx:.4} | {dy:.4} | {dtheta:.4} | {normal:.3} | {student:.3} |"
            );
        }
        let of = |k: usize| {
            let all = self.spreads.iter().map(|sd| format!("{:.1}", 1e3 * sd[k]));
            all.collect::<Vec<String>>().join(", ")
        };
        let _ = writeln!(
            text,
            "\nThe center of friction differs from push to push by {} mm in each direction (standard \
             deviation, by fold), and from place to place, faster than a step, by {} mm.\n\n![Feet of five folds under the square](real-data-feet.svg)\n\n\
             The points of each fold, their area by the share that they bear. Folds share most of their rows: \
             that they agree does not make the places unique, for other points have nearly the same limit \
             surface.\n",
            of(0),
            of(1)
        );
        text
    }

    /// The outline with the feet of each fold.
    pub(super) fn picture(&self) -> Result<String> {
        let mm = |place: &[f64; 2]| place.map(|x| 1e3 * x);
        let outline: Vec<[f64; 2]> = self.outline.iter().map(mm).collect();
        let mut panel = Panel::new("body x in mm", "body y in mm").with(Polygon::new(&outline));
        for (fold, feet) in self.feet.iter().enumerate() {
            let color = Color::cycle(fold);
            for [x, y, share] in feet {
                // 8 mm for the whole weight.
                let radius = 8.0 * share.sqrt();
                panel = panel.with(Ellipse::circle([1e3 * x, 1e3 * y], radius).fill(color, 0.45));
            }
            let center =
                [0, 1].map(|k| feet.iter().map(|foot| 1e3 * foot[k] * foot[2]).sum::<f64>());
            panel =
                panel.with(Points::at(&[center]).color(color).label(&format!("fold {}", fold + 1)));
        }
        Ok(Figure::new(1, 1).panel_size(460.0, 460.0).with(panel).svg()?)
    }
}

const HEAD: &str = "
## Physics alone on the one-step pushes

Where the square rests and what else a push meets, added one after the other and fitted to four of five
folds of whole runs (`runs.csv` says which rows are steps of one push); errors of the fifth, together.

```text
cargo xtask real-comparison --data DIR --only supports
pushlab add support-points --fit mit-push-table/table.csv --preset mit-table --model nominal.toml -o points.toml
pushlab add vertex-contact --fit mit-push-table/table.csv --preset mit-table --model points.toml -o caught.toml
pushlab add friction-center-offset --per-push --fit mit-push-table/table.csv --preset mit-table --model caught.toml -o wanders.toml
```

Squared error over variance, and mean log density of a channel (in m, m and rad, nats): of all steps of a run
together, which share what differs from push to push and an error of their own, with normal errors and with
Student's t of four degrees.

| model | error²/variance | Δx | Δy | Δθ | density, normal | density, t |
|---|---|---|---|---|---|---|
";

impl Table {
    /// The table with the steps of each run together, and `runs` in its order.
    fn read(path: &Path, of: &Path, runs: &mut [Run]) -> Result<Self> {
        let mapping = TableMapping::mit_table()?;
        let mut table = mapping.read_table(path)?;
        let n = table.rows.len();
        ensure!(
            runs.len() == n && runs.iter().enumerate().all(|(k, run)| run.row == k),
            "{}: a row for each of the table's {n} is needed, in order",
            of.display()
        );
        runs.sort_by_key(|run| (run.run, run.row));
        let row = |run: &Run| StepRow { push: run.run, ..table.rows[run.row].clone() };
        table.rows = runs.iter().map(row).collect();
        let observations = Observations::of_rows(&table, &mapping)?;
        let objects = ObjectChoice::Fixed(Box::new(mapping.object.clone()));
        let found =
            StepSelection::default().channel_steps(&table, &objects, mapping.pusher.radius)?;
        ensure!(found.steps.len() == n, "{}: not every row is a step", path.display());
        let name = |row: &StepRow| format!("{}#{}", row.recording, row.push);
        let names = table.rows.iter().map(name).collect();
        Ok(Self { mapping, observations, steps: found.steps, names })
    }

    /// The pushes of some rows.
    fn part(&self, rows: &[usize]) -> Result<Observations> {
        let mut names: Vec<String> = rows.iter().map(|row| self.names[*row].clone()).collect();
        names.dedup();
        Ok(self.observations.part(&names)?)
    }

    fn variances(&self) -> [f64; 3] {
        [0, 1, 2].map(|k| {
            let values: Vec<f64> = self.steps.iter().filter_map(|step| step.observed[k]).collect();
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / values.len() as f64
        })
    }

    /// Sums of squared errors over some rows.
    fn squares(&self, model: &Description, rows: &[usize]) -> Result<[f64; 3]> {
        let channels = ChannelModel::new(model, self.mapping.support, &[])?;
        let predicted = channels.predict(rows.iter().map(|row| &self.steps[*row].input))?;
        let mut sums = [0.0; 3];
        for (row, predicted) in rows.iter().zip(predicted) {
            for (k, sum) in sums.iter_mut().enumerate() {
                let miss = self.steps[*row].observed[k].map(|is| is - predicted.to_array()[k]);
                *sum += miss.unwrap_or_default().powi(2);
            }
        }
        Ok(sums)
    }
}
