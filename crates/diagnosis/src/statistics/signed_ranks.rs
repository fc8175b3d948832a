//! Whether a change is made to those that are missed, and the way they are missed.

use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A push that an effect acts on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Acted {
    pub(crate) push: usize,
    /// Whether it is missed by less with the effect.
    pub(crate) gains: bool,
}

/// Draws at most; their number bounds how small a probability can be.
const N_DRAWS: usize = 99_999;
/// As large ones that are enough: a probability of a tenth and more is then known to a hundredth of it.
const ENOUGH: usize = 10_000;

/// Probability that pushes that an effect acts on are missed by so much, and gain so often, if where it acts has
/// nothing to do with what is missed, nor the way it acts.
///
/// The statistic is the sum of the ranks, by how far they are missed without the effect, of those that gain. Each draw
/// takes other pushes of the same stratum for them, and changes gains into losses for whole clusters.
///
/// - `missed`: how far each push is missed without the effect, in any unit.
/// - `strata`: those of each push, within which any other could have been missed as well.
/// - `clusters`: those of each push, whose errors may be shared.
///
/// # Source
/// Of ranks and of signs, as the two tests of Wilcoxon (1945), Individual comparisons by ranking methods, Biometrics
/// Bulletin 1(6), which are put together here; drawn as by Dwass (1957), Modified randomization tests for nonparametric
/// hypotheses, Annals of Mathematical Statistics 28(1), until enough are as large, as by Besag & Clifford (1991),
/// Sequential Monte Carlo p-values, Biometrika 78(2).
pub(crate) fn p_of_signed_ranks(
    missed: &[f64],
    acted: &[Acted],
    (strata, clusters): (&[usize], &[usize]),
    seed: u64,
) -> f64 {
    let ranks = ranks(missed);
    let told: f64 = acted.iter().filter(|one| one.gains).map(|one| ranks[one.push]).sum();
    let mut groups = grouped(acted, strata, clusters);
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut as_large = 0;
    for draw in 1..=N_DRAWS {
        let mut drawn = 0.0;
        for Group { others, gains } in &mut groups {
            let (taken, _) = others.partial_shuffle(&mut random, gains.iter().map(Vec::len).sum());
            let mut taken = taken.iter();
            for of_cluster in &*gains {
                let is_turned: bool = random.random();
                let own = of_cluster.iter().zip(&mut taken);
                let own = own.filter(|(gains, _)| **gains != is_turned);
                drawn += own.map(|(_, push)| ranks[*push]).sum::<f64>();
            }
        }
        as_large += usize::from(drawn >= told - ROUNDING);
        if as_large == ENOUGH {
            return as_large as f64 / draw as f64;
        }
    }
    (1 + as_large) as f64 / (1 + N_DRAWS) as f64
}

/// Ranks are whole or half numbers.
const ROUNDING: f64 = 0.25;

/// The pushes of a stratum, and of those that are acted on, cluster by cluster, whether they gain.
struct Group {
    others: Vec<usize>,
    gains: Vec<Vec<bool>>,
}

fn grouped(acted: &[Acted], strata: &[usize], clusters: &[usize]) -> Vec<Group> {
    let mut sorted = acted.to_vec();
    sorted.sort_by_key(|one| (strata[one.push], clusters[one.push], one.push));
    let of_stratum = |of_stratum: &[Acted]| {
        let own = strata[of_stratum[0].push];
        let of_cluster = of_stratum.chunk_by(|a, b| clusters[a.push] == clusters[b.push]);
        Group {
            others: (0..strata.len()).filter(|push| strata[*push] == own).collect(),
            gains: of_cluster.map(|all| all.iter().map(|one| one.gains).collect()).collect(),
        }
    };
    sorted.chunk_by(|a, b| strata[a.push] == strata[b.push]).map(of_stratum).collect()
}

/// Places in rising order, from 1; the mean place of those that are equal.
fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let mut ranks = vec![0.0; values.len()];
    let mut before = 0;
    for equal in order.chunk_by(|a, b| values[*a] == values[*b]) {
        let middle = before as f64 + 0.5 * (1 + equal.len()) as f64;
        equal.iter().for_each(|k| ranks[*k] = middle);
        before += equal.len();
    }
    ranks
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::{Acted, N_DRAWS, p_of_signed_ranks, ranks};

    /// Of twelve pushes, each a cluster.
    fn p(acted: &[(usize, bool)]) -> f64 {
        let missed: Vec<f64> = (0..12).map(f64::from).collect();
        let acted: Vec<Acted> =
            acted.iter().map(|(push, gains)| Acted { push: *push, gains: *gains }).collect();
        let clusters: Vec<usize> = (0..12).collect();
        p_of_signed_ranks(&missed, &acted, (&[0; 12], &clusters), 7)
    }

    #[test]
    fn probabilities_are_those_of_all_draws() {
        // The three of 220 that are missed most, with one of eight signs.
        let all = p(&[(9, true), (10, true), (11, true)]);
        let sd = (1.0 / 1760.0 / N_DRAWS as f64).sqrt();
        assert!((all - 1.0 / 1760.0).abs() < 4.0 * sd, "{all}");
        // Two ranks of twelve with one of four signs, 12 + 11, or 12 + 10.
        let second = p(&[(9, true), (11, true)]);
        let exact = 2.0 / 66.0 / 4.0;
        assert!((second - exact).abs() < 4.0 * (exact / N_DRAWS as f64).sqrt(), "{second}");
        assert!(p(&[(9, true), (10, true), (11, false)]) > 0.01);
        assert!(p(&[(0, true), (1, true), (2, true)]) > 0.1);
        assert_eq!(p(&[]), 1.0);
    }

    #[test]
    fn pushes_of_a_session_gain_together_and_are_drawn_among_themselves() {
        let missed: Vec<f64> = (0..12).map(f64::from).collect();
        let acted = [8, 9, 10, 11].map(|push| Acted { push, gains: true });
        let sessions: Vec<usize> = (0..12).map(|push| push / 4).collect();
        let told = p_of_signed_ranks(&missed, &acted, (&sessions, &sessions), 7);
        assert!((told - 0.5).abs() < 0.01, "{told}");
    }

    #[test]
    fn by_chance_one_in_twenty_is_at_most_a_twentieth() {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let mut is_small = || {
            let missed: Vec<f64> = (0..30).map(|_| random.random_range(0.5..1.5)).collect();
            let acted: Vec<Acted> =
                (0..5).map(|k| Acted { push: 6 * k, gains: random.random() }).collect();
            let clusters: Vec<usize> = (0..30).collect();
            p_of_signed_ranks(&missed, &acted, (&[0; 30], &clusters), 7) <= 0.05
        };
        let n = (0..100).filter(|_| is_small()).count();
        // 99 % of binomial counts of 100 draws at 0.05.
        assert!((1..=11).contains(&n), "{n}");
    }

    #[test]
    fn equal_values_share_their_ranks() {
        assert_eq!(ranks(&[2.0, 1.0, 2.0, 3.0]), [2.5, 1.0, 2.5, 4.0]);
    }
}
