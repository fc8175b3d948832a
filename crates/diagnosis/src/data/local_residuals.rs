//! What is left of values that depend on inputs, by fits to the rows around each one.

use nalgebra::{DMatrix, DVector};
use rayon::iter::{IntoParallelIterator, ParallelIterator};

/// A row's inputs, and what must agree.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Point {
    /// Rows of other kinds say nothing of it.
    pub(crate) kind: u32,
    /// Inputs over their standard deviations.
    pub(crate) at: Vec<f64>,
}

/// Rows within so many times the hole are fitted to.
const REACH: f64 = 3.0;
/// Rows for each coefficient of a fit.
const ROWS_A_COEFFICIENT: usize = 3;
/// Variance of a fit over that of a row, above which nothing is said.
const MOST_OF_FIT: f64 = 0.7;
/// Residuals count at most so many of their typical sizes.
const LARGEST: f64 = 4.0;
/// Standard deviations of a normal number in its median size.
const SD_IN_MEDIANS: f64 = 1.482_602_218_505_602;

impl Point {
    pub(crate) fn distance(&self, other: &Self) -> f64 {
        let square = |(a, b): (&f64, &f64)| (a - b) * (a - b);
        self.at.iter().zip(&other.at).map(square).sum::<f64>().sqrt()
    }
}

/// Pairs of rows of one kind within a distance, each as (distance, earlier row, later row).
pub(crate) fn pairs(points: &[Point], within: f64) -> Vec<(f64, usize, usize)> {
    let order = in_order(points);
    let of = |place: usize| {
        let one = order[place];
        let later = order[place + 1..].iter();
        let near = later.take_while(|b| points[**b].at[0] - points[one].at[0] < within);
        let pair = |b: &usize| {
            let distance = points[one].distance(&points[*b]);
            let is_pair = distance < within && points[one].kind == points[*b].kind;
            is_pair.then_some((distance, one.min(*b), one.max(*b)))
        };
        near.filter_map(pair).collect::<Vec<_>>()
    };
    (0..order.len()).into_par_iter().flat_map_iter(of).collect()
}

/// What a fit to the rows around a row leaves of its values.
#[derive(Clone, Debug)]
pub(crate) struct Residual {
    /// Over their typical size.
    pub(crate) values: [f64; 3],
    /// The rows fitted to, in their order, with the weight of each in the fitted value.
    weights: Vec<(usize, f64)>,
}

impl Residual {
    /// Its squares, summed, that are the row's own where rows are independent.
    pub(crate) fn own_square(&self) -> f64 {
        let of_fit = self.weights.iter().map(|(_, weight)| weight * weight).sum::<f64>();
        self.values.iter().map(|value| value * value).sum::<f64>() / (1.0 + of_fit)
    }

    /// Covariance of two residuals that comes from the fits alone, over the variance of independent rows.
    pub(crate) fn fits_share(&self, other: &Self) -> f64 {
        let (mut sum, mut theirs) = (0.0, other.weights.iter().peekable());
        for (row, weight) in &self.weights {
            while theirs.next_if(|(b, _)| b < row).is_some() {}
            sum += theirs.next_if(|(b, _)| b == row).map_or(0.0, |(_, other)| weight * other);
        }
        sum
    }
}

/// Each row's values less a weighted fit to the rows around a hole about it, over their typical
/// size; none where too few rows are there, or too unevenly.
///
/// What rows within the hole share stays in the residuals, what is smooth beyond it does not. Of one
/// or two inputs the fit is quadratic, else linear. O(N M) for M rows in a strip of six holes.
pub(crate) fn local_residuals(
    points: &[Point],
    values: &[[f64; 3]],
    hole: f64,
) -> Vec<Option<Residual>> {
    let order = in_order(points);
    let mut place_of = vec![0; order.len()];
    order.iter().enumerate().for_each(|(place, row)| place_of[*row] = place);
    let reach = REACH * hole;
    let around = |row: usize| {
        let (own, place) = (&points[row], place_of[row]);
        let is_near = |b: &&usize| (points[**b].at[0] - own.at[0]).abs() < reach;
        let before = order[..place].iter().rev().take_while(is_near);
        let after = order[place + 1..].iter().take_while(is_near);
        let rows = before.chain(after).filter(|b| points[**b].kind == own.kind);
        let rows = rows.map(|b| (own.distance(&points[*b]), *b));
        let mut rows: Vec<_> =
            rows.filter(|(distance, _)| (hole..reach).contains(distance)).collect();
        rows.sort_by_key(|(_, row)| *row);
        rows
    };
    let residual = |row: usize| {
        let weights = weights(&points[row], points, &around(row), reach)?;
        let of_fit = weights.iter().map(|(_, weight)| weight * weight).sum::<f64>();
        if of_fit > MOST_OF_FIT {
            return None;
        }
        let fitted =
            |k: usize| weights.iter().map(|(b, weight)| weight * values[*b][k]).sum::<f64>();
        let values = [0, 1, 2].map(|k| values[row][k] - fitted(k));
        Some(Residual { values, weights })
    };
    let mut residuals: Vec<_> = (0..points.len()).into_par_iter().map(residual).collect();
    for k in 0..3 {
        let sizes = residuals.iter().flatten().map(|residual| residual.values[k].abs()).collect();
        let typical = SD_IN_MEDIANS * dataset::quantile(sizes, 0.5).unwrap_or_default();
        for residual in residuals.iter_mut().flatten() {
            let over = if typical > 0.0 { residual.values[k] / typical } else { 0.0 };
            residual.values[k] = over.clamp(-LARGEST, LARGEST);
        }
    }
    residuals
}

/// Rows by their first input.
fn in_order(points: &[Point]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|a, b| points[*a].at[0].total_cmp(&points[*b].at[0]));
    order
}

/// What each of some rows weighs in the value of a fit to them, where `own` is.
fn weights(
    own: &Point,
    points: &[Point],
    rows: &[(f64, usize)],
    reach: f64,
) -> Option<Vec<(usize, f64)>> {
    let terms = |point: &Point| {
        let from: Vec<f64> = point.at.iter().zip(&own.at).map(|(a, b)| (a - b) / reach).collect();
        let mut terms = vec![1.0];
        terms.extend(&from);
        if from.len() <= 2 {
            for (k, one) in from.iter().enumerate() {
                terms.extend(from[k..].iter().map(|other| one * other));
            }
        }
        DVector::from_vec(terms)
    };
    let n = terms(own).len();
    if rows.len() < ROWS_A_COEFFICIENT * n {
        return None;
    }
    let nearness = |distance: f64| (1.0 - (distance / reach).powi(2)).powi(2);
    let mut matrix = DMatrix::<f64>::zeros(n, n);
    let rows: Vec<_> = rows
        .iter()
        .map(|(distance, row)| (*row, nearness(*distance), terms(&points[*row])))
        .collect();
    rows.iter().for_each(|(_, nearness, terms)| matrix.ger(*nearness, terms, terms, 1.0));
    let mut first = DVector::zeros(n);
    first[0] = 1.0;
    let first = matrix.cholesky()?.solve(&first);
    let weight =
        |(row, nearness, terms): (usize, f64, DVector<f64>)| (row, nearness * terms.dot(&first));
    Some(rows.into_iter().map(weight).collect())
}

#[cfg(test)]
mod tests {
    use super::{Point, local_residuals, pairs};

    /// Rows evenly over a square of two to either side.
    fn spread(n: usize) -> Vec<Point> {
        let golden = 0.618_033_988_749_895;
        let place = |k: usize| {
            let [u, v] = [(k as f64 + 0.5) / n as f64, (k as f64 * golden).fract()];
            Point { kind: 0, at: vec![4.0 * u - 2.0, 4.0 * v - 2.0] }
        };
        (0..n).map(place).collect()
    }

    #[test]
    fn what_is_smooth_is_gone_and_what_is_each_rows_own_stays() {
        let points = spread(800);
        let own = |k: usize| ((k * 7919) % 101) as f64 / 101.0 - 0.5;
        let smooth = |point: &Point| (0.8 * point.at[0]).sin() + point.at[0] * point.at[1];
        let values: Vec<[f64; 3]> =
            points.iter().enumerate().map(|(k, p)| [smooth(p) + 0.1 * own(k), 0.0, 1.0]).collect();
        let found = local_residuals(&points, &values, 0.2);
        let n_known = found.iter().flatten().count();
        assert!(n_known > 700, "{n_known}");
        let (mut with, mut all, mut size) = (0.0, 0.0, 0.0);
        for (k, residual) in
            found.iter().enumerate().filter_map(|(k, r)| Some((k, r.as_ref()?.values)))
        {
            (with, all, size) =
                (with + residual[0] * own(k), all + own(k).powi(2), size + residual[0].powi(2));
        }
        let correlation = with / (all * size).sqrt();
        assert!(correlation > 0.9, "{correlation}");
    }

    #[test]
    fn pairs_are_those_of_one_kind_within_reach() {
        let mut points = spread(60);
        points.iter_mut().enumerate().for_each(|(k, point)| point.kind = (k % 2) as u32);
        let mut found = pairs(&points, 0.7);
        found.sort_by_key(|(_, a, b)| (*a, *b));
        let mut expected = Vec::new();
        for a in 0..points.len() {
            for b in a + 1..points.len() {
                let distance = points[a].distance(&points[b]);
                if points[a].kind == points[b].kind && distance < 0.7 {
                    expected.push((distance, a, b));
                }
            }
        }
        assert!(!expected.is_empty());
        assert_eq!(found, expected);
    }
}
