//! A diagnosis in words.

use std::fmt;

use diagnosis::{
    Clusters, Diagnosis, EffectFinding, ErrorFall, Gain, Grade, MotionError, OriginShare,
    ParameterFinding, PushScatter, Remains,
};
use effects::readable_unit;
use models::Cluster;

use crate::tool::people::{behind_number, four_digits, lines, spread, two_digits};
use crate::tool::step_kind::StepKind;
use crate::tool::terminal::{TITLE, WARNING};

/// A diagnosis of a model.
pub(super) struct Answer<'a> {
    pub(super) found: &'a Diagnosis,
    /// The model's name.
    pub(super) model: &'a str,
    /// What a step is.
    pub(super) step: StepKind,
    /// Whether it is written to a file, which the next commands read.
    pub(super) is_kept: bool,
}

/// Width of a line of running text.
const WIDTH: usize = 96;
/// Width of a name before its reason.
const REASON: usize = 26;
/// An error that grows by so much is told to.
const RISES: f64 = 1.05;
/// The least probability that is told: a smaller one is below it.
const LEAST_P: f64 = 1e-4;

impl fmt::Display for Answer<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let found = self.found;
        let data = &found.data;
        let (steps, pushes) = (data.steps, data.pushes_used);
        writeln!(f, "{TITLE}{}{TITLE:#} on {steps} steps of {pushes} pushes", self.model)?;
        if let Some(runs) = &data.runs {
            lines(&runs.to_string(), WIDTH).iter().try_for_each(|line| writeln!(f, "  {line}"))?;
        }
        let used = |n: usize, all: usize| match n < all {
            true => format!("{n} (of {all}, evenly over edges and speeds)"),
            false => n.to_string(),
        };
        let fitted = used(data.pushes_fitted, found.split.fit.len());
        let confirming = used(data.pushes_confirming, found.split.confirm.len());
        let [of_fitted, of_confirming] = [data.clusters_fitted, data.clusters_confirming]
            .map(|clusters| clusters.map_or_else(String::new, sessions));
        writeln!(f, "  fitted to {fitted}{of_fitted}, confirmed on {confirming}{of_confirming}")?;
        if let (Some(clusters), Some(missing @ 1..)) = (data.clusters_fitted, data.clusters_missing)
        {
            let kind = plural(clusters.kind);
            writeln!(
                f,
                "  too few {kind} to be sure of a name: {missing} more to fit to would do"
            )?;
        }
        let cells = found.noise.n_cells;
        match found.noise.source.as_str() {
            "repeats" => writeln!(f, "  noise from {cells} groups of repeated pushes")?,
            _ => writeln!(f, "  noise estimated from {cells} pairs of neighbours: no repeats")?,
        }
        for suspicion in &found.suspicions {
            for line in lines(&format!("This holds only if it is not so: {suspicion}"), WIDTH) {
                writeln!(f, "{WARNING}{line}{WARNING:#}")?;
            }
        }
        for line in lines(&found.sentence, WIDTH) {
            writeln!(f, "{TITLE}{line}{TITLE:#}")?;
        }
        write_error(f, &found.error, self.step)?;
        for (grade, title) in [
            (Some(Grade::Identified), "missing"),
            (Some(Grade::Ambiguous), "one of these"),
            (Some(Grade::Effective), "the error falls with it, though the cause may be another"),
            (None, "there as well, though hardly seen"),
            (Some(Grade::Hint), "hints"),
        ] {
            let is_told = |effect: &&EffectFinding| match grade {
                Some(grade) => effect.grade == grade && !effect.small,
                None => effect.small,
            };
            let effects: Vec<_> = found.effects.iter().filter(is_told).collect();
            if !effects.is_empty() {
                writeln!(f, "{TITLE}{title}{TITLE:#}")?;
                effects.into_iter().try_for_each(|effect| write_effect(f, effect))?;
            }
        }
        write_rest(f, &found.effects)?;
        write_scatter(f, &found.noise.push_to_push)?;
        found.remains.as_ref().map_or(Ok(()), |remains| write_remains(f, remains))?;
        self.write_next(f)
    }
}

impl Answer<'_> {
    fn write_next(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.found.next.is_empty() {
            return Ok(());
        }
        let first = if self.is_kept { "" } else { ", after the same with -o diagnosis.json" };
        writeln!(f, "{TITLE}next{TITLE:#}{first}")?;
        self.found.next.iter().try_for_each(|command| writeln!(f, "  {command}"))
    }
}

/// What differs from push to push, as far as it is much of the noise.
fn write_scatter(f: &mut fmt::Formatter<'_>, scatter: &[PushScatter]) -> fmt::Result {
    if !scatter.iter().any(PushScatter::is_much) {
        return Ok(());
    }
    writeln!(f, "{TITLE}differs from push to push{TITLE:#}")?;
    for PushScatter { effect, unit, sd, low95, high95, share } in
        scatter.iter().filter(|one| one.is_much())
    {
        let size = spread([*sd, *low95, *high95], unit);
        writeln!(f, "  {effect:26} {size}: {:.0} % of the noise", 100.0 * share)?;
    }
    Ok(())
}

/// What of the rig the error comes from that the claimed effects leave.
fn write_remains(f: &mut fmt::Formatter<'_>, remains: &Remains) -> fmt::Result {
    let Remains { gain, share, smooth, origins } = remains;
    write!(f, "{TITLE}what is left{TITLE:#}")?;
    if !gain.is_sure() && !smooth.is_sure() {
        return writeln!(f, ": nothing that held-out pushes would be predicted better by");
    }
    let percent = 100.0 * share;
    writeln!(f, ": {percent:.0} % of the squared error; on held-out pushes it is predicted by")?;
    let (sure, unsure): (Vec<_>, Vec<_>) = origins.iter().partition(|one| one.gain.is_sure());
    for OriginShare { origin, gain: Gain { mean, se }, alone, last_in, at } in sure {
        write!(f, "  {:12} gain {mean:.0} ± {se:.0} nats", origin.name())?;
        if let (Some(alone), Some(last_in)) = (alone, last_in) {
            let (alone, last_in) = (100.0 * alone, 100.0 * last_in);
            write!(f, ", {alone:.0} % of all; {last_in:.0} % by nothing else")?;
        }
        match at {
            Some(at) => writeln!(f, "; most {at}")?,
            None => writeln!(f)?,
        }
    }
    if !unsure.is_empty() {
        let names: Vec<&str> = unsure.iter().map(|one| one.origin.name()).collect();
        writeln!(f, "  nothing sure by {}", names.join(", "))?;
    }
    let Gain { mean, se } = smooth;
    writeln!(f, "  any smooth function of place, direction and speed: {mean:.0} ± {se:.0} nats")
}

/// What is taken for independent, where that is not the pushes.
fn sessions(clusters: Clusters) -> String {
    match clusters.kind {
        Cluster::Push => String::new(),
        kind @ Cluster::Session => format!(" ({} {})", clusters.n, plural(kind)),
    }
}

fn plural(kind: Cluster) -> &'static str {
    match kind {
        Cluster::Push => "pushes",
        Cluster::Session => "sessions",
    }
}

/// The error of a step before and after, beside the floor.
pub(in crate::tool::commands) fn write_error(
    f: &mut fmt::Formatter<'_>,
    error: &ErrorFall,
    step: StepKind,
) -> fmt::Result {
    writeln!(f, "{TITLE}error of a step, RMS{TITLE:#} ({step}), on the held-out pushes")?;
    let ErrorFall { before_si, after_si, floor_si, .. } = error;
    let row = |of: fn(&MotionError) -> Option<f64>| [before_si, after_si, floor_si].map(of);
    for (name, unit, per, values) in [
        ("dx", "mm", 1e3, row(|one| one.dx_m)),
        ("dy", "mm", 1e3, row(|one| one.dy_m)),
        ("dtheta", "°", 1.0_f64.to_degrees(), row(|one| one.dtheta_rad)),
        ("force_normal", "N", 1.0, row(|one| one.force_normal_n)),
        ("force_tangential", "N", 1.0, row(|one| one.force_tangential_n)),
    ] {
        if let [Some(before), Some(after), floor] = values {
            let (before, after) = (per * before, per * after);
            write!(f, "  {name:16} {before:7.3} → {after:.3} {unit:2}")?;
            if let Some(floor) = floor.map(|floor| per * floor).filter(|floor| *floor > 0.0) {
                write!(f, "  floor {floor:.3}, {:.1} times it", after / floor)?;
            }
            let rises = if after > RISES * before { "; it rises" } else { "" };
            writeln!(f, "{rises}")?;
        }
    }
    Ok(())
}

fn write_effect(f: &mut fmt::Formatter<'_>, effect: &EffectFinding) -> fmt::Result {
    let EffectFinding { id, p_adjusted, log_density_gain, rivals, why, parameters, .. } = effect;
    write!(f, "  {id:26}")?;
    match p_adjusted {
        Some(p) if *p < LEAST_P => write!(f, " p < {LEAST_P}")?,
        Some(p) => write!(f, " p {p:.4}")?,
        None => {}
    }
    if let Some(Gain { mean, se }) = log_density_gain {
        write!(f, "  gain {mean:.0} ± {se:.0} nats")?;
    }
    writeln!(f)?;
    if matches!(effect.grade, Grade::Identified | Grade::Ambiguous | Grade::Effective) {
        parameters.iter().try_for_each(|parameter| write_parameter(f, parameter))?;
    }
    let is_sure = matches!(effect.grade, Grade::Identified | Grade::Ambiguous);
    if !is_sure && !why.is_empty() {
        lines(why, WIDTH).into_iter().try_for_each(|line| writeln!(f, "    {line}"))?;
    }
    match rivals.is_empty() {
        true => Ok(()),
        false => writeln!(f, "    looks like {}", rivals.join(", ")),
    }
}

fn write_parameter(f: &mut fmt::Formatter<'_>, parameter: &ParameterFinding) -> fmt::Result {
    let Some(estimate) = parameter.estimate else { return Ok(()) };
    let (per, unit) = readable_unit(&parameter.unit);
    let number = |value: f64| four_digits(per * value);
    let unit = behind_number(unit);
    write!(f, "    {} = {}{unit}", parameter.name, number(estimate))?;
    match (parameter.low95, parameter.high95) {
        (Some(low), Some(high)) => writeln!(f, " ({} to {})", number(low), number(high)),
        _ => writeln!(f),
    }
}

/// The effects that are not claimed: why, and how large those may be that show no sign.
fn write_rest(f: &mut fmt::Formatter<'_>, effects: &[EffectFinding]) -> fmt::Result {
    for (grade, title) in [
        (Grade::BelowDetectionLimit, "looked at, and not claimed"),
        (Grade::NotTestable, "these pushes cannot tell"),
    ] {
        let told = effects.iter().filter(|effect| effect.grade == grade);
        let told: Vec<_> =
            told.filter(|effect| effect.is_seen() || grade == Grade::NotTestable).collect();
        if !told.is_empty() {
            writeln!(f, "{TITLE}{title}{TITLE:#}")?;
        }
        for EffectFinding { id, why, .. } in told {
            let text = format!("{id:26} {why}");
            let (first, others) = match &lines(&text, WIDTH)[..] {
                [first, others @ ..] => (first.to_string(), others.join(" ")),
                [] => (text, String::new()),
            };
            writeln!(f, "  {first}")?;
            lines(&others, WIDTH - REASON)
                .into_iter()
                .filter(|line| !line.is_empty())
                .try_for_each(|line| writeln!(f, "  {:REASON$} {line}", ""))?;
        }
    }
    let unseen = effects.iter().filter(|effect| effect.grade == Grade::BelowDetectionLimit);
    let unseen: Vec<String> = unseen.filter(|effect| !effect.is_seen()).map(limit).collect();
    if unseen.is_empty() {
        return Ok(());
    }
    writeln!(
        f,
        "{TITLE}not seen{TITLE:#}; nine such sets in ten would show it from the size behind it on"
    )?;
    lines(&unseen.join(", "), WIDTH).into_iter().try_for_each(|line| writeln!(f, "  {line}"))
}

/// As "force-bias 0.16 N or 4.3°": of each unit by the number that these pushes show least of.
fn limit(effect: &EffectFinding) -> String {
    let mut limits: Vec<(&str, f64)> = Vec::new();
    for ParameterFinding { unit, detection_limit, .. } in &effect.parameters {
        let Some(limit) = *detection_limit else { continue };
        match limits.iter_mut().find(|(known, _)| known == unit) {
            Some((_, largest)) => *largest = largest.max(limit),
            None => limits.push((unit, limit)),
        }
    }
    let told = limits.into_iter().map(|(unit, limit)| {
        let (per, unit) = readable_unit(unit);
        format!("{}{}", two_digits(per * limit), behind_number(unit))
    });
    format!("{} {}", effect.id, told.collect::<Vec<_>>().join(" or ")).trim_end().to_owned()
}

#[cfg(test)]
mod tests {
    use super::sessions;
    use diagnosis::Clusters;
    use models::Cluster;

    #[test]
    fn sessions_are_told_where_they_are_taken_for_independent() {
        let told = |kind: Cluster| sessions(Clusters { kind, n: 11 });
        assert_eq!([told(Cluster::Session), told(Cluster::Push)], [" (11 sessions)", ""]);
    }
}
