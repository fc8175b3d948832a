//! Outputs at the same inputs: the covariance in two factors is the covariance of all rows together.

use faer::Mat;
use gp_core::{
    Coregionalization, Gp, Kernel, Matern52, Mean, Posterior, SquaredExponential, White,
};
use proptest::collection::vec;
use proptest::prelude::{ProptestConfig, Strategy, prop_assert, proptest};

/// Sums of N³ products of numbers near 1, on two ways.
const ROUNDING: f64 = 1e-9;

#[derive(Clone, Debug)]
struct Case {
    n_outputs: usize,
    /// Inputs, N×2.
    x: Mat<f64>,
    /// One output after the other.
    y: Vec<f64>,
    variances: Vec<f64>,
    odds: Vec<f64>,
    own: Vec<f64>,
    own_odds: Vec<f64>,
}

/// What is new at each input.
#[derive(Clone, Copy, Debug)]
enum New {
    /// The same variance for all outputs.
    Common,
    /// One of each output, which look at all inputs.
    Own,
    /// Shared by the outputs of an input.
    Shared,
}

impl Case {
    fn kernel(&self, new: New) -> Box<dyn Kernel> {
        let rough = Matern52::new(&[0.8, 1.3], 1.0).unwrap();
        let smooth = (rough + SquaredExponential::isotropic(2.0)).active(&[0, 1]);
        let outputs = Coregionalization::from_odds(&self.variances, &self.odds).active(&[2]);
        let own = |odds: &[f64]| Coregionalization::from_odds(&self.own, odds).active(&[2]);
        match new {
            New::Common => {
                let kernel = outputs * smooth;
                Box::new(kernel)
            }
            New::Own => {
                let kernel = smooth * outputs + own(&[]) * White::new(0.3);
                Box::new(kernel)
            }
            New::Shared => {
                let white = White::new(0.3).active(&[1, 0]);
                let kernel = white * own(&self.own_odds) + smooth * outputs;
                Box::new(kernel)
            }
        }
    }

    /// Rows of (input, output) in the order of `stack`, or with an input's outputs together, of which no
    /// factors can be made.
    fn order(&self, is_together: bool) -> Vec<(usize, usize)> {
        let (n, p) = (self.x.nrows(), self.n_outputs);
        let row = |k: usize| if is_together { (k / p, k % p) } else { (k % n, k / n) };
        (0..n * p).map(row).collect()
    }

    fn gp(&self, new: New, mean: Mean, noise: f64, is_together: bool) -> Gp {
        let order = self.order(is_together);
        let entry = |k: usize, d: usize| {
            let (i, p) = order[k];
            if d == 2 { p as f64 } else { self.x[(i, d)] }
        };
        let x = Mat::from_fn(order.len(), 3, entry);
        let y: Vec<f64> = order.iter().map(|(i, p)| self.y[p * self.x.nrows() + i]).collect();
        let builder = Gp::builder(self.kernel(new)).noise_variance(noise).mean(mean);
        builder.condition(&x, &y).unwrap()
    }
}

fn case() -> impl Strategy<Value = Case> {
    (2_usize..5, 3_usize..9).prop_flat_map(|(n_outputs, n)| {
        let n_pairs = n_outputs * (n_outputs - 1) / 2;
        let odds = || vec(0.05..20.0, n_pairs);
        let variances = || vec(0.1..3.0, n_outputs);
        let known = (vec(-2.0..2.0, 2 * n), vec(-3.0..3.0, n_outputs * n));
        (known, variances(), odds(), variances(), odds()).prop_map(
            move |((entries, y), variances, odds, own, own_odds)| {
                let x = Mat::from_fn(n, 2, |i, d| entries[2 * i + d]);
                Case { n_outputs, x, y, variances, odds, own, own_odds }
            },
        )
    })
}

fn close(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < ROUNDING * (1.0 + b.abs()))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn in_two_factors_every_number_is_that_of_all_rows_together(case in case()) {
        let x_star = Mat::from_fn(4, 3, |i, d| {
            if d == 2 { (i % 2) as f64 } else { 0.6 * i as f64 - 0.4 * d as f64 - 0.7 }
        });
        for new in [New::Common, New::Own, New::Shared] {
            for mean in [Mean::Fixed(0.3), Mean::Estimated, Mean::Linear] {
                let [gp, whole] =
                    [false, true].map(|is_together| case.gp(new, mean, 0.1, is_together));
                let values = [&gp, &whole].map(Gp::log_marginal_likelihood);
                prop_assert!(close(&values[..1], &values[1..]), "{new:?} {values:?}");
                let [one, other] =
                    [&gp, &whole].map(|gp| gp.log_marginal_likelihood_gradient().unwrap());
                prop_assert!(close(&one, &other), "{new:?} {mean:?} {one:?} {other:?}");
                let [one, other] = [&gp, &whole].map(|gp| gp.predict(&x_star).unwrap());
                prop_assert!(close(&one.0, &other.0) && close(&one.1, &other.1));
                let [one, other] = [&gp, &whole].map(|gp| gp.predict_joint(x_star.as_ref()).unwrap());
                let off = one.covariance() - other.covariance();
                prop_assert!(off.norm_max() < ROUNDING);
                let [one, other] =
                    [&gp, &whole].map(|gp| gp.variance_gradient(x_star.as_ref()).unwrap());
                prop_assert!((&one - &other).norm_max() < ROUNDING);
                // Rows in the same order.
                let sorted = |gp: &Gp, is_together: bool| {
                    let out = gp.leave_one_out().unwrap();
                    let rows = case.order(is_together).into_iter().zip(out.variance.clone());
                    let mut rows: Vec<_> = rows.map(|((i, p), value)| ((p, i), value)).collect();
                    rows.sort_by_key(|(row, _)| *row);
                    rows.into_iter().map(|(_, value)| value).collect::<Vec<f64>>()
                };
                prop_assert!(close(&sorted(&gp, false), &sorted(&whole, true)));
            }
        }
    }

    #[test]
    fn rows_that_come_and_go_leave_the_factors_for_the_whole(case in case()) {
        let [mut gp, mut whole] =
            [false, true].map(|is_together| case.gp(New::Own, Mean::Estimated, 0.1, is_together));
        let x_star = Mat::from_fn(2, 3, |i, d| if d == 2 { 1.0 } else { 0.3 * i as f64 });
        for one in [&mut gp, &mut whole] {
            one.add_row(&[0.1, 0.2, 1.0], 0.7, 0.0).unwrap();
            one.remove_row(0).unwrap();
        }
        let [one, other] = [&gp, &whole].map(|gp| gp.predict(&x_star).unwrap());
        prop_assert!(close(&one.0, &other.0) && close(&one.1, &other.1));
    }
}

#[test]
fn outputs_without_noise_are_as_of_all_rows_together() {
    let x = Mat::from_fn(4, 2, |i, d| 0.7 * i as f64 + 0.2 * d as f64);
    let y: Vec<f64> = (0..8).map(|i| f64::from(i).sin()).collect();
    let (variances, own, odds) = (vec![1.0, 2.0], vec![1.0, 0.5], vec![3.0]);
    let own_odds = odds.clone();
    let case = Case { n_outputs: 2, x, y, variances, odds, own, own_odds };
    let [gp, whole] = [false, true].map(|is_together| {
        case.gp(New::Common, Mean::Estimated, 0.0, is_together).log_marginal_likelihood()
    });
    assert!((gp - whole).abs() < 1e-6 * whole.abs(), "{gp} {whole}");
    // The condition number is of the same covariance.
    let [gp, whole] = [false, true].map(|is_together| {
        case.gp(New::Shared, Mean::Estimated, 0.1, is_together).condition_number()
    });
    assert!((gp / whole - 1.0).abs() < 0.05, "{gp} {whole}");
}
