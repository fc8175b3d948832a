//! How noise grows with the motion of a step.

use dataset::quantile;

/// Variance of a step's noise: constant + per_square · way².
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Growth {
    pub(crate) constant: f64,
    pub(crate) per_square: f64,
}

/// A deviation of a step from what it repeats.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Deviation {
    pub(crate) cluster: usize,
    /// Of the pusher over the step, in m.
    pub(crate) way: f64,
    /// Without the bias of the mean that it is from.
    pub(crate) square: f64,
}

/// Ways that differ by less say nothing of a growth.
const LEAST_SPREAD: f64 = 1.5;
/// Growth of the variance over the ways that is worth a parameter.
const LEAST_GROWTH: f64 = 2.0;
/// Standard errors, from whole clusters, between the growth and none.
const FEWEST_SE: f64 = 2.0;

impl Growth {
    /// The growth, where it shows.
    ///
    /// Least squares of the squares on way², weighted by the fitted variance, which makes them the
    /// maximum of the Gaussian likelihood.
    pub(crate) fn of(deviations: &[Deviation]) -> Option<Self> {
        let ways: Vec<f64> = deviations.iter().map(|deviation| deviation.way).collect();
        let (low, high) = (quantile(ways.clone(), 0.1)?, quantile(ways, 0.9)?);
        if high < LEAST_SPREAD * low {
            return None;
        }
        let mean = deviations.iter().map(|d| d.square).sum::<f64>() / deviations.len() as f64;
        let mut growth = Self { constant: mean, per_square: 0.0 };
        for _ in 0..20 {
            growth = growth.improved(deviations)?;
        }
        let grows = growth.variance(high) > LEAST_GROWTH * growth.variance(low);
        (grows && growth.per_square > FEWEST_SE * growth.se(deviations)).then_some(growth)
    }

    pub(crate) fn variance(&self, way: f64) -> f64 {
        self.constant + self.per_square * way * way
    }

    /// One weighted regression; none of both parameters falls below zero.
    fn improved(&self, deviations: &[Deviation]) -> Option<Self> {
        let [mut w, mut x, mut xx, mut y, mut xy] = [0.0; 5];
        for deviation in deviations {
            let weight = self.variance(deviation.way).powi(-2);
            let square = deviation.way * deviation.way;
            w += weight;
            x += weight * square;
            xx += weight * square * square;
            y += weight * deviation.square;
            xy += weight * square * deviation.square;
        }
        let determinant = w * xx - x * x;
        if determinant <= 0.0 || !determinant.is_finite() {
            return None;
        }
        let (constant, per_square) =
            ((xx * y - x * xy) / determinant, (w * xy - x * y) / determinant);
        Some(match (constant > 0.0, per_square > 0.0) {
            (true, true) => Self { constant, per_square },
            (false, _) => Self { constant: 1e-3 * y / w, per_square: xy / xx },
            (true, false) => Self { constant: y / w, per_square: 0.0 },
        })
    }

    /// Standard error of the growth, from the scores of whole clusters.
    fn se(&self, deviations: &[Deviation]) -> f64 {
        let clusters = deviations.iter().map(|deviation| deviation.cluster + 1);
        let n_clusters = clusters.max().unwrap_or(0);
        let [mut w, mut x, mut xx] = [0.0; 3];
        for deviation in deviations {
            let (weight, square) = (self.variance(deviation.way).powi(-2), deviation.way.powi(2));
            (w, x, xx) = (w + weight, x + weight * square, xx + weight * square * square);
        }
        let mut scores = vec![0.0; n_clusters];
        for deviation in deviations {
            let variance = self.variance(deviation.way);
            let centered = deviation.way.powi(2) - x / w;
            scores[deviation.cluster] +=
                centered * (deviation.square - variance) / variance.powi(2);
        }
        let information = xx - x * x / w;
        scores.iter().map(|score| score * score).sum::<f64>().sqrt() / information
    }
}

#[cfg(test)]
mod tests {
    use super::{Deviation, Growth};

    /// Squares of a known variance, whose standardised values are those of half a normal each.
    fn deviations(variance: impl Fn(f64) -> f64) -> Vec<Deviation> {
        let quantiles = [0.01, 0.1, 0.3, 0.7, 1.3, 3.59];
        let one = |k: usize| {
            let way = [0.004, 0.01, 0.02, 0.04, 0.08][k % 5];
            Deviation {
                cluster: k / 5,
                way,
                square: variance(way) * quantiles[(k / 5 + k % 5) % 6],
            }
        };
        (0..300).map(one).collect()
    }

    #[test]
    fn a_growth_is_measured_where_it_shows_and_only_there() {
        let truth = |way: f64| 1e-8 + 4e-6 * way * way;
        let found = Growth::of(&deviations(truth)).unwrap();
        assert!((found.constant / 1e-8 - 1.0).abs() < 0.2, "{found:?}");
        assert!((found.per_square / 4e-6 - 1.0).abs() < 0.2, "{found:?}");
        assert_eq!(Growth::of(&deviations(|_| 1e-8)), None);
        let one_way: Vec<_> =
            deviations(truth).into_iter().filter(|deviation| deviation.way == 0.01).collect();
        assert_eq!(Growth::of(&one_way), None);
    }
}
