//! A map of the pressure under an object.

use crate::{
    Channel, Confounder, Effect, EffectInfo, Nuisance, Object, Off, Origin, Parameter, Role, Spot,
    Stage,
};

/// Pressure map: see [`EffectInfo`] for its physics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PressureMap;

/// A cell's share, typically large at the rim.
const fn cell(name: &'static str, typical: f64) -> Parameter {
    Parameter {
        name,
        unit: "1",
        meaning: "Share of the weight on a cell; rows are counted along y of the body, columns along x",
        off: Off::At(0.0),
        typical,
        range: (0.0, 1.0),
        role: Role::Cell,
    }
}

const RIM: f64 = 0.055;
const MIDDLE: f64 = 0.01;

const CELLS: [Parameter; 25] = [
    cell("row1_column1", RIM),
    cell("row1_column2", RIM),
    cell("row1_column3", RIM),
    cell("row1_column4", RIM),
    cell("row1_column5", RIM),
    cell("row2_column1", RIM),
    cell("row2_column2", MIDDLE),
    cell("row2_column3", MIDDLE),
    cell("row2_column4", MIDDLE),
    cell("row2_column5", RIM),
    cell("row3_column1", RIM),
    cell("row3_column2", MIDDLE),
    cell("row3_column3", MIDDLE),
    cell("row3_column4", MIDDLE),
    cell("row3_column5", RIM),
    cell("row4_column1", RIM),
    cell("row4_column2", MIDDLE),
    cell("row4_column3", MIDDLE),
    cell("row4_column4", MIDDLE),
    cell("row4_column5", RIM),
    cell("row5_column1", RIM),
    cell("row5_column2", RIM),
    cell("row5_column3", RIM),
    cell("row5_column4", RIM),
    cell("row5_column5", RIM),
];

static INFO: EffectInfo = EffectInfo {
    id: "pressure-map",
    title: "Map of the pressure",
    physics: "The weight rests on cells of a grid over the outline's bounding box, each with a share \
        of its own; what the shares leave is spread over the area as the model says. Every such \
        pressure has an exact and convex limit surface, which depends linearly on the shares.",
    equation: "w = Σ sₖ μs m g vₖ/|vₖ| at rₖ + (1 − Σ sₖ) of the area, rₖ the centroid of what of cell \
        k is within the outline; shares of more than 1 in all are in proportion.",
    source: "Goyal, Ruina & Papadopoulos (1991), Planar sliding with dry friction, part 1, Wear 143; \
        Lynch (1993), Estimating the friction parameters of pushed objects, IROS.",
    stages: &[Stage::Pressure],
    origin: Origin::Support,
    reaches: &[Channel::Motion, Channel::Force],
    parameters: &CELLS,
    confounders: &[Confounder {
        id: "support-points",
        when: "always: a map is what many points look like",
    }],
    nuisance: Nuisance::No,
    shown_by: &[],
};

impl Effect for PressureMap {
    fn info(&self) -> &EffectInfo {
        &INFO
    }

    fn spots(&self, values: &[f64], object: &Object, spots: &mut Vec<Spot>) {
        if values.iter().all(|share| *share == 0.0) {
            return;
        }
        let cells = object.cells().iter().zip(values);
        spots.extend(
            cells
                .filter(|(cell, share)| cell.share > 0.0 && **share > 0.0)
                .map(|(cell, share)| Spot { share: *share, ..*cell }),
        );
    }
}
