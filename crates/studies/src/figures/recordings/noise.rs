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
/// A pusher that stays this near to where it was is at rest, in m.
const AT_REST: f64 = 1e-4;
/// Fewest samples of a stream that tell of its noise.
const FEWEST: usize = 10;
/// Times longer than this are not looked for, in s, nor more pushes than this.
const LONG_ENOUGH: f64 = 0.4;
const MOST_TRIED: usize = 20;

/// Deviations of some channels of one sensor from their means.
struct Sensor {
    title: &'static str,
    label: &'static str,
    channels: Vec<(&'static str, Vec<f64>)>,
    t: Vec<f64>,
}

pub(crate) fn draw(inputs: &Inputs) -> Result<Sketch> {
    let report = inputs.ingest_report()?;
    let mut stills = Vec::new();
    for choice in Choice::nearest_first(report, (0.5, 0.0)).into_iter().take(MOST_TRIED) {
        let recording = inputs.recording(&choice.recording.name)?;
        stills.extend(still(&recording, &choice).map(|span| (recording, span)));
    }
    let length = |span: &(f64, f64)| (span.1 - span.0).min(LONG_ENOUGH);
    // Of those that are long enough, the first, which is nearest to a central push.
    let Some((recording, span)) =
        stills.into_iter().rev().max_by(|(_, a), (_, b)| length(a).total_cmp(&length(b)))
    else {
        return Err(inputs.lacking("samples of an object and a pusher at rest"));
    };
    let sensors = sensors(&recording, span);
    let columns = 2;
    let mut figure = Figure::new(sensors.len().div_ceil(columns), columns).panel_size(440.0, 300.0);
    let mut data = Vec::new();
    for sensor in &sensors {
        figure = figure.with(sensor.panel(span.0)?);
        data.push(sensor.numbers(span.0));
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
        "Samples of object, robot and force sensor while object and pusher rest before or after \
         one push, as differences from their medians, with what still dies down after a stop; lines \
         at plus and minus one standard deviation (sd).{pooled}"
    );
    let alt = "Scattered points about zero for each sensor.";
    Ok(Sketch::new(figure, json!(data), &caption, alt))
}

/// The longest time in which neither object nor pusher moves, before or after a push.
fn still(recording: &Recording, choice: &Choice) -> Option<(f64, f64)> {
    let (from, until) = choice.window();
    let around =
        [(from, choice.push.contact_start_s - SETTLING), (choice.push.rest_s + SETTLING, until)];
    let spans = around.into_iter().filter_map(|span| longest_rest(&recording.robot, span));
    let longest = spans.max_by(|a, b| (a.1 - a.0).total_cmp(&(b.1 - b.0)))?;
    let t = &recording.object.t;
    let n = t.iter().filter(|t| (longest.0..longest.1).contains(*t)).count();
    (n >= FEWEST).then_some(longest)
}

/// The longest time in which a stream stays where it is.
fn longest_rest(stream: &PoseStream, (from, until): (f64, f64)) -> Option<(f64, f64)> {
    let mut order: Vec<_> =
        (0..stream.len()).filter(|&i| (from..until).contains(&stream.t[i])).collect();
    order.sort_by(|&a, &b| stream.t[a].total_cmp(&stream.t[b]));
    let way = |a: usize, b: usize| (stream.x[a] - stream.x[b]).hypot(stream.y[a] - stream.y[b]);
    let mut runs: Vec<(usize, usize)> = Vec::new();
    for i in order {
        match runs.last_mut() {
            Some((first, last)) if way(*first, i) < AT_REST => *last = i,
            _ => runs.push((i, i)),
        }
    }
    let spans = runs.into_iter().map(|(first, last)| (stream.t[first], stream.t[last]));
    spans.max_by(|a, b| (a.1 - a.0).total_cmp(&(b.1 - b.0)))
}

fn sensors(recording: &Recording, (from, until): (f64, f64)) -> Vec<Sensor> {
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
                // A picometer and the like are digits of the numbers, not of the sensor.
                let difference = |value: f64| (1e6 * scale * (value - middle)).round() / 1e6;
                (*name, own.into_iter().map(difference).collect())
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
    use dataset::PoseStream;

    use super::{longest_rest, standard_deviation};

    /// Moves at 20 mm/s, but for a rest from 1 s to 1.5 s and one from 2 s to 2.2 s.
    #[test]
    fn the_longest_rest_is_found_within_what_is_asked_for() {
        let t: Vec<f64> = (0..300).map(|k| f64::from(k) / 100.0).collect();
        let way = |t: &f64| t.min(1.0) + (t - 1.5).clamp(0.0, 0.5) + (t - 2.2).max(0.0);
        let x: Vec<f64> = t.iter().map(|t| 0.02 * way(t)).collect();
        let stream = PoseStream { y: vec![0.0; t.len()], x, t, ..PoseStream::default() };
        for (asked, (from, until)) in [((0.0, 3.0), (1.0, 1.5)), ((1.6, 3.0), (2.0, 2.2))] {
            let found = longest_rest(&stream, asked).unwrap();
            assert!((found.0 - from).abs() < 0.011 && (found.1 - until).abs() < 0.011, "{found:?}");
        }
        assert_eq!(longest_rest(&stream, (4.0, 5.0)), None);
    }

    #[test]
    fn the_standard_deviation_is_that_of_a_sample() {
        assert_eq!(standard_deviation(&[1.0, 2.0, 3.0]), Some(1.0));
        assert_eq!(standard_deviation(&[1.0]), None);
    }
}
