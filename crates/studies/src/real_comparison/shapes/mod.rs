//! Physics alone on long pushes of every object: where each rests, and the error with it.

mod diagnosed;
mod folds;
mod pushes;

use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result};
use models::Description;
use planar::MIT_NAMES;
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};
use report::{Color, Ellipse, Figure, Panel, Points, Polygon};

pub(super) use self::diagnosed::{diagnosed, diagnosed_text};
use self::folds::{Fitted, N_MODELS, of_folds};
use self::pushes::{Error, pushes};
use super::plain_fit::feet;

/// The fits of one object's pushes.
pub(super) struct Shape {
    name: String,
    n_pushes: usize,
    /// Model after model.
    fitted: Vec<Fitted>,
    /// The last model of each fold.
    models: Vec<Description>,
    outline: Vec<[f64; 2]>,
}

/// Fits the pushes of every object in a file of end points, each by itself.
///
/// # Errors
/// A file that cannot be read; a model that cannot predict an object's pushes.
pub(super) fn shapes(path: &Path) -> Result<Vec<Shape>> {
    MIT_NAMES.par_iter().map(|name| of(path, name).with_context(|| name.to_string())).collect()
}

fn of(path: &Path, name: &str) -> Result<Shape> {
    let (all, nominal) = pushes(path, name)?;
    let started = Instant::now();
    let (fitted, models) = of_folds(&all, &nominal)?;
    let n_pushes = all.pushes().len();
    println!("{name}: {n_pushes} pushes fitted in {} s", started.elapsed().as_secs());
    let outline = all.steps().first().map(|step| step.input.object.shape().outline(90));
    let outline = outline.unwrap_or_default().iter().map(|place| [place.x, place.y]).collect();
    Ok(Shape { name: name.to_owned(), n_pushes, fitted, models, outline })
}

/// The section of the page.
pub(super) fn text(shapes: &[Shape]) -> String {
    let mut page = HEAD.to_owned();
    for Shape { name, n_pushes, fitted, .. } in shapes {
        let cells = fitted.iter().map(|fitted| (fitted.error, fitted.n_failed));
        page += &row(&format!("{name} ({n_pushes})"), &cells.collect::<Vec<_>>());
    }
    let mean = |k: usize| {
        let mut sum = Error::default();
        for shape in shapes {
            sum.position += shape.fitted[k].error.position;
            sum.angle += shape.fitted[k].error.angle;
        }
        (sum.over(shapes.len()), 0)
    };
    page += &row("mean of the objects", &(0..N_MODELS).map(mean).collect::<Vec<_>>());
    page + TAIL
}

fn row(name: &str, errors: &[(Error, usize)]) -> String {
    let cell = |(error, n_failed): &(Error, usize)| match n_failed {
        0 => error.to_string(),
        n => format!("{error} ({n} fits failed)"),
    };
    let cells: Vec<_> = errors.iter().map(cell).collect();
    format!("| {name} | {} |\n", cells.join(" | "))
}

/// Each outline with the points of every fold, and their center.
///
/// # Errors
/// A picture that cannot be drawn.
pub(super) fn picture(shapes: &[Shape]) -> Result<String> {
    const COLUMNS: usize = 4;
    let rows = shapes.len().div_ceil(COLUMNS);
    let mut figure = Figure::new(rows, COLUMNS).panel_size(250.0, 250.0);
    for shape in shapes {
        let mm = |place: &[f64; 2]| place.map(|x| 1e3 * x);
        let outline: Vec<[f64; 2]> = shape.outline.iter().map(mm).collect();
        let mut panel = Panel::new("x in mm", "y in mm")
            .title(&shape.name)
            .equal_aspect()
            .with(Polygon::new(&outline));
        for (fold, feet) in shape.models.iter().filter_map(feet).enumerate() {
            let color = Color::cycle(fold);
            for [x, y, share] in &feet {
                panel = panel.with(
                    Ellipse::circle([1e3 * x, 1e3 * y], WHOLE * share.sqrt()).fill(color, 0.4),
                );
            }
            let center =
                [0, 1].map(|k| feet.iter().map(|foot| 1e3 * foot[k] * foot[2]).sum::<f64>());
            panel = panel.with(Points::at(&[center]).color(color));
        }
        figure = figure.with(panel);
    }
    Ok(figure.svg()?)
}

/// Radius of a foot that bears the whole weight, in mm.
const WHOLE: f64 = 12.0;

const HEAD: &str = "
## Physics alone on long pushes of every shape

Pushes of 50 mm at 10 mm/s of eleven objects on plywood, of which the poses before and after and the
ends of the pusher's way are known, as `pushlab ingest --preset mit-endpoints` reads them: a row each,
simulated as a whole from the start of the way, before the touch, to its end; the pusher may slide off or
meet a vertex. All pushes are counted but those in which the tracking flips: the object turns further than
any contact turns it.

```text
cargo xtask real-comparison --data DIR --only shapes
pushlab fit mit-push-endpoints/plywood.csv --preset mit-endpoints --shape rect1 --free pusher-friction,support-points --model nominal.toml -o points.toml
pushlab fit mit-push-endpoints/plywood.csv --preset mit-endpoints --shape rect1 --free pusher-friction,support-points,approach-gap --nuisances --model points.toml -o whole.toml
```

Mean distance and mean angle between the predicted and the measured end, of pushes that no fit has seen:
plain fits to every other push, and the error on the rest, over all pushes. Nothing fitted; the pusher's
friction μp; with the radius c of the pressure; with four support points instead; with a gap before the
touch; and with the nuisances of that fit in the model: the tip's radius and compliance, and where the tracked
frame is in the object, each within the tolerance of what is claimed of it. (With `--shape hex` it says that
hex is tracked turned by 0.024 ± 0.005 rad.)

| object (pushes) | nominal | μp | μp, c | μp, points | and gap | and nuisances |
|---|---|---|---|---|---|---|
";

const TAIL: &str = "
A published toolbox reaches 3.73 mm and 4.12° with a fitted ellipsoid and 3.36 mm and 3.54° with a fitted
quartic, averages over the shapes of all of these pushes, with surfaces that were fitted to separate
measurements of force and motion.

![Where each object rests, by the fits of two halves](real-data-shapes.svg)

The points of each half in its color, their area by the share of the weight that they bear, and the center
of friction that follows. Other points have nearly the same limit surface: what both halves agree on is
where the pressure leans, not single feet.
";
