//! Errors that gather somewhere without a sign of their own.

use super::DiagnoseSettings;
use super::search::Found;
use crate::comparison::gathered;
use crate::{
    Concentration, DiagnosisError, MapSettings, NoiseFloor, Observations, Predictions, Whitening,
};

/// Errors over the standard deviations that the noise model gives them.
struct Scaled {
    /// Times the number's typical standard deviation, so that they keep its unit.
    residuals: Vec<[Option<f64>; 7]>,
    typical: [f64; 7],
    predictions: Predictions,
}

/// Mean square in a region, in variances of the noise, from which something is wrong there.
const LEAST_SQUARE: f64 = 4.0;
/// Steps in the region, of pushes set aside, that have to say the same.
const FEWEST_AGAIN: usize = 3;

/// The region in which most squared error gathers that noise would not, on the pushes fitted to and
/// again on those set aside.
///
/// A few pushes that go far wrong in one place have no mean that flips of signs would show.
pub(super) fn gathered_again(
    found: &Found,
    (fitted, aside): (&Observations, &Observations),
    floor: &NoiseFloor,
    settings: &DiagnoseSettings,
) -> Result<Option<Concentration>, DiagnosisError> {
    let (here, there) = (Scaled::of(found, fitted, settings)?, Scaled::of(found, aside, settings)?);
    let map_settings = MapSettings { seed: settings.seed, ..MapSettings::default() };
    let regions = gathered(&here.residuals, fitted, &here.predictions, floor, &map_settings);
    let is_seen_again = |region: &Concentration| {
        let number = region.number();
        let least = LEAST_SQUARE * here.typical[number].powi(2);
        let squares: Vec<f64> = (0..aside.n_steps())
            .filter(|step| region.conditions.iter().all(|one| one.holds(aside, *step)))
            .filter_map(|step| there.residuals[step][number])
            .map(|residual| residual * residual)
            .collect();
        let mean = squares.iter().sum::<f64>() / squares.len().max(1) as f64;
        region.rms.powi(2) >= least && squares.len() >= FEWEST_AGAIN && mean >= least
    };
    let seen = regions.into_iter().filter(is_seen_again);
    Ok(seen.max_by(|a, b| a.error_share.total_cmp(&b.error_share)))
}

impl Scaled {
    fn of(
        found: &Found,
        observations: &Observations,
        settings: &DiagnoseSettings,
    ) -> Result<Self, DiagnosisError> {
        let model = &found.with_nuisances;
        let predictions = Predictions::of(model, &settings.own, observations)?;
        let whitening: Whitening = found.noise.whitening(model, &settings.own, observations)?;
        let (mut sums, mut counts) = ([0.0; 7], [0_usize; 7]);
        for (_, number, sd) in whitening.sd() {
            sums[number] += sd * sd;
            counts[number] += 1;
        }
        let typical: [f64; 7] = std::array::from_fn(|k| (sums[k] / counts[k].max(1) as f64).sqrt());
        let all = predictions.residuals(observations)?;
        let mut residuals = vec![[None; 7]; all.len()];
        for (step, number, sd) in whitening.sd() {
            residuals[step][number] =
                all[step][number].map(|residual| residual / sd * typical[number]);
        }
        Ok(Self { residuals, typical, predictions })
    }
}
