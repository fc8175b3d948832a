//! Whether the force is about that of sliding.

use crate::SupportSpec;

use super::mistake::View;
use super::scene::Scene;
use super::{Check, Find, Suspicion, mass};
use crate::curves::sample::quantile;

pub(super) const CHECK: Check = Check {
    id: "force-size",
    looks_at: "the force over that of sliding by the object's own motion, which is the table's \
               friction over the stated one",
    names: "forces, a mass or a gravity in another unit, and friction that no table has",
    find: Find::Forces(find),
};

/// Friction of the table, over the stated one, that is a table's own: a diagnosis measures it.
const USUAL: (f64, f64) = (0.47, 2.2);
/// Coefficients of friction that dry tables have: PTFE on polished steel, and rubber.
///
/// Source: The Engineering ToolBox, friction coefficients (0.04 for PTFE on steel, 1.0 for rubber on
/// dry concrete).
const POSSIBLE: (f64, f64) = (0.04, 1.2);
/// Beyond this of the stated one, and of what tables have, nothing can be concluded.
const CERTAIN: f64 = 5.0;
/// A unit is named where it leaves the friction within this factor of the stated one.
const ALIKE: f64 = 1.6;
/// Gravity on earth, in m/s².
const GRAVITY: (f64, f64) = (9.7, 9.9);

/// Units by what they multiply the friction by: of force first, for a scale that shows newtons is
/// rarer than one that shows kilograms; then of the mass.
const UNITS: [(f64, &str, &str, f64); 11] = [
    (1.0 / 9.806_65, "the force is in kgf, not N", "fx and fy with scale = 9.80665", 1.0),
    (101.971_6, "the force is in gf, not N", "fx and fy with scale = 9.80665e-3", 1.0),
    (1.0 / 4.448_222, "the force is in lbf, not N", "fx and fy with scale = 4.448222", 1.0),
    (3.596_943, "the force is in ozf, not N", "fx and fy with scale = 0.2780139", 1.0),
    (1e3, "the force is in mN, not N", "fx and fy with scale = 1e-3", 1.0),
    (1e-3, "the force is in kN, not N", "fx and fy with scale = 1e3", 1.0),
    (1e5, "the force is in dyn, not N", "fx and fy with scale = 1e-5", 1.0),
    (1.0 / 2.204_623, "the mass is in lb, not kg", "mass", 0.453_592_4),
    (1.0 / 35.273_96, "the mass is in oz, not kg", "mass", 0.028_349_52),
    (1e-3, "the mass is in g, not kg", "mass", 1e-3),
    (1e3, "the mass is in t, not kg", "mass", 1e3),
];

/// μ g m is the force of sliding without turning; the ellipsoid makes less of it where it turns.
fn find(scene: &Scene<'_>, view: &View) -> Option<Suspicion> {
    if mass::is_possible(scene) == Some(false) || view.is_unit {
        return None;
    }
    let support = scene.manifest.support;
    let ratio = ratio(scene, &support)?;
    let friction = ratio * support.friction;
    if ratio > USUAL.0 && ratio < USUAL.1 {
        return None;
    }
    let causes = causes(ratio, &support);
    let is_table = friction > POSSIBLE.0 && friction < POSSIBLE.1;
    let is_close = ratio > 1.0 / CERTAIN && ratio < CERTAIN;
    let (what, mut fix) = causes.first().cloned().unwrap_or_else(|| {
        let how = if ratio > 1.0 { "large" } else { "small" };
        (
            format!("the force is too {how} for the object: its scale, the mass or the friction"),
            "check the sensor with a known weight, and weigh the object".to_owned(),
        )
    });
    for (other, how) in causes.iter().skip(1) {
        fix += &format!("; or, if {other}: {how}");
    }
    if is_table || !causes.is_empty() {
        fix += &format!("; or set support.friction = {friction:.2} if it is the table's");
    }
    let range = if is_table { "within" } else { "outside" };
    Some(Suspicion {
        what,
        evidence: format!(
            "while the object moves, the force is {ratio:.2e} times that of sliding: friction {} \
             in the place of {}, {range} the {} to {} of dry tables",
            short(friction),
            support.friction,
            POSSIBLE.0,
            POSSIBLE.1
        ),
        fix,
        is_certain: !is_table && !is_close,
    })
}

/// What would make a friction of the stated one's size of this, the likelier first, with what to do.
fn causes(ratio: f64, support: &SupportSpec) -> Vec<(String, String)> {
    let off = |factor: f64| (ratio / factor).ln().abs();
    let mut causes = Vec::new();
    if support.gravity < GRAVITY.0 || support.gravity > GRAVITY.1 {
        let what = format!("gravity is not {} m/s²", support.gravity);
        let fix = "set support.gravity_m_s2 = 9.81".to_owned();
        causes.push((off(9.81 / support.gravity), (what, fix)));
    }
    for (factor, what, fix, scale) in UNITS {
        let fix = match fix {
            "mass" => format!("set object.mass_kg to {scale} times what it is"),
            columns => format!("set {columns} under streams.wrench.columns (or fields)"),
        };
        causes.push((off(factor), (what.to_owned(), fix)));
    }
    causes.retain(|(off, _)| *off < ALIKE.ln());
    // Stable: of two that explain as much the earlier stays first.
    causes.sort_by(|(a, _), (b, _)| (10.0 * a).round().total_cmp(&(10.0 * b).round()));
    causes.into_iter().map(|(_, cause)| cause).collect()
}

/// Median force over μ m g |v| / √(|v|² + c²ω²), the force of sliding with this motion.
fn ratio(scene: &Scene<'_>, support: &SupportSpec) -> Option<f64> {
    let one = |(recording, moment): &(usize, super::moment::Moment)| {
        let object = scene.object(*recording);
        let [(start, from), _, (end, to)] = moment.object;
        let center = object.center_of_mass;
        let place = |position, angle| planar::Pose { position, angle }.transform_point(&center);
        let way = (place(end, to) - place(start, from)).norm();
        let turn = object.shape.mean_distance(&center) * planar::wrap_angle(to - from);
        let sliding = support.friction * object.mass * support.gravity * way / way.hypot(turn);
        Some(moment.force?.norm() / sliding).filter(|ratio| ratio.is_finite())
    };
    quantile(scene.seen.iter().filter_map(one).collect(), 0.5)
}

/// A coefficient in two digits.
fn short(friction: f64) -> String {
    if (0.01..100.0).contains(&friction) {
        format!("{friction:.2}")
    } else {
        format!("{friction:.1e}")
    }
}
