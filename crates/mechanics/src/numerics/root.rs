//! Roots of increasing functions, bracketed.

use crate::MechanicsError;

const MAX_ITERATIONS: usize = 200;

/// A point and the function's value there.
pub(crate) type Sample = (f64, f64);

/// The end points of a bracket of at most `tolerance` around the root of an increasing function.
///
/// Illinois steps, every third one a bisection, so that jumps are located too. Where the function
/// vanishes exactly, an end of the given bracket included, both ends are that point.
///
/// # Errors
/// The function's own; `NoSignChange` for a bracket at whose lower end the function is positive, at
/// whose upper end it is negative, or where it is no number; `NotConverged`.
pub(crate) fn root_bracket(
    what: &'static str,
    mut low: Sample,
    mut high: Sample,
    tolerance: f64,
    mut function: impl FnMut(f64) -> Result<f64, MechanicsError>,
) -> Result<(Sample, Sample), MechanicsError> {
    let (mut low_weight, mut high_weight) = (1.0, 1.0);
    for iteration in 1..=MAX_ITERATIONS {
        if low.1 == 0.0 {
            return Ok((low, low));
        }
        if high.1 == 0.0 {
            return Ok((high, high));
        }
        if !(low.1 < 0.0 && high.1 > 0.0) {
            let (from, to) = ([low.0, low.1], [high.0, high.1]);
            return Err(MechanicsError::NoSignChange { what, from, to });
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
        if value <= 0.0 {
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

#[cfg(test)]
mod tests {
    use super::root_bracket;
    use crate::MechanicsError;

    #[test]
    fn a_bracket_without_a_change_of_sign_is_an_error_and_an_exact_zero_at_its_end_is_none() {
        let between = |low: f64, high: f64| {
            let line = |x: f64| x - 1.0;
            root_bracket("x", (low, line(low)), (high, line(high)), 1e-12, |x| Ok(line(x)))
        };
        let no_root = |from, to| Err(MechanicsError::NoSignChange { what: "x", from, to });
        assert_eq!(between(2.0, 3.0), no_root([2.0, 1.0], [3.0, 2.0]));
        assert_eq!(between(-1.0, 0.5), no_root([-1.0, -2.0], [0.5, -0.5]));
        assert_eq!(between(1.0, 3.0), Ok(((1.0, 0.0), (1.0, 0.0))));
        assert_eq!(between(0.0, 1.0), Ok(((1.0, 0.0), (1.0, 0.0))));
        let (low, high) = between(0.25, 3.0).unwrap();
        assert!(low.0 <= 1.0 && high.0 >= 1.0 && high.0 - low.0 <= 1e-12);
    }

    #[test]
    fn a_function_that_is_no_number_is_an_error() {
        let step = |x: f64| Ok(if x < 0.4 { -1.0 } else { f64::NAN });
        let found = root_bracket("x", (0.0, -1.0), (1.0, 1.0), 1e-12, step);
        assert!(matches!(found, Err(MechanicsError::NoSignChange { .. })), "{found:?}");
        let ends = root_bracket("x", (0.0, f64::NAN), (1.0, 1.0), 1e-12, Ok);
        assert!(matches!(ends, Err(MechanicsError::NoSignChange { .. })), "{ends:?}");
    }
}
