//! Figure 6.2: how the particles lie about the measured end of a push.

use anyhow::Result;
use models::{RollOutSettings, StepErrors};
use planar::wrap_angle;
use report::{Axis, Claim, Figure, Guide, Histogram, LegendPlace, Panel};
use serde_json::json;

use super::scene::{Rolled, Scene, place_of};
use crate::figures::claims::judged;
use crate::figures::inputs::Inputs;
use crate::figures::sketch::Sketch;

/// What this figure settles.
pub(crate) const CLAIMS: [&str; 1] = ["13. Roll-out errors are not Gaussian."];
const WANTED: [f64; 2] = [0.3, -0.7];
const N_PARTICLES: usize = 2000;
const N_TESTED: usize = 500;
const N_BINS: usize = 40;
/// The 99 % quantile of the chi-squared distribution of two.
const JARQUE_BERA_99: f64 = 9.210_340_371_976_182;
const OUTPUTS: [(&str, f64); 3] = [("x / mm", 1e3), ("y / mm", 1e3), ("angle / °", 57.295_779_513)];

pub(crate) fn draw(inputs: &Inputs) -> Result<Sketch> {
    let scene = inputs.scene()?;
    let push = scene.nearest(WANTED)?;
    let rolled = Rolled::of(scene.gp.model.as_ref(), push, &scene.held(N_PARTICLES))?;
    let end = push.poses_wb[push.poses_wb.len() - 1];
    let off = |output: usize| -> Vec<f64> {
        let of = |pose: &planar::Pose| match output {
            0 => pose.position.x - end.position.x,
            1 => pose.position.y - end.position.y,
            _ => wrap_angle(pose.angle - end.angle),
        };
        let last = &rolled.particles[rolled.last()];
        last.iter().map(|particle| OUTPUTS[output].1 * of(&particle.pose_wb)).collect()
    };
    let mut figure = Figure::new(1, 3).panel_size(300.0, 260.0);
    let mut numbers = serde_json::Map::new();
    for (output, (name, _)) in OUTPUTS.iter().enumerate() {
        let samples = off(output);
        let histogram = Histogram::new(&samples, N_BINS);
        let (edges, densities) = histogram.densities();
        numbers.insert((*name).to_owned(), json!({ "edges": edges, "density": densities }));
        let panel = Panel::new(Axis::new(&format!("particle − measured, {name}")), "density")
            .legend(LegendPlace::Hidden)
            .with(histogram)
            .with(Guide::vertical(0.0));
        figure = figure.with(panel);
    }
    let caption = format!(
        "{N_PARTICLES} particles of a Gaussian process at the end of a push it has not seen ({}), less \
         the measured end. Where 0 is within the bars the roll-out has it.",
        place_of(push)
    );
    let alt = "Three histograms of the error at the end of a push.";
    let sketch = Sketch::new(figure, serde_json::Value::Object(numbers), &caption, alt);
    Ok(sketch.claim(normality(scene)?))
}

/// Jarque and Bera's test of the particles at the end of every push, output by output.
fn normality(scene: &Scene) -> Result<Claim> {
    // What a push holds is drawn with heavy tails: independent steps have only what the push makes.
    let errors = StepErrors::Independent;
    let settings = RollOutSettings { n_particles: N_TESTED, errors, ..scene.held(1) };
    let all = scene.all(scene.gp.model.as_ref(), &settings)?;
    let (mut n_rejected, mut skews, mut kurtoses) = (0, Vec::new(), Vec::new());
    for rolled in &all {
        let mean = rolled.moments[rolled.last()].pose_wb.mean;
        let particles = &rolled.particles[rolled.last()];
        let outputs = [0, 1, 2].map(|output| {
            let of = |pose: &planar::Pose| match output {
                0 => pose.position.x,
                1 => pose.position.y,
                _ => mean.z + wrap_angle(pose.angle - mean.z),
            };
            shape_of(&particles.iter().map(|one| of(&one.pose_wb)).collect::<Vec<_>>())
        });
        let n = N_TESTED as f64;
        let statistic =
            |[skew, kurtosis]: &[f64; 2]| n / 6.0 * (skew * skew + 0.25 * kurtosis * kurtosis);
        n_rejected += usize::from(outputs.iter().any(|shape| statistic(shape) > JARQUE_BERA_99));
        skews.extend(outputs.map(|[skew, _]| skew.abs()));
        kurtoses.extend(outputs.map(|[_, kurtosis]| kurtosis.abs()));
    }
    let median = |values: Vec<f64>| crate::held_out::quantile(values, 0.5);
    let value = format!(
        "{n_rejected} of {} pushes reject it in some output; median |skewness| {:.2}, |excess \
         kurtosis| {:.2}",
        all.len(),
        median(skews),
        median(kurtoses)
    );
    let reason = "the test of Jarque and Bera on 500 particles at the end, level 1 % an output, \
                  rejects in more than half of the pushes; errors of steps are drawn as independent \
                  Gaussians";
    Ok(judged(CLAIMS[0], value, 2 * n_rejected > all.len(), reason))
}

/// Skewness and excess kurtosis.
fn shape_of(samples: &[f64]) -> [f64; 2] {
    let n = samples.len() as f64;
    let mean = samples.iter().sum::<f64>() / n;
    let moment = |power: i32| samples.iter().map(|x| (x - mean).powi(power)).sum::<f64>() / n;
    let variance = moment(2);
    [moment(3) / variance.powf(1.5), moment(4) / (variance * variance) - 3.0]
}

#[cfg(test)]
mod tests {
    use super::shape_of;

    #[test]
    fn shapes_of_known_samples() {
        let even: Vec<f64> = (0..10_001).map(|k| f64::from(k) / 1e4).collect();
        let [skew, kurtosis] = shape_of(&even);
        assert!(skew.abs() < 1e-9 && (kurtosis + 1.2).abs() < 1e-3, "{skew} {kurtosis}");
        let squares: Vec<f64> = even.iter().map(|x| x * x).collect();
        // Of the square of an even number: 2√5/7.
        assert!((shape_of(&squares)[0] - 0.638_88).abs() < 1e-3);
    }
}
