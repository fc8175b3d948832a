//! Rows without ids that share their errors, for their inputs nearly agree.

use std::collections::BTreeMap;
use std::f64::consts::{PI, SQRT_2};
use std::fmt;

use serde::{Deserialize, Serialize};

use crate::data::clusters::{ClusterMean, numbered};
use crate::data::local_residuals::{Point, local_residuals, pairs};

/// Rows of a table without ids that are taken for steps of one push.
///
/// Rows of one run are joined by a chain of rows, each of which is nearly like the next.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Runs {
    /// How many there are, of one row or more.
    pub n: usize,
    /// Rows.
    pub n_rows: usize,
    /// Share of their variance that the residuals of the nearest rows have in common.
    pub shared: f64,
    /// Difference in p, where all else agrees, up to which rows are linked: a quarter of that share
    /// is left there, or more where rows are too dense.
    pub p: f64,
    /// The same of β, in rad.
    pub beta: f64,
}

/// Runs with the run of each row.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FoundRuns {
    pub(crate) runs: Runs,
    pub(crate) of_row: Vec<usize>,
}

/// Radius of the hole in local fits over the spacing that rows would have if they lay evenly.
const HOLE: f64 = 1.5;
/// Wider holes, in standard deviations of the inputs, leave too much of what is smooth.
const WIDEST_HOLE: f64 = 0.6;
/// Shells of distance within the hole; each is so many times as wide as the next.
const N_SHELLS: usize = 14;
const RATIO: f64 = SQRT_2;
/// Fewer pairs say nothing of a shell.
const FEWEST_PAIRS: f64 = 30.0;
/// Pairs in a shell over those of rows that lie evenly: steps of a push follow each other closely.
const EXCESS: f64 = 1.5;
/// The same of the shell in which what rows share falls, and what of it is left there.
const POPULATED: f64 = 0.7;
const FALLEN: f64 = 0.7;
/// Least share of variance that the nearest rows have in common.
const LEAST_SHARED: f64 = 0.25;
/// What is left of it where a link ends.
const AT_LINK: f64 = 0.25;
/// Shells over which it lasts, at least: rows that repeat each other are all at one distance.
const FEWEST_SHELLS: usize = 3;
/// Part of a link within which that is tested.
const NEAR: f64 = 0.3;
/// Standard errors, from rows so joined, between what they share and nothing.
const FEWEST_SE: f64 = 4.0;
/// Groups of such rows, at least.
const FEWEST_RUNS: usize = 12;
/// Share of the rows that one run may hold.
const LARGEST_RUN: f64 = 0.1;

/// The runs of rows without ids; none where rows nearly alike have no more in common than others.
///
/// - `points`: inputs over their standard deviations.
/// - `values`: observed less predicted by a nominal model.
/// - `sds`: standard deviations of p and β, the first inputs.
///
/// Rows are linked up to the distance over which a quarter is left of what residuals of the nearest rows
/// share beyond those farther off. That alone would link what repeats one push, too: at every shorter
/// distance there must be more pairs than chance makes, and at longer ones pairs that share less. Where
/// links as long would join a good part of all rows, they are shorter.
pub(crate) fn runs(points: &[Point], values: &[[f64; 3]], sds: [f64; 2]) -> Option<FoundRuns> {
    let spacing = spacing(points)?;
    let hole = HOLE * spacing;
    if hole > WIDEST_HOLE {
        return None;
    }
    let residuals = local_residuals(points, values, hole);
    let shared = |a: usize, b: usize| {
        let (one, other) = (residuals[a].as_ref()?, residuals[b].as_ref()?);
        let square = 0.5 * (one.own_square() + other.own_square());
        let product = (0..3).map(|k| one.values[k] * other.values[k]).sum::<f64>();
        Some([product - one.fits_share(other) * square, square])
    };
    let pair = |(distance, a, b)| Pair { distance, rows: [a, b], shared: shared(a, b) };
    let pairs: Vec<Pair> = pairs(points, hole).into_iter().map(pair).collect();
    let dimension = points.first()?.at.len();
    let shells = Shells::of(&pairs, hole, (points.len(), dimension, spacing));
    let (share, mut link) = shells.range(hole)?;
    let most = LARGEST_RUN * points.len() as f64;
    let mut of_row = linked(&pairs, points.len(), link);
    while counts(&of_row).into_iter().any(|n| n as f64 > most) {
        link /= RATIO.sqrt();
        of_row = linked(&pairs, points.len(), link);
    }
    // Where nothing is shared, rows are independent, however they are joined.
    let near = NEAR * link;
    if !shells.is_sure(&pairs, &linked(&pairs, points.len(), near), near) {
        return None;
    }
    let [p, beta] = sds.map(|sd| link * sd);
    let n = counts(&of_row).len();
    let runs = Runs { n, n_rows: points.len(), shared: share, p, beta };
    Some(FoundRuns { runs, of_row })
}

/// Two rows that are nearly alike.
struct Pair {
    distance: f64,
    rows: [usize; 2],
    /// Product of their residuals, summed over the outputs, less what the fits have in common, and
    /// the mean of the squares of both; none where a residual is not known.
    shared: Option<[f64; 2]>,
}

/// Distance between rows that fill the range of their inputs evenly.
fn spacing(points: &[Point]) -> Option<f64> {
    let n_kinds = numbered(points.iter().map(|point| point.kind)).into_iter().max()? + 1;
    let dimension = points.first().map(|point| point.at.len()).filter(|n| *n > 0)?;
    let width = |k: usize| {
        let values: Vec<f64> = points.iter().map(|point| point.at[k]).collect();
        let [low, high] = [0.05, 0.95].map(|share| dataset::quantile(values.clone(), share));
        Some((high? - low?) / 0.9)
    };
    let volume: f64 = (0..dimension).map(width).product::<Option<f64>>()?;
    let spacing = (n_kinds as f64 * volume / points.len() as f64).powf(1.0 / dimension as f64);
    (spacing > 0.0).then_some(spacing)
}

/// What pairs share by their distance, the widest shell first.
struct Shells {
    n: [f64; N_SHELLS],
    /// Pairs of rows that lie evenly.
    even: [f64; N_SHELLS],
    /// Pairs whose residuals are known.
    known: [f64; N_SHELLS],
    products: [f64; N_SHELLS],
    squares: [f64; N_SHELLS],
}

impl Shells {
    fn of(pairs: &[Pair], hole: f64, (n_rows, dimension, spacing): (usize, usize, f64)) -> Self {
        let zero = [0.0; N_SHELLS];
        let mut shells = Self { n: zero, even: zero, known: zero, products: zero, squares: zero };
        for pair in pairs {
            let shell = ((hole / pair.distance).ln() / RATIO.ln()).floor();
            let shell = shell.clamp(0.0, (N_SHELLS - 1) as f64) as usize;
            shells.n[shell] += 1.0;
            if let Some([product, square]) = pair.shared {
                shells.known[shell] += 1.0;
                shells.products[shell] += product;
                shells.squares[shell] += square;
            }
        }
        let half = 0.5 * dimension as f64;
        let ball = PI.powf(half) / libm::tgamma(half + 1.0);
        let within =
            |radius: f64| 0.5 * n_rows as f64 * ball * (radius / spacing).powi(dimension as i32);
        for (k, even) in shells.even.iter_mut().enumerate() {
            let [wide, narrow] = [k, k + 1].map(|k| within(hole * RATIO.powi(-(k as i32))));
            *even = if k + 1 < N_SHELLS { wide - narrow } else { wide };
        }
        shells
    }

    /// What rows at the hole's rim have in common: a part of what is smooth.
    fn at_rim(&self) -> f64 {
        self.products[0] / self.squares[0].max(f64::MIN_POSITIVE)
    }

    /// What the pairs of some shells share beyond those at the rim.
    fn beyond_rim(&self, shells: std::ops::Range<usize>) -> f64 {
        let sum = |values: &[f64]| values[shells.clone()].iter().sum::<f64>();
        let rim = self.at_rim();
        let shared = sum(&self.products) / sum(&self.squares).max(f64::MIN_POSITIVE);
        (shared - rim) / (1.0 - rim).max(f64::MIN_POSITIVE)
    }

    /// What the nearest rows share, and the distance over which a part of that is left.
    fn range(&self, hole: f64) -> Option<(f64, f64)> {
        let nearest = (1..N_SHELLS)
            .rev()
            .find(|k| self.known[*k..].iter().sum::<f64>() >= 2.0 * FEWEST_PAIRS)?;
        let share = self.beyond_rim(nearest..N_SHELLS);
        // Whether there are more pairs than chance makes, as steps that follow each other have.
        let is_close =
            |k: &usize| self.known[*k] >= FEWEST_PAIRS && self.n[*k] >= EXCESS * self.even[*k];
        let has_fallen = |k: &usize| self.beyond_rim(*k..*k + 1) < AT_LINK * share;
        let end = (0..nearest).rev().find(|k| has_fallen(k) || !is_close(k))?;
        let left = self.beyond_rim(end..end + 1);
        let is_seen = self.known[end] >= FEWEST_PAIRS && self.n[end] >= POPULATED * self.even[end];
        let is_fall = is_seen && left < FALLEN * share;
        if share < LEAST_SHARED || nearest - end < FEWEST_SHELLS || !is_fall {
            return None;
        }
        let last = self.beyond_rim(end + 1..end + 2);
        // Between the middles of the two shells about the fall, or where close pairs end.
        let part = ((last - AT_LINK * share) / (last - left)).clamp(0.0, 1.0);
        let shells = if has_fallen(&end) { end as f64 + 1.5 - part } else { end as f64 + 1.0 };
        Some((share, hole * RATIO.powf(-shells)))
    }

    /// Whether what rows so near share is more than chance.
    fn is_sure(&self, pairs: &[Pair], of_row: &[usize], link: f64) -> bool {
        let mut sums: BTreeMap<usize, [f64; 2]> = BTreeMap::new();
        for pair in pairs.iter().filter(|pair| pair.distance < link) {
            let Some(shared) = pair.shared else { continue };
            let sums = sums.entry(of_row[pair.rows[0]]).or_default();
            sums.iter_mut().zip(shared).for_each(|(sum, own)| *sum += own);
        }
        // Each group counts once: the errors of some are far larger than those of others.
        let of_group = |[product, square]: &[f64; 2]| product / square.max(f64::MIN_POSITIVE);
        let shares: Vec<(usize, f64)> =
            sums.values().map(|sums| of_group(sums) - self.at_rim()).enumerate().collect();
        let mean = ClusterMean::of(&shares);
        mean.is_some_and(|all| all.n_clusters >= FEWEST_RUNS && all.mean > FEWEST_SE * all.se)
    }
}

/// The run of each row, by chains of pairs that are nearer than a link.
fn linked(pairs: &[Pair], n_rows: usize, link: f64) -> Vec<usize> {
    fn root(parents: &mut [usize], mut row: usize) -> usize {
        while parents[row] != row {
            parents[row] = parents[parents[row]];
            row = parents[row];
        }
        row
    }
    let mut parents: Vec<usize> = (0..n_rows).collect();
    for pair in pairs.iter().filter(|pair| pair.distance < link) {
        let [a, b] = pair.rows.map(|row| root(&mut parents, row));
        parents[a.max(b)] = a.min(b);
    }
    numbered((0..n_rows).map(|row| root(&mut parents, row)))
}

/// Rows of each run.
fn counts(of_row: &[usize]) -> Vec<usize> {
    let mut counts = vec![0; of_row.iter().max().map_or(0, |last| last + 1)];
    of_row.iter().for_each(|run| counts[*run] += 1);
    counts
}

impl fmt::Display for Runs {
    /// One sentence without its end.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { n, n_rows, shared, p, beta } = self;
        write!(
            f,
            "{n} runs of rows, each taken for a push: {n_rows} rows have no ids, and residuals of \
             the nearest ones share {:.0} % of their variance; rows nearer than {p:.4} in p and \
             {beta:.4} rad in β are linked",
            100.0 * shared
        )
    }
}

#[cfg(test)]
mod tests {
    use super::{FoundRuns, Point, runs};
    use crate::synthetic::normal;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    /// Standard deviations of p, even over its edge, and of β.
    const SDS: [f64; 2] = [0.289, 0.6];

    /// Rows at (p, β) with a share of their error that rows of one push have in common.
    struct Rows {
        places: Vec<([f64; 2], usize)>,
        shared: f64,
    }

    impl Rows {
        /// - `miss`: what the model misses by smoothly, over the errors' standard deviation.
        fn runs(&self, miss: f64, rng: &mut ChaCha8Rng) -> Option<FoundRuns> {
            let n_pushes = self.places.iter().map(|(_, push)| push + 1).max().unwrap_or(0);
            let of_push: Vec<[f64; 3]> =
                (0..n_pushes).map(|_| std::array::from_fn(|_| normal(rng))).collect();
            let points = self
                .places
                .iter()
                .map(|([p, beta], _)| Point { kind: 1, at: vec![p / SDS[0], beta / SDS[1]] });
            let values = self.places.iter().map(|([p, beta], push)| {
                let missed = miss * (3.0 * p).sin() * beta.cos();
                let own = |of: f64, own: f64| {
                    missed + self.shared.sqrt() * of + (1.0 - self.shared).sqrt() * own
                };
                std::array::from_fn(|k| 1e-4 * own(of_push[*push][k], normal(rng)))
            });
            let points: Vec<Point> = points.collect();
            let values: Vec<[f64; 3]> = values.collect();
            runs(&points, &values, SDS)
        }
    }

    /// Steps of pushes of so many each, from places anywhere: contact and angle drift along.
    fn steps_of_pushes(n_pushes: usize, n_steps: usize, rng: &mut ChaCha8Rng) -> Rows {
        let mut places = Vec::new();
        for push in 0..n_pushes {
            let mut at = [rng.random_range(0.0..1.0), rng.random_range(-1.0..1.0)];
            let turn = 0.02 * (at[0] - 0.5);
            for _ in 0..n_steps {
                places.push((at, push));
                at =
                    [at[0] + 0.003 * at[1] + 3e-4 * normal(rng), at[1] + turn + 1e-3 * normal(rng)];
            }
        }
        Rows { places, shared: 0.8 }
    }

    fn seeded(seed: u64) -> ChaCha8Rng {
        ChaCha8Rng::seed_from_u64(seed)
    }

    #[test]
    fn steps_whose_ids_were_dropped_are_found_as_runs_of_their_pushes() {
        for seed in 0..5 {
            let mut rng = seeded(seed);
            let rows = steps_of_pushes(300, 8, &mut rng);
            let found = rows.runs(3.0, &mut rng).expect("rows share errors");
            assert!((150..600).contains(&found.runs.n), "{:?}", found.runs);
            assert!((0.5..1.0).contains(&found.runs.shared), "{:?}", found.runs);
            // Steps that follow each other are of one run, and pushes far from each other of several.
            let (mut together, mut n) = (0, 0);
            for (k, pair) in rows.places.windows(2).enumerate() {
                if pair[0].1 == pair[1].1 {
                    n += 1;
                    together += usize::from(found.of_row[k] == found.of_row[k + 1]);
                }
            }
            assert!(5 * together > 4 * n, "{together} of {n}");
        }
    }

    #[test]
    fn independent_pushes_are_no_runs() {
        for seed in 0..6 {
            let mut rng = seeded(100 + seed);
            // Anywhere; each at one of 120 places with a little jitter, or with none; half so.
            let anywhere =
                |rng: &mut ChaCha8Rng| [rng.random_range(0.0..1.0), rng.random_range(-1.0..1.0)];
            let of_design = |jitter: f64, repeated: f64, rng: &mut ChaCha8Rng| {
                let mut place = |k: usize| {
                    if !rng.random_bool(repeated) {
                        return (anywhere(rng), k);
                    }
                    let cell = rng.random_range(0..120);
                    let center = [0.05 + 0.1 * (cell % 10) as f64, 0.16 * (cell / 10) as f64 - 0.9];
                    let at = [0, 1].map(|k| center[k] + jitter * SDS[k] * normal(rng));
                    (at, k)
                };
                Rows { places: (0..960).map(&mut place).collect(), shared: 0.8 }
            };
            let mut wrong = Vec::new();
            for (jitter, repeated) in
                [(0.0, 0.0), (0.0, 1.0), (0.01, 1.0), (0.03, 1.0), (0.01, 0.5)]
            {
                for miss in [0.0, 3.0, 30.0] {
                    let found = of_design(jitter, repeated, &mut rng).runs(miss, &mut rng);
                    let found = found.map(|found| found.runs);
                    wrong.extend(found.map(|found| (jitter, repeated, miss, found)));
                }
            }
            assert!(wrong.is_empty(), "{seed}: {wrong:?}");
        }
    }

    #[test]
    fn steps_that_share_no_errors_are_no_runs() {
        for seed in 0..6 {
            let mut rng = seeded(200 + seed);
            let rows = Rows { shared: 0.0, ..steps_of_pushes(300, 8, &mut rng) };
            assert_eq!(rows.runs(3.0, &mut rng).map(|found| found.runs), None, "{seed}");
        }
    }

    #[test]
    fn few_rows_and_rows_all_alike_are_no_runs() {
        let mut rng = seeded(7);
        assert!(steps_of_pushes(5, 8, &mut rng).runs(0.0, &mut rng).is_none());
        let alike = Rows { places: vec![([0.5, 0.1], 0); 400], shared: 0.8 };
        assert!(alike.runs(0.0, &mut rng).is_none());
        assert!(runs(&[], &[], SDS).is_none());
    }
}
