//! How far steps are from a model: what a push shares, and what each step has alone.

use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use effects::Effect;
use models::{ChannelModel, Description};
use nalgebra::{Cholesky, DMatrix, DVector, Dyn, Matrix3, Matrix3xX, SymmetricEigen, Vector3};
use rayon::prelude::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};

use crate::{DiagnosisError, Observations, Whitening};

/// How far steps are from their predictions, beside what differs from push to push by the model: an
/// error that all steps of a push share, and one that each has alone, with the tails of Student's t.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionErrors {
    /// Scale of the error of (Δx, Δy, Δθ) that each step has alone, squared: in m² and rad².
    pub rest: Matrix3<f64>,
    /// The same of the error that the steps of a push share.
    pub shared: Matrix3<f64>,
    /// Degrees of freedom of a push's errors; none for normal errors.
    pub tails: Option<f64>,
}

/// What predictions miss of a push's motions, three numbers a step.
pub(super) struct Missed {
    /// The steps, by their number in the set.
    steps: Vec<usize>,
    miss: DVector<f64>,
    /// Deviations of pushes, whose square is the covariance over them.
    varied: DMatrix<f64>,
}

const ROUNDS: usize = 60;
/// Of errors, in m² and rad²: that of no miss at all.
const LEAST: f64 = 1e-18;
/// Of the first guess, what steps of a push share.
const SHARE: f64 = 0.3;

impl MotionErrors {
    /// Those under which the motions of all pushes are likeliest.
    ///
    /// # Errors
    /// `Model` for what a prediction refuses; `NotACovariance` for a push whose numbers overflow.
    ///
    /// # Source
    /// Expectation–maximisation: Lange, Little & Taylor (1989), Robust statistical modeling using the t
    /// distribution, Journal of the American Statistical Association 84.
    pub fn learn(
        observations: &Observations,
        model: &Description,
        own: &[Arc<dyn Effect>],
        tails: Option<f64>,
    ) -> Result<Self, DiagnosisError> {
        Self::of_missed(&missed(observations, model, own)?, tails)
    }

    /// The log density of each push's motions together, in nats of m, m and rad; 0 where none is
    /// observed.
    ///
    /// # Errors
    /// As [`MotionErrors::learn`].
    pub fn log_densities(
        &self,
        observations: &Observations,
        model: &Description,
        own: &[Arc<dyn Effect>],
    ) -> Result<Vec<f64>, DiagnosisError> {
        self.of_each(&missed(observations, model, own)?)
    }

    /// The covariance of motions about a model's, to fit it with; of what else was observed that of the
    /// noise, which is taken for independent of them.
    ///
    /// # Errors
    /// As [`MotionErrors::learn`]; `NotACovariance`.
    pub fn whitening(
        &self,
        noise: &Whitening,
        observations: &Observations,
        model: &Description,
        own: &[Arc<dyn Effect>],
    ) -> Result<Whitening, DiagnosisError> {
        let all = missed(observations, model, own)?;
        let covariance = |(push, missed): (usize, &Missed)| {
            let (entries, mut covariance) = noise.covariance(push);
            let of_motions = self.covariance(missed);
            let place = |(step, number): &(usize, usize)| {
                let step = missed.steps.iter().position(|own| own == step)?;
                (*number < 3).then_some(3 * step + number)
            };
            let places: Vec<Option<usize>> = entries.iter().map(place).collect();
            for (row, one) in places.iter().enumerate() {
                for (column, other) in places.iter().enumerate() {
                    match (one, other) {
                        (Some(one), Some(other)) => {
                            covariance[(row, column)] = of_motions[(*one, *other)];
                        }
                        (None, None) => {}
                        _ => covariance[(row, column)] = 0.0,
                    }
                }
            }
            (entries, covariance)
        };
        Whitening::new(all.iter().enumerate().map(covariance))
    }

    /// The covariance of all errors of a single step, in m² and rad²: where they have tails, the square of
    /// their scale, which far steps do not raise.
    pub fn of_step(&self) -> Matrix3<f64> {
        self.rest + self.shared
    }

    pub(super) fn of_missed(all: &[Missed], tails: Option<f64>) -> Result<Self, DiagnosisError> {
        let n_steps = all.iter().map(Missed::n_steps).sum::<usize>().max(1) as f64;
        let n_pushes = all.iter().filter(|missed| missed.n_steps() > 0).count().max(1) as f64;
        let square: Matrix3<f64> =
            all.iter().flat_map(Missed::of_steps).map(|miss| miss * miss.transpose()).sum();
        let whole = square / n_steps + LEAST * Matrix3::identity();
        let mut found = Self { rest: (1.0 - SHARE) * whole, shared: SHARE * whole, tails };
        for _ in 0..ROUNDS {
            let of_push = |(push, missed)| found.expected(push, missed);
            let expected = all.par_iter().enumerate().map(of_push);
            let [mut rest, mut shared] = [Matrix3::zeros(); 2];
            for of_push in expected.collect::<Result<Vec<_>, _>>()? {
                rest += of_push[0];
                shared += of_push[1];
            }
            let mean = |sum: Matrix3<f64>, n: f64| {
                0.5 / n * (sum + sum.transpose()) + LEAST * Matrix3::identity()
            };
            (found.rest, found.shared) = (mean(rest, n_steps), mean(shared, n_pushes));
        }
        Ok(found)
    }

    fn factor(&self, push: usize, missed: &Missed) -> Result<Factor, DiagnosisError> {
        Factor::of(self, missed).ok_or(DiagnosisError::NotACovariance { push })
    }

    /// The covariance of a push's errors.
    fn covariance(&self, missed: &Missed) -> DMatrix<f64> {
        let mut covariance = &missed.varied * missed.varied.transpose();
        for one in 0..missed.n_steps() {
            for other in 0..missed.n_steps() {
                let mut block = covariance.fixed_view_mut::<3, 3>(3 * one, 3 * other);
                block += self.shared;
                if one == other {
                    block += self.rest;
                }
            }
        }
        covariance
    }

    /// Expected squares of a push's errors: the sum of those that steps have alone, and of what they
    /// share; nothing of a push without steps.
    fn expected(&self, push: usize, missed: &Missed) -> Result<[Matrix3<f64>; 2], DiagnosisError> {
        let n = missed.n_steps();
        if n == 0 {
            return Ok([Matrix3::zeros(); 2]);
        }
        let factor = self.factor(push, missed)?;
        let pulled = factor.solve(&missed.miss);
        let square = missed.miss.dot(&pulled);
        let weight = self.tails.map_or(1.0, |tails| (tails + 3.0 * n as f64) / (tails + square));
        let (mut rest, mut pull) = (Matrix3::zeros(), Vector3::zeros());
        for step in 0..n {
            let of_step = pulled.fixed_rows::<3>(3 * step);
            let own = self.rest * of_step;
            rest += weight * own * own.transpose() + self.rest;
            pull += of_step;
        }
        let [of_steps, of_all] = factor.sums_of_inverse();
        rest -= self.rest * of_steps * self.rest;
        let common = self.shared * pull;
        let known = self.shared * of_all * self.shared;
        Ok([rest, weight * common * common.transpose() + self.shared - known])
    }

    /// What a push's motions tell of the numbers that it drew, with the weight that its tails leave it: J'C⁻¹J
    /// and J'C⁻¹r, with C the covariance of all but the draws.
    pub(super) fn told_of_draws(
        &self,
        push: usize,
        missed: &Missed,
    ) -> Result<(DMatrix<f64>, DVector<f64>), DiagnosisError> {
        let n = missed.miss.len() as f64;
        let square = missed.miss.dot(&self.factor(push, missed)?.solve(&missed.miss));
        let weight = self.tails.map_or(1.0, |tails| (tails + n) / (tails + square));
        let without = self.factor(push, &missed.keeping(0.0))?;
        let pulled = missed.varied.column_iter().map(|column| without.solve(&column.into_owned()));
        let pulled = DMatrix::from_columns(&pulled.collect::<Vec<_>>());
        let information = weight * pulled.tr_mul(&missed.varied);
        Ok((information, weight * pulled.tr_mul(&missed.miss)))
    }

    pub(super) fn of_each(&self, all: &[Missed]) -> Result<Vec<f64>, DiagnosisError> {
        all.par_iter().enumerate().map(|(push, missed)| self.of_push(push, missed)).collect()
    }

    fn of_push(&self, push: usize, missed: &Missed) -> Result<f64, DiagnosisError> {
        let n = missed.miss.len() as f64;
        let factor = self.factor(push, missed)?;
        let square = missed.miss.dot(&factor.solve(&missed.miss));
        let spread = 0.5 * factor.ln_determinant;
        Ok(match self.tails {
            None => -0.5 * n * TAU.ln() - spread - 0.5 * square,
            Some(tails) => {
                let norm = libm::lgamma(0.5 * (tails + n)) - libm::lgamma(0.5 * tails);
                let norm = norm - 0.5 * n * (tails * PI).ln();
                norm - spread - 0.5 * (tails + n) * (1.0 + square / tails).ln()
            }
        })
    }
}

/// The covariance of a push's errors, factored: what each step has alone is a block of its own, and all else
/// few directions beside it, so that a long push costs no more than its steps (Woodbury's identity).
struct Factor {
    /// L⁻¹ of the rest LLᵀ that each step has alone.
    whitened: Matrix3<f64>,
    /// B: what else moves the steps, whitened, three rows a step.
    directions: DMatrix<f64>,
    /// 1 + BᵀB.
    inner: Cholesky<f64, Dyn>,
    ln_determinant: f64,
}

impl Factor {
    fn of(errors: &MotionErrors, missed: &Missed) -> Option<Self> {
        let rest = errors.rest.cholesky()?;
        let SymmetricEigen { eigenvectors, eigenvalues } = errors.shared.symmetric_eigen();
        // What steps share may be less than three numbers; below 0 it is none.
        if eigenvalues.min() < -1e-9 * eigenvalues.max() {
            return None;
        }
        let sd = eigenvalues.map(|variance| variance.max(0.0).sqrt());
        let whitened = rest.l().try_inverse()?;
        let n = missed.n_steps();
        let mut directions = DMatrix::zeros(3 * n, 3 + missed.varied.ncols());
        let common = whitened * eigenvectors * Matrix3::from_diagonal(&sd);
        for step in 0..n {
            directions.fixed_view_mut::<3, 3>(3 * step, 0).copy_from(&common);
            let varied = whitened * missed.varied.fixed_rows::<3>(3 * step);
            directions.view_mut((3 * step, 3), (3, varied.ncols())).copy_from(&varied);
        }
        let inner = directions.tr_mul(&directions);
        let inner =
            (inner + DMatrix::identity(directions.ncols(), directions.ncols())).cholesky()?;
        let ln_determinant = n as f64 * rest.ln_determinant() + inner.ln_determinant();
        ln_determinant.is_finite().then_some(Self { whitened, directions, inner, ln_determinant })
    }

    /// The inverse times the misses of a push.
    fn solve(&self, miss: &DVector<f64>) -> DVector<f64> {
        let by_steps = |by: &Matrix3<f64>, all: &mut DVector<f64>| {
            for step in 0..all.len() / 3 {
                let of_step = by * all.fixed_rows::<3>(3 * step);
                all.fixed_rows_mut::<3>(3 * step).copy_from(&of_step);
            }
        };
        let mut solved = miss.clone();
        by_steps(&self.whitened, &mut solved);
        let taken = self.inner.solve(&self.directions.tr_mul(&solved));
        solved.gemv(-1.0, &self.directions, &taken, 1.0);
        by_steps(&self.whitened.transpose(), &mut solved);
        solved
    }

    /// The sums of the inverse's blocks of three rows and three columns: of those on the diagonal, and of all.
    fn sums_of_inverse(&self) -> [Matrix3<f64>; 2] {
        let n_steps = self.directions.nrows() / 3;
        let mut together = Matrix3xX::zeros(self.directions.ncols());
        let mut of_steps = Matrix3::zeros();
        for step in 0..n_steps {
            let of_step = self.directions.fixed_rows::<3>(3 * step);
            of_steps += of_step * self.inner.solve(&of_step.transpose());
            together += of_step;
        }
        let of_all = &together * self.inner.solve(&together.transpose());
        let whole = n_steps as f64 * Matrix3::identity();
        let outward = |inside: Matrix3<f64>| self.whitened.transpose() * inside * self.whitened;
        [outward(whole - of_steps), outward(whole - of_all)]
    }
}

impl Missed {
    pub(super) fn n_steps(&self) -> usize {
        self.steps.len()
    }

    /// Whether its push draws numbers.
    pub(super) fn has_drawn(&self) -> bool {
        self.varied.ncols() > 0
    }

    /// The same where a push keeps a share of the variance that it has.
    pub(super) fn keeping(&self, share: f64) -> Self {
        let (steps, miss) = (self.steps.clone(), self.miss.clone());
        Self { steps, miss, varied: share.sqrt() * &self.varied }
    }

    fn of_steps(&self) -> impl Iterator<Item = Vector3<f64>> + '_ {
        (0..self.n_steps()).map(|step| self.miss.fixed_rows::<3>(3 * step).into_owned())
    }
}

/// What a model misses of each push.
///
/// # Errors
/// `Model` for what a prediction refuses.
pub(super) fn missed(
    observations: &Observations,
    model: &Description,
    own: &[Arc<dyn Effect>],
) -> Result<Vec<Missed>, DiagnosisError> {
    let channels = ChannelModel::new(model, observations.support, own)?;
    let mut steps_of = vec![Vec::new(); observations.pushes.len()];
    for (step, push) in observations.push_of.iter().enumerate() {
        let [dx, dy, dtheta, ..] = observations.steps[step].observed;
        if let (Some(dx), Some(dy), Some(dtheta)) = (dx, dy, dtheta) {
            steps_of[*push].push((step, Vector3::new(dx, dy, dtheta)));
        }
    }
    let of_push = |steps: &Vec<(usize, Vector3<f64>)>| {
        let inputs = steps.iter().map(|(step, _)| &observations.steps[*step].input);
        let motions = channels.motions_of_pushes(inputs)?;
        let n_values = motions.iter().map(|(_, all)| all.len()).max().unwrap_or_default();
        let mut missed = Missed {
            steps: steps.iter().map(|(step, _)| *step).collect(),
            miss: DVector::zeros(3 * steps.len()),
            varied: DMatrix::zeros(3 * steps.len(), n_values),
        };
        for (row, ((_, observed), (mean, deviations))) in steps.iter().zip(&motions).enumerate() {
            missed.miss.fixed_rows_mut::<3>(3 * row).copy_from(&(observed - mean));
            for (column, change) in deviations.iter().enumerate() {
                missed.varied.fixed_view_mut::<3, 1>(3 * row, column).copy_from(change);
            }
        }
        Ok(missed)
    };
    steps_of.par_iter().map(of_push).collect()
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector, Matrix3, Vector3};
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::{Missed, MotionErrors};
    use crate::NoiseModel;
    use crate::synthetic::{normal, recorded};

    /// Errors of pushes of several steps, of standard deviations that steps have alone and that they share.
    fn pushes(n_pushes: usize, n_steps: usize, alone: [f64; 3], shared: [f64; 3]) -> Vec<Missed> {
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let mut error = |sd: [f64; 3]| Vector3::from(sd.map(|sd| sd * normal(&mut rng)));
        let mut push = || {
            let common = error(shared);
            let steps: Vec<f64> =
                (0..n_steps).flat_map(|_| <[f64; 3]>::from(common + error(alone))).collect();
            let (miss, varied) = (DVector::from_vec(steps), DMatrix::zeros(3 * n_steps, 1));
            Missed { steps: (0..n_steps).collect(), miss, varied }
        };
        (0..n_pushes).map(|_| push()).collect()
    }

    #[test]
    fn what_a_push_shares_is_told_from_what_a_step_has_alone() {
        let (alone, shared) = ([1e-4, 2e-4, 3e-3], [2e-4, 1e-4, 6e-3]);
        let found = MotionErrors::of_missed(&pushes(600, 4, alone, shared), None).unwrap();
        for (found, truth) in [(found.rest, alone), (found.shared, shared)] {
            for k in 0..3 {
                assert!((found[(k, k)].sqrt() / truth[k] - 1.0).abs() < 0.08, "{found} {truth:?}");
            }
        }
        // What has nothing in common is not said to.
        let found = MotionErrors::of_missed(&pushes(600, 4, alone, [0.0; 3]), None).unwrap();
        assert!((0..3).all(|k| found.shared[(k, k)] < 0.05 * found.rest[(k, k)]), "{found:?}");
    }

    #[test]
    fn densities_of_steps_that_share_nothing_add_up() {
        let whole = &pushes(1, 3, [1e-4, 2e-4, 3e-3], [1e-4; 3])[0];
        let rest = Matrix3::from_diagonal(&Vector3::new(1e-8, 4e-8, 9e-6));
        let errors = |shared| MotionErrors { rest, shared, tails: None };
        let alone = errors(Matrix3::zeros());
        let step = |k: usize| Missed {
            steps: vec![k],
            miss: whole.miss.rows(3 * k, 3).into_owned(),
            varied: DMatrix::zeros(3, 1),
        };
        let sum: f64 = (0..3).map(|k| alone.of_push(k, &step(k)).unwrap()).sum();
        assert!((alone.of_push(0, whole).unwrap() - sum).abs() < 1e-9);
        // What differs by one number is an error that is shared.
        let varied = DMatrix::from_fn(9, 1, |row, _| if row % 3 == 0 { 2e-4 } else { 0.0 });
        let differs = Missed { varied, miss: whole.miss.clone(), steps: whole.steps.clone() };
        let common = errors(Matrix3::from_diagonal(&Vector3::new(4e-8, 0.0, 0.0)));
        let [one, other] =
            [alone.of_push(0, &differs), common.of_push(0, whole)].map(Result::unwrap);
        assert!((one - other).abs() < 1e-9, "{one} {other}");
        // Many degrees of freedom are a normal distribution.
        let t = MotionErrors { tails: Some(1e7), ..common };
        assert!((t.of_push(0, whole).unwrap() - other).abs() < 1e-4);
    }

    #[test]
    fn motions_have_the_errors_that_were_learnt_and_forces_those_of_the_noise() {
        let (observations, model) = recorded(1);
        let noise = NoiseModel::learn(&model, &[], &observations).unwrap();
        let noise = noise.whitening(&model, &[], &observations).unwrap();
        let (rest, shared) = (Matrix3::from_diagonal_element(4e-6), Matrix3::from_element(1e-6));
        let errors = MotionErrors { rest, shared, tails: Some(4.0) };
        let found = errors.whitening(&noise, &observations, &model, &[]).unwrap();
        let mut n_forces = 0;
        for push in 0..observations.pushes().len() {
            let ((entries, covariance), (_, before)) =
                (found.covariance(push), noise.covariance(push));
            for (row, one) in entries.iter().enumerate() {
                n_forces += usize::from(one.1 == 3);
                for (column, other) in entries.iter().enumerate() {
                    let expected = match (one.1 < 3, other.1 < 3) {
                        (true, true) if one == other => 5e-6,
                        (true, true) => 1e-6,
                        (false, false) => before[(row, column)],
                        _ => 0.0,
                    };
                    let size = covariance[(row, row)].max(covariance[(column, column)]);
                    let off = (covariance[(row, column)] - expected).abs();
                    assert!(off < 1e-9 * size, "{one:?} {other:?} {off}");
                }
            }
        }
        assert!(n_forces > 100, "{n_forces}");
    }

    #[test]
    fn few_directions_stand_for_the_whole_covariance() {
        let rest = Matrix3::new(4e-8, 1e-8, 0.0, 1e-8, 3e-8, 2e-7, 0.0, 2e-7, 9e-6);
        let shared = Matrix3::from_diagonal(&Vector3::new(1e-8, 0.0, 2e-6));
        let mut push = pushes(1, 5, [1e-4, 2e-4, 3e-3], [1e-4; 3]).remove(0);
        push.varied =
            DMatrix::from_fn(15, 2, |row, column| 1e-4 * (row as f64 - 4.0 * column as f64));
        let errors = MotionErrors { rest, shared, tails: None };
        let (few, whole) = (errors.factor(0, &push).unwrap(), errors.covariance(&push));
        let whole = whole.cholesky().unwrap();
        assert!((few.ln_determinant - whole.ln_determinant()).abs() < 1e-9);
        let (inverse, solved) = (whole.inverse(), few.solve(&push.miss));
        assert!((&inverse * &push.miss - &solved).norm() < 1e-9 * solved.norm());
        let block =
            |one: usize, other: usize| inverse.fixed_view::<3, 3>(3 * one, 3 * other).into_owned();
        let of_steps: Matrix3<f64> = (0..5).map(|step| block(step, step)).sum();
        let of_all: Matrix3<f64> = (0..25).map(|pair| block(pair / 5, pair % 5)).sum();
        for (found, expected) in few.sums_of_inverse().into_iter().zip([of_steps, of_all]) {
            assert!((found - expected).norm() < 1e-9 * of_steps.norm(), "{found} {expected}");
        }
    }

    #[test]
    fn numbers_that_overflow_are_no_density_of_nothing() {
        let mut pushes = pushes(3, 2, [1e-4; 3], [1e-4; 3]);
        pushes[1].varied.fill(1e200);
        let refused = MotionErrors::of_missed(&pushes, None).unwrap_err();
        assert!(matches!(refused, crate::DiagnosisError::NotACovariance { push: 1 }), "{refused}");
    }
}
