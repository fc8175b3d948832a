//! Effects of the catalogue, in the terms of the plant.

use std::f64::consts::PI;

use super::{EffectKind, Parameter, Quantity};
use crate::design::layout::Layout;
use crate::{Burr, Design, Feet, PlantError, Texture};

const TURN: (f64, f64) = (-2.0 * PI, 2.0 * PI);
const SPEED: (f64, f64) = (1e-4, 1.0);

/// In the catalogue's order.
pub(super) const KINDS: &[EffectKind] = &[
    EffectKind {
        id: "support-friction",
        about: "the support's friction is not the nominal one",
        in_catalogue: true,
        parameters: &[Parameter::new("coefficient", Quantity::Number, 0.25, 0.32, (0.01, 2.0))],
        apply: |truth, _, v| {
            truth.support_friction.coefficient = v[0];
            Ok(())
        },
    },
    EffectKind {
        id: "pressure-radius",
        about: "the load is nearer to its center, or further, than uniform pressure has it",
        in_catalogue: true,
        parameters: &[Parameter::new("ratio", Quantity::Number, 1.0, 0.85, (0.5, 1.35))],
        apply: |truth, _, v| {
            truth.pressure.radius_ratio = v[0];
            Ok(())
        },
    },
    EffectKind {
        id: "limit-surface-shape",
        about: "part of the load rests on a plate that dissipates like an ellipsoid",
        in_catalogue: true,
        parameters: &[Parameter::new("patch_share", Quantity::Number, 1.0, 0.0, (0.0, 1.0))],
        apply: |truth, _, v| {
            truth.pressure.patch_share = v[0];
            Ok(())
        },
    },
    EffectKind {
        id: "friction-center-offset",
        about: "center of mass and of pressure are off the outline's centroid",
        in_catalogue: true,
        parameters: &[
            Parameter::new("x", Quantity::Length, 0.0, 0.008, (-0.03, 0.03)),
            Parameter::new("y", Quantity::Length, 0.0, -0.004, (-0.03, 0.03)),
        ],
        apply: |truth, _, v| {
            truth.pressure.center_shift = [v[0], v[1]];
            truth.body.center_shift = [v[0], v[1]];
            Ok(())
        },
    },
    EffectKind {
        id: "table-anisotropy",
        about: "friction along a grain of the table differs from friction across it",
        in_catalogue: true,
        parameters: &[
            Parameter::new("ratio", Quantity::Number, 1.0, 1.3, (0.3, 3.0)),
            Parameter::free("direction", Quantity::Angle, 0.6, TURN),
        ],
        apply: |truth, _, v| {
            (truth.table_grain.ratio, truth.table_grain.direction) = (v[0], v[1]);
            Ok(())
        },
    },
    EffectKind {
        id: "body-anisotropy",
        about: "friction along a grain of the object differs from friction across it",
        in_catalogue: true,
        parameters: &[
            Parameter::new("ratio", Quantity::Number, 1.0, 1.3, (0.3, 3.0)),
            Parameter::free("direction", Quantity::Angle, 0.6, TURN),
        ],
        apply: |truth, _, v| {
            (truth.body_grain.ratio, truth.body_grain.direction) = (v[0], v[1]);
            Ok(())
        },
    },
    EffectKind {
        id: "friction-gradient",
        about: "friction rises over the table, relative to that at the table's origin",
        in_catalogue: true,
        parameters: &[
            Parameter::new("x", Quantity::PerLength, 0.0, 2.0, (-10.0, 10.0)),
            Parameter::new("y", Quantity::PerLength, 0.0, -1.0, (-10.0, 10.0)),
        ],
        apply: |truth, _, v| {
            truth.friction_map.gradient = [v[0], v[1]];
            Ok(())
        },
    },
    EffectKind {
        id: "table-tilt",
        about: "the table is tilted: part of gravity acts along it",
        in_catalogue: true,
        parameters: &[
            Parameter::new("x", Quantity::Acceleration, 0.0, -0.25, (-2.0, 2.0)),
            Parameter::new("y", Quantity::Acceleration, 0.0, 0.2, (-2.0, 2.0)),
        ],
        apply: |truth, _, v| {
            truth.height_map.downhill = [v[0], v[1]];
            Ok(())
        },
    },
    EffectKind {
        id: "rate-dependent-friction",
        about: "friction rises with the logarithm of the speed",
        in_catalogue: true,
        parameters: &[
            Parameter::new("slope", Quantity::Number, 0.0, 0.1, (-0.1, 1.0)),
            Parameter::free("speed", Quantity::Speed, 0.01, SPEED),
        ],
        apply: |truth, _, v| {
            let rate = &mut truth.support_friction.rate;
            (rate.log_slope, rate.log_speed) = (v[0], v[1]);
            Ok(())
        },
    },
    EffectKind {
        id: "support-stiction",
        about: "the support's friction is larger at rest and falls within a Stribeck speed",
        in_catalogue: true,
        parameters: &[
            Parameter::new("ratio", Quantity::Number, 1.0, 1.3, (0.5, 3.0)),
            Parameter::free("speed", Quantity::Speed, 0.01, SPEED),
        ],
        apply: |truth, _, v| {
            let rate = &mut truth.support_friction.rate;
            (rate.breakaway_ratio, rate.stribeck_speed) = (v[0], v[1]);
            Ok(())
        },
    },
    EffectKind {
        id: "friction-drift",
        about: "the support's friction changes from the first push to the last",
        in_catalogue: true,
        parameters: &[Parameter::new("change", Quantity::Number, 0.0, -0.15, (-0.9, 0.9))],
        apply: |truth, _, v| {
            truth.support_friction.drift = v[0];
            Ok(())
        },
    },
    EffectKind {
        id: "pusher-friction",
        about: "the tip's friction is not the nominal one",
        in_catalogue: true,
        parameters: &[Parameter::new("coefficient", Quantity::Number, 0.25, 0.4, (0.0, 2.0))],
        apply: |truth, _, v| {
            truth.tip_friction.coefficient = v[0];
            Ok(())
        },
    },
    EffectKind {
        id: "pusher-friction-asymmetry",
        about: "the tip rubs more when it slides to its left than to its right",
        in_catalogue: true,
        parameters: &[Parameter::new("difference", Quantity::Number, 0.0, 0.4, (-1.9, 1.9))],
        apply: |truth, _, v| {
            truth.tip_friction.asymmetry = v[0];
            Ok(())
        },
    },
    EffectKind {
        id: "pusher-stiction",
        about: "the tip's friction is larger at rest than in sliding",
        in_catalogue: true,
        parameters: &[
            Parameter::new("ratio", Quantity::Number, 1.0, 1.5, (0.5, 4.0)),
            Parameter::free("speed", Quantity::Speed, 0.001, SPEED),
        ],
        apply: |truth, _, v| {
            (truth.tip_friction.static_ratio, truth.tip_friction.stribeck_speed) = (v[0], v[1]);
            Ok(())
        },
    },
    EffectKind {
        id: "pusher-radius",
        about: "the tip's radius is not the nominal one",
        in_catalogue: true,
        parameters: &[Parameter::new("radius", Quantity::Length, 0.00475, 0.00575, (5e-4, 0.05))],
        apply: |truth, _, v| {
            truth.tip.radius = v[0];
            Ok(())
        },
    },
    EffectKind {
        id: "contact-bias",
        about: "the force acts beside the geometrical contact, to the left of the inward normal",
        in_catalogue: true,
        parameters: &[Parameter::new("offset", Quantity::Length, 0.0, 0.0015, (-0.02, 0.02))],
        apply: |truth, _, v| {
            truth.tip.bias = v[0];
            Ok(())
        },
    },
    EffectKind {
        id: "edge-rounding",
        about: "the outline's corners are round",
        in_catalogue: true,
        parameters: &[Parameter::new("radius", Quantity::Length, 0.0, 0.005, (0.0, 0.05))],
        apply: |truth, _, v| {
            truth.wear.corner_radius = v[0];
            Ok(())
        },
    },
    EffectKind {
        id: "pusher-compliance",
        about: "tip and arm give way under force",
        in_catalogue: true,
        parameters: &[Parameter::new("compliance", Quantity::Compliance, 2e-5, 3e-4, (1e-6, 5e-3))],
        apply: |truth, _, v| {
            truth.tip.compliance = v[0];
            Ok(())
        },
    },
    EffectKind {
        id: "inertia",
        about: "pushes up to a speed at which mass matters (the plant always has its mass)",
        in_catalogue: true,
        parameters: &[Parameter::new("speed", Quantity::Speed, 0.02, 0.4, (0.02, 0.5))],
        apply: |_, design, v| hurry(design, v[0]),
    },
    EffectKind {
        id: "pose-offset",
        about: "the tracked frame is not at the outline's frame",
        in_catalogue: true,
        parameters: &[
            Parameter::new("x", Quantity::Length, 0.0, 0.002, (-0.05, 0.05)),
            Parameter::new("y", Quantity::Length, 0.0, -0.001, (-0.05, 0.05)),
        ],
        apply: |truth, _, v| {
            truth.markers.shift = [v[0], v[1]];
            Ok(())
        },
    },
    EffectKind {
        id: "yaw-offset",
        about: "the tracked frame is turned against the outline's frame",
        in_catalogue: true,
        parameters: &[Parameter::new("angle", Quantity::Angle, 0.0, 0.025, (-1.0, 1.0))],
        apply: |truth, _, v| {
            truth.markers.yaw = v[0];
            Ok(())
        },
    },
    EffectKind {
        id: "robot-offset",
        about: "motion capture's frame is beside the robot's",
        in_catalogue: true,
        parameters: &[
            Parameter::new("x", Quantity::Length, 0.0, 0.0015, (-0.05, 0.05)),
            Parameter::new("y", Quantity::Length, 0.0, 0.001, (-0.05, 0.05)),
        ],
        apply: |truth, _, v| {
            truth.cameras.shift = [v[0], v[1]];
            Ok(())
        },
    },
    EffectKind {
        id: "stream-latency",
        about: "the object's stamps lag behind the robot's",
        in_catalogue: true,
        parameters: &[Parameter::new("delay", Quantity::Time, 0.0, 0.015, (-0.2, 0.2))],
        apply: |truth, _, v| {
            truth.clocks.object_latency = v[0];
            Ok(())
        },
    },
    EffectKind {
        id: "force-bias",
        about: "the loaded force sensor reads an offset, in turned axes",
        in_catalogue: true,
        parameters: &[
            Parameter::new("x", Quantity::Force, 0.0, 0.25, (-5.0, 5.0)),
            Parameter::new("y", Quantity::Force, 0.0, -0.15, (-5.0, 5.0)),
            Parameter::new("rotation", Quantity::Angle, 0.0, 0.05, (-3.2, 3.2)),
        ],
        apply: |truth, _, v| {
            truth.force_sensor.loaded_bias = [v[0], v[1]];
            truth.force_sensor.rotation = v[2];
            Ok(())
        },
    },
];

/// Of the catalogue, but of shapes and supports that have many numbers: the plant has a few of its own.
pub(super) const OF_SUPPORT_AND_TIP: &[EffectKind] = &[
    EffectKind {
        id: "support-points",
        about: "three feet bear a share of the weight, at a part of the way to the outline",
        in_catalogue: true,
        parameters: &[
            Parameter::new("share", Quantity::Number, 0.0, 1.0, (0.0, 1.0)),
            Parameter::free("reach", Quantity::Number, 0.8, (0.05, 0.98)),
            Parameter::free("direction", Quantity::Angle, 0.5, TURN),
        ],
        apply: |truth, _, v| {
            truth.pressure.feet = Feet { share: v[0], reach: v[1], direction: v[2] };
            Ok(())
        },
    },
    EffectKind {
        id: "pressure-map",
        about: "the rim bears a share of the weight beside what even pressure has there",
        in_catalogue: true,
        parameters: &[Parameter::new("rim_share", Quantity::Number, 0.0, 0.8, (0.0, 1.0))],
        apply: |truth, _, v| {
            truth.pressure.rim_share = v[0];
            Ok(())
        },
    },
    EffectKind {
        id: "vertex-contact",
        about: "the tip catches near every vertex",
        in_catalogue: true,
        parameters: &[Parameter::new("reach", Quantity::Length, 0.0, 0.006, (0.0, 0.03))],
        apply: |truth, _, v| {
            if v[0] > 0.0 {
                truth.wear.burr = Burr { n_vertices: ALL, friction: CAUGHT, reach: v[0] };
            }
            Ok(())
        },
    },
    EffectKind {
        id: "push-height",
        about: "the tip pushes above the table and moves the load forward",
        in_catalogue: true,
        parameters: &[Parameter::new("height", Quantity::Length, 0.0, 0.01, (0.0, 0.1))],
        apply: |truth, _, v| {
            truth.tip.height = v[0];
            if v[0] > 0.0 && truth.underside.stiffness == 0.0 {
                truth.underside.stiffness = STIFF;
            }
            Ok(())
        },
    },
];

/// Of the catalogue, and in no surprise: surprises stay what they were for their seeds.
pub(super) const OF_THE_TABLE: &[EffectKind] = &[EffectKind {
    id: "friction-field",
    about: "friction differs from place to place of the table, over decimetres",
    in_catalogue: true,
    parameters: &[
        Parameter::new("sd", Quantity::Number, 0.0, 0.15, (0.0, 1.0)),
        Parameter::free("longest", Quantity::Length, 0.3, (0.05, 2.0)),
    ],
    apply: |truth, _, v| {
        if v[0] > 0.0 {
            let (sd, longest) = (v[0], v[1]);
            let shortest = 0.5 * longest;
            truth.friction_map.texture = Texture { sd, longest, shortest, persistence: 0.6 };
        }
        Ok(())
    },
}];

/// More than any outline has vertices.
const ALL: usize = 1000;
/// Friction of the tip at a vertex, beside that of the sides: it sticks wherever it pushes.
const CAUGHT: f64 = 3.0;
/// Of a table under a flat bottom, in N/m.
const STIFF: f64 = 1e6;

/// Gives the design speeds up to a largest one.
fn hurry(design: &mut Design, largest: f64) -> Result<(), PlantError> {
    if matches!(design.layout, Layout::List(_) | Layout::Thesis) {
        let what = "inertia sets the speeds of a drawn design; a list or grid has its own";
        return Err(PlantError::Design { what: what.into() });
    }
    let slower = [0.02, 0.05, 0.1, 0.2, 0.4].into_iter().filter(|speed| *speed < largest);
    design.speeds = slower.chain([largest]).collect();
    Ok(())
}
