//! A pusher of another radius.

use crate::{
    Channel, Confounder, Effect, EffectInfo, Geometry, Nuisance, Off, Origin, Parameter, Role,
    Stage, StepInput, Tolerance,
};

/// Pusher radius: see [`EffectInfo`] for its physics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PusherRadius;

static INFO: EffectInfo = EffectInfo {
    id: "pusher-radius",
    title: "Pusher radius",
    physics: "A pusher thicker than stated touches earlier, which shows in the gap; it touches \
        corners elsewhere and rolls farther along an edge that turns. An outline that is smaller than \
        stated looks like a thinner pusher, even like one that is thinner than a point.",
    equation: "R = R₀ + excess, with R₀ the stated radius, in m; where R < 0, a point and the outline \
        moved inwards by −R.",
    source: "Montana (1988), The kinematics of contact and grasp, Int. J. Robotics Research 7(3).",
    stages: &[Stage::Geometry],
    origin: Origin::Contact,
    reaches: &[Channel::Motion, Channel::Force, Channel::Gap],
    parameters: &[Parameter {
        name: "excess",
        unit: "m",
        meaning: "True radius less the stated one",
        off: Off::At(0.0),
        typical: 5e-4,
        range: (-5e-3, 5e-3),
        role: Role::Even,
    }],
    confounders: &[
        Confounder { id: "stream-latency", when: "in the gap, at one speed and one β" },
        Confounder { id: "pose-offset", when: "in the gap, with one edge only" },
    ],
    nuisance: Nuisance::Known(Tolerance::PusherRadius),
    shown_by: &[],
};

impl Effect for PusherRadius {
    fn info(&self) -> &EffectInfo {
        &INFO
    }

    fn geometry(&self, values: &[f64], _: &StepInput, geometry: &mut Geometry) {
        geometry.radius_excess += values[0];
    }
}
