//! Friction that grows with the logarithm of speed.

use crate::elementary::ln_1p_each;
use crate::{
    Channel, Confounder, Effect, EffectInfo, LocalFriction, Nuisance, Off, Origin, Parameter, Role,
    Sliding, SlidingPoints, Stage,
};

/// Friction that depends on speed: see [`EffectInfo`] for its physics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RateDependentFriction;

static INFO: EffectInfo = EffectInfo {
    id: "rate-dependent-friction",
    title: "Friction that depends on speed",
    physics: "Many dry contacts resist more, or less, the faster they slide. Every point of the \
        support has its own speed, so that the outer points of a turning object weigh more or \
        less than the inner ones: the force grows with speed, the motion changes weakly.",
    equation: "μ(v) = μ (1 + k ln(1 + v/v₀)), with v the speed of a support point over the table, \
        in m/s.",
    source: "Dieterich (1979), Modeling of rock friction: 1, J. Geophysical Research 84(B5); \
        Ruina (1983), Slip instability and state variable friction laws, J. Geophysical Research \
        88(B12).",
    stages: &[Stage::Local],
    origin: Origin::Dynamics,
    reaches: &[Channel::Motion, Channel::Force],
    parameters: &[
        Parameter {
            name: "k",
            unit: "1",
            meaning: "Relative growth of friction for each e-fold of speed",
            off: Off::At(0.0),
            typical: 0.1,
            range: (-0.1, 0.5),
            role: Role::Even,
        },
        Parameter {
            name: "v0",
            unit: "m/s",
            meaning: "Speed at which the growth sets in",
            off: Off::Undefined,
            typical: 0.02,
            range: (1e-3, 1.0),
            role: Role::Even,
        },
    ],
    confounders: &[
        Confounder { id: "limit-surface-shape", when: "at one speed" },
        Confounder { id: "support-stiction", when: "unless speeds span the Stribeck velocity" },
    ],
    nuisance: Nuisance::No,
    shown_by: &[],
};

impl Effect for RateDependentFriction {
    fn info(&self) -> &EffectInfo {
        &INFO
    }

    fn local_friction(&self, values: &[f64], sliding: &Sliding) -> f64 {
        values[0] * (sliding.velocity_w.norm() / values[1]).ln_1p()
    }

    fn local_growth(&self, values: &[f64], sliding: &Sliding, _: f64) -> f64 {
        let speed = sliding.velocity_w.norm();
        values[0] * speed / (speed + values[1])
    }

    fn add_local_friction(
        &self,
        values: &[f64],
        points: &SlidingPoints,
        found: &mut LocalFriction,
    ) {
        let mut logarithms = [0.0; SlidingPoints::MOST];
        let squares = points.squared_speeds();
        let logarithms = &mut logarithms[..squares.len()];
        let ratio = |square: &f64| square.sqrt() / values[1];
        logarithms.iter_mut().zip(squares).for_each(|(of, square)| *of = ratio(square));
        ln_1p_each(logarithms);
        for (k, (square, logarithm)) in squares.iter().zip(logarithms).enumerate() {
            found.surplus[k] += values[0] * *logarithm;
            found.growth[k] += values[0] * ratio(square) / (1.0 + ratio(square));
        }
    }
}
