//! Figure 4.7: the table's three outputs over contact position and direction.

use std::collections::BTreeSet;

use anyhow::Result;
use dataset::{Phase, StepRow};
use report::{Claim, Color, ColorMap, Figure, Panel, Points, Table};

use super::fold;
use super::force_scan::median;
use crate::figures::claims::{judged, untestable};
use crate::figures::inputs::Inputs;
use crate::figures::sketch::Sketch;

/// What this figure settles.
pub(crate) const CLAIMS: [&str; 2] = [
    "15. β > 0 gives Δy < 0; Δy depends mainly on β, Δθ mainly on p.",
    "16. Folding the four edges into one adds noise.",
];
/// Steps whose pusher moves by the usual way, within this share, are not cut short.
const WHOLE: f64 = 0.05;
/// Directions closer to the normal than this have no sign, in rad.
const OBLIQUE: f64 = 0.1;
/// Pushes below which p and β cannot be told apart.
const FEWEST_PUSHES: usize = 10;

pub(crate) fn draw(inputs: &Inputs) -> Result<Sketch> {
    let rows = whole_steps(&inputs.table()?.rows);
    if rows.is_empty() {
        return Err(inputs.lacking("steps in contact"));
    }
    let of = |value: fn(&StepRow) -> f64| rows.iter().map(|row| value(row)).collect::<Vec<f64>>();
    let (p, beta) = (of(|row| row.p), of(|row| row.beta.to_degrees()));
    let outputs = [
        ("Δx, along the push", "Δx / mm", of(|row| 1e3 * row.dx), ColorMap::Viridis),
        ("Δy, to the left of the push", "Δy / mm", of(|row| 1e3 * row.dy), ColorMap::Diverging),
        ("Δθ, counter-clockwise", "Δθ / °", of(|row| row.dtheta.to_degrees()), ColorMap::Diverging),
    ];
    let mut figure = Figure::new(1, 3).panel_size(400.0, 310.0);
    for (title, label, values, map) in &outputs {
        let (low, high) = extremes(values, *map);
        let radius = if rows.len() > 1000 { 2.2 } else { 3.0 };
        let rims = Points::new(&p, &beta).radius(radius + 0.7).color(Color::GRAY);
        let points = Points::new(&p, &beta).radius(radius);
        let points = points.values(values, *map, label).value_range(low, high);
        figure = figure.with(
            Panel::new("contact position p", "push direction β / °")
                .title(title)
                .with(rims)
                .with(points),
        );
    }
    let [dx, dy, dtheta] = outputs.map(|(_, _, values, _)| values);
    let table = Table::new()
        .column("edge", &of(|row| f64::from(row.edge)))
        .column("p", &p)
        .column("beta_deg", &beta)
        .column("dx_mm", &dx)
        .column("dy_mm", &dy)
        .column("dtheta_deg", &dtheta);
    let way = 1e3 * rows[0].speed * rows[0].dt;
    let caption = format!(
        "The table: {} steps of {way:.1} mm each, all edges folded into one by symmetry. Colors \
         reach from the 1st to the 99th percentile.",
        rows.len()
    );
    let alt = "Three clouds of colored points over contact position and push direction.";
    let sketch = Sketch::new(figure, table, &caption, alt);
    Ok(sketch.claim(signs(&rows)).claim(fold::claim(inputs, &rows, CLAIMS[1])?))
}

/// Steps in contact that are not cut short by its end.
fn whole_steps(rows: &[StepRow]) -> Vec<&StepRow> {
    let way = |row: &StepRow| row.speed * row.dt;
    let in_contact = rows.iter().filter(|row| row.phase == Phase::Contact);
    let usual = median(in_contact.clone().map(way).collect()).unwrap_or_default();
    in_contact.filter(|row| (way(row) / usual - 1.0).abs() < WHOLE).collect()
}

/// The 1st and 99th percentile; the same on both sides of zero for a diverging map.
fn extremes(values: &[f64], map: ColorMap) -> (f64, f64) {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let at = |share: f64| sorted[(share * (sorted.len() - 1) as f64).round() as usize];
    let (low, high) = (at(0.01), at(0.99));
    let reach = low.abs().max(high.abs()).max(f64::MIN_POSITIVE);
    match map {
        ColorMap::Diverging => (-reach, reach),
        _ if low < high => (low, high),
        _ => (low - reach, high + reach),
    }
}

fn signs(rows: &[&StepRow]) -> Claim {
    let pushes: BTreeSet<_> = rows.iter().map(|row| (&row.recording, row.push)).collect();
    if pushes.len() < FEWEST_PUSHES {
        return untestable(CLAIMS[0], "fewer than ten pushes: p and β go together");
    }
    let oblique: Vec<_> = rows.iter().filter(|row| row.beta.abs() > OBLIQUE).collect();
    let opposite = oblique.iter().filter(|row| row.beta * row.dy < 0.0).count();
    let share = opposite as f64 / oblique.len().max(1) as f64;
    let of = |value: fn(&StepRow) -> f64| rows.iter().map(|row| value(row)).collect::<Vec<f64>>();
    let (p, beta) = (of(|row| row.p), of(|row| row.beta));
    let [dy_p, dy_beta] = sensitivities(&p, &beta, &of(|row| row.dy));
    let [turn_p, turn_beta] = sensitivities(&p, &beta, &of(|row| row.dtheta));
    let value = format!(
        "Δy against β in {:.0} % of {} oblique steps; a standard deviation of β changes Δy by \
         {dy_beta:.2} of its own and one of p by {dy_p:.2}; Δθ: {turn_beta:.2} and {turn_p:.2}",
        100.0 * share,
        oblique.len()
    )
    .replace('-', "\u{2212}");
    let mainly = |named: f64, other: f64| named * named > 2.0 * other * other;
    let holds = share >= 0.9 && mainly(dy_beta, dy_p) && mainly(turn_p, turn_beta);
    let reason = "signs opposite in 90 % of the steps with |β| > 0.1 rad, and the named input \
                  adds twice as much variance as the other, by linear regression on both";
    judged(CLAIMS[0], value, holds, reason)
}

/// Coefficients of the linear regression of z on x and y, all in their standard deviations.
fn sensitivities(x: &[f64], y: &[f64], z: &[f64]) -> [f64; 2] {
    let n = x.len() as f64;
    let standard = |values: &[f64]| {
        let mean = values.iter().sum::<f64>() / n;
        let sd = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt();
        let scale = if sd > 0.0 { sd } else { 1.0 };
        values.iter().map(|v| (v - mean) / scale).collect::<Vec<f64>>()
    };
    let (x, y, z) = (standard(x), standard(y), standard(z));
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / n;
    let (xy, xz, yz) = (product(&x, &y), product(&x, &z), product(&y, &z));
    // Inputs that move together cannot be told apart.
    let open = (1.0 - xy * xy).max(f64::EPSILON);
    [(xz - xy * yz) / open, (yz - xy * xz) / open]
}

#[cfg(test)]
mod tests {
    use report::ColorMap;

    use super::{extremes, sensitivities};

    #[test]
    fn sensitivities_are_told_apart_where_inputs_are_correlated() {
        let x: Vec<f64> = (0..100).map(f64::from).collect();
        let y: Vec<f64> = x.iter().map(|x| x + (x * 7.0) % 31.0).collect();
        let z: Vec<f64> = x.iter().map(|x| 3.0 - 2.0 * x).collect();
        let [by_x, by_y] = sensitivities(&x, &y, &z);
        assert!((by_x + 1.0).abs() < 1e-12 && by_y.abs() < 1e-12, "{by_x} {by_y}");
        assert_eq!(sensitivities(&x, &y, &[1.0; 100]), [0.0, 0.0]);
    }

    #[test]
    fn colors_of_signed_values_are_centered_and_never_empty() {
        assert_eq!(extremes(&[-1.0, 3.0], ColorMap::Diverging), (-3.0, 3.0));
        assert_eq!(extremes(&[1.0, 3.0], ColorMap::Viridis), (1.0, 3.0));
        let (low, high) = extremes(&[2.0, 2.0], ColorMap::Viridis);
        assert!(low < high);
    }
}
