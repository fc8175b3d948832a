//! The page that lists every effect.

use std::fmt::Write as _;

use effects::{Channel, Confounder, EffectInfo, Off, Parameter, all};

const HEAD: &str = "# The catalogue of effects

A model of pushing is a base (limit surface, nominal friction) and any of the effects below. Each
acts at one stage of the prediction, is seen by some channels of the measurement, and can be taken
for others. `model.toml` names them by their ids and parameters.

The figures show what an effect of typical size changes, on a 90 mm square of 0.84 kg: maps over the
place p along an edge and the angle β of the push, for steps of 10 mm at 20 mm/s; then the push that
shows it most, over speed and over the object's orientation, in standard deviations of ordinary
sensors (30 µm, 0.08°, 50 mN, 0.1 mm of gap). Dashed: the way that the object goes in 0.1 s after
the pusher stopped.

This page and its figures are written by `cargo xtask effects-atlas` from what the effects say of
themselves. An effect of your own: [write your own effect](write-your-own-effect.md).
";

/// The whole page.
pub(super) fn text() -> String {
    let mut text = HEAD.to_owned();
    text.push_str("\n| id | what it is | parameters | seen in |\n|---|---|---|---|\n");
    for effect in all() {
        let about = effect.info();
        let names: Vec<_> = kinds(about).iter().map(|kind| with_unit(kind)).collect();
        let (id, title) = (about.id, about.title);
        let row = format!("| [`{id}`](#{id}) | {title} | {} | {} |", names.join(", "), seen(about));
        writeln!(text, "{row}").expect("a String takes any text");
    }
    for effect in all() {
        section(&mut text, effect.info());
    }
    text
}

fn section(text: &mut String, about: &EffectInfo) {
    let EffectInfo { id, title, physics, equation, source, .. } = about;
    let mut line = |content: String| {
        text.push_str(&content);
        text.push('\n');
    };
    line(format!("\n<a id=\"{id}\"></a>\n## {title}: `{id}`\n"));
    line(format!("{physics}\n\n> {equation}\n"));
    line(
        "| parameter | unit | off | typical | range | meaning |\n|---|---|---|---|---|---|".into(),
    );
    for same in kinds(about) {
        let (parameter, name) = (same[0], names(&same));
        let Parameter { meaning, typical, range, .. } = parameter;
        let (unit, off) = (parameter.unit, off(parameter));
        let range = format!("{} to {}", range.0, range.1);
        line(format!("| {name} | {unit} | {off} | {typical} | {range} | {meaning} |"));
    }
    line(format!("\n- Seen in {}.", seen(about)));
    for Confounder { id, when } in about.confounders {
        line(format!("- Confounded with [`{id}`](#{id}): {when}."));
    }
    line(format!("- Source: {}.", source.trim_end_matches('.')));
    line(format!("\n![What {id} changes](effects/{id}.svg)"));
}

/// The parameters, those together that mean the same at other places.
fn kinds(about: &EffectInfo) -> Vec<Vec<&Parameter>> {
    let mut kinds: Vec<Vec<&Parameter>> = Vec::new();
    for parameter in about.parameters {
        let is_same = |kind: &&mut Vec<&Parameter>| kind[0].meaning == parameter.meaning;
        match kinds.iter_mut().find(is_same) {
            Some(kind) => kind.push(parameter),
            None => kinds.push(vec![parameter]),
        }
    }
    kinds
}

fn names(kind: &[&Parameter]) -> String {
    match kind {
        [first, .., last] => format!("`{}` to `{}`", first.name, last.name),
        _ => format!("`{}`", kind[0].name),
    }
}

fn with_unit(kind: &[&Parameter]) -> String {
    let name = match kind {
        [first, .., last] => format!("{} to {}", first.name, last.name),
        _ => kind[0].name.to_owned(),
    };
    match kind[0].unit {
        "1" => name,
        unit => format!("{name} in {unit}"),
    }
}

fn off(parameter: &Parameter) -> String {
    match parameter.off {
        Off::At(value) => value.to_string(),
        Off::PusherFriction | Off::SupportFriction => "nominal".into(),
        Off::SurfaceShape => "that of the base".into(),
        Off::Undefined => "none".into(),
    }
}

fn seen(about: &EffectInfo) -> String {
    let name = |channel: &Channel| match channel {
        Channel::Motion => "motion",
        Channel::Force => "force",
        Channel::Gap => "gap",
    };
    about.reaches.iter().map(name).collect::<Vec<_>>().join(", ")
}
