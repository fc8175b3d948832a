//! How widely what the errors of whole pushes add up to scatters, when some pushes err more than others.

use nalgebra::{Matrix3, Vector3};

use crate::scatter::error_products::Shares;
use crate::scatter::push_errors::PushErrors;

/// The sums of pushes' errors, over what was forecast of them: a Student t about 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PushScatter {
    /// Scale squared of what is forecast: its variance for many degrees of freedom.
    pub(crate) scale: f64,
    /// Degrees of freedom, of what the pushes say and of how few they are.
    pub(crate) freedom: f64,
}

/// The sum of a push's errors, along directions in which its parts do not correlate.
#[derive(Clone, Debug)]
pub(crate) struct PushSum {
    /// The square of the sum over the forecast variance, and the share of that variance which is the
    /// push's; the rest is noise of the measured start and end. One pair a direction that is free.
    squares: Vec<[f64; 2]>,
}

/// Inverse degrees of freedom that are weighed: from a Gaussian to three, below which moments of the
/// particles would be those of their few farthest.
const N_TRIED: usize = 21;
const HEAVIEST: f64 = 1.0 / 3.0;
/// As good as a Gaussian.
const LIGHTEST: f64 = 1e-3;
/// The logarithms of the scales that are searched.
const SCALES: [f64; 2] = [-14.0, 7.0];
const N_ROUNDS: usize = 32;
/// Directions whose variance is a smaller share of the largest are held by contact.
const FREE: f64 = 0.01;

impl PushSum {
    /// Of whitened errors and the shares that they have in all pushes.
    pub(crate) fn of(push: &PushErrors, shares: &Shares) -> Self {
        let [held, own, measured] =
            [shares.held, shares.own, shares.measured].map(|part| Matrix3::from_diagonal(&part));
        let kept = (-push.way / shares.length).exp();
        let (mut forecast, mut noise) = (Matrix3::zeros(), Matrix3::zeros());
        // What is kept of all steps before is carried along.
        let mut before = Matrix3::zeros();
        let through = push.drawn.through(&push.free);
        for (k, free) in through.iter().enumerate() {
            let across = free.transpose();
            before *= kept;
            let with_before = before * held * across;
            forecast += free * (held + own) * across + with_before + with_before.transpose();
            before += free;
            noise += 2.0 * free * measured * across;
            if k > 0 {
                let with_last = through[k - 1] * measured * across;
                noise -= with_last + with_last.transpose();
            }
        }
        Self::along(&push.errors.iter().sum(), &forecast, &noise)
    }

    fn along(sum: &Vector3<f64>, forecast: &Matrix3<f64>, noise: &Matrix3<f64>) -> Self {
        let whole = (forecast + noise).symmetric_eigen();
        let least = FREE * whole.eigenvalues.max();
        let scaled = |k: usize| match whole.eigenvalues[k] {
            variance if variance > least => whole.eigenvectors.column(k) / variance.sqrt(),
            _ => Vector3::zeros(),
        };
        let white = Matrix3::from_columns(&[scaled(0), scaled(1), scaled(2)]).transpose();
        let of_push = (white * forecast * white.transpose()).symmetric_eigen();
        let sum = of_push.eigenvectors.transpose() * white * sum;
        let pairs = sum.iter().zip(&of_push.eigenvalues);
        let pairs = pairs.map(|(sum, share)| [sum * sum, share.clamp(0.0, 1.0)]);
        // What contact holds is in no direction but the null vector's.
        Self { squares: pairs.filter(|[square, share]| square + share > 1e-12).collect() }
    }

    /// Log density of a t of such a scale and degrees of freedom, without what depends on neither.
    ///
    /// - `normal`: its part of the degrees of freedom alone, for each number of directions.
    fn log_density(&self, scale: f64, freedom: f64, normal: &[f64; 4]) -> f64 {
        let n = self.squares.len() as f64;
        let variance = |share: f64| (scale * share + (1.0 - share)).max(f64::MIN_POSITIVE);
        let square: f64 =
            self.squares.iter().map(|[square, share]| square / variance(*share)).sum();
        let log_size: f64 = self.squares.iter().map(|[_, share]| variance(*share).ln()).sum();
        normal[self.squares.len()]
            - 0.5 * log_size
            - 0.5 * (freedom + n) * (square / freedom).ln_1p()
    }
}

impl PushScatter {
    /// By maximum likelihood of multivariate t distributions: sumᵢ ~ t_ν(0, scale · forecastᵢ +
    /// measuredᵢ).
    ///
    /// 1/ν is its mean under the likelihood with an even prior, and with 1/n added: a variance known
    /// from n numbers alone predicts the next one as a t of n degrees of freedom.
    pub(crate) fn of(pushes: &[PushSum]) -> Self {
        let inverse = |k: usize| LIGHTEST + (HEAVIEST - LIGHTEST) * k as f64 / (N_TRIED - 1) as f64;
        let likeliest = |inverse: f64| likeliest_scale(pushes, 1.0 / inverse);
        let logs: Vec<_> = (0..N_TRIED).map(|k| (inverse(k), likeliest(inverse(k)).1)).collect();
        let most = logs.iter().map(|(_, log)| *log).fold(f64::NEG_INFINITY, f64::max);
        let sum = |of: &dyn Fn(f64) -> f64| -> f64 {
            logs.iter().map(|(inverse, log)| of(*inverse) * (log - most).exp()).sum()
        };
        let told = sum(&|inverse| inverse) / sum(&|_| 1.0);
        let n_numbers: usize = pushes.iter().map(|push| push.squares.len()).sum();
        let freedom = 1.0 / (told + 1.0 / n_numbers.max(1) as f64).min(HEAVIEST);
        Self { scale: likeliest(told).0, freedom }
    }
}

/// The scale of most likelihood for given degrees of freedom, and its log likelihood: by golden section.
fn likeliest_scale(pushes: &[PushSum], freedom: f64) -> (f64, f64) {
    let ratio = 0.5 * (5_f64.sqrt() - 1.0);
    let normal = std::array::from_fn(|n| {
        let n = n as f64;
        libm::lgamma(0.5 * (freedom + n)) - libm::lgamma(0.5 * freedom) - 0.5 * n * freedom.ln()
    });
    let value = |log_scale: f64| -> f64 {
        pushes.iter().map(|push| push.log_density(log_scale.exp(), freedom, &normal)).sum()
    };
    let [mut low, mut high] = SCALES;
    for _ in 0..N_ROUNDS {
        let width = ratio * (high - low);
        if value(high - width) < value(low + width) {
            low = high - width;
        } else {
            high = low + width;
        }
    }
    let middle = 0.5 * (low + high);
    (middle.exp(), value(middle))
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Vector3};
    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{ChiSquared, Distribution, StandardNormal};

    use super::{PushScatter, PushSum};

    /// Sums of pushes whose sizes scatter as a t of some degrees of freedom; none for a Gaussian. Two
    /// directions are free.
    fn sums(n: usize, scale: f64, freedom: Option<f64>) -> Vec<(Vector3<f64>, f64, PushSum)> {
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let chi = freedom.map(|freedom| (freedom, ChiSquared::new(freedom).unwrap()));
        let mut push = |k: usize| {
            let size = chi.map_or(1.0, |(freedom, chi)| freedom / chi.sample(&mut random));
            let held = Vector3::new(1.0, 1.0 + k as f64 % 3.0, -0.5).normalize();
            let free = Matrix3::identity() - held * held.transpose();
            let (forecast, noise) = ((4 + k % 9).pow(2) as f64, 0.5_f64);
            let mut normal =
                || -> Vector3<f64> { Vector3::from_fn(|_, _| random.sample(StandardNormal)) };
            let sum = (size * scale * forecast).sqrt() * normal() + noise.sqrt() * normal();
            let sum = free * sum;
            (sum, forecast, PushSum::along(&sum, &(forecast * free), &(noise * free)))
        };
        (0..n).map(&mut push).collect()
    }

    fn found(sums: &[(Vector3<f64>, f64, PushSum)]) -> PushScatter {
        PushScatter::of(&sums.iter().map(|(_, _, sum)| sum.clone()).collect::<Vec<_>>())
    }

    #[test]
    fn scale_and_tails_of_many_pushes_are_found() {
        for (scale, freedom, inverse) in
            [(0.5, None, 0.0), (2.0, Some(10.0), 0.1), (0.1, Some(4.0), 0.25)]
        {
            let sums = sums(4000, scale, freedom);
            assert!(sums.iter().all(|(_, _, sum)| sum.squares.len() == 2));
            let found = found(&sums);
            assert!((1.0 / found.freedom - inverse).abs() < 0.03, "{freedom:?}: {found:?}");
            assert!((found.scale / scale - 1.0).abs() < 0.1, "{freedom:?}: {found:?}");
        }
    }

    #[test]
    fn the_next_push_is_as_often_within_95_percent_as_said_however_few_were_seen() {
        // As even as they are thought to be before any push is seen.
        let freedoms = [None, Some(12.0), Some(6.0), Some(4.0), Some(3.0)];
        let all: Vec<_> = freedoms.iter().flat_map(|freedom| sums(2100, 1.0, *freedom)).collect();
        // The 95 % region of a t of two dimensions: x² ≤ ν (0.05^(−2/ν) − 1).
        let farthest = |freedom: f64| freedom * (0.05_f64.powf(-2.0 / freedom) - 1.0);
        let (mut n_within, mut n_by_gauss, mut n_tried) = (0, 0, 0);
        for group in all.chunks_exact(21) {
            let ((sum, forecast, _), seen) = (&group[0], &group[1..]);
            let found = found(seen);
            let square = sum.norm_squared() / (found.scale * forecast + 0.5);
            n_within += usize::from(square < farthest(found.freedom));
            n_by_gauss += usize::from(square < farthest(1e6));
            n_tried += 1;
        }
        let share = |n: usize| n as f64 / f64::from(n_tried);
        assert!((0.93..0.98).contains(&share(n_within)), "{}", share(n_within));
        assert!(share(n_by_gauss) < 0.9, "{}", share(n_by_gauss));
    }

    #[test]
    fn pushes_that_are_as_sure_as_their_measurement_have_no_scale() {
        assert!(found(&sums(500, 0.0, None)).scale < 1e-3);
    }
}
