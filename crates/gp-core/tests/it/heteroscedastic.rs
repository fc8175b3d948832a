//! The process with noise as a function of the input, on data whose noise is known.

use faer::linalg::solvers::Llt;
use faer::{Mat, Side};
use gp_core::scores::{coverage, nlpd};
use gp_core::{
    Gp, GpError, HeteroscedasticGp, HeteroscedasticGpModel, HeteroscedasticReport, LearnOptions,
    Matern32, Mean, Posterior, SquaredExponential,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// Noise of standard deviation 0.05 on the left, growing to 0.65 on the right of [0, 1].
fn noise_sd(x: f64) -> f64 {
    0.05 + 0.6 * x * x
}

/// sin(2πx) with that noise.
fn data(n: usize, seed: u64) -> (Mat<f64>, Vec<f64>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let x: Mat<f64> = Mat::from_fn(n, 1, |_, _| rng.random());
    let mut normal = || rng.sample::<f64, _>(StandardNormal);
    let value = |x: f64| (std::f64::consts::TAU * x).sin();
    let y = (0..n).map(|i| value(x[(i, 0)]) + noise_sd(x[(i, 0)]) * normal()).collect();
    (x, y)
}

fn learn(x: &Mat<f64>, y: &[f64]) -> (HeteroscedasticGp, HeteroscedasticReport) {
    let kernel = || SquaredExponential::unit(1).unwrap();
    let options = LearnOptions::default();
    HeteroscedasticGp::learn(kernel(), kernel(), x.as_ref(), y, &options).unwrap()
}

#[test]
fn it_finds_where_the_noise_is_and_beats_one_noise_for_all() {
    let (x, y) = data(200, 1);
    let (gp, report) = learn(&x, &y);
    assert!(report.stop.converged() && report.bound > report.homoscedastic + 20.0, "{report:?}");
    let x_star = Mat::from_fn(9, 1, |i, _| 0.1 + 0.1 * i as f64);
    let noise = gp.predict_noise(x_star.as_ref()).unwrap();
    for (i, noise) in noise.iter().enumerate() {
        let ratio = noise.sqrt() / noise_sd(x_star[(i, 0)]);
        assert!((0.7..1.4).contains(&ratio), "{i} {ratio}");
    }
    let (x_test, y_test) = data(2000, 2);
    let (mean, variance) = gp.predict_observation(x_test.as_ref()).unwrap();
    let kernel = SquaredExponential::unit(1).unwrap();
    let plain = Gp::builder(kernel).fit(x.as_ref(), &y).unwrap();
    let (plain_mean, plain_variance) = plain.predict_observation(x_test.as_ref()).unwrap();
    let gain = nlpd(&y_test, &plain_mean, &plain_variance).unwrap()
        - nlpd(&y_test, &mean, &variance).unwrap();
    assert!(gain > 0.2, "{gain}");
    let inside = coverage(&y_test, &mean, &variance, &[0.5, 0.95]).unwrap();
    assert!((inside[0] - 0.5).abs() < 0.07 && (inside[1] - 0.95).abs() < 0.03, "{inside:?}");
}

#[test]
fn with_one_noise_for_all_it_is_no_worse_than_the_plain_process() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let x = Mat::from_fn(120, 1, |_, _| rng.random::<f64>());
    let y: Vec<f64> = (0..120)
        .map(|i| (6.0 * x[(i, 0)]).sin() + 0.2 * rng.sample::<f64, _>(StandardNormal))
        .collect();
    let (gp, report) = learn(&x, &y);
    // A constant noise is among what it can say, so the bound comes close to the likelihood.
    assert!(report.bound > report.homoscedastic - 0.5, "{report:?}");
    let noise = gp.predict_noise(x.as_ref()).unwrap();
    assert!(noise.iter().all(|noise| (0.12..0.3).contains(&noise.sqrt())));
}

#[test]
fn variances_are_between_zero_and_the_prior_and_agree_with_the_joint_ones() {
    let (x, y) = data(60, 3);
    let (gp, report) = learn(&x, &y);
    let x_star = Mat::from_fn(20, 1, |i, _| 0.1 * i as f64 - 0.5);
    let (mean, variance) = gp.predict(x_star.as_ref()).unwrap();
    let prior = report.kernel[1];
    let known = HeteroscedasticGpModel { mean: Mean::Fixed(0.2), ..gp.to_model().unwrap() };
    let known = HeteroscedasticGp::from_model(&known).unwrap().predict(x_star.as_ref()).unwrap().1;
    assert!(known.iter().all(|variance| (0.0..=prior).contains(variance)));
    assert!(known.iter().zip(&variance).all(|(known, learnt)| known <= learnt));
    assert_eq!(gp.predict_mean(x_star.as_ref()).unwrap(), mean);
    let joint = gp.predict_joint(x_star.as_ref()).unwrap();
    let mut covariance = joint.covariance().to_owned();
    for (i, variance) in variance.iter().enumerate() {
        assert!((covariance[(i, i)] - variance).abs() < 1e-10);
        covariance[(i, i)] += 1e-8;
    }
    assert!(Llt::new(covariance.as_ref(), Side::Lower).is_ok());
}

#[test]
fn a_saved_model_predicts_the_same_bits() {
    let (x, y) = data(40, 4);
    let (gp, _) = learn(&x, &y);
    let text = serde_json::to_string(&gp.to_model().unwrap()).unwrap();
    let model: HeteroscedasticGpModel = serde_json::from_str(&text).unwrap();
    let loaded = HeteroscedasticGp::from_model(&model).unwrap();
    assert_eq!(
        gp.predict_observation(x.as_ref()).unwrap(),
        loaded.predict_observation(x.as_ref()).unwrap()
    );
    assert_eq!(loaded.to_model().unwrap(), model);
    let newer = HeteroscedasticGpModel { version: 2, ..model.clone() };
    let refused = |model| HeteroscedasticGp::from_model(model).unwrap_err();
    assert_eq!(refused(&newer), GpError::UnsupportedVersion { found: 2, supported: 1 });
    let flat = HeteroscedasticGpModel { precisions: vec![0.0; 40], ..model.clone() };
    assert!(matches!(refused(&flat), GpError::NotPositive { .. }));
    let short = HeteroscedasticGpModel { precisions: vec![1.0], ..model };
    assert!(matches!(refused(&short), GpError::ShapeMismatch { what: "precisions", .. }));
}

#[test]
fn kernels_of_different_inputs_are_refused() {
    let (x, y) = data(10, 5);
    let (kernel, other) = (SquaredExponential::unit(1).unwrap(), Matern32::unit(2).unwrap());
    let result = HeteroscedasticGp::learn(kernel, other, x.as_ref(), &y, &LearnOptions::default());
    let what = "columns of the inputs";
    assert_eq!(result.unwrap_err(), GpError::ShapeMismatch { what, expected: 2, actual: 1 });
}
