//! The section about the ends of long pushes.

use std::fmt::Write as _;

use diagnosis::{Diagnosis, EffectFinding, ParameterFinding, Status, Verdict};

use super::{Ends, Error};

/// Hints that are told of an object.
const MOST_HINTS: usize = 4;

/// The section.
pub(in crate::real_comparison) fn text(ends: &[Ends]) -> String {
    let mut page = HEAD.to_owned();
    for one in ends {
        page += &row(one);
    }
    page += &means(ends);
    let n_missed: usize = ends.iter().map(|one| one.n_missed).sum();
    let _ =
        write!(page, "\nLeft out besides: {n_missed} pushes whose way never meets the outline.\n");
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
## The ends of long pushes of every shape

Pushes of 50 mm at 10 mm/s of eleven objects on plywood, of which the poses before and after and the
ends of the pusher's way are known: a row each, a step of 50 mm from the touch (before it the object
rests) to the end, integrated in sub-steps of 1 mm. Compared is the motion alone: the gap at the end
follows from it, and the one at the start is none by construction. Where the pusher has slid off before
the end (it is more than 2 mm from the outline there) the end tells little of friction; such pushes are
not diagnosed, and their errors are in the last columns alone. Neither sessions nor the order of the
pushes nor repeats are known: every push is a cluster of its own, and the noise is an estimate from
neighbours. Of each object's pushes every second or third is taken, so that no more than 150 are.
Each object is diagnosed by itself, with μp = 0.25 and uniform pressure to begin with.

Mean distance and mean angle between the predicted and the measured end, before and after what held-out
pushes confirm is added (where that closes less than half of the gap it is no more than a hint), on
held-out pushes: the quarter that the diagnosis holds out, and, under “all”, those together
with the pushes whose pusher slid off, each kind with the share that it has of all pushes.

| object | pushes, slid off | verdict | named | before | after | before, all | after, all |
|---|---|---|---|---|---|---|---|
";

const TAIL: &str = "
A published toolbox reaches 3.73 mm and 4.12° with a fitted ellipsoid and 3.36 mm and 3.54° with a fitted
quartic, averages over the shapes of all of these pushes, with surfaces that were fitted to separate
measurements of force and motion.

What the diagnosis says of each object, in its own words (“per step” is per push here), and the hints that
it does not claim:
";

fn row(one: &Ends) -> String {
    let (verdict, named) = match &one.found {
        Ok(found) => (verdict(found.verdict), named(found)),
        Err(_) => ("no answer", "–".to_owned()),
    };
    let [before, after] = one.errors;
    let errors = [before.kept, after.kept, before.all, after.all].map(size);
    let Ends { shape, n_used, n_kept, n_lost, .. } = one;
    format!(
        "| {shape} | {n_used} of {n_kept}, {n_lost} | {verdict} | {named} | {} |\n",
        errors.join(" | ")
    )
}

fn verdict(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Named => "named",
        Verdict::OneOf => "one of a group",
        Verdict::StructureUnexplained => "structure unexplained",
        Verdict::NoneFound => "none found",
        Verdict::Weak => "weak",
    }
}

fn named(found: &Diagnosis) -> String {
    let groups = found.one_of.iter().map(|group| group.join(" or "));
    let named: Vec<String> = found.named.iter().cloned().chain(groups).collect();
    let is_confirmed = |effect: &&EffectFinding| {
        effect.status == Status::Weak && effect.log_density_gain.is_some()
    };
    let hints: Vec<&str> =
        found.effects.iter().filter(is_confirmed).map(|effect| effect.id.as_str()).collect();
    match (named.is_empty(), hints.is_empty()) {
        (false, _) => named.join(", "),
        (true, false) => format!("– (confirmed, not claimed: {})", hints.join(", ")),
        (true, true) => "–".to_owned(),
    }
}

/// The mean of the objects' errors, each object counted once.
fn means(ends: &[Ends]) -> String {
    let mean = |of: &dyn Fn(&Ends) -> Error| {
        let n = ends.len() as f64;
        let sum = |of: &dyn Fn(&Ends) -> f64| ends.iter().map(of).sum::<f64>() / n;
        size(Error { position: sum(&|one| of(one).position), angle: sum(&|one| of(one).angle) })
    };
    let n_used: usize = ends.iter().map(|one| one.n_used).sum();
    let n_kept: usize = ends.iter().map(|one| one.n_kept).sum();
    let n_lost: usize = ends.iter().map(|one| one.n_lost).sum();
    let errors = [
        mean(&|one| one.errors[0].kept),
        mean(&|one| one.errors[1].kept),
        mean(&|one| one.errors[0].all),
        mean(&|one| one.errors[1].all),
    ];
    format!(
        "| mean of the objects | {n_used} of {n_kept}, {n_lost} | | | {} |\n",
        errors.join(" | ")
    )
}

fn size(error: Error) -> String {
    format!("{:.2} mm, {:.2}°", 1e3 * error.position, error.angle.to_degrees())
}

/// What is claimed with its values, and hints with what speaks against each.
fn hints(found: &Diagnosis) -> String {
    let is = |status: Status| found.effects.iter().filter(move |one| one.status == status);
    let mut text = String::new();
    for effect in is(Status::Present).chain(is(Status::Possible)) {
        let _ = writeln!(text, "- {}: {}", effect.id, values(effect));
    }
    for effect in is(Status::Weak).take(MOST_HINTS) {
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
    effect.parameters.iter().filter_map(value).collect::<Vec<_>>().join(", ")
}
