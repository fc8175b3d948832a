//! What a minimum becomes without some of its data.

use nalgebra::DVector;

use super::descent::Minimum;
use super::problem::Problem;
use crate::cut_offs::INFLUENTIAL;

/// Share of the information about some number that has to be left without a cluster: less is
/// rounding.
const LEAST_LEFT: f64 = 1e-10;

impl Minimum {
    /// How far the numbers move in one Newton step when some rows are left out: δ = (A − A₁)⁻¹u,
    /// with A the curvature, u and A₁ the rows' share of the slope and of A. None where the other
    /// rows do not determine every number.
    ///
    /// Where a push that jumps ends the way down, its secant pulls on without end: what is left of all
    /// pulls is its doing, and not counted.
    pub(super) fn shift_without(&self, rows: &[usize]) -> Option<DVector<f64>> {
        let own = self.slopes.select_rows(rows);
        let mut weighted = own.clone();
        for (mut of_row, row) in weighted.row_iter_mut().zip(rows) {
            of_row *= self.weights[*row];
        }
        let z = DVector::from_iterator(rows.len(), rows.iter().map(|row| self.at.z[*row]));
        let left = &self.curvature - own.tr_mul(&weighted);
        // In units in which the whole curvature is 1.
        let mut scaled = left.clone();
        let root = self.curvature.clone().cholesky()?.unpack();
        root.solve_lower_triangular_mut(&mut scaled);
        let mut scaled = scaled.transpose();
        root.solve_lower_triangular_mut(&mut scaled);
        if scaled.nrows() > 0 && scaled.symmetric_eigenvalues().min() < LEAST_LEFT {
            return None;
        }
        let pull = weighted.tr_mul(&z);
        let settled = &pull - &self.pull;
        let [of_pull, of_settled] = [&pull, &settled].map(|pull| {
            root.solve_lower_triangular(pull).map_or(f64::INFINITY, |scaled| scaled.norm())
        });
        let own = if of_settled < of_pull { settled } else { pull };
        Some(left.cholesky()?.solve(&own))
    }
}

/// A minimum without some of its pushes.
pub(super) struct Without {
    /// How far the numbers move that were moved.
    pub shift: DVector<f64>,
    /// The residuals there, if they were predicted anew.
    pub z: Option<DVector<f64>>,
}

impl Problem<'_> {
    /// A minimum without some pushes; none where the others do not determine every number.
    ///
    /// Where a push at the edge of sliding jumps, its slope holds next to the minimum alone, and may outweigh
    /// those of all the others: they would follow it without end, if slopes were all. So where pushes move the
    /// minimum far (Cook's distance), the others are predicted there, and halfway, until they are better
    /// predicted than at the minimum or the way is short.
    pub(super) fn without(&self, minimum: &Minimum, pushes: &[usize]) -> Option<Without> {
        let all_rows = self.whitening.rows();
        let rows: Vec<usize> = pushes.iter().flat_map(|push| all_rows[*push].clone()).collect();
        let mut shift = minimum.shift_without(&rows)?;
        let n_numbers = minimum.moved.len().max(1) as f64;
        let square = n_numbers * self.robust.scale().powi(2);
        while shift.dot(&(&minimum.curvature * &shift)) > INFLUENTIAL * square {
            let mut x = minimum.at.x.clone();
            for (k, shift) in minimum.moved.iter().zip(shift.iter()) {
                let (low, high) = self.ranges[*k];
                x[*k] = (x[*k] + shift).clamp(low, high);
            }
            // What the mechanics refuse is too far.
            if let Ok(there) = self.stand(x)
                && self.of_others(pushes, &there.z) < self.of_others(pushes, &minimum.at.z)
            {
                return Some(Without { shift, z: Some(there.z) });
            }
            shift *= 0.5;
        }
        Some(Without { shift, z: None })
    }

    /// What is minimised, but for some pushes' parts.
    fn of_others(&self, pushes: &[usize], z: &DVector<f64>) -> f64 {
        let of_pushes = self.robust.of_pushes(z);
        self.robust.value(z) - pushes.iter().map(|push| of_pushes[*push]).sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::super::descent::Minimum;
    use super::super::problem::Evaluation;
    use crate::FitSettings;
    use crate::cut_offs::INFLUENTIAL;
    use crate::fit::Refit;
    use crate::synthetic::{pushed_with, white};
    use effects::by_id;
    use nalgebra::{DMatrix, DVector};

    /// The least squares of z = b − S x, which a zero x stands for.
    fn minimum(slopes: &DMatrix<f64>, b: &DVector<f64>) -> Minimum {
        let curvature = slopes.tr_mul(slopes);
        let x = curvature.clone().cholesky().unwrap().solve(&slopes.tr_mul(b));
        let z = b - slopes * &x;
        Minimum {
            at: Evaluation { x: x.as_slice().to_vec(), value: z.norm_squared(), z },
            moved: (0..slopes.ncols()).collect(),
            weights: DVector::repeat(slopes.nrows(), 1.0),
            whole: slopes.clone(),
            slopes: slopes.clone(),
            curvature,
            pull: DVector::zeros(slopes.ncols()),
            iterations: 1,
            decrement: 0.0,
        }
    }

    fn number(row: usize, column: usize) -> f64 {
        ((7 * row + 5 * column) as f64 * 1.7 + (row * column) as f64).sin()
    }

    #[test]
    fn a_shift_leads_to_the_minimum_of_the_other_rows() {
        let slopes = DMatrix::from_fn(9, 2, number);
        let b = DVector::from_fn(9, |row, _| number(row, 11));
        let all = minimum(&slopes, &b);
        let others: Vec<usize> = (3..9).collect();
        let without = minimum(&slopes.select_rows(&others), &b.select_rows(&others));
        let shift = all.shift_without(&[0, 1, 2]).unwrap();
        for k in 0..2 {
            let expected = all.at.x[k] - shift[k];
            assert!((without.at.x[k] - expected).abs() < 1e-12, "{k}");
        }
    }

    #[test]
    fn a_shift_without_a_row_that_jumps_leads_to_the_minimum_of_the_others() {
        let slopes = DMatrix::from_fn(9, 2, number);
        let b = DVector::from_fn(9, |row, _| number(row, 11));
        let others: Vec<usize> = (1..9).collect();
        let without = minimum(&slopes.select_rows(&others), &b.select_rows(&others));
        // The other side of the jump is not seen: it pulls by far more than where it is.
        let mut jumps = minimum(&slopes, &b);
        jumps.at.z[0] += 40.0;
        jumps.pull = slopes.tr_mul(&jumps.at.z);
        let shift = jumps.shift_without(&[0]).unwrap();
        for k in 0..2 {
            assert!((without.at.x[k] - (jumps.at.x[k] - shift[k])).abs() < 1e-12, "{k}");
        }
    }

    #[test]
    fn without_the_only_rows_that_show_a_number_there_is_no_minimum() {
        // The second number shows in rows 0 to 2 alone; in units of either size.
        for unit in [1.0, 1e-7, 1e7] {
            let shows = |row: usize, column: usize| column == 0 || row < 3;
            let slopes = DMatrix::from_fn(9, 2, |row, column| match shows(row, column) {
                true if column == 1 => unit * number(row, column),
                true => number(row, column),
                false => 0.0,
            });
            let all = minimum(&slopes, &DVector::from_fn(9, |row, _| number(row, 11)));
            assert_eq!(all.shift_without(&[0, 1, 2]), None);
            assert!(all.shift_without(&[3, 4, 5]).is_some());
        }
    }

    #[test]
    fn a_push_at_the_edge_of_sliding_does_not_lead_the_others_away() {
        let (id, truth) = ("pusher-stiction", [1.6, 1e-3]);
        for seed in [3, 15, 57] {
            let (observations, model, _) = pushed_with((id, &truth), seed);
            let whitening = white(&observations);
            let settings = FitSettings::default();
            let here = Refit::new(&observations, &model, &whitening, &settings).unwrap();
            let found = here.far_from_off(by_id(id).unwrap()).unwrap().unwrap();
            let Refit { problem, minimum, .. } = &found;
            let rows = whitening.rows();
            let errors = |shift: &DVector<f64>| {
                shift.dot(&(&minimum.curvature * shift)).sqrt() / problem.robust.scale()
            };
            // A Cook's distance, as errors.
            let influential = (minimum.moved.len() as f64 * INFLUENTIAL).sqrt();
            let mut farthest: f64 = 0.0;
            for pushes in observations.pushes_of_clusters() {
                let own: Vec<usize> = pushes.iter().flat_map(|push| rows[*push].clone()).collect();
                farthest = farthest.max(errors(&minimum.shift_without(&own).unwrap()));
                let told = problem.without(minimum, &pushes).unwrap();
                let is_near = errors(&told.shift) <= influential;
                let here = problem.of_others(&pushes, &minimum.at.z);
                let gains = |z| problem.of_others(&pushes, z) < here;
                assert!(is_near || told.z.as_ref().is_some_and(gains), "seed {seed}: {pushes:?}");
            }
            assert!(farthest > 30.0, "seed {seed}: {farthest}");
            let fit = found.fit(&settings).unwrap();
            let told = fit.effects.iter().find(|effect| effect.id == id).unwrap();
            let ratio = &told.parameters[0];
            assert!(ratio.se < 0.1 * ratio.value, "seed {seed}: {ratio:?}");
        }
    }
}
