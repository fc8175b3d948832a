//! How much a parameter differs from push to push.

use std::collections::BTreeMap;

use effects::{Effect, EffectInfo, Parameter, PusherFriction, Role, Setting, Spread, by_id_with};
use models::{Base, Description, ModelEffect};

use super::motion_errors::missed;
use super::{FitSettings, MotionErrors};
use crate::{DiagnosisError, Observations};

/// A spread that was fitted.
#[derive(Clone, Debug)]
pub struct SpreadFit {
    /// The model with it.
    pub description: Description,
    /// Names of the parameters that have it.
    pub parameters: Vec<&'static str>,
    /// How much they differ.
    pub spread: Spread,
    /// Mean gain of log density of a cluster over no spread, in nats, and its standard error.
    pub gain: [f64; 2],
    /// What else scatters motions.
    pub errors: MotionErrors,
}

const NOT_THERE: &str = "the model does not carry it; add it first";
/// Sizes tried, in the typical size of the effect; logarithms as they are.
const TRIED: [f64; 9] = [0.0, 0.1, 0.2, 0.35, 0.5, 0.7, 1.0, 1.4, 2.0];
/// Of real tails, in degrees of freedom of Student's t.
const TAILS: f64 = 4.0;
/// Times that the gaps beside the best size are halved.
const HALVINGS: usize = 2;
/// Times that the largest size grows while it is the likeliest.
const WIDENINGS: usize = 6;

/// Fits by how much an effect of the model differs from push to push: the likeliest motions of all
/// pushes, whose other errors, of each step and of the push, have Student's t with four degrees.
///
/// A friction differs by its logarithm, other parameters by their unit; the components of a vector alike.
///
/// # Errors
/// `NotPerPush` for an effect that the model lacks, or whose parameters are no plain numbers or vectors;
/// `Model` for what a prediction refuses.
pub fn fit_per_push(
    observations: &Observations,
    model: &Description,
    effect: &str,
    settings: &FitSettings,
) -> Result<SpreadFit, DiagnosisError> {
    let effect = by_id_with(effect, &settings.own).map_err(models::ModelError::from)?;
    let about = effect.info();
    let refuse = |why| Err(DiagnosisError::NotPerPush { effect: about.id, why });
    let is_plain = |parameter: &Parameter| {
        matches!(parameter.role, Role::Even | Role::Odd | Role::Share | Role::X(_) | Role::Y(_))
    };
    if !about.parameters.iter().all(is_plain) {
        return refuse("its parameters are no plain numbers; choose an effect that has such alone");
    }
    let model = carrying(model, about)?;
    let parameters: Vec<&Parameter> = about.parameters.iter().collect();
    let tried = |size: f64| -> Result<Tried, DiagnosisError> {
        let spread = of_size(&parameters, size);
        let mut model = model.clone();
        for carried in model.effects.iter_mut().filter(|carried| carried.id == about.id) {
            let named = parameters.iter().map(|parameter| (parameter.name.to_owned(), spread));
            carried.per_push = if size > 0.0 { named.collect() } else { BTreeMap::new() };
        }
        let missed = missed(observations, &model, &settings.own)?;
        let errors = MotionErrors::of_missed(&missed, Some(TAILS))?;
        let densities = errors.of_each(&missed)?;
        Ok(Tried {
            size,
            spread,
            errors,
            sum: densities.iter().sum(),
            densities,
            description: model,
        })
    };
    let mut all = TRIED.into_iter().map(tried).collect::<Result<Vec<Tried>, _>>()?;
    // The likeliest may be beyond sizes that are met.
    for _ in 0..WIDENINGS {
        let [.., before, last] = all.as_slice() else { break };
        let size = 1.5 * last.size;
        let is_allowed = parameters.iter().all(|one| of_size(&parameters, size).check(one).is_ok());
        if last.sum <= before.sum || !is_allowed {
            break;
        }
        all.push(tried(size)?);
    }
    for _ in 0..HALVINGS {
        let best = all.iter().enumerate().max_by(|a, b| a.1.sum.total_cmp(&b.1.sum));
        let Some((best, _)) = best else { break };
        for right in [best + 1, best] {
            if (1..all.len()).contains(&right) {
                all.insert(right, tried(0.5 * (all[right - 1].size + all[right].size))?);
            }
        }
    }
    let none = all[0].densities.clone();
    let best = all.into_iter().reduce(|best, next| if next.sum > best.sum { next } else { best });
    // There are as many as sizes at the least.
    let Some(Tried { spread, errors, densities, description, .. }) = best else {
        return Err(observations.too_few(0, 1));
    };
    let gain = gain(&densities, &none, observations);
    let parameters = parameters.iter().map(|parameter| parameter.name).collect();
    Ok(SpreadFit { description, parameters, spread, gain, errors })
}

/// The model with the effect, which may be the base's friction.
fn carrying(model: &Description, about: &EffectInfo) -> Result<Description, DiagnosisError> {
    let mut model = model.clone();
    if !model.effects.iter().any(|carried| carried.id == about.id) {
        let friction = match &model.base {
            Base::Analytical(base) if about.id == PusherFriction.info().id => {
                base.pusher_friction().value
            }
            _ => return Err(DiagnosisError::NotPerPush { effect: about.id, why: NOT_THERE }),
        };
        // The base has one number for all pushes.
        model.effects.push(ModelEffect::from(Setting::new(about, &[friction])));
    }
    Ok(model)
}

/// A size that was tried.
struct Tried {
    size: f64,
    spread: Spread,
    errors: MotionErrors,
    /// Log density of each push, and of all.
    densities: Vec<f64>,
    sum: f64,
    description: Description,
}

/// A spread in the effect's typical size: of positive numbers that are never off relative.
fn of_size(parameters: &[&Parameter], size: f64) -> Spread {
    let is_positive =
        |parameter: &&Parameter| parameter.range.0 >= 0.0 && parameter.off != effects::Off::At(0.0);
    match parameters {
        [one] if is_positive(one) => Spread::RelativeSd(size),
        _ => {
            let largest = parameters.iter().map(|parameter| parameter.typical.abs());
            Spread::Sd(size * largest.fold(0.0, f64::max))
        }
    }
}

/// Mean gain of a cluster, and its standard error.
fn gain(with: &[f64], without: &[f64], observations: &Observations) -> [f64; 2] {
    let of_push = |push: &usize| with[*push] - without[*push];
    let clusters = observations.pushes_of_clusters();
    let gains: Vec<f64> = clusters.iter().map(|pushes| pushes.iter().map(of_push).sum()).collect();
    let n = gains.len();
    let mean = gains.iter().sum::<f64>() / n as f64;
    let square: f64 = gains.iter().map(|gain| (gain - mean).powi(2)).sum();
    [mean, (square / (n * n.saturating_sub(1).max(1)) as f64).sqrt()]
}

#[cfg(test)]
mod tests {
    use effects::{Spread, by_id};
    use models::ModelEffect;
    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;

    use super::fit_per_push;
    use crate::synthetic::{NOISE, normal, recorded};
    use crate::{FitSettings, Predictions};

    /// The spread that is found of a pusher friction whose logarithm has a standard deviation a push.
    fn found(sd: f64) -> (f64, [f64; 2]) {
        let (mut observations, model) = recorded(1);
        let about = by_id("pusher-friction").unwrap().info();
        let with = |friction: f64| ModelEffect::from(effects::Setting::new(about, &[friction]));
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let n = observations.pushes.len();
        let frictions: Vec<f64> = (0..n).map(|_| 0.25 * (sd * normal(&mut rng)).exp()).collect();
        for (push, friction) in frictions.into_iter().enumerate() {
            let mut one = model.clone();
            one.effects.push(with(friction));
            let steps: Vec<usize> = (0..observations.steps.len())
                .filter(|k| observations.push_of[*k] == push)
                .collect();
            let predicted = Predictions::of(&one, &[], &observations).unwrap();
            for step in steps {
                let motion = observations.steps[step].observed.iter_mut().take(3).zip(NOISE);
                for ((observed, sd), made) in motion.zip(predicted.steps()[step]) {
                    let noise = 0.3 * sd * normal(&mut rng);
                    *observed = made.map(|at| at + noise);
                }
            }
        }
        let fit = fit_per_push(&observations, &model, "pusher-friction", &FitSettings::default())
            .unwrap();
        let Spread::RelativeSd(sd) = fit.spread else { panic!("{:?}", fit.spread) };
        assert_eq!(fit.parameters, ["friction"]);
        (sd, fit.gain)
    }

    #[test]
    fn what_no_fit_tells_is_refused() {
        let (observations, mut model) = recorded(1);
        let refused = |model: &models::Description, id: &str| {
            let error = fit_per_push(&observations, model, id, &FitSettings::default());
            error.unwrap_err().to_string()
        };
        assert!(refused(&model, "table-tilt").contains("add it first"));
        let about = by_id("inertia").unwrap().info();
        model.effects.push(effects::Setting::new(about, &[1.0]).into());
        for id in ["inertia", "support-points", "table-anisotropy", "vertex-contact"] {
            assert!(refused(&model, id).contains("no plain numbers"), "{id}");
        }
    }

    #[test]
    fn a_friction_that_differs_from_push_to_push_is_told_from_one_that_does_not() {
        let (none, [gain, _]) = found(0.0);
        assert!(none < 0.08 && gain < 0.5, "{none} {gain}");
        let (some, [gain, se]) = found(0.4);
        assert!((0.25..0.6).contains(&some) && gain > 3.0 * se, "{some} {gain} {se}");
    }
}
