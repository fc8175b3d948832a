//! Corners that are round.

use crate::{
    Channel, Effect, EffectInfo, Geometry, Nuisance, Off, Origin, Parameter, Role, Stage, StepInput,
};

/// Rounded corners: see [`EffectInfo`] for its physics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EdgeRounding;

static INFO: EffectInfo = EffectInfo {
    id: "edge-rounding",
    title: "Rounded corners",
    physics: "Corners of real objects are round. Near them the contact normal turns before the \
        corner of the drawing is reached, and the outline lies inside the drawing, which shows in \
        the gap. Smooth outlines have no corners and do not change.",
    equation: "outline = (polygon moved inwards by ρ) ⊕ disc of radius ρ, in m.",
    source: "de Berg, Cheong, van Kreveld & Overmars (2008), Computational Geometry, chapter 13, \
        for Minkowski sums.",
    stages: &[Stage::Geometry],
    origin: Origin::Contact,
    reaches: &[Channel::Motion, Channel::Force, Channel::Gap],
    parameters: &[Parameter {
        name: "radius",
        unit: "m",
        meaning: "Radius of the corners",
        off: Off::At(0.0),
        typical: 3e-3,
        range: (0.0, 0.02),
        role: Role::Even,
    }],
    confounders: &[],
    nuisance: Nuisance::No,
    shown_by: &["pushes at the corners"],
};

impl Effect for EdgeRounding {
    fn info(&self) -> &EffectInfo {
        &INFO
    }

    fn geometry(&self, values: &[f64], _: &StepInput, geometry: &mut Geometry) {
        geometry.corner_radius += values[0];
    }
}
