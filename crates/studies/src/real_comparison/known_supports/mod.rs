//! Pushes of an object that stands on known feet: are they found?

mod diagnosed;

use std::fmt::Write;
use std::path::Path;

use anyhow::{Context, Result};
use dataset::{IngestSettings, Preset, RecordingSet, ingest};
use diagnosis::{Fit, Observations, ParameterFit, Predictions, SupportPointsFit};
use models::{Analytical, Description, PushModel};
use nalgebra::{Matrix3, Vector2, Vector3};
use report::{Color, Ellipse, Figure, Panel, Points, Polygon};

use self::diagnosed::Diagnosed;
use super::plain_fit::{feet, fit, fitted};

/// The sets and their feet, in m, by Zhou, Paolini, Bagnell & Mason (2016); none for the whole face.
const SETS: [(&str, Option<[[f64; 2]; 3]>); 5] = [
    ("corners", Some([[0.010, 0.010], [0.130, 0.010], [0.010, 0.130]])),
    ("uneven", Some([[0.010, 0.010], [0.090, 0.030], [0.010, 0.130]])),
    ("middle", Some([[0.030, 0.030], [0.090, 0.030], [0.030, 0.090]])),
    ("near-center", Some([[0.030, 0.030], [0.063_33, 0.043_33], [0.043_33, 0.063_33]])),
    ("full-face", None),
];
const N_FOLDS: usize = 5;
/// What is fitted: the pusher's friction, where the tracked frame is in the object, and points.
const FREE: [&str; 3] = ["pusher-friction", "pose-offset", "support-points"];
/// Four points of which nothing is known, and three that share the weight by statics.
const POINTS: [SupportPointsFit; 2] =
    [SupportPointsFit { n: 4, by_statics: false }, SupportPointsFit { n: 3, by_statics: true }];

/// What is known and what is found of one set.
pub(super) struct Known {
    name: &'static str,
    /// Places and shares.
    feet: Vec<[f64; 3]>,
    /// By each of [`POINTS`].
    found: [Found; 2],
    /// Center of friction x and y, and c, in m.
    truth: [f64; 3],
    /// Squared errors over variances of held-out motions: of the nominal model, with fitted friction and
    /// frame, with each of [`POINTS`].
    nmse: [f64; 4],
    outline: Vec<[f64; 2]>,
    /// What is claimed by the diagnosis alone.
    diagnosed: Diagnosed,
}

/// What a fit of points to all pushes finds.
struct Found {
    /// Places and shares.
    feet: Vec<[f64; 3]>,
    /// Center of friction x and y, and c, in m.
    follows: Vec<ParameterFit>,
    pusher_friction: f64,
}

/// Fits each set, to all its pushes and in folds.
///
/// # Errors
/// Sets that cannot be read; what a fit says.
pub(super) fn known_supports(folder: &Path) -> Result<Vec<Known>> {
    SETS.into_iter().map(|(name, feet)| Known::of(folder, name, feet).context(name)).collect()
}

impl Known {
    fn of(folder: &Path, name: &'static str, feet_o: Option<[[f64; 2]; 3]>) -> Result<Self> {
        let set = RecordingSet::open_with_preset(&folder.join(name), Preset::CmuKnownSupports)?;
        let (table, _) = ingest(&set, &IngestSettings::default())?;
        let manifest = set.manifest();
        let all = Observations::of(&table, manifest)?;
        let nominal = Analytical::nominal(manifest.pusher.friction)?.describe()?;
        let on_points = |train: &Observations, points| fit(train, nominal.clone(), &FREE, points);
        let names: Vec<String> = all.pushes().iter().map(ToString::to_string).collect();
        let (mut squares, mut values) = ([[0.0; 3]; 4], [const { Vec::new() }; 3]);
        for fold in 0..N_FOLDS {
            let part = |is_in: bool| {
                let part = names.iter().enumerate().filter(|(k, _)| (k % N_FOLDS == fold) == is_in);
                all.part(&part.map(|(_, name)| name.clone()).collect::<Vec<_>>())
            };
            let (train, aside) = (part(false)?, part(true)?);
            let friction = fitted(&train, nominal.clone(), &FREE[..2])?;
            let [free, by_statics] = POINTS.map(|points| on_points(&train, points));
            for step in aside.steps() {
                for (values, observed) in values.iter_mut().zip(step.observed) {
                    values.extend(observed);
                }
            }
            let models = [&nominal, &friction, &free?.description, &by_statics?.description];
            for (sums, model) in squares.iter_mut().zip(models) {
                add_squares(sums, model, &aside)?;
            }
        }
        let of_variance = |sums: [f64; 3]| {
            (0..3).map(|k| sums[k] / squares_about_mean(&values[k])).sum::<f64>() / 3.0
        };
        let [free, by_statics] = POINTS.map(|points| Found::of(on_points(&all, points)?));
        let object = &all.steps().first().context("no pushes")?.input.object;
        let (feet_o, truth) = match feet_o {
            Some(feet) => standing(feet, object.centroid())?,
            None => {
                let center = object.centroid();
                (Vec::new(), [center.x, center.y, object.mean_distance()])
            }
        };
        Ok(Self {
            name,
            feet: feet_o,
            truth,
            found: [free?, by_statics?],
            nmse: squares.map(of_variance),
            diagnosed: Diagnosed::of(&all, &nominal)?,
            outline: object.shape().outline(4).iter().map(|place| [place.x, place.y]).collect(),
        })
    }

    fn row(&self) -> String {
        let [nominal, friction, free, by_statics] = self.nmse;
        let mut row = format!(
            "| {} | {nominal:.3} | {friction:.3} | {free:.3} | {by_statics:.3} | {:.2}",
            self.name, self.found[0].pusher_friction
        );
        let told = |found: &Found, k: usize| {
            let ParameterFit { value, interval, .. } = found.follows[k];
            let ends = interval.map_or("–".to_owned(), |interval| {
                format!("{:.1} to {:.1}", 1e3 * interval.low95, 1e3 * interval.high95)
            });
            format!("{:.1} ({ends})", 1e3 * value)
        };
        for (k, truth) in self.truth.iter().enumerate() {
            let _ = write!(row, " | {} for {:.1}", told(&self.found[0], k), 1e3 * truth);
        }
        let _ = write!(row, " | {}", told(&self.found[1], 2));
        row + " |\n"
    }
}

impl Found {
    fn of(fit: Fit) -> Result<Self> {
        let feet = feet(&fit.description).context("no points")?;
        let of = |id: &str| fit.effects.iter().find(|effect| effect.id == id);
        let friction = of(FREE[0]).and_then(|effect| effect.parameters.first());
        Ok(Self {
            feet,
            follows: of(FREE[2]).context("no points")?.follows.clone(),
            pusher_friction: friction.context("no friction")?.value,
        })
    }

    /// Distance of the center from the true one, in m, and ratio of the mean distances.
    fn off(&self, truth: &[f64; 3]) -> (f64, f64) {
        let of = |k: usize| self.follows[k].value - truth[k];
        (of(0).hypot(of(1)), self.follows[2].value / truth[2])
    }

    /// Whether the 95 % interval of one of the three numbers holds it.
    fn holds(&self, truth: &[f64; 3], k: usize) -> bool {
        let interval = self.follows[k].interval;
        interval.is_some_and(|range| (range.low95..=range.high95).contains(&truth[k]))
    }
}

/// Feet with the shares that a rigid object has, its center of friction and c.
fn standing(feet: [[f64; 2]; 3], center: &Vector2<f64>) -> Result<(Vec<[f64; 3]>, [f64; 3])> {
    let moments = Matrix3::from_fn(|row, foot| if row < 2 { feet[foot][row] } else { 1.0 });
    let shares = moments.lu().solve(&Vector3::new(center.x, center.y, 1.0));
    let shares = shares.context("feet in a line")?;
    let feet: Vec<[f64; 3]> =
        feet.iter().zip(shares.iter()).map(|([x, y], share)| [*x, *y, *share]).collect();
    let distance = |[x, y, share]: &[f64; 3]| share * (x - center.x).hypot(y - center.y);
    let c = feet.iter().map(distance).sum();
    Ok((feet, [center.x, center.y, c]))
}

fn add_squares(sums: &mut [f64; 3], model: &Description, aside: &Observations) -> Result<()> {
    let predictions = Predictions::of(model, &[], aside)?;
    for (step, predicted) in aside.steps().iter().zip(predictions.steps()) {
        for (k, sum) in sums.iter_mut().enumerate() {
            let pair = step.observed[k].zip(predicted[k]);
            *sum += pair.map_or(0.0, |(seen, told)| (seen - told).powi(2));
        }
    }
    Ok(())
}

fn squares_about_mean(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    values.iter().map(|value| (value - mean).powi(2)).sum()
}

/// The section of the page.
pub(super) fn text(known: &[Known]) -> String {
    let mut page = HEAD.to_owned();
    for one in known {
        page += &one.row();
    }
    for (which, name) in ["four points", "three by statics"].into_iter().enumerate() {
        let count = |is: &dyn Fn(&Found, &[f64; 3]) -> bool| {
            known.iter().filter(|one| is(&one.found[which], &one.truth)).count()
        };
        let is_near = |found: &Found, truth: &_| found.off(truth).0 < 5e-3;
        let is_alike = |found: &Found, truth: &_| (found.off(truth).1 - 1.0).abs() < 0.1;
        let [x, y, c] = [0, 1, 2].map(|k| count(&|found, truth| found.holds(truth, k)));
        let _ = writeln!(
            page,
            "\nBy {name} the center is within 5 mm of the true one in {} of {n}, c within 10 % in {}, both \
             in {}; the 95 % intervals hold the truth in {x} (x), {y} (y) and {c} (c) of {n}.",
            count(&is_near),
            count(&is_alike),
            count(&|found, truth| is_near(found, truth) && is_alike(found, truth)),
            n = known.len()
        );
    }
    page + &diagnosed::text(known) + TAIL
}

/// The outlines with true feet and those found: by fits of four points, and by the diagnosis alone.
///
/// # Errors
/// A picture that cannot be drawn.
pub(super) fn picture(known: &[Known]) -> Result<String> {
    let mut figure = Figure::new(2, known.len()).panel_size(240.0, 240.0);
    for one in known {
        figure = figure.with(one.panel(one.name, &one.found[0].feet));
    }
    for one in known {
        figure = figure.with(one.panel(&format!("{}, diagnosed", one.name), &one.diagnosed.feet));
    }
    Ok(figure.svg()?)
}

impl Known {
    fn panel(&self, title: &str, found: &[[f64; 3]]) -> Panel {
        let mm = |place: &[f64]| [1e3 * place[0], 1e3 * place[1]];
        let outline: Vec<[f64; 2]> = self.outline.iter().map(|place| mm(place)).collect();
        let feet: Vec<[f64; 2]> = self.feet.iter().map(|foot| mm(foot)).collect();
        let [ours, true_color] = [Color::cycle(0), Color::cycle(1)];
        let mut panel = Panel::new("x in mm", "y in mm")
            .title(title)
            .equal_aspect()
            .with(Polygon::new(&outline));
        for foot in found {
            let circle = Ellipse::circle(mm(foot), WHOLE * foot[2].sqrt());
            panel = panel.with(circle.fill(ours, 0.4));
        }
        if !found.is_empty() {
            panel = panel.with(Points::at(&[mm(&diagnosed::center(found))]).color(ours));
        }
        panel = panel.with(Points::at(&[mm(&self.truth)]).color(true_color));
        if !feet.is_empty() {
            panel = panel.with(Points::at(&feet).color(true_color));
        }
        panel
    }
}

/// Radius of a foot that bears the whole weight, in mm.
const WHOLE: f64 = 14.0;

const HEAD: &str = "
## Physics alone on an object with known feet

50 pushes each of a triangle (legs of 150 mm) that stands on three known feet or on its whole face: the
pose before and after a push, the pusher's way and the force. The tracked pusher is 1 to 1.6 mm inside the
tracked outline while it pushes.

```text
cargo xtask real-comparison --data DIR --only known-supports
pushlab fit cmu-known-supports/corners --preset cmu-known-supports --free pusher-friction,pose-offset,support-points --model nominal.toml -o points.toml
pushlab fit cmu-known-supports/corners --preset cmu-known-supports --free pusher-friction,pose-offset,support-points --points 3 --by-statics --model nominal.toml -o feet.toml
```

Squared error over variance of motions that no fit has seen (five folds; mean of Δx, Δy, Δθ), with nothing
fitted, with the pusher's friction and where the tracked frame is in the object (`pose-offset`), with four
points besides of which nothing is known, and with three that share the weight by statics; and, fitted to
all pushes with four points, the pusher's friction, the center of friction and the mean distance c of the
pressure from it in mm, with 95 % intervals, beside the truth (weights by statics); and c by three points.
All is fitted at once from nominal values: a friction that was fitted beside a wrong support
may lead to wrong points.

| set | nominal | μp, frame | four points | three by statics | μp | x | y | c | c by statics |
|---|---|---|---|---|---|---|---|---|---|
";

const TAIL: &str = "
![True feet and those found](real-data-known-supports.svg)

Orange are the true feet and their center; blue the points found, their area by the share of the weight that
they bear, and the center of friction that follows: above by fits of four points, below by the diagnosis alone, where
it claims any.
";
