//! What a diagnosis says: what is missing, how sure that is, and what else it could be.

mod card;
mod charts;
mod remains;
mod signatures;

use ::report::{ReportError, Section};
use diagnosis::{
    Diagnosis, EffectFinding, Gain, Grade, Leftover, ParameterFinding, PushScatter, Verdict,
};
use effects::by_id;

pub(super) use self::signatures::Signatures;

use super::measure::Measure;

/// The section of a diagnosis.
pub(super) fn section(found: &Diagnosis, signatures: &Signatures) -> Result<Section, ReportError> {
    let mut section = Section::new("diagnosis", "What is missing")
        .text(&found.sentence)
        .text(reading(found.verdict));
    section = card::card(found, section);
    let gains = charts::gains(found)?;
    if !gains.is_empty() {
        section = section.text(GAINS).drawings(gains);
    }
    let errors = charts::errors(&found.error)?;
    if !errors.is_empty() {
        section = section.text(ERRORS).drawings(errors);
    }
    if !signatures.drawings.is_empty() {
        section = section.text(SIGNATURES).drawings(signatures.drawings.clone());
    }
    for note in &signatures.notes {
        section = section.text(note);
    }
    let claimed = rows(found, |effect| is_added(effect.grade));
    if !claimed.is_empty() {
        let head = ["effect", "said", "p", "gain in nats", "gap closed", "values (95 %)"];
        section = section.table(&head, claimed);
    }
    let is_doubted = |one: &&EffectFinding| one.grade != Grade::Identified || one.small;
    let doubted = found.effects.iter().filter(|one| is_added(one.grade)).filter(is_doubted);
    let doubted: Vec<_> = doubted.map(|one| vec![one.id.clone(), one.why.clone()]).collect();
    if !doubted.is_empty() {
        section = section.table(&["effect", "why its cause may be another"], doubted);
    }
    section = alike(found, section);
    section = section.text(&left(&found.leftover));
    if let Some(remains) = &found.remains {
        section = remains::told(remains, section);
    }
    Ok(rest(found, scatter(&found.noise.push_to_push, section)))
}

/// What differs from push to push.
fn scatter(scatter: &[PushScatter], section: Section) -> Section {
    if scatter.is_empty() {
        return section;
    }
    let row = |one: &PushScatter| {
        let PushScatter { effect, unit, sd, low95, high95, share } = one;
        let measure = measure(unit);
        let size = format!(
            "{} ({} to {})",
            measure.text(*sd),
            measure.number(*low95),
            measure.number(*high95)
        );
        vec![effect.clone(), size, format!("{:.0} %", 100.0 * share)]
    };
    section
        .text(
            "What differs from push to push, and makes the pushes of one kind end differently: no model of these \
             inputs can foresee it, but it can be told how much it is. `pushlab add --all --from DIAGNOSIS` gives \
             what is a twentieth or more to a model, which then predicts the scatter as well.",
        )
        .table(
            &["effect", "standard deviation (95 %)", "share of what is noise to the model"],
            scatter.iter().map(row).collect(),
        )
}

const GAINS: &str = "Gain in log predictive density by each effect, in nats, on pushes that no fit \
     has seen, with one standard error. It says how much better these pushes are predicted with the effect \
     than without; it does not say how large the effect is, and a gain of many hundred is no more \
     true than one of fifty: more pushes make it longer.";
const ERRORS: &str = "Error of a step before and after the claimed effects are added, on the held-out \
     pushes; the gray line is the noise floor, as far as repeats or alike pushes tell it: pushes without \
     repeats tell it roughly, and a few held-out ones may err by less. A bar that stays well above the line means that something else is missing, not that the effect is wrong.";
const SIGNATURES: &str = "What each effect changes, beside what the model misses, in the number of a step and over \
     what the effect shows most, in units of the noise floor. Both are of all pushes, those \
     of the fit among them: they show where, and the bars above show how much on held-out pushes. Where both \
     agree, cell by cell, that speaks for it. It is no proof: look-alikes have nearly the same picture, and the \
     verdict weighs all numbers of a step, not this one alone. Of two maps the slider shows the effect on its \
     left, and the model on its right.";

/// What a verdict means, and what it does not.
fn reading(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Identified => {
            "Identified: the effect is surer than chance allows in one of a hundred sets, matters beside \
             the noise, has an interval without “off”, has no rival that explains as much, and \
             predicts held-out pushes. It is not proof that the part of the rig behind \
             it is broken: an effect that the library does not know can look the same."
        }
        Verdict::Ambiguous => {
            "Ambiguous: something is missing, and the pushes cannot tell which effect of the \
             group it is. The first of the list is not likelier than the others. `pushlab suggest` \
             tells which pushes would decide."
        }
        Verdict::Effective => {
            "Effective: the error on held-out pushes falls with the effect, but another cause may be \
             behind it: the table says why. Add it to \
             predict better; do not take its name for the cause."
        }
        Verdict::Unexplained => {
            "Unexplained: the model fails in a way that no effect of the library removes. \
             An effect in the tables below is a hint then, and adding it would be wrong."
        }
        Verdict::NoneFound => {
            "None found: nothing is missing that these pushes could show. It does not mean that \
             nothing is missing: see the limits, and what cannot be tested."
        }
        Verdict::Inconclusive => {
            "Inconclusive: there are hints, and none passes every rule. To add one because it is the best of \
             them would be to choose by chance."
        }
    }
}

/// Whether `add --all` may take it.
fn is_added(grade: Grade) -> bool {
    matches!(grade, Grade::Identified | Grade::Ambiguous | Grade::Effective)
}

fn rows(found: &Diagnosis, is_told: impl Fn(&&EffectFinding) -> bool) -> Vec<Vec<String>> {
    let row = |effect: &EffectFinding| {
        let said = match effect.grade {
            _ if effect.small => "there, hardly seen",
            Grade::Identified => "missing",
            Grade::Ambiguous => "one of a group",
            Grade::Effective => "effective",
            _ => "",
        };
        let gain = effect.log_density_gain;
        let gain = gain.map_or_else(dash, |Gain { mean, se }| format!("{mean:.1} ± {se:.1}"));
        let closed = effect.gap_closed.map_or_else(dash, |share| format!("{:.0} %", 100.0 * share));
        let p = effect.p_adjusted.map_or_else(dash, |p| format!("{p:.4}"));
        let values = effect.parameters.iter().filter_map(value).collect::<Vec<_>>().join("; ");
        vec![effect.id.clone(), said.to_owned(), p, gain, closed, values]
    };
    found.effects.iter().filter(is_told).map(row).collect()
}

fn dash() -> String {
    "–".to_owned()
}

/// As "ratio 1.34 (1.31 to 1.37)".
fn value(parameter: &ParameterFinding) -> Option<String> {
    let ParameterFinding { name, unit, estimate, low95, high95, .. } = parameter;
    let measure = measure(unit);
    let unit =
        if measure.unit.is_empty() && unit != "1" { format!(" {unit}") } else { String::new() };
    let mut text = format!("{name} {}{unit}", measure.text((*estimate)?));
    if let Some((low, high)) = low95.zip(*high95) {
        text += &format!(" ({} to {})", measure.number(low), measure.number(high));
    }
    Some(text)
}

fn measure(unit: &str) -> Measure {
    let known = ["m", "rad", "m/s", "N"].into_iter().find(|known| *known == unit);
    Measure::of(known.unwrap_or("1"))
}

/// What may be taken for what is claimed.
fn alike(found: &Diagnosis, section: Section) -> Section {
    let mut rows = Vec::new();
    let is_claimed = |grade| matches!(grade, Grade::Identified | Grade::Ambiguous);
    for effect in found.effects.iter().filter(|effect| is_claimed(effect.grade)) {
        let known = by_id(&effect.id).map(|known| known.info().confounders).unwrap_or_default();
        let in_group = |other: &str| {
            found.ambiguous.iter().any(|g| g.contains(&effect.id) && g.iter().any(|id| id == other))
        };
        for rival in &effect.rivals {
            let when = known.iter().find(|one| one.id == rival);
            let when = when.map_or_else(dash, |one| one.when.to_owned());
            let here = match in_group(rival) {
                true => "these pushes cannot tell them apart",
                false => "alike in these pushes, and told apart",
            };
            rows.push(vec![effect.id.clone(), rival.clone(), here.to_owned(), when]);
        }
    }
    if rows.is_empty() {
        return section;
    }
    section
        .text(
            "Look-alikes: effects that change nearly the same in these pushes. Likeness is of these \
             pushes, not of the effects: other pushes tell them apart.",
        )
        .table(&["effect", "looks like", "here", "what tells them apart"], rows)
}

fn left(leftover: &Leftover) -> String {
    match (&leftover.covariate, leftover.p) {
        (Some(sentence), p) => {
            let p = p.map_or_else(String::new, |p| format!(" (p {p:.3})"));
            let origin = leftover.origin.map_or_else(String::new, |origin| {
                format!(" That speaks of the {}.", origin.name())
            });
            format!(
                "What is left: with all that is claimed the model still {sentence}{p}. No effect of the library explains that.{origin}"
            )
        }
        (None, Some(p)) => format!(
            "What is left: nothing beyond chance over place, angle, speed, orientation, table and time \
             (p {p:.2} for as much structure in noise). That is no proof that the model is complete where no \
             push was made."
        ),
        (None, None) => "What is left: there are too few pushes to look for structure.".to_owned(),
    }
}

/// Hints, limits, and what cannot be tested.
fn rest(found: &Diagnosis, mut section: Section) -> Section {
    let of = |grade: Grade| found.effects.iter().filter(move |effect| effect.grade == grade);
    let hints: Vec<_> = of(Grade::Hint).map(|e| vec![e.id.clone(), e.why.clone()]).collect();
    if !hints.is_empty() {
        section = section
            .text("Hints, which are not claimed, and what speaks against each:")
            .table(&["effect", "why it is not claimed"], hints);
    }
    let limits = of(Grade::BelowDetectionLimit).map(|effect| {
        let values: Vec<String> = effect.parameters.iter().filter_map(value).collect();
        vec![effect.id.clone(), effect.why.clone(), values.join("; ")]
    });
    let limits: Vec<_> = limits.collect();
    if !limits.is_empty() {
        section = section
            .text(
                "Not claimed: why, and how much of each effect could still be there, by one step of a fit. A \
                 wide interval means that little is known, not that the effect is probably large.",
            )
            .table(&["effect", "why it is not claimed", "values (95 %)"], limits);
    }
    let silent: Vec<_> =
        of(Grade::NotTestable).map(|e| vec![e.id.clone(), e.why.clone()]).collect();
    if silent.is_empty() {
        return section;
    }
    section
        .text(
            "Not testable with these pushes: they could be there at any usual size, and nothing here \
             would show it.",
        )
        .table(&["effect", "why, and what to measure"], silent)
}
