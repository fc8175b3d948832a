//! Laws of every resampler.

use filter::{Weights, all_resamplers};
use proptest::prelude::{Strategy, prop};
use proptest::test_runner::Config;
use proptest::{prop_assert, prop_assert_eq, proptest};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Weights that sum to 1, some of them zero.
fn weights() -> impl Strategy<Value = Vec<f64>> {
    let log = prop::collection::vec(-12.0..0.0_f64, 1..60);
    log.prop_map(|mut log| {
        let n = log.len();
        log.iter_mut().step_by(5).take(n / 5).for_each(|value| *value = f64::NEG_INFINITY);
        log[n - 1] = -1.0;
        Weights::from_logs(log).unwrap().0.as_slice().to_vec()
    })
}

fn counts(ancestors: &[usize], n: usize) -> Vec<usize> {
    let mut counts = vec![0; n];
    ancestors.iter().for_each(|k| counts[*k] += 1);
    counts
}

proptest! {
    #![proptest_config(Config::with_cases(64))]

    #[test]
    fn draws_are_as_many_as_asked_ascending_and_of_positive_weight(
        weights in weights(), n in 0_usize..200, seed in 0_u64..1000,
    ) {
        for resampler in all_resamplers() {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            let ancestors = resampler.ancestors(&weights, n, &mut random);
            prop_assert_eq!(ancestors.len(), n);
            prop_assert!(ancestors.is_sorted());
            prop_assert!(ancestors.iter().all(|k| weights[*k] > 0.0), "{}", resampler.id());
        }
    }

    #[test]
    fn heavy_particles_survive_where_promised(weights in weights(), seed in 0_u64..1000) {
        let n = weights.len();
        for resampler in all_resamplers().into_iter().filter(|one| one.keeps_heavy_particles()) {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            let counts = counts(&resampler.ancestors(&weights, n, &mut random), n);
            for (count, weight) in counts.iter().zip(&weights) {
                let heavy = (weight * n as f64 - 1e-9).floor().max(0.0) as usize;
                prop_assert!(*count >= heavy, "{}: {count} of {weight}", resampler.id());
            }
        }
    }

    #[test]
    fn equal_weights_return_the_same_set_where_promised(n in 1_usize..3000, seed in 0_u64..1000) {
        let weights = Weights::equal(n);
        for resampler in all_resamplers().into_iter().filter(|one| one.keeps_equal_weights()) {
            let mut random = ChaCha8Rng::seed_from_u64(seed);
            let ancestors = resampler.ancestors(weights.as_slice(), n, &mut random);
            prop_assert!(ancestors.into_iter().eq(0..n), "{}", resampler.id());
        }
    }
}

#[test]
fn promises_that_are_not_made_are_not_kept() {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    for resampler in all_resamplers() {
        // A weight of just above 1/n that straddles two strata, and equal weights.
        let weights = [0.12, 0.26, 0.62];
        let mut draws = (0..2000).map(|_| resampler.ancestors(&weights, 4, &mut random));
        let always = draws.all(|ancestors| ancestors.contains(&1));
        assert_eq!(always, resampler.keeps_heavy_particles(), "{}", resampler.id());
        let mut draws = (0..100).map(|_| resampler.ancestors(&[0.25; 4], 4, &mut random));
        let same = draws.all(|ancestors| ancestors == [0, 1, 2, 3]);
        assert_eq!(same, resampler.keeps_equal_weights(), "{}", resampler.id());
    }
}

#[test]
fn every_resampler_is_unbiased() {
    let weights = [0.02, 0.31, 0.0, 0.17, 0.07, 0.43];
    let (n, n_draws) = (10, 20_000);
    for resampler in all_resamplers() {
        let mut random = ChaCha8Rng::seed_from_u64(11);
        let mut sums = [0.0; 6];
        for _ in 0..n_draws {
            let ancestors = resampler.ancestors(&weights, n, &mut random);
            ancestors.iter().for_each(|k| sums[*k] += 1.0);
        }
        for (sum, weight) in sums.iter().zip(weights) {
            // Five standard errors of the noisiest, multinomial draws.
            let expected = f64::from(n_draws) * n as f64 * weight;
            let tolerance = 5.0 * (expected * (1.0 - weight)).sqrt();
            assert!((sum - expected).abs() <= tolerance, "{}: {sum}", resampler.id());
        }
    }
}
