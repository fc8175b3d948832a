//! What a push has drawn, as far as its errors tell.

use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use crate::scatter::whitened::{Whitened, whitened};
use crate::{ModelError, PushModel, RecordedPush};

/// What is left open of a push's draw, for steps whose own errors have variance 1: a Gaussian about the
/// likeliest numbers.
#[derive(Clone, Debug, Default)]
pub(crate) struct GivenDraw {
    /// What one standard deviation of the draw, along each of independent directions, does to the whitened
    /// errors of the steps.
    open: Vec<Vec<Vector3<f64>>>,
}

/// To either side, for slopes: far enough to reach over the kinks of sticking and sliding.
const DIFFERENCE: f64 = 0.25;
const N_ROUNDS: usize = 10;
const N_HALVINGS: usize = 5;

impl GivenDraw {
    /// The draw with the likeliest numbers, by Gauss–Newton on the sum of the squares of numbers and
    /// whitened errors; no numbers where pushes draw none.
    pub(super) fn of(
        model: &dyn PushModel,
        push: &RecordedPush,
    ) -> Result<(Self, Vec<f64>), ModelError> {
        let n_drawn = model.n_drawn();
        if n_drawn == 0 {
            return Ok((Self::default(), Vec::new()));
        }
        let errors = |numbers: &DVector<f64>| whitened(model, push, numbers.as_slice());
        let cost = |numbers: &DVector<f64>| {
            let squares = errors(numbers)?.errors.iter().map(Vector3::norm_squared).sum::<f64>();
            Ok::<_, ModelError>(squares + numbers.norm_squared())
        };
        let mut numbers = DVector::zeros(n_drawn);
        let mut least = cost(&numbers)?;
        for _ in 0..N_ROUNDS {
            let slopes = slopes(&numbers, errors)?;
            let (mut known, mut right) = (DMatrix::identity(n_drawn, n_drawn), -&numbers);
            for (slopes, error) in slopes.iter().zip(errors(&numbers)?.errors) {
                known += slopes.tr_mul(slopes);
                right -= slopes.tr_mul(&error);
            }
            // Positive definite, as it begins with the identity.
            let Some(mut by) = known.cholesky().map(|known| known.solve(&right)) else { break };
            let mut is_better = false;
            for _ in 0..N_HALVINGS {
                let there = &numbers + &by;
                let now = cost(&there)?;
                if now < least {
                    (numbers, least, is_better) = (there, now, true);
                    break;
                }
                by *= 0.5;
            }
            if !is_better {
                break;
            }
        }
        let open = Self::about(&slopes(&numbers, errors)?);
        Ok((open, numbers.as_slice().to_vec()))
    }

    fn about(slopes: &[DMatrix<f64>]) -> Self {
        let n_drawn = slopes.first().map_or(0, DMatrix::ncols);
        let known = slopes.iter().map(|slopes| slopes.tr_mul(slopes));
        let known = known.fold(DMatrix::identity(n_drawn, n_drawn), |sum, one| sum + one);
        let known = known.symmetric_eigen();
        let along = |k: usize| {
            let direction = known.eigenvectors.column(k) / known.eigenvalues[k].sqrt();
            let step = |slopes: &DMatrix<f64>| {
                Vector3::from_column_slice((slopes * &direction).as_slice())
            };
            slopes.iter().map(step).collect()
        };
        Self { open: (0..n_drawn).map(along).collect() }
    }

    /// What the draw that is left open adds to products of errors so many steps apart: with it, those of
    /// errors about the likeliest draw are expected to be those of the steps' own.
    pub(super) fn products(&self, lag: usize) -> Vector3<f64> {
        let of_one = |steps: &Vec<Vector3<f64>>| -> Vector3<f64> {
            steps.iter().zip(&steps[lag..]).map(|(a, b)| a.component_mul(b)).sum()
        };
        self.open.iter().map(of_one).sum()
    }

    /// How the own error of each step comes into the sum of a push's errors about its likeliest draw, which
    /// has taken a part of it: (I − J V Jᵀ) A summed over rows, with the projections A of the steps.
    pub(super) fn through(&self, free: &[Matrix3<f64>]) -> Vec<Matrix3<f64>> {
        let step = |(k, free): (usize, &Matrix3<f64>)| {
            let taken = |steps: &Vec<Vector3<f64>>| {
                steps.iter().sum::<Vector3<f64>>() * steps[k].transpose()
            };
            let taken: Matrix3<f64> = self.open.iter().map(taken).sum();
            free - taken * free
        };
        free.iter().enumerate().map(step).collect()
    }
}

/// Slopes of the errors over the numbers: a row an output, a column a number.
fn slopes(
    numbers: &DVector<f64>,
    errors: impl Fn(&DVector<f64>) -> Result<Whitened, ModelError>,
) -> Result<Vec<DMatrix<f64>>, ModelError> {
    let mut slopes: Vec<DMatrix<f64>> = Vec::new();
    for k in 0..numbers.len() {
        let at = |by: f64| {
            let mut there = numbers.clone();
            there[k] += by;
            Ok::<_, ModelError>(errors(&there)?.errors)
        };
        let (above, below) = (at(DIFFERENCE)?, at(-DIFFERENCE)?);
        slopes.resize(above.len(), DMatrix::zeros(3, numbers.len()));
        for ((slopes, above), below) in slopes.iter_mut().zip(above).zip(below) {
            slopes.set_column(k, &((above - below) / (2.0 * DIFFERENCE)));
        }
    }
    Ok(slopes)
}
