//! C² cubic splines of one variable: interpolating or smoothing, with derivatives.
//!
//! The evaluator is our own: the `splines` crate has no C² spline (its cubic is Catmull–Rom on
//! uniform knots) and no derivatives, which twists need; a natural spline can be handed to it as
//! Bézier keys, but the tridiagonal solve, which is most of the work, stays ours all the same.

use std::sync::Arc;

use crate::error::DatasetError;

/// What closes the system of a cubic spline at its two ends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum EndCondition {
    /// No curvature at the ends: right for a body that starts and ends at rest.
    #[default]
    Natural,
    /// The first two and the last two pieces are one cubic each.
    NotAKnot,
}

/// A piecewise cubic y(t) with continuous second derivative over increasing knots.
#[derive(Clone, Debug, PartialEq)]
pub struct CubicSpline {
    t: Arc<[f64]>,
    y: Vec<f64>,
    curvature: Vec<f64>,
}

impl CubicSpline {
    /// The spline through all points (tᵢ, yᵢ), which may be spaced unevenly.
    ///
    /// Two points give a line and, with `NotAKnot`, three a parabola. Cost O(N).
    ///
    /// # Errors
    /// `SplineKnots` for fewer than two points, unequal lengths, values that are not finite or
    /// knots that do not increase.
    pub fn interpolate(t: &[f64], y: &[f64], ends: EndCondition) -> Result<Self, DatasetError> {
        check_knots(t, y)?;
        let curvature = match (ends, t.len()) {
            (EndCondition::NotAKnot, 3) => vec![2.0 * divided_difference(t, y, 1); 3],
            (EndCondition::NotAKnot, 4..) => not_a_knot_curvature(t, y),
            _ => natural_curvature(t, y),
        };
        Ok(Self { t: t.into(), y: y.to_vec(), curvature })
    }

    /// A spline from its values and second derivatives at the knots, already known to fit.
    pub(crate) fn from_curvature(t: Arc<[f64]>, y: Vec<f64>, curvature: Vec<f64>) -> Self {
        Self { t, y, curvature }
    }

    /// First and last knot.
    #[must_use]
    pub fn span(&self) -> (f64, f64) {
        (self.t[0], self.t[self.t.len() - 1])
    }

    /// The knots.
    #[must_use]
    pub fn knots(&self) -> &[f64] {
        &self.t
    }

    /// The values at the knots.
    pub(crate) fn values(&self) -> &[f64] {
        &self.y
    }

    /// y(t); none outside the knots.
    #[must_use]
    pub fn value(&self, t: f64) -> Option<f64> {
        self.place(t).map(|place| self.value_at(&place))
    }

    /// dy/dt; none outside the knots.
    #[must_use]
    pub fn derivative(&self, t: f64) -> Option<f64> {
        self.place(t).map(|place| self.derivative_at(&place))
    }

    /// d²y/dt²; none outside the knots.
    #[must_use]
    pub fn second_derivative(&self, t: f64) -> Option<f64> {
        let Place { i, a, b, .. } = self.place(t)?;
        Some(a * self.curvature[i] + b * self.curvature[i + 1])
    }

    /// Where t lies among the knots: the same for all splines over them; none outside.
    pub(crate) fn place(&self, t: f64) -> Option<Place> {
        let i = interval(&self.t, t)?;
        let h = self.t[i + 1] - self.t[i];
        let b = (t - self.t[i]) / h;
        let a = 1.0 - b;
        Some(Place { i, a, b, h, bends: [a * a * a - a, b * b * b - b] })
    }

    /// y at a place.
    pub(crate) fn value_at(&self, place: &Place) -> f64 {
        let Place { i, a, b, h, bends } = *place;
        let bend = bends[0] * self.curvature[i] + bends[1] * self.curvature[i + 1];
        a * self.y[i] + b * self.y[i + 1] + bend * h * h / 6.0
    }

    /// dy/dt at a place.
    pub(crate) fn derivative_at(&self, place: &Place) -> f64 {
        let Place { i, a, b, h, .. } = *place;
        let m = [self.curvature[i], self.curvature[i + 1]];
        let bend = (3.0 * b * b - 1.0) * m[1] - (3.0 * a * a - 1.0) * m[0];
        (self.y[i + 1] - self.y[i]) / h + bend * h / 6.0
    }
}

/// The cubic piece that holds a time, and the barycentric coordinates a = 1 − b of its knots.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    i: usize,
    a: f64,
    b: f64,
    h: f64,
    /// a³ − a and b³ − b, which values of several splines share.
    bends: [f64; 2],
}

/// The last knot at or before t that has one after it; none outside the knots.
///
/// Stamps are nearly even, so the search begins where t would be if they were.
fn interval(knots: &[f64], t: f64) -> Option<usize> {
    let (first, last) = (knots[0], knots[knots.len() - 1]);
    if !(first..=last).contains(&t) {
        return None;
    }
    let last_piece = knots.len() - 2;
    let guess = (t - first) / (last - first) * (knots.len() - 1) as f64;
    let mut low = (guess as usize).min(last_piece);
    let mut high = low + 1;
    let mut reach = 1;
    while knots[low] > t {
        high = low;
        low = low.saturating_sub(reach);
        reach *= 2;
    }
    while high < knots.len() && knots[high] <= t {
        low = high;
        high = (high + reach).min(knots.len());
        reach *= 2;
    }
    let after = low + knots[low..high].partition_point(|&knot| knot <= t);
    Some((after - 1).min(last_piece))
}

/// Checks what every spline needs of its knots.
pub(crate) fn check_knots(t: &[f64], y: &[f64]) -> Result<(), DatasetError> {
    let fail = |what: String| Err(DatasetError::SplineKnots { what });
    if t.len() != y.len() || t.len() < 2 {
        return fail(format!(
            "needs at least two knots with one value each, got {} and {}",
            t.len(),
            y.len()
        ));
    }
    if let Some(i) = t.iter().zip(y).position(|(t, y)| !(t.is_finite() && y.is_finite())) {
        return fail(format!("knot {i} is not finite: ({}, {})", t[i], y[i]));
    }
    if let Some(i) = t.windows(2).position(|pair| pair[1] <= pair[0]) {
        return fail(format!("knots must increase, but {} s follows {} s", t[i + 1], t[i]));
    }
    Ok(())
}

/// The second divided difference y[tᵢ₋₁, tᵢ, tᵢ₊₁].
pub(crate) fn divided_difference(t: &[f64], y: &[f64], i: usize) -> f64 {
    let right = (y[i + 1] - y[i]) / (t[i + 1] - t[i]);
    let left = (y[i] - y[i - 1]) / (t[i] - t[i - 1]);
    (right - left) / (t[i + 1] - t[i - 1])
}

fn natural_curvature(t: &[f64], y: &[f64]) -> Vec<f64> {
    let n = t.len();
    let mut system = Tridiagonal::interior(t, y);
    let mut curvature = vec![0.0; n];
    if n > 2 {
        curvature[1..n - 1].copy_from_slice(&system.solve());
    }
    curvature
}

/// Eliminates the end curvatures by linear extrapolation, m₀ = m₁ + (m₁ − m₂) h₀/h₁.
fn not_a_knot_curvature(t: &[f64], y: &[f64]) -> Vec<f64> {
    let n = t.len();
    let first = (t[1] - t[0]) / (t[2] - t[1]);
    let last = (t[n - 1] - t[n - 2]) / (t[n - 2] - t[n - 3]);
    let mut system = Tridiagonal::interior(t, y);
    let (h_first, h_last) = (t[1] - t[0], t[n - 1] - t[n - 2]);
    system.diagonal[0] += h_first * (1.0 + first);
    system.upper[0] -= h_first * first;
    system.diagonal[n - 3] += h_last * (1.0 + last);
    system.lower[n - 3] -= h_last * last;
    let inner = system.solve();
    let mut curvature = vec![0.0; n];
    curvature[1..n - 1].copy_from_slice(&inner);
    curvature[0] = inner[0] + (inner[0] - inner[1]) * first;
    curvature[n - 1] = inner[n - 3] + (inner[n - 3] - inner[n - 4]) * last;
    curvature
}

/// hᵢ₋₁ mᵢ₋₁ + 2 (hᵢ₋₁ + hᵢ) mᵢ + hᵢ mᵢ₊₁ = 6 (hᵢ₋₁ + hᵢ) y[tᵢ₋₁, tᵢ, tᵢ₊₁] for inner knots.
struct Tridiagonal {
    lower: Vec<f64>,
    diagonal: Vec<f64>,
    upper: Vec<f64>,
    right: Vec<f64>,
}

impl Tridiagonal {
    fn interior(t: &[f64], y: &[f64]) -> Self {
        let inner = 1..t.len() - 1;
        Self {
            lower: inner.clone().map(|i| t[i] - t[i - 1]).collect(),
            diagonal: inner.clone().map(|i| 2.0 * (t[i + 1] - t[i - 1])).collect(),
            upper: inner.clone().map(|i| t[i + 1] - t[i]).collect(),
            right: inner
                .map(|i| 6.0 * (t[i + 1] - t[i - 1]) * divided_difference(t, y, i))
                .collect(),
        }
    }

    /// Elimination without pivoting: the matrix is diagonally dominant.
    fn solve(&mut self) -> Vec<f64> {
        let n = self.diagonal.len();
        for i in 1..n {
            let factor = self.lower[i] / self.diagonal[i - 1];
            self.diagonal[i] -= factor * self.upper[i - 1];
            self.right[i] -= factor * self.right[i - 1];
        }
        let mut x = vec![0.0; n];
        for i in (0..n).rev() {
            let after = if i + 1 < n { self.upper[i] * x[i + 1] } else { 0.0 };
            x[i] = (self.right[i] - after) / self.diagonal[i];
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use proptest::{
        collection::vec,
        prelude::{Strategy, prop_assert, prop_assert_eq, proptest},
        test_runner::Config,
    };

    use super::{CubicSpline, EndCondition, interval};

    const T: [f64; 8] = [0.0, 0.3, 1.1, 1.25, 2.0, 3.7, 4.0, 5.5];
    const Y: [f64; 8] = [1.0, 2.0, -0.5, 0.25, 3.0, -1.0, 0.5, 0.75];
    const AT: [f64; 6] = [0.1, 0.77, 1.2, 2.9, 3.85, 5.0];

    fn assert_matches(ends: EndCondition, expected: &[[f64; 3]; 6]) {
        let spline = CubicSpline::interpolate(&T, &Y, ends).unwrap();
        for (at, want) in AT.iter().zip(expected) {
            let got = [spline.value(*at), spline.derivative(*at), spline.second_derivative(*at)];
            for (got, want) in got.into_iter().zip(want) {
                let got = got.unwrap();
                assert!((got - want).abs() <= 1e-12 * (1.0 + want.abs()), "{at}: {got} {want}");
            }
        }
    }

    /// SciPy 1.17.1: `s = CubicSpline(T, Y, bc_type="natural"); s(at), s(at, 1), s(at, 2)`.
    #[test]
    fn natural_matches_scipy() {
        assert_matches(
            EndCondition::Natural,
            &[
                [1.475078993919368, 4.396425787728592, -10.6309245439526],
                [0.08433410946115649, -5.020964757269233, 9.913962025828894],
                [-0.04044298127354127, 5.635334162517336, 11.559105513777872],
                [0.008719126381286468, -4.369252633219492, 3.020552120703723],
                [-0.2937439229736199, 5.334579999728701, 3.8883487087662143],
                [1.721650142264638, -1.4158085467302897, -3.1649504267939133],
            ],
        );
    }

    /// SciPy 1.17.1: the same with `bc_type="not-a-knot"`.
    #[test]
    fn not_a_knot_matches_scipy() {
        assert_matches(
            EndCondition::NotAKnot,
            &[
                [1.7024373538829467, 4.927173657956029, -39.42719983621504],
                [-0.06099304310893472, -4.542192372236199, 11.160435566984514],
                [-0.036986525078416536, 5.5826864864844605, 10.538185317360504],
                [0.18467673553941832, -4.258941811324513, 2.494350601174883],
                [-0.37712989113422307, 5.11366458048539, 11.300434767486497],
                [5.292902695503795, -1.93368979582851, -23.55670324803241],
            ],
        );
        let three = CubicSpline::interpolate(&T[..3], &Y[..3], EndCondition::NotAKnot).unwrap();
        assert!((three.value(0.5).unwrap() - 2.0795454545454546).abs() < 1e-14);
        assert!((three.derivative(0.5).unwrap() + 0.7765151515151518).abs() < 1e-14);
        assert!((three.second_derivative(0.5).unwrap() + 11.742424242424242).abs() < 1e-13);
    }

    #[test]
    fn nothing_is_extrapolated() {
        let spline = CubicSpline::interpolate(&T, &Y, EndCondition::Natural).unwrap();
        assert_eq!(spline.value(-1e-9), None);
        assert_eq!(spline.derivative(5.500001), None);
        assert_eq!(spline.value(5.5).map(|y| (y - 0.75).abs() < 1e-14), Some(true));
        assert_eq!(spline.value(f64::NAN), None);
    }

    #[test]
    fn bad_knots_are_named() {
        let error = |t: &[f64], y: &[f64]| {
            CubicSpline::interpolate(t, y, EndCondition::Natural).unwrap_err().to_string()
        };
        assert!(error(&[0.0], &[0.0]).contains("at least two knots"));
        assert!(error(&[0.0, 1.0, 1.0], &[0.0; 3]).contains("1 s follows 1 s"));
        assert!(error(&[0.0, 2.0, 1.0], &[0.0; 3]).contains("1 s follows 2 s"));
        assert!(error(&[0.0, 1.0], &[0.0, f64::NAN]).contains("knot 1 is not finite: (1, NaN)"));
    }

    fn knots() -> impl Strategy<Value = (Vec<f64>, Vec<f64>)> {
        vec((0.05f64..1.0, -2.0f64..2.0), 4..20).prop_map(|pairs| {
            let mut t = 0.0;
            pairs
                .into_iter()
                .map(|(step, y)| {
                    t += step;
                    (t, y)
                })
                .unzip()
        })
    }

    #[test]
    fn a_time_at_a_knot_belongs_to_the_piece_after_it() {
        for (i, &knot) in T.iter().enumerate() {
            assert_eq!(interval(&T, knot), Some(i.min(T.len() - 2)));
            assert_eq!(interval(&T, knot.next_down()), i.checked_sub(1));
        }
    }

    proptest! {
        #![proptest_config(Config::with_cases(64))]

        #[test]
        fn not_a_knot_reproduces_every_cubic((t, c) in knots()) {
            let cubic = |t: f64| c[0] + t * (c[1] + t * (c[2] + t * c[3]));
            let slope = |t: f64| c[1] + t * (2.0 * c[2] + 3.0 * t * c[3]);
            let y: Vec<_> = t.iter().map(|&t| cubic(t)).collect();
            let spline = CubicSpline::interpolate(&t, &y, EndCondition::NotAKnot).unwrap();
            let scale = y.iter().fold(1.0f64, |max, y| max.max(y.abs()));
            for pair in t.windows(2) {
                let at = 0.3 * pair[0] + 0.7 * pair[1];
                prop_assert!((spline.value(at).unwrap() - cubic(at)).abs() < 1e-9 * scale);
                prop_assert!((spline.derivative(at).unwrap() - slope(at)).abs() < 1e-6 * scale);
            }
        }

        #[test]
        fn the_interval_of_a_time_is_that_of_a_full_search((t, _) in knots(), share in 0.0f64..1.0) {
            // Spacings from 50 ms to 1 s, then one long gap: as uneven as recordings get.
            let mut t = t;
            t.push(t[t.len() - 1] + 500.0);
            for at in [t[0] + share * (t[t.len() - 2] - t[0]), t[0] + 500.0 * share] {
                let searched = t.partition_point(|&knot| knot <= at) - 1;
                prop_assert_eq!(interval(&t, at), Some(searched));
            }
        }

        #[test]
        fn value_slope_and_curvature_are_continuous((t, y) in knots()) {
            for ends in [EndCondition::Natural, EndCondition::NotAKnot] {
                let spline = CubicSpline::interpolate(&t, &y, ends).unwrap();
                for (&knot, &value) in t.iter().zip(&y) {
                    prop_assert!((spline.value(knot).unwrap() - value).abs() < 1e-9);
                }
                for &knot in &t[1..t.len() - 1] {
                    let h = 1e-9;
                    let sides = |f: fn(&CubicSpline, f64) -> Option<f64>| {
                        (f(&spline, knot - h).unwrap(), f(&spline, knot + h).unwrap())
                    };
                    let (left, right) = sides(CubicSpline::derivative);
                    prop_assert!((left - right).abs() < 1e-5);
                    let (left, right) = sides(CubicSpline::second_derivative);
                    prop_assert!((left - right).abs() < 1e-4 * (1.0 + left.abs()));
                }
            }
        }
    }
}
