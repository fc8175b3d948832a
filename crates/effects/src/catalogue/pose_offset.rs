//! A tracked frame beside the outline.

use nalgebra::Vector2;

use crate::{
    Channel, Confounder, Effect, EffectInfo, Frame, MeasurementModel, Nuisance, Off, Origin,
    Parameter, Role, Stage, StepInput, Tolerance,
};

/// Offset of the tracked frame: see [`EffectInfo`] for its physics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PoseOffset;

static INFO: EffectInfo = EffectInfo {
    id: "pose-offset",
    title: "Offset of the tracked frame",
    physics: "The markers were not glued where the drawing says: the outline, and with it the \
        support, lies beside the tracked frame. The contact is elsewhere than it seems, and the \
        gap is wrong by the part of the offset along the normal.",
    equation: "pose_wo = pose_wb · (mx, my, 0), with O the outline's frame, in m, fixed to the \
        body.",
    source: "Tsai & Lenz (1989), A new technique for fully autonomous and efficient 3D robotics \
        hand/eye calibration, IEEE Trans. Robotics and Automation 5(3), for calibrated frames.",
    stages: &[Stage::Measurement],
    origin: Origin::Measurement,
    reaches: &[Channel::Motion, Channel::Force, Channel::Gap],
    parameters: &[
        Parameter {
            name: "mx",
            unit: "m",
            meaning: "Place of the outline along x of the tracked frame",
            off: Off::At(0.0),
            typical: 1e-3,
            range: (-0.02, 0.02),
            role: Role::X(Frame::Body),
        },
        Parameter {
            name: "my",
            unit: "m",
            meaning: "Place of the outline along y of the tracked frame",
            off: Off::At(0.0),
            typical: -8e-4,
            range: (-0.02, 0.02),
            role: Role::Y(Frame::Body),
        },
    ],
    confounders: &[
        Confounder { id: "friction-center-offset", when: "without the contact gap" },
        Confounder { id: "friction-gradient", when: "with one edge and one orientation only" },
        Confounder { id: "contact-bias", when: "with one edge and one orientation only" },
    ],
    nuisance: Nuisance::Known(Tolerance::Pose),
    shown_by: &[],
};

impl Effect for PoseOffset {
    fn info(&self) -> &EffectInfo {
        &INFO
    }

    fn measurement(&self, values: &[f64], _: &StepInput, measurement: &mut MeasurementModel) {
        measurement.offset_b += Vector2::new(values[0], values[1]);
    }
}
