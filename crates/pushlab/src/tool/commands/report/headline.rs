//! What was found, in sentences.

use std::fmt;

use ::report::{Region, Section};
use diagnosis::ChannelError;
use models::Cluster;
use serde::Serialize;

use super::errors::floor_source;
use super::maps::region_of;
use super::measure::Measure;
use super::{Report, Tried, tag};

/// What there is to say of a model.
#[derive(Serialize)]
pub(super) struct Headline {
    /// How wrong it is, beside the noise floor.
    error: String,
    /// Where it fails, the most first; none where it fails nowhere more than chance.
    findings: Vec<String>,
    /// The steps that each finding is about.
    #[serde(skip)]
    regions: Vec<Option<Region>>,
}

/// Findings that are told on the page, and on a terminal.
const MOST_FINDINGS: usize = 6;
const MOST_LINES: usize = 2;
/// Places where error gathers without a sign that are told on the page.
const MOST_GATHERED: usize = 3;

impl Headline {
    /// One a model.
    pub(super) fn all(report: &Report) -> Vec<Self> {
        let of = |(index, model): (usize, &Tried)| {
            let found = &model.found;
            let findings = found.findings.iter().take(MOST_FINDINGS);
            let findings = findings.map(|one| (&one.sentence, one.name, &one.region));
            let gathered = found.concentrations.iter().take(MOST_GATHERED);
            let gathered = gathered.map(|one| (&one.sentence, one.name, &one.region));
            let told = findings.chain(gathered).map(|(sentence, name, cells)| {
                (format!("It {sentence}."), region_of(report, index, name, cells))
            });
            let (findings, regions) = told.unzip();
            Self { error: error(index, model), findings, regions }
        };
        report.models.iter().enumerate().map(of).collect()
    }
}

const CONTRADICTED: &str = "These recordings contradict the mechanics. Correct this first: all that \
                            follows rests on it.";
const NOWHERE: &str = "It fails nowhere more than chance.";

impl fmt::Display for Headline {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.error)?;
        if self.findings.is_empty() {
            return writeln!(f, "  {NOWHERE}");
        }
        self.findings.iter().take(MOST_LINES).try_for_each(|finding| writeln!(f, "  {finding}"))
    }
}

/// The section that a reader begins with.
pub(super) fn section(report: &Report, headlines: &[Headline]) -> Section {
    let mut section = Section::new("found", "What was found");
    if !report.suspicions.is_empty() {
        let told = report.suspicions.iter().map(|suspicion| format!("{suspicion}."));
        section = section.text(CONTRADICTED).list(told.collect());
    }
    for Headline { error, findings, regions } in headlines {
        section = section.text(error);
        section = match findings[..] {
            [] => section.text(NOWHERE),
            _ => {
                let told = findings.iter().cloned().zip(regions.iter().cloned());
                section.linked_list(told.collect())
            }
        };
    }
    section.text(&compared(report))
}

/// How wrong a model is.
fn error(index: usize, model: &Tried) -> String {
    let channels = &model.comparison.channels;
    let part = |(name, what): (&str, &str)| {
        let error = channels.iter().find(|error| error.name == name)?;
        let rms = Measure::of(error.unit).text(error.rms);
        Some(format!("{rms} {what}{}", ratio(error)))
    };
    let motion = [("dx", "along the push"), ("dy", "sideways"), ("dtheta", "in turn")];
    let parts: Vec<String> = motion.into_iter().filter_map(part).collect();
    let end = model.ends.as_ref().map_or_else(String::new, |ends| {
        let [distance, turn] = [("m", ends.position.mean), ("rad", ends.angle.mean)]
            .map(|(unit, mean)| Measure::of(unit).text(mean));
        format!("; a whole push ends {distance} and {turn} off on average")
    });
    format!("{} – {}: a step is wrong by {}{end}.", tag(index), model.name, parts.join(", "))
}

fn ratio(error: &ChannelError) -> String {
    error.over_floor.map(|ratio| format!(" ({ratio:.1} × the noise floor)")).unwrap_or_default()
}

/// What the maps and the player show, where that is not what is compared.
fn shown(report: &Report) -> String {
    let (all, compared) = (report.all.pushes().len(), report.observations.pushes().len());
    if all == compared {
        return String::new();
    }
    let mut text = format!(
        " Where models fail, maps and player are of all {all} pushes, those of fits among them"
    );
    for (index, model) in report.models.iter().enumerate().filter(|(_, model)| model.n_fitted > 0) {
        let (tag, n) = (tag(index), model.n_fitted);
        text += &match model.is_of_all {
            true => format!("; {tag} was fitted to {n} of them, and fits these a little better"),
            false => format!("; {tag} learnt from {n} of them, and is mapped on the others alone"),
        };
    }
    text + "."
}

/// What was compared, and what was not.
fn compared(report: &Report) -> String {
    let first = &report.models[0].comparison;
    let part = report.part.to_string();
    let mut text = floor_source(report);
    if !part.is_empty() {
        text += &format!(" Compared are {}.", part.trim());
    }
    text += &shown(report);
    if first.cluster == Cluster::Session {
        text += " Intervals and tests take whole measuring sessions for independent.";
    }
    if !first.not_asked.is_empty() {
        text += &format!(" Not told: {}.", first.not_asked.join("; "));
    }
    if first.n_excluded > 0 {
        text += &format!(" Rows excluded: {}.", first.excluded);
    }
    text
}
