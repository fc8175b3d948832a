//! Pressure nearer to the rim or to the middle.

use crate::{
    Channel, Confounder, Effect, EffectInfo, Nuisance, Off, Origin, Parameter, Role, Snapshot,
    Stage, StepInput, Support,
};

/// Pressure radius: see [`EffectInfo`] for its physics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PressureRadius;

static INFO: EffectInfo = EffectInfo {
    id: "pressure-radius",
    title: "Pressure radius",
    physics: "Pressure that sits at the rim resists turning more than uniform pressure, pressure \
        in the middle less. The characteristic length c, the largest moment over the largest \
        force, grows or shrinks; the surface keeps its kind.",
    equation: "c = ratio · c₀, with c₀ the mean distance of the area from its centroid, in m; ratio is \
        at most (distance of the outline's farthest point)/c₀, 1.848 for a square.",
    source: "Mason (1986), Mechanics and planning of manipulator pushing operations, Int. J. \
        Robotics Research 5(3); Lee & Cutkosky (1991), Fixture planning with friction.",
    stages: &[Stage::Support],
    origin: Origin::Support,
    reaches: &[Channel::Motion, Channel::Force],
    parameters: &[Parameter {
        name: "ratio",
        unit: "1",
        meaning: "Characteristic length over that of uniform pressure",
        off: Off::At(1.0),
        typical: 0.92,
        range: (0.01, 4.0),
        role: Role::Even,
    }],
    confounders: &[Confounder {
        id: "limit-surface-shape",
        when: "where all pushes turn alike; an ellipsoid fitted to the exact surface has a c that \
            is 9 to 14 % too small",
    }],
    nuisance: Nuisance::Free { nominal_within: 0.01 },
    shown_by: &[],
};

impl Effect for PressureRadius {
    fn info(&self) -> &EffectInfo {
        &INFO
    }

    /// At most all weight at the outline's farthest point.
    fn range_in(&self, parameter: usize, step: &StepInput) -> (f64, f64) {
        let (low, high) = self.info().parameters[parameter].range;
        (low, high.min(step.object.farthest_distance() / step.object.mean_distance()))
    }

    fn support(&self, values: &[f64], _: &Snapshot<'_>, support: &mut Support) {
        support.length_ratio *= values[0];
    }
}
