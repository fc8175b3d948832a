//! A comparison in words, with mm, degrees and N.

use std::fmt;

use diagnosis::{
    ChannelChange, ChannelError, Comparison, Floor, FloorSource, IntervalCalibration, NoiseFloor,
    PushEnds, Spread,
};
use effects::readable_unit;
use models::Cluster;

use super::{Against, Compared};
use crate::tool::people::lines;
use crate::tool::terminal::TITLE;
use crate::tool::unexplained::shares;

/// Width of a line of running text.
const WIDTH: usize = 96;
/// Pushes that a screen has room for.
const MOST_LINES: usize = 6;
/// Findings that a screen has room for.
const MOST_FINDINGS: usize = 8;

impl fmt::Display for Compared {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let found = &self.comparison;
        let (steps, pushes) = (found.n_steps, found.n_pushes);
        writeln!(f, "{TITLE}{}{TITLE:#} on {steps} steps of {pushes} pushes", self.model)?;
        write!(f, "{}", self.part)?;
        if found.n_excluded > 0 {
            writeln!(f, "  rows excluded: {}", found.excluded)?;
        }
        if let Some(runs) = &found.runs {
            lines(&runs.to_string(), WIDTH).iter().try_for_each(|line| writeln!(f, "  {line}"))?;
        }
        for what in &found.not_asked {
            writeln!(f, "  {what}")?;
        }
        if let Some(unexplained) = &self.unexplained {
            let shares = shares(unexplained);
            writeln!(f, "  share of what it says that no physics explains: {shares}")?;
        }
        writeln!(f, "{TITLE}error of a step, RMS{TITLE:#} ({})", self.step)?;
        found.channels.iter().try_for_each(|error| write_error(f, error))?;
        let floor = &found.floor;
        match floor.source {
            FloorSource::Repeats => {
                let (repeats, cells) = (floor.n_repeats, floor.n_cells);
                writeln!(f, "  floor: {repeats} repeats of {cells} pushes{}", widened(floor))?;
            }
            FloorSource::Neighbours => {
                writeln!(f, "  floor: an estimate from neighbours, for there are no repeats")?;
            }
        }
        write_growth(f, found)?;
        for doubtful in &found.doubtful {
            let [steps, error] = [doubtful.step_share, doubtful.error_share].map(|n| 100.0 * n);
            let (n, what) = (doubtful.n_steps, doubtful.what.name());
            writeln!(f, "  {n} steps ({steps:.1} %) {what}: {error:.0} % of the squared error")?;
        }
        if found.cluster == Cluster::Session {
            writeln!(f, "  ± and tests take whole measuring sessions for independent")?;
        }
        write_ends(f, self.roll_outs.as_ref())?;
        write_calibration(f, &found.calibration)?;
        write_findings(f, found)?;
        writeln!(f, "{TITLE}worst pushes{TITLE:#}, error of a step")?;
        for push in found.worst.iter().take(MOST_LINES) {
            let [x, y, turn] = push.rms;
            let moved = 1e3 * x.hypot(y);
            let (name, turn) = (&push.name, turn.to_degrees());
            writeln!(f, "  {} push {}: {moved:.2} mm, {turn:.2}°", name.recording, name.push)?;
        }
        self.against.as_ref().map_or(Ok(()), |against| write_against(f, against))
    }
}

/// The error of a number in one line.
pub(in crate::tool::commands) fn write_error(
    f: &mut fmt::Formatter<'_>,
    error: &ChannelError,
) -> fmt::Result {
    let ChannelError { name, rms, rms_se, nmse, floor, .. } = error;
    let (per, unit) = readable_unit(error.unit);
    write!(f, "  {name:16} {:7.3} ± {:.3} {unit:2}", per * rms, per * rms_se)?;
    if let Some(Floor { rms, low95, high95, .. }) = floor {
        let (rms, low, high) = (per * rms, per * low95, per * high95);
        write!(f, "  floor {rms:.3} ({low:.3} to {high:.3})")?;
    }
    let (bias, bias_se) = (per * error.bias, per * error.bias_se);
    write!(f, "  bias {bias:+.3} ± {bias_se:.3}")?;
    match nmse {
        Some(nmse) => writeln!(f, "  NMSE {nmse:.4}"),
        None => writeln!(f),
    }
}

/// What repeats at few places do not tell, behind how many there are.
pub(in crate::tool::commands) fn widened(floor: &NoiseFloor) -> String {
    match floor.widened[..] {
        [] => String::new(),
        _ => format!(
            "; for {} what they tell of its causes, over all steps",
            floor.widened.join(", ")
        ),
    }
}

/// Where the floor grows with the motion.
fn write_growth(f: &mut fmt::Formatter<'_>, found: &Comparison) -> fmt::Result {
    let floors = found.channels.iter().filter_map(|error| Some((error, error.floor?)));
    let growing: Vec<_> = floors
        .filter(|(_, floor)| floor.per_meter > 0.0)
        .map(|(error, floor)| {
            let (per, unit) = readable_unit(error.unit);
            let (constant, growth) = (per * floor.constant, 1e-3 * per * floor.per_meter);
            format!("{} {constant:.3} {unit} and {growth:.4} {unit} per mm", error.name)
        })
        .collect();
    if growing.is_empty() {
        return Ok(());
    }
    writeln!(f, "  it grows with the pusher's way in a step: {}", growing.join("; "))
}

fn write_ends(f: &mut fmt::Formatter<'_>, ends: Option<&PushEnds>) -> fmt::Result {
    let Some(ends) = ends else { return Ok(()) };
    let PushEnds { position, angle, n_lost, pushes } = ends;
    let n = pushes.len();
    writeln!(
        f,
        "{TITLE}mean error at the end of a push{TITLE:#}, rolled out from its start, {n} pushes"
    )?;
    for (name, per, unit, Spread { mean, median, p90 }) in
        [("place", 1e3, "mm", position), ("angle", 1.0_f64.to_degrees(), "°", angle)]
    {
        let (mean, median, p90) = (per * mean, per * median, per * p90);
        writeln!(
            f,
            "  {name:16} {mean:7.3} {unit:2}  median {median:.3}  90th percentile {p90:.3}"
        )?;
    }
    if *n_lost > 0 {
        writeln!(f, "  {n_lost} pushes lose contact in the model and not in truth")?;
    }
    Ok(())
}

/// What intervals hold, if there are any.
pub(in crate::tool::commands) fn write_calibration(
    f: &mut fmt::Formatter<'_>,
    found: &[IntervalCalibration],
) -> fmt::Result {
    if found.is_empty() {
        return Ok(());
    }
    writeln!(f, "{TITLE}what the model's own intervals hold{TITLE:#}")?;
    for number in found {
        let (per, unit) = readable_unit(number.unit);
        let [half, ninety, most] = number.coverage.map(|covered| 100.0 * covered.share);
        let (crps, nlpd) = (per * number.crps, number.nlpd);
        writeln!(
            f,
            "  {:16} 50 %: {half:.0} %  90 %: {ninety:.0} %  95 %: {most:.0} %  CRPS {crps:.3} \
             {unit}  NLPD {nlpd:.2}",
            number.name
        )?;
    }
    Ok(())
}

fn write_findings(f: &mut fmt::Formatter<'_>, found: &Comparison) -> fmt::Result {
    if found.findings.is_empty() && found.concentrations.is_empty() {
        let n = found.maps.len();
        return writeln!(
            f,
            "{TITLE}where it fails{TITLE:#}: nowhere more than chance, in {n} maps"
        );
    }
    writeln!(f, "{TITLE}where it fails{TITLE:#}, with the share of the squared error: the model")?;
    for finding in found.findings.iter().take(MOST_FINDINGS) {
        let (share, number) = (100.0 * finding.share, number_of(finding.name));
        writeln!(f, "  {share:3.0} % of {number:16} {}", finding.sentence)?;
    }
    for gathered in &found.concentrations {
        writeln!(f, "  {}", gathered.sentence)?;
    }
    let n_more = found.findings.len().saturating_sub(MOST_FINDINGS);
    if n_more > 0 {
        writeln!(f, "  and {n_more} more; --json has them and all maps")?;
    }
    Ok(())
}

/// The number that a reading in the sense of the model is of.
fn number_of(reading: &str) -> &str {
    match reading {
        "drift" => "dy",
        "turn" => "dtheta",
        other => other,
    }
}

fn write_against(f: &mut fmt::Formatter<'_>, against: &Against) -> fmt::Result {
    writeln!(f, "{TITLE}against {}{TITLE:#}", against.model)?;
    for change in &against.changes {
        let ChannelChange { name, before, after, better_share, gap_closed, .. } = change;
        let ((per, unit), better) = (readable_unit(change.unit), 100.0 * better_share);
        // d rms = d square / (2 rms).
        let se = per * change.square_change_se / (before + after).max(f64::MIN_POSITIVE);
        let (old, new) = (per * before, per * after);
        let change = new - old;
        write!(f, "  {name:16} {old:.3} → {new:.3} {unit} ({change:+.3} ± {se:.3})")?;
        write!(f, ", better in {better:.0} % of the pushes")?;
        match gap_closed {
            Some(gap) => writeln!(f, ", {:.0} % of the gap to the floor closed", 100.0 * gap)?,
            None => writeln!(f)?,
        }
    }
    Ok(())
}
