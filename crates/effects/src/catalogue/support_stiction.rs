//! Friction with the table that is larger at low speed.

use crate::{
    Channel, Confounder, Effect, EffectInfo, Nuisance, Off, Origin, Parameter, Role, Sliding, Stage,
};

/// Stiction of the support: see [`EffectInfo`] for its physics.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SupportStiction;

static INFO: EffectInfo = EffectInfo {
    id: "support-stiction",
    title: "Stiction of the support",
    physics: "A resting contact holds more than a sliding one, and the difference fades as it \
        gets faster. The force is larger at the start and at low speed; points near the center of \
        rotation, which are slow, weigh more.",
    equation: "μ(v) = μ (1 + (b − 1) exp(−v²/vs²)), with b the breakaway ratio and vs the Stribeck \
        velocity, in m/s.",
    source: "Canudas de Wit, Olsson, Åström & Lischinsky (1995), A new model for control of systems \
        with friction, IEEE Trans. Automatic Control 40(3); Armstrong-Hélouvry, Dupont & Canudas de \
        Wit (1994), Automatica 30(7).",
    stages: &[Stage::Local],
    origin: Origin::Dynamics,
    reaches: &[Channel::Motion, Channel::Force],
    parameters: &[
        Parameter {
            name: "breakaway",
            unit: "1",
            meaning: "Friction at rest over friction at speed",
            off: Off::At(1.0),
            typical: 1.3,
            range: (1.0, 2.0),
            role: Role::Even,
        },
        Parameter {
            name: "stribeck_velocity",
            unit: "m/s",
            meaning: "Speed over which the difference fades",
            off: Off::Undefined,
            typical: 0.02,
            range: (5e-3, 0.5),
            role: Role::Even,
        },
    ],
    confounders: &[Confounder {
        id: "rate-dependent-friction",
        when: "unless speeds span the Stribeck velocity",
    }],
    nuisance: Nuisance::No,
    shown_by: &[],
};

impl Effect for SupportStiction {
    fn info(&self) -> &EffectInfo {
        &INFO
    }

    fn local_friction(&self, values: &[f64], sliding: &Sliding) -> f64 {
        (values[0] - 1.0) * (-sliding.velocity_w.norm_squared() / values[1].powi(2)).exp()
    }

    fn local_growth(&self, values: &[f64], sliding: &Sliding, surplus: f64) -> f64 {
        -2.0 * sliding.velocity_w.norm_squared() / values[1].powi(2) * surplus
    }
}
