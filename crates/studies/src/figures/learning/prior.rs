//! Figure 3.1: what functions a kernel expects before it has seen data.

use std::f64::consts::PI;

use anyhow::Result;
use faer::Mat;
use gp_core::{JointGaussian, Kernel, Periodic, SquaredExponential};
use report::{Axis, Band, Color, Figure, Line, Panel, Table};

use crate::figures::inputs::{Inputs, SEED};
use crate::figures::sketch::Sketch;

/// Inputs: so many points from 0 to this.
const POINTS: usize = 241;
const REACH: f64 = 12.0;
/// Lengthscales of the slow, the fast and the periodic functions, and the latter's period.
const SLOW: f64 = 2.0;
const FAST: f64 = 0.5;
const FADING: f64 = 10.0;
const PERIOD: f64 = 3.0;
/// Functions drawn, and functions in which zeros are counted.
const DRAWN: usize = 3;
const COUNTED: usize = 2000;

pub(crate) fn draw(_: &Inputs) -> Result<Sketch> {
    let smooth = |lengthscale: f64| SquaredExponential::new(&[lengthscale], 1.0);
    let periodic = smooth(FADING)? * Periodic::new(PERIOD, 1.0);
    let priors: [(String, &str, Box<dyn Kernel>); 3] = [
        (format!("squared exponential, l = {SLOW}"), "slow", Box::new(smooth(SLOW)?)),
        (format!("squared exponential, l = {FAST}"), "fast", Box::new(smooth(FAST)?)),
        (format!("periodic, T = {PERIOD}, fading, l = {FADING}"), "periodic", Box::new(periodic)),
    ];
    let x = Mat::from_fn(POINTS, 1, |i, _| at(i));
    let inputs: Vec<f64> = (0..POINTS).map(at).collect();
    let mut table = Table::new().column("x", &inputs);
    let mut figure = Figure::new(1, 3).panel_size(330.0, 290.0);
    let mut crossings = Vec::new();
    for (title, name, kernel) in &priors {
        let samples = JointGaussian::prior(&**kernel, x.as_ref())?.sample(COUNTED, SEED)?;
        let sample = |j: usize| (0..POINTS).map(|i| samples[(i, j)]).collect::<Vec<f64>>();
        crossings.push((0..COUNTED).map(|j| sign_changes(&sample(j))).sum::<usize>());
        let two_sd = 2.0 * kernel.value(&[0.0], &[0.0]).sqrt();
        let band = [-two_sd, two_sd].map(|edge| vec![edge; POINTS]);
        let mut panel =
            Panel::new(Axis::new("input x").range(0.0, REACH), Axis::new("f(x)").range(-3.4, 3.4))
                .title(title)
                .with(Band::new(&inputs, &band[0], &band[1]).color(Color::GRAY));
        for j in 0..DRAWN {
            panel = panel.with(Line::new(&inputs, &sample(j)).color(Color::cycle(j)));
            table = table.column(&format!("{name}_{j}"), &sample(j));
        }
        figure = figure.with(panel);
    }
    let rate = |k: usize| crossings[k] as f64 / (COUNTED as f64 * REACH);
    let (near, far) = (&priors[2].2, 2.0 * PERIOD);
    let caption = format!(
        "{DRAWN} functions from each of three priors, and their ±2 standard deviations. The \
         lengthscale sets how fast they change: over {COUNTED} draws they cross zero {:.3} and {:.3} \
         times a unit of x, where 1/(πl) is {:.3} and {:.3}. The periodic kernel times a slow one gives \
         functions that nearly repeat: values one period apart have a correlation of {:.2}, two \
         periods apart of {:.2}, half a period apart of {:.2}.",
        rate(0),
        rate(1),
        1.0 / (PI * SLOW),
        1.0 / (PI * FAST),
        near.value(&[0.0], &[PERIOD]),
        near.value(&[0.0], &[far]),
        near.value(&[0.0], &[0.5 * PERIOD]),
    );
    let alt = "Three panels with three random functions each: slow waves, quick waves, and waves that \
               repeat with a slowly changing form.";
    Ok(Sketch::new(figure, table, &caption, alt))
}

fn at(i: usize) -> f64 {
    REACH * i as f64 / (POINTS - 1) as f64
}

fn sign_changes(values: &[f64]) -> usize {
    values.windows(2).filter(|pair| (pair[0] > 0.0) != (pair[1] > 0.0)).count()
}
