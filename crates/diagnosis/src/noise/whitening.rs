//! Residuals made independent and of unit variance, by what is known of their noise.

use std::ops::Range;

use nalgebra::linalg::Cholesky;
use nalgebra::{DMatrix, DVector, Dyn};

use crate::DiagnosisError;

/// The mean and the covariance of the noise of observed numbers, a block for each push, in factored form.
///
/// With Σ = L Lᵀ the covariance of a push's numbers and m their mean, its whitened residuals are L⁻¹(r − m).
#[derive(Clone, Debug)]
pub struct Whitening {
    blocks: Vec<Block>,
    /// Mean of each step's numbers; none where all are 0.
    mean: Option<Vec<[f64; 7]>>,
}

/// The numbers of one push and their covariance.
#[derive(Clone, Debug)]
struct Block {
    entries: Vec<(usize, usize)>,
    factor: Cholesky<f64, Dyn>,
}

/// The numbers of a push that are used, each as (step, number of [`effects::Channels`]), and the
/// covariance of their noise, in the products of their SI units.
pub type PushCovariance = (Vec<(usize, usize)>, DMatrix<f64>);

impl Whitening {
    /// Noise of mean 0, from one covariance a push, in the order of the observations' pushes.
    ///
    /// # Errors
    /// `NotACovariance` for a matrix of another size or that is not positive definite.
    pub fn new(
        covariances: impl IntoIterator<Item = PushCovariance>,
    ) -> Result<Self, DiagnosisError> {
        let block = |(push, (entries, covariance)): (usize, PushCovariance)| {
            let fits = covariance.shape() == (entries.len(), entries.len());
            let factor = covariance.cholesky().filter(|_| fits);
            let factor = factor.ok_or(DiagnosisError::NotACovariance { push })?;
            Ok::<_, DiagnosisError>(Block { entries, factor })
        };
        let blocks = covariances.into_iter().enumerate().map(block).collect::<Result<_, _>>()?;
        Ok(Self { blocks, mean: None })
    }

    /// The same of noise with a mean, of each step's numbers.
    pub(crate) fn about(self, mean: Option<Vec<[f64; 7]>>) -> Self {
        Self { mean, ..self }
    }

    /// Mean of each step's numbers, in their units; none where all are 0.
    pub(crate) fn mean(&self) -> Option<&[[f64; 7]]> {
        self.mean.as_deref()
    }

    /// How many numbers are used, over all pushes.
    pub fn n_numbers(&self) -> usize {
        self.blocks.iter().map(|block| block.entries.len()).sum()
    }

    /// The rows of [`Whitening::whiten`] that are each push's.
    pub fn rows(&self) -> Vec<Range<usize>> {
        let mut start = 0;
        let rows = |block: &Block| {
            let first = start;
            start += block.entries.len();
            first..start
        };
        self.blocks.iter().map(rows).collect()
    }

    /// The numbers of a push that are used, each as (step, number).
    pub fn entries(&self, push: usize) -> &[(usize, usize)] {
        &self.blocks[push].entries
    }

    /// The numbers of a push that are used, and their covariance.
    pub(crate) fn covariance(&self, push: usize) -> PushCovariance {
        let Block { entries, factor } = &self.blocks[push];
        let lower = factor.l();
        (entries.clone(), &lower * lower.transpose())
    }

    /// The used ones among observed less predicted numbers of each step, whitened, push after push.
    pub fn whiten_residuals(&self, residuals: &[[f64; 7]]) -> DVector<f64> {
        match &self.mean {
            Some(mean) => {
                let less = |(residual, mean): (&[f64; 7], &[f64; 7])| {
                    std::array::from_fn(|k| residual[k] - mean[k])
                };
                self.whiten(&residuals.iter().zip(mean).map(less).collect::<Vec<_>>())
            }
            None => self.whiten(residuals),
        }
    }

    /// The used ones among changes of the numbers of each step, whitened, push after push.
    pub fn whiten(&self, values: &[[f64; 7]]) -> DVector<f64> {
        let mut white = DVector::zeros(self.n_numbers());
        for (block, rows) in self.blocks.iter().zip(self.rows()) {
            let mut part = white.rows_mut(rows.start, rows.len());
            for (value, (step, number)) in part.iter_mut().zip(&block.entries) {
                *value = values[*step][*number];
            }
            block.factor.l_dirty().solve_lower_triangular_mut(&mut part);
        }
        white
    }

    /// Several sets of the numbers of one push, a column each, whitened; a row for each entry.
    pub(crate) fn whiten_columns(&self, push: usize, mut columns: DMatrix<f64>) -> DMatrix<f64> {
        self.blocks[push].factor.l_dirty().solve_lower_triangular_mut(&mut columns);
        columns
    }

    /// Columns that this whitening made, as `other` would have made them; rows that follow those of
    /// the last push stay.
    pub(crate) fn rewhitened(&self, columns: &DMatrix<f64>, other: &Self) -> DMatrix<f64> {
        let mut found = columns.clone();
        for (push, rows) in self.rows().into_iter().enumerate() {
            let plain = self.blocks[push].factor.l() * columns.rows(rows.start, rows.len());
            let white = other.whiten_columns(push, plain);
            found.rows_mut(rows.start, rows.len()).copy_from(&white);
        }
        found
    }

    /// The standard deviation of each number, as (step, number, standard deviation in its unit).
    pub fn sd(&self) -> Vec<(usize, usize, f64)> {
        let of = |block: &Block| {
            let factor = block.factor.l();
            let rows = block.entries.iter().zip(factor.row_iter().map(|row| row.norm()));
            rows.map(|((step, number), sd)| (*step, *number, sd)).collect::<Vec<_>>()
        };
        self.blocks.iter().flat_map(of).collect()
    }

    /// The root mean square of the standard deviations of each number; 0 of one that is not observed.
    pub(crate) fn typical_sd(&self) -> [f64; 7] {
        let mut sums = [(0.0, 0_usize); 7];
        for (_, number, sd) in self.sd() {
            sums[number].0 += sd * sd;
            sums[number].1 += 1;
        }
        sums.map(|(sum, n)| (sum / n.max(1) as f64).sqrt())
    }

    /// ln |Σ| of each push.
    pub(crate) fn log_determinants(&self) -> Vec<f64> {
        self.blocks.iter().map(|block| block.factor.ln_determinant()).collect()
    }

    /// ln |Σ| of all pushes together.
    pub fn log_determinant(&self) -> f64 {
        self.blocks.iter().map(|block| block.factor.ln_determinant()).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::Whitening;
    use crate::DiagnosisError;
    use nalgebra::{DMatrix, DVector};

    #[test]
    fn whitened_residuals_have_the_quadratic_form_of_the_covariance() {
        let matrix =
            DMatrix::from_row_slice(3, 3, &[4.0, 1.0, 0.5, 1.0, 3.0, -1.0, 0.5, -1.0, 2.0]);
        let other = DMatrix::from_element(1, 1, 9.0);
        let entries = vec![(0, 0), (0, 2), (1, 2)];
        let whitening = Whitening::new([(entries, matrix.clone()), (vec![(2, 5)], other)]).unwrap();
        let mut values = [[f64::NAN; 7]; 3];
        (values[0][0], values[0][2], values[1][2], values[2][5]) = (1.0, -2.0, 0.7, 6.0);
        let white = whitening.whiten(&values);
        let residuals = DVector::from_vec(vec![1.0, -2.0, 0.7]);
        let square = residuals.dot(&(matrix.clone().try_inverse().unwrap() * &residuals));
        assert!((white.rows(0, 3).norm_squared() - square).abs() < 1e-12);
        assert!((white[3] - 2.0).abs() < 1e-15);
        let determinant = (matrix.determinant() * 9.0).ln();
        assert!((whitening.log_determinant() - determinant).abs() < 1e-12);
        assert_eq!((whitening.rows(), whitening.n_numbers()), (vec![0..3, 3..4], 4));
    }

    #[test]
    fn columns_pass_from_one_whitening_to_another() {
        let of = |variance: f64| {
            let matrix = DMatrix::from_row_slice(2, 2, &[variance, 0.5, 0.5, 2.0]);
            Whitening::new([(vec![(0, 0), (0, 1)], matrix)]).unwrap()
        };
        let (one, other) = (of(1.0), of(3.0));
        let mut values = [[0.0; 7]];
        (values[0][0], values[0][1]) = (0.7, -1.3);
        // The last row is a prior's.
        let columns = |whitening: &Whitening| whitening.whiten(&values).insert_row(2, 4.0);
        let columns = [&one, &other].map(|whitening| DMatrix::from_columns(&[columns(whitening)]));
        assert!((one.rewhitened(&columns[0], &other) - &columns[1]).norm() < 1e-14);
    }

    #[test]
    fn what_is_no_covariance_is_refused() {
        for matrix in [DMatrix::zeros(1, 1), DMatrix::identity(2, 2)] {
            let refused =
                Whitening::new([(Vec::new(), DMatrix::zeros(0, 0)), (vec![(0, 0)], matrix)]);
            assert!(matches!(refused, Err(DiagnosisError::NotACovariance { push: 1 })));
        }
    }
}
