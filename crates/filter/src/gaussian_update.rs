//! What a measurement makes of a Gaussian and of a mixture.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};

use crate::gaussian_measurement::finite;
use crate::linearized::{Linearized, symmetric};
use crate::{
    DifferentiableMeasurement, FilterError, Gaussian, GaussianMeasurement, Mixture, Rule, Weights,
};

/// A Gaussian after a measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct GaussianUpdate {
    /// What is known of the state then.
    pub posterior: Gaussian,
    /// Log density of the measurement given all before it, in nats.
    pub log_evidence: f64,
    /// What was measured beyond what was expected, angles in (−π, π].
    pub innovation: DVector<f64>,
    /// The covariance that the innovation was expected to have.
    pub innovation_covariance: DMatrix<f64>,
}

/// A mixture after a measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct MixtureUpdate {
    /// What is known of the state then.
    pub posterior: Mixture,
    /// Log density of the measurement given all before it, in nats.
    pub log_evidence: f64,
}

impl GaussianUpdate {
    /// νᵀ S⁻¹ ν of the innovation ν with covariance S: χ² with as many degrees of freedom as were
    /// measured, if the model is right. A measurement far out in it may be an outlier.
    #[must_use]
    pub fn normalized_innovation_squared(&self) -> f64 {
        // S had a root when the update was made.
        let root = self.innovation_covariance.clone().cholesky();
        root.map_or(f64::INFINITY, |root| self.innovation.dot(&root.solve(&self.innovation)))
    }
}

impl Gaussian {
    /// The Kalman filter's update; where h is not linear the extended one's, by its Jacobian at the mean.
    ///
    /// # Errors
    /// What the measurement says; `ShapeMismatch` for one of another state; `NotFinite`; `Singular` if
    /// neither the noise nor the state leaves a coordinate of the innovation any variance.
    ///
    /// # Source
    /// Kalman (1960), A new approach to linear filtering and prediction problems; the covariance as in
    /// Bucy & Joseph (1968), Filtering for stochastic processes with applications to guidance.
    pub fn updated<Z: DifferentiableMeasurement>(
        &self,
        measurement: &Z,
    ) -> Result<GaussianUpdate, FilterError> {
        let center = measurement.expected(self.mean())?;
        let jacobian = measurement.jacobian(self.mean())?;
        let what = "entries of the Jacobian";
        let (expected, actual) = (center.len() * self.mean().len(), jacobian.len());
        if jacobian.nrows() != center.len() || actual != expected {
            return Err(FilterError::ShapeMismatch { what, expected, actual });
        }
        finite("an entry of the Jacobian", &jacobian)?;
        let rest = DMatrix::zeros(center.len(), center.len());
        self.conditioned(&Linearized { center, slope: jacobian * self.root(), rest }, measurement)
    }

    /// The update by a rule's points: the unscented or the Gauss–Hermite Kalman filter's.
    ///
    /// Exact for a linear h; else the Gaussian of the best line through h in the mean over the state,
    /// with what is left of h as noise. It asks h alone, at 2d + 1 or mᵈ points.
    ///
    /// # Errors
    /// As [`Gaussian::updated`].
    ///
    /// # Source
    /// Julier & Uhlmann (1997), A new extension of the Kalman filter to nonlinear systems; Ito & Xiong
    /// (2000), Gaussian filters for nonlinear filtering problems, IEEE Trans. Automatic Control 45(5).
    pub fn updated_by<Z: GaussianMeasurement<State = DVector<f64>>>(
        &self,
        rule: &dyn Rule,
        measurement: &Z,
    ) -> Result<GaussianUpdate, FilterError> {
        let middle = measurement.expected(self.mean())?;
        check_length(&middle, measurement)?;
        let points = self.standard_points(rule);
        let value = |(point, _): &(DVector<f64>, f64)| {
            let expected = measurement.expected(&self.at(point))?;
            check_length(&expected, measurement)?;
            // Angles next to each other, on whichever side of the seam.
            let off = measurement.residual(&expected, &middle);
            check_length(&off, measurement)?;
            Ok(&middle + off)
        };
        let values = points.iter().map(value).collect::<Result<Vec<_>, FilterError>>()?;
        self.conditioned(&Linearized::of_points(&points, &values), measurement)
    }

    fn conditioned<Z: GaussianMeasurement>(
        &self,
        line: &Linearized,
        measurement: &Z,
    ) -> Result<GaussianUpdate, FilterError> {
        check_length(&line.center, measurement)?;
        finite("an expected measurement", &line.center)?;
        finite("a measured value", measurement.measured())?;
        let noise = measurement.noise();
        let expected = &line.center + noise.mean();
        let innovation = measurement.residual(measurement.measured(), &expected);
        check_length(&innovation, measurement)?;
        let innovation_covariance = symmetric(line.covariance() + noise.covariance());
        finite("an expected variance", &innovation_covariance)?;
        let dimension = innovation.len();
        let root = innovation_covariance
            .clone()
            .cholesky()
            .ok_or(FilterError::Singular { what: "covariance of the innovation", dimension })?;
        let square = innovation.dot(&root.solve(&innovation));
        let log_determinant = 2.0 * root.l().diagonal().iter().map(|x| x.ln()).sum::<f64>();
        let log_evidence = -0.5 * (square + log_determinant + dimension as f64 * TAU.ln());
        finite("the log evidence of a measurement", [&log_evidence])?;
        let gain = root.solve(&line.slope).transpose();
        let covariance = line.corrected(&gain, &(&line.rest + noise.covariance()));
        let posterior = self.of_standard(&(gain * &innovation), &covariance)?;
        Ok(GaussianUpdate { posterior, log_evidence, innovation, innovation_covariance })
    }
}

impl Mixture {
    /// [`Gaussian::updated`] of each component, which is weighed by its evidence.
    ///
    /// Components whose weight becomes 0 in floating point are gone.
    ///
    /// # Errors
    /// As [`Gaussian::updated`].
    ///
    /// # Source
    /// Alspach & Sorenson (1972), Nonlinear Bayesian estimation using Gaussian sum approximations, IEEE
    /// Trans. Automatic Control 17(4).
    pub fn updated<Z: DifferentiableMeasurement>(
        &self,
        measurement: &Z,
    ) -> Result<MixtureUpdate, FilterError> {
        self.updated_each(|component| component.updated(measurement))
    }

    /// [`Gaussian::updated_by`] of each component, which is weighed by its evidence.
    ///
    /// # Errors
    /// As [`Gaussian::updated_by`].
    pub fn updated_by<Z: GaussianMeasurement<State = DVector<f64>>>(
        &self,
        rule: &dyn Rule,
        measurement: &Z,
    ) -> Result<MixtureUpdate, FilterError> {
        self.updated_each(|component| component.updated_by(rule, measurement))
    }

    fn updated_each(
        &self,
        update: impl Fn(&Gaussian) -> Result<GaussianUpdate, FilterError>,
    ) -> Result<MixtureUpdate, FilterError> {
        let (mut parts, mut logs) = (Vec::new(), Vec::new());
        for (component, weight) in self.components() {
            let updated = update(component)?;
            logs.push(weight.ln() + updated.log_evidence);
            parts.push(updated.posterior);
        }
        let none = FilterError::Empty { what: "components that explain the measurement" };
        let (weights, log_evidence) = Weights::from_logs(logs).ok_or(none)?;
        let weighted = parts.into_iter().zip(weights.as_slice().iter().copied());
        let posterior = Self::new(weighted.filter(|(_, weight)| *weight > 0.0).collect())?;
        Ok(MixtureUpdate { posterior, log_evidence })
    }
}

fn check_length<Z: GaussianMeasurement>(
    of_model: &DVector<f64>,
    measurement: &Z,
) -> Result<(), FilterError> {
    let expected = measurement.measured().len();
    for (what, actual) in [
        ("coordinates of the expected measurement", of_model.len()),
        ("dimension of the measurement's noise", measurement.noise().mean().len()),
    ] {
        if actual != expected {
            return Err(FilterError::ShapeMismatch { what, expected, actual });
        }
    }
    Ok(())
}
