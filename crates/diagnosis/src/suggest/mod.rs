//! Candidates that look alike go in, the pushes come out that would tell most, among those that a
//! rig can do.

mod aim;
mod area;
mod choice;
mod halton;
mod planned;
mod precision;
mod route;
mod separation;
mod standpoint;

use std::sync::Arc;

use effects::Effect;
use models::Description;
use nalgebra::Vector2;
use planar::Pose;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

pub use self::aim::Aim;
pub use self::precision::Precision;
pub use self::separation::Separation;

use self::area::Reach;
use self::planned::Planned;
use self::precision::Precisions;
use self::route::Route;
use self::separation::Separations;
use self::standpoint::Standpoint;
use crate::{DiagnosisError, NoiseModel, Observations, Tolerances};

/// Which pushes may be suggested, and how many.
#[derive(Clone, Debug)]
pub struct SuggestSettings {
    /// Effects besides those of the catalogue.
    pub own: Vec<Arc<dyn Effect>>,
    /// How exactly the nominal values are known.
    pub tolerances: Tolerances,
    /// How many pushes, repeats counted.
    pub n_pushes: usize,
    /// How often each of them is done: repeats show the noise.
    pub n_repeats: usize,
    /// Seed of the candidates and of the order.
    pub seed: u64,
    /// Pushes among which is chosen.
    pub n_candidates: usize,
    /// Speeds to choose from, in m/s; if there are none, half of the set's slowest to twice its
    /// fastest.
    pub speeds: Vec<f64>,
    /// Smallest and largest x, and y, that the body's origin may have on the table, in m; else a
    /// square about where it was.
    pub area: Option<[[f64; 2]; 2]>,
    /// Way of the pusher after the touch, in m; else what is usual in the set.
    pub travel: Option<f64>,
    /// Largest angle from the inward normal, in rad.
    pub steepest: f64,
}

impl Default for SuggestSettings {
    fn default() -> Self {
        Self {
            own: Vec::new(),
            tolerances: Tolerances::default(),
            n_pushes: 20,
            n_repeats: 5,
            seed: 7,
            n_candidates: 300,
            speeds: Vec::new(),
            area: None,
            travel: None,
            steepest: 40.0_f64.to_radians(),
        }
    }
}

/// Pushes to do next, in the order in which to do them, and what they are expected to tell.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Suggestion {
    /// The pushes.
    pub pushes: Vec<SuggestedPush>,
    /// How well each pair of rivals will be told apart.
    pub separations: Vec<Separation>,
    /// How exactly the parameters of an effect will be known.
    pub precisions: Vec<Precision>,
    /// Pushes among which was chosen: those of the candidates that can be done.
    #[serde(skip)]
    pub feasible: Vec<SuggestedPush>,
    /// Candidates in all.
    pub n_candidates: usize,
    /// Smallest and largest x, and y, of the body's origin on the table, in m.
    pub area: [[f64; 2]; 2],
    /// The pusher's radius, to whose center the path belongs, in m.
    pub pusher_radius: f64,
}

/// A push to be done.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SuggestedPush {
    /// 0-based edge of the outline, from vertex i to i + 1.
    pub edge: usize,
    /// Place of the contact along it, 0 to 1.
    pub p: f64,
    /// From the inward normal to the pusher's velocity, counter-clockwise positive, in rad.
    pub angle: f64,
    /// Speed of the pusher, in m/s.
    pub speed: f64,
    /// Straight way of the pusher after the touch, in m.
    pub travel: f64,
    /// Pose of B in W at which the object is laid down.
    #[serde(serialize_with = "pose")]
    pub pose_wb: Pose,
    /// The pusher's center where the push begins, where it touches and where it ends, in m,
    /// frame W.
    pub path_w: [Vector2<f64>; 3],
    /// Name of the group of equal pushes that it belongs to.
    pub repeat: String,
}

fn pose<S: serde::Serializer>(pose: &Pose, serializer: S) -> Result<S::Ok, S::Error> {
    [pose.position.x, pose.position.y, pose.angle].serialize(serializer)
}

/// Random choices that the chosen pushes are compared with.
const N_RANDOM: usize = 32;

/// The pushes among many that can be done which tell the most: of rivals, of parameters, or of an
/// effect that was not testable.
///
/// Rivals are refitted to the observations. Pushes are chosen to make the worst told pair as far
/// apart as possible: the whitened distance of one's predictions from the other's, after the free
/// numbers of the other have followed as far as the observations let them (T-optimality). For
/// parameters the determinant of their information beside the nuisances is made large
/// (D-optimality). A greedy choice is improved by exchanges; all of it is of first order in the
/// free numbers.
///
/// - `known`: effects beside the model's that are claimed anyway.
///
/// # Errors
/// `NothingToSuggest`, `NoFeasiblePush`, `NoPushShows`; what the model or the fits refuse.
///
/// # Source
/// Atkinson & Fedorov (1975); Fedorov (1972) for exchanges.
pub fn suggest(
    observations: &Observations,
    model: &Description,
    known: &[&str],
    aim: &Aim,
    settings: &SuggestSettings,
) -> Result<Suggestion, DiagnosisError> {
    let (noise, standpoints) = standpoints(observations, model, &aim.claims(known), settings)?;
    let reach = Reach::of(observations, settings);
    let routes = route::candidates(observations, &standpoints[0], &reach, settings)?;
    let planned = Planned::new(observations, &routes);
    let n_designs = settings.n_pushes.div_ceil(settings.n_repeats.max(1)).clamp(1, routes.len());
    let counts: Vec<f64> = (0..n_designs)
        .map(|k| {
            let left = settings.n_pushes - (k * settings.n_repeats).min(settings.n_pushes);
            left.min(settings.n_repeats).max(1) as f64
        })
        .collect();
    let mut rng = ChaCha8Rng::seed_from_u64(settings.seed);
    let (chosen, separations, precisions) = match aim {
        Aim::Rivals(_) => {
            let work = Separations::new(aim, &standpoints, observations, &planned, &noise)?;
            let chosen = choice::best(&counts, routes.len(), |design| work.value(design));
            let random = choice::random(&counts, routes.len(), N_RANDOM, &mut rng);
            let told = work.told(&chosen, &random);
            (chosen, told, Vec::new())
        }
        Aim::Precision(ids) | Aim::Testable(ids) => {
            let is_in_model = matches!(aim, Aim::Precision(_));
            let work = Precisions::new(ids, &standpoints[0], observations, &planned, &noise)?;
            let chosen = choice::best(&counts, routes.len(), |design| work.value(design));
            let random = choice::random(&counts, routes.len(), N_RANDOM, &mut rng);
            let told = work.told(&chosen, &random)?;
            if !is_in_model {
                precision::check(ids, &told)?;
            }
            (chosen, Vec::new(), told)
        }
    };
    let mut pushes = repeated(&routes, &chosen);
    pushes.shuffle(&mut rng);
    Ok(Suggestion {
        pushes,
        separations,
        precisions,
        feasible: routes.into_iter().map(|route| route.push).collect(),
        n_candidates: settings.n_candidates,
        area: reach.area,
        pusher_radius: reach.pusher_radius,
    })
}

/// The noise and the fitted models: beside the first, the noise is not what the model misses.
fn standpoints(
    observations: &Observations,
    model: &Description,
    claims: &[Vec<&str>],
    settings: &SuggestSettings,
) -> Result<(NoiseModel, Vec<Standpoint>), DiagnosisError> {
    let stand = |ids: &[&str], noise: &NoiseModel| {
        Standpoint::fitted(observations, model, ids, noise, settings)
    };
    let rough = NoiseModel::learn(model, &settings.own, observations)?;
    let first = stand(&claims[0], &rough)?;
    let noise = NoiseModel::learn(&first.description, &settings.own, observations)?;
    let others = claims[1..].iter().map(|ids| stand(ids, &noise));
    let all = std::iter::once(Ok(first)).chain(others).collect::<Result<_, _>>()?;
    Ok((noise, all))
}

/// Every chosen push as often as it is to be done.
fn repeated(routes: &[Route], design: &[(usize, f64)]) -> Vec<SuggestedPush> {
    let copies = design.iter().enumerate().flat_map(|(index, (route, count))| {
        let repeat = format!("suggested-{}", index + 1);
        let push = SuggestedPush { repeat, ..routes[*route].push.clone() };
        std::iter::repeat_n(push, *count as usize)
    });
    copies.collect()
}
