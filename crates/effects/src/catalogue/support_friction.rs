//! Another friction between object and table.

use crate::{
    Channel, Effect, EffectInfo, Nuisance, Off, Origin, Parameter, Role, Snapshot, Stage, Support,
};

/// Friction with the table: see [`EffectInfo`] for its physics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SupportFriction;

static INFO: EffectInfo = EffectInfo {
    id: "support-friction",
    title: "Friction with the table",
    physics: "The table is rougher or smoother than stated. On a level table the quasi-static \
        motion does not depend on it: only the force does, in proportion. With a tilt or with \
        inertia the motion depends on the ratio of the load to friction.",
    equation: "F = μs m g, with μs the coefficient of friction, m the mass in kg, g gravity in \
        m/s².",
    source: "Yu, Bauza, Fazeli & Rodriguez (2016), More than a million ways to be pushed, IROS.",
    stages: &[Stage::Support],
    origin: Origin::Table,
    reaches: &[Channel::Force],
    parameters: &[Parameter {
        name: "friction",
        unit: "1",
        meaning: "Coefficient of friction between object and table",
        off: Off::SupportFriction,
        typical: 0.3,
        range: (0.01, 2.0),
        role: Role::Even,
    }],
    confounders: &[],
    nuisance: Nuisance::Free { nominal_within: 0.03 },
    shown_by: &[],
};

impl Effect for SupportFriction {
    fn info(&self) -> &EffectInfo {
        &INFO
    }

    fn support(&self, values: &[f64], moment: &Snapshot<'_>, support: &mut Support) {
        support.friction *= values[0] / moment.rig.support_friction();
    }
}
