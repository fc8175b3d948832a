//! What a set can tell, in words, with mm, degrees and N.

use std::fmt;

use diagnosis::{Covariate, Coverage, ErrorSource, FloorSource};
use effects::{Channel, readable_unit};

use super::{Checked, Showable, Size};
use crate::tool::people::{behind_number, spread, two_digits};
use crate::tool::terminal::TITLE;

/// Pairs of look-alikes that a screen has room for.
const MOST_PAIRS: usize = 8;

impl fmt::Display for Checked {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Coverage { n_steps, n_pushes, .. } = self.coverage;
        writeln!(f, "{TITLE}{}{TITLE:#}: {n_steps} steps of {n_pushes} pushes", self.name)?;
        if !self.excluded.is_empty() {
            writeln!(f, "  rows excluded: {}", self.excluded)?;
        }
        write_coverage(f, self)?;
        let names: Vec<_> = self.channels.iter().map(|channel| channel_name(*channel)).collect();
        writeln!(f, "  channels: {}", names.join(", "))?;
        self.write_noise(f)?;
        self.write_effects(f)?;
        self.write_look_alikes(f)
    }
}

fn channel_name(channel: Channel) -> &'static str {
    match channel {
        Channel::Motion => "motion",
        Channel::Force => "contact force",
        Channel::Gap => "contact gap",
    }
}

fn write_coverage(
    f: &mut fmt::Formatter<'_>,
    Checked { coverage: found, duration, unknown, .. }: &Checked,
) -> fmt::Result {
    let knows = |covariate| !unknown.contains(&covariate);
    let degrees = |[low, high]: [f64; 2]| (low.to_degrees(), high.to_degrees());
    let (low, high) = degrees(found.beta);
    writeln!(f, "  p {:.2} to {:.2}, β {low:.0}° to {high:.0}°", found.p[0], found.p[1])?;
    let [slow, fast] = found.speed.map(|speed| 1e3 * speed);
    writeln!(f, "  speed {slow:.0} to {fast:.0} mm/s")?;
    let edges: Vec<_> = found.steps_on_edges.iter().map(ToString::to_string).collect();
    writeln!(f, "  steps on edges: {}", edges.join(", "))?;
    if knows(Covariate::Orientation) {
        writeln!(f, "  orientations: {} of 12 sectors of 30°", found.n_orientations)?;
    }
    if knows(Covariate::TableX) {
        let [x, y] = found.table.map(|[low, high]| 1e3 * (high - low));
        writeln!(f, "  table: {x:.0} × {y:.0} mm")?;
    }
    if !unknown.is_empty() {
        let names: Vec<_> = unknown.iter().map(|one| one.name()).collect();
        writeln!(f, "  not told by the rows: {}", names.join(", "))?;
    }
    let time = duration.map_or("not known".to_owned(), |time| format!("{:.0} min", time / 60.0));
    writeln!(f, "  time: {time}, sessions: {}", found.n_sessions)?;
    match found.n_cells {
        0 => writeln!(f, "  repeats: none; repeat some pushes to learn the noise"),
        n => writeln!(f, "  repeats: {} pushes of {n} kinds", found.n_repeated),
    }
}

impl Checked {
    fn write_noise(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let noise = &self.noise;
        let source = match noise.source {
            FloorSource::Repeats => format!("from {} repeated pushes", noise.n_pushes),
            FloorSource::Neighbours => {
                format!("an estimate from {} pairs of pushes that are alike", noise.n_cells)
            }
        };
        writeln!(f, "{TITLE}noise{TITLE:#}, {source}, as standard deviations")?;
        writeln!(f, "  of a step or its ends")?;
        noise.sources.iter().filter(|own| !own.of_push).try_for_each(|own| write_source(f, own))?;
        writeln!(f, "  from push to push")?;
        noise.sources.iter().filter(|own| own.of_push).try_for_each(|own| write_source(f, own))?;
        if noise.n_unused > 0 {
            writeln!(f, "  {} of the groups or pairs say nothing", noise.n_unused)?;
        }
        match noise.dropped[..] {
            [] => Ok(()),
            _ => writeln!(f, "  could not be sized: {}", noise.dropped.join(", ")),
        }
    }

    fn write_effects(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{TITLE}what could be found{TITLE:#} beyond {}, in 9 of 10 such sets",
            self.model
        )?;
        if self.n_pushes_screened < self.coverage.n_pushes {
            writeln!(f, "  looked for in {} pushes, an even choice", self.n_pushes_screened)?;
        }
        for effect in self.effects.iter().filter(|effect| effect.not_testable.is_none()) {
            writeln!(f, "  {:26} {}", effect.id, sizes(effect))?;
        }
        let untestable: Vec<_> = self
            .effects
            .iter()
            .filter_map(|effect| Some((effect.id, effect.not_testable.as_ref()?)))
            .collect();
        if !untestable.is_empty() {
            writeln!(f, "{TITLE}what cannot be tested{TITLE:#}")?;
        }
        for (id, why) in untestable {
            writeln!(f, "  {id:26} because {}", why.because)?;
            writeln!(f, "  {:26} measure {}", "", why.measure)?;
        }
        Ok(())
    }

    fn write_look_alikes(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.look_alikes.is_empty() {
            return writeln!(f, "no two of them look alike in these pushes");
        }
        writeln!(f, "{TITLE}what cannot be told apart well{TITLE:#}, with correlation")?;
        for pair in self.look_alikes.iter().take(MOST_PAIRS) {
            writeln!(f, "  {:.3}  {} and {}", pair.correlation, pair.one, pair.other)?;
        }
        let n_more = self.look_alikes.len().saturating_sub(MOST_PAIRS);
        if n_more > 0 {
            writeln!(f, "  and {n_more} more pairs; --json has them all")?;
        }
        Ok(())
    }
}

fn write_source(f: &mut fmt::Formatter<'_>, source: &ErrorSource) -> fmt::Result {
    let size = spread([source.sd, source.low95, source.high95], source.unit);
    writeln!(f, "    {:38} {size}", source.name)
}

/// The sizes of an effect's coordinates; of a ratio along an axis the larger one, as a ratio.
fn sizes(effect: &Showable) -> String {
    let axis = |size: &&Size| size.name.starts_with("e ");
    let widest = effect.coordinates.iter().filter(axis).map(|size| size.detection_limit);
    if let Some(widest) = widest.reduce(f64::max) {
        return format!("ratio {:.4}, in any direction", (2.0 * widest).exp());
    }
    let one = |size: &Size| {
        let (per, unit) = readable_unit(size.unit);
        let limit = two_digits(per * size.detection_limit);
        format!("{} {limit}{}", size.name, behind_number(unit))
    };
    effect.coordinates.iter().map(one).collect::<Vec<_>>().join(", ")
}
