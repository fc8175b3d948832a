//! Between the ellipsoid and the exact surface of uniform pressure.

use crate::{
    Channel, Confounder, Effect, EffectInfo, Nuisance, Off, Origin, Parameter, Role, Snapshot,
    Stage, Support,
};

/// Shape of the limit surface: see [`EffectInfo`] for its physics.
///
/// The load w(t) is the gradient of the power P(t) = (1 − λ) P_ellipsoid(t) + λ P_patch(t). Both powers
/// are support functions of convex surfaces, that is convex and homogeneous of degree one. For 0 ≤ λ
/// ≤ 1 neither factor is negative, so P is convex and homogeneous too: the support function of the
/// Minkowski sum of both bodies, scaled by the factors. Beyond, one body is subtracted and the rest need
/// not be convex: on a rectangle of 3:1 it is not at λ = 1.25 or −0.5.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LimitSurfaceShape;

static INFO: EffectInfo = EffectInfo {
    id: "limit-surface-shape",
    title: "Shape of the limit surface",
    physics: "The exact limit surface of uniform pressure is not an ellipsoid: turns about centers \
        in and near the object come out differently. The loads of both surfaces for the same \
        motion are mixed; both have the same largest force and moment. A mixture of two convex \
        surfaces is convex; beyond its ends it is not, and λ ends there.",
    equation: "w(t) = (1 − λ) w_ellipsoid(t) + λ w_patch(t), with t the motion and w its load; λ \
        = 0 the ellipsoid, 1 the patch.",
    source: "Goyal, Ruina & Papadopoulos (1991), Planar sliding with dry friction, Wear 143; Howe \
        & Cutkosky (1996), Practical force-motion models for sliding manipulation, Int. J. \
        Robotics Research 15(6).",
    stages: &[Stage::Support],
    origin: Origin::Support,
    reaches: &[Channel::Motion, Channel::Force],
    parameters: &[Parameter {
        name: "lambda",
        unit: "1",
        meaning: "0 for the ellipsoid, 1 for the exact surface of uniform pressure",
        off: Off::SurfaceShape,
        typical: 1.0,
        range: (0.0, 1.0),
        role: Role::Share,
    }],
    confounders: &[
        Confounder {
            id: "pressure-radius",
            when: "where all pushes turn alike; an ellipsoid fitted to the exact surface has a c \
                that is 9 to 14 % too small",
        },
        Confounder {
            id: "rate-dependent-friction",
            when: "at one speed; pushes at several speeds tell them apart",
        },
    ],
    nuisance: Nuisance::No,
    shown_by: &[],
};

impl Effect for LimitSurfaceShape {
    fn info(&self) -> &EffectInfo {
        &INFO
    }

    fn support(&self, values: &[f64], moment: &Snapshot<'_>, support: &mut Support) {
        support.shape += values[0] - moment.rig.surface_shape();
    }
}
