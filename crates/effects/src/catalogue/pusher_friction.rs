//! Another friction between pusher and object.

use crate::{
    Channel, ContactLaw, Effect, EffectInfo, Nuisance, Off, Origin, Parameter, Role, Snapshot,
    Stage,
};

/// Friction with the pusher: see [`EffectInfo`] for its physics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PusherFriction;

static INFO: EffectInfo = EffectInfo {
    id: "pusher-friction",
    title: "Friction with the pusher",
    physics: "The pusher sticks to steeper pushes, or slides at flatter ones, than stated: the \
        friction cone is wider or narrower.",
    equation: "|f_t| ≤ μp f_n, with f_n and f_t the force along and across the contact normal.",
    source: "Lynch, Maekawa & Tanie (1992), Manipulation and active sensing by pushing using \
        tactile feedback, IROS.",
    stages: &[Stage::Contact],
    origin: Origin::Contact,
    reaches: &[Channel::Motion, Channel::Force],
    parameters: &[Parameter {
        name: "friction",
        unit: "1",
        meaning: "Coefficient of friction between pusher and object",
        off: Off::PusherFriction,
        typical: 0.35,
        range: (0.0, 2.0),
        role: Role::Even,
    }],
    confounders: &[],
    nuisance: Nuisance::Free { nominal_within: 0.03 },
    shown_by: &[],
};

impl Effect for PusherFriction {
    fn info(&self) -> &EffectInfo {
        &INFO
    }

    fn contact(&self, values: &[f64], moment: &Snapshot<'_>, law: &mut ContactLaw) {
        law.friction += values[0] - moment.rig.pusher_friction();
    }
}
