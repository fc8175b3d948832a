//! Roots of increasing functions, bracketed.

use crate::MechanicsError;

const MAX_ITERATIONS: usize = 200;

/// A point and the function's value there.
pub(crate) type Sample = (f64, f64);

/// The end points of a bracket of at most `tolerance` around the root of an increasing function.
///
/// Illinois steps, every third one a bisection, so that jumps are located too. Where the function
/// vanishes exactly, both ends are that point.
///
/// # Errors
/// The function's own, and `NotConverged`.
pub(crate) fn root_bracket(
    what: &'static str,
    mut low: Sample,
    mut high: Sample,
    tolerance: f64,
    mut function: impl FnMut(f64) -> Result<f64, MechanicsError>,
) -> Result<(Sample, Sample), MechanicsError> {
    let (mut low_weight, mut high_weight) = (1.0, 1.0);
    for iteration in 1..=MAX_ITERATIONS {
        if low.1 >= 0.0 {
            return Ok((low, low));
        }
        if high.1 <= 0.0 {
            return Ok((high, high));
        }
        let width = high.0 - low.0;
        let middle = low.0 + 0.5 * width;
        if width <= tolerance || middle <= low.0 || middle >= high.0 {
            return Ok((low, high));
        }
        let (below, above) = (low_weight * low.1, high_weight * high.1);
        let secant = low.0 - below * width / (above - below);
        let inset = (0.5 * tolerance).min(0.25 * width);
        let point =
            if iteration % 3 == 0 { middle } else { secant.clamp(low.0 + inset, high.0 - inset) };
        let value = function(point)?;
        if value == 0.0 {
            return Ok(((point, value), (point, value)));
        }
        if value < 0.0 {
            low = (point, value);
            (low_weight, high_weight) = (1.0, 0.5 * high_weight);
        } else {
            high = (point, value);
            (low_weight, high_weight) = (0.5 * low_weight, 1.0);
        }
    }
    let residual = high.0 - low.0;
    Err(MechanicsError::NotConverged { what, iterations: MAX_ITERATIONS, residual, tolerance })
}
