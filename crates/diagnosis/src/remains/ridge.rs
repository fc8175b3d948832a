//! Least squares of many numbers that are small, group by group as small as the data say.

use std::ops::Range;

use faer::Mat;
use gp_core::{Cholesky, cholesky};
use nalgebra::{DMatrix, DVector};

/// The numbers' normal equations A δ = b, in units in which the noise is 1.
pub(super) struct Normal {
    pub(super) information: DMatrix<f64>,
    pub(super) pull: DVector<f64>,
}

/// Updates of the groups' variances at most.
const MOST_UPDATES: usize = 30;
/// Relative change of every variance at which they are known well enough.
const SETTLED: f64 = 0.02;
/// A variance at which a group is nothing.
const NOTHING: f64 = 1e-9;

impl Normal {
    /// The variance of each group's numbers that makes the pulls likeliest.
    ///
    /// # Source
    /// MacKay (1992), Bayesian interpolation, Neural Computation 4.
    pub(super) fn variances(&self, groups: &[Range<usize>]) -> Option<Vec<f64>> {
        let mut variances = vec![1.0; groups.len()];
        for _ in 0..MOST_UPDATES {
            let (factor, root) = self.factor(groups, &variances)?;
            let mean = mean_at(&factor, &root, &self.pull);
            let left_of = factor.inverse_diagonal();
            let mut is_settled = true;
            for (variance, group) in variances.iter_mut().zip(groups) {
                let left: f64 = left_of[group.clone()].iter().sum();
                let determined = group.len() as f64 - left;
                let square: f64 = group.clone().map(|k| mean[k] * mean[k]).sum();
                let found = match determined > 1e-6 {
                    true => (square / determined).max(NOTHING),
                    false => NOTHING,
                };
                is_settled &= (found - *variance).abs() <= SETTLED * *variance;
                *variance = found;
            }
            if is_settled {
                break;
            }
        }
        Some(variances)
    }

    /// The numbers' mean where each group has its variance.
    pub(super) fn mean(&self, groups: &[Range<usize>], variances: &[f64]) -> Option<DVector<f64>> {
        let (factor, root) = self.factor(groups, variances)?;
        Some(mean_at(&factor, &root, &self.pull))
    }

    /// How many numbers the data determine.
    pub(super) fn determined(&self, groups: &[Range<usize>], variances: &[f64]) -> Option<f64> {
        let (factor, _) = self.factor(groups, variances)?;
        Some(self.pull.len() as f64 - factor.inverse_diagonal().iter().sum::<f64>())
    }

    /// The same of some of the columns, the groups in their order.
    pub(super) fn of(&self, columns: &[usize]) -> Self {
        let information = crate::statistics::score::pick(&self.information, columns, columns);
        let pull = DVector::from_iterator(columns.len(), columns.iter().map(|k| self.pull[*k]));
        Self { information, pull }
    }

    /// Of T½ A T½ + 1, with T the numbers' variances, and T½.
    fn factor(
        &self,
        groups: &[Range<usize>],
        variances: &[f64],
    ) -> Option<(Cholesky, DVector<f64>)> {
        let n = self.pull.len();
        let mut root = DVector::zeros(n);
        for (group, variance) in groups.iter().zip(variances) {
            root.rows_mut(group.start, group.len()).fill(variance.sqrt());
        }
        let entry = |i: usize, j: usize| {
            root[i] * root[j] * self.information[(i, j)] + if i == j { 1.0 } else { 0.0 }
        };
        let whole = Mat::from_fn(n, n, entry);
        Some((Cholesky::new("the components' information", whole).ok()?, root))
    }
}

fn mean_at(factor: &Cholesky, root: &DVector<f64>, pull: &DVector<f64>) -> DVector<f64> {
    let mut mean = pull.component_mul(root);
    cholesky::solve_with(factor.factor(), mean.as_mut_slice());
    mean.component_mul(root)
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::Normal;
    use crate::synthetic::normal;

    #[test]
    fn a_group_that_is_there_has_its_variance_and_the_other_next_to_none() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let slopes = DMatrix::from_fn(800, 60, |_, _| normal(&mut rng));
        let truth = DVector::from_fn(60, |k, _| if k < 30 { 0.5 * normal(&mut rng) } else { 0.0 });
        let observed = &slopes * &truth + DVector::from_fn(800, |_, _| normal(&mut rng));
        let all = Normal { information: slopes.tr_mul(&slopes), pull: slopes.tr_mul(&observed) };
        let groups = [0..30, 30..60];
        let variances = all.variances(&groups).unwrap();
        let drawn = truth.rows(0, 30).norm_squared() / 30.0;
        assert!((variances[0] / drawn - 1.0).abs() < 0.1, "{variances:?} {drawn}");
        assert!(variances[1] < 1e-3, "{variances:?}");
        let mean = all.mean(&groups, &variances).unwrap();
        let least = all.information.clone().cholesky().unwrap().solve(&all.pull);
        assert!((&mean - &truth).norm() < 0.8 * (&least - &truth).norm());
    }
}
