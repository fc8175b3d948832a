//! Cubic smoothing splines: the smoothest curve that misses the samples by their noise.

use crate::{
    error::DatasetError,
    spline::{CubicSpline, check_knots, divided_difference},
};

/// Bisections of the penalty; noise far below the samples' rounding needs the most.
const LARGEST_STEPS: usize = 200;
const RELATIVE_TOLERANCE: f64 = 1e-6;

/// The linear map from samples to the natural spline that minimises
/// Σ (yᵢ − f(tᵢ))² + λ ∫ f″² dt, for fixed times and penalty.
///
/// With the second derivatives γ at the inner knots, (R + λ QᵀQ) γ = Qᵀy and f(tᵢ) = y − λ Q γ.
///
/// # Source
/// Reinsch (1967), "Smoothing by spline functions".
#[derive(Clone, Debug)]
pub struct Smoother {
    t: Vec<f64>,
    penalty: f64,
    system: Banded,
}

impl Smoother {
    /// A smoother over increasing times (s); penalty 0 interpolates.
    ///
    /// # Errors
    /// `SplineKnots` for fewer than two times, times that do not increase, or a penalty that is
    /// negative or not finite.
    pub fn new(t: &[f64], penalty: f64) -> Result<Self, DatasetError> {
        check_knots(t, t)?;
        if !(penalty >= 0.0 && penalty.is_finite()) {
            let what = format!("penalty must be finite and not negative, got {penalty}");
            return Err(DatasetError::SplineKnots { what });
        }
        Ok(Self { t: t.to_vec(), penalty, system: Banded::new(t, penalty) })
    }

    /// The spline for samples y at the smoother's times. Cost O(N).
    ///
    /// # Errors
    /// `SplineKnots` for another number of samples or one that is not finite.
    pub fn fit(&self, y: &[f64]) -> Result<CubicSpline, DatasetError> {
        check_knots(&self.t, y)?;
        let n = self.t.len();
        let mut right: Vec<_> = (1..n - 1)
            .map(|i| divided_difference(&self.t, y, i) * (self.t[i + 1] - self.t[i - 1]))
            .collect();
        self.system.solve(&mut right);
        let mut curvature = vec![0.0; n];
        curvature[1..n - 1].copy_from_slice(&right);
        let spread = self.spread(&right);
        let values = y.iter().zip(&spread).map(|(y, q)| y - self.penalty * q).collect();
        Ok(CubicSpline::from_curvature(self.t.clone(), values, curvature))
    }

    /// Standard deviation of the fitted value at time t, in units of the samples' noise.
    ///
    /// It is the norm of the row of the spline's hat matrix that belongs to t; none outside the
    /// knots. Cost O(N).
    #[must_use]
    pub fn noise_gain(&self, t: f64) -> Option<f64> {
        let n = self.t.len();
        if !(self.t[0]..=self.t[n - 1]).contains(&t) {
            return None;
        }
        let i = self.t.partition_point(|&knot| knot <= t).clamp(1, n - 1) - 1;
        let h = self.t[i + 1] - self.t[i];
        let b = (t - self.t[i]) / h;
        let a = 1.0 - b;
        let mut on_values = vec![0.0; n];
        (on_values[i], on_values[i + 1]) = (a, b);
        let mut right: Vec<_> = (1..n - 1)
            .map(|k| {
                let difference = divided_difference(&self.t, &on_values, k);
                -self.penalty * difference * (self.t[k + 1] - self.t[k - 1])
            })
            .collect();
        for (knot, weight) in [(i, a), (i + 1, b)] {
            if (1..n - 1).contains(&knot) {
                right[knot - 1] += (weight.powi(3) - weight) * h * h / 6.0;
            }
        }
        self.system.solve(&mut right);
        let spread = self.spread(&right);
        let squared: f64 = on_values.iter().zip(&spread).map(|(a, q)| (a + q).powi(2)).sum();
        Some(squared.sqrt())
    }

    /// Q γ, with γ at the inner knots.
    fn spread(&self, inner: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; self.t.len()];
        for (k, gamma) in inner.iter().enumerate() {
            let left = gamma / (self.t[k + 1] - self.t[k]);
            let right = gamma / (self.t[k + 2] - self.t[k + 1]);
            out[k] += left;
            out[k + 1] -= left + right;
            out[k + 2] += right;
        }
        out
    }
}

/// The smoothing spline whose mean squared miss is the square of `noise_sd`, with its smoother.
///
/// The penalty is found by bisection. Where even a straight line misses by less, the spline is the
/// limit of a large penalty, a line; with `noise_sd` 0 it interpolates.
///
/// # Errors
/// `SplineKnots` as in [`Smoother::new`], or for a noise that is negative or not finite.
pub fn smooth(
    t: &[f64],
    y: &[f64],
    noise_sd: f64,
) -> Result<(CubicSpline, Smoother), DatasetError> {
    if !(noise_sd >= 0.0 && noise_sd.is_finite()) {
        let what = format!("noise_sd must be finite and not negative, got {noise_sd}");
        return Err(DatasetError::SplineKnots { what });
    }
    let fit = |penalty: f64| {
        let smoother = Smoother::new(t, penalty)?;
        let spline = smoother.fit(y)?;
        let misses = spline.knot_values().iter().zip(y).map(|(f, y)| (f - y).powi(2));
        let mean_square = misses.sum::<f64>() / y.len() as f64;
        Ok::<_, DatasetError>((spline, smoother, mean_square))
    };
    let target = noise_sd * noise_sd;
    let (spline, smoother, _) = fit(0.0)?;
    if noise_sd == 0.0 || t.len() == 2 {
        return Ok((spline, smoother));
    }
    let spacing = (t[t.len() - 1] - t[0]) / (t.len() - 1) as f64;
    let largest = (t[t.len() - 1] - t[0]).powi(3) * 1e6;
    let (mut low, mut high) = (0.0, spacing.powi(3));
    while fit(high)?.2 < target {
        if high >= largest {
            let (line, smoother, _) = fit(high)?;
            return Ok((line, smoother));
        }
        (low, high) = (high, high * 8.0);
    }
    for _ in 0..LARGEST_STEPS {
        if high - low <= RELATIVE_TOLERANCE * high {
            break;
        }
        let middle = if low > 0.0 { (low * high).sqrt() } else { high / 8.0 };
        if fit(middle)?.2 < target {
            low = middle;
        } else {
            high = middle;
        }
    }
    let (spline, smoother, _) = fit(high)?;
    Ok((spline, smoother))
}

/// LDLᵀ of the positive definite five-diagonal matrix R + λ QᵀQ.
#[derive(Clone, Debug)]
struct Banded {
    diagonal: Vec<f64>,
    first: Vec<f64>,
    second: Vec<f64>,
}

impl Banded {
    fn new(t: &[f64], penalty: f64) -> Self {
        let n = t.len().saturating_sub(2);
        let h = |k: usize| t[k + 1] - t[k];
        let q = |k: usize| (1.0 / h(k), -1.0 / h(k) - 1.0 / h(k + 1), 1.0 / h(k + 1));
        let mut diagonal = vec![0.0; n];
        let mut first = vec![0.0; n];
        let mut second = vec![0.0; n];
        for k in 0..n {
            let (a, b, c) = q(k);
            let mut d = (h(k) + h(k + 1)) / 3.0 + penalty * (a * a + b * b + c * c);
            let mut e = if k + 1 < n {
                let (next_a, next_b, _) = q(k + 1);
                h(k + 1) / 6.0 + penalty * (b * next_a + c * next_b)
            } else {
                0.0
            };
            let f = if k + 2 < n { penalty * c / h(k + 2) } else { 0.0 };
            if k >= 1 {
                d -= first[k - 1] * first[k - 1] * diagonal[k - 1];
                e -= first[k - 1] * second[k - 1] * diagonal[k - 1];
            }
            if k >= 2 {
                d -= second[k - 2] * second[k - 2] * diagonal[k - 2];
            }
            diagonal[k] = d;
            first[k] = e / d;
            second[k] = f / d;
        }
        Self { diagonal, first, second }
    }

    fn solve(&self, x: &mut [f64]) {
        let n = x.len();
        for i in 0..n {
            if i >= 1 {
                x[i] -= self.first[i - 1] * x[i - 1];
            }
            if i >= 2 {
                x[i] -= self.second[i - 2] * x[i - 2];
            }
        }
        for i in (0..n).rev() {
            x[i] /= self.diagonal[i];
            if i + 1 < n {
                x[i] -= self.first[i] * x[i + 1];
            }
            if i + 2 < n {
                x[i] -= self.second[i] * x[i + 2];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Smoother, smooth};
    use crate::spline::{CubicSpline, EndCondition};

    const T: [f64; 8] = [0.0, 0.3, 1.1, 1.25, 2.0, 3.7, 4.0, 5.5];
    const Y: [f64; 8] = [1.0, 2.0, -0.5, 0.25, 3.0, -1.0, 0.5, 0.75];
    const AT: [f64; 6] = [0.1, 0.77, 1.2, 2.9, 3.85, 5.0];

    /// SciPy 1.17.1: `s = make_smoothing_spline(T, Y, lam=lam); s(at), s(at, 1), s(at, 2)`.
    #[test]
    fn smoothing_matches_scipy() {
        let cases = [
            (
                0.01,
                [
                    [1.3907543993887068, 0.5163246652977137, -3.281825156699371],
                    [0.4198346686323563, -2.251739652268708, 3.6525637471761057],
                    [0.16070186265629816, 1.7001275314169653, 10.5252684519578],
                    [1.0750620425140025, -3.2905868031078915, 0.17600251865315064],
                    [-0.23835968810690794, 1.8265048535949657, 3.6178888767239323],
                    [0.8429827574743554, 0.008135028062220329, -0.9391961758593439],
                ],
            ),
            (
                0.5,
                [
                    [1.1706229154681522, -0.3461673901589166, -0.04102058384091789],
                    [0.9400673732910932, -0.26691676026060707, 0.5301207448617846],
                    [0.8922555800730555, 0.07562580857337196, 0.8498784766456666],
                    [0.6252561833052522, -0.6400890830425814, -0.07348243907615948],
                    [0.16654196946284483, -0.15621582324220032, 0.7891370356118363],
                    [0.3430158805646958, 0.36451912320666235, 0.2074380533833594],
                ],
            ),
        ];
        for (penalty, expected) in cases {
            let spline = Smoother::new(&T, penalty).unwrap().fit(&Y).unwrap();
            for (at, want) in AT.iter().zip(expected) {
                let got =
                    [spline.value(*at), spline.derivative(*at), spline.second_derivative(*at)];
                for (got, want) in got.into_iter().zip(want) {
                    assert!((got.unwrap() - want).abs() < 1e-11, "{at}: {got:?} {want}");
                }
            }
        }
    }

    #[test]
    fn the_mean_square_miss_is_the_noise() {
        for noise_sd in [0.01, 0.2, 0.6] {
            let (spline, _) = smooth(&T, &Y, noise_sd).unwrap();
            let misses = spline.knot_values().iter().zip(Y).map(|(f, y)| (f - y).powi(2));
            let sd = (misses.sum::<f64>() / 8.0).sqrt();
            assert!((sd - noise_sd).abs() < 1e-5 * noise_sd, "{sd} {noise_sd}");
        }
    }

    #[test]
    fn without_noise_it_is_the_natural_spline() {
        let (smoothed, _) = smooth(&T, &Y, 0.0).unwrap();
        let natural = CubicSpline::interpolate(&T, &Y, EndCondition::Natural).unwrap();
        for at in AT {
            let difference = smoothed.value(at).unwrap() - natural.value(at).unwrap();
            assert!(difference.abs() < 1e-13, "{at}: {difference}");
        }
    }

    #[test]
    fn noise_beyond_all_structure_leaves_the_regression_line() {
        let (spline, _) = smooth(&T, &Y, 10.0).unwrap();
        let mean_t = T.iter().sum::<f64>() / 8.0;
        let mean_y = Y.iter().sum::<f64>() / 8.0;
        let slope = T.iter().zip(Y).map(|(t, y)| (t - mean_t) * (y - mean_y)).sum::<f64>()
            / T.iter().map(|t| (t - mean_t).powi(2)).sum::<f64>();
        for at in AT {
            let line = mean_y + slope * (at - mean_t);
            assert!((spline.value(at).unwrap() - line).abs() < 1e-6, "{at}");
        }
    }

    #[test]
    fn noise_gain_is_the_norm_of_the_response_to_single_samples() {
        for penalty in [0.0, 0.03, 2.0] {
            let smoother = Smoother::new(&T, penalty).unwrap();
            for at in AT {
                let squared: f64 = (0..8)
                    .map(|k| {
                        let mut unit = [0.0; 8];
                        unit[k] = 1.0;
                        smoother.fit(&unit).unwrap().value(at).unwrap().powi(2)
                    })
                    .sum();
                let gain = smoother.noise_gain(at).unwrap();
                assert!((gain - squared.sqrt()).abs() < 1e-12, "{penalty} {at}: {gain}");
            }
            assert_eq!(smoother.noise_gain(-0.1), None);
        }
    }

    #[test]
    fn negative_noise_is_refused() {
        let message = smooth(&T, &Y, -1.0).unwrap_err().to_string();
        assert!(message.contains("noise_sd must be finite and not negative, got -1"), "{message}");
    }
}
