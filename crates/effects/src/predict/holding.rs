//! Which loads friction holds at rest.

use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

use crate::EffectError;

/// Relative accuracy of a level.
const TOLERANCE: f64 = 1e-9;
const MAX_ITERATIONS: usize = 1000;

/// How far a load is beyond what friction holds, 1 at its limit; none for a load that it holds.
///
/// Friction that loads L(t) move at t holds the loads w with w·t ≤ P(t) = L(t)·t for every motion t,
/// so the level of w is |w| over the smallest P on the plane w·t = |w|. There P is convex in two
/// numbers, its derivatives by them are those of L·t, and ellipses around the smallest shrink to it:
/// neither a facet nor a vertex of the limit surface matters, and every ellipse bounds the level.
///
/// - `friction`: L, boundary loads of a convex set that is symmetric about 0;
/// - `wrench`: w, not zero; forces and moments, and velocities and turns, in units of like size;
/// - `guess`: a motion that w may belong to.
///
/// # Errors
/// `NotConverged`, and what `friction` refuses.
///
/// # Source
/// Grötschel, Lovász & Schrijver (1993), Geometric Algorithms and Combinatorial Optimization, chapter
/// 3, for the ellipsoid method.
pub(crate) fn overload(
    friction: impl Fn(&Vector3<f64>) -> Result<Vector3<f64>, EffectError>,
    wrench: &Vector3<f64>,
    guess: &Vector3<f64>,
) -> Result<Option<f64>, EffectError> {
    let failed = |iterations| EffectError::NotConverged { what: "the load at rest", iterations };
    let first = guess.normalize();
    let [second, third] = across(&first);
    let loads = [friction(&first)?, friction(&second)?, friction(&third)?];
    // Their octahedron is held.
    let inverse = Matrix3::from_columns(&loads).try_inverse().ok_or(failed(0))?;
    if (inverse * wrench).lp_norm(1) < 1.0 {
        return Ok(None);
    }
    let size = wrench.norm();
    let along = wrench / size;
    let [one, two] = across(&along);
    let mut center = Vector2::new(one.dot(&first), two.dot(&first)) / along.dot(&first);
    let mut least = f64::INFINITY;
    // Maps the unit disc to the ellipse.
    let mut ellipse = Matrix2::zeros();
    for iteration in 0..MAX_ITERATIONS {
        let motion = along + center.x * one + center.y * two;
        let load = friction(&motion)?;
        let power = load.dot(&motion);
        if iteration == 0 {
            // By the octahedron P(t) ≥ |t|/(√3 |inverse|): where P is smallest t is not longer.
            let longest = 3_f64.sqrt() * power * inverse.norm();
            ellipse = Matrix2::identity() * (longest + center.norm());
        }
        least = least.min(power);
        let slope = Vector2::new(load.dot(&one), load.dot(&two));
        let image = ellipse.tr_mul(&slope);
        let reach = image.norm();
        let is_known = reach <= TOLERANCE * power;
        if power - reach > size || (is_known && least > size) {
            return Ok(None);
        }
        if is_known {
            return Ok(Some(size / least));
        }
        // The smallest ellipse around the half on which P may be smaller.
        let step = ellipse * (image / reach);
        center -= step / 3.0;
        ellipse -= (1.0 - 3_f64.sqrt().recip()) * step * (image / reach).transpose();
        ellipse *= 2.0 / 3_f64.sqrt();
    }
    Err(failed(MAX_ITERATIONS))
}

/// Two unit vectors across a third and across each other.
fn across(unit: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let other = Vector3::ith(unit.iamin(), 1.0);
    let first = unit.cross(&other).normalize();
    [first, unit.cross(&first)]
}

#[cfg(test)]
mod tests {
    use super::overload;
    use nalgebra::{Matrix3, Vector3};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn random(random: &mut ChaCha8Rng) -> Vector3<f64> {
        Vector3::from_fn(|_, _| random.random_range(-1.0..1.0))
    }

    #[test]
    fn on_an_ellipsoid_the_level_is_the_closed_form() {
        let mut source = ChaCha8Rng::seed_from_u64(8);
        for _ in 0..300 {
            let root =
                Matrix3::from_fn(|_, _| source.random_range(-1.0..1.0)) + Matrix3::identity();
            let inverse: Matrix3<f64> = root * root.transpose() + 0.05 * Matrix3::identity();
            let friction = |t: &Vector3<f64>| Ok(inverse * t / t.dot(&(inverse * t)).sqrt());
            let (wrench, guess) = (random(&mut source), random(&mut source));
            let level = wrench.dot(&(inverse.try_inverse().unwrap() * wrench)).sqrt();
            for share in [0.3, 0.9, 1.0 - 1e-6, 1.0 + 1e-6, 1.1, 3.0] {
                let found = overload(friction, &(share / level * wrench), &guess).unwrap();
                match found {
                    None => assert!(share < 1.0, "{share} {wrench} {guess} {inverse}"),
                    Some(found) => {
                        assert!(
                            share > 1.0 && (found / share - 1.0).abs() < 1e-7,
                            "{share} {found}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn facets_and_an_edge_are_no_trouble() {
        // A cylinder: forces to 1 and moments to 1, P = |v| + |ω|.
        let friction = |t: &Vector3<f64>| {
            let force = t.xy().try_normalize(0.0).unwrap_or_default();
            let moment = if t.z == 0.0 { 0.0 } else { t.z.signum() };
            Ok(Vector3::new(force.x, force.y, moment))
        };
        let mut source = ChaCha8Rng::seed_from_u64(9);
        for _ in 0..300 {
            let wrench = random(&mut source);
            let level = wrench.xy().norm().max(wrench.z.abs());
            for share in [0.5, 1.0 - 1e-6, 1.0 + 1e-6, 2.0] {
                let found = overload(friction, &(share / level * wrench), &random(&mut source));
                let found = found.unwrap();
                assert_eq!(found.is_some(), share > 1.0, "{wrench} {found:?}");
                assert!(found.is_none_or(|found| (found / share - 1.0).abs() < 1e-7));
            }
        }
    }
}
