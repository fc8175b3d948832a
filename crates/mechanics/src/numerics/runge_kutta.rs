//! One step of the embedded Runge–Kutta pair of orders 5 and 4.

use nalgebra::SVector;

/// The result of a step.
pub(crate) struct Step<const N: usize> {
    /// The state at the end, of order 5.
    pub(crate) end: SVector<f64, N>,
    /// Its difference from the solution of order 4.
    pub(crate) error: SVector<f64, N>,
}

const NODES: [f64; 7] = [0.0, 1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0, 1.0];
pub(crate) const STAGES: [[f64; 6]; 7] = [
    [0.0; 6],
    [1.0 / 5.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    [3.0 / 40.0, 9.0 / 40.0, 0.0, 0.0, 0.0, 0.0],
    [44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0, 0.0, 0.0, 0.0],
    [19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0, 0.0, 0.0],
    [9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0, 0.0],
    [35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];
pub(crate) const ERROR: [f64; 7] = [
    71.0 / 57600.0,
    0.0,
    -71.0 / 16695.0,
    71.0 / 1920.0,
    -17253.0 / 339_200.0,
    22.0 / 525.0,
    -1.0 / 40.0,
];

/// A step of length `h` from `start` at `time`, where the derivative is `first`.
///
/// # Errors
/// Those of the derivative.
///
/// # Source
/// Dormand & Prince (1980), "A family of embedded Runge-Kutta formulae".
#[inline]
pub(crate) fn step<const N: usize, E>(
    time: f64,
    start: &SVector<f64, N>,
    first: &SVector<f64, N>,
    h: f64,
    mut derivative: impl FnMut(f64, &SVector<f64, N>) -> Result<SVector<f64, N>, E>,
) -> Result<Step<N>, E> {
    let mut slopes = [*first; 7];
    let mut end = *start;
    for stage in 1..7 {
        let mut sum = SVector::zeros();
        for (weight, slope) in STAGES[stage].iter().zip(&slopes[..stage]) {
            sum += *weight * slope;
        }
        end = start + h * sum;
        slopes[stage] = derivative(time + NODES[stage] * h, &end)?;
    }
    let mut error = SVector::zeros();
    for (weight, slope) in ERROR.iter().zip(&slopes) {
        error += h * *weight * slope;
    }
    Ok(Step { end, error })
}

#[cfg(test)]
mod tests {
    use super::step;
    use crate::MechanicsError;
    use nalgebra::SVector;

    #[test]
    fn halving_the_step_divides_the_error_of_a_step_by_two_to_the_sixth() {
        let error_of = |h: f64| {
            let start = SVector::<f64, 1>::new(1.0);
            let decay = |_: f64, x: &SVector<f64, 1>| Ok::<_, MechanicsError>(-x);
            let end = step(0.0, &start, &-start, h, decay).unwrap().end[0];
            (end - (-h).exp()).abs()
        };
        let ratio = error_of(0.2) / error_of(0.1);
        assert!((55.0..75.0).contains(&ratio), "{ratio}");
    }
}
