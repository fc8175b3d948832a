//! Cubic smoothing splines: the likeliest smooth curve through samples of known noise.

use std::sync::Arc;

use crate::curves::banded::Banded;
use crate::curves::spline::{CubicSpline, check_knots, divided_difference};
use crate::error::DatasetError;

/// Precision of the penalty's logarithm: the curve hardly depends on it.
const LOG_TOLERANCE: f64 = 1e-3;

/// The linear map from samples to the natural spline that minimises
/// Σ (yᵢ − f(tᵢ))² + λ ∫ f″² dt, for fixed times and penalty.
///
/// With the second derivatives γ at the inner knots, (R + λ QᵀQ) γ = Qᵀy and f(tᵢ) = y − λ Q γ.
///
/// # Source
/// Reinsch (1967), "Smoothing by spline functions".
#[derive(Clone, Debug)]
pub struct Smoother {
    t: Arc<[f64]>,
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
        Ok(Self { t: t.into(), penalty, system: Banded::new(t, penalty) })
    }

    /// The spline for samples y at the smoother's times. Cost O(N).
    ///
    /// # Errors
    /// `SplineKnots` for another number of samples or one that is not finite.
    pub fn fit(&self, y: &[f64]) -> Result<CubicSpline, DatasetError> {
        self.fit_columns([y]).map(|[spline]| spline)
    }

    /// The splines for several columns of samples at once.
    ///
    /// # Errors
    /// As [`Self::fit`].
    pub(crate) fn fit_columns<const K: usize>(
        &self,
        columns: [&[f64]; K],
    ) -> Result<[CubicSpline; K], DatasetError> {
        for y in columns {
            check_knots(&self.t, y)?;
        }
        let n = self.t.len();
        let mut solved: Vec<_> = (1..n - 1)
            .map(|i| {
                let width = self.t[i + 1] - self.t[i - 1];
                columns.map(|y| divided_difference(&self.t, y, i) * width)
            })
            .collect();
        self.system.solve(&mut solved);
        Ok(std::array::from_fn(|k| {
            let mut curvature = vec![0.0; n];
            for (curvature, solved) in curvature[1..].iter_mut().zip(&solved) {
                *curvature = solved[k];
            }
            let mut values = columns[k].to_vec();
            if self.penalty > 0.0 {
                let spread = self.spread(&curvature[1..n - 1]);
                for (value, spread) in values.iter_mut().zip(&spread) {
                    *value -= self.penalty * spread;
                }
            }
            CubicSpline::from_curvature(self.t.clone(), values, curvature)
        }))
    }

    /// Standard deviation of the fitted value at time t, in units of the samples' noise.
    ///
    /// It is the norm of the row of the spline's hat matrix that belongs to t; none outside the
    /// knots. Cost O(N), for penalty 0 O(1): there a sample's influence at least halves from knot to
    /// knot, and far ones are left out.
    #[must_use]
    pub fn noise_gain(&self, t: f64) -> Option<f64> {
        const REACH: usize = 40;
        let n = self.t.len();
        if !(self.t[0]..=self.t[n - 1]).contains(&t) {
            return None;
        }
        let i = self.t.partition_point(|&knot| knot <= t).clamp(1, n - 1) - 1;
        if self.penalty == 0.0 && n > 2 * REACH + 2 {
            let near = i.saturating_sub(REACH)..(i + REACH + 2).min(n);
            return Self::new(&self.t[near], 0.0).ok()?.noise_gain(t);
        }
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
        self.system.solve(right.as_chunks_mut::<1>().0);
        let spread = self.spread(&right);
        let squared: f64 = on_values.iter().zip(&spread).map(|(a, q)| (a + q).powi(2)).sum();
        Some(squared.sqrt())
    }

    /// Standard deviation of the fitted value at time t, in units of the samples' noise, when the
    /// smoothed curve is as rough as the penalty supposes: its bias counts as well as the noise.
    ///
    /// It is √Hᵢᵢ at the knots, H the hat matrix, and on a line between them; none outside. For
    /// penalty 0 it is 1. Cost O(N).
    ///
    /// # Source
    /// Wahba (1983), "Bayesian 'confidence intervals' for the cross-validated smoothing spline".
    #[must_use]
    pub fn error_gain(&self, t: f64) -> Option<f64> {
        let n = self.t.len();
        if !(self.t[0]..=self.t[n - 1]).contains(&t) {
            return None;
        }
        let bands = self.system.inverse_bands();
        let i = self.t.partition_point(|&knot| knot <= t).clamp(1, n - 1) - 1;
        let b = (t - self.t[i]) / (self.t[i + 1] - self.t[i]);
        let variance = (1.0 - b) * self.leverage(&bands, i) + b * self.leverage(&bands, i + 1);
        Some(variance.max(0.0).sqrt())
    }

    /// Hᵢᵢ = 1 − λ (Q B⁻¹ Qᵀ)ᵢᵢ, with the central diagonals of B⁻¹.
    fn leverage(&self, bands: &[Vec<f64>; 3], i: usize) -> f64 {
        let n_inner = self.t.len() - 2;
        let h = |k: usize| self.t[k + 1] - self.t[k];
        // Row i of Q: its columns are the inner knots i − 1, i and i + 1, counted from −1.
        let weight = |column: usize| match i + 1 - column {
            0 => 0.0,
            1 => 1.0 / h(i),
            2 => -1.0 / h(i - 1) - 1.0 / h(i),
            _ => 1.0 / h(i - 1),
        };
        let columns = i.saturating_sub(2)..(i + 1).min(n_inner);
        let mut sum = 0.0;
        for a in columns.clone() {
            for b in columns.clone() {
                sum += weight(a) * weight(b) * bands[a.abs_diff(b)][a.min(b)];
            }
        }
        1.0 - self.penalty * sum
    }

    /// −2 log of the restricted likelihood of the samples, up to a constant.
    ///
    /// Under the prior of the spline the changes of slope Qᵀy are normal with variance (σ²/λ) B.
    fn misfit(&self, y: &[f64], noise_sd: f64) -> f64 {
        let right: Vec<_> = (1..self.t.len() - 1)
            .map(|i| divided_difference(&self.t, y, i) * (self.t[i + 1] - self.t[i - 1]))
            .collect();
        let mut solved = right.clone();
        self.system.solve(solved.as_chunks_mut::<1>().0);
        let squares: f64 = right.iter().zip(&solved).map(|(a, b)| a * b).sum();
        let scale = self.penalty / (noise_sd * noise_sd);
        scale * squares + self.system.log_determinant() - right.len() as f64 * self.penalty.ln()
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

/// The smoothing spline with the penalty under which the samples are likeliest, with its smoother.
///
/// The curve is taken for an integrated Wiener process of unknown strength plus white noise; the
/// strength is the one of largest restricted likelihood. With `noise_sd` 0 the spline interpolates;
/// where the samples show no bend at all it is the limit of a large penalty, a line.
///
/// # Errors
/// `SplineKnots` as in [`Smoother::new`], or for a noise that is negative or not finite.
///
/// # Source
/// Wahba (1985), "A comparison of GCV and GML for choosing the smoothing parameter".
pub fn smooth(
    t: &[f64],
    y: &[f64],
    noise_sd: f64,
) -> Result<(CubicSpline, Smoother), DatasetError> {
    if !(noise_sd >= 0.0 && noise_sd.is_finite()) {
        let what = format!("noise_sd must be finite and not negative, got {noise_sd}");
        return Err(DatasetError::SplineKnots { what });
    }
    check_knots(t, y)?;
    if noise_sd == 0.0 || t.len() == 2 {
        let smoother = Smoother::new(t, 0.0)?;
        return Ok((smoother.fit(y)?, smoother));
    }
    let misfit = |log_penalty: f64| {
        Smoother::new(t, log_penalty.exp()).map(|smoother| smoother.misfit(y, noise_sd))
    };
    let span = t[t.len() - 1] - t[0];
    let spacing = span / (t.len() - 1) as f64;
    let (lowest, highest) = ((1e-6 * spacing.powi(3)).ln(), (1e6 * span.powi(3)).ln());
    let log_penalty = minimum(&misfit, lowest, highest)?;
    let smoother = Smoother::new(t, log_penalty.exp())?;
    Ok((smoother.fit(y)?, smoother))
}

/// Where a function is smallest: the best of a scan, refined by golden sections. Of equals the
/// largest argument counts.
fn minimum(
    function: &impl Fn(f64) -> Result<f64, DatasetError>,
    low: f64,
    high: f64,
) -> Result<f64, DatasetError> {
    const N_SCAN: usize = 24;
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let spacing = (high - low) / N_SCAN as f64;
    let (mut best, mut least) = (high, function(high)?);
    for k in (0..N_SCAN).rev() {
        let at = low + k as f64 * spacing;
        let value = function(at)?;
        // A flat end is flat to rounding only.
        if value < least - 1e-9 * least.abs() {
            (best, least) = (at, value);
        }
    }
    if best == high {
        return Ok(high);
    }
    let (mut a, mut b) = ((best - spacing).max(low), (best + spacing).min(high));
    let (mut x1, mut x2) = (b - GOLDEN * (b - a), a + GOLDEN * (b - a));
    let (mut f1, mut f2) = (function(x1)?, function(x2)?);
    while b - a > LOG_TOLERANCE {
        if f1 < f2 {
            (b, x2, f2) = (x2, x1, f1);
            x1 = b - GOLDEN * (b - a);
            f1 = function(x1)?;
        } else {
            (a, x1, f1) = (x1, x2, f2);
            x2 = a + GOLDEN * (b - a);
            f2 = function(x2)?;
        }
    }
    Ok(f64::midpoint(a, b))
}

#[cfg(test)]
mod tests {
    use super::{Smoother, smooth};
    use crate::curves::spline::{CubicSpline, EndCondition};

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

    /// White uniform noise of standard deviation 1, from mixed bits.
    fn noise(seed: u64) -> f64 {
        let mixed = (seed + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        let mixed = (mixed ^ (mixed >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        12f64.sqrt() * ((mixed ^ (mixed >> 32)) as f64 / 2f64.powi(64) - 0.5)
    }

    #[test]
    fn the_penalty_is_the_likeliest() {
        for noise_sd in [0.05, 0.3, 0.6] {
            let (_, best) = smooth(&T, &Y, noise_sd).unwrap();
            let least = best.misfit(&Y, noise_sd);
            for factor in [0.25, 0.8, 1.25, 4.0] {
                let other = Smoother::new(&T, factor * best.penalty).unwrap();
                assert!(other.misfit(&Y, noise_sd) > least, "{noise_sd} {factor}");
            }
        }
    }

    #[test]
    fn the_stated_error_is_the_actual_one() {
        let t: Vec<f64> = (0..80).map(|i| i as f64 * 0.02).collect();
        // A bend that hardly rises above the noise is taken for a line now and then.
        for (bend, largest) in [(0.3, 1.5), (2.0, 1.2), (8.0, 1.2)] {
            let truth = |t: f64| (bend * t).sin();
            let mut squares = 0.0;
            for seed in 0..60 {
                let y: Vec<f64> = t
                    .iter()
                    .enumerate()
                    .map(|(i, &t)| truth(t) + 0.01 * noise(seed * 80 + i as u64))
                    .collect();
                let (spline, smoother) = smooth(&t, &y, 0.01).unwrap();
                for at in [0.0, 0.11, 0.4, 0.8, 1.23, 1.58] {
                    let sd = 0.01 * smoother.error_gain(at).unwrap();
                    squares += ((spline.value(at).unwrap() - truth(at)) / sd).powi(2) / 360.0;
                }
            }
            assert!((0.8..largest).contains(&squares.sqrt()), "{bend}: {}", squares.sqrt());
        }
    }

    #[test]
    fn error_gain_at_the_knots_is_the_response_to_their_own_sample() {
        for penalty in [0.0, 0.03, 2.0] {
            let smoother = Smoother::new(&T, penalty).unwrap();
            for k in 0..8 {
                let mut unit = [0.0; 8];
                unit[k] = 1.0;
                let own = smoother.fit(&unit).unwrap().value(T[k]).unwrap();
                let gain = smoother.error_gain(T[k]).unwrap();
                assert!((gain - own.sqrt()).abs() < 1e-12, "{penalty} {k}: {gain} {own}");
            }
            assert_eq!(smoother.error_gain(5.6), None);
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
    fn far_samples_do_not_count_without_penalty() {
        let t: Vec<f64> = (0..200).map(|i| f64::from(i) + 0.3 * f64::from(i % 3)).collect();
        let smoother = Smoother::new(&t, 0.0).unwrap();
        let at = 100.4;
        let squared: f64 = (0..200)
            .map(|k| {
                let mut unit = [0.0; 200];
                unit[k] = 1.0;
                smoother.fit(&unit).unwrap().value(at).unwrap().powi(2)
            })
            .sum();
        let gain = smoother.noise_gain(at).unwrap();
        assert!((gain - squared.sqrt()).abs() < 1e-12, "{gain} {}", squared.sqrt());
    }

    #[test]
    fn negative_noise_is_refused() {
        let message = smooth(&T, &Y, -1.0).unwrap_err().to_string();
        assert!(message.contains("noise_sd must be finite and not negative, got -1"), "{message}");
    }
}
