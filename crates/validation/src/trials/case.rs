//! One trial: what is hidden, how it is pushed, and what is asked.

use std::f64::consts::PI;

use anyhow::{Context, Result};
use models::SurfaceKind;
use plant::{
    Design, GenerateSettings, Hidden, HiddenEffect, Layout, PlannedPush, Profile, PushedObject,
    Scatter, Sensor, Sensors, effect_kinds,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use super::scattering::SCATTERING;
use super::variant::Variant;

/// A kind of trial, with rows of its own in the table of pass marks.
#[derive(
    Clone,
    Copy,
    Debug,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Hash,
    Serialize,
    Deserialize,
    clap::ValueEnum,
)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Family {
    /// Nothing hidden, and a base that is right
    Nothing,
    /// Nothing hidden, and the thesis' ellipsoid on a patch
    Ellipsoid,
    /// One effect, in multiples of its nameable size
    Single,
    /// One effect of a fixed, typical size
    Typical,
    /// Two effects of four times their nameable sizes
    Pair,
    /// An effect that no catalogue has
    Outside,
    /// One edge, one orientation, one speed
    Narrow,
    /// An effect that the sensors or pushes cannot show
    Untestable,
    /// A nominal friction of the pusher that is a fifth too small
    WrongNominal,
    /// The same set told otherwise
    Robust,
    /// Another effect than the hidden one, added by hand
    WrongEffect,
    /// Nothing hidden on a rig as rough as real ones
    Rough,
    /// One effect of a fixed, typical size on such a rig
    RoughTypical,
    /// One quantity that scatters from push to push
    Scattered,
    /// A support, a tip at vertices or a height of the push, by the simulator's own law
    Supports,
}

/// Which pushes are made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Pushes {
    /// Any place, angle and orientation, at 20 mm/s.
    Rich,
    /// The same at 10, 20 and 40 mm/s.
    Speeds,
    /// One edge, one orientation, one place, one speed.
    Narrow,
    /// Rich, but away from the corners.
    Central,
}

/// What is pushed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Outline {
    Square,
    Triangle,
    Ellipse,
    /// An L.
    Corner,
}

/// Measuring sessions, whose friction, pressure, contact and force zero differ half as much as those of pushes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Sessions {
    /// As if none differed.
    Alike,
    /// All pushes are of one that differs.
    One,
    /// Pushes one after the other are shared out among so many.
    Fifteen,
}

/// How the rig is set up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub(super) struct Setup {
    pub(super) pushes: Pushes,
    pub(super) n_pushes: usize,
    pub(super) has_force: bool,
    pub(super) outline: Outline,
    pub(super) rig: Rig,
    pub(super) sessions: Sessions,
}

/// A profile of the simulator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Rig {
    Quiet,
    Rough,
    Abs,
    Delrin,
    Plywood,
    Pu,
}

/// How large a hidden effect is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Size {
    /// So many typical sizes of the simulator.
    Typical(f64),
    /// So many of the smallest sizes that may be named, by the oracle.
    Nameable(f64),
}

/// An effect to hide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Asked {
    pub(super) id: &'static str,
    pub(super) size: Size,
    /// To the other side, where there are two.
    pub(super) is_mirrored: bool,
}

/// One trial.
#[derive(Clone, Debug)]
pub(super) struct Case {
    /// Unique, and the same in every run.
    pub(super) name: String,
    pub(super) family: Family,
    /// The effect that it is about; several are joined by +.
    pub(super) about: String,
    pub(super) seed: u64,
    /// Surface of the model under test.
    pub(super) surface: SurfaceKind,
    pub(super) setup: Setup,
    pub(super) hidden: Vec<Asked>,
    /// What else is asked of the same set.
    pub(super) variants: Vec<Variant>,
}

/// Reported trials use seeds from here on; those below are for development.
pub(super) const FIRST_REPORTED_SEED: u64 = 1_000_000;

/// Corners of an L, in m.
const CORNER: [[f64; 2]; 6] = [
    [-0.035, -0.035],
    [0.065, -0.035],
    [0.065, 0.005],
    [0.005, 0.005],
    [0.005, 0.065],
    [-0.035, 0.065],
];

const SPEEDS: [f64; 3] = [0.01, 0.02, 0.04];
const STEEPEST: f64 = 40.0 * PI / 180.0;
/// Steepest angle of narrow pushes, in rad: the object hardly slides along the tip.
const NARROWEST: f64 = 10.0 * PI / 180.0;
/// How far they go, in m: it hardly turns.
const SHORT: f64 = 0.015;

impl Outline {
    pub(super) const ALL: [Self; 4] = [Self::Square, Self::Triangle, Self::Ellipse, Self::Corner];

    fn object(self) -> PushedObject {
        let known = |name: &str| PushedObject::Mit { name: name.to_owned() };
        match self {
            Self::Square => known("rect1"),
            Self::Triangle => known("tri1"),
            Self::Ellipse => known("ellip1"),
            Self::Corner => PushedObject::Polygon { vertices: CORNER.to_vec(), mass: 0.6 },
        }
    }
}

impl Sessions {
    pub(super) const ALL: [Self; 3] = [Self::Alike, Self::One, Self::Fifteen];

    /// How sessions differ over how pushes do.
    pub(super) fn share(self) -> f64 {
        match self {
            Self::Alike => 0.0,
            Self::One | Self::Fifteen => 0.5,
        }
    }
}

impl Setup {
    pub(super) const RICH: Self = Self {
        pushes: Pushes::Rich,
        n_pushes: 120,
        has_force: true,
        outline: Outline::Square,
        rig: Rig::Quiet,
        sessions: Sessions::Alike,
    };

    /// The setup that shows an effect.
    pub(super) fn of(id: &str) -> Self {
        match id {
            "rate-dependent-friction"
            | "support-stiction"
            | "pusher-stiction"
            | "stream-latency"
            | "pusher-compliance"
            | "liquid-film"
            | "flexing-tip" => Self { pushes: Pushes::Speeds, ..Self::RICH },
            _ => Self::RICH,
        }
    }

    /// Its profile in the simulator.
    pub(super) fn profile(&self) -> &'static Profile {
        let name = match self.rig {
            Rig::Quiet => "quiet",
            Rig::Rough => "rough",
            Rig::Abs => "abs",
            Rig::Delrin => "delrin",
            Rig::Plywood => "plywood",
            Rig::Pu => "pu",
        };
        Profile::named(name).expect("every rig is a profile of the simulator")
    }

    /// A rig where nothing is hidden.
    pub(super) fn rig(&self, seed: u64) -> GenerateSettings {
        let layout = match self.pushes {
            Pushes::Rich | Pushes::Speeds => Layout::Rich,
            Pushes::Narrow => Layout::Narrow { edge: 0 },
            Pushes::Central => Layout::List(central(self.n_pushes, seed)),
        };
        let speeds = if self.pushes == Pushes::Speeds { SPEEDS.to_vec() } else { Vec::new() };
        let design = Design {
            layout,
            n_pushes: self.n_pushes,
            n_sessions: if self.sessions == Sessions::Fifteen { 15 } else { 1 },
            speeds,
            repeat_share: 0.25,
            n_repeated: 4,
            steepest: if self.pushes == Pushes::Narrow { NARROWEST } else { STEEPEST },
            travel: if self.pushes == Pushes::Narrow { SHORT } else { Design::default().travel },
            ..Design::default()
        };
        let profile = self.profile();
        let sensors = profile.sensors();
        let force =
            if self.has_force { sensors.force } else { Sensor { rate: 0.0, ..Sensor::default() } };
        GenerateSettings {
            name: "pushes of a trial".to_owned(),
            object: self.outline.object(),
            design,
            scatter: Scatter { session_share: self.sessions.share(), ..profile.scatter() },
            sensors: Sensors { force, ..sensors },
            format: "csv".to_owned(),
            seed,
            ..profile.settings()
        }
    }
}

/// Pushes of all edges and orientations at the middle fifth of the edges of a square; every fourth
/// one of four that are repeated.
fn central(n_pushes: usize, seed: u64) -> Vec<PlannedPush> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut draw = |repeat: String| PlannedPush {
        edge: random.random_range(0..4),
        p: random.random_range(0.4..0.6),
        angle: random.random_range(-STEEPEST..STEEPEST),
        speed: 0.02,
        travel: 0.03,
        place: [
            random.random_range(-0.1..0.1),
            random.random_range(-0.1..0.1),
            random.random_range(-PI..PI),
        ],
        session: 0,
        repeat,
    };
    let repeated: Vec<PlannedPush> = (0..4).map(|k| draw(format!("repeat-{k}"))).collect();
    let push = |k: usize| match k % 4 {
        0 => repeated[k / 4 % 4].clone(),
        _ => draw(String::new()),
    };
    (0..n_pushes).map(push).collect()
}

impl Asked {
    pub(super) fn typical(id: &'static str) -> Self {
        Self { id, size: Size::Typical(1.0), is_mirrored: false }
    }

    /// The effect at a share of its typical departure from "off".
    ///
    /// # Errors
    /// A value out of the effect's range.
    pub(super) fn hidden(&self, share: f64) -> Result<HiddenEffect> {
        let kind = effect_kinds().into_iter().find(|kind| kind.id == self.id);
        let kind = kind.with_context(|| format!("nothing hides {}", self.id))?;
        let mut effect = HiddenEffect::typical(self.id)?;
        for parameter in kind.parameters {
            let Some(off) = parameter.off else { continue };
            let has_sides = parameter.range.0 == -parameter.range.1;
            let side = if self.is_mirrored && has_sides { -1.0 } else { 1.0 };
            let value = off + side * share * (parameter.typical - off);
            effect = effect.with(parameter.name, value)?;
        }
        Ok(effect)
    }

    /// The effect at a share of its typical departure in each of its directions alone: each parameter by
    /// itself; a grain as it is typically and turned by an eighth.
    ///
    /// # Errors
    /// A value out of the effect's range.
    pub(super) fn in_each_direction(id: &'static str, share: f64) -> Result<Vec<HiddenEffect>> {
        const EIGHTH: f64 = PI / 4.0;
        let kind = effect_kinds().into_iter().find(|kind| kind.id == id);
        let kind = kind.with_context(|| format!("nothing hides {id}"))?;
        let sized = |one: &plant::Parameter| {
            one.off.filter(|off| *off != one.typical).map(|off| (one.name, off))
        };
        let sized: Vec<(&str, f64)> = kind.parameters.iter().filter_map(sized).collect();
        let typical = Self::typical(id).hidden(share)?;
        if let (1, Some(direction)) = (sized.len(), typical.values.get("direction")) {
            let turned = typical.clone().with("direction", direction + EIGHTH)?;
            return Ok(vec![typical, turned]);
        }
        let alone = |(name, _): &(&str, f64)| -> Result<HiddenEffect> {
            let mut others = sized.iter().filter(|(other, _)| other != name);
            let off = |effect: HiddenEffect, (other, off): &(&str, f64)| effect.with(other, *off);
            Ok(others.try_fold(typical.clone(), off)?)
        };
        sized.iter().map(alone).collect()
    }
}

impl Case {
    /// Whether every second push is kept from the diagnosis, to see what its model is worth on the
    /// same rig.
    pub(super) fn has_fresh_pushes(&self) -> bool {
        matches!(self.family, Family::Typical | Family::Rough | Family::RoughTypical)
    }

    /// Whether a size or a score of it comes from the oracle.
    pub(super) fn needs_oracle(&self) -> bool {
        let is_sized = |asked: &Asked| matches!(asked.size, Size::Nameable(_));
        let family = matches!(self.family, Family::WrongEffect | Family::Outside | Family::Narrow);
        family || self.hidden.iter().any(is_sized)
    }

    /// Times the nameable size of the first hidden effect; none for typical sizes.
    pub(super) fn multiple(&self) -> Option<f64> {
        self.hidden.first().and_then(|asked| match asked.size {
            Size::Nameable(times) => Some(times),
            Size::Typical(_) => None,
        })
    }

    /// The rig, with hidden effects at these shares of their typical sizes.
    ///
    /// # Errors
    /// A size out of an effect's range.
    pub(super) fn rig(&self, shares: &[f64]) -> Result<GenerateSettings> {
        let mut rig = self.setup.rig(self.seed);
        if self.has_fresh_pushes() {
            rig.design.n_pushes *= 2;
        }
        if self.family == Family::Scattered {
            let source = SCATTERING.iter().find(|source| source.name == self.about);
            let source = source.with_context(|| format!("nothing scatters {}", self.about))?;
            source.set(&mut rig.scatter);
        }
        for (asked, share) in self.hidden.iter().zip(shares) {
            rig.hidden.push(Hidden::Effect(asked.hidden(*share)?));
        }
        Ok(rig)
    }
}

#[cfg(test)]
mod tests {
    use super::{Asked, Size};

    #[test]
    fn a_share_scales_the_departure_and_a_mirror_turns_what_has_two_sides() {
        let asked = Asked { id: "table-tilt", size: Size::Nameable(2.0), is_mirrored: true };
        let hidden = asked.hidden(0.5).unwrap();
        assert_eq!((hidden.values["x"], hidden.values["y"]), (0.125, -0.1));
        let grain = Asked { id: "table-anisotropy", ..asked }.hidden(0.5).unwrap();
        assert!((grain.values["ratio"] - 1.15).abs() < 1e-12);
        assert_eq!(grain.values["direction"], 0.6);
        assert!(Asked { id: "limit-surface-shape", ..asked }.hidden(3.0).is_err());
    }

    #[test]
    fn directions_of_an_effect_are_its_parameters_and_a_grain_has_two() {
        let of = |id| Asked::in_each_direction(id, 0.5).unwrap();
        let [tilt, grain] = [of("table-tilt"), of("table-anisotropy")];
        let xy: Vec<[f64; 2]> = tilt.iter().map(|one| [one.values["x"], one.values["y"]]).collect();
        assert_eq!(xy, [[-0.125, 0.0], [0.0, 0.1]]);
        let turn = grain[1].values["direction"] - grain[0].values["direction"];
        assert!((turn - std::f64::consts::FRAC_PI_4).abs() < 1e-12);
        assert!(grain.iter().all(|one| (one.values["ratio"] - 1.15).abs() < 1e-12));
        assert_eq!(of("contact-bias").len(), 1);
    }
}
