//! Errors that gather somewhere without a sign of their own.

use super::DiagnoseSettings;
use super::standing::Standing;
use crate::compare::comparison::gathered;
use crate::cut_offs::{FEWEST_GATHERED, GATHERED};
use crate::{Concentration, MapSettings, NoiseFloor, Observations};

/// Errors over the standard deviations that the noise model gives them.
struct Scaled {
    /// Times the number's typical standard deviation, so that they keep its unit.
    residuals: Vec<[Option<f64>; 7]>,
    typical: [f64; 7],
}

/// The region in which most squared error gathers that noise would not, on the pushes fitted to and
/// again on those held out.
///
/// A few pushes that go far wrong in one place have no mean that flips of signs would show.
pub(super) fn gathered_again(
    [fitted, aside]: [&Standing; 2],
    floor: &NoiseFloor,
    settings: &DiagnoseSettings,
) -> Option<Concentration> {
    let (here, there) = (Scaled::of(fitted), Scaled::of(aside));
    let map_settings = MapSettings { seed: settings.seed, ..MapSettings::default() };
    let Standing { observations, predictions, .. } = fitted;
    let regions = gathered(&here.residuals, observations, predictions, floor, &map_settings);
    let seen = regions.into_iter().filter(|region| {
        let (number, aside) = (region.number(), aside.observations);
        is_seen_again(region, aside, |step| there.residuals[step][number], here.typical[number])
    });
    seen.max_by(|a, b| a.error_share.total_cmp(&b.error_share))
}

/// Whether errors of a region's number, in its unit, are as large there on other pushes.
fn is_seen_again(
    region: &Concentration,
    aside: &Observations,
    residual: impl Fn(usize) -> Option<f64>,
    typical: f64,
) -> bool {
    let least = GATHERED * typical.powi(2);
    let squares: Vec<f64> = (0..aside.n_steps())
        .filter(|step| region.conditions.iter().all(|one| one.holds(aside, *step)))
        .filter_map(residual)
        .map(|residual| residual * residual)
        .collect();
    let mean = squares.iter().sum::<f64>() / squares.len().max(1) as f64;
    region.rms.powi(2) >= least && squares.len() >= FEWEST_GATHERED && mean >= least
}

impl Scaled {
    fn of(standing: &Standing) -> Self {
        let all = &standing.residuals;
        let typical = standing.whitening.typical_sd();
        let mut residuals = vec![[None; 7]; all.len()];
        for (step, number, sd) in standing.whitening.sd() {
            residuals[step][number] =
                all[step][number].map(|residual| residual / sd * typical[number]);
        }
        Self { residuals, typical }
    }
}

#[cfg(test)]
mod tests {
    use super::is_seen_again;
    use crate::synthetic::made;
    use crate::{Concentration, Condition, Covariate};

    fn region(rms: f64) -> Concentration {
        let [from, to] = [Some(0.8), None];
        Concentration {
            sentence: String::new(),
            name: "dtheta",
            unit: "rad",
            conditions: vec![Condition { covariate: Covariate::P, from, to }],
            n_steps: 40,
            n_pushes: 10,
            rms,
            rms_elsewhere: 0.001,
            error_share: 0.5,
            step_share: 0.05,
        }
    }

    #[test]
    fn errors_gather_again_if_they_are_large_there_and_on_enough_steps() {
        let (aside, ..) = made(2, |_| 0.0);
        let wrong_at = |place: fn(f64) -> bool| {
            let p = aside.values_of(Covariate::P);
            move |step: usize| Some(if place(p[step]) { 0.02 } else { 0.001 })
        };
        assert!(is_seen_again(&region(0.02), &aside, wrong_at(|p| p > 0.8), 0.002));
        // Large elsewhere, not large enough in either part, and on two steps alone.
        assert!(!is_seen_again(&region(0.02), &aside, wrong_at(|p| p < 0.7), 0.002));
        assert!(!is_seen_again(&region(0.003), &aside, wrong_at(|p| p > 0.8), 0.002));
        assert!(!is_seen_again(&region(0.02), &aside, wrong_at(|p| p > 0.8), 0.02));
        let p = aside.values_of(Covariate::P);
        let there: Vec<usize> = (0..p.len()).filter(|step| p[*step] >= 0.8).take(2).collect();
        let few = |step: usize| there.contains(&step).then_some(0.02);
        assert!(!is_seen_again(&region(0.02), &aside, few, 0.002));
    }
}
