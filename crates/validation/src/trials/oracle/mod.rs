//! How large an effect has to be, from the simulator alone: no number of the tool is used.
//!
//! The same pushes are simulated with and without the effect, without noise. The differences of
//! all that is recorded of a push are whitened with the noise of sensors and pushes that the
//! simulator's settings state, and cleared of what other frictions and another spread of the
//! pressure would do, which every diagnosis leaves open.

mod information;
mod noise;
mod view;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use effects::by_id;
use plant::{
    GenerateSettings, Hidden, HiddenEffect, Layout, Sensors, SimulatedPush, effect_kinds, simulate,
};
use serde::{Deserialize, Serialize};

use self::information::{Information, Signature, noncentrality};
use self::noise::Noise;
use self::view::View;
use super::case::{Asked, Sessions, Setup, Size};

/// Sizes of effects by setup, kept in a file.
#[derive(Debug, Default)]
pub(super) struct Oracle {
    path: PathBuf,
    setups: BTreeMap<String, SetupSizes>,
}

/// What the oracle found with one setup.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct SetupSizes {
    pub(super) setup: Setup,
    /// Root mean square of whitened differences of a re-simulation with noise alone: 1 if the
    /// noise is understood.
    pub(super) whitened_rms: f64,
    pub(super) effects: BTreeMap<String, Sizes>,
    /// Correlations of pairs beyond the nuisances.
    pub(super) correlations: Vec<(String, String, f64)>,
    /// Share of an effect's signature that each documented look-alike leaves.
    left_by: BTreeMap<String, BTreeMap<String, f64>>,
}

/// Sizes of an effect, as shares of its typical departure from "off".
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Sizes {
    /// Found with probability 0.9 in a test at 0.01/23.
    pub(super) detectable: f64,
    /// Changes a number of a step by 0.3 of its noise.
    pub(super) visible: f64,
    /// Twice what a manifest leaves open.
    pub(super) tolerated: f64,
}

impl Sizes {
    /// The size from which the effect may be named: detectable, visible and not tolerated.
    pub(super) fn nameable(&self) -> f64 {
        self.detectable
            .max(self.visible)
            .max(self.tolerated + 2.0 * self.detectable / NOT_CENTRAL[0])
    }
}

impl Sizes {
    /// Change of a number of a step over its noise, at the typical size.
    pub(super) fn visibility(&self) -> f64 {
        VISIBLE / self.visible
    }
}

/// Noncentrality √δ for a power of 0.9 at 0.01/23, by degrees of freedom.
const NOT_CENTRAL: [f64; 3] = [4.80, 5.10, 5.32];
/// Distance in standard deviations at which one of two is taken for the other once in twenty.
const TOLD_APART: f64 = 3.29;
/// Difference of predictions over the noise from which an effect may be named.
const VISIBLE: f64 = 0.3;
/// Share of the typical size of first differences.
const FIRST_SHARE: f64 = 0.2;
const SHARES: (f64, f64) = (0.02, 1.0);
/// A size tells of one that is at most so many times smaller.
const AS_LARGE: f64 = 1.3;
/// Sizes that are tried between one that may be named and one that may not.
const HALVINGS: usize = 8;
/// Three quarters of the pushes are fitted.
const FITTED: f64 = 0.75;
const SEED: u64 = 2_026;
/// Correlation below which effects are unlike.
const UNLIKE: f64 = 0.4;
/// How many of them are tried.
const MOST_UNLIKE: usize = 3;
/// No set of pushes of one design shows it: it is a matter of the pushes' speeds.
pub(super) const OF_THE_PUSHES: &str = "inertia";

impl Oracle {
    /// The sizes known in a file; none if there is no file.
    ///
    /// # Errors
    /// A file that is not of this version.
    pub(super) fn open(path: &Path) -> Result<Self> {
        let setups = match fs::read_to_string(path) {
            Ok(text) => serde_json::from_str(&text)
                .with_context(|| format!("{} is of another version; remove it", path.display()))?,
            Err(_) => BTreeMap::new(),
        };
        Ok(Self { path: path.to_owned(), setups })
    }

    /// Finds the sizes of every effect with a setup, unless they are known.
    ///
    /// # Errors
    /// A push that cannot be simulated; a file that cannot be written.
    pub(super) fn prepare(&mut self, setup: &Setup) -> Result<()> {
        let key = key(setup);
        if self.setups.contains_key(&key) {
            return Ok(());
        }
        eprintln!("oracle: {key}");
        self.setups.insert(key, SetupSizes::of(setup)?);
        let text = serde_json::to_string_pretty(&self.setups)? + "\n";
        Ok(output::write(&self.path, text)?)
    }

    /// By what is pushed and measured, in words.
    pub(super) fn setups(&self) -> impl Iterator<Item = (&String, &SetupSizes)> {
        self.setups.iter()
    }

    /// Whether a setup was prepared.
    pub(super) fn knows(&self, setup: &Setup) -> bool {
        self.setups.contains_key(&key(setup))
    }

    pub(super) fn sizes(&self, id: &str, setup: &Setup) -> Result<&Sizes> {
        let known = self.setups.get(&key(setup)).and_then(|found| found.effects.get(id));
        known.with_context(|| format!("the oracle knows no size of {id} with {}", key(setup)))
    }

    /// An effect's size as a share of its typical departure from "off".
    ///
    /// # Errors
    /// An effect without a known size.
    pub(super) fn share(&self, asked: &Asked, setup: &Setup) -> Result<f64> {
        match asked.size {
            Size::Typical(share) => Ok(share),
            Size::Nameable(times) => Ok(times * self.sizes(asked.id, setup)?.nameable()),
        }
    }

    /// Documented look-alikes that leave so little of an effect that the likelier of the two is the wrong one
    /// more often than once in twenty.
    ///
    /// # Errors
    /// An effect without a known size.
    pub(super) fn alike(&self, asked: &Asked, setup: &Setup) -> Result<Vec<String>> {
        let share = self.share(asked, setup)?;
        let sds = share * noncentrality(asked.id) / self.sizes(asked.id, setup)?.detectable;
        let known = self.setups.get(&key(setup)).and_then(|found| found.left_by.get(asked.id));
        let alike = known.into_iter().flatten().filter(|(_, left)| sds * **left < TOLD_APART);
        Ok(alike.map(|(other, _)| other.clone()).collect())
    }

    /// A few effects that do something else than the one asked for.
    ///
    /// # Errors
    /// An effect without a known size.
    pub(super) fn unlike(&self, asked: &Asked, setup: &Setup) -> Result<Vec<&str>> {
        let found = self.setups.get(&key(setup)).context("the setup is not known")?;
        let others = found.correlations.iter().filter_map(|(one, other, correlation)| {
            let other = match (one == asked.id, other == asked.id) {
                (true, _) => other,
                (_, true) => one,
                _ => return None,
            };
            let is_known = effects::by_id(other).is_ok() && !NUISANCES.contains(&other.as_str());
            (is_known && correlation.abs() < UNLIKE).then_some(other.as_str())
        });
        let others: Vec<&str> = others.collect();
        let stride = others.len().div_ceil(MOST_UNLIKE).max(1);
        Ok(others.into_iter().step_by(stride).collect())
    }
}

/// What every diagnosis leaves open.
const NUISANCES: [&str; 3] = ["support-friction", "pusher-friction", "pressure-radius"];

fn key(setup: &Setup) -> String {
    let pushes = format!("{:?}", setup.pushes).to_lowercase();
    let force = if setup.has_force { "with" } else { "without" };
    let sessions = match setup.sessions {
        Sessions::Alike => "",
        Sessions::One => ", of one session that differs",
        Sessions::Fifteen => ", of fifteen sessions that differ",
    };
    format!("{} {pushes} pushes {force} force{sessions}", setup.n_pushes)
}

/// Pushes of a setup without noise, and the noise that a recording would have.
struct Bench {
    rig: GenerateSettings,
    pushes: Vec<SimulatedPush>,
    views: Vec<View>,
    noise: Noise,
}

impl Bench {
    fn of(setup: &Setup) -> Result<Self> {
        let noisy = setup.rig(SEED);
        let drawn = GenerateSettings {
            scatter: plant::Scatter::NONE,
            sensors: ideal(setup),
            ..noisy.clone()
        };
        let plan = simulate(&drawn)?.into_iter().map(|push| push.plan).collect();
        let design =
            plant::Design { layout: Layout::List(plan), n_pushes: 0, ..drawn.design.clone() };
        let rig = GenerateSettings { design, ..drawn };
        let pushes = simulate(&rig)?;
        let views: Vec<View> = pushes.iter().map(|push| View::of(push, &rig)).collect();
        ensure!(views.iter().any(|view| !view.is_empty()), "no push of the setup stays in contact");
        let noise = Noise::of(&rig, &noisy, &pushes, &views)?;
        Ok(Self { rig, pushes, views, noise })
    }

    /// The change of all numbers with an effect at a share of its typical size, over the share.
    fn signature(&self, asked: &Asked, share: f64) -> Result<Signature> {
        self.signature_of(asked.hidden(share)?, share)
    }

    fn signature_of(&self, effect: HiddenEffect, share: f64) -> Result<Signature> {
        let mut rig = self.rig.clone();
        rig.hidden.push(Hidden::Effect(effect));
        let changed = simulate(&rig)?;
        let pairs = self.views.iter().zip(self.pushes.iter().zip(&changed));
        Ok(Signature(pairs.map(|(view, (off, on))| view.difference(off, on, share)).collect()))
    }

    /// What is seen of an effect about the smallest size that may be named.
    ///
    /// Secants over the size itself, for sticking and sliding have an edge between them, and a corner whose
    /// rounding ends before anything is read shows nothing: how large a size has to be follows from one as large.
    fn smallest(&self, asked: &Asked, share: f64) -> Result<Seen> {
        let mut seen = self.seen(asked, share)?;
        let mut too_small = 0.0_f64;
        for _ in 0..HALVINGS {
            let told = seen.sizes.nameable().max(too_small).max(SHARES.0);
            if seen.share <= AS_LARGE * told {
                break;
            }
            let smaller = self.seen(asked, (told * seen.share).sqrt())?;
            match smaller.sizes.nameable() <= smaller.share {
                true => seen = smaller,
                false => too_small = smaller.share,
            }
        }
        seen.sizes.detectable = seen.sizes.detectable.max(too_small);
        Ok(seen)
    }

    fn seen(&self, asked: &Asked, share: f64) -> Result<Seen> {
        let information = Information::of(self, &self.signature(asked, share)?, asked.id);
        let sizes = Sizes {
            detectable: information.detectable(asked.id),
            visible: VISIBLE / information.visibility(self),
            tolerated: tolerated(asked.id),
        };
        Ok(Seen { share, sizes, information })
    }

    /// What is seen of an effect in each of its directions alone.
    fn in_each_direction(&self, id: &'static str, share: f64) -> Result<Vec<Information>> {
        let directions = Asked::in_each_direction(id, share)?.into_iter();
        let seen = |effect| Ok(Information::of(self, &self.signature_of(effect, share)?, id));
        directions.map(seen).collect()
    }
}

/// What is seen of an effect at a share of its typical size.
struct Seen {
    share: f64,
    sizes: Sizes,
    information: Information,
}

/// Whether one of two effects is documented to look like the other.
fn are_documented(one: &str, other: &str) -> bool {
    let says = |one: &str, other: &str| {
        by_id(one).is_ok_and(|effect| effect.info().confounders.iter().any(|one| one.id == other))
    };
    says(one, other) || says(other, one)
}

/// Sensors without noise, and those that are there.
fn ideal(setup: &Setup) -> Sensors {
    let mut sensors = Sensors::ideal();
    if !setup.has_force {
        sensors.force.rate = 0.0;
    }
    sensors
}

impl SetupSizes {
    fn of(setup: &Setup) -> Result<Self> {
        let bench = Bench::of(setup)?;
        let (mut sizes, mut signatures) = (BTreeMap::new(), Vec::new());
        let mut directions = BTreeMap::new();
        for kind in effect_kinds().into_iter().filter(|kind| kind.id != OF_THE_PUSHES) {
            let asked = Asked::typical(kind.id);
            let first = Information::of(&bench, &bench.signature(&asked, FIRST_SHARE)?, kind.id);
            let share = first.detectable(kind.id).clamp(SHARES.0, SHARES.1);
            let Ok(found) = bench.smallest(&asked, share) else { continue };
            let Seen { share, sizes: own, information } = found;
            sizes.insert(kind.id.to_owned(), own);
            signatures.push((kind.id.to_owned(), information));
            if by_id(kind.id).is_ok() {
                directions.insert(kind.id, bench.in_each_direction(kind.id, share)?);
            }
        }
        let mut correlations = Vec::new();
        for (k, (one, first)) in signatures.iter().enumerate() {
            for (other, second) in &signatures[k + 1..] {
                correlations.push((one.clone(), other.clone(), first.correlation(second)));
            }
        }
        let left_by = |(id, found): &(String, Information)| {
            let others = directions.iter().filter(|(other, _)| are_documented(id, other));
            let left = others.map(|(other, of)| ((*other).to_owned(), found.left_by(of)));
            (id.clone(), left.collect())
        };
        let left_by = signatures.iter().map(left_by).collect();
        let whitened_rms = bench.noise.check(&bench.pushes, &bench.views)?;
        Ok(Self { setup: *setup, whitened_rms, effects: sizes, correlations, left_by })
    }
}

/// Twice what a manifest leaves open of an effect, as a share of its typical size.
fn tolerated(id: &str) -> f64 {
    let (tolerance, typical) = match id {
        "pusher-radius" => (1e-4, 1e-3),
        "pose-offset" => (1e-4, 2e-3),
        "yaw-offset" => (0.2_f64.to_radians(), 0.025),
        "stream-latency" => (2e-3, 0.015),
        "pusher-compliance" => (2e-5, 2.8e-4),
        "support-friction" => (0.03 * 0.25, 0.07),
        "pusher-friction" => (0.03 * 0.25, 0.15),
        "pressure-radius" => (0.01, 0.15),
        _ => return 0.0,
    };
    2.0 * tolerance / typical
}

#[cfg(test)]
mod tests {
    use super::super::case::{Asked, Sessions, Setup};
    use super::information::Information;
    use super::{AS_LARGE, Bench, Sizes};

    #[test]
    fn a_corner_whose_rounding_ends_before_anything_is_read_is_not_nameable() {
        let bench = Bench::of(&Setup { n_pushes: 48, ..Setup::RICH }).unwrap();
        let seen = bench.smallest(&Asked::typical("edge-rounding"), 1.0).unwrap();
        // The simulator's are of 5 mm, and within 1.5 mm of a vertex nothing is read.
        let radius = 5.0 * seen.sizes.nameable();
        assert!((1.5 / AS_LARGE..=5.0).contains(&radius), "{radius} mm");
    }

    #[test]
    fn noise_simulated_again_is_white_and_sizes_fall_with_information() {
        let setup = Setup { n_pushes: 16, ..Setup::RICH };
        let bench = Bench::of(&setup).unwrap();
        let rms = bench.noise.check(&bench.pushes, &bench.views).unwrap();
        // About 700 numbers, some of them of pushes at the edge of sliding.
        assert!((0.85..1.25).contains(&rms), "{rms}");
        let found = |id: &'static str| {
            let signature = bench.signature(&Asked::typical(id), 0.05).unwrap();
            Information::of(&bench, &signature, id)
        };
        let (tilt, gradient) = (found("table-tilt"), found("friction-gradient"));
        assert!((tilt.correlation(&tilt) - 1.0).abs() < 1e-9);
        assert!(tilt.correlation(&gradient).abs() < 1.0);
        // A look-alike leaves nothing of itself.
        let left = |id| tilt.left_by(&bench.in_each_direction(id, 0.05).unwrap());
        assert!(left("table-tilt") < 0.1 && left("friction-gradient") > 0.3);
        // What every diagnosis leaves open is no evidence for anything but itself.
        let signature = bench.signature(&Asked::typical("support-friction"), 0.05).unwrap();
        let itself = Information::of(&bench, &signature, "support-friction");
        let cleared = Information::of(&bench, &signature, "table-tilt");
        let [itself, cleared] = [itself, cleared].map(|found| found.detectable("support-friction"));
        assert!(itself < 0.2 && cleared > 20.0 * itself, "{itself} {cleared}");
    }

    #[test]
    fn what_a_session_shares_hides_what_it_may_be_and_nothing_else() {
        let detectable = |sessions: Sessions| {
            let bench = Bench::of(&Setup { n_pushes: 12, sessions, ..Setup::RICH }).unwrap();
            let rms = bench.noise.check(&bench.pushes, &bench.views).unwrap();
            assert!((0.8..1.3).contains(&rms), "{rms}");
            ["friction-center-offset", "table-anisotropy"].map(|id| {
                let signature = bench.signature(&Asked::typical(id), 0.05).unwrap();
                Information::of(&bench, &signature, id).detectable(id)
            })
        };
        let [one, alike] = [Sessions::One, Sessions::Alike].map(detectable);
        assert!(one[0] > 1.3 * alike[0] && one[1] < 1.15 * alike[1], "{one:?} {alike:?}");
    }

    #[test]
    fn an_effect_is_nameable_from_the_largest_of_its_sizes() {
        let sizes = Sizes { detectable: 0.1, visible: 0.3, tolerated: 0.0 };
        assert_eq!((sizes.nameable(), sizes.visibility()), (0.3, 1.0));
        assert!(Sizes { tolerated: 0.4, ..sizes }.nameable() > 0.4);
    }
}
