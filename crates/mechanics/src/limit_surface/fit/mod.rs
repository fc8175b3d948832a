//! Least-squares fits of limit surfaces to measured loads and motions.

mod barrier;
mod quartic;

pub use quartic::fit_quartic;

use crate::{Ellipsoid, LimitSurface, MechanicsError};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
use planar::{Twist, Wrench};

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
    /// Newton steps of the constrained fit; 0 if plain least squares were admissible.
    pub n_steps: usize,
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
    let (rows, right) = scaled.level_set_equations(2.0, &terms);
    let solution = least_squares("an ellipsoid", rows, &right)?;
    let matrix: Matrix3<f64> = basis.iter().zip(solution.iter()).map(|(m, c)| m * *c).sum();
    let unscale = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 1.0 / length)) / scaled.force;
    Ellipsoid::from_matrix(unscale * matrix * unscale)
        .and_then(|surface| scored(surface, pairs, length, 0))
}

/// Scores a surface on pairs: see [`Fit`].
///
/// # Errors
/// Those of the surface, and `TooFewPairs` without pairs.
pub fn scored<S: LimitSurface>(
    surface: S,
    pairs: &[WrenchTwist],
    length: f64,
    n_steps: usize,
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
    Ok(Fit { surface, force_error_rms, twist_error_mean, n_steps })
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

    /// Equations for H(w) = 1 and for a gradient along the motion, both linear in the coefficients;
    /// `terms` gives each term's value and its gradient, both over its degree, so that near the
    /// surface the residuals of all degrees are those of the level.
    fn level_set_equations(
        &self,
        degree: f64,
        terms: &impl Fn(&Vector3<f64>) -> Vec<(f64, Vector3<f64>)>,
    ) -> (DMatrix<f64>, DVector<f64>) {
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
        (rows, right)
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

#[cfg(test)]
mod tests {
    use super::{WrenchTwist, fit_ellipsoid, fit_quartic};
    use crate::{Ellipsoid, LimitSurface, MechanicsError, Patch, PointSet};
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
        assert_eq!(quartic.n_steps, 0);
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
    fn a_quartic_fit_to_two_points_is_the_best_convex_one() {
        // The level of two points has edges, so that plain least squares are not convex.
        let points = [(Vector2::new(0.05, 0.0), 1.0), (Vector2::new(-0.05, 0.0), 1.0)];
        let pairs = pairs(&PointSet::new(points).unwrap());
        let quartic = fit_quartic(&pairs, 0.05).unwrap();
        let ellipsoid = fit_ellipsoid(&pairs, 0.05).unwrap();
        assert!(quartic.n_steps > 0);
        assert!(quartic.force_error_rms < 0.8 * ellipsoid.force_error_rms, "{quartic:?}");
        assert!(quartic.twist_error_mean < ellipsoid.twist_error_mean);
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
