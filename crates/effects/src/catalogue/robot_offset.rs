//! A robot's frame beside that of motion capture.

use nalgebra::Vector2;

use crate::{
    Channel, Confounder, Effect, EffectInfo, Frame, MeasurementModel, Nuisance, Off, Origin,
    Parameter, Role, Stage, StepInput,
};

/// Offset of the robot's frame: see [`EffectInfo`] for its physics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RobotOffset;

static INFO: EffectInfo = EffectInfo {
    id: "robot-offset",
    title: "Offset of the robot's frame",
    physics: "The robot tells where the tip is, and motion capture where the object is, each in a frame \
        of its own. What a calibration of one against the other leaves, or a tip that is not quite where \
        the robot has it, moves the tip by the same way along the table in every push: along an edge \
        where the object lies one way, into it where it lies another.",
    equation: "tip_w = told_w + (wx, wy), in m, with W the frame of motion capture.",
    source: "Zhuang, Roth & Sudhakar (1994), Simultaneous robot/world and tool/flange calibration by \
        solving homogeneous transformation equations of the form AX = YB, IEEE Trans. Robotics and \
        Automation 10(4).",
    stages: &[Stage::Measurement],
    origin: Origin::Measurement,
    reaches: &[Channel::Motion, Channel::Force, Channel::Gap],
    parameters: &[
        Parameter {
            name: "wx",
            unit: "m",
            meaning: "Place of the tip along x of the table beside where the robot tells it",
            off: Off::At(0.0),
            typical: 1e-3,
            range: (-0.02, 0.02),
            role: Role::X(Frame::World),
        },
        Parameter {
            name: "wy",
            unit: "m",
            meaning: "Place of the tip along y of the table beside where the robot tells it",
            off: Off::At(0.0),
            typical: 8e-4,
            range: (-0.02, 0.02),
            role: Role::Y(Frame::World),
        },
    ],
    confounders: &[
        Confounder { id: "pose-offset", when: "while the object lies one way" },
        Confounder { id: "contact-bias", when: "with one edge and one orientation only" },
        Confounder { id: "pusher-radius", when: "with one edge and one orientation only" },
    ],
    nuisance: Nuisance::No,
    shown_by: &["pushes of an object that lies many ways on the table"],
};

impl Effect for RobotOffset {
    fn info(&self) -> &EffectInfo {
        &INFO
    }

    fn measurement(&self, values: &[f64], _: &StepInput, measurement: &mut MeasurementModel) {
        measurement.robot_w += Vector2::new(values[0], values[1]);
    }
}
