//! Weight that rests on a few points.

use nalgebra::Vector2;

use crate::{
    Channel, Confounder, Effect, EffectInfo, Frame, Nuisance, Object, Off, Origin, Parameter, Role,
    Spot, Stage,
};

/// Support points: see [`EffectInfo`] for their physics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SupportPoints;

/// A point's three parameters, typically on a hexagon.
const fn point(names: [&'static str; 3], (x, y): (f64, f64)) -> [Parameter; 3] {
    let [name_x, name_y, name_share] = names;
    [
        Parameter {
            name: name_x,
            unit: "m",
            meaning: "Along x of the body",
            off: Off::At(0.0),
            typical: x,
            range: (-0.5, 0.5),
            role: Role::X(Frame::Body),
        },
        Parameter {
            name: name_y,
            unit: "m",
            meaning: "Along y of the body",
            off: Off::At(0.0),
            typical: y,
            range: (-0.5, 0.5),
            role: Role::Y(Frame::Body),
        },
        Parameter {
            name: name_share,
            unit: "1",
            meaning: "Share of the weight; 0 for a point that is not there",
            off: Off::At(0.0),
            typical: 0.15,
            range: (0.0, 1.0),
            role: Role::Part,
        },
    ]
}

const POINTS: [[Parameter; 3]; 6] = [
    point(["x1", "y1", "share1"], (0.032, 0.005)),
    point(["x2", "y2", "share2"], (0.012, 0.030)),
    point(["x3", "y3", "share3"], (-0.020, 0.025)),
    point(["x4", "y4", "share4"], (-0.032, -0.005)),
    point(["x5", "y5", "share5"], (-0.012, -0.030)),
    point(["x6", "y6", "share6"], (0.020, -0.025)),
];

/// Radius of gyration of a point's pressure over the area's mean distance: half a millimeter under an
/// object of a hand's width.
const RADIUS: f64 = 0.015;

static INFO: EffectInfo = EffectInfo {
    id: "support-points",
    title: "Weight on a few points",
    physics: "A rigid object stands on few points of a table that is nowhere quite flat. Each bears \
        its share of the weight, with Coulomb friction against its own sliding; what the shares leave \
        is spread over the area as the model says. Other places and shares can have nearly the same \
        limit surface: read from them the center of friction and the mean distance, and where the \
        pressure leans.",
    equation: "w = Σ sᵢ μs m g vᵢ/|vᵢ| at rᵢ + (1 − Σ sᵢ) of the area, vᵢ = v + ω J rᵢ; shares of more \
        than 1 in all are in proportion.",
    source: "Goyal, Ruina & Papadopoulos (1991), Planar sliding with dry friction, part 1, Wear 143.",
    stages: &[Stage::Pressure],
    origin: Origin::Support,
    reaches: &[Channel::Motion, Channel::Force],
    parameters: POINTS.as_flattened(),
    confounders: &[
        Confounder { id: "pressure-map", when: "always: points are one of its pressures" },
        Confounder { id: "pressure-radius", when: "where pushes do not show the surface's facets" },
        Confounder { id: "friction-center-offset", when: "where all pushes turn alike" },
    ],
    nuisance: Nuisance::No,
    shown_by: &[],
};

impl Effect for SupportPoints {
    fn info(&self) -> &EffectInfo {
        &INFO
    }

    fn spots(&self, values: &[f64], object: &Object, spots: &mut Vec<Spot>) {
        let bearing = values.chunks_exact(3).filter(|point| point[2] != 0.0);
        spots.extend(bearing.map(|point| Spot {
            place_o: Vector2::new(point[0], point[1]),
            share: point[2],
            radius: RADIUS * object.mean_distance(),
        }));
    }
}
