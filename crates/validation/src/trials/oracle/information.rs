//! What a setup's pushes know of an effect.

use effects::{Role, by_id};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use super::noise::{N_NUISANCES, PushNoise};
use super::{Bench, FITTED, NOT_CENTRAL, NUISANCES};

/// The change of each push's numbers with an effect, at its typical size.
pub(super) struct Signature(pub(super) Vec<DVector<f64>>);

/// A signature, whitened and cleared of the nuisances.
pub(super) struct Information {
    /// Whitened, a vector for each push.
    white: Vec<DVector<f64>>,
    /// As it is read, cleared of the nuisances.
    plain: Vec<DVector<f64>>,
}

impl Information {
    /// An effect that is a nuisance itself is cleared of the others alone.
    pub(super) fn of(bench: &Bench, signature: &Signature, id: &str) -> Self {
        let free = NUISANCES.map(|nuisance| f64::from(u8::from(nuisance != id)));
        let own = bench.noise.pushes();
        let mut white = bench.noise.whiten(signature.0.iter().cloned());
        let nuisances: [Vec<DVector<f64>>; N_NUISANCES] = std::array::from_fn(|k| {
            // Where contact is lost with the effect nothing is known, and of the nuisances neither.
            let column = |(noise, change): (&PushNoise, &DVector<f64>)| {
                let is_known = f64::from(u8::from(change.amax() > 0.0));
                is_known * free[k] * noise.slopes.column(k)
            };
            bench.noise.whiten(own.iter().zip(&signature.0).map(column))
        });
        let dot = |one: &[DVector<f64>], other: &[DVector<f64>]| -> f64 {
            one.iter().zip(other).map(|(one, other)| one.dot(other)).sum()
        };
        let normal = Matrix3::from_fn(|i, j| dot(&nuisances[i], &nuisances[j]))
            + Matrix3::identity() * 1e-12;
        let right = Vector3::from_fn(|i, _| dot(&nuisances[i], &white));
        // Columns that are left out have no part.
        let inverse = normal.pseudo_inverse(1e-9).unwrap_or_else(|_| Matrix3::zeros());
        let share = inverse * right;
        for (column, share) in nuisances.iter().zip(share.iter()) {
            white.iter_mut().zip(column).for_each(|(white, column)| *white -= *share * column);
        }
        let clear = |(noise, change): (&PushNoise, &DVector<f64>)| {
            if change.amax() == 0.0 {
                return change.clone();
            }
            let left = DVector::from_fn(N_NUISANCES, |k, _| free[k] * share[k]);
            change - noise.slopes.columns(0, N_NUISANCES) * left
        };
        let plain = own.iter().zip(&signature.0).map(clear).collect();
        Self { white, plain }
    }

    fn information(&self) -> f64 {
        FITTED * self.white.iter().map(DVector::norm_squared).sum::<f64>()
    }

    /// Share of the typical size that is found with probability 0.9.
    pub(super) fn detectable(&self, id: &str) -> f64 {
        noncentrality(id) / self.information().max(1e-12).sqrt()
    }

    /// Correlation with another effect.
    pub(super) fn correlation(&self, other: &Self) -> f64 {
        let products = self.white.iter().zip(&other.white);
        let inner: f64 = products.filter(|(a, b)| a.len() == b.len()).map(|(a, b)| a.dot(b)).sum();
        FITTED * inner / (self.information() * other.information()).max(1e-300).sqrt()
    }

    /// Share of the signature that another effect leaves, which may have any size in each of its directions.
    pub(super) fn left_by(&self, directions: &[Self]) -> f64 {
        let inner = |one: &Self, other: &Self| -> f64 {
            let products = one.white.iter().zip(&other.white);
            products.filter(|(a, b)| a.len() == b.len()).map(|(a, b)| a.dot(b)).sum()
        };
        let n = directions.len();
        let normal = DMatrix::from_fn(n, n, |i, j| inner(&directions[i], &directions[j]));
        let right = DVector::from_fn(n, |i, _| inner(&directions[i], self));
        let inverse = normal.pseudo_inverse(1e-9).unwrap_or_else(|_| DMatrix::zeros(n, n));
        let own = inner(self, self).max(1e-300);
        (1.0 - right.dot(&(inverse * &right)) / own).max(0.0).sqrt()
    }

    /// Largest root mean square change of one of a step's numbers, over its noise.
    pub(super) fn visibility(&self, bench: &Bench) -> f64 {
        let mut sums = [[0.0; 2]; 7];
        let pushes = bench.views.iter().zip(bench.noise.pushes()).zip(&self.plain);
        for ((view, noise), change) in pushes {
            for step in view.step_numbers() {
                let variance = variance(&noise.in_place, &step.weights);
                let [sum, n] = &mut sums[step.number];
                *sum += step.weights.dot(change).powi(2) / variance;
                *n += 1.0;
            }
        }
        let rms = sums.iter().filter(|[_, n]| *n > 0.0).map(|[sum, n]| (sum / n).sqrt());
        rms.fold(1e-12, f64::max)
    }
}

fn variance(covariance: &DMatrix<f64>, weights: &DVector<f64>) -> f64 {
    (covariance * weights).dot(weights).max(1e-300)
}

/// Whitened length of what a test of an effect finds with probability 0.9.
pub(super) fn noncentrality(id: &str) -> f64 {
    NOT_CENTRAL[freedom(id).clamp(1, NOT_CENTRAL.len()) - 1]
}

/// Degrees of freedom of the test of an effect: parameters that say how much.
fn freedom(id: &str) -> usize {
    let Ok(effect) = by_id(id) else { return 1 };
    let parameters = effect.info().parameters.iter();
    let sized = parameters.filter(|parameter| {
        parameter.off != effects::Off::Undefined || matches!(parameter.role, Role::Direction(_))
    });
    sized.count()
}
