//! A limit surface that was measured under one object, whatever the pressure is that makes it.

use mechanics::{Fit, LimitSurface, MechanicsError, Quartic, WrenchTwist, fit_quartic};
use planar::Twist;
use serde::{Deserialize, Serialize};

use crate::ModelError;

/// A convex quartic limit surface of one object, in its body frame, that bears 1 N.
///
/// Convexity is proved when it is made ([`Quartic::new`]); loads and motions follow from each other
/// exactly. It says nothing of other objects, nor of where the pressure is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EffectiveSurface {
    /// Of H(Fx, Fy, M/length) = 1 with forces in N, in the order of [`mechanics::QUARTIC_EXPONENTS`].
    coefficients: [f64; 15],
    /// That makes moments and forces of like size, in m.
    length: f64,
}

/// Directions of motion over which the force that a surface bears is averaged.
const N_DIRECTIONS: u32 = 16;

impl EffectiveSurface {
    /// A surface of such coefficients, in 1/N⁴, and length, in m, scaled to bear 1 N on the mean over the
    /// directions of translation.
    ///
    /// # Errors
    /// `Mechanics` as [`Quartic::new`]: for coefficients that are not convex or not finite.
    pub fn new(coefficients: [f64; 15], length: f64) -> Result<Self, ModelError> {
        let force = mean_force(&Quartic::new(coefficients, length)?)?;
        Ok(Self { coefficients: coefficients.map(|c| c * force.powi(4)), length })
    }

    /// The surface that is nearest to measured loads and motions of an object, in its body frame, with the
    /// fit of it in N: among all convex quartics ([`fit_quartic`]).
    ///
    /// - `length`: makes moments and forces of like size, in m.
    ///
    /// # Errors
    /// `Mechanics` for fewer than 15 pairs, or pairs that are too alike.
    pub fn of_pairs(
        pairs: &[WrenchTwist],
        length: f64,
    ) -> Result<(Self, Fit<Quartic>), ModelError> {
        let fit = fit_quartic(pairs, length)?;
        Ok((Self::new(*fit.surface.coefficients(), length)?, fit))
    }

    /// What makes moments and forces of like size, in m.
    pub fn length(&self) -> f64 {
        self.length
    }

    /// The surface as it bears a force, in N.
    ///
    /// # Errors
    /// `Mechanics` as [`Quartic::new`], for coefficients from elsewhere.
    pub fn bearing(&self, force: f64) -> Result<Quartic, ModelError> {
        Ok(Quartic::new(self.coefficients.map(|c| c / force.powi(4)), self.length)?)
    }
}

/// The force of friction on the mean over the directions of translation, in N.
fn mean_force(surface: &Quartic) -> Result<f64, MechanicsError> {
    let along = |k: u32| {
        let angle = std::f64::consts::TAU * f64::from(k) / f64::from(N_DIRECTIONS);
        surface.dissipation(&Twist::new(angle.cos(), angle.sin(), 0.0))
    };
    let forces = (0..N_DIRECTIONS).map(along).collect::<Result<Vec<f64>, _>>()?;
    Ok(forces.iter().sum::<f64>() / f64::from(N_DIRECTIONS))
}

#[cfg(test)]
mod tests {
    use mechanics::{LimitSurface, Patch, UniformPressure, WrenchTwist, fit_ellipsoid};
    use planar::{Shape, Twist, mit_object};

    use super::EffectiveSurface;

    fn pairs(shape: &Shape, force: f64) -> Vec<WrenchTwist> {
        let exact = Patch::over(shape, force).unwrap();
        let twist = |k: u32| {
            let z = (f64::from(k) + 0.5) / 60.0 - 1.0;
            let (sin, cos) = (2.4 * f64::from(k)).sin_cos();
            let r = (1.0 - z * z).sqrt();
            Twist::new(r * cos, r * sin, z / 0.04)
        };
        let pair = |k| WrenchTwist { wrench: exact.wrench(&twist(k)).unwrap(), twist: twist(k) };
        (0..120).map(pair).collect()
    }

    #[test]
    fn a_measured_surface_bears_one_newton_and_goes_back_and_forth_exactly() {
        for shape in [Shape::square(0.09).unwrap(), mit_object("tri1").unwrap().shape] {
            let pairs = pairs(&shape, 3.0);
            let (surface, fit) = EffectiveSurface::of_pairs(&pairs, 0.035).unwrap();
            let ellipsoid = fit_ellipsoid(&pairs, 0.035).unwrap();
            assert!(fit.force_error_rms < 0.7 * ellipsoid.force_error_rms, "{fit:?}");
            assert!(fit.twist_error_mean < ellipsoid.twist_error_mean, "{fit:?}");
            for force in [1.0, 2.5] {
                let quartic = surface.bearing(force).unwrap();
                let along = |x: f64, y: f64| quartic.dissipation(&Twist::new(x, y, 0.0)).unwrap();
                let mean = 0.25 * (along(1., 0.) + along(-1., 0.) + along(0., 1.) + along(0., -1.));
                assert!((mean / force - 1.0).abs() < 0.02, "{mean}");
                for pair in &pairs {
                    let load = quartic.wrench(&pair.twist).unwrap();
                    assert!((quartic.level(&load).unwrap() - 1.0).abs() < 1e-10);
                    let back = quartic.twist(&load).unwrap();
                    let size = quartic.dissipation(&pair.twist).unwrap();
                    let off = (size * back.to_vector() - pair.twist.to_vector()).amax();
                    assert!(off < 1e-7 * pair.twist.to_vector().amax(), "{off}");
                }
            }
        }
    }

    #[test]
    fn surfaces_that_are_not_convex_are_refused() {
        let mut coefficients = [0.0; 15];
        (coefficients[0], coefficients[10], coefficients[14]) = (1.0, 1.0, 1.0);
        coefficients[3] = 20.0;
        let error = EffectiveSurface::new(coefficients, 0.03).unwrap_err().to_string();
        assert!(error.contains("convex"), "{error}");
    }
}
