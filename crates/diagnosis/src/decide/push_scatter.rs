//! By how much what moves an object differs from push to push.

use std::borrow::Cow;

use models::Description;
use serde::{Deserialize, Serialize};

use super::DiagnoseSettings;
use crate::cut_offs::MUCH_OF_NOISE;
use crate::data::thinning::thinned;
use crate::noise::conditional_modes::ConditionalModes;
use crate::predict::tangent::Tangent;
use crate::remains::{noise_beside, noise_of_each};
use crate::{DiagnosisError, ErrorSource, NoiseModel, Observations};

/// By how much a parameter of an effect differs from push to push.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PushScatter {
    /// The effect's id.
    pub effect: String,
    /// SI unit of the standard deviation.
    pub unit: String,
    /// Standard deviation; of a vector that of each component.
    pub sd: f64,
    /// Lower end of its 95 % interval.
    pub low95: f64,
    /// Upper end.
    pub high95: f64,
    /// Share of the variance of a step's motion and force that is noise to the best model.
    pub share: f64,
}

impl PushScatter {
    /// Whether it makes so much of the noise that it is told and carried.
    pub fn is_much(&self) -> bool {
        self.share >= MUCH_OF_NOISE
    }
}

/// How often pushes are linearised anew at what each had itself, and the noise is learnt from there. Trial: on three
/// sets a fourth time changed what is told by 0 to 0.4 of its standard error.
const N_ROUNDS: usize = 3;
/// Steps of pushes that are used at most: hundreds of pushes tell a standard deviation to a few hundredths.
const MOST_STEPS: usize = 2000;

/// What differs from push to push beside a model, what scatters the steps most first; the tangent is its by every
/// effect.
///
/// Noise that weighs a search is linearised over what is usual, for a model that lacks something lets all seem to
/// scatter widely. Beside the model that was found every push is linearised at its own likeliest values: the edge
/// between sticking and sliding makes more of a small difference, less of a large one.
pub(super) fn push_scatter(
    (tangent, model): (&Tangent, &Description),
    observations: &Observations,
    settings: &DiagnoseSettings,
) -> Result<Vec<PushScatter>, DiagnosisError> {
    let observations = thinned(observations, MOST_STEPS)?;
    let tangent = match &observations {
        Cow::Borrowed(_) => tangent.of_tested(&settings.own),
        Cow::Owned(part) => Tangent::of(model, &settings.own, part)?,
    };
    let observations = &*observations;
    let usual = NoiseModel::usual_beside(model)?;
    let mut noise = noise_beside(&tangent, observations, &settings.remain(), &usual)?;
    let about = (model, settings.own.as_slice(), observations);
    let mut modes = ConditionalModes::at_the_model(tangent, about)?;
    for _ in 0..N_ROUNDS {
        // So much less friction may let an object slide by itself: then what is known stays.
        let Ok(()) = modes.approach(&noise) else { break };
        let learn = noise_of_each(modes.tangent(), observations, &settings.remain(), &noise);
        let Ok(Some(learnt)) = learn else { break };
        noise = learnt;
    }
    Ok(told(&noise))
}

fn told(noise: &NoiseModel) -> Vec<PushScatter> {
    let tell = |source: &ErrorSource| PushScatter {
        effect: source.name.to_owned(),
        unit: source.unit.to_owned(),
        sd: source.sd,
        low95: source.low95,
        high95: source.high95,
        share: source.share,
    };
    let of_push = noise.sources.iter().filter(|source| source.of_push);
    let mut told: Vec<PushScatter> = of_push.map(tell).collect();
    told.sort_by(|a, b| b.share.total_cmp(&a.share));
    told
}

#[cfg(test)]
mod tests {
    use models::Description;

    use super::{PushScatter, Tangent, push_scatter};
    use crate::synthetic::{SessionErrors, repeated, with_own};
    use crate::{DiagnoseSettings, Observations};

    /// Each push is a session of its own, so that what differs from session to session does from push to push.
    fn found(differs: &[(&str, f64)]) -> Vec<PushScatter> {
        let (mut all, model) = repeated(1, 3);
        for (step, push) in all.steps.iter_mut().zip(&all.push_of) {
            step.input.session = *push as u32;
        }
        let errors = SessionErrors::of((all, model), differs);
        let observed = errors.observed(3, 0.0);
        scatter(&errors.model, &observed)
    }

    fn scatter(model: &Description, observed: &Observations) -> Vec<PushScatter> {
        let tangent = Tangent::of_all(model, &[], observed).unwrap();
        push_scatter((&tangent, model), observed, &DiagnoseSettings::default()).unwrap()
    }

    #[test]
    fn what_differs_from_push_to_push_is_told_first_and_within_its_interval() {
        for (id, sd) in
            [("friction-center-offset", 2e-3), ("contact-bias", 1e-3), ("pressure-radius", 0.1)]
        {
            let found = found(&[(id, sd)]);
            let first = &found[0];
            assert_eq!(first.effect, id, "{found:?}");
            // Twice the interval's half: one in ten thousand.
            let off = (first.sd / sd).ln().abs() / (first.high95 / first.sd).ln();
            assert!(off < 2.0 && first.share > 5.0 * found[1].share, "{found:?}");
        }
    }

    /// With one slope for all pushes the friction is told 1.5 to 1.9 times as wide.
    #[test]
    fn a_friction_is_told_to_differ_as_it_does_where_tips_hold_and_slide() {
        for seed in 1..=3 {
            let (observed, model, own) = with_own("pusher-friction", 0.06, seed);
            let sd = (own.iter().map(|off| off * off).sum::<f64>() / own.len() as f64).sqrt();
            let found = scatter(&model, &observed);
            let [first, others @ ..] = found.as_slice() else { panic!("nothing is told") };
            assert_eq!(first.effect, "pusher-friction", "{found:?}");
            assert!((first.sd / sd).ln().abs() < 0.15, "{seed}: {sd} {found:?}");
            // What its slope is not right for is not taken for another quantity.
            assert!(others.iter().all(|one| one.share < 0.15), "{seed}: {found:?}");
        }
    }

    #[test]
    fn nothing_is_told_to_differ_widely_where_noise_is_white() {
        let found = found(&[]);
        assert!(found.iter().all(|one| one.share < 0.05), "{found:?}");
    }
}
