//! Probabilities that hold for many tests at once, by flipping the signs of clusters.

use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

/// A test whose statistic is a square of a sum over clusters.
///
/// T = (Σs)ᵀ (Σssᵀ)⁺ (Σs), with s a cluster's part, and (Σs)ᵀ I⁻¹ (Σs), which is what it explains.
#[derive(Clone, Debug)]
pub(crate) struct FlipTest {
    /// Each cluster's part, times (Σssᵀ)^(−½).
    parts: Vec<DVector<f64>>,
    /// Each cluster's part, times I^(−½).
    in_noise: Vec<DVector<f64>>,
}

/// Probabilities of a test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FlipProbability {
    /// Of a statistic as large or larger in this test.
    pub(crate) p: f64,
    /// The same for any test at least as surprising.
    pub(crate) p_adjusted: f64,
}

/// The flips that are used.
#[derive(Clone, Debug)]
pub(crate) struct Flips {
    n_flips: usize,
    /// Each cluster's signs, flip after flip.
    signs: Vec<Vec<i8>>,
}

impl Flips {
    /// Random signs of clusters, or every choice of them where there are no more than asked for.
    ///
    /// A flip and its opposite are one, since statistics are squares.
    pub(crate) fn new(n_clusters: usize, n_flips: usize, seed: u64) -> Self {
        let few = n_clusters.saturating_sub(1) < usize::BITS as usize - 1
            && (1_usize << n_clusters.saturating_sub(1)) - 1 <= n_flips;
        if few {
            let all = 1..1_usize << n_clusters.saturating_sub(1);
            let sign = |choice: usize, k: usize| if choice >> k & 1 == 1 { -1 } else { 1 };
            let of_cluster = |k| all.clone().map(|choice| sign(choice, k)).collect();
            let signs = (0..n_clusters).map(of_cluster).collect();
            return Self { n_flips: all.len(), signs };
        }
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut signs = vec![Vec::with_capacity(n_flips); n_clusters];
        for _ in 0..n_flips {
            signs.iter_mut().for_each(|own| own.push(if rng.random::<bool>() { 1 } else { -1 }));
        }
        Self { n_flips, signs }
    }

    pub(crate) fn len(&self) -> usize {
        self.n_flips
    }

    /// The probabilities of all tests, the null imposed: each cluster's part as likely of the other
    /// sign.
    ///
    /// Twice the smaller one of two. By T a test's probability is its rank among its flips; it finds what few
    /// clusters show, and has little to say of few clusters, for every test has some flip of the first rank.
    /// By (Σs)ᵀ I⁻¹ (Σs) what explains much is told from what is surprising and explains little.
    /// Both step down from the most surprising test: each is compared with the most surprising of those not
    /// yet passed.
    ///
    /// # Source
    /// Westfall & Young (1993), Resampling-based multiple testing, algorithm 2.8.
    pub(crate) fn probabilities(&self, tests: &[FlipTest]) -> Vec<FlipProbability> {
        let of_arm = |parts: fn(&FlipTest) -> &[DVector<f64>], by_rank: bool| {
            let ranked: Vec<Ranked> =
                tests.into_par_iter().map(|test| self.ranked(parts(test), by_rank)).collect();
            self.stepped_down(&ranked)
        };
        let by_scatter = of_arm(|test| &test.parts, true);
        let by_gain = of_arm(|test| &test.in_noise, false);
        let of_both = |(one, other): (FlipProbability, FlipProbability)| FlipProbability {
            p: (2.0 * one.p.min(other.p)).min(1.0),
            p_adjusted: (2.0 * one.p_adjusted.min(other.p_adjusted)).min(1.0),
        };
        by_scatter.into_iter().zip(by_gain).map(of_both).collect()
    }

    fn stepped_down(&self, ranked: &[Ranked]) -> Vec<FlipProbability> {
        let mut order: Vec<usize> = (0..ranked.len()).collect();
        order.sort_by(|a, b| ranked[*a].own.total_cmp(&ranked[*b].own));
        let mut least = vec![f64::INFINITY; self.len()];
        let mut adjusted = vec![1.0; ranked.len()];
        for test in order.iter().rev() {
            let Ranked { own, flipped, .. } = &ranked[*test];
            least.iter_mut().zip(flipped).for_each(|(least, p)| *least = least.min(*p));
            let as_small = least.iter().filter(|least| *least <= own).count();
            adjusted[*test] = (1 + as_small) as f64 / (1 + self.len()) as f64;
        }
        let mut floor: f64 = 0.0;
        for test in &order {
            floor = floor.max(adjusted[*test]);
            adjusted[*test] = floor;
        }
        let found = ranked.iter().zip(adjusted);
        found.map(|(one, p_adjusted)| FlipProbability { p: one.p, p_adjusted }).collect()
    }

    /// The square of the sum of parts in each flip.
    fn squares_of_sums(&self, parts: &[DVector<f64>]) -> Vec<f64> {
        let mut squares = vec![0.0; self.len()];
        let mut sums = vec![0.0; self.len()];
        for component in 0..parts.first().map_or(0, DVector::len) {
            sums.fill(0.0);
            for (part, signs) in parts.iter().zip(&self.signs) {
                let part = part[component];
                sums.iter_mut().zip(signs).for_each(|(sum, sign)| *sum += f64::from(*sign) * part);
            }
            squares.iter_mut().zip(&sums).for_each(|(square, sum)| *square += sum * sum);
        }
        squares
    }

    /// How surprising the square of the sum of parts, and each of its flips, is: by its rank among them, or
    /// the larger the more.
    fn ranked(&self, parts: &[DVector<f64>], by_rank: bool) -> Ranked {
        let own = parts.iter().cloned().reduce(|sum, part| sum + part);
        let own = own.map_or(0.0, |sum| sum.norm_squared());
        let flipped = self.squares_of_sums(parts);
        let mut sorted: Vec<f64> = flipped.iter().copied().chain([own]).collect();
        sorted.sort_by(f64::total_cmp);
        let all = sorted.len();
        // Flips that change nothing sum in another order only: equal up to rounding.
        let enough = |value: f64| value * (1.0 - 1e-9);
        let p = |value: f64| {
            let below = sorted.partition_point(|other| *other < enough(value));
            (all - below) as f64 / all as f64
        };
        match by_rank {
            true => {
                Ranked { p: p(own), own: p(own), flipped: flipped.into_iter().map(p).collect() }
            }
            false => Ranked {
                p: p(own),
                own: -enough(own),
                flipped: flipped.into_iter().map(|value| -value).collect(),
            },
        }
    }
}

/// How surprising a statistic is: the smaller the more.
struct Ranked {
    /// Its rank among its flips, as a probability.
    p: f64,
    own: f64,
    flipped: Vec<f64>,
}

impl FlipTest {
    /// Of each cluster's part of a score with its information I.
    pub(crate) fn new(parts: &[DVector<f64>], information: &DMatrix<f64>) -> Self {
        let n = parts.first().map_or(0, DVector::len);
        let scatter = parts.iter().fold(DMatrix::zeros(n, n), |all, s| all + s * s.transpose());
        let whitened = |by: DMatrix<f64>| {
            let root = inverse_root(by);
            parts.iter().map(|part| &root * part).collect()
        };
        Self { parts: whitened(scatter), in_noise: whitened(information.clone()) }
    }

    /// A test that nothing can pass.
    pub(crate) fn none() -> Self {
        Self { parts: Vec::new(), in_noise: Vec::new() }
    }

    pub(crate) fn n_parts(&self) -> usize {
        self.parts.len()
    }
}

/// A root of the pseudo-inverse of a matrix that is not negative.
fn inverse_root(matrix: DMatrix<f64>) -> DMatrix<f64> {
    let eigen = matrix.symmetric_eigen();
    let least = 1e-12 * eigen.eigenvalues.iter().copied().fold(0.0, f64::max);
    let roots =
        eigen.eigenvalues.map(|value| if value > least { value.sqrt().recip() } else { 0.0 });
    DMatrix::from_diagonal(&roots) * eigen.eigenvectors.transpose()
}

#[cfg(test)]
mod tests {
    use super::{FlipTest, Flips};
    use nalgebra::{DMatrix, DVector};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    fn normal(rng: &mut ChaCha8Rng) -> f64 {
        let (radius, angle): (f64, f64) = (1.0 - rng.random::<f64>(), rng.random());
        (-2.0 * radius.ln()).sqrt() * (std::f64::consts::TAU * angle).cos()
    }

    /// Tests on Gaussian clusters of twelve steps that share most of their error.
    fn tests(rng: &mut ChaCha8Rng, n_clusters: usize, shift: f64) -> Vec<FlipTest> {
        let test = |freedom: usize, slopes: &[Vec<f64>], errors: &[Vec<f64>]| {
            let part = |cluster: usize| {
                DVector::from_fn(freedom, |k, _| {
                    let steps = slopes[cluster].iter().zip(&errors[cluster]);
                    steps
                        .map(|(slope, error)| (slope + 0.3 * k as f64) * (error + shift * slope))
                        .sum()
                })
            };
            let parts: Vec<DVector<f64>> = (0..n_clusters).map(part).collect();
            FlipTest::new(&parts, &DMatrix::identity(freedom, freedom))
        };
        let errors: Vec<Vec<f64>> = (0..n_clusters)
            .map(|_| {
                let shared = 3.0 * normal(rng);
                (0..12).map(|_| shared + normal(rng)).collect()
            })
            .collect();
        (0..8)
            .map(|k| {
                let slopes: Vec<Vec<f64>> =
                    (0..n_clusters).map(|_| (0..12).map(|_| 0.5 + normal(rng)).collect()).collect();
                test(1 + k % 2, &slopes, &errors)
            })
            .collect()
    }

    fn alarms(n_clusters: usize, draws: u64) -> f64 {
        let alarm = |seed: u64| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let tests = tests(&mut rng, n_clusters, 0.0);
            let found = Flips::new(n_clusters, 199, seed).probabilities(&tests);
            found.iter().any(|p| p.p_adjusted <= 0.05)
        };
        (0..draws).filter(|seed| alarm(*seed)).count() as f64 / draws as f64
    }

    #[test]
    fn eight_tests_without_effect_alarm_in_one_of_twenty_sets() {
        // 95 % of binomial shares of 400 draws at 0.05 are between 0.03 and 0.073.
        let share = alarms(30, 400);
        assert!((0.025..0.075).contains(&share), "{share}");
    }

    #[test]
    fn few_clusters_use_every_flip_and_keep_the_level() {
        assert_eq!(Flips::new(6, 999, 1).len(), 31);
        assert_eq!(Flips::new(30, 999, 1).len(), 999);
        let share = alarms(6, 400);
        assert!(share <= 0.075, "{share}");
    }

    #[test]
    fn among_many_tests_of_few_clusters_what_all_show_is_found() {
        // 2^10 flips and 24 tests, each of which has some flip of the first rank.
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let mut test = |shift: f64| {
            let part = |_| DVector::from_element(1, shift + normal(&mut rng));
            FlipTest::new(&(0..11).map(part).collect::<Vec<_>>(), &DMatrix::identity(1, 1))
        };
        let tests: Vec<FlipTest> = (0..24).map(|k| test(if k == 7 { 5.0 } else { 0.0 })).collect();
        let found = Flips::new(11, 9999, 1).probabilities(&tests);
        assert_eq!(found[7].p_adjusted, 2.0 / 1024.0);
        assert!(
            found.iter().enumerate().all(|(k, one)| k == 7 || one.p_adjusted > 0.05),
            "{found:?}"
        );
    }

    #[test]
    fn an_effect_is_found_and_an_adjusted_p_is_no_smaller_than_its_own() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let found = Flips::new(40, 999, 3).probabilities(&tests(&mut rng, 40, 1.5));
        assert!(found.iter().all(|p| p.p_adjusted <= 0.01), "{found:?}");
        let found = Flips::new(40, 999, 3).probabilities(&tests(&mut rng, 40, 0.0));
        assert!(found.iter().all(|p| p.p_adjusted >= p.p), "{found:?}");
    }
}
