//! A push above the table.

use crate::{
    Channel, Confounder, ContactLaw, Effect, EffectInfo, Nuisance, Off, Origin, Parameter, Role,
    Snapshot, Stage,
};

/// Height of the push: see [`EffectInfo`] for its physics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PushHeight;

static INFO: EffectInfo = EffectInfo {
    id: "push-height",
    title: "Push above the table",
    physics: "A push at some height tips the object: friction holds it at its bottom. The weight leans \
        the way it is pushed, and with it the center of friction.",
    equation: "d = h f/(m g): the center of the pressure moves by d along the contact force f, which \
        depends on it in turn; h the height of the contact above the table, in m.",
    source: "Statics of a rigid object; Lynch (1999), Toppling manipulation, ICRA, for where it ends.",
    stages: &[Stage::Contact],
    origin: Origin::Contact,
    reaches: &[Channel::Motion, Channel::Force],
    parameters: &[Parameter {
        name: "height",
        unit: "m",
        meaning: "Of the contact above the table",
        off: Off::At(0.0),
        typical: 0.01,
        range: (0.0, 0.2),
        role: Role::Even,
    }],
    confounders: &[Confounder {
        id: "friction-center-offset",
        when: "with one edge only: a push always leans the load away from the pusher",
    }],
    nuisance: Nuisance::No,
    shown_by: &["pushes of opposite edges"],
};

impl Effect for PushHeight {
    fn info(&self) -> &EffectInfo {
        &INFO
    }

    fn contact(&self, values: &[f64], _: &Snapshot<'_>, law: &mut ContactLaw) {
        law.height += values[0];
    }
}
