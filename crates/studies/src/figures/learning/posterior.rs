//! Figure 3.2: the posterior against the density of the data.

use anyhow::{Context, Result};
use faer::Mat;
use gp_core::{Gp, JointGaussian, Mean, SquaredExponential};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;
use report::{Axis, Band, Color, Figure, Line, Panel, Points};
use serde_json::{Value, json};

use crate::figures::inputs::{Inputs, SEED};
use crate::figures::sketch::Sketch;

/// Inputs: so many points from 0 to this.
const POINTS: usize = 241;
const REACH: f64 = 12.0;
/// The prior, which is also what the function was drawn from, and the noise on the data.
const LENGTHSCALE: f64 = 1.0;
const NOISE_SD: f64 = 0.1;

/// A choice of inputs, as indices of the grid.
struct Design {
    title: &'static str,
    indices: fn() -> Vec<usize>,
}

const DESIGNS: [Design; 4] = [
    Design { title: "4 points", indices: || spread(4) },
    Design { title: "10 points", indices: || spread(10) },
    Design {
        title: "10 points, dense on the left",
        indices: || (0..10).map(|k| 3 + 10 * k).collect(),
    },
    Design { title: "40 points", indices: || spread(40) },
];

/// A posterior on the grid with the data behind it.
struct Belief {
    x: Vec<f64>,
    y: Vec<f64>,
    mean: Vec<f64>,
    sd: Vec<f64>,
}

pub(crate) fn draw(_: &Inputs) -> Result<Sketch> {
    let kernel = SquaredExponential::new(&[LENGTHSCALE], 1.0)?;
    let grid = Mat::from_fn(POINTS, 1, |i, _| at(i));
    let drawn = JointGaussian::prior(&kernel, grid.as_ref())?.sample(1, SEED)?;
    let truth: Vec<f64> = (0..POINTS).map(|i| drawn[(i, 0)]).collect();
    let mut noise = ChaCha8Rng::seed_from_u64(SEED);
    // Every grid point has one observation, so that designs share what they have in common.
    let observed: Vec<f64> =
        truth.iter().map(|f| f + NOISE_SD * noise.sample::<f64, _>(StandardNormal)).collect();
    let mut beliefs = Vec::new();
    for design in &DESIGNS {
        let indices = (design.indices)();
        let x = Mat::from_fn(indices.len(), 1, |k, _| at(indices[k]));
        let y: Vec<f64> = indices.iter().map(|&i| observed[i]).collect();
        let noise_variance = NOISE_SD * NOISE_SD;
        let gp = Gp::builder(kernel.clone())
            .noise_variance(noise_variance)
            .mean(Mean::Fixed(0.0))
            .condition(x.as_ref(), &y)?;
        let (mean, variance) = gp.predict(grid.as_ref())?;
        let sd = variance.iter().map(|v| v.sqrt()).collect();
        let x = indices.iter().map(|&i| at(i)).collect();
        beliefs.push(Belief { x, y, mean, sd });
    }
    let mut figure = Figure::new(2, 2).panel_size(430.0, 250.0).one_legend();
    for (design, belief) in DESIGNS.iter().zip(&beliefs) {
        figure = figure.with(belief.panel(design.title, &truth));
    }
    let designs: Vec<Value> =
        DESIGNS.iter().zip(&beliefs).map(|(design, belief)| belief.data(design.title)).collect();
    let x: Vec<f64> = (0..POINTS).map(at).collect();
    let data = json!({ "x": x, "function": truth, "designs": designs });
    let caption = caption(&beliefs, &truth)?;
    let alt = "Four panels of one function with the points at which it was seen and a band about its \
               estimate.";
    Ok(Sketch::new(figure, data, &caption, alt))
}

fn caption(beliefs: &[Belief], truth: &[f64]) -> Result<String> {
    let [few, some, uneven, many] = beliefs else { anyhow::bail!("four designs are described") };
    let inside: Vec<String> =
        beliefs.iter().map(|belief| format!("{:.0}", 100.0 * belief.coverage(truth))).collect();
    let right = |belief: &Belief| belief.sd.last().copied().context("an empty grid");
    Ok(format!(
        "One function, seen with noise (standard deviation {NOISE_SD}) at few, more, unevenly spread \
         and many points; the prior (lengthscale {LENGTHSCALE}, standard deviation 1) is the one it \
         was drawn from. The mean standard deviation of f is {:.2} with 4 points, {:.2} with 10 and \
         {:.3} with 40. Dense on the left, the same 10 points leave {:.3} there (x < 5) and {:.2} at \
         the right end. The function is within ±2 standard deviations at {} % \
         of the inputs, in the order of the panels.",
        average(&few.sd),
        average(&some.sd),
        average(&many.sd),
        average(&uneven.sd[..POINTS * 5 / 12]),
        right(uneven)?,
        inside.join(", "),
    ))
}

impl Belief {
    fn panel(&self, title: &str, truth: &[f64]) -> Panel {
        let x: Vec<f64> = (0..POINTS).map(at).collect();
        let (low, high) = self.bounds();
        // Marks on the axis show where data are, as in the thesis.
        let foot = vec![FLOOR + 0.2; self.x.len()];
        Panel::new(Axis::new("input x").range(0.0, REACH), Axis::new("f(x)").range(FLOOR, -FLOOR))
            .title(title)
            .with(Band::new(&x, &low, &high).color(Color::BLUE).label("±2 standard deviations"))
            .with(Line::new(&x, truth).color(Color::INK).width(1.3).dashed().label("function"))
            .with(Line::new(&x, &self.mean).color(Color::BLUE).label("mean"))
            .with(Points::new(&self.x, &self.y).color(Color::VERMILION).label("data"))
            .with(
                Points::new(&self.x, &foot)
                    .color(Color::GREEN)
                    .radius(3.0)
                    .label("inputs of the data"),
            )
    }

    fn bounds(&self) -> (Vec<f64>, Vec<f64>) {
        let pairs = || self.mean.iter().zip(&self.sd);
        (
            pairs().map(|(m, sd)| m - 2.0 * sd).collect(),
            pairs().map(|(m, sd)| m + 2.0 * sd).collect(),
        )
    }

    /// The share of the grid where the function is within two standard deviations.
    fn coverage(&self, truth: &[f64]) -> f64 {
        let (low, high) = self.bounds();
        let bounds = low.iter().zip(&high);
        let inside =
            truth.iter().zip(bounds).filter(|(f, (l, h))| (**l..=**h).contains(*f)).count();
        inside as f64 / truth.len() as f64
    }

    fn data(&self, title: &str) -> Value {
        json!({ "title": title, "x": self.x, "y": self.y, "mean": self.mean, "sd": self.sd })
    }
}

/// Lower end of the vertical axis.
const FLOOR: f64 = -3.4;

fn at(i: usize) -> f64 {
    REACH * i as f64 / (POINTS - 1) as f64
}

/// `n` grid points in the middles of equal parts.
fn spread(n: usize) -> Vec<usize> {
    (0..n).map(|k| (2 * k + 1) * (POINTS - 1) / (2 * n)).collect()
}

fn average(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}
