//! Friction that depends on the direction over the table.

use crate::{
    Channel, Confounder, Effect, EffectInfo, Frame, LogTensor, Nuisance, Off, Origin, Parameter,
    Role, Snapshot, Stage, Support,
};

/// Anisotropy of the table: see [`EffectInfo`] for its physics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TableAnisotropy;

static INFO: EffectInfo = EffectInfo {
    id: "table-anisotropy",
    title: "Anisotropy of the table",
    physics: "The table has a grain. An object that slides along the grain meets another friction \
        than across it. Friction is an ellipse: T is symmetric, with determinant 1 and the square \
        roots of ratio and 1/ratio along and across the direction. The grain stays with the table \
        while the object turns.",
    equation: "f = μ T² v/|T v|, with v the velocity over the table; T = R(φ) diag(ratio^½, \
        ratio^−½) R(φ)ᵀ, φ the direction in W.",
    source: "Zmitrowicz (1981), A theoretical model of anisotropic dry friction, Wear 73(1).",
    stages: &[Stage::Support],
    origin: Origin::Table,
    reaches: &[Channel::Motion, Channel::Force],
    parameters: &[
        Parameter {
            name: "ratio",
            unit: "1",
            meaning: "Friction along the direction over friction across it",
            off: Off::At(1.0),
            typical: 1.3,
            range: (0.25, 4.0),
            role: Role::Ratio(Frame::World),
        },
        Parameter {
            name: "direction",
            unit: "rad",
            meaning: "Direction of the larger friction on the table, modulo π",
            off: Off::Undefined,
            typical: 0.6,
            range: (-6.3, 6.3),
            role: Role::Direction(Frame::World),
        },
    ],
    confounders: &[
        Confounder { id: "body-anisotropy", when: "with one edge and one orientation only" },
        Confounder { id: "table-tilt", when: "with one edge and one orientation only" },
    ],
    nuisance: Nuisance::No,
    shown_by: &[],
};

impl Effect for TableAnisotropy {
    fn info(&self) -> &EffectInfo {
        &INFO
    }

    fn support(&self, values: &[f64], moment: &Snapshot<'_>, support: &mut Support) {
        support.tensor_o += LogTensor::axis(values[0], values[1] - moment.pose_wo.angle);
    }
}
