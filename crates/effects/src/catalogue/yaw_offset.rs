//! A tracked frame that is turned against the outline.

use crate::{
    Channel, Effect, EffectInfo, MeasurementModel, Nuisance, Off, Origin, Parameter, Role, Stage,
    StepInput, Tolerance,
};

/// Turn of the tracked frame: see [`EffectInfo`] for its physics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct YawOffset;

static INFO: EffectInfo = EffectInfo {
    id: "yaw-offset",
    title: "Turn of the tracked frame",
    physics: "The tracked frame is turned against the drawing: every β is wrong by the same \
        angle, and the gap by the angle times the distance along the edge.",
    equation: "pose_wo = pose_wb · (0, 0, ψ), with O the outline's frame, ψ in rad.",
    source: "Tsai & Lenz (1989), A new technique for fully autonomous and efficient 3D robotics \
        hand/eye calibration, IEEE Trans. Robotics and Automation 5(3), for calibrated frames.",
    stages: &[Stage::Measurement],
    origin: Origin::Measurement,
    reaches: &[Channel::Motion, Channel::Force, Channel::Gap],
    parameters: &[Parameter {
        name: "yaw",
        unit: "rad",
        meaning: "Turn of the outline against the tracked frame",
        off: Off::At(0.0),
        typical: 0.015,
        range: (-0.3, 0.3),
        role: Role::Odd,
    }],
    confounders: &[],
    nuisance: Nuisance::Known(Tolerance::Yaw),
    shown_by: &[],
};

impl Effect for YawOffset {
    fn info(&self) -> &EffectInfo {
        &INFO
    }

    fn measurement(&self, values: &[f64], _: &StepInput, measurement: &mut MeasurementModel) {
        measurement.yaw += values[0];
    }
}
