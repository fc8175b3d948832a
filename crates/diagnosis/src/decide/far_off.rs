//! The few pushes that are missed by far, and what they share.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use effects::Origin;
use models::Cluster;
use nalgebra::Vector2;
use rand::SeedableRng;
use rand::seq::index::sample;
use rand_chacha::ChaCha8Rng;

use super::DiagnoseSettings;
use super::standing::Standing;
use crate::cut_offs::{FAR, FEWEST_FAR, MOST_FAR};

/// What pushes that are missed by far have in common.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Shared {
    n_far: usize,
    n_pushes: usize,
    /// Probability that as many pushes of each session, where sessions are the clusters, or of all
    /// pushes, drawn at random, lie together as closely.
    pub(super) p: f64,
    /// What of the rig is there.
    pub(super) origin: Origin,
    /// Where they lie, in words.
    place: String,
}

/// A push at its worst step.
#[derive(Clone, Copy, Debug)]
struct Worst {
    /// Among which pushes another one could have been missed as well: those of its session where
    /// sessions share errors, else all.
    stratum: usize,
    /// Largest error of a number over its standard deviation.
    error: f64,
    /// Contact point on the object, in m.
    contact_b: Vector2<f64>,
    /// The object on the table, in m.
    object_w: Vector2<f64>,
    /// Yaw of the object, in rad.
    yaw: f64,
    /// In m/s.
    speed: f64,
    /// Place in the order of the set, 0 to 1.
    time: f64,
}

/// Draws of as many pushes at random.
const N_DRAWS: usize = 1999;

/// What the pushes that the best model misses by far share, of those fitted to and those held out.
///
/// A chipped corner or a dent of the table spoils a few pushes entirely and all others not at all: no
/// mean shows it. That the few lie together does.
pub(super) fn shared_by_far_off(
    parts: [&Standing; 2],
    settings: &DiagnoseSettings,
) -> Option<Shared> {
    let mut pushes: Vec<Worst> = Vec::new();
    for standing in parts {
        // Sessions stay whole, so those of the parts are different ones.
        let first = match standing.observations.cluster {
            Cluster::Push => 0,
            Cluster::Session => pushes.iter().map(|push| push.stratum + 1).max().unwrap_or(0),
        };
        let own = worst_steps(standing);
        pushes.extend(own.into_iter().map(|one| Worst { stratum: first + one.stratum, ..one }));
    }
    shared(&pushes, settings.seed)
}

fn worst_steps(standing: &Standing) -> Vec<Worst> {
    let Standing { observations, residuals, whitening, .. } = standing;
    let mut worst = vec![(0.0, None); observations.pushes.len()];
    for (step, number, sd) in whitening.sd() {
        let error = residuals[step][number].map_or(0.0, |residual| (residual / sd).abs());
        let of_push: &mut (f64, Option<usize>) = &mut worst[observations.push_of[step]];
        if of_push.1.is_none() || error > of_push.0 {
            *of_push = (error, Some(step));
        }
    }
    let at = |(error, step): (f64, Option<usize>)| {
        let step = step?;
        let (input, place) = (&observations.steps[step].input, &observations.places[step]);
        Some(Worst {
            error,
            stratum: match observations.cluster {
                Cluster::Push => 0,
                Cluster::Session => observations.cluster_of[step],
            },
            contact_b: input.object.shape().point_at(place.edge as usize, place.p),
            object_w: input.pose_wb.position,
            yaw: input.pose_wb.angle,
            speed: place.speed,
            time: input.progress,
        })
    };
    worst.into_iter().filter_map(at).collect()
}

/// The likeliest thing that the pushes missed by far share; none if there are too few or too many.
fn shared(pushes: &[Worst], seed: u64) -> Option<Shared> {
    let far: Vec<usize> = (0..pushes.len()).filter(|push| pushes[*push].error >= FAR).collect();
    let n_most = (MOST_FAR * pushes.len() as f64) as usize;
    if far.len() < FEWEST_FAR || far.len() > n_most {
        return None;
    }
    let draws = draws(pushes, &far, seed);
    let of_axis = |axis: &Axis| {
        let points: Vec<Vector2<f64>> = pushes.iter().map(axis.point).collect();
        let together = spread(&points, &far);
        let closer = draws.iter().filter(|draw| spread(&points, draw) <= together).count();
        let p = (AXES.len() * (1 + closer)) as f64 / (1 + N_DRAWS) as f64;
        let place = (axis.told)(&far.iter().map(|push| pushes[*push]).collect::<Vec<_>>());
        Shared {
            n_far: far.len(),
            n_pushes: pushes.len(),
            p: p.min(1.0),
            origin: axis.origin,
            place,
        }
    };
    AXES.iter().map(of_axis).min_by(|a, b| a.p.total_cmp(&b.p))
}

/// As many pushes of each stratum as are missed by far, at random: that a session goes wrong as a whole
/// says nothing of what its pushes share.
fn draws(pushes: &[Worst], far: &[usize], seed: u64) -> Vec<Vec<usize>> {
    let mut strata: BTreeMap<usize, (Vec<usize>, usize)> = BTreeMap::new();
    for (push, worst) in pushes.iter().enumerate() {
        let (members, n_far) = strata.entry(worst.stratum).or_default();
        members.push(push);
        *n_far += usize::from(far.contains(&push));
    }
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut draw = |(members, n): &(Vec<usize>, usize)| -> Vec<usize> {
        sample(&mut random, members.len(), *n).iter().map(|k| members[k]).collect()
    };
    (0..N_DRAWS).map(|_| strata.values().flat_map(&mut draw).collect()).collect()
}

/// Mean distance between the pushes of a draw.
fn spread(points: &[Vector2<f64>], draw: &[usize]) -> f64 {
    let pairs =
        draw.iter().enumerate().flat_map(|(k, one)| draw[..k].iter().map(move |b| (*one, *b)));
    let (sum, n) = pairs.fold((0.0, 0.0), |(sum, n), (one, other)| {
        (sum + (points[one] - points[other]).norm(), n + 1.0)
    });
    sum / n
}

/// Something that pushes may share.
struct Axis {
    /// What of the rig it is.
    origin: Origin,
    /// Where a push lies on it.
    point: fn(&Worst) -> Vector2<f64>,
    /// Where all of some lie.
    told: fn(&[Worst]) -> String,
}

static AXES: [Axis; 5] = [
    Axis {
        origin: Origin::Contact,
        point: |push| push.contact_b,
        told: |pushes| format!("touch {} of the object", around(pushes, |push| push.contact_b)),
    },
    Axis {
        origin: Origin::Table,
        point: |push| push.object_w,
        told: |pushes| format!("are {} of the table", around(pushes, |push| push.object_w)),
    },
    Axis {
        origin: Origin::Table,
        point: |push| Vector2::new(push.yaw.cos(), push.yaw.sin()),
        told: |pushes| {
            let sum: Vector2<f64> =
                pushes.iter().map(|push| Vector2::new(push.yaw.cos(), push.yaw.sin())).sum();
            let middle = sum.y.atan2(sum.x);
            let off = |push: &Worst| planar::wrap_angle(push.yaw - middle).abs();
            let width = pushes.iter().map(off).fold(0.0, f64::max);
            let [middle, width] = [middle, width].map(|angle| 180.0 / PI * angle);
            format!("find the object turned by {middle:.0}° give or take {width:.0}°")
        },
    },
    Axis {
        origin: Origin::Dynamics,
        point: |push| Vector2::new(push.speed.max(f64::MIN_POSITIVE).ln(), 0.0),
        told: |pushes| {
            let [low, high] = ends(pushes, |push| 1e3 * push.speed);
            format!("go at {low:.0} to {high:.0} mm/s")
        },
    },
    Axis {
        origin: Origin::Time,
        point: |push| Vector2::new(push.time, 0.0),
        told: |pushes| {
            let [low, high] = ends(pushes, |push| 100.0 * push.time);
            format!("come after {low:.0} to {high:.0} % of the recordings")
        },
    },
];

/// As "within 12 mm of (44, −31) mm".
fn around(pushes: &[Worst], place: fn(&Worst) -> Vector2<f64>) -> String {
    let middle = pushes.iter().map(place).sum::<Vector2<f64>>() / pushes.len() as f64;
    let radius = pushes.iter().map(|push| (place(push) - middle).norm()).fold(0.0, f64::max);
    let [x, y, radius] = [middle.x, middle.y, radius].map(|length| 1e3 * length);
    format!("within {radius:.0} mm of ({x:.0}, {y:.0}) mm")
}

fn ends(pushes: &[Worst], value: fn(&Worst) -> f64) -> [f64; 2] {
    let values = || pushes.iter().map(value);
    [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)]
}

impl Shared {
    /// As "misses 4 of 120 pushes by far, which touch within 12 mm of (44, −31) mm of the object".
    pub(super) fn sentence(&self) -> String {
        let Self { n_far, n_pushes, place, .. } = self;
        format!("misses {n_far} of {n_pushes} pushes by far, and those {place}")
    }
}

#[cfg(test)]
mod tests {
    use super::{FAR, Worst, shared};
    use effects::Origin;
    use nalgebra::Vector2;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Pushes anywhere, of which some are missed by far.
    fn pushes(seed: u64, is_far: impl Fn(usize, &Worst) -> bool) -> Vec<Worst> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let push = |k: usize| {
            let mut at = |half: f64| random.random_range(-half..half);
            let mut push = Worst {
                stratum: 0,
                error: 2.0,
                contact_b: Vector2::new(at(0.045), at(0.045)),
                object_w: Vector2::new(at(0.1), at(0.1)),
                yaw: at(3.0),
                speed: 0.05 + at(0.04),
                time: k as f64 / 120.0,
            };
            push.error = if is_far(k, &push) { 4.0 * FAR } else { 2.0 };
            push
        };
        (0..120).map(push).collect()
    }

    #[test]
    fn pushes_missed_at_one_corner_share_it() {
        let corner = Vector2::new(0.045, -0.045);
        let all = pushes(3, |_, push| (push.contact_b - corner).norm() < 0.018);
        let found = shared(&all, 7).unwrap();
        assert!(found.p <= 0.01, "{found:?}");
        assert!(found.sentence().contains("of the object"), "{}", found.sentence());
        assert_eq!(found.origin, Origin::Contact);
    }

    #[test]
    fn pushes_missed_in_a_part_of_the_set_share_the_time() {
        let found = shared(&pushes(4, |k, _| (60..66).contains(&k)), 7).unwrap();
        assert!(found.p <= 0.01 && found.sentence().ends_with("50 to 54 % of the recordings"));
        assert_eq!(found.origin, Origin::Time);
    }

    #[test]
    fn a_session_that_goes_wrong_says_nothing_of_its_place() {
        // Each session of six is at a place of its own, and one of them is missed in five of six.
        let all = |missed: fn(usize) -> bool| {
            let mut all = pushes(6, |k, _| missed(k));
            for (k, push) in all.iter_mut().enumerate() {
                push.stratum = k / 6;
                let place = Vector2::new((k / 6) as f64 * 0.02 - 0.2, 0.1);
                push.object_w = place + 0.01 * push.object_w;
            }
            all
        };
        let wrong = all(|k| (60..65).contains(&k));
        let found = shared(&wrong, 7).unwrap();
        assert!(found.p > 0.05, "{found:?}");
        let mut alone = wrong;
        alone.iter_mut().for_each(|push| push.stratum = 0);
        assert!(shared(&alone, 7).unwrap().p <= 0.01);
        // What goes wrong in the same way in every session is found as before.
        let mut all = all(|_| false);
        let corner = Vector2::new(0.045, -0.045);
        for push in &mut all {
            let is_far = (push.contact_b - corner).norm() < 0.03;
            push.error = if is_far { 4.0 * FAR } else { 2.0 };
        }
        assert!(shared(&all, 7).unwrap().p <= 0.01);
    }

    #[test]
    fn outliers_share_nothing() {
        let is_sure = |seed: u64| {
            let all = pushes(seed, |k, _| k % 24 == 5);
            shared(&all, 7).unwrap().p <= 0.01
        };
        let n_sure = (0..100).filter(|seed| is_sure(*seed)).count();
        assert!(n_sure <= 4, "{n_sure} of 100 where 1 is expected");
    }

    #[test]
    fn two_pushes_or_every_second_one_are_not_asked() {
        assert_eq!(shared(&pushes(5, |k, _| k < 2), 7), None);
        assert_eq!(shared(&pushes(5, |k, _| k % 2 == 0), 7), None);
    }
}
