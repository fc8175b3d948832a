//! A force that acts beside the nearest point.

use crate::{
    Channel, Confounder, Effect, EffectInfo, Geometry, Nuisance, Off, Origin, Parameter, Role,
    Stage, StepInput,
};

/// Bias of the contact point: see [`EffectInfo`] for its physics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ContactBias;

static INFO: EffectInfo = EffectInfo {
    id: "contact-bias",
    title: "Bias of the contact point",
    physics: "The pusher leans, or its tip is worn on one side: it touches where pusher and outline \
        are nearest, but its force acts beside that point, along the edge.",
    equation: "p_force = p_nearest + b e, with e the direction of increasing p along the edge.",
    source: "Geometry of a leaning pin; for the sensitivity of the turn to the contact point see \
        Mason (1986), Int. J. Robotics Research 5(3).",
    stages: &[Stage::Geometry],
    origin: Origin::Contact,
    reaches: &[Channel::Motion, Channel::Force],
    parameters: &[Parameter {
        name: "shift",
        unit: "m",
        meaning: "Along the edge, towards larger p",
        off: Off::At(0.0),
        typical: 1e-3,
        range: (-0.02, 0.02),
        role: Role::Odd,
    }],
    confounders: &[
        Confounder { id: "friction-center-offset", when: "with one edge and one orientation only" },
        Confounder { id: "pose-offset", when: "with one edge and one orientation only" },
        Confounder { id: "friction-gradient", when: "with one edge and one orientation only" },
    ],
    nuisance: Nuisance::No,
    shown_by: &[],
};

impl Effect for ContactBias {
    fn info(&self) -> &EffectInfo {
        &INFO
    }

    fn geometry(&self, values: &[f64], _: &StepInput, geometry: &mut Geometry) {
        geometry.contact_shift += values[0];
    }
}
