//! Effects of a diagnosis as a model carries them.

use anyhow::{Result, bail, ensure};
use diagnosis::{Diagnosis, EffectFinding, Grade, ParameterFinding, PushScatter};
use effects::{EffectInfo, Off, Parameter, Setting, Spread, by_id};
use models::{Base, Description, Estimate, ModelEffect};

/// Which effects of a diagnosis are added.
pub(super) enum Asked<'a> {
    /// This one.
    One(&'a str),
    /// Those that are identified.
    Identified,
    /// Those that lower the error as well, the first of each group, and what is there and hardly seen.
    All,
}

/// The effects of a diagnosis that are asked for, in its order.
///
/// # Errors
/// If there is none, if the effect is no more than a hint, or if the diagnosis does not tell its values.
pub(super) fn chosen(found: &Diagnosis, asked: &Asked) -> Result<Vec<ModelEffect>> {
    let identified = found.identified.iter().map(String::as_str);
    let ids: Vec<&str> = match asked {
        Asked::One(id) => {
            by_id(id)?;
            vec![*id]
        }
        Asked::Identified => identified.collect(),
        Asked::All => {
            let firsts = found.ambiguous.iter().filter_map(|group| group.first());
            let small = found.effects.iter().filter(|effect| effect.small).map(|effect| &effect.id);
            let others = firsts.chain(&found.effective).chain(small).map(String::as_str);
            identified.chain(others).collect()
        }
    };
    let is_spread = matches!(asked, Asked::All) && much_scatter(found).next().is_some();
    if ids.is_empty() && !is_spread {
        ensure!(
            found.effective.is_empty(),
            "the diagnosis names no effect for sure, but the error falls with {}: \
             `pushlab add --all --from …` adds what lowers it",
            found.effective.join(", ")
        );
        let groups: Vec<String> = found.ambiguous.iter().map(|group| group.join(", ")).collect();
        match groups.is_empty() {
            true => bail!("the diagnosis names no effect: {}", found.sentence),
            false => bail!(
                "the diagnosis names no single effect, but one of {}; name the one to add, as in \
                 `pushlab add {} --from …`, or let `pushlab suggest` tell which pushes would decide",
                groups.join("; one of "),
                found.ambiguous[0].first().map_or("EFFECT", String::as_str),
            ),
        }
    }
    ids.into_iter().map(|id| diagnosed_effect(found, id)).collect()
}

/// An effect with the values that a diagnosis tells.
///
/// # Errors
/// If it is none of those claimed or possible, or has no values.
pub(crate) fn diagnosed_effect(found: &Diagnosis, id: &str) -> Result<ModelEffect> {
    let known = found.effects.iter().find(|effect| effect.id == id);
    let Some(EffectFinding { grade, parameters, why, .. }) = known else {
        bail!("the diagnosis does not tell of {id}: the model that was diagnosed has it already")
    };
    let said = match grade {
        Grade::Identified | Grade::Ambiguous | Grade::Effective => "",
        Grade::Hint => "is a hint alone",
        Grade::BelowDetectionLimit => "was not seen",
        Grade::NotTestable => "cannot be tested with these pushes",
    };
    let why = if why.is_empty() { String::new() } else { format!(" ({why})") };
    ensure!(
        said.is_empty(),
        "{id} {said}{why}; to add it all the same: `pushlab add {id} --fit SET`, or `--set`"
    );
    let about = by_id(id)?.info();
    let values = parameters.iter().filter_map(|one| Some((one.name.clone(), one.estimate?)));
    let setting = Setting { id: id.to_owned(), parameters: values.collect(), ..Setting::default() };
    let Ok(values) = setting.values(about) else {
        bail!(
            "the diagnosis does not tell the values of {id}; `pushlab add {id} --fit SET` fits them"
        )
    };
    about.check(&values)?;
    let source = source(found);
    let estimate = |one: &ParameterFinding| {
        let value = one.estimate.unwrap_or_default();
        (one.name.clone(), Estimate { value, se: se(one), source: source.clone() })
    };
    Ok(ModelEffect::new(id, parameters.iter().map(estimate).collect()))
}

/// Lets what the diagnosis found to differ from push to push differ in a model, as far as it is much of the
/// noise and the model says about which value; says whether something did, and of which effects not.
///
/// # Errors
/// If an effect differs from place to place as well, by another measure.
pub(super) fn spread<'a>(
    model: &mut Description,
    found: &'a Diagnosis,
) -> Result<(bool, Vec<&'a str>)> {
    let (mut is_given, mut left_out) = (false, Vec::new());
    for scatter in much_scatter(found) {
        let (id, about) = (scatter.effect.as_str(), by_id(&scatter.effect)?.info());
        if !model.effects.iter().any(|carried| carried.id == id) {
            match off(model, about, &source(found)) {
                Some(off) => model.effects.push(off),
                None => {
                    left_out.push(id);
                    continue;
                }
            }
        }
        let alike = about.parameters.iter().filter(|one| one.unit == scatter.unit);
        for carried in model.effects.iter_mut().filter(|carried| carried.id == id) {
            let sd = |one: &Parameter| (one.name.to_owned(), Spread::Sd(scatter.sd));
            carried.per_push.extend(alike.clone().map(sd));
            // The diagnosis tells all that differs between pushes, sessions' part with it.
            for one in alike.clone() {
                carried.per_session.remove(one.name);
            }
            carried.setting().check_spreads()?;
        }
        is_given = true;
    }
    Ok((is_given, left_out))
}

/// An effect at the values where it changes nothing, with the source of its scatter; none where a model does not
/// say which they are.
fn off(model: &Description, about: &EffectInfo, source: &str) -> Option<ModelEffect> {
    let value = |parameter: &Parameter| match (parameter.off, &model.base) {
        (Off::At(value), _) => Some(Estimate::exact(value, &format!("scatter {source}"))),
        (Off::PusherFriction, Base::Analytical(base)) => Some(base.pusher_friction().clone()),
        _ => None,
    };
    let values = about.parameters.iter().map(|one| Some((one.name.to_owned(), value(one)?)));
    Some(ModelEffect::new(about.id, values.collect::<Option<_>>()?))
}

fn much_scatter(found: &Diagnosis) -> impl Iterator<Item = &PushScatter> {
    found.noise.push_to_push.iter().filter(|one| one.is_much())
}

/// The standard error, or the half-width of the interval over the normal quantile.
fn se(parameter: &ParameterFinding) -> f64 {
    const NORMAL_975: f64 = 1.96;
    let ParameterFinding { se, low95, high95, .. } = parameter;
    let of_interval = low95.zip(*high95).map(|(low, high)| 0.5 * (high - low) / NORMAL_975);
    se.or(of_interval).unwrap_or_default().max(0.0)
}

fn source(found: &Diagnosis) -> String {
    let tool = found.made_by.as_ref().map_or("a diagnosis", |made| made.tool.as_str());
    let split = &found.split;
    format!("diagnosed by {tool} on {} pushes, sha256:{}", split.fit.len(), split.set)
}
