//! A pusher that yields.

use crate::{
    Channel, Confounder, ContactLaw, Effect, EffectInfo, Nuisance, Off, Origin, Parameter, Role,
    Snapshot, Stage, Tolerance,
};

/// Compliance of the pusher: see [`EffectInfo`] for its physics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PusherCompliance;

static INFO: EffectInfo = EffectInfo {
    id: "pusher-compliance",
    title: "Compliance of the pusher",
    physics: "Arm and pin are springs: under force the tip stays behind the place that the robot \
        reports. The measured gap is negative by the deflection, and at first contact the robot \
        goes that way before the object moves. Only the yielding along the normal is followed, \
        and no vibration.",
    equation: "d = C f_n, with C the compliance in m/N.",
    source: "Whitney (1982), Quasi-static assembly of compliantly supported rigid parts, J. \
        Dynamic Systems, Measurement, and Control 104(1).",
    stages: &[Stage::Contact],
    origin: Origin::Contact,
    reaches: &[Channel::Motion, Channel::Force, Channel::Gap],
    parameters: &[Parameter {
        name: "compliance",
        unit: "m/N",
        meaning: "Way that the tip yields for each newton",
        off: Off::At(0.0),
        typical: 5e-5,
        range: (0.0, 1e-3),
        role: Role::Even,
    }],
    confounders: &[
        Confounder { id: "stream-latency", when: "without the gap at several speeds" },
        Confounder { id: "inertia", when: "without the gap" },
    ],
    nuisance: Nuisance::Known(Tolerance::Compliance),
    shown_by: &[],
};

impl Effect for PusherCompliance {
    fn info(&self) -> &EffectInfo {
        &INFO
    }

    fn contact(&self, values: &[f64], _: &Snapshot<'_>, law: &mut ContactLaw) {
        law.compliance += values[0];
    }
}
