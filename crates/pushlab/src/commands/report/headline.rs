//! What was found, in sentences.

use ::report::Section;
use diagnosis::ChannelError;
use models::Cluster;

use super::errors::floor_source;
use super::measure::Measure;
use super::{Report, Tried, tag};

/// Findings that are told on the page, and in a headline.
const MOST_FINDINGS: usize = 6;
const MOST_IN_HEADLINE: usize = 2;

/// For each model: its error against the floor, and where it fails most.
pub(super) fn headlines(report: &Report) -> Vec<String> {
    let headline = |(index, model): (usize, &Tried)| {
        let mut text = error(index, model);
        match told(model, MOST_IN_HEADLINE)[..] {
            [] => text += " It fails nowhere more than chance.",
            ref findings => text += &format!(" It {}.", findings.join("; it ")),
        }
        text
    };
    report.models.iter().enumerate().map(headline).collect()
}

/// The section that a reader begins with.
pub(super) fn section(report: &Report) -> Section {
    let mut section = Section::new("found", "What was found");
    for (index, model) in report.models.iter().enumerate() {
        section = section.text(&error(index, model));
        let findings = told(model, MOST_FINDINGS);
        section = if findings.is_empty() {
            section.text("It fails nowhere more than chance.")
        } else {
            section.list(findings.iter().map(|finding| format!("It {finding}.")).collect())
        };
    }
    section.text(&compared(report))
}

/// Where a model fails, the most first.
fn told(model: &Tried, most: usize) -> Vec<&str> {
    let findings = model.comparison.findings.iter().take(most);
    findings.map(|finding| finding.sentence.as_str()).collect()
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

/// What was compared, and what was not.
fn compared(report: &Report) -> String {
    let first = &report.models[0].comparison;
    let part = report.part.to_string();
    let mut text = floor_source(report);
    if !part.is_empty() {
        text += &format!(" Compared are {}.", part.trim());
    }
    if first.cluster == Cluster::Session {
        text += " Intervals and tests take whole measuring sessions for independent.";
    }
    if first.n_set_aside > 0 {
        text += &format!(" Rows set aside: {}.", first.set_aside);
    }
    text
}
