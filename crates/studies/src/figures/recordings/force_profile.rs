//! Figure 4.4: the force over a push, with its zero and the contact found in it.

use anyhow::Result;
use dataset::ForceZero;
use report::{Claim, Color, Figure, Guide, LegendPlace, Line, Panel};
use serde_json::json;

use super::choice::Choice;
use super::force_scan::{Forces, median};
use crate::figures::claims::{judged, untestable};
use crate::figures::inputs::Inputs;
use crate::figures::sketch::Sketch;

/// What this figure settles.
pub(crate) const CLAIMS: [&str; 3] = [
    "1. The steady pushing force is about μs·m·g.",
    "2. Force alone finds the start and the end of contact.",
    "14. Contact starts with a short static peak of force.",
];
/// Pushes that carry the object straight: these need the whole friction force.
const CENTRAL: (f64, f64) = (0.11, 0.36);
/// Shown before first contact and after rest, in s.
const MARGIN: f64 = 0.6;
/// Largest error of a start or end that counts as found, in s.
const FOUND: f64 = 0.1;
/// Pushes below which nothing is said.
const FEWEST_PUSHES: usize = 5;

pub(crate) fn draw(inputs: &Inputs) -> Result<Sketch> {
    let report = inputs.ingest_report()?;
    let with_force = |choice: &Choice| choice.recording.force_zero != ForceZero::NoForce;
    let tared = |choice: &Choice| matches!(choice.recording.force_zero, ForceZero::Tared { .. });
    let middle = (0.5, 0.0);
    let known = Choice::nearest(report, middle, tared);
    let unknown = Choice::nearest(report, middle, |c| with_force(c) && !tared(c));
    let chosen: Vec<_> = known.into_iter().chain(unknown).collect();
    if chosen.is_empty() {
        return Err(inputs.lacking("measured forces"));
    }
    let scans = scan(inputs)?;
    let (mut panels, mut data) = (Vec::new(), Vec::new());
    for choice in &chosen {
        let Some((_, forces)) = scans.iter().find(|(of, _)| std::ptr::eq(of.push, choice.push))
        else {
            continue;
        };
        panels.push(panel(choice, forces, nominal(inputs, choice)?));
        data.push(json!({
            "recording": choice.recording.name,
            "push": choice.push.push,
            "since_contact_s": forces.t,
            "recorded_n": forces.recorded,
            "zero_subtracted_n": forces.tared,
            "contact_s": choice.contact_end() - choice.push.contact_start_s,
            "zero": choice.recording.force_zero,
        }));
    }
    let mut figure = Figure::new(1, panels.len()).panel_size(580.0, 390.0);
    for panel in panels {
        figure = figure.with(panel);
    }
    let caption = "Magnitude of the force between pusher and object. The zero is the force read \
                   while geometry says that the pusher is free; with it subtracted, the force \
                   tells contact (shaded) from no contact. Where the zero is not known or is lost \
                   during a push, geometry alone decides.";
    let alt = "A force that rises at contact, stays about constant and falls at its end.";
    let mut sketch = Sketch::new(figure, json!(data), caption, alt);
    for claim in [steady(inputs, &scans)?, force_alone(inputs, &scans)?, static_peak(&scans)] {
        sketch = sketch.claim(claim);
    }
    Ok(sketch)
}

/// The forces of every push that has some.
fn scan(inputs: &Inputs) -> Result<Vec<(Choice<'_>, Forces)>> {
    let report = inputs.ingest_report()?;
    let mut scans = Vec::new();
    for recording in &report.recordings {
        let own: Vec<_> =
            Choice::all(report).filter(|c| std::ptr::eq(c.recording, recording)).collect();
        if own.is_empty() || recording.force_zero == ForceZero::NoForce {
            continue;
        }
        if let Some(wrench) = &inputs.recording(&recording.name)?.wrench {
            scans.extend(own.into_iter().map(|choice| (choice, Forces::of(&choice, wrench))));
        }
    }
    Ok(scans)
}

fn panel(choice: &Choice, forces: &Forces, nominal: f64) -> Panel {
    let end = choice.contact_end() - choice.push.contact_start_s;
    let rest = choice.push.rest_s - choice.push.contact_start_s;
    let shown: Vec<_> = (0..forces.t.len())
        .filter(|&i| (-MARGIN..rest.max(end) + MARGIN).contains(&forces.t[i]))
        .collect();
    let pick = |from: &[f64]| shown.iter().map(|&i| from[i]).collect::<Vec<f64>>();
    let t = pick(&forces.t);
    let state = if forces.tared.is_empty() { "zero not known" } else { "zero known" };
    let mut panel = Panel::new("time since first contact / s", "force / N")
        .title(&format!("{}: {state}", choice.place()))
        .legend(LegendPlace::Below)
        .with(Guide::interval(0.0, end).color(Color::GREEN).label("contact"))
        .with(Guide::horizontal(nominal).dashed().label(&format!("μs·m·g = {nominal:.2} N")))
        .with(Line::new(&t, &pick(&forces.recorded)).color(Color::ORANGE).label("as recorded"));
    if !forces.tared.is_empty() {
        let line = Line::new(&t, &pick(&forces.tared)).color(Color::BLUE);
        panel = panel.with(line.label("zero subtracted"));
    }
    panel
}

/// μs·m·g of a push's object, in N.
fn nominal(inputs: &Inputs, choice: &Choice) -> Result<f64> {
    let support = inputs.support()?;
    Ok(support.friction * support.gravity * inputs.object(&choice.recording.name)?.mass)
}

fn steady(inputs: &Inputs, scans: &[(Choice, Forces)]) -> Result<Claim> {
    let mut ratios = (Vec::new(), Vec::new());
    let mut forces = Vec::new();
    for (choice, _) in scans {
        let Some(force) = choice.push.steady_force_n else { continue };
        let ratio = force / nominal(inputs, choice)?;
        ratios.1.push(ratio);
        let first = &choice.first;
        if (first.p - 0.5).abs() <= CENTRAL.0 && first.beta_rad.abs() <= CENTRAL.1 {
            ratios.0.push(ratio);
            forces.push(force);
        }
    }
    let n = ratios.0.len();
    let all = median(ratios.1);
    if n < FEWEST_PUSHES {
        let reason = format!("{n} central pushes with a known force zero, five are needed");
        return Ok(untestable(CLAIMS[0], &reason));
    }
    let (Some(central), Some(force), Some(all)) = (median(ratios.0), median(forces), all) else {
        return Ok(untestable(CLAIMS[0], "no central push with a known force zero"));
    };
    let value = format!(
        "{force:.2} N, {central:.2} of μs·m·g, in the median of {n} central pushes ({all:.2} of \
         it over all)"
    );
    let reason = "within 10 % of μs·m·g for pushes at |p − 0.5| ≤ 0.1 and |β| ≤ 20°; a push that \
                  turns the object needs less";
    Ok(judged(CLAIMS[0], value, (central - 1.0).abs() <= 0.1, reason))
}

fn force_alone(inputs: &Inputs, scans: &[(Choice, Forces)]) -> Result<Claim> {
    let (mut starts, mut ends, mut both) = (0, 0, 0);
    for (choice, forces) in scans {
        let Some((from, to)) = forces.contact_by_force(0.25 * nominal(inputs, choice)?) else {
            continue;
        };
        let length = choice.contact_end() - choice.push.contact_start_s;
        let (start, end) = (from.abs() <= FOUND, (to - length).abs() <= FOUND);
        starts += usize::from(start);
        ends += usize::from(end);
        both += usize::from(start && end);
    }
    let n = scans.len();
    if n < FEWEST_PUSHES {
        return Ok(untestable(CLAIMS[1], "fewer than five pushes with forces"));
    }
    let value = format!("start found in {starts}, end in {ends}, both in {both} of {n} pushes");
    let reason = "both within 0.1 s of the contact by force and geometry in 95 % of the pushes; \
                  force alone: from a quarter of μs·m·g off its first level to half of its median";
    Ok(judged(CLAIMS[1], value, both as f64 >= 0.95 * n as f64, reason))
}

fn static_peak(scans: &[(Choice, Forces)]) -> Claim {
    let ratios: Vec<_> = scans.iter().filter_map(|(_, forces)| forces.peak_over_level()).collect();
    let (n, peaks) = (ratios.len(), ratios.iter().filter(|ratio| **ratio > 1.1).count());
    let Some(ratio) = median(ratios).filter(|_| n >= FEWEST_PUSHES) else {
        return untestable(CLAIMS[2], "fewer than five pushes with a known force zero");
    };
    let value = format!("peak over level {ratio:.2} in the median; above 1.1 in {peaks} of {n}");
    let reason = "largest force within 0.15 s of first contact above 1.1 times the median of the \
                  next 0.25 s, in more than half of the pushes";
    judged(CLAIMS[2], value, 2 * peaks > n, reason)
}
