//! Robust estimates of a stream's noise and of its center.

/// Turns a median of absolute deviations into the standard deviation of a normal distribution.
pub(crate) const NORMAL_SD_OVER_MAD: f64 = 1.482_602_218_505_602;

/// The median; none of an empty list. For an even number, the mean of the middle two.
pub(crate) fn median(values: &[f64]) -> Option<f64> {
    if values.is_empty() {
        return None;
    }
    let mut values = values.to_vec();
    let is_odd = values.len() % 2 == 1;
    let middle = values.len() / 2;
    let (below, upper, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    let lower = below.iter().copied().max_by(f64::total_cmp);
    Some(lower.filter(|_| !is_odd).map_or(*upper, |lower| 0.5 * (lower + *upper)))
}

/// The mean; none of an empty list.
pub(crate) fn mean(values: &[f64]) -> Option<f64> {
    if values.is_empty() { None } else { Some(values.iter().sum::<f64>() / values.len() as f64) }
}

/// Standard deviation of the white noise on samples y(t) of a slowly bending curve.
///
/// Each sample is compared with the line through its two neighbors; the spread of these
/// differences is taken robustly (median of absolute values), so that jumps do not count. None for
/// fewer than five samples.
pub(crate) fn noise_sd(t: &[f64], y: &[f64]) -> Option<f64> {
    if t.len() < 5 {
        return None;
    }
    let misses: Vec<_> = (1..t.len() - 1)
        .map(|i| {
            let b = (t[i] - t[i - 1]) / (t[i + 1] - t[i - 1]);
            let a = 1.0 - b;
            ((y[i] - a * y[i - 1] - b * y[i + 1]) / (1.0 + a * a + b * b).sqrt()).abs()
        })
        .collect();
    median(&misses).map(|mad| NORMAL_SD_OVER_MAD * mad)
}
