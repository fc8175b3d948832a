//! Score tests of generalised least squares, from the products of whitened columns.

use nalgebra::{DMatrix, DVector};

/// Noncentrality √δ at which a test of one, two and three degrees at 0.01/23 is passed with probability 0.9.
const DETECTABLE: [f64; 3] = [4.80, 5.10, 5.32];

/// The same of so many degrees; of more than three that of three.
pub(crate) fn detectable(freedom: usize) -> f64 {
    DETECTABLE[(freedom - 1).min(DETECTABLE.len() - 1)]
}

/// Products of whitened columns: of the residual, and of one slope a coordinate, each slope times
/// the coordinate's scale.
///
/// Everything that a test needs is in them, for all pushes and for each.
#[derive(Clone, Debug)]
pub(crate) struct Products {
    /// GᵀG.
    pub(crate) slopes: DMatrix<f64>,
    /// Gᵀr.
    pub(crate) residual: DVector<f64>,
    /// rᵀr.
    pub(crate) square: f64,
}

impl Products {
    pub(crate) fn zero(n: usize) -> Self {
        Self { slopes: DMatrix::zeros(n, n), residual: DVector::zeros(n), square: 0.0 }
    }

    /// Of the whitened residual and slopes: a row for each number.
    pub(crate) fn of(residual: &DVector<f64>, slopes: &DMatrix<f64>) -> Self {
        Self {
            slopes: slopes.tr_mul(slopes),
            residual: slopes.tr_mul(residual),
            square: residual.norm_squared(),
        }
    }

    pub(crate) fn add(&mut self, other: &Self) {
        self.slopes += &other.slopes;
        self.residual += &other.residual;
        self.square += other.square;
    }
}

/// A test of some coordinates, with others as nuisances.
#[derive(Clone, Debug)]
pub(crate) struct Score {
    pub(crate) tested: Vec<usize>,
    pub(crate) nuisances: Vec<usize>,
    /// U = Gᵀ P r.
    pub(crate) score: DVector<f64>,
    /// I = Gᵀ P G.
    pub(crate) information: DMatrix<f64>,
    /// The same without nuisances.
    pub(crate) plain_information: DMatrix<f64>,
    /// What each nuisance takes of the tested slopes: (JᵀJ + 1)⁻¹ JᵀG.
    pub(crate) shares: DMatrix<f64>,
    /// The nuisances where nothing is tested.
    pub(crate) estimate: DVector<f64>,
}

impl Score {
    /// The test of coordinates `tested`; nuisances are normal with mean 0 and variance 1 in their
    /// scales, or of any size where `is_free`. None if they cannot be told apart.
    pub(crate) fn new(
        all: &Products,
        tested: Vec<usize>,
        nuisances: Vec<usize>,
        is_free: &[bool],
    ) -> Option<Self> {
        let mut precision = pick(&all.slopes, &nuisances, &nuisances);
        for (k, nuisance) in nuisances.iter().enumerate() {
            precision[(k, k)] += if is_free[*nuisance] { FREE } else { 1.0 };
        }
        let cross = pick(&all.slopes, &nuisances, &tested);
        let of = |indices: &[usize]| {
            DVector::from_iterator(indices.len(), indices.iter().map(|k| all.residual[*k]))
        };
        let right = of(&nuisances);
        let factor = precision.cholesky()?;
        let (shares, estimate) = (factor.solve(&cross), factor.solve(&right));
        let plain_information = pick(&all.slopes, &tested, &tested);
        let information = &plain_information - cross.tr_mul(&shares);
        let score = of(&tested) - shares.tr_mul(&right);
        Some(Self { tested, nuisances, score, information, plain_information, shares, estimate })
    }

    /// T = Uᵀ I⁻¹ U; none where nothing is left of the slopes.
    pub(crate) fn statistic(&self) -> Option<f64> {
        let solved = self.information.clone().cholesky()?.solve(&self.score);
        Some(self.score.dot(&solved))
    }

    /// A cluster's part of U with the nuisances at their estimate; over all clusters and the
    /// nuisances' own beliefs, [`Score::beliefs`], they sum to U.
    pub(crate) fn part(&self, cluster: &Products) -> DVector<f64> {
        let left = |indices: &[usize]| {
            let of = |k: &usize| cluster.residual[*k];
            let values = DVector::from_iterator(indices.len(), indices.iter().map(of));
            values - pick(&cluster.slopes, indices, &self.nuisances) * &self.estimate
        };
        left(&self.tested) - self.shares.tr_mul(&left(&self.nuisances))
    }

    /// What is believed of each nuisance beforehand, as parts of U.
    pub(crate) fn beliefs(&self, is_free: &[bool]) -> Vec<DVector<f64>> {
        let precision = |k: usize| if is_free[self.nuisances[k]] { FREE } else { 1.0 };
        let part = |k: usize| precision(k) * self.estimate[k] * self.shares.row(k).transpose();
        (0..self.nuisances.len()).map(part).collect()
    }

    /// The covariance of the one-step estimate, in the coordinates' scales.
    pub(crate) fn covariance(&self) -> Option<DMatrix<f64>> {
        Some(self.information.clone().cholesky()?.inverse())
    }
}

/// Precision that stands for none, and keeps what no number sees determined.
const FREE: f64 = 1e-6;

pub(crate) fn pick(matrix: &DMatrix<f64>, rows: &[usize], columns: &[usize]) -> DMatrix<f64> {
    DMatrix::from_fn(rows.len(), columns.len(), |i, j| matrix[(rows[i], columns[j])])
}

/// The largest correlation of two groups of coordinates about the nuisances of both, 0 to 1.
pub(crate) fn likeness(
    all: &Products,
    (one, other): (&[usize], &[usize]),
    nuisances: &[usize],
    is_free: &[bool],
) -> Option<f64> {
    let rest = nuisances.iter().copied().filter(|k| !one.contains(k) && !other.contains(k));
    let both: Vec<usize> = one.iter().chain(other).copied().collect();
    let joint = Score::new(all, both, rest.collect(), is_free)?.information;
    let n = one.len();
    let (first, last): (Vec<usize>, Vec<usize>) = (0..joint.nrows()).partition(|k| *k < n);
    let root = |indices: &[usize]| Some(pick(&joint, indices, indices).cholesky()?.unpack());
    let mut cross = pick(&joint, &first, &last);
    root(&first)?.solve_lower_triangular_mut(&mut cross);
    let mut cross = cross.transpose();
    root(&last)?.solve_lower_triangular_mut(&mut cross);
    Some(cross.singular_values().max().min(1.0))
}

#[cfg(test)]
mod tests {
    use super::{Products, Score, likeness};
    use nalgebra::{DMatrix, DVector};

    /// Whitened residual and four slopes of five pushes, of which coordinate 3 is 2 × 0 + noise.
    fn pushes() -> Vec<(DVector<f64>, DMatrix<f64>)> {
        let number = |push: usize, row: usize, column: usize| {
            ((3 * push + 7 * row + 5 * column) as f64 * 1.7 + (row * column) as f64).sin()
        };
        (0..5)
            .map(|push| {
                let slopes = DMatrix::from_fn(6, 4, |row, column| match column {
                    3 => 2.0 * number(push, row, 0) + 0.1 * number(push, row, 9),
                    _ => number(push, row, column),
                });
                (DVector::from_fn(6, |row, _| number(push, row, 11) + slopes[(row, 1)]), slopes)
            })
            .collect()
    }

    fn all(pushes: &[(DVector<f64>, DMatrix<f64>)]) -> Products {
        let mut all = Products::zero(4);
        pushes.iter().for_each(|(residual, slopes)| all.add(&Products::of(residual, slopes)));
        all
    }

    /// Σ r² and prior terms at the best coefficients of some columns.
    fn least_square(columns: &[usize], is_free: &[bool]) -> f64 {
        let all = all(&pushes());
        let score = Score::new(&all, Vec::new(), columns.to_vec(), is_free).unwrap();
        let fitted: f64 =
            columns.iter().zip(score.estimate.iter()).map(|(k, b)| all.residual[*k] * b).sum();
        all.square - fitted
    }

    #[test]
    fn the_statistic_is_the_fall_of_the_sum_of_squares() {
        let is_free = [true, true, false, true];
        let all = all(&pushes());
        let score = Score::new(&all, vec![0, 1], vec![2], &is_free).unwrap();
        let fall = least_square(&[2], &is_free) - least_square(&[0, 1, 2], &is_free);
        assert!((score.statistic().unwrap() - fall).abs() < 1e-4 * fall, "{fall}");
    }

    #[test]
    fn parts_of_pushes_and_beliefs_sum_to_the_score() {
        let (pushes, is_free) = (pushes(), [false, true, false, false]);
        let score = Score::new(&all(&pushes), vec![0, 1], vec![2, 3], &is_free).unwrap();
        let part = |(residual, slopes): &(DVector<f64>, DMatrix<f64>)| {
            score.part(&Products::of(residual, slopes))
        };
        let mut sum: DVector<f64> = pushes.iter().map(part).sum();
        score.beliefs(&is_free).iter().for_each(|belief| sum += belief);
        assert!((sum - &score.score).norm() < 1e-10 * score.score.norm());
    }

    #[test]
    fn units_change_neither_statistic_nor_likeness() {
        let units = [1e3, 1e-4, 57.3, 0.2];
        let scaled: Vec<_> = pushes()
            .into_iter()
            .map(|(residual, mut slopes)| {
                (0..4).for_each(|k| slopes.column_mut(k).scale_mut(units[k]));
                (residual, slopes)
            })
            .collect();
        let is_free = [true; 4];
        let of = |all: &Products| {
            let score = Score::new(all, vec![0, 1], vec![2], &is_free).unwrap();
            let likeness = likeness(all, (&[0], &[3]), &[2], &is_free).unwrap();
            (score.statistic().unwrap(), likeness)
        };
        let (one, other) = (of(&all(&pushes())), of(&all(&scaled)));
        assert!((one.0 / other.0 - 1.0).abs() < 1e-4, "{one:?} {other:?}");
        assert!((one.1 - other.1).abs() < 1e-4 && one.1 > 0.99, "{one:?} {other:?}");
    }
}
