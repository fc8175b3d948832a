//! Figure 5.2: mean and standard deviation of the learned push over position and direction.

use anyhow::Result;
use models::{
    GpPushModel, Noise, PushModel, StepInput, StepObservation, StepPrediction, learn_options,
};
use report::{Claim, Color, ColorMap, Figure, Grid, HeatMap, Panel, Points, Table};

use super::steps::Steps;
use crate::figures::claims::judged;
use crate::figures::inputs::{Inputs, SEED, STEP_WAY};
use crate::figures::sketch::Sketch;
use crate::held_out::{quantile, shuffled};

/// What this figure settles.
pub(crate) const CLAIMS: [&str; 1] = [
    "10. Posterior variance is nearly flat but for the borders of the inputs, and too small at the \
     vertices.",
];
const MOST_TRAINING: usize = 500;
const COLUMNS: usize = 61;
const ROWS: usize = 51;
/// Share of each input's range that counts as its border, on either side.
const BORDER: f64 = 0.15;
/// Share of an edge that counts as near its vertex, on either side.
const NEAR_VERTEX: f64 = 0.1;
/// What turns m, m and rad into the unit of the figure, by output.
const SCALES: [(&str, &str, f64); 3] =
    [("Δx", "mm", 1e3), ("Δy", "mm", 1e3), ("Δθ", "°", 180.0 / std::f64::consts::PI)];

pub(crate) fn draw(inputs: &Inputs) -> Result<Sketch> {
    let data = Steps::of(inputs)?;
    let shuffled = shuffled(&data.steps, SEED, 0);
    let (train, test) = shuffled.split_at(MOST_TRAINING.min(data.steps.len() / 2));
    let (model, _) = GpPushModel::learn(train, &learn_options())?;
    let beta = |share| quantile(data.steps.iter().map(|step| step.input.beta()).collect(), share);
    let range = (beta(0.01), beta(0.99));
    let cells = cells(&data, range)?;
    let field = model.predict(&cells, Noise::Excluded)?;
    let caption = format!(
        "Mean (top) and standard deviation (bottom) of the motion in a step of {:.0} mm, by Gaussian \
         processes learned from {} steps (dots), without the noise of an observation. All edges are \
         folded into one.",
        1e3 * STEP_WAY,
        train.len()
    );
    let alt = "Six maps over contact position and push direction: three means, and three standard \
               deviations with the training steps as dots.";
    let sketch = Sketch::new(figure(&field, range, train), table(&cells, &field), &caption, alt);
    Ok(sketch.claim(claim(&cells, &field, range, &model, test)?))
}

/// Steps at the centers of the maps' cells, row by row.
fn cells(data: &Steps, (low, high): (f64, f64)) -> Result<Vec<StepInput>> {
    let at = |k: usize, n: usize| (k as f64 + 0.5) / n as f64;
    let cell = |index: usize| {
        let (row, column) = (index / COLUMNS, index % COLUMNS);
        let (p, beta) = (at(column, COLUMNS), low + (high - low) * at(row, ROWS));
        let shape = data.shape.clone();
        Ok(StepInput::on_edge(shape, data.pusher_radius, 0, p, beta, STEP_WAY)?)
    };
    (0..COLUMNS * ROWS).map(cell).collect()
}

fn figure(field: &[StepPrediction], range: (f64, f64), train: &[StepObservation]) -> Figure {
    let degrees = (range.0.to_degrees(), range.1.to_degrees());
    let grid = |values| Grid::new((0.0, 1.0), degrees, COLUMNS, ROWS, values);
    let panel =
        |title: String| Panel::new("contact position p", "push direction β / °").title(&title);
    let inside = train.iter().map(|step| &step.input);
    let inside = inside.filter(|input| (range.0..=range.1).contains(&input.beta()));
    let dots: Vec<_> = inside.map(|input| [input.p(), input.beta().to_degrees()]).collect();
    let mut figure = Figure::new(2, 3).panel_size(340.0, 260.0);
    for (k, (name, unit, scale)) in SCALES.iter().enumerate() {
        let values = field.iter().map(|prediction| scale * prediction.mean[k]).collect();
        let map = if k == 0 { ColorMap::Viridis } else { ColorMap::Diverging };
        let mean = HeatMap::new(grid(values), &format!("{name} / {unit}")).map(map);
        figure = figure.with(panel(format!("mean of {name}")).with(mean));
    }
    for (k, (name, unit, _)) in SCALES.iter().enumerate() {
        let map = HeatMap::new(grid(deviations(field, k)), &format!("sd of {name} / {unit}"));
        let title = format!("standard deviation of {name}");
        let dots = Points::at(&dots).radius(1.1).color(Color::WHITE);
        figure = figure.with(panel(title).with(map.map(ColorMap::Cividis)).with(dots));
    }
    figure
}

/// The standard deviations of an output, in the figure's unit.
fn deviations(field: &[StepPrediction], k: usize) -> Vec<f64> {
    field.iter().map(|prediction| SCALES[k].2 * prediction.covariance[(k, k)].sqrt()).collect()
}

fn table(cells: &[StepInput], field: &[StepPrediction]) -> Table {
    let column = |value: &dyn Fn(&StepInput) -> f64| cells.iter().map(value).collect::<Vec<_>>();
    let mut table = Table::new()
        .column("p", &column(&|cell| cell.p()))
        .column("beta_deg", &column(&|cell| cell.beta().to_degrees()));
    for (k, name) in ["dx_mm", "dy_mm", "dtheta_deg"].iter().enumerate() {
        let mean: Vec<f64> = field.iter().map(|at| SCALES[k].2 * at.mean[k]).collect();
        table = table
            .column(&format!("mean_{name}"), &mean)
            .column(&format!("sd_{name}"), &deviations(field, k));
    }
    table
}

fn claim(
    cells: &[StepInput],
    field: &[StepPrediction],
    (low, high): (f64, f64),
    model: &dyn PushModel,
    test: &[StepObservation],
) -> Result<Claim> {
    let is_inner = |cell: &StepInput| {
        let share = (cell.beta() - low) / (high - low);
        [cell.p(), share].iter().all(|share| (BORDER..=1.0 - BORDER).contains(share))
    };
    let (mut unevenness, mut rise) = ([0.0; 3], [0.0; 3]);
    for k in 0..3 {
        let pairs = || cells.iter().zip(deviations(field, k));
        let some = |inner: bool| -> Vec<f64> {
            pairs().filter(|(cell, _)| is_inner(cell) == inner).map(|(_, sd)| sd).collect()
        };
        unevenness[k] = quantile(some(true), 0.9) / quantile(some(true), 0.1);
        rise[k] = quantile(some(false), 0.5) / quantile(some(true), 0.5);
    }
    let (vertex, middle) = standardized_errors(model, test)?;
    let list = |values: [f64; 3]| values.map(|value| format!("{value:.2}")).join(", ");
    let value = format!(
        "for Δx, Δy, Δθ: inside, the 90th percentile of the standard deviation is {} times the \
         10th; at the borders its median is {} times that inside; root mean square of error over \
         predicted standard deviation {} near the vertices and {} elsewhere",
        list(unevenness),
        list(rise),
        list(vertex),
        list(middle)
    );
    let all = |test: &dyn Fn(usize) -> bool| (0..3).all(test);
    let holds = all(&|k| unevenness[k] < 1.5)
        && all(&|k| rise[k] > 1.1)
        && all(&|k| vertex[k] > 1.1 && vertex[k] > middle[k]);
    let reason = "in every output: 90th below 1.5 times the 10th percentile inside (the middle 70 % \
                  of p and of β), at least 1.1 times the inner median at the borders, and errors \
                  above 1.1 predicted standard deviations within a tenth of the vertices, larger \
                  than elsewhere; on steps not used for training";
    Ok(judged(CLAIMS[0], value, holds, reason))
}

/// Root mean square of error over predicted standard deviation near vertices and elsewhere.
fn standardized_errors(
    model: &dyn PushModel,
    test: &[StepObservation],
) -> Result<([f64; 3], [f64; 3])> {
    let inputs: Vec<_> = test.iter().map(|step| step.input.clone()).collect();
    let predictions = model.predict(&inputs, Noise::Included)?;
    let rms = |near: bool, k: usize| {
        let pairs = test.iter().zip(&predictions).filter(|(step, _)| {
            (NEAR_VERTEX..=1.0 - NEAR_VERTEX).contains(&step.input.p()) != near
        });
        let squares: Vec<f64> = pairs
            .map(|(step, at)| (step.outputs[k] - at.mean[k]).powi(2) / at.covariance[(k, k)])
            .collect();
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
    };
    Ok(([0, 1, 2].map(|k| rms(true, k)), [0, 1, 2].map(|k| rms(false, k))))
}
