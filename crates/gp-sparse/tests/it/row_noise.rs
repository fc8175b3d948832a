//! Known noise of the rows.

use faer::Mat;
use gp_core::{Gp, GpError, Posterior, SquaredExponential};
use gp_sparse::{Approximation, PseudoInputs, SparseGp, SparseOptions, SparseSettings};

const ALL: [Approximation; 4] = [
    Approximation::Fitc,
    Approximation::Vfe,
    Approximation::Dtc,
    Approximation::PowerEp { alpha: 0.4 },
];
const NOISE_VARIANCE: f64 = 0.03;

fn kernel() -> SquaredExponential {
    SquaredExponential::new(&[0.7], 1.3).unwrap()
}

fn settings(approximation: Approximation) -> SparseSettings {
    SparseSettings { approximation, jitter: 0.0, ..SparseSettings::default() }
}

/// Inputs a lengthscale apart, outputs, and noise that differs a hundredfold.
fn data(n: usize, distance: f64) -> (Mat<f64>, Vec<f64>, Vec<f64>) {
    let x = Mat::from_fn(n, 1, |i, _| distance * i as f64);
    let y = (0..n).map(|i| (1.7 * distance * i as f64).sin() + 0.2 * (i % 3) as f64).collect();
    (x, y, (0..n).map(|i| [0.0, 0.01, 1.0][i % 3]).collect())
}

fn pseudo_inputs() -> Mat<f64> {
    Mat::from_fn(5, 1, |a, _| 0.2 + 1.1 * a as f64)
}

#[test]
fn pseudo_inputs_at_the_data_give_the_exact_process() {
    let (x, y, noise) = data(12, 0.7);
    let exact = Gp::builder(kernel()).row_noise(&noise).noise_variance(NOISE_VARIANCE);
    let exact = exact.condition(&x, &y).unwrap();
    let x_star = Mat::from_fn(7, 1, |i, _| 1.3 * i as f64 - 0.4);
    let (mean, variance) = exact.predict(&x_star).unwrap();
    for approximation in ALL {
        let settings = settings(approximation);
        let (x, z) = (x.as_ref(), x.as_ref());
        let gp = SparseGp::fit_with_row_noise(kernel(), x, &y, &noise, z, NOISE_VARIANCE, settings);
        let gp = gp.unwrap();
        assert!((gp.objective() - exact.log_marginal_likelihood()).abs() < 1e-8);
        let (sparse_mean, sparse_variance) = gp.predict(x_star.as_ref()).unwrap();
        for i in 0..7 {
            assert!((sparse_mean[i] - mean[i]).abs() < 1e-9, "{approximation:?}");
            assert!((sparse_variance[i] - variance[i]).abs() < 1e-9, "{approximation:?}");
        }
    }
}

#[test]
fn the_same_noise_of_all_rows_is_noise_of_the_process() {
    let (x, y, _) = data(300, 0.02);
    let z = pseudo_inputs();
    for approximation in ALL {
        let (x, z, settings) = (x.as_ref(), z.as_ref(), settings(approximation));
        let of_rows =
            SparseGp::fit_with_row_noise(kernel(), x, &y, &[0.02; 300], z, 0.01, settings).unwrap();
        let common = SparseGp::fit(kernel(), x, &y, z, 0.03, settings).unwrap();
        assert!((of_rows.objective() - common.objective()).abs() < 1e-9, "{approximation:?}");
        let (a, b) = (of_rows.predict(z).unwrap(), common.predict(z).unwrap());
        assert!(a.0.iter().zip(&b.0).all(|(a, b)| (a - b).abs() < 1e-11));
        assert!(a.1.iter().zip(&b.1).all(|(a, b)| (a - b).abs() < 1e-11));
        assert_eq!(of_rows.noise_variance(), 0.01);
    }
}

#[test]
fn gradients_equal_finite_differences() {
    let (x, y, noise) = data(30, 0.15);
    for approximation in ALL {
        let settings = settings(approximation);
        let fit = |logs: &[f64]| {
            let kernel = SquaredExponential::new(&[logs[0].exp()], logs[1].exp()).unwrap();
            let (x, z) = (x.as_ref(), pseudo_inputs());
            let noise_variance = logs[2].exp();
            let z = z.as_ref();
            SparseGp::fit_with_row_noise(kernel, x, &y, &noise, z, noise_variance, settings)
                .unwrap()
        };
        let logs = [-0.3, 0.2, -3.0];
        let gp = fit(&logs);
        let mut evaluator = gp.evaluator_with_row_noise(x.as_ref(), &y, &noise).unwrap();
        assert!((evaluator.evaluate().unwrap() - gp.objective()).abs() < 1e-10);
        for (k, slope) in evaluator.gradient()[..3].iter().enumerate() {
            let at = |h: f64| {
                let mut moved = logs;
                moved[k] += h;
                fit(&moved).objective()
            };
            let expected = (at(1e-5) - at(-1e-5)) / 2e-5;
            let close = (slope - expected).abs() < 1e-6 * (1.0 + slope.abs());
            assert!(close, "{approximation:?} {k}: {slope} {expected}");
        }
    }
}

#[test]
fn known_noise_is_not_learnt_again() {
    let (x, y, _) = data(240, 0.02);
    let noise: Vec<f64> = (0..240).map(|i| if i % 2 == 0 { 0.0 } else { 0.5 }).collect();
    let coarse: Vec<f64> = (0..240)
        .map(|i| y[i] - 0.2 * (i % 3) as f64 + noise[i].sqrt() * (13.0 * (i * i) as f64).sin())
        .collect();
    let sd = |row_noise: Vec<f64>| {
        let pseudo_inputs = PseudoInputs::Given(pseudo_inputs());
        let options = SparseOptions { pseudo_inputs, row_noise, ..SparseOptions::default() };
        let (gp, _) = SparseGp::learn(kernel(), x.as_ref(), &coarse, &options).unwrap();
        gp.noise_variance().sqrt()
    };
    let (told, untold) = (sd(noise.clone()), sd(Vec::new()));
    assert!(told < 0.1 && untold > 0.3, "{told} {untold}");
}

#[test]
fn noise_that_does_not_fit_the_rows() {
    let (x, y, _) = data(3, 0.7);
    let fit = |noise: &[f64]| {
        let (x, settings) = (x.as_ref(), settings(Approximation::Vfe));
        SparseGp::fit_with_row_noise(kernel(), x, &y, noise, x, 0.1, settings).unwrap_err()
    };
    assert_eq!(fit(&[0.0]), GpError::ShapeMismatch { what: "row noise", expected: 3, actual: 1 });
    let negative = fit(&[0.0, -1.0, 0.0]);
    assert_eq!(negative, GpError::Negative { name: "noise variance of row 1".into(), value: -1.0 });
    let options = SparseOptions { row_noise: vec![0.1], ..SparseOptions::default() };
    let result = SparseGp::learn(kernel(), x.as_ref(), &y, &options);
    assert!(matches!(result, Err(GpError::ShapeMismatch { what: "row noise", .. })));
}
