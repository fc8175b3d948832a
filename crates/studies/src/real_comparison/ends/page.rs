//! The section about the ends of long pushes.

use std::fmt::Write as _;

use diagnosis::{Diagnosis, EffectFinding, Grade, ParameterFinding, Verdict};

use super::{Ends, Error};

/// More are places that a picture tells better.
const MOST_VALUES: usize = 4;
/// Hints that are told of an object.
const MOST_HINTS: usize = 4;

/// The section.
pub(in crate::real_comparison) fn text(ends: &[Ends]) -> String {
    let mut page = HEAD.to_owned();
    for one in ends {
        page += &row(one);
    }
    page += &means(ends);
    page += TAIL;
    for one in ends {
        let text = match &one.found {
            Ok(found) => format!("{}\n{}", found.sentence, hints(found)),
            Err(error) => format!("The diagnosis ends with an error: {error}.\n"),
        };
        let _ = write!(page, "\n**{}.** {text}", one.shape);
    }
    page
}

const HEAD: &str = "
## What is missing in long pushes of every shape

What `pushlab diagnose` says of the pushes of the section before. Compared is the motion alone. Neither
sessions nor the order of the pushes nor repeats are known: every push is a cluster of its own, and the
noise is an estimate from neighbors. Of each object's pushes every second or third is taken for the
diagnosis, so that no more than 150 are. Each object is diagnosed by itself, with μp = 0.25 and uniform
pressure to begin with.

Mean distance and mean angle between the predicted and the measured end, before and after all that
`pushlab add --all` takes is added, on the quarter of the pushes that the diagnosis holds out.

| object | pushes, flips | verdict | named | before | after |
|---|---|---|---|---|---|
";

const TAIL: &str = "
What the diagnosis says of each object, in its own words (“per step” is per push here), and the hints that
it does not claim:
";

fn row(one: &Ends) -> String {
    let (verdict, named) = match &one.found {
        Ok(found) => (verdict(found.verdict), named(found)),
        Err(_) => ("no answer", "–".to_owned()),
    };
    let [before, after] = one.errors.map(|error| error.to_string());
    let Ends { shape, n_used, n_pushes, n_flips, .. } = one;
    format!(
        "| {shape} | {n_used} of {n_pushes}, {n_flips} | {verdict} | {named} | {before} | {after} |\n"
    )
}

fn verdict(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Identified => "identified",
        Verdict::Ambiguous => "ambiguous",
        Verdict::Effective => "effective",
        Verdict::Unexplained => "unexplained",
        Verdict::NoneFound => "none found",
        Verdict::Inconclusive => "inconclusive",
    }
}

fn named(found: &Diagnosis) -> String {
    let groups = found.ambiguous.iter().map(|group| group.join(" or "));
    let effective = found.effective.iter().map(|id| format!("{id} (effective)"));
    let named: Vec<String> =
        found.identified.iter().cloned().chain(groups).chain(effective).collect();
    if named.is_empty() { "–".to_owned() } else { named.join(", ") }
}

/// The mean of the objects' errors, each object counted once.
fn means(ends: &[Ends]) -> String {
    let mean = |k: usize| {
        let mut sum = Error::default();
        for one in ends {
            sum.position += one.errors[k].position;
            sum.angle += one.errors[k].angle;
        }
        sum.over(ends.len()).to_string()
    };
    let count = |of: fn(&Ends) -> usize| ends.iter().map(of).sum::<usize>();
    let (used, all) = (count(|one| one.n_used), count(|one| one.n_pushes));
    let flips = count(|one| one.n_flips);
    format!("| mean of the objects | {used} of {all}, {flips} | | | {} | {} |\n", mean(0), mean(1))
}

/// What is claimed with its values, and hints with what speaks against each.
fn hints(found: &Diagnosis) -> String {
    let is = |grade: Grade| found.effects.iter().filter(move |one| one.grade == grade);
    let mut text = String::new();
    for effect in is(Grade::Identified).chain(is(Grade::Ambiguous)).chain(is(Grade::Effective)) {
        let _ = writeln!(text, "- {}: {}", effect.id, values(effect));
    }
    for effect in is(Grade::Hint).take(MOST_HINTS) {
        let why = if effect.why.is_empty() { "not sure enough" } else { &effect.why };
        let _ = writeln!(text, "- hint: {} ({why})", effect.id);
    }
    if text.is_empty() { text } else { format!("\n{text}") }
}

fn values(effect: &EffectFinding) -> String {
    let value = |parameter: &ParameterFinding| {
        let ParameterFinding { name, unit, estimate, low95, high95, .. } = parameter;
        let (per, unit) = match unit.as_str() {
            "m" => (1e3, " mm"),
            "rad" => (1.0_f64.to_degrees(), "°"),
            "1" => (1.0, ""),
            other => (1.0, other),
        };
        let number = |value: f64| format!("{:.3}", per * value).replace('-', "−");
        let ends = low95.zip(*high95);
        let ends = ends.map(|(low, high)| format!(" ({} to {})", number(low), number(high)));
        Some(format!("{name} {}{unit}{}", number((*estimate)?), ends.unwrap_or_default()))
    };
    if effect.parameters.len() > MOST_VALUES {
        return effect.why.clone();
    }
    effect.parameters.iter().filter_map(value).collect::<Vec<_>>().join(", ")
}
