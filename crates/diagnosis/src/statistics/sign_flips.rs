//! Probabilities that hold for many tests at once, by flipping the signs of clusters.

use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

/// A test whose statistic is a square of a sum over clusters.
///
/// T = (Σs)ᵀ (Σssᵀ)⁺ (Σs), with s a cluster's part.
#[derive(Clone, Debug)]
pub(crate) struct FlipTest {
    /// Each cluster's part, times (Σssᵀ)^(−½).
    parts: Vec<DVector<f64>>,
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
pub(crate) struct Flips(Vec<Vec<f64>>);

impl Flips {
    /// Random signs of clusters, or every choice of them where there are no more than asked for.
    ///
    /// A flip and its opposite are one, since statistics are squares.
    pub(crate) fn new(n_clusters: usize, n_flips: usize, seed: u64) -> Self {
        let few = n_clusters.saturating_sub(1) < usize::BITS as usize - 1
            && (1_usize << n_clusters.saturating_sub(1)) - 1 <= n_flips;
        if few {
            let sign = |choice: usize, k: usize| if choice >> k & 1 == 1 { -1.0 } else { 1.0 };
            let all = 1..1_usize << n_clusters.saturating_sub(1);
            let signs = |choice| (0..n_clusters).map(|k| sign(choice, k)).collect();
            return Self(all.map(signs).collect());
        }
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut sign = || if rng.random::<bool>() { 1.0 } else { -1.0 };
        Self((0..n_flips).map(|_| (0..n_clusters).map(|_| sign()).collect()).collect())
    }

    pub(crate) fn len(&self) -> usize {
        self.0.len()
    }

    /// The probabilities of all tests, the null imposed: each cluster's part as likely of the other
    /// sign.
    ///
    /// A test's own probability is the rank of its statistic among its flips. Steps down from the
    /// most surprising test (max-T over probabilities, for an effect that few clusters show has a
    /// small statistic at any probability): each is compared with the most surprising of those not
    /// yet passed.
    ///
    /// # Source
    /// Westfall & Young (1993), Resampling-based multiple testing, algorithm 2.8.
    pub(crate) fn probabilities(&self, tests: &[FlipTest]) -> Vec<FlipProbability> {
        let ranked: Vec<(f64, Vec<f64>)> =
            tests.into_par_iter().map(|test| self.ranked(test)).collect();
        let mut order: Vec<usize> = (0..tests.len()).collect();
        order.sort_by(|a, b| ranked[*a].0.total_cmp(&ranked[*b].0));
        let mut least = vec![f64::INFINITY; self.len()];
        let mut adjusted = vec![1.0; tests.len()];
        for test in order.iter().rev() {
            let (own, flipped) = &ranked[*test];
            least.iter_mut().zip(flipped).for_each(|(least, p)| *least = least.min(*p));
            let as_small = least.iter().filter(|least| *least <= own).count();
            adjusted[*test] = (1 + as_small) as f64 / (1 + self.len()) as f64;
        }
        let mut floor: f64 = 0.0;
        for test in &order {
            floor = floor.max(adjusted[*test]);
            adjusted[*test] = floor;
        }
        let of =
            |(k, (p, _)): (usize, &(f64, _))| FlipProbability { p: *p, p_adjusted: adjusted[k] };
        ranked.iter().enumerate().map(of).collect()
    }

    /// The probability of a test's statistic, and of each of its flips, among all of them.
    fn ranked(&self, test: &FlipTest) -> (f64, Vec<f64>) {
        let own = test.statistic(|_| 1.0);
        let flipped: Vec<f64> = self.0.iter().map(|signs| test.statistic(|k| signs[k])).collect();
        let mut sorted: Vec<f64> = flipped.iter().copied().chain([own]).collect();
        sorted.sort_by(f64::total_cmp);
        let all = sorted.len();
        let p = |value: f64| {
            // Flips that change nothing sum in another order only: equal up to rounding.
            let below = sorted.partition_point(|other| *other < value * (1.0 - 1e-9));
            (all - below) as f64 / all as f64
        };
        (p(own), flipped.into_iter().map(p).collect())
    }
}

impl FlipTest {
    /// Of each cluster's part of a score.
    pub(crate) fn new(parts: Vec<DVector<f64>>) -> Self {
        let n = parts.first().map_or(0, DVector::len);
        let scatter = parts.iter().fold(DMatrix::zeros(n, n), |all, s| all + s * s.transpose());
        let eigen = scatter.symmetric_eigen();
        let least = 1e-12 * eigen.eigenvalues.iter().copied().fold(0.0, f64::max);
        let roots =
            eigen.eigenvalues.map(|value| if value > least { value.sqrt().recip() } else { 0.0 });
        let whitening = DMatrix::from_diagonal(&roots) * eigen.eigenvectors.transpose();
        Self { parts: parts.iter().map(|part| &whitening * part).collect() }
    }

    /// A test that nothing can pass.
    pub(crate) fn none() -> Self {
        Self { parts: Vec::new() }
    }

    pub(crate) fn n_parts(&self) -> usize {
        self.parts.len()
    }

    /// T with a sign for each part.
    fn statistic(&self, sign: impl Fn(usize) -> f64) -> f64 {
        let mut sum = DVector::zeros(self.parts.first().map_or(0, DVector::len));
        for (k, part) in self.parts.iter().enumerate() {
            sum.axpy(sign(k), part, 1.0);
        }
        sum.norm_squared()
    }
}

#[cfg(test)]
mod tests {
    use super::{FlipTest, Flips};
    use nalgebra::DVector;
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
            FlipTest::new((0..n_clusters).map(part).collect())
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
    fn an_effect_is_found_and_an_adjusted_p_is_no_smaller_than_its_own() {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let found = Flips::new(40, 999, 3).probabilities(&tests(&mut rng, 40, 1.5));
        assert!(found.iter().all(|p| p.p_adjusted <= 0.01), "{found:?}");
        let found = Flips::new(40, 999, 3).probabilities(&tests(&mut rng, 40, 0.0));
        assert!(found.iter().all(|p| p.p_adjusted >= p.p), "{found:?}");
    }
}
