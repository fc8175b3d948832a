//! A fitted model and its noise go in, what of the rig the error that it leaves comes from comes out:
//! every origin has a component that is free to take any form, and gains what it gains on held-out pushes.

mod beside;
mod columns;
mod folds;
mod place;
mod ridge;

use std::ops::Range;
use std::sync::Arc;

use effects::{Effect, Origin};
use models::Description;
use serde::{Deserialize, Serialize};

pub(crate) use self::beside::Beside;
use self::beside::beside;
use self::columns::Columns;
use self::folds::{Folds, Gains, LeftOfPushes, left_by_all};
use self::place::place;
use crate::cut_offs::FEWEST_CLUSTERS;
use crate::data::split::clusters;
use crate::noise::widely_differing::At;
use crate::predict::tangent::Tangent;
use crate::{DiagnosisError, Gain, NoiseModel, Observations, Tolerances};

/// What of the rig the error that a model leaves comes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Remains {
    /// What free components of all origins together gain on held-out pushes, in nats.
    pub gain: Gain,
    /// Share of the squared error, in units of the noise, that they take off.
    pub share: f64,
    /// What any smooth function of place along the edge, direction and speed gains.
    pub smooth: Gain,
    /// Every origin that has a component, that of the largest gain first.
    pub origins: Vec<OriginShare>,
}

/// How much of what is left an origin holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OriginShare {
    /// What of the rig.
    pub origin: Origin,
    /// What its component gains alone, in nats.
    pub gain: Gain,
    /// That as a share of what all together gain; none where that is not sure.
    pub alone: Option<f64>,
    /// Share of what all together gain that is lost without it; none where that is not sure.
    pub last_in: Option<f64>,
    /// Where it gains most, in words; none where that is nowhere in particular.
    pub at: Option<String>,
}

/// How remains are looked at.
pub(crate) struct RemainSettings<'a> {
    /// Effects besides those of the catalogue.
    pub(crate) own: &'a [Arc<dyn Effect>],
    pub(crate) tolerances: Tolerances,
    /// Seed of the parts, each predicted by a fit to the others.
    pub(crate) seed: u64,
}

/// What of the rig the error comes from that a model leaves, beside noise learnt about it; and what becomes of the
/// model's effects beside that.
///
/// Each origin has a component: the pressure under the object cell by cell, which may lean with the push,
/// friction and place of the contact as functions of place and direction, a field over the table, and so on,
/// as large as makes the pushes that it is fitted to likeliest; the numbers that every fit leaves open follow.
/// `tangent` is the model's by every effect; `is_testable` tells those that the data may show. None of fewer than
/// eight clusters, and where nothing can be fitted.
///
/// # Errors
/// `Model` for what the model refuses; `NotACovariance`.
pub(crate) fn remains(
    (tangent, model): (&Tangent, &Description),
    observations: &Observations,
    (noise, at): (&NoiseModel, At),
    is_testable: impl Fn(&str) -> bool,
    settings: &RemainSettings,
) -> Result<Option<(Remains, Vec<Beside>)>, DiagnosisError> {
    let members = clusters(observations);
    if members.len() < FEWEST_CLUSTERS {
        return Ok(None);
    }
    let mut tangent = tangent.clone();
    noise.put(&mut tangent.linearisation, at, (model, settings.own), observations)?;
    let whitening = noise.whitening_at(observations, &tangent.linearisation)?;
    let columns =
        Columns::of(&tangent, (observations, &whitening), &is_testable, settings.tolerances)
            .with_more_freedom(&is_testable);
    let folds = Folds::new(&columns, (whitening.rows(), members), settings.seed);
    Ok(folds.and_then(|folds| shares(&folds, &columns, observations)))
}

/// Noise learnt from repeats or neighbours, and from what is left of each push where every origin has its
/// component.
///
/// Repeats in one place agree better than pushes all over the table do, for what varies from place to place
/// is the same in each. What no free component explains is noise, wherever it is, about as large as is expected.
///
/// # Errors
/// `NotACovariance`.
pub(crate) fn noise_beside(
    tangent: &Tangent,
    observations: &Observations,
    settings: &RemainSettings,
    expected: &NoiseModel,
) -> Result<NoiseModel, DiagnosisError> {
    let noise = NoiseModel::learn_at(tangent, observations, None, expected)?;
    match left_beside(tangent, observations, settings, &noise)? {
        Some(left) => NoiseModel::learn_at(tangent, observations, Some(&left), expected),
        None => Ok(noise),
    }
}

/// Noise learnt from what is left of each push where every origin has its component, linearised at what each push
/// had itself; about as large as is expected. None where nothing can be fitted.
///
/// # Errors
/// `NotACovariance`.
pub(crate) fn noise_of_each(
    tangent: &Tangent,
    observations: &Observations,
    settings: &RemainSettings,
    expected: &NoiseModel,
) -> Result<Option<NoiseModel>, DiagnosisError> {
    let left = left_beside(tangent, observations, settings, expected)?;
    Ok(left.map(|left| NoiseModel::learn_of_each(tangent, observations, &left, expected)))
}

/// What is left of each push where every origin has its component beside a noise; none where nothing
/// can be fitted.
fn left_beside(
    tangent: &Tangent,
    observations: &Observations,
    settings: &RemainSettings,
    noise: &NoiseModel,
) -> Result<Option<LeftOfPushes>, DiagnosisError> {
    let whitening = noise.whitening_at(observations, &tangent.linearisation)?;
    let columns = Columns::of(tangent, (observations, &whitening), |_| true, settings.tolerances);
    Ok(left_by_all(&columns, &whitening.rows()))
}

/// An origin, its component with as much freedom as gains most on held-out pushes, and what that gains.
struct Own<'a> {
    origin: Origin,
    groups: &'a [Range<usize>],
    alone: Gains,
    gain: Gain,
}

impl<'a> Own<'a> {
    fn of(
        (folds, observations): (&Folds, &Observations),
        (origin, groups): (Origin, &'a Vec<Range<usize>>),
    ) -> Option<Self> {
        let with = |n: usize| {
            let alone = folds.alone(&groups[..n])?;
            let gain = alone.of_clusters(observations);
            Some(Self { origin, groups: &groups[..n], alone, gain })
        };
        let all: Vec<Self> = (1..=groups.len()).map(with).collect::<Option<_>>()?;
        all.into_iter().max_by(|a, b| a.gain.mean.total_cmp(&b.gain.mean))
    }
}

fn shares(
    folds: &Folds,
    columns: &Columns,
    observations: &Observations,
) -> Option<(Remains, Vec<Beside>)> {
    let used = Origin::ALL.into_iter().zip(&columns.origins).filter(|(_, own)| !own.is_empty());
    let used = used.map(|own| Own::of((folds, observations), own));
    let used: Vec<Own> = used.collect::<Option<_>>()?;
    let groups = |which: &dyn Fn(Origin) -> bool| -> Vec<Range<usize>> {
        used.iter().filter(|own| which(own.origin)).flat_map(|own| own.groups.to_vec()).collect()
    };
    let together = groups(&|_| true);
    let variances = folds.variances(&together)?;
    let all = folds.gains(&together, &variances)?;
    let gain = all.of_clusters(observations);
    let share = |part: f64| gain.is_sure().then(|| (part / gain.mean).clamp(0.0, 1.0));
    let of_origin = |own: &Own| {
        let others = groups(&|origin| origin != own.origin);
        let of_others = |variances: &Vec<f64>| {
            let all = together.iter().zip(variances);
            all.filter(|(group, _)| others.contains(group)).map(|(_, variance)| *variance).collect()
        };
        let without: Vec<Vec<f64>> = variances.iter().map(of_others).collect();
        let without = folds.gains(&others, &without)?.of_clusters(observations);
        let at = || place(&columns.of_steps(&own.alone.of_rows), observations);
        Some(OriginShare {
            origin: own.origin,
            gain: own.gain,
            alone: share(own.gain.mean),
            last_in: share(gain.mean - without.mean),
            at: own.gain.is_sure().then(at).flatten(),
        })
    };
    let mut origins: Vec<OriginShare> = used.iter().map(of_origin).collect::<Option<_>>()?;
    origins.sort_by(|a, b| b.gain.mean.total_cmp(&a.gain.mean));
    let smooth = folds.alone(std::slice::from_ref(&columns.smooth))?.of_clusters(observations);
    let besides = used.iter().map(|own| beside((folds, columns), (own.origin, own.groups)));
    let besides = besides.flatten().flatten().collect();
    Some((Remains { gain, share: all.share_of_square(), smooth, origins }, besides))
}

impl Remains {
    /// The origin that holds most, if any is sure to hold something.
    pub fn main(&self) -> Option<&OriginShare> {
        self.origins.first().filter(|one| one.gain.is_sure())
    }
}

impl Gains {
    fn of_clusters(&self, observations: &Observations) -> Gain {
        let mut of_clusters = vec![0.0; observations.n_clusters()];
        for (cluster, gains) in observations.clusters_of_pushes().into_iter().zip(&self.of_rows) {
            of_clusters[cluster] += gains.sum();
        }
        Gain::of(&of_clusters)
    }
}

#[cfg(test)]
mod tests {
    use effects::{Origin, by_id};
    use models::Description;

    use super::{At, Beside, RemainSettings, Remains, Tangent, remains};
    use crate::fit::fit_with_noise;
    use crate::synthetic::pushed_with;
    use crate::{FitSettings, NoiseModel, Observations, Tolerances};

    /// What a model leaves of pushes, and what becomes of its effects.
    fn looked_at(observations: &Observations, model: &Description) -> (Remains, Vec<Beside>) {
        let noise = NoiseModel::learn(model, &[], observations).unwrap();
        let settings = RemainSettings { own: &[], tolerances: Tolerances::default(), seed: 1 };
        let tangent = Tangent::of_all(model, &[], observations).unwrap();
        let about = (&noise, At::Middle);
        let found = remains((&tangent, model), observations, about, |_| true, &settings);
        found.unwrap().unwrap()
    }

    /// What the nominal model leaves of pushes with an effect.
    fn left_of(hidden: (&str, &[f64])) -> Remains {
        let (observations, model, _) = pushed_with(hidden, 1);
        looked_at(&observations, &model).0
    }

    /// An effect that is fitted to pushes with an effect, beside all that its origin could do.
    fn beside_its_origin(fitted: &str, hidden: (&str, &[f64])) -> Beside {
        let (observations, model, _) = pushed_with(hidden, 1);
        let noise = NoiseModel::learn(&model, &[], &observations).unwrap();
        let settings = FitSettings::default();
        let fit = fit_with_noise(&observations, &model, &[fitted], &noise, &settings).unwrap();
        let (_, besides) = looked_at(&observations, &fit.with_nuisances);
        besides.into_iter().find(|beside| beside.id == fitted).unwrap()
    }

    #[test]
    fn what_is_there_keeps_its_size_whatever_else_its_origin_may_do() {
        for (id, values) in [
            ("table-anisotropy", &[0.6, 1.3][..]),
            ("body-anisotropy", &[0.6, 1.3]),
            ("pressure-radius", &[1.2]),
            ("friction-gradient", &[2.0, -1.0]),
        ] {
            let found = beside_its_origin(id, (id, values));
            assert!(found.stands() && !found.is_moved(), "{found:?}");
        }
    }

    #[test]
    fn what_takes_the_shape_of_another_cause_gives_it_up_to_it() {
        let direction_and_ratio: &[f64] = &[0.6, 1.3];
        for (fitted, hidden) in [
            ("support-friction", ("friction-gradient", &[2.0, -1.0][..])),
            ("table-anisotropy", ("table-tilt", &[0.3, 0.2])),
            ("table-tilt", ("table-anisotropy", direction_and_ratio)),
            ("body-anisotropy", ("friction-center-offset", &[0.008, -0.004])),
        ] {
            let found = beside_its_origin(fitted, hidden);
            assert!(found.is_moved() && !found.stands(), "{found:?}");
            let told = found.sentence();
            let origin = found.origin.name();
            assert!(told.contains(&format!("more freedom of the {origin} beside it")), "{told}");
        }
    }

    #[test]
    fn what_is_left_comes_most_from_where_an_effect_does() {
        for (id, origin) in [
            ("table-anisotropy", Origin::Table),
            ("pusher-friction-asymmetry", Origin::Contact),
            ("body-anisotropy", Origin::Support),
            ("force-bias", Origin::Measurement),
        ] {
            let parameters = by_id(id).unwrap().info().parameters;
            let typical: Vec<f64> = parameters.iter().map(|one| one.typical).collect();
            let found = left_of((id, &typical));
            let main = found.main().unwrap();
            assert_eq!(main.origin, origin, "{id}: {found:?}");
            assert!(main.alone.is_some_and(|share| share > 0.5), "{id}: {found:?}");
        }
    }

    #[test]
    fn nothing_is_left_of_what_the_model_has() {
        let found = left_of(("pusher-friction", &[0.25]));
        assert!(found.main().is_none() && found.share < 0.01, "{found:?}");
    }
}
