//! Gravity along a table that is not level.

use nalgebra::Vector2;
use planar::Wrench;

use crate::{
    Channel, Confounder, Effect, EffectInfo, Frame, Nuisance, Off, Origin, Parameter, Role,
    Snapshot, Stage,
};

/// Tilt of the table: see [`EffectInfo`] for its physics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TableTilt;

static INFO: EffectInfo = EffectInfo {
    id: "table-tilt",
    title: "Tilt of the table",
    physics: "On a table that is not level a part of gravity pulls at the center of mass. Below \
        friction it moves nothing by itself, but it helps or hinders the push and turns the \
        motion downhill.",
    equation: "w = m (ax, ay) at the center of mass, with (ax, ay) gravity along the table, in \
        m/s², W.",
    source: "Erdmann & Mason (1988), An exploration of sensorless manipulation, IEEE J. Robotics \
        and Automation 4(4), for gravity along a tilted plane against friction.",
    stages: &[Stage::Load],
    origin: Origin::Table,
    reaches: &[Channel::Motion, Channel::Force],
    parameters: &[
        Parameter {
            name: "ax",
            unit: "m/s²",
            meaning: "Gravity along x of the table",
            off: Off::At(0.0),
            typical: 0.15,
            range: (-2.0, 2.0),
            role: Role::X(Frame::World),
        },
        Parameter {
            name: "ay",
            unit: "m/s²",
            meaning: "Gravity along y of the table",
            off: Off::At(0.0),
            typical: -0.1,
            range: (-2.0, 2.0),
            role: Role::Y(Frame::World),
        },
    ],
    confounders: &[
        Confounder {
            id: "friction-gradient",
            when: "with one orientation, or without pushes over the whole table",
        },
        Confounder { id: "table-anisotropy", when: "with one edge and one orientation only" },
        Confounder { id: "body-anisotropy", when: "with one edge and one orientation only" },
    ],
    nuisance: Nuisance::No,
    shown_by: &[],
};

impl Effect for TableTilt {
    fn info(&self) -> &EffectInfo {
        &INFO
    }

    fn load(&self, values: &[f64], moment: &Snapshot<'_>, load_w: &mut Wrench) {
        let object = &moment.step.object;
        let force_w = object.mass() * Vector2::new(values[0], values[1]);
        let arm_w = moment.pose_wo.rotate(object.center_of_mass());
        *load_w += Wrench::from_force_at(&force_w, &arm_w);
    }
}
