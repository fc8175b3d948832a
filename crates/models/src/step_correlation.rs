//! How the errors of the steps of a push go together.

use nalgebra::{Matrix3, Vector3};
use rand_chacha::ChaCha8Rng;
use rand_distr::{ChiSquared, Distribution};
use serde::{Deserialize, Serialize};

use crate::held_scatter::{HeldScatter, PushMean};
use crate::{ModelError, Noise, PushModel, RecordedPush, Slip, StepInput, StepObservation};

/// Which part of a model's variance a whole push shares, which is each step's own, and which is
/// noise of the measured poses, that one step has in excess and the next one lacks.
///
/// z_k = √held · u + √own · w_k + √measured · (e_{k+1} − e_k), of errors z = L⁻¹(observed − mean) with
/// L Lᵀ the model's covariance of a step, u of the push, w and e of the step, all with variance 1.
/// held + own + 2 measured is 1 for a model whose steps are calibrated. By moments: `measured` is what
/// the mean product of neighbors lacks to that of errors two or more steps apart, and `own` the rest of
/// the mean square, each at least 0. A bias that all pushes share counts as held.
///
/// Pushes differ in how much they hold, for some begin where the model is worse than it says: u has a
/// Student t distribution. Its scale `held` and its degrees of freedom are those of most likelihood; few
/// pushes leave them open, which makes the tails heavier.
///
/// # Source
/// Searle, Casella & McCulloch (1992), Variance Components, chapter 4 (analysis-of-variance
/// estimators), here with a third component for the differences.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StepCorrelation {
    /// Of Δx, Δy and Δθ, as shares of the model's variance: the scale squared of a t.
    pub held: [f64; 3],
    /// The degrees of freedom of what a push holds: many for pushes that all hold alike.
    pub freedom: f64,
    /// Likewise.
    pub own: [f64; 3],
    /// Likewise; it does not move the object.
    pub measured: [f64; 3],
    /// Root mean square change of the measured gap since the start of a push in contact, in m.
    pub gap_sd: f64,
    /// Pushes that it was measured on.
    pub n_pushes: usize,
    /// Their steps.
    pub n_steps: usize,
}

/// Fewer pushes with three steps do not tell what they share.
const FEWEST: usize = 4;

impl StepCorrelation {
    /// Measures it on pushes that the model has not seen, each as it was recorded.
    ///
    /// # Errors
    /// `TooFewPushes` for fewer than four pushes of three steps or more; `NoVariance` for a model that
    /// claims none; what the model refuses.
    pub fn measure<'a>(
        model: &dyn PushModel,
        pushes: impl IntoIterator<Item = &'a RecordedPush>,
    ) -> Result<Self, ModelError> {
        Self::measure_by(pushes.into_iter().map(|push| (model, push)))
    }

    /// The same where each push has a model of its own, which has not seen it: with models of one kind
    /// that each leave out a part of the pushes, all of them are measured on.
    ///
    /// # Errors
    /// As [`StepCorrelation::measure`].
    pub fn measure_by<'a, 'm>(
        pushes: impl IntoIterator<Item = (&'m dyn PushModel, &'a RecordedPush)>,
    ) -> Result<Self, ModelError> {
        let (mut errors, mut squares, mut n_gaps) = (Vec::new(), 0.0, 0);
        for (model, push) in pushes {
            errors.push(whitened(model, &push.steps)?);
            let gaps = push.gaps();
            squares += gaps.iter().map(|gap| (gap - gaps[0]).powi(2)).sum::<f64>();
            n_gaps += gaps.len() - 1;
        }
        let gap_sd = (squares / n_gaps.max(1) as f64).sqrt();
        Ok(Self { gap_sd, ..Self::of_errors(&errors)? })
    }

    /// Of whitened errors, one list a push.
    pub(crate) fn of_errors(errors: &[Vec<Vector3<f64>>]) -> Result<Self, ModelError> {
        let long: Vec<_> = errors.iter().filter(|errors| errors.len() >= 3).collect();
        if long.len() < FEWEST {
            return Err(ModelError::TooFewPushes { n_pushes: long.len(), needed: FEWEST });
        }
        let mut sums = [Vector3::<f64>::zeros(); 3];
        let mut counts = [0_usize; 3];
        for errors in &long {
            for (k, one) in errors.iter().enumerate() {
                for (lag, other) in errors[k..].iter().enumerate() {
                    sums[lag.min(2)] += one.component_mul(other);
                    counts[lag.min(2)] += 1;
                }
            }
        }
        let [square, neighbors, apart] = std::array::from_fn(|lag| sums[lag] / counts[lag] as f64);
        let products = apart.map(|product| product.max(0.0));
        let measured = (products - neighbors).map(|lacking| lacking.max(0.0));
        let own = (square - products - 2.0 * measured).map(|rest| rest.max(0.0));
        let mean = |errors: &&Vec<Vector3<f64>>| {
            let n = errors.len();
            PushMean { mean: errors.iter().sum::<Vector3<f64>>() / n as f64, n }
        };
        let means: Vec<PushMean> = long.iter().map(mean).collect();
        let HeldScatter { held, freedom } = HeldScatter::of(&means, &own);
        Ok(Self {
            held: held.into(),
            freedom,
            own: own.into(),
            measured: measured.into(),
            gap_sd: 0.0,
            n_pushes: long.len(),
            n_steps: long.iter().map(|errors| errors.len()).sum(),
        })
    }

    /// By how much what a push holds is larger than the scale: the root of ν/χ²_ν.
    pub(crate) fn size(&self, random: &mut ChaCha8Rng) -> f64 {
        // Degrees of freedom are positive; without them there is no scatter of the scatter.
        ChiSquared::new(self.freedom).map_or(1.0, |chi| (self.freedom / chi.sample(random)).sqrt())
    }

    /// A whitened error of a step, of the push's numbers and the step's.
    pub(crate) fn drawn(&self, held: &Vector3<f64>, own: &Vector3<f64>) -> Vector3<f64> {
        Vector3::from_fn(|k, _| self.held[k].sqrt() * held[k] + self.own[k].sqrt() * own[k])
    }
}

/// L⁻¹(observed − mean) of each step.
fn whitened(
    model: &dyn PushModel,
    steps: &[StepObservation],
) -> Result<Vec<Vector3<f64>>, ModelError> {
    let inputs: Vec<StepInput> = steps.iter().map(|step| step.input.clone()).collect();
    let said = match model.as_mixture() {
        // A step is held against the way that it went: which one is drawn anew every time.
        Some(mixture) => {
            let ways = mixture.ways(&inputs, Noise::Included)?;
            ways.iter().zip(steps).map(|(said, step)| said.of(Slip::of(step))).collect()
        }
        None => model.predict(&inputs, Noise::Included)?,
    };
    let error = |(step, said): (&StepObservation, &crate::StepPrediction)| {
        let off = step.outputs - said.mean;
        root(&said.covariance)
            .solve_lower_triangular(&off)
            .ok_or(ModelError::NoVariance { kind: model.kind() })
    };
    steps.iter().zip(&said).map(error).collect()
}

/// The lower triangular root of a covariance, which may be singular: then it has columns of zeros.
pub(crate) fn root(covariance: &Matrix3<f64>) -> Matrix3<f64> {
    let [xy, xz, yz] = [covariance.m21, covariance.m31, covariance.m32];
    if xy == 0.0 && xz == 0.0 && yz == 0.0 {
        return Matrix3::from_diagonal(
            &covariance.diagonal().map(|variance| variance.max(0.0).sqrt()),
        );
    }
    let mut root = Matrix3::zeros();
    for j in 0..3 {
        let before = |i: usize, k: usize| (0..j).map(|m| root[(i, m)] * root[(k, m)]).sum::<f64>();
        let square = covariance[(j, j)] - before(j, j);
        if square <= 1e-14 * covariance[(j, j)] {
            continue;
        }
        let diagonal = square.sqrt();
        let below: [f64; 3] = std::array::from_fn(|i| {
            if i > j { (covariance[(i, j)] - before(i, j)) / diagonal } else { 0.0 }
        });
        root[(j, j)] = diagonal;
        (j + 1..3).for_each(|i| root[(i, j)] = below[i]);
    }
    root
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Vector3};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::StandardNormal;

    use super::{StepCorrelation, root};
    use crate::ModelError;

    const STEPS: usize = 12;

    /// Errors of pushes with known shares.
    fn errors(n_pushes: usize, held: f64, own: f64, measured: f64) -> Vec<Vec<Vector3<f64>>> {
        let mut random = ChaCha8Rng::seed_from_u64(7);
        let mut normal =
            || -> Vector3<f64> { Vector3::from_fn(|_, _| random.sample(StandardNormal)) };
        let mut push = |_| {
            let (shared, mut noise) = (normal(), normal());
            let mut step = |_| {
                let before = std::mem::replace(&mut noise, normal());
                let own = own.sqrt() * normal();
                held.sqrt() * shared + own + measured.sqrt() * (noise - before)
            };
            (0..STEPS).map(&mut step).collect()
        };
        (0..n_pushes).map(&mut push).collect()
    }

    #[test]
    fn known_shares_are_found() {
        for (held, own, measured) in [(0.4, 0.4, 0.1), (0.0, 1.0, 0.0), (0.0, 0.2, 0.4)] {
            let found = StepCorrelation::of_errors(&errors(4000, held, own, measured)).unwrap();
            for (values, truth) in
                [(found.held, held), (found.own, own), (found.measured, measured)]
            {
                assert!(values.iter().all(|value| (value - truth).abs() < 0.03), "{found:?}");
            }
            assert_eq!((found.n_pushes, found.n_steps), (4000, 4000 * STEPS));
        }
    }

    #[test]
    fn a_push_ends_as_far_off_as_its_shares_say() {
        let shares = StepCorrelation::of_errors(&errors(4000, 0.4, 0.4, 0.1)).unwrap();
        let ends = |errors: &[Vec<Vector3<f64>>]| {
            let square = |steps: &Vec<Vector3<f64>>| steps.iter().sum::<Vector3<f64>>().x.powi(2);
            errors.iter().map(square).sum::<f64>() / errors.len() as f64
        };
        let n = STEPS as f64;
        let forecast = n * n * shares.held[0] + n * shares.own[0] + 2.0 * shares.measured[0];
        let real = ends(&errors(8000, 0.4, 0.4, 0.1));
        assert!((forecast / real - 1.0).abs() < 0.06, "{forecast} {real}");
        assert!(real / n > 4.0, "independent steps would say 1 a step, and be far too sure");
    }

    #[test]
    fn few_or_short_pushes_are_refused() {
        let mut few = errors(5, 0.1, 0.1, 0.1);
        few[0].truncate(2);
        few[1].truncate(1);
        let error = StepCorrelation::of_errors(&few).unwrap_err();
        assert!(matches!(error, ModelError::TooFewPushes { n_pushes: 3, needed: 4 }), "{error}");
    }

    #[test]
    fn a_root_gives_its_covariance_back_even_if_that_is_singular() {
        let factor = Matrix3::new(1.0, 0.0, 0.0, -0.5, 2.0, 0.0, 0.25, 1.0, 0.5);
        let full = factor * factor.transpose();
        let flat = Vector3::new(1.0, 0.0, 2.0);
        for covariance in [full, flat * flat.transpose(), Matrix3::zeros()] {
            let root = root(&covariance);
            assert!((root * root.transpose() - covariance).amax() < 1e-12, "{covariance}");
        }
    }
}
