//! Least-squares fits of limit surfaces to measured loads and motions.

use crate::quartic::{QUARTIC_EXPONENTS, gradient, polynomial, squared};
use crate::{Ellipsoid, LimitSurface, MechanicsError, Patch, Quartic};
use nalgebra::{DMatrix, DVector, Matrix3, Vector2, Vector3};
use planar::{Shape, Twist, Wrench};

/// A load applied to a sliding object, in N and N·m, and the object's motion, in one frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WrenchTwist {
    /// The applied load.
    pub wrench: Wrench,
    /// The motion; only its direction counts.
    pub twist: Twist,
}

/// A fitted surface and how well it explains the pairs, in the space of (Fx, Fy, M/ρ).
#[derive(Clone, Debug)]
pub struct Fit<S> {
    /// The surface.
    pub surface: S,
    /// Root mean square distance of the load from the one predicted for the motion, in N.
    pub force_error_rms: f64,
    /// Mean angle between the motion and the one predicted for the load, in rad.
    pub twist_error_mean: f64,
    /// Attempts until the surface was admissible; 1 if plain least squares was.
    pub iterations: usize,
}

/// Fits wᵀ A w = 1 with motions along A w; ρ is `length`, in m.
///
/// # Errors
/// `TooFewPairs` below 6 pairs, `Undetermined` if they are too alike, `NotPositiveDefinite` if
/// the best quadric is no ellipsoid, and `NotPositive` or `NotFinite` for bad input.
pub fn fit_ellipsoid(pairs: &[WrenchTwist], length: f64) -> Result<Fit<Ellipsoid>, MechanicsError> {
    let scaled = Scaled::new("an ellipsoid", pairs, length, 6)?;
    let basis: Vec<Matrix3<f64>> = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)]
        .map(|(i, j)| {
            let mut m = Matrix3::zeros();
            (m[(i, j)], m[(j, i)]) = (1.0, 1.0);
            m
        })
        .to_vec();
    let terms =
        |w: &Vector3<f64>| basis.iter().map(|m| (0.5 * w.dot(&(m * w)), m * w)).collect::<Vec<_>>();
    let solution = scaled.level_set_fit("an ellipsoid", 2.0, &terms)?;
    let matrix: Matrix3<f64> = basis.iter().zip(solution.iter()).map(|(m, c)| m * *c).sum();
    let unscale = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 1.0 / length)) / scaled.force;
    Ellipsoid::from_matrix(unscale * matrix * unscale)
        .and_then(|surface| scored(surface, pairs, length, 1))
}

/// Fits a quartic, drawn towards the fitted ellipsoid just as far as it needs to be convex.
///
/// # Errors
/// As [`fit_ellipsoid`], below 15 pairs.
pub fn fit_quartic(pairs: &[WrenchTwist], length: f64) -> Result<Fit<Quartic>, MechanicsError> {
    let scaled = Scaled::new("a quartic", pairs, length, 15)?;
    let unit = |k: usize| -> [f64; 15] { std::array::from_fn(|i| f64::from(u8::from(i == k))) };
    let terms = |w: &Vector3<f64>| {
        let term = |k| (0.25 * polynomial(&unit(k), w), 0.25 * gradient(&unit(k), w));
        (0..QUARTIC_EXPONENTS.len()).map(term).collect::<Vec<_>>()
    };
    let solution = scaled.level_set_fit("a quartic", 4.0, &terms)?;
    let scale = scaled.force.powi(-4);
    let free: [f64; 15] = std::array::from_fn(|k| scale * solution[k]);
    let ellipsoid = fit_ellipsoid(pairs, length)?.surface;
    let unscale = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, length));
    let convex = squared(&(unscale * ellipsoid.matrix() * unscale));
    let blend = |share: f64| {
        let c = std::array::from_fn(|k| (1.0 - share) * free[k] + share * convex[k]);
        Quartic::new(c, length)
    };
    let (surface, iterations) = least_blend(&blend)?;
    scored(surface, pairs, length, iterations)
}

/// Fits the traction c₀ + c₁ x + c₂ y + c₃ |r|² over `shape` to the loads of the motions, drawn
/// towards the uniform one just as far as it needs to be nowhere negative.
///
/// # Errors
/// As [`fit_ellipsoid`], below 4 pairs; `BadTraction` if even the uniform traction is not positive.
pub fn fit_patch(
    shape: &Shape,
    pairs: &[WrenchTwist],
    length: f64,
) -> Result<Fit<Patch>, MechanicsError> {
    Scaled::new("a patch", pairs, length, 4)?;
    let radius = shape.bounding_radius();
    // Lifted by |r| ≤ radius every basis field is a traction by itself; the lift is taken off again.
    let basis: [fn(&Vector2<f64>) -> f64; 4] =
        [|_| 1.0, |r| 1.0 + r.x, |r| 1.0 + r.y, |r| r.norm_squared()];
    let unit = |k: usize| Patch::with_traction(shape, move |r| basis[k](&(r / radius)));
    let patches = [unit(0)?, unit(1)?, unit(2)?, unit(3)?];
    let mut rows = DMatrix::zeros(3 * pairs.len(), 4);
    let mut loads = DVector::zeros(3 * pairs.len());
    for (i, pair) in pairs.iter().enumerate() {
        for (k, patch) in patches.iter().enumerate() {
            let load = normalized(&patch.wrench(&pair.twist)?, length);
            rows.fixed_view_mut::<3, 1>(3 * i, k).copy_from(&load);
        }
        loads.fixed_rows_mut::<3>(3 * i).copy_from(&normalized(&pair.wrench, length));
    }
    // Columns of like size make the check of the rank independent of the shape's area.
    let size = shape.area();
    let free = least_squares("a patch", rows / size, &loads)? / size;
    let ones = uniform_size(&patches[0], pairs, length)?;
    let blend = |share: f64| {
        let c: [f64; 4] = std::array::from_fn(|k| (1.0 - share) * free[k]);
        let level = c[0] + c[1] + c[2] + share * ones;
        let field = move |r: &Vector2<f64>| {
            let r = r / radius;
            level + c[1] * r.x + c[2] * r.y + c[3] * r.norm_squared()
        };
        refuse_negative(shape, &field)?;
        Patch::with_traction(shape, field)
    };
    let (surface, iterations) = least_blend(&blend)?;
    scored(surface, pairs, length, iterations)
}

/// Scores a surface on pairs: see [`Fit`].
///
/// # Errors
/// Those of the surface, and `TooFewPairs` without pairs.
pub fn scored<S: LimitSurface>(
    surface: S,
    pairs: &[WrenchTwist],
    length: f64,
    iterations: usize,
) -> Result<Fit<S>, MechanicsError> {
    if pairs.is_empty() {
        return Err(MechanicsError::TooFewPairs { what: "a score", needed: 1, got: 0 });
    }
    let (mut squares, mut angles) = (0.0, 0.0);
    for pair in pairs {
        let load = surface.wrench(&pair.twist)?;
        squares += normalized(&(load - pair.wrench), length).norm_squared();
        let motion = direction(&surface.twist(&pair.wrench)?, length);
        angles += motion.angle(&direction(&pair.twist, length));
    }
    let n = pairs.len() as f64;
    let (force_error_rms, twist_error_mean) = ((squares / n).sqrt(), angles / n);
    Ok(Fit { surface, force_error_rms, twist_error_mean, iterations })
}

/// Pairs as loads (Fx, Fy, M/ρ) of mean size 1 and directions of motion (vx, vy, ω ρ).
struct Scaled {
    pairs: Vec<(Vector3<f64>, Vector3<f64>)>,
    force: f64,
}

impl Scaled {
    fn new(
        what: &'static str,
        pairs: &[WrenchTwist],
        length: f64,
        needed: usize,
    ) -> Result<Self, MechanicsError> {
        if !(length > 0.0 && length.is_finite()) {
            let name = "characteristic length";
            return Err(MechanicsError::NotPositive { name, value: length, unit: "m" });
        }
        if pairs.len() < needed {
            return Err(MechanicsError::TooFewPairs { what, needed, got: pairs.len() });
        }
        let mut scaled = Vec::with_capacity(pairs.len());
        for pair in pairs {
            let (_, load) = crate::limit_surface::direction_of_wrench(&pair.wrench)?;
            let (_, motion) = crate::limit_surface::direction_of_twist(&pair.twist)?;
            for (size, name) in [(load, "wrench"), (motion, "twist")] {
                if size == 0.0 {
                    return Err(MechanicsError::NoDirection { name });
                }
            }
            scaled.push((normalized(&pair.wrench, length), direction(&pair.twist, length)));
        }
        let force = scaled.iter().map(|(w, _)| w.norm()).sum::<f64>() / scaled.len() as f64;
        scaled.iter_mut().for_each(|(w, _)| *w /= force);
        Ok(Self { pairs: scaled, force })
    }

    /// Least squares for H(w) = 1 and for a gradient along the motion, both linear in the
    /// coefficients; `terms` gives each term's value and its gradient, both over its degree, so
    /// that near the surface the residuals of all degrees are those of the level.
    fn level_set_fit(
        &self,
        what: &'static str,
        degree: f64,
        terms: &impl Fn(&Vector3<f64>) -> Vec<(f64, Vector3<f64>)>,
    ) -> Result<DVector<f64>, MechanicsError> {
        let n_terms = terms(&Vector3::x()).len();
        let mut rows = DMatrix::zeros(4 * self.pairs.len(), n_terms);
        let mut right = DVector::zeros(4 * self.pairs.len());
        for (i, (w, motion)) in self.pairs.iter().enumerate() {
            right[4 * i] = 1.0 / degree;
            for (k, (value, gradient)) in terms(w).into_iter().enumerate() {
                rows[(4 * i, k)] = value;
                let across = gradient - gradient.dot(motion) * motion;
                rows.fixed_view_mut::<3, 1>(4 * i + 1, k).copy_from(&across);
            }
        }
        least_squares(what, rows, &right)
    }
}

fn normalized(wrench: &Wrench, length: f64) -> Vector3<f64> {
    Vector3::new(wrench.force.x, wrench.force.y, wrench.torque / length)
}

fn direction(twist: &Twist, length: f64) -> Vector3<f64> {
    let scaled = Vector3::new(twist.linear.x, twist.linear.y, twist.angular * length);
    (scaled / scaled.amax()).normalize()
}

fn least_squares(
    what: &'static str,
    rows: DMatrix<f64>,
    right: &DVector<f64>,
) -> Result<DVector<f64>, MechanicsError> {
    let undetermined = || MechanicsError::Undetermined { what };
    let qr = rows.qr();
    let (r, projected) = (qr.r(), qr.q().transpose() * right);
    let diagonal = r.diagonal().abs();
    let floor = 1e-10 * diagonal.max();
    if !diagonal.iter().all(|x| *x > floor) {
        return Err(undetermined());
    }
    r.solve_upper_triangular(&projected).ok_or_else(undetermined)
}

/// The admissible surface with the smallest share of its safe neighbor, to 1/1024.
fn least_blend<S>(
    blend: &impl Fn(f64) -> Result<S, MechanicsError>,
) -> Result<(S, usize), MechanicsError> {
    if let Ok(surface) = blend(0.0) {
        return Ok((surface, 1));
    }
    let mut best = blend(1.0)?;
    let (mut refused, mut admitted) = (0.0, 1.0);
    let halvings = 10;
    for _ in 0..halvings {
        let middle = 0.5 * (refused + admitted);
        match blend(middle) {
            Ok(surface) => (best, admitted) = (surface, middle),
            Err(_) => refused = middle,
        }
    }
    Ok((best, halvings + 2))
}

/// The uniform traction, in N/m², whose loads fit best.
fn uniform_size(unit: &Patch, pairs: &[WrenchTwist], length: f64) -> Result<f64, MechanicsError> {
    let (mut product, mut square) = (0.0, 0.0);
    for pair in pairs {
        let load = normalized(&unit.wrench(&pair.twist)?, length);
        product += load.dot(&normalized(&pair.wrench, length));
        square += load.norm_squared();
    }
    Ok(product / square)
}

/// Refuses a quadratic field that is negative somewhere on a fine set of rays of the outline.
fn refuse_negative(
    shape: &Shape,
    field: &impl Fn(&Vector2<f64>) -> f64,
) -> Result<(), MechanicsError> {
    let center = shape.centroid();
    for edge in 0..shape.n_edges() {
        for k in 0..=64 {
            for j in 0..=16 {
                let rim = shape.point_at(edge, f64::from(k) / 64.0);
                let r = center + f64::from(j) / 16.0 * (rim - center);
                let value = field(&r);
                if value < 0.0 || value.is_nan() {
                    return Err(MechanicsError::BadTraction { value, x: r.x, y: r.y });
                }
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{WrenchTwist, fit_ellipsoid, fit_patch, fit_quartic};
    use crate::{Ellipsoid, LimitSurface, MechanicsError, Patch};
    use nalgebra::{Matrix3, Vector2};
    use planar::{Shape, Twist};

    fn pairs(surface: &dyn LimitSurface) -> Vec<WrenchTwist> {
        let golden = 2.399_963_229_728_653_f64;
        let twist = |k: u32| {
            let z = (f64::from(k) + 0.5) / 40.0 - 1.0;
            let (sin, cos) = (f64::from(k) * golden).sin_cos();
            let r = (1.0 - z * z).sqrt();
            Twist::new(r * cos, r * sin, z / 0.04)
        };
        let pair = |k| WrenchTwist { wrench: surface.wrench(&twist(k)).unwrap(), twist: twist(k) };
        (0..80).map(pair).collect()
    }

    #[test]
    fn a_fit_to_an_ellipsoid_finds_it() {
        let tilted = Matrix3::new(1.0, 0.1, 3.0, 0.1, 1.4, -4.0, 3.0, -4.0, 500.0);
        let truth = Ellipsoid::from_matrix(tilted).unwrap();
        let fit = fit_ellipsoid(&pairs(&truth), 0.04).unwrap();
        assert!((fit.surface.matrix() - tilted).amax() < 1e-8);
        assert!(fit.force_error_rms < 1e-10 && fit.twist_error_mean < 1e-6);
        let quartic = fit_quartic(&pairs(&truth), 0.04).unwrap();
        assert_eq!(quartic.iterations, 1);
        assert!(quartic.force_error_rms < 1e-7 && quartic.twist_error_mean < 1e-6);
    }

    #[test]
    fn a_quartic_explains_a_uniform_square_better_than_an_ellipsoid() {
        let truth = Patch::uniform(&Shape::square(0.09).unwrap(), 2.0).unwrap();
        let (ellipsoid, quartic) = (
            fit_ellipsoid(&pairs(&truth), 0.034).unwrap(),
            fit_quartic(&pairs(&truth), 0.034).unwrap(),
        );
        assert!(
            quartic.force_error_rms < 0.7 * ellipsoid.force_error_rms,
            "{quartic:?} {ellipsoid:?}"
        );
    }

    #[test]
    fn a_patch_fit_finds_the_traction_of_its_family() {
        let square = Shape::square(0.09).unwrap();
        let traction =
            |r: &Vector2<f64>| 200.0 + 1500.0 * r.x - 500.0 * r.y + 3e4 * r.norm_squared();
        let truth = Patch::with_traction(&square, traction).unwrap();
        let fit = fit_patch(&square, &pairs(&truth), 0.034).unwrap();
        assert!(fit.force_error_rms < 1e-8, "{fit:?}");
        let gap = fit.surface.center_of_friction() - truth.center_of_friction();
        assert!(gap.norm() < 1e-9);
    }

    #[test]
    fn pairs_that_say_too_little_are_refused() {
        let truth = Ellipsoid::new(2.0, 0.08).unwrap();
        let few = fit_ellipsoid(&pairs(&truth)[..5], 0.04).unwrap_err();
        assert_eq!(few, MechanicsError::TooFewPairs { what: "an ellipsoid", needed: 6, got: 5 });
        let same = vec![pairs(&truth)[0]; 20];
        let alike = fit_quartic(&same, 0.04).unwrap_err();
        assert_eq!(alike, MechanicsError::Undetermined { what: "a quartic" });
    }
}
