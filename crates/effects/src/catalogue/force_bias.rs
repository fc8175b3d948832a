//! A force sensor with a zero error and a turn.

use nalgebra::Vector2;

use crate::{
    Channel, Effect, EffectInfo, Frame, MeasurementModel, Nuisance, Off, Origin, Parameter, Role,
    Stage, StepInput,
};

/// Bias of the force sensor: see [`EffectInfo`] for its physics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ForceBias;

static INFO: EffectInfo = EffectInfo {
    id: "force-bias",
    title: "Bias of the force sensor",
    physics: "The sensor's zero has moved, and its axes are turned against the table's. The \
        motion does not know.",
    equation: "f_measured = R(turn) f + (fx, fy), force on the object in N, axes of W.",
    source: "Kubus, Kröger & Wahl (2008), On-line estimation of inertial parameters using a \
        recursive total least-squares approach, IROS, which estimates the sensor's offsets with \
        the load.",
    stages: &[Stage::Measurement],
    origin: Origin::Measurement,
    reaches: &[Channel::Force],
    parameters: &[
        Parameter {
            name: "fx",
            unit: "N",
            meaning: "Added along x of the table to the force on the object",
            off: Off::At(0.0),
            typical: 0.1,
            range: (-5.0, 5.0),
            role: Role::X(Frame::World),
        },
        Parameter {
            name: "fy",
            unit: "N",
            meaning: "Added along y of the table to the force on the object",
            off: Off::At(0.0),
            typical: -0.08,
            range: (-5.0, 5.0),
            role: Role::Y(Frame::World),
        },
        Parameter {
            name: "turn",
            unit: "rad",
            meaning: "Turn of the sensor's axes, counter-clockwise",
            off: Off::At(0.0),
            typical: 0.03,
            range: (-3.2, 3.2),
            role: Role::Odd,
        },
    ],
    confounders: &[],
    nuisance: Nuisance::No,
    shown_by: &[],
};

impl Effect for ForceBias {
    fn info(&self) -> &EffectInfo {
        &INFO
    }

    fn measurement(&self, values: &[f64], _: &StepInput, measurement: &mut MeasurementModel) {
        measurement.force_bias_w += Vector2::new(values[0], values[1]);
        measurement.force_turn += values[2];
    }
}
