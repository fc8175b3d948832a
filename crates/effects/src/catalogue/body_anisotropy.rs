//! Friction that depends on the direction over the body.

use crate::{
    Channel, Confounder, Effect, EffectInfo, Frame, LogTensor, Nuisance, Off, Origin, Parameter,
    Role, Snapshot, Stage, Support,
};

/// Anisotropy of the body: see [`EffectInfo`] for its physics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BodyAnisotropy;

static INFO: EffectInfo = EffectInfo {
    id: "body-anisotropy",
    title: "Anisotropy of the body",
    physics: "The object's base has a grain. An object that slides along the grain meets another \
        friction than across it. Friction is an ellipse: T is symmetric, with determinant 1 and \
        the square roots of ratio and 1/ratio along and across the direction. The grain turns \
        with the object.",
    equation: "f = μ T² v/|T v|, with v the velocity over the table; T = R(φ) diag(ratio^½, \
        ratio^−½) R(φ)ᵀ, φ the direction in the body.",
    source: "Zmitrowicz (1981), A theoretical model of anisotropic dry friction, Wear 73(1).",
    stages: &[Stage::Support],
    origin: Origin::Support,
    reaches: &[Channel::Motion, Channel::Force],
    parameters: &[
        Parameter {
            name: "ratio",
            unit: "1",
            meaning: "Friction along the direction over friction across it",
            off: Off::At(1.0),
            typical: 1.3,
            range: (0.25, 4.0),
            role: Role::Ratio(Frame::Body),
        },
        Parameter {
            name: "direction",
            unit: "rad",
            meaning: "Direction of the larger friction in the body, modulo π",
            off: Off::Undefined,
            typical: 0.6,
            range: (-6.3, 6.3),
            role: Role::Direction(Frame::Body),
        },
    ],
    confounders: &[
        Confounder { id: "table-anisotropy", when: "with one edge and one orientation only" },
        Confounder { id: "table-tilt", when: "with one edge and one orientation only" },
    ],
    nuisance: Nuisance::No,
    shown_by: &[],
};

impl Effect for BodyAnisotropy {
    fn info(&self) -> &EffectInfo {
        &INFO
    }

    fn support(&self, values: &[f64], _: &Snapshot<'_>, support: &mut Support) {
        support.tensor_o += LogTensor::axis(values[0], values[1]);
    }
}
