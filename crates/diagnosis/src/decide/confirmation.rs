//! What held-out pushes say.

use models::Description;

use super::raised::{Missed, Raised};
use super::{DiagnoseSettings, ErrorFall, MotionError};
use crate::data::clusters::ClusterMean;
use crate::noise::widely_differing::At;
use crate::{DiagnosisError, NoiseModel, Observations, Predictions, Whitening};

/// The held-out pushes, under the noise as the best model knows it.
pub(super) struct Aside<'a> {
    observations: &'a Observations,
    settings: &'a DiagnoseSettings,
    noise: &'a NoiseModel,
    /// Where models are linearised.
    at: At,
    /// Of the best model.
    whitening: Whitening,
}

/// A model on the held-out pushes.
#[derive(Clone, Debug)]
pub(super) struct Outcome {
    /// Squares of the residuals as the best model whitens them, with their clusters.
    squares: Vec<(usize, f64)>,
    /// Log predictive density of each push, by its own.
    log_densities: Vec<f64>,
    /// What is missed of each number, in its unit.
    pub(super) missed: Missed,
}

const UNIT: &str = "whitened RMS, confirmation pushes";

impl<'a> Aside<'a> {
    pub(super) fn new(
        observations: &'a Observations,
        best: &Description,
        (noise, at): (&'a NoiseModel, At),
        settings: &'a DiagnoseSettings,
    ) -> Result<Self, DiagnosisError> {
        let whitening = noise.whitening_from(at, best, &settings.own, observations)?;
        Ok(Self { observations, settings, noise, at, whitening })
    }

    pub(super) fn outcome(&self, model: &Description) -> Result<Outcome, DiagnosisError> {
        let own = &self.settings.own;
        let residuals =
            Predictions::expected(model, own, self.observations)?.residuals(self.observations)?;
        let values: Vec<[f64; 7]> =
            residuals.iter().map(|step| step.map(Option::unwrap_or_default)).collect();
        let by_own = self.noise.whitening_from(self.at, model, own, self.observations)?;
        let white = by_own.whiten_residuals(&values);
        let densities = by_own.rows().into_iter().zip(by_own.log_determinants());
        let densities = densities
            .map(|(rows, size)| -0.5 * (white.rows(rows.start, rows.len()).norm_squared() + size));
        let white = self.whitening.whiten_residuals(&values);
        let clusters = self.observations.clusters_of_pushes().into_iter();
        let squares = clusters.zip(self.whitening.rows());
        let squares = squares.flat_map(|(cluster, rows)| rows.map(move |row| (cluster, row)));
        let squares = squares.map(|(cluster, row)| (cluster, white[row] * white[row])).collect();
        let missed = Missed::of(&residuals, &self.observations.cluster_of);
        Ok(Outcome { squares, log_densities: densities.collect(), missed })
    }

    /// What a model as it is misses.
    fn missed(&self, model: &Description) -> Result<Missed, DiagnosisError> {
        let predictions = Predictions::expected(model, &self.settings.own, self.observations)?;
        let residuals = predictions.residuals(self.observations)?;
        Ok(Missed::of(&residuals, &self.observations.cluster_of))
    }

    /// The gain of each cluster in log predictive density from one model to another.
    pub(super) fn gains(&self, one: &Outcome, other: &Outcome) -> Vec<f64> {
        let mut gains = vec![0.0; self.observations.n_clusters()];
        let by_push = one.log_densities.iter().zip(&other.log_densities);
        for (cluster, (one, other)) in self.observations.clusters_of_pushes().iter().zip(by_push) {
            gains[*cluster] += other - one;
        }
        gains
    }

    /// The fall of the error, without its floor in units of the sensors, and what is missed by more with all that is
    /// claimed.
    ///
    /// In units of the noise what a manifest leaves open is fitted before and after; in those of the
    /// sensors `given` is the model under test as it is, and `claimed` has the claimed effects alone.
    pub(super) fn fall(
        &self,
        [before, after]: [&Outcome; 2],
        [given, claimed]: [&Description; 2],
    ) -> Result<(ErrorFall, Option<Raised>), DiagnosisError> {
        let [given, claimed] = [self.missed(given)?, self.missed(claimed)?];
        let mean = ClusterMean::of(&before.squares);
        let se = mean.map_or(f64::INFINITY, |mean| 0.5 * mean.se / mean.mean.sqrt());
        let gap = before.rms() - 1.0;
        let fall = ErrorFall {
            before: before.rms(),
            after: after.rms(),
            floor: 1.0,
            gap_closed: (gap > 2.0 * se).then(|| (before.rms() - after.rms()) / gap),
            unit: UNIT.to_owned(),
            before_si: MotionError::of(given.rms()),
            after_si: MotionError::of(claimed.rms()),
            floor_si: MotionError::of([None; 5]),
        };
        Ok((fall, Raised::of(&given, &claimed)))
    }
}

impl Outcome {
    /// Root mean square of the whitened residuals.
    pub(super) fn rms(&self) -> f64 {
        let n = self.squares.len().max(1) as f64;
        (self.squares.iter().map(|(_, square)| square).sum::<f64>() / n).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::{Aside, At};
    use crate::synthetic::recorded;
    use crate::{DiagnoseSettings, Gain, NoiseModel, split};

    #[test]
    fn what_confirms_is_counted_by_sessions() {
        let (all, model) = recorded(15);
        let noise = NoiseModel::learn(&model, &[], &all).unwrap();
        let aside = all.part(&split(&all, 7).unwrap().confirm).unwrap();
        let settings = DiagnoseSettings::default();
        let aside = Aside::new(&aside, &model, (&noise, At::Middle), &settings).unwrap();
        let outcome = aside.outcome(&model).unwrap();
        let clusters: BTreeSet<usize> =
            outcome.squares.iter().map(|(cluster, _)| *cluster).collect();
        assert_eq!(clusters, (0..4).collect());
        // Ten nats of each session at most, however many pushes it has.
        let mut better = outcome.clone();
        better.log_densities.iter_mut().for_each(|density| *density += 9.0);
        let gain = Gain::of(&aside.gains(&outcome, &better));
        assert!((gain.mean - 40.0).abs() < 1e-12 && gain.se < 1e-12, "{gain:?}");
    }
}
