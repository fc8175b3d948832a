//! Mean, covariance and quantiles of a distribution over planar poses.

use std::f64::consts::{PI, TAU};

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use crate::slab::quantile as normal_quantile;
use crate::{FilterError, Gaussian, Weights};

/// A state of which a planar pose is a part.
pub trait PlanarState {
    /// x and y in m, and the angle in rad, of any turn.
    fn planar(&self) -> [f64; 3];
}

impl PlanarState for [f64; 3] {
    fn planar(&self) -> [f64; 3] {
        *self
    }
}

impl PlanarState for Vector3<f64> {
    fn planar(&self) -> [f64; 3] {
        (*self).into()
    }
}

/// Where a cloud of weighted poses is, and how wide.
///
/// The mean angle is the direction of the mean of (cos θ, sin θ), which knows no seam; deviations
/// from it are in (−π, π].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlanarSummary {
    /// Mean x and y in m, and mean angle in rad in (−π, π].
    pub mean: Vector3<f64>,
    /// Covariance of x, y and angle about the mean, in m², m·rad and rad².
    pub covariance: Matrix3<f64>,
    /// Length of the mean of (cos θ, sin θ): 1 for one angle, 0 for none at all.
    pub concentration: f64,
}

impl PlanarSummary {
    /// The summary of weighted states.
    ///
    /// # Errors
    /// `Empty` without states; `ShapeMismatch` for another number of weights; `NotANumber` for a
    /// state that is not finite, with its number.
    pub fn of<S: PlanarState>(states: &[S], weights: &Weights) -> Result<Self, FilterError> {
        let poses = poses(states, weights)?;
        let (mut position, mut heading) = ([0.0; 2], [0.0; 2]);
        for ([x, y, angle], weight) in &poses {
            position[0] += weight * x;
            position[1] += weight * y;
            heading[0] += weight * angle.cos();
            heading[1] += weight * angle.sin();
        }
        let mean = Vector3::new(position[0], position[1], heading[1].atan2(heading[0]));
        let deviation = |[x, y, angle]: &[f64; 3]| {
            Vector3::new(x - mean.x, y - mean.y, wrapped(angle - mean.z))
        };
        let covariance = poses.iter().fold(Matrix3::zeros(), |sum, (pose, weight)| {
            let deviation = deviation(pose);
            sum + *weight * deviation * deviation.transpose()
        });
        Ok(Self { mean, covariance, concentration: heading[0].hypot(heading[1]) })
    }

    /// For each probability the quantiles of x, y and angle, each on its own; the angle's are
    /// counted from the mean and may lie beyond ±π.
    ///
    /// # Errors
    /// As [`PlanarSummary::of`]; `OutOfRange` for a probability beyond 0 to 1.
    pub fn quantiles<S: PlanarState>(
        &self,
        states: &[S],
        weights: &Weights,
        probabilities: &[f64],
    ) -> Result<Vec<Vector3<f64>>, FilterError> {
        let poses = poses(states, weights)?;
        if let Some(value) = probabilities.iter().find(|value| !(0.0..=1.0).contains(*value)) {
            let (name, expected) = ("probability", "from 0 to 1");
            return Err(FilterError::OutOfRange { name, expected, value: *value });
        }
        let of_axis = |axis: usize| {
            let value = |pose: &[f64; 3]| match axis {
                2 => self.mean.z + wrapped(pose[2] - self.mean.z),
                _ => pose[axis],
            };
            let mut sorted: Vec<_> = poses.iter().map(|(pose, w)| (value(pose), *w)).collect();
            sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
            probabilities.iter().map(|share| quantile(&sorted, *share)).collect::<Vec<_>>()
        };
        let [x, y, angle] = [0, 1, 2].map(of_axis);
        let rows = x.into_iter().zip(y).zip(angle);
        Ok(rows.map(|((x, y), angle)| Vector3::new(x, y, angle)).collect())
    }

    /// The level, from 0 to 1, of the region of the states on whose border a measured pose lies.
    ///
    /// Regions are ellipsoids about the mean in the metric of the covariance, each as large as the
    /// share of the states in it: right for states of any distribution. The pose's own is widened by
    /// the variance of its measurement.
    ///
    /// - `measured`: x and y in m, angle in rad; - `measured_sd`: along each axis in m, and in rad.
    ///
    /// # Errors
    /// As [`PlanarSummary::of`]; `OutOfRange` for a standard deviation that is negative or no number.
    pub fn level<S: PlanarState>(
        &self,
        states: &[S],
        weights: &Weights,
        measured: [f64; 3],
        measured_sd: [f64; 2],
    ) -> Result<f64, FilterError> {
        let poses = poses(states, weights)?;
        if let Some(value) = measured_sd.into_iter().find(|sd| !(*sd >= 0.0 && sd.is_finite())) {
            let (name, expected) = ("sd of a measured pose", "finite and not negative");
            return Err(FilterError::OutOfRange { name, expected, value });
        }
        let reached = self.distance(measured, measured_sd);
        let is_nearer = |pose: &[f64; 3]| self.distance(*pose, [0.0; 2]) < reached;
        Ok(poses.iter().filter(|(pose, _)| is_nearer(pose)).map(|(_, weight)| weight).sum())
    }

    /// The summary of a Gaussian over x and y in m and the angle in rad, of any turn.
    ///
    /// # Errors
    /// `ShapeMismatch` for a Gaussian of other than three coordinates.
    pub fn of_gaussian(gaussian: &Gaussian) -> Result<Self, FilterError> {
        let (mean, expected) = (gaussian.mean(), 3);
        if mean.len() != expected {
            let (what, actual) = ("coordinates of a pose", mean.len());
            return Err(FilterError::ShapeMismatch { what, expected, actual });
        }
        let covariance = Matrix3::from_iterator(gaussian.covariance().iter().copied());
        Ok(Self {
            mean: Vector3::new(mean[0], mean[1], wrapped(mean[2])),
            covariance,
            // Of a Gaussian that is wrapped about the circle.
            concentration: (-0.5 * covariance[(2, 2)]).exp(),
        })
    }

    /// As [`PlanarSummary::quantiles`], of a Gaussian with this mean and covariance.
    ///
    /// # Errors
    /// `OutOfRange` for a probability that is not between 0 and 1.
    pub fn gaussian_quantiles(
        &self,
        probabilities: &[f64],
    ) -> Result<Vec<Vector3<f64>>, FilterError> {
        let sds = self.covariance.diagonal().map(|variance| variance.max(0.0).sqrt());
        let quantiles = |probability: &f64| {
            if !(*probability > 0.0 && *probability < 1.0) {
                let (name, expected) = ("probability", "between 0 and 1");
                return Err(FilterError::OutOfRange { name, expected, value: *probability });
            }
            Ok(self.mean + normal_quantile(*probability) * sds)
        };
        probabilities.iter().map(quantiles).collect()
    }

    /// As [`PlanarSummary::level`], of a Gaussian with this mean and covariance.
    pub fn gaussian_level(&self, measured: [f64; 3], measured_sd: [f64; 2]) -> f64 {
        // The probability that a χ² of three degrees of freedom is below the square.
        let reach = self.distance(measured, measured_sd).sqrt();
        if reach == f64::INFINITY {
            return 1.0;
        }
        let density = (2.0 / PI).sqrt() * reach * (-0.5 * reach * reach).exp();
        libm::erf(reach / std::f64::consts::SQRT_2) - density
    }

    /// The squared distance of Mahalanobis of a pose with a variance of its own.
    fn distance(&self, [x, y, angle]: [f64; 3], [place_sd, angle_sd]: [f64; 2]) -> f64 {
        let own = Vector3::new(place_sd, place_sd, angle_sd).map(|sd| sd * sd + LEAST_VARIANCE);
        let covariance = self.covariance + Matrix3::from_diagonal(&own);
        let off = Vector3::new(x - self.mean.x, y - self.mean.y, wrapped(angle - self.mean.z));
        covariance.cholesky().map_or(f64::INFINITY, |root| off.dot(&root.solve(&off)))
    }
}

/// (10 nm)² and (10 nrad)²: so that states without spread have regions, too.
const LEAST_VARIANCE: f64 = 1e-16;

/// The pose and weight of each state.
pub(crate) fn poses<S: PlanarState>(
    states: &[S],
    weights: &Weights,
) -> Result<Vec<([f64; 3], f64)>, FilterError> {
    let (expected, actual) = (states.len(), weights.as_slice().len());
    if states.is_empty() {
        return Err(FilterError::Empty { what: "states" });
    }
    if actual != expected {
        return Err(FilterError::ShapeMismatch { what: "weights", expected, actual });
    }
    let pose = |(particle, (state, weight)): (usize, (&S, &f64))| {
        let pose = state.planar();
        match pose.into_iter().find(|value| !value.is_finite()) {
            Some(value) => {
                Err(FilterError::NotANumber { step: 0, what: "a coordinate", particle, value })
            }
            None => Ok((pose, *weight)),
        }
    };
    states.iter().zip(weights.as_slice()).enumerate().map(pose).collect()
}

/// The least value at which the weights up to it reach a share.
fn quantile(sorted: &[(f64, f64)], share: f64) -> f64 {
    let mut sum = 0.0;
    let reached = sorted.iter().find(|(_, weight)| {
        sum += weight;
        sum >= share
    });
    reached.or(sorted.last()).map_or(0.0, |(value, _)| *value)
}

/// An angle in (−π, π].
fn wrapped(angle: f64) -> f64 {
    let angle = angle.rem_euclid(TAU);
    if angle > PI { angle - TAU } else { angle }
}
