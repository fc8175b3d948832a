//! Weights of particles, kept as logarithms.

use crate::FilterError;

/// Weights that sum to 1.
///
/// Kept as logarithms beside their exponentials, so that likelihoods of e^−10000 lose nothing.
#[derive(Clone, Debug, PartialEq)]
pub struct Weights {
    log: Vec<f64>,
    linear: Vec<f64>,
}

impl Weights {
    /// Equal weights.
    #[must_use]
    pub fn equal(n: usize) -> Self {
        let weight = 1.0 / n as f64;
        Self { log: vec![weight.ln(); n], linear: vec![weight; n] }
    }

    /// From logarithms up to a constant, with the logarithm of their sum; none if all are −∞.
    #[must_use]
    pub fn from_logs(mut log: Vec<f64>) -> Option<(Self, f64)> {
        let largest = log.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if !largest.is_finite() {
            return None;
        }
        let mut linear: Vec<f64> = log.iter().map(|value| (value - largest).exp()).collect();
        let sum = sum(&linear);
        let log_sum = largest + sum.ln();
        linear.iter_mut().for_each(|weight| *weight /= sum);
        log.iter_mut().for_each(|weight| *weight -= log_sum);
        Some((Self { log, linear }, log_sum))
    }

    /// The weights.
    #[must_use]
    pub fn as_slice(&self) -> &[f64] {
        &self.linear
    }

    /// Their logarithms.
    #[must_use]
    pub fn logs(&self) -> &[f64] {
        &self.log
    }

    /// Effective sample size 1/Σw², from 1 to the number of particles.
    #[must_use]
    pub fn effective_size(&self) -> f64 {
        let squares: Vec<f64> = self.linear.iter().map(|weight| weight * weight).collect();
        1.0 / sum(&squares)
    }

    /// The weights times likelihoods, and the log evidence log Σ w L.
    ///
    /// # Errors
    /// `ShapeMismatch`; `NotANumber` for a NaN or +∞; `Collapsed` if all are −∞.
    pub fn updated(
        &self,
        log_likelihoods: &[f64],
        step: usize,
    ) -> Result<(Self, f64), FilterError> {
        let (expected, actual) = (self.log.len(), log_likelihoods.len());
        if actual != expected {
            return Err(FilterError::ShapeMismatch { what: "likelihoods", expected, actual });
        }
        let is_wrong = |value: &f64| value.is_nan() || *value == f64::INFINITY;
        if let Some(particle) = log_likelihoods.iter().position(is_wrong) {
            let (what, value) = ("log likelihood", log_likelihoods[particle]);
            return Err(FilterError::NotANumber { step, what, particle, value });
        }
        let log = self.log.iter().zip(log_likelihoods).map(|(weight, value)| weight + value);
        Self::from_logs(log.collect())
            .ok_or(FilterError::Collapsed { step, n_particles: self.log.len() })
    }
}

/// Pairwise sum: its error grows with the logarithm of the length.
pub(crate) fn sum(values: &[f64]) -> f64 {
    if values.len() <= 64 {
        return values.iter().sum();
    }
    let (left, right) = values.split_at(values.len() / 2);
    sum(left) + sum(right)
}

#[cfg(test)]
mod tests {
    use super::Weights;

    #[test]
    fn likelihoods_of_any_size_keep_their_ratios() {
        let (weights, log_sum) = Weights::from_logs(vec![-10_000.0, -10_001.0, -2e9]).unwrap();
        assert!((weights.as_slice()[0] / weights.as_slice()[1] - 1.0_f64.exp()).abs() < 1e-12);
        assert!((log_sum + 10_000.0 - (1.0 + (-1.0_f64).exp()).ln()).abs() < 1e-11);
        assert_eq!(weights.as_slice()[2], 0.0);
        assert!(Weights::from_logs(vec![f64::NEG_INFINITY; 2]).is_none());
    }

    #[test]
    fn a_million_tiny_weights_sum_to_one() {
        let logs: Vec<f64> = (0..1_000_000).map(|k| -900.0 - f64::from(k % 1000)).collect();
        let (weights, _) = Weights::from_logs(logs).unwrap();
        assert!((super::sum(weights.as_slice()) - 1.0).abs() < 1e-12);
        assert!((Weights::equal(1_000_000).effective_size() - 1e6).abs() < 1e-4);
    }
}
