//! A pusher that sticks harder than it slides.

use crate::{
    Channel, Confounder, ContactLaw, Effect, EffectInfo, Nuisance, Off, Origin, Parameter, Role,
    Snapshot, Stage,
};

/// Stiction of the pusher: see [`EffectInfo`] for its physics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PusherStiction;

static INFO: EffectInfo = EffectInfo {
    id: "pusher-stiction",
    title: "Stiction of the pusher",
    physics: "A sticking contact holds until the force leaves a cone that is wider than the one \
        in which it slides fast; a sliding one goes on until it comes to rest. Where it may do \
        either a push does what it did before: at the start of a step it slides if its measured \
        slip is more than half of what sliding would give, or if contact begins there.",
    equation: "Sticks while |f_t| ≤ r μp f_n; slides with |f_t| = μp (1 + (r − 1) exp(−s²/vs²)) f_n, \
        with r the ratio, s the slip and vs the Stribeck velocity, in m/s.",
    source: "Canudas de Wit, Olsson, Åström & Lischinsky (1995), A new model for control of systems \
        with friction, IEEE Trans. Automatic Control 40(3), its curve of steady sliding.",
    stages: &[Stage::Contact],
    origin: Origin::Contact,
    reaches: &[Channel::Motion, Channel::Force],
    parameters: &[
        Parameter {
            name: "ratio",
            unit: "1",
            meaning: "Static over kinetic friction with the pusher",
            off: Off::At(1.0),
            typical: 1.3,
            range: (1.0, 3.0),
            role: Role::Even,
        },
        Parameter {
            name: "stribeck_velocity",
            unit: "m/s",
            meaning: "Slip over which the difference fades",
            off: Off::Undefined,
            typical: 2e-3,
            range: (1e-4, 0.1),
            role: Role::Even,
        },
    ],
    confounders: &[Confounder { id: "pusher-friction", when: "where few pushes slide" }],
    nuisance: Nuisance::No,
    shown_by: &[],
};

impl Effect for PusherStiction {
    fn info(&self) -> &EffectInfo {
        &INFO
    }

    fn contact(&self, values: &[f64], _: &Snapshot<'_>, law: &mut ContactLaw) {
        law.static_ratio *= values[0];
        law.stribeck_velocity = values[1];
    }
}
