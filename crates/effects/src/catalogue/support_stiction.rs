//! Friction with the table that is larger at low speed.

use crate::elementary::exp_each;
use crate::{
    Channel, Confounder, Effect, EffectInfo, LocalFriction, Nuisance, Off, Origin, Parameter, Role,
    Sliding, SlidingPoints, Stage,
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

    fn add_local_friction(
        &self,
        values: &[f64],
        points: &SlidingPoints,
        found: &mut LocalFriction,
    ) {
        let mut fades = [0.0; SlidingPoints::MOST];
        let squares = points.squared_speeds();
        let fades = &mut fades[..squares.len()];
        let (more, fade) = (values[0] - 1.0, -values[1].powi(2).recip());
        fades.iter_mut().zip(squares).for_each(|(exponent, square)| *exponent = fade * square);
        exp_each(fades);
        for (k, (square, fade_there)) in squares.iter().zip(fades).enumerate() {
            let surplus = more * *fade_there;
            found.surplus[k] += surplus;
            found.growth[k] += 2.0 * fade * square * surplus;
        }
    }
}
