//! Friction that changes in the course of a set.

use crate::{
    Channel, Effect, EffectInfo, Nuisance, Off, Origin, Parameter, Role, Snapshot, Stage, Support,
};

/// Drift of friction: see [`EffectInfo`] for its physics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrictionDrift;

static INFO: EffectInfo = EffectInfo {
    id: "friction-drift",
    title: "Drift of friction",
    physics: "Sliding polishes and soils: friction changes from the first push of a set to the \
        last. On a level table the quasi-static motion does not depend on it.",
    equation: "μ = μs (1 + d (s − ½)), with s the place of the push in the set, 0 to 1: the mean \
        stays μs.",
    source: "Yu, Bauza, Fazeli & Rodriguez (2016), More than a million ways to be pushed, IROS, \
        which shows friction over time.",
    stages: &[Stage::Support],
    origin: Origin::Time,
    reaches: &[Channel::Force],
    parameters: &[Parameter {
        name: "change",
        unit: "1",
        meaning: "Friction of the last push less that of the first, over the mean",
        off: Off::At(0.0),
        typical: 0.15,
        range: (-1.5, 1.5),
        role: Role::Even,
    }],
    confounders: &[],
    nuisance: Nuisance::No,
    shown_by: &[],
};

impl Effect for FrictionDrift {
    fn info(&self) -> &EffectInfo {
        &INFO
    }

    fn support(&self, values: &[f64], moment: &Snapshot<'_>, support: &mut Support) {
        support.friction *= 1.0 + values[0] * (moment.step.progress - 0.5);
    }
}
