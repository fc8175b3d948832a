//! The best few of many.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

/// Rounds of exchanges.
const MOST_ROUNDS: usize = 4;
/// A value is better if it is larger by this share.
const BETTER: f64 = 1.0 + 1e-9;

/// Different candidates that together have the largest value, each with how often it is done: one
/// after the other, then each exchanged for a better one as long as that helps. There are at least
/// as many candidates as counts.
pub(super) fn best(
    counts: &[f64],
    n_candidates: usize,
    value: impl Fn(&[(usize, f64)]) -> f64 + Sync,
) -> Vec<(usize, f64)> {
    let mut design: Vec<(usize, f64)> = Vec::new();
    let with = |design: &[(usize, f64)], place: usize, candidate: usize| {
        let mut other = design.to_vec();
        match other.get_mut(place) {
            Some(old) => old.0 = candidate,
            None => other.push((candidate, counts[place])),
        }
        other
    };
    let best_at = |design: &[(usize, f64)], place: usize| {
        let is_free = |candidate: &usize| {
            let mut others = design.iter().enumerate();
            others.all(|(index, (other, _))| index == place || other != candidate)
        };
        let of = |candidate: usize| (value(&with(design, place, candidate)), candidate);
        let values: Vec<(f64, usize)> =
            (0..n_candidates).into_par_iter().filter(is_free).map(of).collect();
        values.into_iter().fold((f64::NEG_INFINITY, 0), |a, b| if b.0 > a.0 { b } else { a })
    };
    let mut reached = f64::NEG_INFINITY;
    for place in 0..counts.len() {
        let (value, candidate) = best_at(&design, place);
        design = with(&design, place, candidate);
        reached = value;
    }
    for _ in 0..MOST_ROUNDS {
        let before = reached;
        for place in 0..counts.len() {
            let (value, candidate) = best_at(&design, place);
            if value > reached {
                design = with(&design, place, candidate);
                reached = value;
            }
        }
        if reached <= before * BETTER {
            break;
        }
    }
    design
}

/// Designs of the same size whose pushes are drawn among all candidates.
pub(super) fn random(
    counts: &[f64],
    n_candidates: usize,
    n: usize,
    rng: &mut ChaCha8Rng,
) -> Vec<Vec<(usize, f64)>> {
    let mut draw =
        || counts.iter().map(|count| (rng.random_range(0..n_candidates), *count)).collect();
    (0..n).map(|_| draw()).collect()
}

#[cfg(test)]
mod tests {
    use super::best;

    #[test]
    fn exchanges_find_what_a_greedy_choice_misses() {
        // The best single push is 0, but 1 and 2 together are better than 0 with any other.
        let value = |design: &[(usize, f64)]| {
            let has = |k: usize| design.iter().any(|(one, _)| *one == k);
            let single = if has(0) { 2.0 } else { 0.0 } + if has(1) { 1.0 } else { 0.0 };
            if has(1) && has(2) { 10.0 + single } else { single }
        };
        let mut found: Vec<_> = best(&[5.0; 2], 4, value).iter().map(|one| one.0).collect();
        found.sort_unstable();
        assert_eq!(found, [1, 2]);
        let sizes: Vec<_> = best(&[5.0, 2.0], 4, value).iter().map(|one| one.1).collect();
        assert_eq!(sizes, [5.0, 2.0]);
    }

    #[test]
    fn no_candidate_is_taken_twice() {
        let value = |design: &[(usize, f64)]| design.iter().map(|(k, n)| *k as f64 * n).sum();
        let mut found: Vec<_> = best(&[1.0; 3], 6, value).iter().map(|one| one.0).collect();
        found.sort_unstable();
        assert_eq!(found, [3, 4, 5]);
    }
}
