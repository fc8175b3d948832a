//! How much a parameter differs from push to push.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use effects::{Effect, Parameter, Role, Spread, by_id_with};
use models::{ChannelModel, ChannelObservation, Description};
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::{ParallelIterator, ParallelSlice};

use super::FitSettings;
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
    /// What else scatters steps.
    pub errors: MotionErrors,
}

/// Sizes tried, in the typical size of the effect; logarithms as they are.
const TRIED: [f64; 9] = [0.0, 0.1, 0.2, 0.35, 0.5, 0.7, 1.0, 1.4, 2.0];
/// Of real tails, in degrees of freedom of Student's t.
const TAILS: f64 = 4.0;
const ROUNDS: usize = 40;
/// Steps that are predicted together.
const CHUNK: usize = 128;
/// Of the rest, in m² and rad²: that of no miss at all.
const LEAST: f64 = 1e-18;
/// Times that the gaps beside the best size are halved.
const HALVINGS: usize = 2;

/// Fits by how much an effect of the model differs from push to push: the likeliest motion of all steps,
/// whose other errors have Student's t with four degrees and one covariance.
///
/// A friction differs by its logarithm, other parameters by their unit; the components of a vector alike.
/// Steps count as independent, whatever they share; the gain's standard error is over whole clusters.
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
    if !model.effects.iter().any(|carried| carried.id == about.id) {
        return refuse("the model does not carry it; add it first");
    }
    let parameters: Vec<&Parameter> = about.parameters.iter().collect();
    let tried = |size: f64| -> Result<Tried, DiagnosisError> {
        let spread = of_size(&parameters, size);
        let mut model = model.clone();
        for carried in model.effects.iter_mut().filter(|carried| carried.id == about.id) {
            let named = parameters.iter().map(|parameter| (parameter.name.to_owned(), spread));
            carried.per_push = if size > 0.0 { named.collect() } else { BTreeMap::new() };
        }
        let misses = misses(observations, &model, &settings.own)?;
        let errors = MotionErrors::of_misses(&misses, Some(TAILS));
        let densities = errors.of_each(&misses);
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

/// A size that was tried.
struct Tried {
    size: f64,
    spread: Spread,
    errors: MotionErrors,
    /// Log density of each step, and of all.
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

/// How far steps are from their predictions, beside what differs from push to push: a covariance with
/// the tails of Student's t.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotionErrors {
    /// Scale of the distribution of (Δx, Δy, Δθ), squared: in m² and rad².
    pub rest: Matrix3<f64>,
    /// Degrees of freedom; none for normal errors.
    pub tails: Option<f64>,
}

/// What a prediction misses of a step's motion, and the covariance over pushes.
type Miss = (Vector3<f64>, Matrix3<f64>);

impl MotionErrors {
    /// Those under which the motions of all steps are likeliest.
    ///
    /// # Errors
    /// `Model` for what a prediction refuses.
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
        Ok(Self::of_misses(&misses(observations, model, own)?, tails))
    }

    /// The log density of each step's motion, in nats of m, m and rad; 0 where it is not observed.
    ///
    /// # Errors
    /// As [`MotionErrors::learn`].
    pub fn log_densities(
        &self,
        observations: &Observations,
        model: &Description,
        own: &[Arc<dyn Effect>],
    ) -> Result<Vec<f64>, DiagnosisError> {
        Ok(self.of_each(&misses(observations, model, own)?))
    }

    fn of_misses(misses: &[Option<Miss>], tails: Option<f64>) -> Self {
        let known = || misses.iter().flatten();
        let n = known().count().max(1) as f64;
        let mut rest: Matrix3<f64> = known().map(|(miss, _)| miss * miss.transpose()).sum();
        rest = rest / n + LEAST * Matrix3::identity();
        for _ in 0..ROUNDS {
            let mut sum = Matrix3::zeros();
            for (miss, covariance) in known() {
                let Some(factor) = (covariance + rest).cholesky() else { continue };
                let whitened = factor.solve(miss);
                let square = miss.dot(&whitened);
                let weight = tails.map_or(1.0, |tails| (tails + 3.0) / (tails + square));
                let own = rest * whitened;
                sum += weight * own * own.transpose() + rest - rest * factor.solve(&rest);
            }
            rest = 0.5 / n * (sum + sum.transpose()) + LEAST * Matrix3::identity();
        }
        Self { rest, tails }
    }

    fn of_each(&self, misses: &[Option<Miss>]) -> Vec<f64> {
        let density = |(miss, covariance): &Miss| {
            let factor = (covariance + self.rest).cholesky()?;
            let square = miss.dot(&factor.solve(miss));
            let spread = 0.5 * factor.ln_determinant();
            Some(match self.tails {
                None => -1.5 * TAU.ln() - spread - 0.5 * square,
                Some(tails) => {
                    let norm = libm::lgamma(0.5 * (tails + 3.0)) - libm::lgamma(0.5 * tails);
                    let norm = norm - 1.5 * (tails * PI).ln();
                    norm - spread - 0.5 * (tails + 3.0) * (1.0 + square / tails).ln()
                }
            })
        };
        misses.iter().map(|miss| miss.as_ref().and_then(density).unwrap_or_default()).collect()
    }
}

fn misses(
    observations: &Observations,
    model: &Description,
    own: &[Arc<dyn Effect>],
) -> Result<Vec<Option<Miss>>, DiagnosisError> {
    let channels = ChannelModel::new(model, observations.support, own)?;
    let predicted = observations
        .steps
        .par_chunks(CHUNK)
        .map(|steps| channels.motion_over_pushes(steps.iter().map(|step| &step.input)));
    let predicted = predicted.collect::<Result<Vec<_>, _>>()?.concat();
    let miss = |(step, (mean, covariance)): (&ChannelObservation, Miss)| {
        let [dx, dy, dtheta, ..] = step.observed;
        Some((Vector3::new(dx?, dy?, dtheta?) - mean, covariance))
    };
    Ok(observations.steps.iter().zip(predicted).map(miss).collect())
}

/// Mean gain of a cluster, and its standard error.
fn gain(with: &[f64], without: &[f64], observations: &Observations) -> [f64; 2] {
    let n = 1 + observations.cluster_of.iter().max().copied().unwrap_or_default();
    let mut gains = vec![0.0; n];
    let steps = with.iter().zip(without).zip(&observations.cluster_of);
    steps.for_each(|((with, without), cluster)| gains[*cluster] += with - without);
    let mean = gains.iter().sum::<f64>() / n as f64;
    let square: f64 = gains.iter().map(|gain| (gain - mean).powi(2)).sum();
    [mean, (square / (n * (n - 1).max(1)) as f64).sqrt()]
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
        let (mut observations, mut model) = recorded(1);
        let about = by_id("pusher-friction").unwrap().info();
        let with = |friction: f64| ModelEffect::from(effects::Setting::new(about, &[friction]));
        model.effects.push(with(0.25));
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let n = observations.pushes.len();
        let frictions: Vec<f64> = (0..n).map(|_| 0.25 * (sd * normal(&mut rng)).exp()).collect();
        for (push, friction) in frictions.into_iter().enumerate() {
            let mut one = model.clone();
            *one.effects.last_mut().unwrap() = with(friction);
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
        assert!(refused(&model, "pusher-friction").contains("add it first"));
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
