//! Rows that come and go, noise of their own, and several outputs.

use faer::Mat;
use gp_core::{
    Constant, Gp, GpError, LearnOptions, Linear, Matern52, Mean, Posterior, SquaredExponential, Sum,
};
use proptest::collection::vec;
use proptest::prelude::{ProptestConfig, Strategy, prop_assert, proptest};

const NOISE_VARIANCE: f64 = 0.05;

#[derive(Clone, Debug)]
struct Case {
    x: Mat<f64>,
    y: Vec<f64>,
    row_noise: Vec<f64>,
}

impl Case {
    fn kernel(&self) -> Sum {
        let d = self.x.ncols();
        Constant::new(0.5)
            + Linear::ard(&vec![0.3; d])
            + SquaredExponential::new(&vec![0.8; d], 1.7).unwrap()
    }

    fn fit(&self, rows: &[usize]) -> Gp {
        let x = Mat::from_fn(rows.len(), self.x.ncols(), |i, d| self.x[(rows[i], d)]);
        let pick = |values: &[f64]| rows.iter().map(|&row| values[row]).collect::<Vec<f64>>();
        let (y, noise) = (pick(&self.y), pick(&self.row_noise));
        let mean = Mean::Estimated;
        Gp::builder(self.kernel())
            .row_noise(&noise)
            .noise_variance(NOISE_VARIANCE)
            .mean(mean)
            .condition(x.as_ref(), &y)
            .unwrap()
    }
}

fn case() -> impl Strategy<Value = Case> {
    (1_usize..3, 2_usize..15).prop_flat_map(|(d, n)| {
        (vec(-2.0..2.0, n * d), vec(-3.0..3.0, n), vec(0.0..0.5, n)).prop_map(
            move |(entries, y, row_noise)| {
                let x = Mat::from_fn(n, d, |i, j| entries[i * d + j]);
                Case { x, y, row_noise }
            },
        )
    })
}

fn same(a: &Gp, b: &Gp, x_star: &Mat<f64>) -> bool {
    let close = |a: &[f64], b: &[f64]| {
        a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-10 * (1.0 + b.abs()))
    };
    let (a_mean, a_variance) = a.predict(x_star.as_ref()).unwrap();
    let (b_mean, b_variance) = b.predict(x_star.as_ref()).unwrap();
    let likelihoods = ([a.log_marginal_likelihood()], [b.log_marginal_likelihood()]);
    close(&a_mean, &b_mean)
        && close(&a_variance, &b_variance)
        && close(&likelihoods.0, &likelihoods.1)
        && close(a.row_noise(), b.row_noise())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn a_row_added_is_as_if_it_had_always_been_there(case in case()) {
        let n = case.y.len();
        let mut gp = case.fit(&(0..n - 1).collect::<Vec<_>>());
        let row: Vec<f64> = (0..case.x.ncols()).map(|d| case.x[(n - 1, d)]).collect();
        gp.add_row(&row, case.y[n - 1], case.row_noise[n - 1]).unwrap();
        prop_assert!(same(&gp, &case.fit(&(0..n).collect::<Vec<_>>()), &case.x));
    }

    #[test]
    fn a_row_removed_is_as_if_it_had_never_been_there(case in case()) {
        let n = case.y.len();
        for index in [0, n / 2, n - 1] {
            let mut gp = case.fit(&(0..n).collect::<Vec<_>>());
            gp.remove_row(index).unwrap();
            let rest: Vec<usize> = (0..n).filter(|&i| i != index).collect();
            prop_assert!(same(&gp, &case.fit(&rest), &case.x));
        }
    }

    #[test]
    fn other_outputs_share_the_factorisation(case in case()) {
        let n = case.y.len();
        let all: Vec<usize> = (0..n).collect();
        let y: Vec<f64> = case.y.iter().map(|y| y * y - 1.0).collect();
        let shared = case.fit(&all).with_outputs(&y).unwrap();
        let alone = Case { y, ..case.clone() }.fit(&all);
        prop_assert!(same(&shared, &alone, &case.x));
    }

    #[test]
    fn variance_gradients_equal_finite_differences(case in case()) {
        let gp = case.fit(&(0..case.y.len()).collect::<Vec<_>>());
        let x_star = Mat::from_fn(3, case.x.ncols(), |i, d| 0.7 * i as f64 - 0.4 * d as f64 + 0.1);
        let gradient = gp.variance_gradient(x_star.as_ref()).unwrap();
        for d in 0..x_star.ncols() {
            let moved = |h: f64| {
                let x = Mat::from_fn(3, x_star.ncols(), |i, j| {
                    x_star[(i, j)] + if j == d { h } else { 0.0 }
                });
                gp.predict(x.as_ref()).unwrap().1
            };
            let h = 1e-4;
            for (i, (above, below)) in moved(h).iter().zip(moved(-h)).enumerate() {
                let expected = (above - below) / (2.0 * h);
                prop_assert!((gradient[(i, d)] - expected).abs() < 1e-6 * (1.0 + expected.abs()));
            }
        }
    }
}

#[test]
fn rows_with_more_noise_pull_less() {
    let x = Mat::from_fn(2, 1, |i, _| i as f64 * 1e-6);
    let kernel = SquaredExponential::new(&[1.0], 1.0).unwrap();
    let fit = |row_noise: &[f64]| {
        let mean = Mean::Fixed(0.0);
        Gp::builder(kernel.clone())
            .row_noise(row_noise)
            .noise_variance(0.1)
            .mean(mean)
            .condition(x.as_ref(), &[1.0, -1.0])
    };
    let mean =
        |row_noise: &[f64]| fit(row_noise).unwrap().predict_mean(x.subrows(0, 1)).unwrap()[0];
    assert!(mean(&[0.0, 0.0]).abs() < 1e-9);
    // Precisions 10 and 1 beside the prior's 1: (10 − 1)/12.
    assert!((mean(&[0.0, 0.9]) - 0.75).abs() < 1e-5);
    let error = fit(&[0.0, -1.0]).unwrap_err();
    assert_eq!(error, GpError::Negative { name: "noise variance of row 1".into(), value: -1.0 });
    assert!(matches!(fit(&[0.0]), Err(GpError::ShapeMismatch { what: "row noise", .. })));
}

#[test]
fn known_row_noise_leaves_the_common_noise_to_learn() {
    let n = 200;
    let wave = |i: usize, step: f64| (step * i as f64).sin();
    let x = Mat::from_fn(n, 1, |i, _| 0.05 * i as f64);
    let row_noise: Vec<f64> = (0..n).map(|i| if i % 2 == 0 { 0.5 } else { 0.0 }).collect();
    // Deviations without correlation: √2·sin has unit variance.
    let deviation = |i: usize| std::f64::consts::SQRT_2 * wave(i, 2.399_963);
    let y: Vec<f64> =
        (0..n).map(|i| wave(i, 0.05) + (0.01 + row_noise[i]).sqrt() * deviation(i)).collect();
    let kernel = || Matern52::unit(1).unwrap();
    let options = LearnOptions::default();
    let gp = Gp::builder(kernel())
        .row_noise(&row_noise)
        .options(options.clone())
        .fit(x.as_ref(), &y)
        .unwrap();
    assert!((gp.noise_variance().sqrt() - 0.1).abs() < 0.03, "{}", gp.noise_variance());
    let plain = Gp::builder(kernel()).options(options.clone()).fit(x.as_ref(), &y).unwrap();
    assert!(
        plain.noise_variance() > 0.15
            && gp.log_marginal_likelihood() > plain.log_marginal_likelihood()
    );
    let saved = Gp::from_model(&gp.to_model().unwrap()).unwrap();
    assert_eq!(saved.to_model().unwrap(), gp.to_model().unwrap());
    let values = saved.predict(x.as_ref()).unwrap();
    assert_eq!(values, gp.predict(x.as_ref()).unwrap());
}

#[test]
fn rows_that_cannot_come_or_go() {
    let x = Mat::from_fn(2, 1, |i, _| i as f64);
    let kernel = SquaredExponential::unit(1).unwrap();
    let mut gp =
        Gp::builder(kernel).noise_variance(0.0).condition(x.as_ref(), &[1.0, 2.0]).unwrap();
    let size = gp.outputs().len();
    assert!(matches!(gp.add_row(&[1.0], 0.0, 0.0), Err(GpError::NotPositiveDefinite { .. })));
    assert!(matches!(gp.add_row(&[1.0, 2.0], 0.0, 0.0), Err(GpError::ShapeMismatch { .. })));
    assert!(matches!(gp.add_row(&[5.0], f64::NAN, 0.0), Err(GpError::NotFinite { .. })));
    assert!(matches!(gp.add_row(&[5.0], 0.0, -1.0), Err(GpError::Negative { .. })));
    assert!(matches!(gp.with_outputs(&[1.0]), Err(GpError::ShapeMismatch { .. })));
    assert_eq!(gp.outputs().len(), size);
    assert!(matches!(gp.remove_row(2), Err(GpError::OutOfRange { .. })));
    gp.remove_row(0).unwrap();
    assert_eq!(gp.remove_row(0), Err(GpError::TooFewRows { needed: 2, actual: 1 }));
}
