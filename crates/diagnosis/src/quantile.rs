//! Quantiles for intervals, by their usual expansions.

/// 97.5 % quantile of the standard normal distribution.
pub(crate) const NORMAL_975: f64 = 1.959_963_984_540_054;

/// χ² with `freedom` degrees over their number, at the normal quantile `z`.
///
/// At ± 1.96 within 1 % from ten degrees on; at three the lower one is 16 % too small, which makes
/// the upper end of a standard deviation 9 % too large.
///
/// # Source
/// Wilson & Hilferty, The distribution of chi-square, PNAS 17 (1931).
pub(crate) fn chi_square_per_freedom(freedom: f64, z: f64) -> f64 {
    let spread = 2.0 / (9.0 * freedom);
    (1.0 - spread + z * spread.sqrt()).max(0.0).powi(3)
}

/// The normal quantile that corresponds to a value of χ² with `freedom` degrees.
pub(crate) fn normal_of_chi_square(value: f64, freedom: f64) -> f64 {
    let spread = 2.0 / (9.0 * freedom);
    ((value / freedom).cbrt() - (1.0 - spread)) / spread.sqrt()
}

/// 97.5 % quantile of Student's t with `freedom` degrees; within 0.5 % for five and more.
///
/// # Source
/// Abramowitz & Stegun, Handbook of mathematical functions (1964), 26.7.5.
pub(crate) fn student_975(freedom: f64) -> f64 {
    let z = NORMAL_975;
    let first = (z.powi(3) + z) / 4.0;
    let second = (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / 96.0;
    let third = (3.0 * z.powi(7) + 19.0 * z.powi(5) + 17.0 * z.powi(3) - 15.0 * z) / 384.0;
    z + first / freedom + second / freedom.powi(2) + third / freedom.powi(3)
}

/// Probability beyond a normal quantile.
pub(crate) fn normal_tail(z: f64) -> f64 {
    0.5 * libm::erfc(z / std::f64::consts::SQRT_2)
}

#[cfg(test)]
mod tests {
    use super::{NORMAL_975, chi_square_per_freedom, normal_of_chi_square, student_975};

    /// Values of printed tables.
    #[test]
    fn quantiles_are_those_of_the_tables() {
        for (freedom, low, high, within) in
            [(3.0, 0.216, 9.348, 0.17), (10.0, 3.247, 20.483, 0.01), (50.0, 32.357, 71.42, 0.001)]
        {
            let of = |z| freedom * chi_square_per_freedom(freedom, z);
            assert!((of(-NORMAL_975) / low - 1.0).abs() < within, "{}", of(-NORMAL_975));
            assert!((of(NORMAL_975) / high - 1.0).abs() < 0.01, "{}", of(NORMAL_975));
            assert!((normal_of_chi_square(of(1.3), freedom) - 1.3).abs() < 1e-12);
        }
        for (freedom, t) in [(5.0, 2.571), (10.0, 2.228), (30.0, 2.042), (1e9, 1.96)] {
            assert!((student_975(freedom) / t - 1.0).abs() < 0.005, "{freedom}");
        }
    }
}
