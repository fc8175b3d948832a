//! Between the ellipsoid and the exact surface of uniform pressure.

use crate::{About, Channel, Effect, LookAlike, Moment, Off, Parameter, Role, Stage, Support};

/// Shape of the limit surface: see [`About`] for its physics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LimitSurfaceShape;

static ABOUT: About = About {
    id: "limit-surface-shape",
    title: "Shape of the limit surface",
    physics: "The exact limit surface of uniform pressure is not an ellipsoid: turns about centers \
        in and near the object come out differently. The loads of both surfaces for the same \
        motion are mixed; both have the same largest force and moment. Beyond λ = 1.25 the mixture \
        need not be convex on long triangles.",
    equation: "w(t) = (1 − λ) w_ellipsoid(t) + λ w_patch(t), with t the motion and w its load; λ \
        = 0 the ellipsoid, 1 the patch.",
    source: "Goyal, Ruina & Papadopoulos (1991), Planar sliding with dry friction, Wear 143; Howe \
        & Cutkosky (1996), Practical force-motion models for sliding manipulation, Int. J. \
        Robotics Research 15(6).",
    stages: &[Stage::Support],
    reaches: &[Channel::Motion, Channel::Force],
    parameters: &[Parameter {
        name: "lambda",
        unit: "1",
        meaning: "0 for the ellipsoid, 1 for the exact surface of uniform pressure",
        off: Off::SurfaceShape,
        typical: 1.0,
        range: (-0.5, 1.5),
        role: Role::Even,
    }],
    look_alikes: &[
        LookAlike {
            id: "pressure-radius",
            when: "where all pushes turn alike; an ellipsoid fitted to the exact surface has a c \
                that is 9 to 14 % too small",
        },
        LookAlike {
            id: "rate-dependent-friction",
            when: "at one speed; pushes at several speeds tell them apart",
        },
    ],
};

impl Effect for LimitSurfaceShape {
    fn about(&self) -> &About {
        &ABOUT
    }

    fn support(&self, values: &[f64], moment: &Moment<'_>, support: &mut Support) {
        support.shape += values[0] - moment.rig.surface_shape();
    }
}
