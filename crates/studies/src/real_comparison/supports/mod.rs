//! Physics alone on the one-step pushes: feet, caught tips and scatter, in folds of whole runs.

mod table;

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::path::Path;

use anyhow::Result;
use diagnosis::{FitSettings, MotionErrors, SupportPointsFit, fit_per_push};
use effects::{Effect, FrictionCenterOffset, Setting};
use models::{Analytical, Description, ModelEffect, Noise, PushModel, StepInput, StepObservation};
use report::{
    Axis, Bars, Color, Ellipse, ErrorBars, Figure, Guide, LegendPlace, Panel, Points, Polygon,
};

use self::table::{Squares, Table};
use super::plain_fit::{feet, fit};
use crate::learned_kinds::{GP, KINDS};

/// What is done to the model before.
enum Addition {
    /// Nothing.
    Nominal,
    /// A fit of these effects.
    Fitted(&'static [&'static str]),
    /// A fit of how much the center of friction differs.
    PerPush,
    /// What that fit left open.
    Nuisances,
}

/// A model of the study.
struct Stage {
    /// For the table.
    name: &'static str,
    /// Under its bar.
    label: &'static str,
    addition: Addition,
}

const STAGES: [Stage; 6] = [
    Stage { name: "nothing fitted", label: "nominal", addition: Addition::Nominal },
    Stage {
        name: "μp and c fitted",
        label: "μp, c fitted",
        addition: Addition::Fitted(&["pusher-friction", "pressure-radius"]),
    },
    Stage {
        name: "five support points instead of c",
        label: "five feet",
        addition: Addition::Fitted(&["pusher-friction", "support-points"]),
    },
    Stage {
        name: "and the tip caught at a vertex",
        label: "+ caught tip",
        addition: Addition::Fitted(&["pusher-friction", "support-points", "vertex-contact"]),
    },
    Stage {
        name: "and a center of friction that differs from push to push",
        label: "+ center wanders",
        addition: Addition::PerPush,
    },
    Stage {
        name: "and the nuisances of that fit: tip and tracked frame",
        label: "+ nuisances",
        addition: Addition::Nuisances,
    },
];
const POINTS: SupportPointsFit = SupportPointsFit { n: 5, by_statics: false };
const TAILS: f64 = 4.0;

/// What is left of the errors by a model, on pushes that its fit has not seen.
#[derive(Clone)]
struct Left {
    /// By row.
    squares: Vec<Squares>,
    /// Sums of log densities over three channels: with normal errors, and with Student's t.
    densities: [f64; 2],
}

/// Squared error over variance.
#[derive(Clone, Copy)]
struct Nmse {
    /// Of the three outputs.
    mean: f64,
    /// Standard error of the mean, from whole runs.
    se: f64,
    of: [f64; 3],
}

/// The study.
pub(super) struct Supports {
    variances: [f64; 3],
    /// The run of each row.
    runs: Vec<u32>,
    left: Vec<Left>,
    /// By a Gaussian process with all other rows.
    learned: Vec<Squares>,
    /// Of rows of different runs that begin alike, beside the last fold's model, in the unit of each output squared.
    floor: Squares,
    /// The points of each fold: x and y in m, and the share.
    feet: Vec<Vec<[f64; 3]>>,
    outline: Vec<[f64; 2]>,
    /// Of each fold: standard deviation of the center of friction from push to push and from place to place, in m.
    spreads: Vec<[f64; 2]>,
}

impl Supports {
    /// Fits in each fold to the others, one addition after the other.
    ///
    /// # Errors
    /// Files that cannot be read; what a fit says.
    pub(super) fn of(table: &Path) -> Result<Self> {
        let table = Table::read(table)?;
        let outline = table.mapping.object.shape.outline(4);
        let n = table.runs.len();
        let none = Left { squares: vec![[0.0; 3]; n], densities: [0.0; 2] };
        let mut found = Self {
            variances: table.variances(),
            runs: table.runs.iter().map(|run| run.run).collect(),
            left: vec![none; STAGES.len()],
            learned: vec![[0.0; 3]; n],
            floor: [0.0; 3],
            feet: Vec::new(),
            outline: outline.iter().map(|place| [place.x, place.y]).collect(),
            spreads: Vec::new(),
        };
        let folds: BTreeSet<usize> = table.runs.iter().map(|run| run.fold).collect();
        for (k, fold) in folds.iter().enumerate() {
            let (held, train): (Vec<usize>, Vec<usize>) =
                (0..n).partition(|row| table.runs[*row].fold == *fold);
            let model = found.add(&table, &train, &held)?;
            found.learn(&table, &train, &held)?;
            if Some(fold) == folds.last() {
                found.floor = table.floor(&model)?;
            }
            println!("fold {} of {}", k + 1, folds.len());
        }
        Ok(found)
    }

    /// The last model.
    fn add(&mut self, table: &Table, train: &[usize], held: &[usize]) -> Result<Description> {
        let (fitted_to, tested) = (table.part(train)?, table.part(held)?);
        let mut model = Analytical::nominal(table.mapping.pusher.friction)?.describe()?;
        let mut nuisances = None;
        for (Stage { addition, .. }, left) in STAGES.iter().zip(&mut self.left) {
            model = match addition {
                Addition::Nominal => model,
                Addition::Fitted(free) => fit(&fitted_to, model, free, POINTS)?.description,
                Addition::Nuisances => nuisances.take().unwrap_or(model),
                Addition::PerPush => {
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
                    nuisances = Some(found.fit.with_nuisances);
                    found.fit.description
                }
            };
            let told = table.predicted(&model, held)?;
            for (row, squares) in held.iter().zip(table.squares(told.into_iter(), held)) {
                left.squares[*row] = squares;
            }
            for (sum, tails) in left.densities.iter_mut().zip([None, Some(TAILS)]) {
                let errors = MotionErrors::learn(&fitted_to, &model, &[], tails)?;
                *sum += errors.log_densities(&tested, &model, &[])?.iter().sum::<f64>();
            }
        }
        self.feet.extend(feet(&model));
        Ok(model)
    }

    fn learn(&mut self, table: &Table, train: &[usize], held: &[usize]) -> Result<()> {
        let nominal = Analytical::nominal(table.mapping.pusher.friction)?;
        let steps: Vec<StepObservation> =
            train.iter().map(|row| table.motions[*row].clone()).collect();
        let model = (KINDS[GP].train)(&nominal, &steps)?;
        let inputs: Vec<StepInput> =
            held.iter().map(|row| table.motions[*row].input.clone()).collect();
        let told = model.predict(&inputs, Noise::Excluded)?.into_iter().map(|told| told.mean);
        for (row, squares) in held.iter().zip(table.squares(told, held)) {
            self.learned[*row] = squares;
        }
        Ok(())
    }

    /// Squares over the variances of the outputs, and the mean of the three.
    fn relative(&self, squares: Squares) -> (f64, [f64; 3]) {
        let of = std::array::from_fn(|k| squares[k] / self.variances[k]);
        (of.iter().sum::<f64>() / 3.0, of)
    }

    fn error(&self, squares: &[Squares]) -> Nmse {
        let n = squares.len() as f64;
        let sum = |k: usize| squares.iter().map(|of_row| of_row[k]).sum::<f64>() / n;
        let (mean, of) = self.relative([0, 1, 2].map(sum));
        let mut runs: BTreeMap<u32, f64> = BTreeMap::new();
        for (run, of_row) in self.runs.iter().zip(squares) {
            *runs.entry(*run).or_default() += self.relative(*of_row).0 - mean;
        }
        let se = runs.values().map(|sum| sum * sum).sum::<f64>().sqrt() / n;
        Nmse { mean, se, of }
    }

    /// The section of the page.
    pub(super) fn text(&self) -> String {
        let mut text = HEAD.to_owned();
        let mut row = |name: &str, error: Nmse, [normal, student]: [String; 2]| {
            let Nmse { mean, se, of: [dx, dy, dtheta] } = error;
            let _ = writeln!(
                text,
                "| {name} | {mean:.4} ± {se:.4} | {dx:.4} | {dy:.4} | {dtheta:.4} | {normal} | {student} |"
            );
        };
        for (stage, left) in STAGES.iter().zip(&self.left) {
            let n = (3 * left.squares.len()) as f64;
            let densities = left.densities.map(|sum| format!("{:.3}", sum / n));
            row(stage.name, self.error(&left.squares), densities);
        }
        let none = [const { String::new() }; 2];
        row("a Gaussian process with all rows of the other folds", self.error(&self.learned), none);
        let (floor, [dx, dy, dtheta]) = self.relative(self.floor);
        let _ = writeln!(
            text,
            "| *what rows of different runs that begin alike differ by* | *{floor:.4}* | *{dx:.4}* | \
             *{dy:.4}* | *{dtheta:.4}* | | |"
        );
        let of = |k: usize| {
            let all = self.spreads.iter().map(|sd| format!("{:.1}", 1e3 * sd[k]));
            all.collect::<Vec<String>>().join(", ")
        };
        let _ = writeln!(
            text,
            "\n![The error, falling with each addition](real-data-error.svg)\n\n\
             The mean of the three outputs; whiskers are one standard error, from whole runs; dashed is what \
             rows of different runs that begin alike differ by.\n\n\
             The center of friction differs from push to push by {} mm in each direction (standard \
             deviation, by fold), and from place to place, faster than a step, by {} mm.\n\n![Feet of five folds under the square](real-data-feet.svg)\n\n\
             The points of each fold, their area by the share that they bear. Folds share most of their rows: \
             that they agree does not make the places unique, for other points have nearly the same limit \
             surface.\n",
            of(0),
            of(1)
        );
        text
    }

    /// A bar for each model, beside a process that learns and the scatter.
    pub(super) fn falling(&self) -> Result<String> {
        let mut bars: Vec<(&str, Nmse, Color)> = STAGES
            .iter()
            .zip(&self.left)
            .map(|(stage, left)| (stage.label, self.error(&left.squares), Color::BLUE))
            .collect();
        bars[0].2 = Color::GRAY;
        bars.push(("GP, all rows", self.error(&self.learned), Color::GREEN));
        let names: Vec<(f64, String)> =
            bars.iter().enumerate().map(|(k, (name, ..))| (k as f64, (*name).to_owned())).collect();
        let top = bars.iter().map(|(_, error, _)| error.mean + error.se).fold(0.0, f64::max);
        let x = Axis::new("").range(-0.6, bars.len() as f64 - 0.4).names(&names);
        let y = Axis::new("squared error / variance").range(0.0, 1.08 * top);
        let mut panel = Panel::new(x, y).legend(LegendPlace::Hidden);
        for (k, (_, Nmse { mean, se, .. }, color)) in bars.into_iter().enumerate() {
            let x = [k as f64];
            panel = panel.with(Bars::new(&x, &[mean], 0.6).color(color));
            panel = panel.with(ErrorBars::new(&x, &[mean - se], &[mean + se]).color(Color::INK));
        }
        let floor = Guide::horizontal(self.relative(self.floor).0);
        let panel = panel.with(floor.color(Color::ORANGE).width(1.8).dashed());
        Ok(Figure::new(1, 1).panel_size(760.0, 260.0).with(panel).svg()?)
    }

    /// The outline with the feet of each fold.
    pub(super) fn feet(&self) -> Result<String> {
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
folds of whole runs (`runs.csv` says which rows are steps of one push); errors of the fifth, together, beside
those of an exact Gaussian process of (p, β) that learns from the same folds.

```text
cargo xtask real-comparison --data DIR --only supports
pushlab add support-points --fit mit-push-table/table.csv --preset mit-table --points 5 --model nominal.toml -o points.toml
pushlab add vertex-contact --fit mit-push-table/table.csv --preset mit-table --model points.toml -o caught.toml
pushlab add friction-center-offset --per-push --nuisances --fit mit-push-table/table.csv --preset mit-table --model caught.toml -o wanders.toml
```

Squared error over variance, and mean log density of a channel (in m, m and rad, nats): of all steps of a run
together, which share what differs from push to push and an error of their own, with normal errors and with
Student's t of four degrees.

| model | error²/variance | Δx | Δy | Δθ | density, normal | density, t |
|---|---|---|---|---|---|---|
";
