//! How exactly pushes tell the parameters of effects.

use nalgebra::DMatrix;
use serde::Serialize;

use super::planned::Planned;
use super::standpoint::Standpoint;
use crate::statistics::score::detectable;
use crate::statistics::score::pick;
use crate::{DiagnosisError, NoiseModel, Observations};
use dataset::quantile;

/// How exactly a coordinate of an effect is known: a parameter, or for a ratio along a direction φ
/// one of (e cos 2φ, e sin 2φ) with e = ½ ln ratio.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Precision {
    /// Id of the effect.
    pub effect: String,
    /// Name of the coordinate.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// Standard error by the pushes so far.
    pub now: f64,
    /// With the suggested ones.
    pub expected: f64,
    /// With as many that are drawn among those that can be done: the median.
    pub with_random: f64,
    /// Size that would be found with probability 0.9 at an adjusted p of 0.01, so far.
    pub detection_limit_now: f64,
    /// The same with the suggested pushes.
    pub detection_limit: f64,
    /// A size that is met on real rigs.
    pub usual: f64,
}

/// Information on some numbers beside the others that stay free.
pub(super) struct Precisions {
    standpoint: Standpoint,
    targets: Vec<usize>,
    others: Vec<usize>,
    so_far: DMatrix<f64>,
    of_candidates: Vec<DMatrix<f64>>,
}

impl Precisions {
    /// # Errors
    /// What the model refuses; `NoPushShows` for an effect without a number that is to be known.
    pub(super) fn new(
        ids: &[String],
        standpoint: &Standpoint,
        observations: &Observations,
        planned: &Planned,
        noise: &NoiseModel,
    ) -> Result<Self, DiagnosisError> {
        let standpoint = standpoint.with_absent(ids, observations)?;
        let is_target = |k: &usize| ids.iter().any(|id| id == standpoint.free[*k].effect);
        let (targets, others): (Vec<usize>, Vec<usize>) =
            (0..standpoint.free.len()).partition(is_target);
        if targets.is_empty() {
            let because = "it is there or not, and has no size";
            return Err(DiagnosisError::NoPushShows { effect: ids.join(", "), because });
        }
        let so_far = standpoint.view(observations, noise)?;
        let zero = DMatrix::zeros(standpoint.free.len(), standpoint.free.len());
        let so_far = so_far.slopes.iter().fold(zero, |sum, slopes| sum + slopes.tr_mul(slopes));
        let there = standpoint.view(&planned.0, noise)?;
        let of_candidates = there.slopes.iter().map(|slopes| slopes.tr_mul(slopes)).collect();
        Ok(Self { standpoint, targets, others, so_far, of_candidates })
    }

    /// ln det of the targets' information.
    pub(super) fn value(&self, design: &[(usize, f64)]) -> f64 {
        let factor = self.information(design).and_then(|information| information.cholesky());
        factor.map_or(f64::NEG_INFINITY, |factor| factor.ln_determinant())
    }

    pub(super) fn told(
        &self,
        design: &[(usize, f64)],
        random: &[Vec<(usize, f64)>],
    ) -> Result<Vec<Precision>, DiagnosisError> {
        let flat = || DiagnosisError::Flat;
        let known = |design: &[(usize, f64)]| self.information(design).ok_or_else(flat);
        let (now, then) = (known(&[])?, known(design)?);
        let se = |information: &DMatrix<f64>, k: usize| {
            let factor = information.clone().cholesky().ok_or_else(flat)?;
            Ok::<_, DiagnosisError>(factor.inverse()[(k, k)].sqrt())
        };
        let others = random.iter().map(|design| known(design)).collect::<Result<Vec<_>, _>>()?;
        let told = |(k, target): (usize, &usize)| {
            let free = &self.standpoint.free[*target];
            let same =
                self.targets.iter().filter(|t| self.standpoint.free[**t].effect == free.effect);
            let detectable = detectable(same.count());
            let size = |information: &DMatrix<f64>| {
                free.prior_sd * detectable / information[(k, k)].max(f64::MIN_POSITIVE).sqrt()
            };
            let with_random = others.iter().map(|one| se(one, k)).collect::<Result<Vec<_>, _>>()?;
            Ok(Precision {
                effect: free.effect.to_owned(),
                name: free.name.to_owned(),
                unit: free.unit.to_owned(),
                now: free.prior_sd * se(&now, k)?,
                expected: free.prior_sd * se(&then, k)?,
                with_random: free.prior_sd * quantile(with_random, 0.5).unwrap_or_default(),
                detection_limit_now: size(&now),
                detection_limit: size(&then),
                // A secant is half the usual size.
                usual: 2.0 * free.direction.size,
            })
        };
        self.targets.iter().enumerate().map(told).collect()
    }

    /// The targets' information with all others following.
    fn information(&self, design: &[(usize, f64)]) -> Option<DMatrix<f64>> {
        let mut sum = self.so_far.clone();
        for (candidate, count) in design {
            sum += *count * &self.of_candidates[*candidate];
        }
        let (targets, others) = (&self.targets, &self.others);
        let n = others.len();
        let precision = pick(&sum, others, others) + DMatrix::identity(n, n);
        let cross = pick(&sum, others, targets);
        let own =
            pick(&sum, targets, targets) + LEAST * DMatrix::identity(targets.len(), targets.len());
        Some(own - cross.tr_mul(&precision.cholesky()?.solve(&cross)))
    }
}

/// Precision, in that of the prior, that keeps what no push shows determined.
const LEAST: f64 = 1e-6;
/// Three times the usual size has to be seen for an effect to count as testable.
const USUAL: f64 = 3.0;

/// Refuses what would stay untestable.
pub(super) fn check(ids: &[String], told: &[Precision]) -> Result<(), DiagnosisError> {
    let is_seen = |id: &String| {
        let mut own = told.iter().filter(|one| one.effect == *id);
        own.any(|one| one.detection_limit < USUAL * one.usual)
    };
    match ids.iter().find(|id| !is_seen(id)) {
        Some(id) => {
            let because = "at three times its usual size it would still be within the noise, or look \
                           like a nominal value that is not known well";
            Err(DiagnosisError::NoPushShows { effect: id.clone(), because })
        }
        None => Ok(()),
    }
}
