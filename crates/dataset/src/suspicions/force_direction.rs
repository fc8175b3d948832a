//! Whether the force is one that a pusher can press with.

use nalgebra::{Matrix2, Vector2};
use planar::perpendicular;

use super::mistake::{View, axes};
use super::numbers::share;
use super::scene::Scene;
use super::{Check, Find, Suspicion};

pub(super) const CHECK: Check = Check {
    id: "force-direction",
    looks_at: "the angle of the force to the outline's normal, and whether friction goes with the slip",
    names: "the swap or sign of the force's axes that lets the pusher press",
    find: Find::Forces(find),
};

/// Cosine of the steepest angle between force and normal that counts as possible: friction of 1.7.
const CONE: f64 = 0.5;
/// Of possible forces fewer are suspicious, and more are right.
const TOO_FEW: f64 = 0.5;
const ENOUGH: f64 = 0.85;
/// By so much larger has the share of possible forces to be where less than half are impossible.
const MORE: f64 = 0.2;
/// Slip that says which way friction acts, over the pusher's way.
const SLIPS: f64 = 0.5;
/// Tangential force that does, over the normal one.
const RUBS: f64 = 0.05;
/// Distance from the outline at which there is a contact, over the object's size.
const TOUCHES: f64 = 0.15;

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
    fn of(scene: &Scene<'_>, view: &View, axes: &Matrix2<f64>) -> Self {
        let touching = TOUCHES * scene.size() * view.outline_scale();
        let seen = scene.seen.iter().filter_map(|(object, moment)| {
            let force = axes * moment.force?;
            let shape = &scene.object(*object).shape;
            Some((force, view.seen(moment, shape, scene.radius())))
        });
        let tells = |(force, seen): &(Vector2<f64>, super::mistake::Seen)| {
            force.norm() > 0.0 && seen.contact.gap.abs() <= touching
        };
        let seen: Vec<_> = seen.filter(tells).collect();
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
pub(super) fn possible(scene: &Scene<'_>, view: &View) -> Option<f64> {
    Reading::of(scene, view, &Matrix2::identity()).possible
}

fn find(scene: &Scene<'_>, view: &View) -> Option<Suspicion> {
    let given = Reading::of(scene, view, &Matrix2::identity());
    // The sign first: of two corrections that explain as much it is the simpler one.
    let mut changes = axes();
    changes.sort_by_key(|(_, change)| *change != -Matrix2::identity());
    let right = |(name, change): &(&'static str, Matrix2<f64>)| {
        let changed = Reading::of(scene, view, change);
        let is_better = changed.possible > given.possible.map(|share| share + MORE);
        (changed.is_right() && (given.is_wrong() || is_better)).then_some((*name, *change))
    };
    let corrected = changes.iter().find_map(right);
    if !given.is_wrong() && corrected.is_none() {
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
    Some(match corrected {
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
