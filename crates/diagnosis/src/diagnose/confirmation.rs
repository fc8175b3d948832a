//! What the pushes say that were set aside.

use effects::Channels;

use super::search::Found;
use super::{DiagnoseSettings, ErrorFall, Gain, MotionError};
use crate::clusters::ClusterMean;
use crate::{DiagnosisError, NoiseModel, Observations, Predictions, Whitening};

/// The accepted models on pushes that no fit has seen.
pub(super) struct Confirmation {
    /// Gain of each accepted effect over the model before it.
    pub(super) gains: Vec<Gain>,
    /// Whitened root mean square of each model, without effects first.
    pub(super) rms: Vec<f64>,
    /// The error before, and after all that is confirmed.
    pub(super) error: ErrorFall,
}

/// A model on the pushes set aside.
struct Outcome {
    /// Whitened residuals, by the whitening of the last model.
    white: Vec<(usize, f64)>,
    /// Log predictive density of each push, by its own.
    log_densities: Vec<f64>,
    /// Root mean square error of a step.
    si: MotionError,
}

/// Largest gain of one cluster, in nats: 20 000 to 1. Where a model misses by many standard
/// deviations, the tails of the noise decide, which nobody knows, and few pushes hold it all.
const MOST_OF_ONE: f64 = 10.0;
const UNIT: &str = "whitened RMS, confirmation pushes";

impl Confirmation {
    pub(super) fn of(
        found: &Found,
        aside: &Observations,
        noise: &NoiseModel,
        settings: &DiagnoseSettings,
    ) -> Result<Self, DiagnosisError> {
        let n = found.accepted.len();
        let own = &settings.own;
        let last = noise.whitening(found.predictor(n), own, aside)?;
        let outcome = |k: usize| {
            let model = found.predictor(k);
            let residuals = Predictions::of(model, own, aside)?.residuals(aside)?;
            Outcome::of(&residuals, aside, &noise.whitening(model, own, aside)?, &last)
        };
        let outcomes = (0..=n).map(outcome).collect::<Result<Vec<_>, DiagnosisError>>()?;
        let gains: Vec<Gain> = outcomes.windows(2).map(|pair| gain(&pair[0], &pair[1])).collect();
        let squares = |outcome: &Outcome| -> Vec<(usize, f64)> {
            outcome.white.iter().map(|(push, z)| (*push, z * z)).collect()
        };
        let means: Vec<Option<ClusterMean>> =
            outcomes.iter().map(|outcome| ClusterMean::of(&squares(outcome))).collect();
        let rms: Vec<f64> =
            means.iter().map(|mean| mean.map_or(0.0, |mean| mean.mean.sqrt())).collect();
        let mut found = Self { gains, rms, error: ErrorFall::default() };
        let after = found.n_confirmed();
        let se = means[0].map_or(0.0, |mean| 0.5 * mean.se / mean.mean.sqrt());
        let (before, gap) = (found.rms[0], found.rms[0] - 1.0);
        found.error = ErrorFall {
            before,
            after: found.rms[after],
            floor: 1.0,
            gap_closed: (gap > 2.0 * se).then(|| (before - found.rms[after]) / gap),
            unit: UNIT.to_owned(),
            before_si: outcomes[0].si,
            after_si: outcomes[after].si,
            floor_si: floor(&last),
        };
        Ok(found)
    }

    /// Share of the gap that an accepted effect closes beyond those before it.
    pub(super) fn gap_closed(&self, index: usize) -> Option<f64> {
        self.error.gap_closed?;
        Some((self.rms[index] - self.rms[index + 1]) / (self.rms[0] - 1.0))
    }
}

impl Outcome {
    fn of(
        residuals: &[[Option<f64>; 7]],
        aside: &Observations,
        own: &Whitening,
        last: &Whitening,
    ) -> Result<Self, DiagnosisError> {
        let values: Vec<[f64; 7]> =
            residuals.iter().map(|step| step.map(Option::unwrap_or_default)).collect();
        let by_push = |whitening: &Whitening| {
            let white = whitening.whiten(&values);
            let rows = whitening.rows().into_iter();
            rows.map(|rows| white.rows(rows.start, rows.len()).into_owned()).collect::<Vec<_>>()
        };
        let densities = by_push(own).into_iter().zip(own.log_determinants());
        let log_densities =
            densities.map(|(white, size)| -0.5 * (white.norm_squared() + size)).collect();
        let white = by_push(last).into_iter().enumerate();
        let white =
            white.flat_map(|(push, white)| white.iter().map(|z| (push, *z)).collect::<Vec<_>>());
        let rms = |number: usize| {
            let squares: Vec<_> = residuals.iter().filter_map(|step| step[number]).collect();
            let n = squares.len();
            (n > 0).then(|| (squares.iter().map(|r| r * r).sum::<f64>() / n as f64).sqrt())
        };
        let si = MotionError { dx_m: rms(0), dy_m: rms(1), dtheta_rad: rms(2) };
        debug_assert_eq!(residuals.len(), aside.n_steps());
        Ok(Self { white: white.collect(), log_densities, si })
    }
}

/// The gain in log density from one model to another, with the scatter of whole pushes.
fn gain(one: &Outcome, other: &Outcome) -> Gain {
    let gains = one.log_densities.iter().zip(&other.log_densities).map(|(one, other)| other - one);
    Gain::of(&gains.collect::<Vec<_>>())
}

impl Gain {
    /// Of the gains of clusters, none of which says more than [`MOST_OF_ONE`].
    pub(super) fn of(gains: &[f64]) -> Self {
        let n = gains.len() as f64;
        let capped = || gains.iter().map(|gain| gain.clamp(-MOST_OF_ONE, MOST_OF_ONE));
        let mean = capped().sum::<f64>() / n;
        let squares = capped().map(|gain| (gain - mean).powi(2)).sum::<f64>();
        Self { mean: n * mean, se: (n * squares / (n - 1.0).max(1.0)).sqrt() }
    }
}

/// The noise of the motion.
fn floor(whitening: &Whitening) -> MotionError {
    let sd = whitening.sd();
    let rms = |number: usize| {
        let squares = sd.iter().filter(|(_, other, _)| *other == number);
        let squares: Vec<f64> = squares.map(|(_, _, sd)| sd * sd).collect();
        let n = squares.len();
        (n > 0).then(|| (squares.iter().sum::<f64>() / n as f64).sqrt())
    };
    debug_assert_eq!(Channels::NAMES[2], "dtheta");
    MotionError { dx_m: rms(0), dy_m: rms(1), dtheta_rad: rms(2) }
}
