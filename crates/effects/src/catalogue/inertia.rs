//! An object that takes time to start and to stop.

use crate::{
    Channel, Confounder, Effect, EffectInfo, Nuisance, Off, Origin, Parameter, Role, Stage,
};

/// Inertia: see [`EffectInfo`] for its physics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Inertia;

static INFO: EffectInfo = EffectInfo {
    id: "inertia",
    title: "Inertia",
    physics: "A fast push does not meet the balance of friction alone: the object takes up the \
        pusher's speed in an impact, turns with a delay of about v/(μ g), presses harder while it \
        is accelerated, and slides on when the pusher stops. A step in the midst of a push begins as \
        fast as the push makes the object from its first contact on, whatever speed was measured. Mass \
        and moment are those of the object; the effect is there or not.",
    equation: "M dt/dt = w_pusher + w_load − w_friction(t), with t the motion and M the mass \
        matrix; an inelastic impact at the touch.",
    source: "Mason (2001), Mechanics of Robotic Manipulation, chapters on quasi-static and \
        dynamic manipulation; Alexander (1977), SIAM J. Numerical Analysis 14(6), for the time \
        step.",
    stages: &[Stage::Dynamics],
    origin: Origin::Dynamics,
    reaches: &[Channel::Motion, Channel::Force, Channel::Gap],
    parameters: &[Parameter {
        name: "kappa",
        unit: "1",
        meaning: "1 with inertia, 0 without",
        off: Off::At(0.0),
        typical: 1.0,
        range: (0.0, 1.0),
        role: Role::Switch,
    }],
    confounders: &[
        Confounder { id: "stream-latency", when: "after the stop only" },
        Confounder { id: "pusher-compliance", when: "after the stop only" },
    ],
    nuisance: Nuisance::No,
    shown_by: &[],
};

impl Effect for Inertia {
    fn info(&self) -> &EffectInfo {
        &INFO
    }

    fn has_inertia(&self, values: &[f64]) -> bool {
        values[0] == 1.0
    }
}
