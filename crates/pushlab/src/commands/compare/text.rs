//! A comparison in words, with mm, degrees and N.

use std::fmt;

use diagnosis::{Cell, ChannelChange, ChannelError, Covariate, Floor, FloorSource, ResidualMap};

use super::{Against, Compared};
use crate::people::people;
use crate::terminal::TITLE;

/// Pushes that a screen has room for.
const MOST_LINES: usize = 6;
/// Probability below which a map is shown as structure.
const SURE: f64 = 0.05;

impl fmt::Display for Compared {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let found = &self.comparison;
        let (steps, pushes) = (found.n_steps, found.n_pushes);
        writeln!(f, "{TITLE}{}{TITLE:#} on {steps} steps of {pushes} pushes", self.model)?;
        write!(f, "{}", self.part)?;
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
        write_maps(f, &found.maps)?;
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

fn write_maps(f: &mut fmt::Formatter<'_>, maps: &[ResidualMap]) -> fmt::Result {
    let sure = maps.iter().filter(|map| map.p_adjusted <= SURE);
    let sure: Vec<_> = sure.map(|map| (map.name, map)).collect();
    // The surest of each number: structure shows in several covariates at once.
    let first = |(index, (name, _)): &(usize, &(&str, _))| {
        sure[..*index].iter().all(|(other, _)| other != name)
    };
    let first = sure.iter().enumerate().filter(first).map(|(_, (_, map))| *map);
    if sure.is_empty() {
        let n = maps.len();
        return writeln!(f, "{TITLE}no structure{TITLE:#} in {n} maps of the mean residual");
    }
    let title = format!("{TITLE}where it fails{TITLE:#}: observed less predicted, on average");
    writeln!(f, "{title}")?;
    for map in first.clone() {
        // The cell whose interval is farthest from zero, in its own widths.
        let distance = |cell: &Cell| cell.mean.abs() / (cell.high95 - cell.low95);
        let worst = map.cells.iter().max_by(|a, b| distance(a).total_cmp(&distance(b)));
        let Some(cell) = worst else { continue };
        let (per, unit) = people(map.unit);
        let half = 0.5 * per * (cell.high95 - cell.low95);
        let place = place(map.covariate, cell);
        let (mean, name, p) = (per * cell.mean, map.name, map.p_adjusted);
        writeln!(f, "  {name} {mean:+.3} ± {half:.3} {unit} {place} (p {p:.3})")?;
    }
    let n_more = sure.len() - first.count();
    if n_more > 0 {
        writeln!(f, "  and {n_more} more maps; --json has them all")?;
    }
    Ok(())
}

fn place(covariate: Covariate, cell: &Cell) -> String {
    let (per, unit) = people(covariate.unit());
    let (from, to) = (per * cell.from, per * cell.to);
    let range = |name: &str| format!("at {name} from {from:.1}{unit} to {to:.1}{unit}");
    match covariate {
        Covariate::Edge => format!("on edge {:.0}", 0.5 * (from + to)),
        Covariate::P => format!("at p from {from:.1} to {to:.1}"),
        Covariate::Beta => range("β"),
        Covariate::Orientation => range("a yaw"),
        Covariate::Direction => range("a push towards"),
        Covariate::TableX => range("x "),
        Covariate::TableY => range("y "),
        Covariate::Time => format!("from {:.0} to {:.0} % of the set", 100.0 * from, 100.0 * to),
        Covariate::Speed => {
            format!("at {:.0} to {:.0} mm/s", 1e3 * cell.from, 1e3 * cell.to)
        }
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
