//! A table that is rougher on one side.

use nalgebra::Vector2;

use crate::{
    Channel, Confounder, Effect, EffectInfo, Frame, Nuisance, Off, Origin, Parameter, Role,
    Snapshot, Stage, Support,
};

/// Gradient of friction over the table: see [`EffectInfo`] for its physics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrictionGradient;

static INFO: EffectInfo = EffectInfo {
    id: "friction-gradient",
    title: "Gradient of friction over the table",
    physics: "Friction grows from one side of the table to the other, by wear or dust. The \
        rougher part of the support pulls the center of friction towards it, and the force varies \
        with the place on the table.",
    equation: "μ(x) = μs exp(g·x), with x the place in W from its origin; the center of friction \
        moves by (∫ r rᵀ dA/A) g, with r from the centroid.",
    source: "Yu, Bauza, Fazeli & Rodriguez (2016), More than a million ways to be pushed, IROS, \
        which maps friction over the table.",
    stages: &[Stage::Support],
    origin: Origin::Table,
    reaches: &[Channel::Motion, Channel::Force],
    parameters: &[
        Parameter {
            name: "gx",
            unit: "1/m",
            meaning: "Relative growth of friction along x of the table",
            off: Off::At(0.0),
            typical: 1.0,
            range: (-5.0, 5.0),
            role: Role::X(Frame::World),
        },
        Parameter {
            name: "gy",
            unit: "1/m",
            meaning: "Relative growth of friction along y of the table",
            off: Off::At(0.0),
            typical: -0.6,
            range: (-5.0, 5.0),
            role: Role::Y(Frame::World),
        },
    ],
    confounders: &[
        Confounder {
            id: "table-tilt",
            when: "with one orientation, or without pushes over the whole table",
        },
        Confounder { id: "friction-center-offset", when: "with one edge and one orientation only" },
        Confounder { id: "pose-offset", when: "with one edge and one orientation only" },
        Confounder { id: "contact-bias", when: "with one edge and one orientation only" },
    ],
    nuisance: Nuisance::No,
    shown_by: &[],
};

impl Effect for FrictionGradient {
    fn info(&self) -> &EffectInfo {
        &INFO
    }

    fn support(&self, values: &[f64], moment: &Snapshot<'_>, support: &mut Support) {
        let gradient_w = Vector2::new(values[0], values[1]);
        let object = &moment.step.object;
        let place_w = moment.pose_wo.transform_point(object.centroid());
        support.friction *= gradient_w.dot(&place_w).exp();
        support.center_o += object.second_moment() * moment.pose_wo.inverse_rotate(&gradient_w);
    }
}
