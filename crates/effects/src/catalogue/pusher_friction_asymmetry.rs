//! A friction cone that leans to one side.

use crate::{
    Channel, ContactLaw, Effect, EffectInfo, Nuisance, Off, Origin, Parameter, Role, Snapshot,
    Stage,
};

/// Asymmetry of the pusher friction: see [`EffectInfo`] for its physics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PusherFrictionAsymmetry;

static INFO: EffectInfo = EffectInfo {
    id: "pusher-friction-asymmetry",
    title: "Asymmetry of the pusher friction",
    physics: "The edge's surface has teeth or fibers that lie one way: the pusher slides to one \
        side more easily than to the other. Left is the inward normal turned by +90°, the way of \
        decreasing p.",
    equation: "−μp (1 − a) f_n ≤ f_t ≤ μp (1 + a) f_n.",
    source: "Zmitrowicz (1981), A theoretical model of anisotropic dry friction, Wear 73(1), for \
        friction that differs between the two senses of a direction.",
    stages: &[Stage::Contact],
    origin: Origin::Contact,
    reaches: &[Channel::Motion, Channel::Force],
    parameters: &[Parameter {
        name: "asymmetry",
        unit: "1",
        meaning: "Relative surplus of friction on the left, and lack on the right",
        off: Off::At(0.0),
        typical: 0.2,
        range: (-0.9, 0.9),
        role: Role::Odd,
    }],
    confounders: &[],
    nuisance: Nuisance::No,
    shown_by: &[],
};

impl Effect for PusherFrictionAsymmetry {
    fn info(&self) -> &EffectInfo {
        &INFO
    }

    fn contact(&self, values: &[f64], _: &Snapshot<'_>, law: &mut ContactLaw) {
        law.asymmetry += values[0];
    }
}
