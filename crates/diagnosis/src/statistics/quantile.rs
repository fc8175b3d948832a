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

/// 97.5 % quantile of Student's t with `freedom` degrees, within 0.5 %; infinite for none.
///
/// # Source
/// Abramowitz & Stegun, Handbook of mathematical functions (1964), 26.7.5.
pub(crate) fn student_975(freedom: f64) -> f64 {
    let z = NORMAL_975;
    if freedom < EXPANDED {
        return few_975(freedom);
    }
    let first = (z.powi(3) + z) / 4.0;
    let second = (5.0 * z.powi(5) + 16.0 * z.powi(3) + 3.0 * z) / 96.0;
    let third = (3.0 * z.powi(7) + 19.0 * z.powi(5) + 17.0 * z.powi(3) - 15.0 * z) / 384.0;
    z + first / freedom + second / freedom.powi(2) + third / freedom.powi(3)
}

/// Degrees from which the expansion of Student's t is exact enough.
const EXPANDED: f64 = 5.0;

/// 97.5 % quantile of Student's t with few degrees, by halving.
fn few_975(freedom: f64) -> f64 {
    if freedom <= 0.0 {
        return f64::INFINITY;
    }
    let (mut low, mut high) = (0.0, 1.0);
    while student_tail(high, freedom) > 0.025 {
        (low, high) = (high, 2.0 * high);
    }
    while high - low > 1e-6 * high {
        let middle = 0.5 * (low + high);
        match student_tail(middle, freedom) > 0.025 {
            true => low = middle,
            false => high = middle,
        }
    }
    high
}

/// Probability beyond a value of Student's t with `freedom` degrees; 1 for none.
pub(crate) fn student_tail(t: f64, freedom: f64) -> f64 {
    if freedom <= 0.0 {
        return 1.0;
    }
    let both = fisher_tail(t * t, 1.0, freedom);
    if t > 0.0 { 0.5 * both } else { 1.0 - 0.5 * both }
}

/// Probability beyond a value of Fisher's F with `first` and `second` degrees; 1 where either is
/// none.
pub(crate) fn fisher_tail(f: f64, first: f64, second: f64) -> f64 {
    if first <= 0.0 || second <= 0.0 || f <= 0.0 {
        return 1.0;
    }
    incomplete_beta(second / (second + first * f), 0.5 * second, 0.5 * first)
}

/// Iₓ(a, b), the regularised incomplete beta function, for 0 ≤ x ≤ 1.
///
/// # Source
/// Its continued fraction, Abramowitz & Stegun (1964), 26.5.8, by Lentz's method.
fn incomplete_beta(x: f64, a: f64, b: f64) -> f64 {
    if x <= 0.0 || x >= 1.0 {
        return x.clamp(0.0, 1.0);
    }
    // It converges fast below the mean.
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - incomplete_beta(1.0 - x, b, a);
    }
    let log_beta = libm::lgamma(a) + libm::lgamma(b) - libm::lgamma(a + b);
    let front = (a * x.ln() + b * (-x).ln_1p() - log_beta).exp() / a;
    let (mut c, mut d, mut product) = (1.0, 1.0 / (1.0 - (a + b) * x / (a + 1.0)), 1.0);
    product *= d;
    for m in 1..1000 {
        let m = f64::from(m);
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        let before = product;
        for term in [even, odd] {
            (c, d) = (1.0 + term / c, 1.0 / (1.0 + term * d));
            product *= c * d;
        }
        if (product / before - 1.0).abs() < 1e-15 {
            break;
        }
    }
    (front * product).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::{
        NORMAL_975, chi_square_per_freedom, fisher_tail, normal_of_chi_square, student_975,
        student_tail,
    };

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
        let student = [(1.0, 12.706), (2.0, 4.303), (3.0, 3.182), (4.0, 2.776), (5.0, 2.571)];
        for (freedom, t) in student.into_iter().chain([(10.0, 2.228), (30.0, 2.042), (1e9, 1.96)]) {
            assert!((student_975(freedom) / t - 1.0).abs() < 0.005, "{freedom}");
        }
        assert_eq!(student_975(0.0), f64::INFINITY);
    }

    #[test]
    fn tails_are_those_of_the_tables_and_of_closed_forms() {
        for (freedom, t) in [(1.0, 31.821), (3.0, 4.541), (10.0, 2.764), (60.0, 2.390)] {
            assert!((student_tail(t, freedom) / 0.01 - 1.0).abs() < 0.002, "{freedom}");
            assert!((student_tail(-t, freedom) - 0.99).abs() < 2e-5, "{freedom}");
        }
        for (first, second, f) in [(1.0, 9.0, 10.56), (2.0, 9.0, 8.022), (3.0, 20.0, 4.938)] {
            assert!((fisher_tail(f, first, second) / 0.01 - 1.0).abs() < 0.002, "{first} {second}");
        }
        // With two degrees above, (1 + 2f/d)^(−d/2).
        for (second, f) in [(4.0, 0.3_f64), (40.0, 25.0), (400.0, 2.0), (7.0, 1e-3)] {
            let exact = (1.0 + 2.0 * f / second).powf(-0.5 * second);
            assert!((fisher_tail(f, 2.0, second) / exact - 1.0).abs() < 1e-10, "{second} {f}");
        }
        assert_eq!([fisher_tail(9.0, 1.0, 0.0), fisher_tail(0.0, 1.0, 5.0)], [1.0, 1.0]);
    }
}
