//! What a step table holds, in numbers.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use dataset::{Coverage, Flags, Phase, Table};
use serde::Serialize;

use crate::tool::terminal::TITLE;

/// Counts over a step table and where in its inputs the rows lie.
#[derive(Serialize)]
pub(crate) struct TableSummary {
    rows: usize,
    recordings: usize,
    pushes: usize,
    sessions: usize,
    /// Rows of each phase.
    phases: BTreeMap<String, usize>,
    /// Rows of each shape.
    shapes: BTreeMap<String, usize>,
    /// Rows with a measured force.
    with_force: usize,
    /// Smallest and largest length of a step.
    dt_s: [f64; 2],
    /// Rows with each flag.
    flags: BTreeMap<&'static str, usize>,
    /// Where the rows in contact lie.
    coverage: Coverage,
    /// What the table carries of its making.
    provenance: Vec<(String, String)>,
}

impl TableSummary {
    pub(crate) fn of(table: &Table) -> Self {
        let (mut phases, mut shapes) = (BTreeMap::new(), BTreeMap::new());
        let mut flags = BTreeMap::new();
        let mut coverage = Coverage::default();
        let mut dt_s = [f64::INFINITY, 0.0_f64];
        for row in &table.rows {
            *phases.entry(row.phase.to_string()).or_default() += 1;
            *shapes.entry(row.shape.to_string()).or_default() += 1;
            for (flag, name) in Flags::ALL {
                if row.flags.contains(flag) {
                    *flags.entry(name).or_default() += 1;
                }
            }
            coverage.add(row);
            dt_s = [dt_s[0].min(row.dt), dt_s[1].max(row.dt)];
        }
        let rows = &table.rows;
        let recordings: BTreeSet<_> = rows.iter().map(|row| &*row.recording).collect();
        let pushes: BTreeSet<_> = rows.iter().map(|row| (&*row.recording, row.push)).collect();
        let sessions: BTreeSet<_> = rows.iter().filter_map(|row| row.session.as_deref()).collect();
        Self {
            rows: rows.len(),
            recordings: recordings.len(),
            pushes: pushes.len(),
            sessions: sessions.len(),
            phases,
            shapes,
            with_force: rows.iter().filter(|row| row.force.is_some()).count(),
            dt_s,
            flags,
            coverage,
            provenance: table.provenance.entries.clone(),
        }
    }
}

impl fmt::Display for TableSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let contact = Phase::Contact.to_string();
        writeln!(
            f,
            "{TITLE}{} rows{TITLE:#} of {} pushes in {} recordings, {} of them in contact",
            self.rows,
            self.pushes,
            self.recordings,
            self.phases.get(&contact).copied().unwrap_or_default()
        )?;
        let counts = |counts: &mut dyn Iterator<Item = (&str, usize)>| {
            counts.map(|(name, n)| format!("{n} {name}")).collect::<Vec<_>>().join(", ")
        };
        let shapes = counts(&mut self.shapes.iter().map(|(name, n)| (name.as_str(), *n)));
        writeln!(f, "  shapes: {shapes}")?;
        writeln!(
            f,
            "  steps of {:.3} to {:.3} s, {} with force",
            self.dt_s[0], self.dt_s[1], self.with_force
        )?;
        let flags = counts(&mut self.flags.iter().map(|(name, n)| (*name, *n)));
        if !flags.is_empty() {
            writeln!(f, "  flags: {flags}")?;
        }
        write!(f, "{}", self.coverage)?;
        writeln!(f, "{TITLE}made by{TITLE:#}")?;
        // The settings are a line of JSON that nobody reads here, the sources one line a recording.
        let is_short = |key: &str| !["settings", "source"].contains(&key);
        for (key, value) in self.provenance.iter().filter(|(key, _)| is_short(key)) {
            writeln!(f, "  {key}: {value}")?;
        }
        let sources: Vec<_> = self.provenance.iter().filter(|(key, _)| key == "source").collect();
        match sources[..] {
            [] => Ok(()),
            [(_, only)] => writeln!(f, "  source: {only}"),
            _ => writeln!(f, "  sources: {}, with their SHA-256 in the table", sources.len()),
        }
    }
}
