//! A center of friction beside the centroid.

use nalgebra::Vector2;

use crate::{
    Channel, Confounder, Effect, EffectInfo, Frame, Nuisance, Off, Origin, Parameter, Role,
    Snapshot, Stage, Support,
};

/// Offset of the center of friction: see [`EffectInfo`] for its physics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrictionCenterOffset;

static INFO: EffectInfo = EffectInfo {
    id: "friction-center-offset",
    title: "Offset of the center of friction",
    physics: "The object presses harder on one side, because its mass is not centered or its base \
        not flat. A push through the shifted center moves it without turning. The center is that \
        of the pressure: the load leans toward it and stays under the outline, with the same mean \
        distance c from it. An ellipsoid moves as it is, and so does any load by what is beyond 0.8 \
        standard deviations of the area.",
    equation: "p_center = p_centroid + (dx, dy), in m, fixed to the object; p(r) ∝ exp(g·r + \
        a |r − d|) with d = ∫ r p dA and c = ∫ |r − d| p dA, of all such pressures the nearest \
        to uniform.",
    source: "Yoshikawa & Kurisu (1991), Identification of the center of friction from pushing an \
        object by a mobile robot, IROS.",
    stages: &[Stage::Support],
    origin: Origin::Support,
    reaches: &[Channel::Motion, Channel::Force],
    parameters: &[
        Parameter {
            name: "dx",
            unit: "m",
            meaning: "Along x of the body",
            off: Off::At(0.0),
            typical: 3e-3,
            range: (-0.05, 0.05),
            role: Role::X(Frame::Body),
        },
        Parameter {
            name: "dy",
            unit: "m",
            meaning: "Along y of the body",
            off: Off::At(0.0),
            typical: -2e-3,
            range: (-0.05, 0.05),
            role: Role::Y(Frame::Body),
        },
    ],
    confounders: &[
        Confounder { id: "pose-offset", when: "without the contact gap" },
        Confounder { id: "friction-gradient", when: "with one edge and one orientation only" },
        Confounder { id: "contact-bias", when: "with one edge and one orientation only" },
    ],
    nuisance: Nuisance::No,
    shown_by: &[],
};

impl Effect for FrictionCenterOffset {
    fn info(&self) -> &EffectInfo {
        &INFO
    }

    fn support(&self, values: &[f64], _: &Snapshot<'_>, support: &mut Support) {
        support.center_o += Vector2::new(values[0], values[1]);
    }
}
