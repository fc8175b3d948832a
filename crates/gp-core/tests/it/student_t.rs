//! The process whose noise has heavy tails: its limits, brute force, and data with outliers.

use std::f64::consts::PI;

use faer::Mat;
use gp_core::{
    Gp, GpError, Kernel, LearnOptions, Matern52, Mean, Posterior, SquaredExponential, StudentTGp,
    StudentTGpModel,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

fn kernel() -> SquaredExponential {
    SquaredExponential::new(&[1.0], 1.3).unwrap()
}

fn line(n: usize) -> (Mat<f64>, Vec<f64>) {
    let x = Mat::from_fn(n, 1, |i, _| 0.4 * i as f64);
    let y = (0..n).map(|i| (0.4 * i as f64).sin() + 0.1 * (5.0 * i as f64).cos()).collect();
    (x, y)
}

/// sin(2πx) with noise of standard deviation 0.1 and every tenth row off by some units.
fn data(n: usize, has_outliers: bool, seed: u64) -> (Mat<f64>, Vec<f64>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let x: Mat<f64> = Mat::from_fn(n, 1, |_, _| rng.random());
    let y = (0..n).map(|i| {
        let normal: f64 = rng.sample(StandardNormal);
        let sd = if has_outliers && i % 10 == 3 { 3.0 } else { 0.1 };
        (2.0 * PI * x[(i, 0)]).sin() + sd * normal
    });
    let y = y.collect();
    (x, y)
}

#[test]
fn with_endless_degrees_of_freedom_it_is_the_gaussian_process() {
    let (x, y) = line(12);
    let robust = StudentTGp::fit(kernel(), x.as_ref(), &y, 0.04, 1e8, Mean::Estimated).unwrap();
    let plain = Gp::builder(kernel()).noise_variance(0.04).condition(x.as_ref(), &y).unwrap();
    let x_star = Mat::from_fn(7, 1, |i, _| 0.9 * i as f64 - 0.5);
    let (found, expected) =
        (robust.predict(x_star.as_ref()).unwrap(), plain.predict(x_star.as_ref()).unwrap());
    let close = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
    assert!(close(&found.0, &expected.0) && close(&found.1, &expected.1));
    assert!((robust.bound() - plain.log_marginal_likelihood()).abs() < 1e-5);
}

#[test]
fn the_influence_of_an_outlier_vanishes_as_it_goes_away() {
    let (x, y) = line(12);
    let without = |values: &[f64]| -> Vec<f64> {
        values.iter().enumerate().filter(|(i, _)| *i != 5).map(|(_, value)| *value).collect()
    };
    let positions: Vec<f64> = (0..12).map(|i| x[(i, 0)]).collect();
    let (x_rest, y_rest) = (without(&positions), without(&y));
    let x_rest = Mat::from_fn(11, 1, |i, _| x_rest[i]);
    let robust = |x: &Mat<f64>, y: &[f64]| {
        StudentTGp::fit(kernel(), x.as_ref(), y, 0.01, 4.0, Mean::Estimated).unwrap()
    };
    let at = Mat::from_fn(1, 1, |_, _| 2.0);
    let expected = robust(&x_rest, &y_rest).predict(at.as_ref()).unwrap();
    let mut last = f64::INFINITY;
    for outlier in [10.0, 1e3, 1e5] {
        let mut y = y.clone();
        y[5] = outlier;
        let found = robust(&x, &y).predict(at.as_ref()).unwrap();
        let shift = (found.0[0] - expected.0[0]).abs() + (found.1[0] - expected.1[0]).abs();
        assert!(shift < 0.1 * last, "{outlier}: {shift} after {last}");
        last = shift;
        let plain = Gp::builder(kernel()).noise_variance(0.01).condition(x.as_ref(), &y).unwrap();
        assert!((plain.predict_mean(at.as_ref()).unwrap()[0] - expected.0[0]).abs() > 1.0);
    }
    assert!(last < 1e-5, "{last}");
}

/// ln p(y) and E f at the rows, by the midpoint rule over all f.
fn brute_force(
    covariance: &[[f64; 2]; 2],
    y: &[f64; 2],
    scale: f64,
    degrees: f64,
) -> (f64, [f64; 2]) {
    let [[a, b], [_, c]] = *covariance;
    let determinant = a * c - b * b;
    let density = |f: [f64; 2]| {
        let square = (c * f[0] * f[0] - 2.0 * b * f[0] * f[1] + a * f[1] * f[1]) / determinant;
        let prior = -0.5 * square - (2.0 * PI * determinant.sqrt()).ln();
        let student = |e: f64| {
            log_gamma_ratio(degrees)
                - 0.5 * (degrees * PI * scale).ln()
                - 0.5 * (degrees + 1.0) * (e * e / (degrees * scale)).ln_1p()
        };
        (prior + student(y[0] - f[0]) + student(y[1] - f[1])).exp()
    };
    let (mut total, mut mean) = (0.0, [0.0; 2]);
    let (n, reach) = (1200, 7.0);
    let step = 2.0 * reach / n as f64;
    for i in 0..n {
        for j in 0..n {
            let f = [i, j].map(|k| (k as f64 + 0.5) * step - reach);
            let weight = density(f) * step * step;
            total += weight;
            mean = [mean[0] + weight * f[0], mean[1] + weight * f[1]];
        }
    }
    (total.ln(), mean.map(|mean| mean / total))
}

/// ln Γ((ν + 1)/2) − ln Γ(ν/2) for ν = 4: Γ(5/2) = ¾√π, Γ(2) = 1.
fn log_gamma_ratio(degrees: f64) -> f64 {
    assert_eq!(degrees, 4.0);
    (0.75 * PI.sqrt()).ln()
}

#[test]
fn two_rows_agree_with_brute_force() {
    let x = Mat::from_fn(2, 1, |i, _| 0.8 * i as f64);
    let (scale, degrees) = (0.05, 4.0);
    let k = kernel();
    let entry = |i: usize, j: usize| k.value(&[x[(i, 0)]], &[x[(j, 0)]]);
    let covariance = [[entry(0, 0), entry(0, 1)], [entry(1, 0), entry(1, 1)]];
    for y in [[0.3, 0.5], [0.3, 1.2], [-0.4, 0.4], [0.3, 3.0]] {
        let gp =
            StudentTGp::fit(kernel(), x.as_ref(), &y, scale, degrees, Mean::Fixed(0.0)).unwrap();
        let (evidence, mean) = brute_force(&covariance, &y, scale, degrees);
        let gap = evidence - gp.bound();
        assert!(gap > 0.0, "{y:?}: {gap}");
        if y[1] == 3.0 {
            // Either row may be the outlier, and the belief keeps one of two explanations.
            assert!(gap < 2.0_f64.ln() + 0.05, "{gap}");
            continue;
        }
        assert!(gap < 0.3, "{y:?}: {gap}");
        let found = gp.predict_mean(x.as_ref()).unwrap();
        let error = (found[0] - mean[0]).abs().max((found[1] - mean[1]).abs());
        assert!(error < 0.05 * (1.0 + y[1].abs()), "{y:?}: {found:?} {mean:?}");
    }
}

#[test]
fn densities_of_observations_integrate_to_one() {
    let (x, y) = line(6);
    let gp = StudentTGp::fit(kernel(), x.as_ref(), &y, 0.05, 6.0, Mean::Estimated).unwrap();
    let at = Mat::from_fn(1, 1, |_, _| 3.1);
    let (mean, variance) = gp.predict_observation(at.as_ref()).unwrap();
    // By y = mean + sinh u, so that the tails are reached.
    let (step, reach) = (0.01, 9.0);
    let (mut total, mut square) = (0.0, 0.0);
    for i in 0..(2.0 * reach / step) as usize {
        let u: f64 = i as f64 * step - reach;
        let density = gp.predict_log_density(at.as_ref(), &[mean[0] + u.sinh()]).unwrap()[0].exp();
        total += step * u.cosh() * density;
        square += step * u.cosh() * density * u.sinh().powi(2);
    }
    assert!((total - 1.0).abs() < 1e-8, "{total}");
    assert!((square / variance[0] - 1.0).abs() < 1e-3, "{square} {variance:?}");
}

#[test]
fn with_outliers_it_finds_the_function_that_a_gaussian_loses() {
    let (x, y) = data(120, true, 1);
    let kernel = || Matern52::unit(1).unwrap();
    let options = LearnOptions::default();
    let (robust, report) = StudentTGp::learn(kernel(), x.as_ref(), &y, &options).unwrap();
    let plain = Gp::builder(kernel()).options(options.clone()).fit(x.as_ref(), &y).unwrap();
    assert!(report.stop.converged() && report.at_bound.len() <= 1, "{report:?}");
    let x_star = Mat::from_fn(50, 1, |i, _| 0.02 * i as f64 + 0.01);
    let error = |posterior: &dyn Posterior| {
        let mean = posterior.predict_mean(x_star.as_ref()).unwrap();
        let square = |i: usize| (mean[i] - (2.0 * PI * x_star[(i, 0)]).sin()).powi(2);
        ((0..50).map(square).sum::<f64>() / 50.0).sqrt()
    };
    let (of_robust, of_plain) = (error(&robust), error(&plain));
    assert!(of_robust < 0.06 && of_robust < 0.4 * of_plain, "{of_robust} {of_plain}");
    let scale = robust.scale_variance().sqrt();
    assert!((0.06..0.14).contains(&scale) && robust.degrees_of_freedom() < 4.0, "{report:?}");
    let (x_test, y_test) = data(1000, true, 2);
    let density = robust.predict_log_density(x_test.as_ref(), &y_test).unwrap();
    let loss = -density.iter().sum::<f64>() / 1000.0;
    let (mean, variance) = plain.predict_observation(x_test.as_ref()).unwrap();
    let gain = gp_core::scores::nlpd(&y_test, &mean, &variance).unwrap() - loss;
    assert!(gain > 0.5, "{gain}");
}

#[test]
fn with_gaussian_noise_it_is_no_worse_than_the_gaussian_process() {
    let (x, y) = data(80, false, 3);
    let kernel = || Matern52::unit(1).unwrap();
    let options = LearnOptions::default();
    let (robust, report) = StudentTGp::learn(kernel(), x.as_ref(), &y, &options).unwrap();
    let plain = Gp::builder(kernel()).options(options.clone()).fit(x.as_ref(), &y).unwrap();
    assert!(report.bound > plain.log_marginal_likelihood() - 0.5, "{report:?}");
    assert!(robust.degrees_of_freedom() > 10.0, "{report:?}");
    let noise = robust.predict_noise(x.as_ref()).unwrap()[0];
    assert!((noise / plain.noise_variance() - 1.0).abs() < 0.2, "{noise}");
}

#[test]
fn a_saved_model_predicts_the_same_bits() {
    let (x, mut y) = line(12);
    y[4] = 9.0;
    let gp = StudentTGp::fit(kernel(), x.as_ref(), &y, 0.04, 3.0, Mean::Estimated).unwrap();
    let text = serde_json::to_string(&gp.to_model().unwrap()).unwrap();
    let mut model: StudentTGpModel = serde_json::from_str(&text).unwrap();
    let loaded = StudentTGp::from_model(&model).unwrap();
    assert_eq!(loaded.predict(x.as_ref()).unwrap(), gp.predict(x.as_ref()).unwrap());
    assert_eq!(loaded.bound(), gp.bound());
    model.version = 7;
    let expected = GpError::UnsupportedVersion { found: 7, supported: StudentTGpModel::VERSION };
    assert_eq!(StudentTGp::from_model(&model).unwrap_err(), expected);
}

#[test]
fn noise_without_a_variance_is_refused() {
    let (x, y) = line(5);
    let fit = |scale, degrees| {
        StudentTGp::fit(kernel(), x.as_ref(), &y, scale, degrees, Mean::Estimated).unwrap_err()
    };
    assert!(matches!(fit(0.1, 2.0), GpError::OutOfRange { value: 2.0, .. }));
    assert!(matches!(fit(0.0, 5.0), GpError::NotPositive { .. }));
}
