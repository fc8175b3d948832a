//! A standard normal number of which it is known between which quantiles it is.

use std::f64::consts::{SQRT_2, TAU};

/// The moments of a standard normal between two quantiles.
pub(crate) struct TruncatedNormal {
    pub(crate) mean: f64,
    pub(crate) variance: f64,
}

impl TruncatedNormal {
    /// Between the quantiles of two probabilities, the first the smaller one.
    ///
    /// With a and b the quantiles: E z = (φ(a) − φ(b))/P, E z² = 1 + (a φ(a) − b φ(b))/P.
    pub(crate) fn between(low: f64, high: f64) -> Self {
        let [a, b] = [low, high].map(quantile);
        let density = |z: f64| (-0.5 * z * z).exp() / TAU.sqrt();
        let share = high - low;
        let mean = (density(a) - density(b)) / share;
        let square = 1.0 + (a * density(a) - b * density(b)) / share;
        Self { mean, variance: (square - mean * mean).max(0.0) }
    }
}

/// The z below which a share of a standard normal lies, by bisection to the last digit; of no share and
/// of all of it ∓40, where the density is 0.
pub(crate) fn quantile(share: f64) -> f64 {
    let (mut low, mut high) = (-40.0, 40.0);
    for _ in 0..64 {
        let middle = 0.5 * (low + high);
        if 0.5 * libm::erfc(-middle / SQRT_2) < share {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::TruncatedNormal;

    #[test]
    fn slabs_have_the_moments_known_from_tables() {
        // The half normal: √(2/π), and 1 − 2/π.
        let half = TruncatedNormal::between(0.5, 1.0);
        assert!((half.mean - (2.0 / std::f64::consts::PI).sqrt()).abs() < 1e-13);
        assert!((half.variance - (1.0 - 2.0 / std::f64::consts::PI)).abs() < 1e-13);
        let whole = TruncatedNormal::between(0.0, 1.0);
        assert!(whole.mean.abs() < 1e-14 && (whole.variance - 1.0).abs() < 1e-13);
    }
}
