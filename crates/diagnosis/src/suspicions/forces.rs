//! Whether the force is one that a pusher can press with.

use dataset::Manifest;
use nalgebra::{Matrix2, Vector2};
use planar::perpendicular;

use super::mistake::{View, axes};
use super::numbers::{quantile, share};
use super::{Scene, Suspicion};

/// Cosine of the steepest angle between force and normal that counts as possible: friction of 1.7.
const CONE: f64 = 0.5;
/// Of possible forces fewer are suspicious, and more are right.
const TOO_FEW: f64 = 0.5;
const ENOUGH: f64 = 0.85;
/// Slip that says which way friction acts, over the pusher's way.
const SLIPS: f64 = 0.5;
/// Tangential force that does, over the normal one.
const RUBS: f64 = 0.05;
/// Median force over μmg that no object has: perhaps, and for sure.
const ODD: (f64, f64) = (0.04, 15.0);
const IMPOSSIBLE: (f64, f64) = (0.01, 60.0);

/// What forces say, with their axes changed.
struct Reading {
    /// Share within a wide cone about the inward normal.
    possible: Option<f64>,
    /// Share whose tangential part goes with the slip, of those that slip.
    with_slip: Option<f64>,
    /// Share with which the pusher does work on the object.
    with_power: Option<f64>,
}

impl Reading {
    fn of(scene: &Scene, view: &View, axes: &Matrix2<f64>) -> Self {
        let seen = scene.seen.iter().filter_map(|(object, moment)| {
            let force = axes * moment.force?;
            let shape = &scene.objects[*object].shape;
            Some((force, view.seen(moment, shape, scene.radius)))
        });
        let seen: Vec<_> = seen.filter(|(force, _)| force.norm() > 0.0).collect();
        let along = |force: &Vector2<f64>, normal: &Vector2<f64>| force.dot(normal) / force.norm();
        let slipping = seen.iter().filter_map(|(force, seen)| {
            let tangential = force.dot(&perpendicular(&seen.normal));
            let tells =
                seen.slip.abs() > SLIPS * seen.way.norm() && tangential.abs() > RUBS * force.norm();
            tells.then_some(tangential * seen.slip > 0.0)
        });
        Self {
            possible: share(seen.iter().map(|(force, seen)| along(force, &seen.normal) > CONE)),
            with_slip: share(slipping),
            with_power: share(seen.iter().map(|(force, seen)| force.dot(&seen.way) > 0.0)),
        }
    }

    fn is_right(&self) -> bool {
        self.possible.is_some_and(|share| share > ENOUGH)
            && self.with_slip.is_none_or(|share| share > 1.0 - TOO_FEW)
    }

    fn is_wrong(&self) -> bool {
        self.possible.is_some_and(|share| share < TOO_FEW)
            || self.with_slip.is_some_and(|share| share < 1.0 - ENOUGH)
    }
}

/// The share of forces that are possible in a view; none without forces.
pub(super) fn possible(scene: &Scene, view: &View) -> Option<f64> {
    Reading::of(scene, view, &Matrix2::identity()).possible
}

/// Whether the force's axes are those of the poses.
pub(super) fn direction(scene: &Scene, view: &View) -> Option<Suspicion> {
    let given = Reading::of(scene, view, &Matrix2::identity());
    if !given.is_wrong() {
        return None;
    }
    let percent = |share: Option<f64>| 100.0 * share.unwrap_or(0.0);
    let mut evidence = format!(
        "the contact force points into the object, within 60° of the normal, in {:.0} % of the \
         moments in which the object moves, and its power is negative in {:.0} %",
        percent(given.possible),
        100.0 - percent(given.with_power)
    );
    if let Some(with_slip) = given.with_slip.filter(|share| *share < 1.0 - ENOUGH) {
        evidence +=
            &format!("; friction goes with the pusher's slip in {:.0} %", 100.0 * with_slip);
    }
    // The sign first: of two corrections that explain as much it is the simpler one.
    let mut changes = axes();
    changes.sort_by_key(|(_, change)| *change != -Matrix2::identity());
    let right = |(name, change): &(&'static str, Matrix2<f64>)| {
        Reading::of(scene, view, change).is_right().then_some((*name, *change))
    };
    Some(match changes.iter().find_map(right) {
        Some((name, change)) => Suspicion {
            what: format!("{name} of the force"),
            evidence: evidence + "; with that corrected all is as it must be",
            fix: format!(
                "forces are of the object on the pusher: set frame = \"sensor\" and signs = {} \
                 under streams.wrench",
                signs(&change)
            ),
            is_certain: true,
        },
        None => Suspicion {
            what: "the force's frame is not that of the poses".into(),
            evidence,
            fix: "check frame, signs and transform under streams.wrench".into(),
            is_certain: false,
        },
    })
}

/// Axes as the manifest writes them.
fn signs(axes: &Matrix2<f64>) -> String {
    let name = |row: usize| match (axes[(row, 0)], axes[(row, 1)]) {
        (one, _) if one > 0.0 => "+x",
        (one, _) if one < 0.0 => "-x",
        (_, one) if one > 0.0 => "+y",
        _ => "-y",
    };
    format!("[\"{}\", \"{}\", \"+z\"]", name(0), name(1))
}

/// Whether the force is about that of sliding.
pub(super) fn size(scene: &Scene, manifest: &Manifest, is_mass_known: bool) -> Option<Suspicion> {
    let support = manifest.support;
    let ratio = |(object, moment): &(usize, super::Moment)| {
        let sliding = support.friction * scene.objects[*object].mass * support.gravity;
        Some(moment.force?.norm() / sliding)
    };
    let ratio = quantile(scene.seen.iter().filter_map(ratio).collect(), 0.5)?;
    let is_odd = ratio < ODD.0 || ratio > ODD.1;
    if !is_mass_known || !is_odd {
        return None;
    }
    let how = if ratio > 1.0 { ("large", "mN", "1e-3") } else { ("small", "kN", "1e3") };
    Some(Suspicion {
        what: format!("the force is too {} for the object: it may be in {}, not N", how.0, how.1),
        evidence: format!(
            "while the object moves, its median is {ratio:.1e} times that of sliding, μ m g"
        ),
        fix: format!(
            "set fx and fy with scale = {} under streams.wrench.columns (or fields), or correct \
             object.mass_kg, support.friction or support.gravity_m_s2",
            how.2
        ),
        is_certain: ratio < IMPOSSIBLE.0 || ratio > IMPOSSIBLE.1,
    })
}
