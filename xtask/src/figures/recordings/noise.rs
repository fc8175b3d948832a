//! Figure 5.1: the noise of the sensors, seen where nothing moves.

use anyhow::{Context, Result};
use dataset::{PoseStream, Recording, WrenchStream};
use report::{Color, Figure, Guide, LegendPlace, Panel, Points};
use serde_json::{Value, json};

use super::choice::Choice;
use super::force_scan::median;
use crate::figures::inputs::Inputs;
use crate::figures::sketch::Sketch;

/// Motion has died down this long after rest, in s.
const SETTLING: f64 = 0.1;
/// Fewest samples of a stream that tell of its noise.
const FEWEST: usize = 10;

/// Deviations of some channels of one sensor from their means.
struct Sensor {
    title: &'static str,
    label: &'static str,
    channels: Vec<(&'static str, Vec<f64>)>,
    t: Vec<f64>,
}

pub(crate) fn draw(inputs: &Inputs) -> Result<Sketch> {
    let report = inputs.ingest_report()?;
    let lasting = |choice: &Choice| {
        choice.recording.streams.iter().all(|stream| {
            let until = choice.window().1.min(stream.span_s[1]);
            let rate = stream.rate_hz.unwrap_or(0.0);
            (until - choice.push.rest_s - SETTLING) * rate > 1.5 * FEWEST as f64
        })
    };
    let choice = Choice::nearest(report, (0.5, 0.0), lasting)
        .ok_or_else(|| inputs.lacking("samples of an object at rest after a push"))?;
    let recording = inputs.recording(&choice.recording.name)?;
    let rest = choice.push.rest_s + SETTLING;
    let sensors = sensors(&recording, rest, choice.window().1);
    let columns = 2;
    let mut figure = Figure::new(sensors.len().div_ceil(columns), columns).panel_size(440.0, 300.0);
    let mut data = Vec::new();
    for sensor in &sensors {
        figure = figure.with(sensor.panel(rest)?);
        data.push(sensor.numbers(rest));
    }
    let pooled = match (report.summary.resting_position_sd_m, report.summary.resting_angle_sd_rad) {
        (Some(position), Some(angle)) => format!(
            " Over the whole set, the object's standard deviation at rest is {:.1} µm per axis and \
             {:.2} mrad in the median of {} recordings.",
            1e6 * position.median,
            1e3 * angle.median,
            position.n
        ),
        _ => String::new(),
    };
    let caption = format!(
        "Samples of object, robot and force sensor while everything rests after one push, as \
         differences from their medians, with what still dies down after the stop; lines at plus and \
         minus one standard deviation (sd).{pooled}"
    );
    let alt = "Scattered points about zero for each sensor.";
    Ok(Sketch::new(figure, json!(data), &caption, alt))
}

fn sensors(recording: &Recording, from: f64, until: f64) -> Vec<Sensor> {
    let PoseStream { t, x, y, theta, .. } = &recording.object;
    let position = [("x", &x[..], 1e6), ("y", &y[..], 1e6)];
    let mut sensors = vec![
        Sensor::new("object, position", "difference / µm", t, &position, (from, until)),
        Sensor::new("object, yaw", "difference / mrad", t, &[("yaw", theta, 1e3)], (from, until)),
    ];
    let PoseStream { t, x, y, .. } = &recording.robot;
    let position = [("x", &x[..], 1e6), ("y", &y[..], 1e6)];
    sensors.push(Sensor::new("robot, position", "difference / µm", t, &position, (from, until)));
    if let Some(WrenchStream { t, fx, fy, .. }) = &recording.wrench {
        let force = [("Fx", &fx[..], 1e3), ("Fy", &fy[..], 1e3)];
        sensors.push(Sensor::new("force", "difference / mN", t, &force, (from, until)));
    }
    sensors.retain(|sensor| sensor.t.len() >= FEWEST);
    sensors
}

impl Sensor {
    fn new(
        title: &'static str,
        label: &'static str,
        t: &[f64],
        channels: &[(&'static str, &[f64], f64)],
        (from, until): (f64, f64),
    ) -> Self {
        let inside: Vec<_> = (0..t.len()).filter(|&i| (from..until).contains(&t[i])).collect();
        let channels = channels
            .iter()
            .map(|(name, values, scale)| {
                let own: Vec<f64> = inside.iter().map(|&i| values[i]).collect();
                let middle = median(own.clone()).unwrap_or_default();
                (*name, own.into_iter().map(|value| scale * (value - middle)).collect())
            })
            .collect();
        Self { title, label, channels, t: inside.into_iter().map(|i| t[i]).collect() }
    }

    fn panel(&self, rest: f64) -> Result<Panel> {
        let t: Vec<f64> = self.t.iter().map(|t| t - rest).collect();
        let mut panel = Panel::new("time at rest / s", self.label)
            .legend(LegendPlace::Below)
            .with(Guide::horizontal(0.0));
        let mut sds = Vec::new();
        for (index, (name, values)) in self.channels.iter().enumerate() {
            let color = Color::cycle(index);
            let sd = standard_deviation(values).context("a sensor without samples")?;
            sds.push(format!("{sd:.2}"));
            panel = panel
                .with(Guide::horizontal(sd).color(color).dashed())
                .with(Guide::horizontal(-sd).color(color).dashed())
                .with(Points::new(&t, values).color(color).label(name));
        }
        let unit = self.label.rsplit(' ').next().unwrap_or_default();
        let title = format!("{}, sd {} {unit}", self.title, sds.join(" and "));
        Ok(panel.title(&title))
    }

    fn numbers(&self, rest: f64) -> Value {
        let t: Vec<f64> = self.t.iter().map(|t| t - rest).collect();
        let channels: Vec<_> = self
            .channels
            .iter()
            .map(|(name, values)| {
                let sd = standard_deviation(values);
                json!({ "name": name, "difference": values, "standard_deviation": sd })
            })
            .collect();
        json!({ "sensor": self.title, "unit": self.label, "t_s": t, "channels": channels })
    }
}

/// Of a sample, about its mean.
fn standard_deviation(values: &[f64]) -> Option<f64> {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (n > 1.0).then(|| (squares / (n - 1.0)).sqrt())
}

#[cfg(test)]
mod tests {
    use super::standard_deviation;

    #[test]
    fn the_standard_deviation_is_that_of_a_sample() {
        assert_eq!(standard_deviation(&[1.0, 2.0, 3.0]), Some(1.0));
        assert_eq!(standard_deviation(&[1.0]), None);
    }
}
