//! Bars of a diagnosis: gains, and errors before and after.

use ::report::{
    Axis, Bars, Color, Drawing, ErrorBars, Figure, Guide, Hover, LegendPlace, Panel, ReportError,
};
use diagnosis::{Diagnosis, EffectFinding, ErrorFall, Gain, MotionError};

use super::super::measure::{Measure, title};

const WIDTH: f64 = 0.6;

/// The gain of each effect that was added and confirmed; nothing where none was.
pub(super) fn gains(found: &Diagnosis) -> Result<Vec<Drawing>, ReportError> {
    let gain = |effect: &EffectFinding| Some((effect.id.clone(), effect.log_density_gain?));
    let gains: Vec<(String, Gain)> = found.effects.iter().filter_map(gain).collect();
    if gains.is_empty() {
        return Ok(Vec::new());
    }
    let ends = gains.iter().flat_map(|(_, gain)| [gain.mean - gain.se, gain.mean + gain.se]);
    let (low, high) = ends.fold((0.0, 0.0), |(a, b): (f64, f64), x| (a.min(x), b.max(x)));
    let room = 0.08 * (high - low).max(1e-9);
    let n = gains.len();
    let names: Vec<(f64, String)> = (1..=n).map(|k| (k as f64, k.to_string())).collect();
    let x = Axis::new("effect").range(0.4, n as f64 + 0.6).names(&names);
    let y = Axis::new("gain in nats").range(low - if low < 0.0 { room } else { 0.0 }, high + room);
    let mut panel = Panel::new(x, y).title("gain on held-out pushes").legend(LegendPlace::Hidden);
    let mut hover = Hover::new();
    for (index, (id, Gain { mean, se })) in gains.iter().enumerate() {
        let x = [index as f64 + 1.0];
        panel = panel
            .with(Bars::new(&x, &[*mean], WIDTH).color(Color::cycle(index)))
            .with(ErrorBars::new(&x, &[mean - se], &[mean + se]).color(Color::INK));
        let text = format!("{id}\n{mean:.1} ± {se:.1} nats");
        let (from, to) = (mean.min(0.0), mean.max(0.0));
        hover = hover.cell([x[0] - 0.3, from], [x[0] + 0.3, to], &text);
    }
    let names: Vec<String> =
        gains.iter().enumerate().map(|(k, (id, _))| format!("{} {id}", k + 1)).collect();
    let figure = Figure::new(1, 1).panel_size(300.0, 210.0).with(panel.with(hover));
    Ok(vec![Drawing::new(&figure, &names.join(", "))?])
}

/// One number of a step in a diagnosis.
type Pick = fn(&MotionError) -> Option<f64>;

/// A number of a step with its unit, the error before and after, and the floor.
pub(super) type Fall = (&'static str, &'static str, [f64; 2], Option<f64>);

/// The numbers of a step whose errors are known.
pub(super) fn numbers(error: &ErrorFall) -> Vec<Fall> {
    let numbers: [(&str, &str, Pick); 5] = [
        ("dx", "m", |motion| motion.dx_m),
        ("dy", "m", |motion| motion.dy_m),
        ("dtheta", "rad", |motion| motion.dtheta_rad),
        ("force_normal", "N", |motion| motion.force_normal_n),
        ("force_tangential", "N", |motion| motion.force_tangential_n),
    ];
    let known = numbers.into_iter().filter_map(|(name, unit, pick)| {
        let errors = [pick(&error.before_si)?, pick(&error.after_si)?];
        Some((name, unit, errors, pick(&error.floor_si)))
    });
    known.collect()
}

/// Error before and after, beside the floor, of each number of a step.
pub(super) fn errors(error: &ErrorFall) -> Result<Vec<Drawing>, ReportError> {
    let numbers = numbers(error).into_iter();
    numbers.map(|(name, unit, errors, floor)| fall(name, unit, errors, floor)).collect()
}

fn fall(
    name: &str,
    unit: &'static str,
    errors: [f64; 2],
    floor: Option<f64>,
) -> Result<Drawing, ReportError> {
    let measure = Measure::of(unit);
    let top = errors.into_iter().chain(floor).fold(0.0, f64::max);
    let x = Axis::new("model").range(0.4, 2.6).names(&[(1.0, "before"), (2.0, "after")]);
    let y = Axis::new(&measure.label("error")).range(0.0, (1.1 * measure.per * top).max(1e-12));
    let mut panel = Panel::new(x, y).title(title(name)).legend(LegendPlace::Hidden);
    let mut hover = Hover::new();
    for (index, (what, rms)) in ["before", "after"].into_iter().zip(errors).enumerate() {
        let (x, height) = (index as f64 + 1.0, measure.per * rms);
        let color = [Color::GRAY, Color::BLUE][index];
        panel = panel.with(Bars::new(&[x], &[height], WIDTH).color(color));
        let text = format!("{what}: {}", measure.text(rms));
        hover = hover.cell([x - 0.3, 0.0], [x + 0.3, height], &text);
    }
    let mut caption = format!("{} → {}", measure.text(errors[0]), measure.text(errors[1]));
    if let Some(floor) = floor {
        panel = panel.with(Guide::horizontal(measure.per * floor));
        caption += &format!(", floor {}", measure.text(floor));
    }
    let figure = Figure::new(1, 1).panel_size(230.0, 190.0).with(panel.with(hover));
    Drawing::new(&figure, &caption)
}
