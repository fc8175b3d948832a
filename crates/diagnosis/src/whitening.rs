//! Errors of whole pushes, turned into independent numbers of variance 1.

use nalgebra::{DMatrix, DVector};

use crate::{DiagnosisError, Observations};

/// The covariance of all that is observed, push by push: pushes are independent of each other.
#[derive(Clone, Debug)]
pub struct Whitening {
    pushes: Vec<PushWhitening>,
}

/// The covariance of the numbers of one push, as its Cholesky factor.
#[derive(Clone, Debug)]
pub struct PushWhitening {
    numbers: Vec<(usize, usize)>,
    factor: DMatrix<f64>,
    log_determinant: f64,
}

impl Whitening {
    /// From the numbers of each push, as (step, index in [`effects::Channels`]), and their
    /// covariance in SI units.
    ///
    /// # Errors
    /// `NotACovariance` for a matrix that is not positive definite, or of another size.
    pub fn new(
        pushes: impl IntoIterator<Item = (Vec<(usize, usize)>, DMatrix<f64>)>,
    ) -> Result<Self, DiagnosisError> {
        let whiten =
            |(index, (numbers, covariance))| PushWhitening::new(index, numbers, covariance);
        Ok(Self { pushes: pushes.into_iter().enumerate().map(whiten).collect::<Result<_, _>>()? })
    }

    /// Errors that are independent, with a standard deviation for each number of
    /// [`effects::Channels`], in SI units.
    ///
    /// # Errors
    /// `NotACovariance` for a standard deviation that is not positive.
    pub fn independent(observations: &Observations, sd: &[f64; 7]) -> Result<Self, DiagnosisError> {
        Self::new(observations.numbers().into_iter().map(|numbers| {
            let variances = numbers.iter().map(|(_, number)| sd[*number].powi(2));
            let variances = DVector::from_iterator(numbers.len(), variances);
            (numbers, DMatrix::from_diagonal(&variances))
        }))
    }

    /// The pushes, in the order of the observations.
    pub fn pushes(&self) -> &[PushWhitening] {
        &self.pushes
    }

    /// How many numbers there are in all.
    pub fn n_numbers(&self) -> usize {
        self.pushes.iter().map(|push| push.numbers.len()).sum()
    }

    /// ln det of the covariance of everything, in SI units.
    pub fn log_determinant(&self) -> f64 {
        self.pushes.iter().map(|push| push.log_determinant).sum()
    }
}

impl PushWhitening {
    fn new(
        push: usize,
        numbers: Vec<(usize, usize)>,
        covariance: DMatrix<f64>,
    ) -> Result<Self, DiagnosisError> {
        let n = numbers.len();
        let refused = DiagnosisError::NotACovariance { push, n_numbers: n };
        if covariance.shape() != (n, n) {
            return Err(refused);
        }
        let factor = covariance.cholesky().ok_or(refused)?.unpack();
        let log_determinant = 2.0 * factor.diagonal().iter().map(|root| root.ln()).sum::<f64>();
        Ok(Self { numbers, factor, log_determinant })
    }

    /// The push's numbers: each as (step, index in [`effects::Channels`]).
    pub fn numbers(&self) -> &[(usize, usize)] {
        &self.numbers
    }

    /// ln det of the covariance, in SI units.
    pub fn log_determinant(&self) -> f64 {
        self.log_determinant
    }

    /// The covariance, in SI units.
    pub fn covariance(&self) -> DMatrix<f64> {
        &self.factor * self.factor.transpose()
    }

    /// Turns numbers of this push, a column each set of them, into independent ones of variance 1.
    ///
    /// # Panics
    /// If there are not as many rows as numbers.
    pub fn whiten(&self, mut columns: DMatrix<f64>) -> DMatrix<f64> {
        assert_eq!(columns.nrows(), self.numbers.len(), "a row for each number of the push");
        // The factor of a positive definite matrix has a positive diagonal.
        self.factor.solve_lower_triangular_mut(&mut columns);
        columns
    }
}

#[cfg(test)]
mod tests {
    use super::Whitening;
    use crate::DiagnosisError;
    use nalgebra::{DMatrix, DVector};

    #[test]
    fn whitened_numbers_have_the_quadratic_form_of_their_covariance() {
        let root = DMatrix::from_row_slice(3, 3, &[2.0, 0.0, 0.0, 0.3, 1.0, 0.0, -0.4, 0.2, 0.7]);
        let covariance = &root * root.transpose();
        let numbers = vec![(0, 0), (0, 1), (1, 0)];
        let whitening = Whitening::new([(numbers, covariance.clone())]).unwrap();
        let push = &whitening.pushes()[0];
        let values = DVector::from_vec(vec![0.5, -1.2, 2.0]);
        let whitened = push.whiten(DMatrix::from_column_slice(3, 1, values.as_slice()));
        let expected = values.dot(&(covariance.clone().try_inverse().unwrap() * &values));
        assert!((whitened.norm_squared() - expected).abs() < 1e-12);
        assert!((whitening.log_determinant() - covariance.determinant().ln()).abs() < 1e-12);
        assert!((push.covariance() - covariance).norm() < 1e-14);
        assert_eq!(whitening.n_numbers(), 3);
    }

    #[test]
    fn what_is_no_covariance_is_refused() {
        let numbers = vec![(0, 0), (0, 1)];
        let indefinite = DMatrix::from_row_slice(2, 2, &[1.0, 2.0, 2.0, 1.0]);
        for wrong in [indefinite, DMatrix::identity(3, 3)] {
            let error = Whitening::new([(numbers.clone(), wrong)]).unwrap_err();
            assert!(matches!(error, DiagnosisError::NotACovariance { push: 0, n_numbers: 2 }));
        }
    }
}
