//! Object poses that come late.

use crate::{
    Channel, Confounder, Effect, EffectInfo, MeasurementModel, Nuisance, Off, Origin, Parameter,
    Role, Stage, StepInput, Tolerance,
};

/// Latency of the object stream: see [`EffectInfo`] for its physics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StreamLatency;

static INFO: EffectInfo = EffectInfo {
    id: "stream-latency",
    title: "Latency of the object stream",
    physics: "The object's stamps are late against the robot's: the pose at a stamp is that of a \
        moment before. While the pusher moves, the gap is wrong by speed times latency; where \
        contact begins the object seems to start late, and after the stop it seems to slide on.",
    equation: "pose_measured(t) = pose_true(t − τ), with τ in s; the pusher's way before and \
        after the step goes on at the velocity of its ends.",
    source: "Olson (2010), A passive solution to the sensor synchronization problem, IROS.",
    stages: &[Stage::Measurement],
    origin: Origin::Measurement,
    reaches: &[Channel::Motion, Channel::Force, Channel::Gap],
    parameters: &[Parameter {
        name: "latency",
        unit: "s",
        meaning: "How late the object's stream is against the robot's",
        off: Off::At(0.0),
        typical: 5e-3,
        range: (-0.1, 0.1),
        role: Role::Even,
    }],
    confounders: &[
        Confounder { id: "inertia", when: "after the stop only" },
        Confounder { id: "pusher-compliance", when: "without the gap at several speeds" },
        Confounder { id: "pusher-radius", when: "in the gap, at one speed and one β" },
    ],
    nuisance: Nuisance::Known(Tolerance::Latency),
    shown_by: &[],
};

impl Effect for StreamLatency {
    fn info(&self) -> &EffectInfo {
        &INFO
    }

    fn measurement(&self, values: &[f64], _: &StepInput, measurement: &mut MeasurementModel) {
        measurement.latency += values[0];
    }
}
