//! How far pushes drive rivals apart.

use nalgebra::DMatrix;
use serde::Serialize;

use super::Aim;
use super::planned::Planned;
use super::standpoint::{Standpoint, View};
use crate::statistics::score::Products;
use crate::{DiagnosisError, NoiseModel, Observations};
use dataset::quantile;

/// How well two rivals are told apart, in standard deviations: the root of twice the log likelihood
/// ratio that is expected, were the one that is harder to tell true.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Separation {
    /// Id of one.
    pub one: String,
    /// Id of the other.
    pub other: String,
    /// By the pushes so far.
    pub now: f64,
    /// With the suggested ones.
    pub expected: f64,
    /// With as many that are drawn among those that can be done: the median.
    pub with_random: f64,
}

/// Every ordered pair of rivals: the first is true, the second is fitted.
pub(super) struct Separations {
    pairs: Vec<Pair>,
    /// Ids of each two pairs.
    names: Vec<[String; 2]>,
}

struct Pair {
    so_far: Products,
    of_candidates: Vec<Products>,
}

impl Separations {
    /// # Errors
    /// What a model refuses.
    pub(super) fn new(
        aim: &Aim,
        standpoints: &[Standpoint],
        observations: &Observations,
        planned: &Planned,
        noise: &NoiseModel,
    ) -> Result<Self, DiagnosisError> {
        let so_far = |standpoint: &Standpoint| standpoint.view(observations, noise);
        let so_far: Vec<View> = standpoints.iter().map(so_far).collect::<Result<_, _>>()?;
        let there = |standpoint: &Standpoint| standpoint.view(&planned.0, noise);
        let there: Vec<View> = standpoints.iter().map(there).collect::<Result<_, _>>()?;
        let (mut pairs, mut names) = (Vec::new(), Vec::new());
        for (places, ids) in aim.pairs() {
            names.push(ids.map(str::to_owned));
            for [truth, fitted] in [places, [places[1], places[0]]] {
                let apart = |views: &[View]| apart(&views[truth], &views[fitted]);
                let n = standpoints[fitted].free.len();
                let mut sum = Products::zero(n);
                apart(&so_far).iter().for_each(|push| sum.add(push));
                pairs.push(Pair { so_far: sum, of_candidates: apart(&there) });
            }
        }
        Ok(Self { pairs, names })
    }

    /// The smallest separation of a design, squared, and a little of the others.
    pub(super) fn value(&self, design: &[(usize, f64)]) -> f64 {
        let squares = self.pairs.iter().map(|pair| pair.left(design));
        let (least, sum) = squares
            .fold((f64::INFINITY, 0.0), |(least, sum), t: f64| (least.min(t), sum + t.sqrt()));
        least + LITTLE * sum
    }

    pub(super) fn told(
        &self,
        design: &[(usize, f64)],
        random: &[Vec<(usize, f64)>],
    ) -> Vec<Separation> {
        let told = |(names, both): (&[String; 2], &[Pair])| {
            let harder = |design: &[(usize, f64)]| {
                both.iter().map(|pair| pair.left(design)).fold(f64::INFINITY, f64::min).sqrt()
            };
            let [one, other] = names.clone();
            Separation {
                one,
                other,
                now: harder(&[]),
                expected: harder(design),
                with_random: quantile(random.iter().map(|design| harder(design)).collect(), 0.5)
                    .unwrap_or_default(),
            }
        };
        self.names.iter().zip(self.pairs.chunks(2)).map(told).collect()
    }
}

/// What the sum of all separations weighs beside the smallest.
const LITTLE: f64 = 1e-3;

impl Pair {
    /// What is left of the distance after the fitted rival's free numbers have followed:
    /// min over δ of |d − Gδ|² + |δ|², in their prior's standard deviations.
    fn left(&self, design: &[(usize, f64)]) -> f64 {
        let mut sum = self.so_far.clone();
        for (candidate, count) in design {
            let push = &self.of_candidates[*candidate];
            sum.slopes += *count * &push.slopes;
            sum.residual += *count * &push.residual;
            sum.square += count * push.square;
        }
        let n = sum.residual.len();
        let Some(factor) = (&sum.slopes + DMatrix::identity(n, n)).cholesky() else { return 0.0 };
        (sum.square - sum.residual.dot(&factor.solve(&sum.residual))).max(0.0)
    }
}

/// Whitened distance of the truth from what is fitted, with the slopes of the latter, a push each.
fn apart(truth: &View, fitted: &View) -> Vec<Products> {
    let differences = truth.predicted.iter().zip(&fitted.predicted);
    let differences: Vec<[f64; 7]> =
        differences.map(|(one, other)| std::array::from_fn(|k| one[k] - other[k])).collect();
    let white = fitted.whitening.whiten(&differences);
    let pushes = fitted.whitening.rows().into_iter().zip(&fitted.slopes);
    let products = pushes.map(|(rows, slopes)| {
        Products::of(&white.rows(rows.start, rows.len()).into_owned(), slopes)
    });
    products.collect()
}

#[cfg(test)]
mod tests {
    use nalgebra::{DMatrix, DVector};

    use super::Pair;
    use crate::statistics::score::Products;

    /// Candidates with two numbers and one free number each.
    fn pair(distances: &[[f64; 2]], slopes: &[[f64; 2]]) -> Pair {
        let push = |(distance, slope): (&[f64; 2], &[f64; 2])| {
            let slope = DMatrix::from_column_slice(2, 1, slope);
            Products::of(&DVector::from_column_slice(distance), &slope)
        };
        let of_candidates = distances.iter().zip(slopes).map(push).collect();
        Pair { so_far: Products::zero(1), of_candidates }
    }

    #[test]
    fn what_the_free_numbers_can_follow_does_not_separate() {
        let pair = pair(&[[3.0, 0.0], [0.0, 3.0]], &[[100.0, 0.0], [100.0, 0.0]]);
        // |d|² less (gᵀd)²/(gᵀg + 1).
        let followed = 9.0 - 9e4 / 10_001.0;
        assert!((pair.left(&[(0, 1.0)]) - followed).abs() < 1e-9);
        assert!((pair.left(&[(1, 1.0)]) - 9.0).abs() < 1e-12);
    }

    #[test]
    fn further_pushes_never_bring_rivals_together() {
        let distances = [[1.0, -0.5], [0.3, 2.0], [-1.2, 0.1]];
        let pair = pair(&distances, &[[0.7, 0.2], [-2.0, 1.0], [0.5, 5.0]]);
        let mut before = pair.left(&[]);
        for design in [vec![(0, 1.0)], vec![(0, 2.0)], vec![(0, 2.0), (1, 1.0)]] {
            let after = pair.left(&design);
            assert!(after >= before - 1e-12, "{before} {after}");
            before = after;
        }
        assert!(before > 1.0, "{before}");
    }
}
