//! What there is to say about an effect.

use std::fmt;

use anyhow::{Context, Result};
use effects::{Channel, EffectInfo, all};
use plant::{EffectKind, effect_kinds};
use serde::Serialize;

use crate::tool::people::{behind_number, lines};
use crate::tool::terminal::TITLE;

/// An effect as a model carries it, if it is in the catalogue, and as a simulation hides it.
#[derive(Serialize)]
pub(super) struct Explanation {
    id: &'static str,
    model: Option<InModel>,
    hidden: Option<Hidden>,
}

/// As a model carries it.
#[derive(Serialize)]
struct InModel {
    title: &'static str,
    physics: &'static str,
    equation: &'static str,
    source: &'static str,
    /// Channels that show it.
    reaches: &'static [Channel],
    parameters: Vec<Parameter>,
    #[serde(rename = "look_alikes")]
    confounders: Vec<Confounder>,
}

#[derive(Serialize)]
struct Parameter {
    name: &'static str,
    unit: &'static str,
    meaning: &'static str,
    typical: f64,
    low: f64,
    high: f64,
}

#[derive(Serialize)]
struct Confounder {
    id: &'static str,
    when: &'static str,
}

/// As a simulation hides it.
#[derive(Serialize)]
struct Hidden {
    about: &'static str,
    parameters: Vec<HiddenParameter>,
}

/// Values are in SI units, which the first of the names carries.
#[derive(Serialize)]
struct HiddenParameter {
    names: Vec<String>,
    unit: &'static str,
    typical: f64,
    low: f64,
    high: f64,
}

impl Explanation {
    /// Gathers what the catalogue and the simulation say.
    ///
    /// # Errors
    /// If neither knows the id.
    pub(super) fn of(id: &str) -> Result<Self> {
        let kind = effect_kinds().into_iter().find(|kind| kind.id == id);
        let about = all().iter().map(|effect| effect.info()).find(|about| about.id == id);
        let known = about.map(|about| about.id).or_else(|| Some(kind.as_ref()?.id));
        let id = known.with_context(|| format!("there is no effect `{id}`"))?;
        Ok(Self { id, model: about.map(InModel::of), hidden: kind.map(Hidden::of) })
    }
}

impl InModel {
    fn of(about: &EffectInfo) -> Self {
        let parameter = |parameter: &effects::Parameter| {
            let effects::Parameter { name, unit, meaning, typical, range: (low, high), .. } =
                *parameter;
            Parameter { name, unit, meaning, typical, low, high }
        };
        let confounder = |of: &effects::Confounder| Confounder { id: of.id, when: of.when };
        Self {
            title: about.title,
            physics: about.physics,
            equation: about.equation,
            source: about.source,
            reaches: about.reaches,
            parameters: about.parameters.iter().map(parameter).collect(),
            confounders: about.confounders.iter().map(confounder).collect(),
        }
    }
}

impl Hidden {
    fn of(kind: &EffectKind) -> Self {
        let parameter = |parameter: &plant::Parameter| {
            let plant::Parameter { quantity, typical, range: (low, high), .. } = *parameter;
            let (names, unit) = (parameter.keys(), quantity.unit());
            HiddenParameter { names, unit, typical, low, high }
        };
        Self { about: kind.about, parameters: kind.parameters.iter().map(parameter).collect() }
    }
}

/// Columns of a line of text.
const WIDTH: usize = 80;

impl fmt::Display for Explanation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(model) = &self.model {
            write!(f, "{model}")?;
        }
        let Some(Hidden { about, parameters }) = &self.hidden else { return Ok(()) };
        writeln!(f, "{TITLE}to hide it in a simulation{TITLE:#}: {about}")?;
        let typical =
            |parameter: &HiddenParameter| format!("{}={}", parameter.names[0], parameter.typical);
        let values: Vec<_> = parameters.iter().map(typical).collect();
        let id = self.id;
        writeln!(f, "  pushlab generate --hidden '{id}: {}' -o DIR", values.join(", "))?;
        for HiddenParameter { names, unit, low, high, .. } in parameters {
            let names = names.join(" or ");
            writeln!(f, "  {names}: {}", range(*low, *high, unit))?;
        }
        Ok(())
    }
}

impl fmt::Display for InModel {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{TITLE}{}{TITLE:#}", self.title)?;
        for text in [self.physics, self.equation, self.source] {
            for line in lines(text, WIDTH) {
                writeln!(f, "  {line}")?;
            }
        }
        let channels: Vec<_> =
            self.reaches.iter().map(|channel| format!("{channel:?}").to_lowercase()).collect();
        writeln!(f, "{TITLE}seen in{TITLE:#}: {}", channels.join(", "))?;
        writeln!(f, "{TITLE}parameters of a model{TITLE:#}")?;
        for Parameter { name, unit, meaning, typical, low, high } in &self.parameters {
            writeln!(f, "  {name}: {meaning}")?;
            writeln!(f, "    {}, typically {typical}", range(*low, *high, unit))?;
        }
        if !self.confounders.is_empty() {
            writeln!(f, "{TITLE}confounded with{TITLE:#}")?;
        }
        for Confounder { id, when } in &self.confounders {
            writeln!(f, "  {id} {when}")?;
        }
        Ok(())
    }
}

fn range(low: f64, high: f64, unit: &str) -> String {
    let unit = behind_number(unit);
    let [low, high] = [low, high].map(|value| (1e6 * value).round() / 1e6);
    format!("{low} to {high}{unit}")
}

#[cfg(test)]
mod tests {
    use super::Explanation;

    #[test]
    fn every_effect_of_the_catalogue_is_explained_and_what_is_tested_for_can_be_hidden() {
        for effect in effects::all() {
            let id = effect.info().id;
            let explanation = Explanation::of(id).unwrap();
            assert!(explanation.model.is_some(), "{id}");
            let text = explanation.to_string();
            let is_tested = effects::tested().iter().any(|tested| tested.info().id == id);
            assert!(text.contains(effect.info().title), "{text}");
            assert!(text.contains("--hidden") || !is_tested, "{text}");
        }
    }

    #[test]
    fn the_shown_way_to_hide_an_effect_is_understood() {
        for kind in plant::effect_kinds() {
            let text = Explanation::of(kind.id).unwrap().to_string();
            let shown = text.split("--hidden '").nth(1).unwrap().split('\'').next().unwrap();
            let typical = plant::HiddenEffect::typical(kind.id).unwrap();
            assert_eq!(shown.parse::<plant::Hidden>().unwrap(), plant::Hidden::Effect(typical));
        }
    }
}
