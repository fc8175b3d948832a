//! Effects that the catalogue of missing effects does not have.

use std::f64::consts::PI;

use super::{EffectKind, Parameter, Quantity};
use crate::truth::{Cable, Groove, Hysteresis, Magnet, Spot, Wobble};

const TURN: (f64, f64) = (-2.0 * PI, 2.0 * PI);
const TABLE: (f64, f64) = (-1.0, 1.0);

/// In order of their names.
pub(super) const KINDS: &[EffectKind] = &[
    EffectKind {
        id: "cable-drag",
        about: "a cable at the object pulls toward an anchor over the table",
        in_catalogue: false,
        parameters: &[
            Parameter::new("tension", Quantity::Force, 0.0, 0.35, (0.0, 5.0)),
            Parameter::new("stiffness", Quantity::Stiffness, 0.0, 1.0, (0.0, 100.0)),
            Parameter::free("anchor_x", Quantity::Length, 0.3, (-5.0, 5.0)),
            Parameter::free("anchor_y", Quantity::Length, 0.4, (-5.0, 5.0)),
            Parameter::free("attachment_x", Quantity::Length, 0.03, (-0.2, 0.2)),
            Parameter::free("attachment_y", Quantity::Length, 0.03, (-0.2, 0.2)),
        ],
        apply: |truth, _, v| {
            truth.cable = Cable {
                tension: v[0],
                stiffness: v[1],
                anchor: [v[2], v[3]],
                attachment: [v[4], v[5]],
            };
            Ok(())
        },
    },
    EffectKind {
        id: "chipped-corner",
        about: "a corner of the object is broken off",
        in_catalogue: false,
        parameters: &[
            Parameter::new("size", Quantity::Length, 0.0, 0.012, (0.0, 0.05)),
            Parameter::free("vertex", Quantity::Index, 0.0, (0.0, 500.0)),
        ],
        apply: |truth, _, v| {
            truth.wear.chip_size = v[0];
            truth.wear.chip_vertex = v[1] as usize;
            Ok(())
        },
    },
    EffectKind {
        id: "flexing-tip",
        about: "the tip bends, and a part of it slips inside and remembers",
        in_catalogue: false,
        parameters: &[
            Parameter::new("compliance", Quantity::Compliance, 2e-5, 8e-4, (1e-6, 5e-3)),
            Parameter::new("stiffness", Quantity::Stiffness, 0.0, 3000.0, (0.0, 1e5)),
            Parameter::free("yield", Quantity::Force, 0.8, (0.01, 20.0)),
        ],
        apply: |truth, _, v| {
            truth.tip.compliance = v[0];
            truth.tip.hysteresis = Hysteresis { stiffness: v[1], yield_force: v[2] };
            Ok(())
        },
    },
    EffectKind {
        id: "liquid-film",
        about: "a film of liquid lets friction fall at one speed and come back beyond it",
        in_catalogue: false,
        parameters: &[
            Parameter::new("dip", Quantity::Number, 0.0, 0.4, (-0.9, 0.9)),
            Parameter::free("speed", Quantity::Speed, 0.015, (1e-3, 1.0)),
        ],
        apply: |truth, _, v| {
            let rate = &mut truth.support_friction.rate;
            (rate.film_dip, rate.film_speed) = (v[0], v[1]);
            Ok(())
        },
    },
    EffectKind {
        id: "magnet",
        about: "a magnet under the table pulls the object down and toward itself",
        in_catalogue: false,
        parameters: &[
            Parameter::new("pull", Quantity::Force, 0.0, 5.0, (0.0, 50.0)),
            Parameter::free("reach", Quantity::Length, 0.04, (0.01, 1.0)),
            Parameter::free("x", Quantity::Length, 0.03, TABLE),
            Parameter::free("y", Quantity::Length, -0.02, TABLE),
        ],
        apply: |truth, _, v| {
            truth.magnet = Magnet { pull: v[0], reach: v[1], place: [v[2], v[3]] };
            Ok(())
        },
    },
    EffectKind {
        id: "sticky-spot",
        about: "a spot of the table rubs more",
        in_catalogue: false,
        parameters: &[
            Parameter::new("increase", Quantity::Number, 0.0, 2.0, (-0.95, 10.0)),
            Parameter::free("radius", Quantity::Length, 0.03, (0.003, 1.0)),
            Parameter::free("x", Quantity::Length, 0.03, TABLE),
            Parameter::free("y", Quantity::Length, -0.02, TABLE),
        ],
        apply: |truth, _, v| {
            truth.friction_map.spot = Spot { increase: v[0], radius: v[1], center: [v[2], v[3]] };
            Ok(())
        },
    },
    EffectKind {
        id: "wobbling-foot",
        about: "the object rocks: the push decides which side carries more of the load",
        in_catalogue: false,
        parameters: &[
            Parameter::new("share", Quantity::Number, 0.0, 0.6, (0.0, 0.9)),
            Parameter::free("direction", Quantity::Angle, 0.6, TURN),
            Parameter::free("force", Quantity::Force, 0.3, (0.01, 10.0)),
        ],
        apply: |truth, _, v| {
            truth.wobble = Wobble { share: v[0], direction: v[1], force: v[2] };
            Ok(())
        },
    },
    EffectKind {
        id: "worn-groove",
        about: "a polished groove in the table guides what rests on it",
        in_catalogue: false,
        parameters: &[
            Parameter::new("polish", Quantity::Number, 0.0, 0.6, (0.0, 1.0)),
            Parameter::new("depth", Quantity::Length, 0.0, 3e-4, (0.0, 0.005)),
            Parameter::free("width", Quantity::Length, 0.015, (0.001, 0.3)),
            Parameter::free("direction", Quantity::Angle, 0.4, TURN),
            Parameter::free("x", Quantity::Length, 0.0, TABLE),
            Parameter::free("y", Quantity::Length, 0.0, TABLE),
        ],
        apply: |truth, _, v| {
            truth.height_map.groove = Groove {
                polish: v[0],
                depth: v[1],
                width: v[2],
                direction: v[3],
                point: [v[4], v[5]],
            };
            Ok(())
        },
    },
];
