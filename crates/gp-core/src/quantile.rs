//! Quantiles by bisection of distribution functions.

use std::f64::consts::FRAC_1_SQRT_2;

/// The x at which the standard normal distribution function is `p`; `p` is kept off 0 and 1.
pub fn normal(p: f64) -> f64 {
    let below = |x: f64| 0.5 * libm::erfc(-x * FRAC_1_SQRT_2);
    invert(below, p.clamp(1e-15, 1.0 - 1e-15), -9.0, 9.0)
}

/// The place between `low` and `high` where a growing function takes a value, to the last digit.
pub fn invert(function: impl Fn(f64) -> f64, value: f64, mut low: f64, mut high: f64) -> f64 {
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if function(middle) < value {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::normal;

    #[test]
    fn quantiles_known_from_tables() {
        assert!((normal(0.975) - 1.959_963_984_540_054).abs() < 1e-12);
        assert!(normal(0.5).abs() < 1e-12);
    }
}
