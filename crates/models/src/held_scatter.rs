//! How widely pushes scatter, when some scatter more than others.

use nalgebra::Vector3;

/// What pushes hold, of some of them: a Student t about 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct HeldScatter {
    /// Scale squared of each output: its variance for many degrees of freedom.
    pub(crate) held: Vector3<f64>,
    /// Degrees of freedom, of what the pushes say and of how few they are.
    pub(crate) freedom: f64,
}

/// The mean of a push's whitened errors, and how many there are.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PushMean {
    pub(crate) mean: Vector3<f64>,
    pub(crate) n: usize,
}

/// Inverse degrees of freedom that are weighed: from a Gaussian to three, below which moments of the
/// particles would be those of their few farthest.
const N_TRIED: usize = 21;
const HEAVIEST: f64 = 1.0 / 3.0;
/// As good as a Gaussian.
const LIGHTEST: f64 = 1e-3;
const N_ROUNDS: usize = 200;

impl HeldScatter {
    /// By maximum likelihood of multivariate t distributions: mᵢ ~ t_ν(0, held + own/nᵢ), with own of
    /// each step's own errors.
    ///
    /// 1/ν is its mean under the likelihood with an even prior, and with 1/N added: a variance known
    /// from N pushes alone predicts the next one as a t of N degrees of freedom.
    ///
    /// # Source
    /// Lange, Little & Taylor (1989), Robust statistical modeling using the t distribution (the
    /// iteration).
    pub(crate) fn of(means: &[PushMean], own: &Vector3<f64>) -> Self {
        let inverse = |k: usize| LIGHTEST + (HEAVIEST - LIGHTEST) * k as f64 / (N_TRIED - 1) as f64;
        let logs: Vec<(f64, f64)> = (0..N_TRIED)
            .map(|k| {
                let held = scales(means, own, 1.0 / inverse(k));
                (inverse(k), log_likelihood(means, own, &held, 1.0 / inverse(k)))
            })
            .collect();
        let most = logs.iter().map(|(_, log)| *log).fold(f64::NEG_INFINITY, f64::max);
        let sum = |of: &dyn Fn(f64) -> f64| -> f64 {
            logs.iter().map(|(inverse, log)| of(*inverse) * (log - most).exp()).sum()
        };
        let told = sum(&|inverse| inverse) / sum(&|_| 1.0);
        let held = scales(means, own, 1.0 / told);
        let freedom = 1.0 / (told + 1.0 / means.len() as f64).min(HEAVIEST);
        Self { held, freedom }
    }
}

/// Variance of a push's mean for a scale of 1.
fn spread(held: &Vector3<f64>, own: &Vector3<f64>, n: usize) -> Vector3<f64> {
    held + own / n as f64
}

/// The square of a push's distance from 0.
fn square(push: &PushMean, held: &Vector3<f64>, own: &Vector3<f64>) -> f64 {
    let spread = spread(held, own, push.n).map(|variance| variance.max(f64::MIN_POSITIVE));
    push.mean.component_mul(&push.mean).component_div(&spread).sum()
}

/// The scales of most likelihood for given degrees of freedom.
fn scales(means: &[PushMean], own: &Vector3<f64>, freedom: f64) -> Vector3<f64> {
    let n = means.len() as f64;
    let squares =
        means.iter().map(|push| push.mean.component_mul(&push.mean)).sum::<Vector3<f64>>() / n;
    let of_steps = own * (means.iter().map(|push| 1.0 / push.n as f64).sum::<f64>() / n);
    let mut held = (squares - of_steps).map(|rest| rest.max(0.0));
    for _ in 0..N_ROUNDS {
        let weighted: Vector3<f64> = means
            .iter()
            .map(|push| {
                let weight = (freedom + 3.0) / (freedom + square(push, &held, own));
                weight * push.mean.component_mul(&push.mean)
            })
            .sum();
        held = (weighted / n - of_steps).map(|rest| rest.max(0.0));
    }
    held
}

fn log_likelihood(
    means: &[PushMean],
    own: &Vector3<f64>,
    held: &Vector3<f64>,
    freedom: f64,
) -> f64 {
    let of_push = |push: &PushMean| {
        let size = spread(held, own, push.n).map(|variance| variance.max(1e-300).ln()).sum();
        -0.5 * size - 0.5 * (freedom + 3.0) * (square(push, held, own) / freedom).ln_1p()
    };
    let each =
        libm::lgamma(0.5 * (freedom + 3.0)) - libm::lgamma(0.5 * freedom) - 1.5 * freedom.ln();
    means.iter().map(of_push).sum::<f64>() + means.len() as f64 * each
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{ChiSquared, Distribution, StandardNormal};

    use super::{HeldScatter, PushMean};

    /// Means of pushes whose sizes scatter as a t of some degrees of freedom; none for a Gaussian.
    fn means(n: usize, held: Vector3<f64>, own: f64, freedom: Option<f64>) -> Vec<PushMean> {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let chi = freedom.map(|freedom| (freedom, ChiSquared::new(freedom).unwrap()));
        let mut push = |k: usize| {
            let size = chi.map_or(1.0, |(freedom, chi)| freedom / chi.sample(&mut random));
            let n = 4 + k % 9;
            let mut normal = || random.sample::<f64, _>(StandardNormal);
            let variance = size * held + Vector3::repeat(own / n as f64);
            PushMean { mean: variance.map(|variance| variance.sqrt() * normal()), n }
        };
        (0..n).map(&mut push).collect()
    }

    #[test]
    fn scales_and_tails_of_many_pushes_are_found() {
        let (held, own) = (Vector3::new(0.5, 2.0, 0.1), Vector3::repeat(0.05));
        for (freedom, inverse) in [(None, 0.0), (Some(10.0), 0.1), (Some(4.0), 0.25)] {
            let found = HeldScatter::of(&means(4000, held, own.x, freedom), &own);
            assert!((1.0 / found.freedom - inverse).abs() < 0.03, "{freedom:?}: {found:?}");
            for k in 0..3 {
                let ratio = found.held[k] / held[k];
                assert!((ratio - 1.0).abs() < 0.15, "{freedom:?}: {found:?}");
            }
        }
    }

    #[test]
    fn the_next_push_is_as_often_within_95_percent_as_said_however_few_were_seen() {
        let (held, own) = (Vector3::repeat(1.0), Vector3::repeat(0.1));
        let all = means(4000, held, own.x, None);
        // Of |t| for many degrees of freedom and for three, in steps that interpolate well.
        let quantile =
            |freedom: f64| 1.96 + 2.37 / freedom + 2.82 / freedom.powi(2) + 3.5 / freedom.powi(3);
        let (mut n_within, mut n_by_gauss, mut n_tried) = (0, 0, 0);
        for group in all.chunks(11) {
            let (next, seen) = (group[0], &group[1..]);
            if seen.len() < 10 {
                continue;
            }
            let found = HeldScatter::of(seen, &own);
            for k in 0..3 {
                let sd = (found.held[k] + own[k] / next.n as f64).sqrt();
                n_within += usize::from(next.mean[k].abs() < quantile(found.freedom) * sd);
                n_by_gauss += usize::from(next.mean[k].abs() < 1.96 * sd);
                n_tried += 1;
            }
        }
        let share = |n: usize| n as f64 / f64::from(n_tried);
        assert!((0.935..0.985).contains(&share(n_within)), "{}", share(n_within));
        assert!(share(n_by_gauss) < 0.925, "{}", share(n_by_gauss));
    }

    #[test]
    fn pushes_that_hold_nothing_have_no_scale() {
        let found =
            HeldScatter::of(&means(500, Vector3::zeros(), 1.0, None), &Vector3::repeat(1.0));
        assert!(found.held.amax() < 0.03, "{found:?}");
    }
}
