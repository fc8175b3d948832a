//! Whether an effect has the same size all over a set.

use nalgebra::{DMatrix, DVector};
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use crate::cut_offs::{DIFFERENT, DIFFERENT_SHARE, FEWEST_IN_GROUP, N_GROUPS, NAME, ONE_SPEED};
use crate::fit::Pulls;
use crate::statistics::quantile::normal_of_chi_square;
use crate::{Covariate, Observations};

/// An effect whose size is another one in other pushes: a cause has one size.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Varies {
    over: Covariate,
    /// Standard deviation over groups of pushes beyond their errors, over the effect's size.
    share: f64,
}

/// Along which pushes are grouped.
const ALONG: [Covariate; 6] = [
    Covariate::Time,
    Covariate::TableX,
    Covariate::TableY,
    Covariate::Direction,
    Covariate::Speed,
    Covariate::Orientation,
];
/// Random deals of the pushes.
const N_DEALS: usize = 999;
/// Pushes of the usual scatter that stand beside a group's own, whose scatter few pushes do not tell.
const USUAL: f64 = 5.0;

impl Varies {
    /// Whether it is another one in other places of the table.
    pub(super) fn is_over_table(&self) -> bool {
        matches!(self.over, Covariate::TableX | Covariate::TableY)
    }

    pub(super) fn sentence(&self) -> String {
        let percent = 100.0 * self.share;
        format!(
            "its size differs by {percent:.0} % over {}, so that another cause may take its shape",
            self.over.name()
        )
    }
}

/// Along what an effect's size differs most surely between groups of pushes, if it does: by Cochran's
/// Q, by more than pushes do that are dealt out to the groups at random, and by more than a quarter of it.
///
/// # Source
/// DerSimonian & Laird (1986), Meta-analysis in clinical trials, Controlled Clinical Trials 7.
pub(super) fn varies(pulls: &Pulls, observations: &Observations, seed: u64) -> Option<Varies> {
    let grouped = ALONG.iter().filter_map(|over| Some((*over, groups(observations, *over)?)));
    let (along, groups): (Vec<Covariate>, Vec<Vec<Vec<usize>>>) = grouped.unzip();
    let differs = |(over, groups): (&Covariate, &Vec<Vec<usize>>)| {
        let (z, share) = spread(pulls, groups)?;
        (z >= DIFFERENT && share >= DIFFERENT_SHARE).then_some((z, Varies { over: *over, share }))
    };
    let found = along.iter().zip(&groups).filter_map(differs);
    let (z, varies) = found.max_by(|a, b| a.0.total_cmp(&b.0))?;
    is_beyond_chance(z, pulls, &groups, seed).then_some(varies)
}

/// Whether pushes that are dealt out at random hardly ever differ as surely along any covariate: few pushes of
/// a group tell little of their own scatter, and normal quantiles take a chance for more.
fn is_beyond_chance(z: f64, pulls: &Pulls, along: &[Vec<Vec<usize>>], seed: u64) -> bool {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut dealt = Pulls { size: pulls.size.clone(), of_pushes: pulls.of_pushes.clone() };
    let mut as_much = 0;
    for _ in 0..N_DEALS {
        dealt.of_pushes.shuffle(&mut rng);
        let all = along.iter().filter_map(|groups| spread(&dealt, groups));
        as_much += usize::from(all.map(|(of_deal, _)| of_deal).fold(f64::MIN, f64::max) >= z);
        if (1 + as_much) as f64 > NAME * (1 + N_DEALS) as f64 {
            return false;
        }
    }
    true
}

/// Pushes in the order of a covariate, in five parts, or by speed where few are asked for; none where it is
/// not known or hardly differs.
fn groups(observations: &Observations, over: Covariate) -> Option<Vec<Vec<usize>>> {
    if observations.unknown.contains(&over) {
        return None;
    }
    let mut first = vec![None; observations.pushes.len()];
    for (step, push) in observations.push_of.iter().enumerate() {
        first[*push].get_or_insert_with(|| observations.value_of(over, step));
    }
    let mut pushes: Vec<(f64, usize)> =
        first.iter().enumerate().filter_map(|(push, at)| Some(((*at)?, push))).collect();
    pushes.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    if let Some(speeds) = speeds(&pushes).filter(|_| over == Covariate::Speed) {
        return Some(speeds);
    }
    let n = pushes.len();
    let part = |k: usize| &pushes[k * n / N_GROUPS..(k + 1) * n / N_GROUPS];
    let parts: Vec<&[(f64, usize)]> = (0..N_GROUPS).map(part).collect();
    let (low, high) = (parts[0].last()?.0, parts[N_GROUPS - 1].first()?.0);
    let is_one = high - low <= 1e-3 * high.abs().max(low.abs());
    (n >= FEWEST_IN_GROUP * N_GROUPS && !is_one).then(|| parts.into_iter().map(names).collect())
}

fn names(part: &[(f64, usize)]) -> Vec<usize> {
    part.iter().map(|(_, push)| *push).collect()
}

/// Pushes in the order of their speeds, in groups of one each; none where there are many speeds, or few pushes
/// of one.
fn speeds(pushes: &[(f64, usize)]) -> Option<Vec<Vec<usize>>> {
    let speeds = pushes.chunk_by(|one, next| next.0 < ONE_SPEED * one.0);
    let speeds: Vec<Vec<usize>> = speeds.map(names).collect();
    let is_few = (2..=N_GROUPS).contains(&speeds.len());
    (is_few && speeds.iter().all(|pushes| pushes.len() >= FEWEST_IN_GROUP)).then_some(speeds)
}

/// Cochran's Q as a normal quantile, and the standard deviation between groups over the size.
fn spread(pulls: &Pulls, groups: &[Vec<usize>]) -> Option<(f64, f64)> {
    let n = pulls.size.len();
    let zero = || (DVector::zeros(n), DMatrix::zeros(n, n));
    let sum = |pushes: &[usize]| {
        pushes.iter().fold(zero(), |(pull, information): (DVector<f64>, DMatrix<f64>), push| {
            let own = &pulls.of_pushes[*push];
            (pull + &own.0, information + &own.1)
        })
    };
    let scatter = |pushes: &[usize], at: &DVector<f64>| {
        pushes.iter().fold(DMatrix::zeros(n, n), |scatter, push| {
            let (pull, information) = &pulls.of_pushes[*push];
            let left = pull - information * at;
            scatter + &left * left.transpose()
        })
    };
    let all: Vec<usize> = groups.concat();
    let (of_all, usual) = (sum(&all).1.trace(), scatter(&all, &DVector::zeros(n)));
    let mut precisions = Vec::new();
    let (mut total, mut weighted) = zero();
    for pushes in groups {
        let (pull, information) = sum(pushes);
        let share = information.trace() / of_all;
        let inverse = information.cholesky()?.inverse();
        let at = &inverse * pull;
        let m = pushes.len() as f64;
        let own = scatter(pushes, &at) * (m / (m - 1.0)) * m + USUAL * share * &usual;
        let variance = &inverse * own / (m + USUAL) * &inverse;
        let precision = variance.clone().cholesky()?.inverse();
        weighted += &precision;
        total += &precision * &at;
        precisions.push((at, precision, variance));
    }
    let mean = weighted.cholesky()?.solve(&total);
    let q: f64 = precisions
        .iter()
        .map(|(at, precision, _)| (at - &mean).dot(&(precision * (at - &mean))))
        .sum();
    let freedom = ((groups.len() - 1) * n) as f64;
    // Squares of the groups beyond what their errors make.
    let square: f64 = precisions.iter().map(|(at, ..)| (at - &mean).norm_squared()).sum();
    let errors: f64 = precisions.iter().map(|(.., variance)| variance.trace()).sum();
    let m = groups.len() as f64;
    let beyond = (square / (m - 1.0) - errors / m).max(0.0);
    Some((normal_of_chi_square(q, freedom), beyond.sqrt() / pulls.size.norm()))
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};
    use rand::SeedableRng;
    use rand::seq::SliceRandom;
    use rand_chacha::ChaCha8Rng;

    use super::{FEWEST_IN_GROUP, is_beyond_chance, speeds, spread};
    use crate::fit::Pulls;
    use crate::synthetic::normal;

    /// Pushes of an effect of size 1 plus what a push's group has beside it; each push tells it to 0.5.
    fn pulls(n: usize, beside: impl Fn(usize) -> f64, seed: u64) -> (Pulls, Vec<Vec<usize>>) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let of_push = |push: usize| {
            let at = beside(5 * push / n) + 0.5 * normal(&mut rng);
            (DVector::from_element(1, 4.0 * at), DMatrix::from_element(1, 1, 4.0))
        };
        let of_pushes = (0..n).map(of_push).collect();
        let groups = (0..5).map(|k| (k * n / 5..(k + 1) * n / 5).collect()).collect();
        (Pulls { size: DVector::from_element(1, 1.0), of_pushes }, groups)
    }

    #[test]
    fn few_speeds_are_the_groups() {
        let at = |speeds: &[f64]| -> Vec<(f64, usize)> {
            let all = speeds.iter().flat_map(|speed| [*speed; FEWEST_IN_GROUP]);
            all.enumerate()
                .map(|(push, speed)| (speed * (1.0 + 1e-3 * push as f64), push))
                .collect()
        };
        let found = speeds(&at(&[0.01, 0.02, 0.04])).unwrap();
        assert_eq!(found.concat(), (0..12).collect::<Vec<_>>());
        assert!(found.iter().all(|group| group.len() == FEWEST_IN_GROUP));
        assert_eq!(speeds(&at(&[0.02])), None);
        assert_eq!(speeds(&at(&[0.01, 0.02, 0.04, 0.08, 0.16, 0.32])), None);
        // Three pushes of a speed of their own are too few.
        assert_eq!(speeds(&at(&[0.01, 0.02])[1..]), None);
    }

    #[test]
    fn one_size_varies_by_chance_alone() {
        let is_sure = |seed: u64| {
            let (pulls, groups) = pulls(100, |_| 0.0, seed);
            let (z, share) = spread(&pulls, &groups).unwrap();
            z >= super::DIFFERENT && share >= super::DIFFERENT_SHARE
        };
        // Chance is 0.17 % each: 3 or more of 400 come once in 33 such tests.
        assert!((0..400).filter(|seed| is_sure(*seed)).count() <= 3);
    }

    /// Pushes that tell two numbers, each as well as it happens to, grouped in six ways.
    #[test]
    fn what_uneven_pushes_differ_by_is_no_surer_than_chance() {
        let deal = |seed: u64| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let of_push = |_| {
                let information = (1.5 * normal(&mut rng)).exp();
                let at = DVector::from_fn(2, |_, _| 1.0 + normal(&mut rng) / information.sqrt());
                (information * at, DMatrix::identity(2, 2) * information)
            };
            let of_pushes: Vec<_> = (0..60).map(of_push).collect();
            let mut order: Vec<usize> = (0..60).collect();
            let mut group = |_| {
                order.shuffle(&mut rng);
                order.chunks(12).map(<[usize]>::to_vec).collect::<Vec<_>>()
            };
            let along: Vec<Vec<Vec<usize>>> = (0..6).map(&mut group).collect();
            let pulls = Pulls { size: DVector::from_element(2, 1.0), of_pushes };
            let of = |groups: &Vec<Vec<usize>>| spread(&pulls, groups).unwrap().0;
            let z = along.iter().map(of).fold(f64::MIN, f64::max);
            let is_sure = z >= super::DIFFERENT;
            (is_sure, is_sure && is_beyond_chance(z, &pulls, &along, seed))
        };
        let found: Vec<(bool, bool)> = (0..600).map(deal).collect();
        let n = |of: fn(&(bool, bool)) -> bool| found.iter().filter(|one| of(one)).count();
        let (by_quantile, by_deals) = (n(|one| one.0), n(|one| one.1));
        // Of one in a hundred 13 come once in a hundred such tests; quantiles alone take more for sure.
        assert!(by_deals <= 12 && 2 * by_deals < by_quantile, "{by_deals} {by_quantile}");
    }

    #[test]
    fn a_size_that_differs_between_groups_is_seen() {
        let found = |by: f64| {
            let (pulls, groups) = pulls(100, |group| by * (group as f64 - 2.0), 3);
            spread(&pulls, &groups).unwrap()
        };
        let (z, share) = found(0.4);
        // Standard deviation of −2 … 2 is 1.58.
        assert!(z > super::DIFFERENT && (0.5..0.8).contains(&share), "{z} {share}");
        let (pulls, groups) = pulls(100, |group| 0.4 * (group as f64 - 2.0), 3);
        assert!(is_beyond_chance(z, &pulls, &[groups], 3));
        assert!(found(0.05).1 < super::DIFFERENT_SHARE);
    }
}
