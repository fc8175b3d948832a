//! Holding pushes out before anything is fitted.

use std::collections::BTreeSet;

use models::Split;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use crate::data::observations::FEWEST_PUSHES;
use crate::data::repeats::{FEWEST_REPEATS, cells};
use crate::{DiagnosisError, Observations, RepeatTolerance};

/// One of so many clusters is held out.
const SHARE: usize = 4;
/// Choices among which one with repeats in both parts is looked for.
const MOST_DRAWS: usize = 200;

/// Holds a quarter of the clusters out to confirm what is fitted to the others.
///
/// A cluster is a measuring session where the whole set has at least twelve, else a push; parts keep
/// the clusters of their whole. The choice is random, but for this: of two hundred draws the first is taken that leaves both parts the repeats
/// that a noise floor needs, or comes nearest to it. It does not depend on the order of the pushes.
///
/// # Errors
/// `TooFewPushes` where a part would have fewer than three.
pub fn split(observations: &Observations, seed: u64) -> Result<Split, DiagnosisError> {
    let clusters = clusters(observations);
    let cells = cells(observations, &RepeatTolerance::default());
    let n_repeats = |pushes: &[usize]| {
        pushes.len() - pushes.iter().map(|push| cells[*push]).collect::<BTreeSet<_>>().len()
    };
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let n_aside = (clusters.len() + SHARE / 2) / SHARE;
    let mut draw = || {
        let mut order: Vec<&Vec<usize>> = clusters.iter().collect();
        order.shuffle(&mut rng);
        let kept = order.split_off(n_aside);
        [kept, order].map(|part| part.into_iter().flatten().copied().collect::<Vec<_>>())
    };
    let score = |parts: &[Vec<usize>; 2]| -> usize {
        parts.iter().map(|part| n_repeats(part).min(FEWEST_REPEATS)).sum()
    };
    let all: Vec<usize> = (0..cells.len()).collect();
    let best = n_repeats(&all).min(2 * FEWEST_REPEATS);
    let mut parts = draw();
    for _ in 1..MOST_DRAWS {
        if score(&parts) >= best {
            break;
        }
        let other = draw();
        if score(&other) > score(&parts) {
            parts = other;
        }
    }
    if parts.iter().any(|part| part.len() < FEWEST_PUSHES) {
        let needed = SHARE * FEWEST_PUSHES - SHARE / 2;
        return Err(observations.too_few(all.len(), needed));
    }
    let [fit, confirm] = parts.map(|mut part| {
        part.sort_unstable();
        part.iter().map(|push| observations.pushes[*push].to_string()).collect()
    });
    let (set, cluster) = (observations.set.clone(), observations.cluster);
    Ok(Split { set, seed, cluster, fit, confirm, confirm_set: None })
}

/// The pushes of each cluster, in an order that is not the table's.
pub(crate) fn clusters(observations: &Observations) -> Vec<Vec<usize>> {
    let name = |push: &usize| &observations.pushes[*push];
    let mut clusters = observations.pushes_of_clusters();
    clusters.iter_mut().for_each(|pushes| pushes.sort_by_key(name));
    clusters.sort_by(|a, b| a.iter().map(name).cmp(b.iter().map(name)));
    clusters
}
