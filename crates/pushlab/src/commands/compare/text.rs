//! A comparison in words, with mm, degrees and N.

use std::fmt;

use diagnosis::{ChannelChange, ChannelError, Comparison, Floor, FloorSource};

use super::{Against, Compared};
use crate::terminal::TITLE;

/// Pushes that a screen has room for.
const MOST_LINES: usize = 6;

impl fmt::Display for Compared {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let found = &self.comparison;
        let (steps, pushes) = (found.n_steps, found.n_pushes);
        writeln!(f, "{TITLE}{}{TITLE:#} on {steps} steps of {pushes} pushes", self.model)?;
        if found.n_set_aside > 0 {
            writeln!(f, "  rows set aside: {}", found.set_aside)?;
        }
        writeln!(f, "{TITLE}error of a step, RMS{TITLE:#}")?;
        found.channels.iter().try_for_each(|error| write_error(f, error))?;
        let floor = &found.floor;
        match floor.source {
            FloorSource::Repeats => {
                let (repeats, cells) = (floor.n_repeats, floor.n_cells);
                writeln!(f, "  floor: {repeats} repeats of {cells} pushes")?;
            }
            FloorSource::Neighbours => {
                writeln!(f, "  floor: an estimate from neighbours, for there are no repeats")?;
            }
        }
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

/// A number of SI units per unit for people, and that unit.
fn people(unit: &str) -> (f64, &str) {
    match unit {
        "m" => (1e3, "mm"),
        "rad" => (1.0_f64.to_degrees(), "°"),
        "1" => (1.0, ""),
        other => (1.0, other),
    }
}

fn write_error(f: &mut fmt::Formatter<'_>, error: &ChannelError) -> fmt::Result {
    let ChannelError { name, rms, rms_se, nmse, floor, .. } = error;
    let (per, unit) = people(error.unit);
    write!(f, "  {name:16} {:7.3} ± {:.3} {unit:2}", per * rms, per * rms_se)?;
    if let Some(Floor { rms, low95, high95 }) = floor {
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

fn write_findings(f: &mut fmt::Formatter<'_>, found: &Comparison) -> fmt::Result {
    if found.findings.is_empty() {
        let n = found.maps.len();
        return writeln!(f, "{TITLE}where it fails{TITLE:#}: nowhere more than chance, in {n} maps");
    }
    writeln!(f, "{TITLE}where it fails{TITLE:#}: the model")?;
    for finding in found.findings.iter().take(MOST_LINES) {
        let share = 100.0 * finding.share;
        let (steps, pushes) = (finding.n_steps, finding.n_pushes);
        writeln!(f, "  {}", finding.sentence)?;
        writeln!(
            f,
            "    {share:.0} % of the squared error of {}, {steps} steps of {pushes} pushes",
            number_of(finding.name)
        )?;
    }
    let n_more = found.findings.len().saturating_sub(MOST_LINES);
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
        let ((per, unit), better) = (people(change.unit), 100.0 * better_share);
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
