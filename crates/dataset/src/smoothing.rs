//! Cubic smoothing splines: the smoothest curve that misses the samples by their noise.

use crate::{
    error::DatasetError,
    spline::{CubicSpline, check_knots, divided_difference},
};

/// Doublings and halvings that bracket the penalty, and bisections that follow.
const SEARCH_STEPS: usize = 200;
const RELATIVE_TOLERANCE: f64 = 1e-9;

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
    for _ in 0..SEARCH_STEPS {
        if fit(high)?.2 >= target || high >= largest {
            break;
        }
        (low, high) = (high, high * 8.0);
    }
    for _ in 0..SEARCH_STEPS {
        if high - low <= RELATIVE_TOLERANCE * high || fit(high)?.2 <= target {
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
