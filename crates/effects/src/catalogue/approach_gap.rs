//! A push that begins before the touch.

use crate::{
    Channel, Confounder, Effect, EffectInfo, Geometry, Nuisance, Off, Origin, Parameter, Role,
    Stage, StepInput,
};

/// Approach gap: see [`EffectInfo`] for its physics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ApproachGap;

static INFO: EffectInfo = EffectInfo {
    id: "approach-gap",
    title: "Gap before the touch",
    physics: "Where a push is said to begin, the pusher is still a little away from the object: that \
        much of its way is lost before the object moves.",
    equation: "The object rests until the pusher has moved by g, in m, towards it.",
    source: "Kinematics of a pusher that moves before it touches.",
    stages: &[Stage::Geometry],
    origin: Origin::Contact,
    reaches: &[Channel::Motion, Channel::Force, Channel::Gap],
    parameters: &[Parameter {
        name: "gap",
        unit: "m",
        meaning: "Between pusher and object where contact is said to begin",
        off: Off::At(0.0),
        typical: 1e-3,
        range: (0.0, 0.02),
        role: Role::Even,
    }],
    confounders: &[
        Confounder { id: "pusher-radius", when: "where only the first step of a push is seen" },
        Confounder { id: "pusher-compliance", when: "without the contact force" },
    ],
    nuisance: Nuisance::No,
    shown_by: &["steps from the first contact on"],
};

impl Effect for ApproachGap {
    fn info(&self) -> &EffectInfo {
        &INFO
    }

    fn geometry(&self, values: &[f64], _: &StepInput, geometry: &mut Geometry) {
        geometry.approach_gap += values[0];
    }
}
