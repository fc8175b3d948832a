//! What a minimum becomes without some of its data.

use nalgebra::DVector;

use super::descent::Minimum;

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

#[cfg(test)]
mod tests {
    use super::super::descent::Minimum;
    use super::super::problem::Evaluation;
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
}
