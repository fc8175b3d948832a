//! The section about the ends of long pushes.

use std::fmt::Write as _;

use diagnosis::{Diagnosis, EffectFinding, ParameterFinding, Status, Verdict};

use super::folds::FREE;
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
    page += FITS;
    for one in ends {
        let errors = one.fitted.iter().map(|fitted| (fitted.error, fitted.n_failed));
        page += &fits_row(&one.shape, &errors.collect::<Vec<_>>());
    }
    page += &fits_means(ends);
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
ends of the pusher's way are known, as `pushlab ingest --preset mit-endpoints` reads them: a row each,
simulated as a whole from the start of the way, before the touch, to its end; the pusher may slide off or
meet a vertex. All pushes are counted but those in which the tracking flips: the object turns further than
any contact turns it. Compared is the motion alone. Neither sessions nor the order of the pushes nor repeats
are known: every push is a cluster of its own, and the noise is an estimate from neighbors. Of each
object's pushes every second or third is taken for the diagnosis, so that no more than 150 are. Each object
is diagnosed by itself, with μp = 0.25 and uniform pressure to begin with.

Mean distance and mean angle between the predicted and the measured end, before and after what held-out
pushes confirm is added (where that closes less than half of the gap it is no more than a hint), on the
quarter of the pushes that the diagnosis holds out.

| object | pushes, flips | verdict | named | before | after |
|---|---|---|---|---|---|
";

const FITS: &str = "
Plain fits (`pushlab fit`) to four fifths of the pushes of an object, and the error on the others, over all
five folds and all pushes: nothing fitted, the pusher's friction μp, with the radius c of the pressure, and
with the center of friction.

| object | nominal | μp | μp, c | μp, c, center |
|---|---|---|---|---|
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
    let [before, after] = one.errors.map(size);
    let Ends { shape, n_used, n_pushes, n_flips, .. } = one;
    format!(
        "| {shape} | {n_used} of {n_pushes}, {n_flips} | {verdict} | {named} | {before} | {after} |\n"
    )
}

fn fits_row(name: &str, errors: &[(Error, usize)]) -> String {
    let cell = |(error, n_failed): &(Error, usize)| match n_failed {
        0 => size(*error),
        n => format!("{} ({n} fits failed)", size(*error)),
    };
    let cells: Vec<_> = errors.iter().map(cell).collect();
    format!("| {name} | {} |\n", cells.join(" | "))
}

/// Means over the objects, each counted once.
fn fits_means(ends: &[Ends]) -> String {
    let of = |k: usize| {
        let mut sum = Error::default();
        for one in ends {
            sum.position += one.fitted[k].error.position;
            sum.angle += one.fitted[k].error.angle;
        }
        (sum.over(ends.len()), 0)
    };
    fits_row("mean of the objects", &(0..FREE.len()).map(of).collect::<Vec<_>>())
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
    let mean = |k: usize| {
        let mut sum = Error::default();
        for one in ends {
            sum.position += one.errors[k].position;
            sum.angle += one.errors[k].angle;
        }
        size(sum.over(ends.len()))
    };
    let count = |of: fn(&Ends) -> usize| ends.iter().map(of).sum::<usize>();
    let (used, all) = (count(|one| one.n_used), count(|one| one.n_pushes));
    let flips = count(|one| one.n_flips);
    format!("| mean of the objects | {used} of {all}, {flips} | | | {} | {} |\n", mean(0), mean(1))
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
