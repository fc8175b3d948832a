//! Linear means and mean functions.

use faer::Mat;
use gp_core::{
    Gp, GpError, GpModel, HeteroscedasticGp, LearnOptions, Mean, MeanFunction, Polynomial,
    Posterior, SquaredExponential, WithMean,
};
use serde::{Deserialize, Serialize};

const NOISE_VARIANCE: f64 = 0.02;

fn kernel(scale: f64) -> SquaredExponential {
    SquaredExponential::new(&[0.8, 1.1], 0.7 * scale * scale).unwrap()
}

fn inputs(n: usize, seed: f64) -> Mat<f64> {
    Mat::from_fn(n, 2, |i, d| 2.0 * (1.7 * (2 * i + d) as f64 + seed).sin() + 5.0)
}

fn outputs(x: &Mat<f64>) -> Vec<f64> {
    (0..x.nrows()).map(|i| (2.0 * x[(i, 0)]).sin() + 0.3 * x[(i, 1)].powi(2)).collect()
}

fn plane(x: &Mat<f64>, i: usize) -> f64 {
    2.0 - 3.0 * x[(i, 0)] + 0.5 * x[(i, 1)]
}

fn fit(x: &Mat<f64>, y: &[f64]) -> Gp {
    Gp::builder(kernel(1.0))
        .noise_variance(NOISE_VARIANCE)
        .mean(Mean::Linear)
        .condition(x.as_ref(), y)
        .unwrap()
}

#[test]
fn a_plane_is_found_exactly_and_continued_far_away() {
    let x = inputs(12, 0.0);
    let y: Vec<f64> = (0..12).map(|i| plane(&x, i)).collect();
    let gp = fit(&x, &y);
    assert!((gp.mean() - 2.0).abs() < 1e-10);
    assert!((gp.mean_slopes()[0] + 3.0).abs() < 1e-11 && (gp.mean_slopes()[1] - 0.5).abs() < 1e-11);
    let far = Mat::from_fn(4, 2, |i, d| 100.0 * (i + d) as f64 - 70.0);
    let mean = gp.predict_mean(far.as_ref()).unwrap();
    assert!((0..4).all(|i| (mean[i] - plane(&far, i)).abs() < 1e-8), "{mean:?}");
    let slopes = gp.mean_gradient(far.as_ref()).unwrap();
    assert!((0..4).all(|i| (slopes[(i, 0)] + 3.0).abs() < 1e-9));
}

#[test]
fn a_plane_added_to_the_outputs_is_added_to_the_predictions() {
    let (x, x_star) = (inputs(15, 0.0), inputs(6, 0.4));
    let y = outputs(&x);
    let (mean, variance) = fit(&x, &y).predict(x_star.as_ref()).unwrap();
    let scale = -7.0;
    let moved: Vec<f64> = (0..15).map(|i| scale * y[i] + plane(&x, i)).collect();
    let noise = scale * scale * NOISE_VARIANCE;
    let gp = Gp::builder(kernel(scale))
        .noise_variance(noise)
        .mean(Mean::Linear)
        .condition(x.as_ref(), &moved)
        .unwrap();
    let (moved_mean, moved_variance) = gp.predict(x_star.as_ref()).unwrap();
    for i in 0..6 {
        let expected = scale * mean[i] + plane(&x_star, i);
        assert!((moved_mean[i] - expected).abs() < 1e-10 * (1.0 + expected.abs()));
        assert!((moved_variance[i] - scale * scale * variance[i]).abs() < 1e-11);
    }
}

#[test]
fn slopes_of_the_likelihood_equal_finite_differences() {
    let x = inputs(15, 0.0);
    let y = outputs(&x);
    let values = [0.8, 1.1, 0.7, NOISE_VARIANCE];
    let likelihood = |values: [f64; 4]| {
        let kernel = SquaredExponential::new(&values[..2], values[2]).unwrap();
        Gp::builder(kernel)
            .noise_variance(values[3])
            .mean(Mean::Linear)
            .condition(x.as_ref(), &y)
            .unwrap()
    };
    let gradient = likelihood(values).log_marginal_likelihood_gradient().unwrap();
    for (p, slope) in gradient.iter().enumerate() {
        let moved = |h: f64| {
            let mut values = values;
            values[p] *= h.exp();
            likelihood(values).log_marginal_likelihood()
        };
        let expected = (moved(1e-5) - moved(-1e-5)) / 2e-5;
        assert!((slope - expected).abs() < 1e-6 * (1.0 + slope.abs()), "{p} {slope} {expected}");
    }
}

#[test]
fn rows_come_and_go_and_models_are_saved_with_a_linear_mean() {
    let x = inputs(15, 0.0);
    let y = outputs(&x);
    let mut gp = fit(&x, &y);
    let model: GpModel =
        serde_json::from_str(&serde_json::to_string(&gp.to_model().unwrap()).unwrap()).unwrap();
    let x_star = inputs(6, 0.4);
    let expected = gp.predict(x_star.as_ref()).unwrap();
    assert_eq!(Gp::from_model(&model).unwrap().predict(x_star.as_ref()).unwrap(), expected);
    gp.remove_row(0).unwrap();
    gp.add_row(&[x[(0, 0)], x[(0, 1)]], y[0], 0.0).unwrap();
    let mean = gp.predict_mean(x_star.as_ref()).unwrap();
    assert!((0..6).all(|i| (mean[i] - expected.0[i]).abs() < 1e-9));
}

#[test]
fn a_process_with_changing_noise_learns_no_slopes() {
    let x = inputs(12, 0.0);
    let options = LearnOptions { mean: Mean::Linear, ..LearnOptions::default() };
    let found =
        HeteroscedasticGp::learn(kernel(1.0), kernel(1.0), x.as_ref(), &outputs(&x), &options);
    assert_eq!(found.unwrap_err(), GpError::LinearMean);
}

#[test]
fn a_linear_mean_is_learnt_with_the_hyperparameters() {
    let x = inputs(40, 0.0);
    let wave = |x: f64| 0.2 * (3.0 * x).sin();
    let y: Vec<f64> = (0..40).map(|i| plane(&x, i) + wave(x[(i, 0)])).collect();
    let learn = |mean| {
        let options = LearnOptions { mean, ..LearnOptions::default() };
        let kernel = SquaredExponential::unit(2).unwrap();
        Gp::builder(kernel).options(options.clone()).fit(x.as_ref(), &y).unwrap()
    };
    let (linear, constant) = (learn(Mean::Linear), learn(Mean::Estimated));
    assert!(linear.log_marginal_likelihood() > constant.log_marginal_likelihood() + 3.0);
    assert!((linear.mean_slopes()[1] - 0.5).abs() < 0.05, "{:?}", linear.mean_slopes());
}

#[test]
fn a_constant_mean_function_is_a_fixed_mean() {
    let (x, x_star) = (inputs(15, 0.0), inputs(6, 0.4));
    let y = outputs(&x);
    let fixed = |mean, y: &[f64]| {
        Gp::builder(kernel(1.0))
            .noise_variance(NOISE_VARIANCE)
            .mean(Mean::Fixed(mean))
            .condition(x.as_ref(), y)
    };
    let about = WithMean::fit(|_: &[f64]| 1.5, x.as_ref(), &y, |y| fixed(0.0, y)).unwrap();
    let expected = fixed(1.5, &y).unwrap();
    let close = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12);
    let (mean, variance) = about.predict_observation(x_star.as_ref()).unwrap();
    let (expected_mean, expected_variance) = expected.predict_observation(x_star.as_ref()).unwrap();
    assert!(close(&mean, &expected_mean) && close(&variance, &expected_variance));
    let joint = about.predict_joint(x_star.as_ref()).unwrap();
    assert!(close(joint.mean(), &expected_mean));
}

/// A mean function of plain data.
#[derive(Serialize, Deserialize)]
struct Plane {
    slopes: Vec<f64>,
}

impl MeanFunction for Plane {
    fn value(&self, x: &[f64]) -> f64 {
        x.iter().zip(&self.slopes).map(|(x, slope)| x * slope).sum()
    }
}

#[test]
fn a_process_about_a_function_is_saved_and_read_with_it() {
    let (x, x_star) = (inputs(15, 0.0), inputs(6, 0.4));
    let y = outputs(&x);
    let builder = Gp::builder(kernel(1.0)).noise_variance(NOISE_VARIANCE);
    let plane = Plane { slopes: vec![0.3, -0.7] };
    let about = WithMean::fit(plane, x.as_ref(), &y, |y| builder.condition(x.as_ref(), y)).unwrap();
    let expected = about.predict(x_star.as_ref()).unwrap();
    let text = serde_json::to_string(&about).unwrap();
    let read: WithMean<Plane, Gp> = serde_json::from_str(&text).unwrap();
    assert_eq!(read.predict(x_star.as_ref()).unwrap(), expected);
    for (from, to) in [("\"residual\"", "\"remains\""), ("[0.3", "[\"0.3\""), ("}", "")] {
        let damaged = text.replacen(from, to, 1);
        assert!(damaged != text && serde_json::from_str::<WithMean<Plane, Gp>>(&damaged).is_err());
    }
    // Of a closure the rest is saved, and put together with it again.
    let residual: Gp =
        serde_json::from_str(&serde_json::to_string(about.residual()).unwrap()).unwrap();
    let again = WithMean::about(|x: &[f64]| about.function().value(x), residual);
    assert_eq!(again.predict(x_star.as_ref()).unwrap(), expected);
}

#[test]
fn far_from_all_data_the_physics_is_left() {
    let x = inputs(15, 0.0);
    let y = outputs(&x);
    let physics = |x: &[f64]| 0.3 * x[1] * x[1];
    let hybrid = WithMean::fit(physics, x.as_ref(), &y, |residuals| {
        Gp::builder(kernel(1.0))
            .noise_variance(NOISE_VARIANCE)
            .mean(Mean::Fixed(0.0))
            .condition(x.as_ref(), residuals)
    });
    let far = Mat::from_fn(1, 2, |_, _| 60.0);
    let mean = hybrid.unwrap().predict_mean(far.as_ref()).unwrap();
    assert!((mean[0] - 0.3 * 3600.0).abs() < 1e-9);
    let broken = WithMean::fit(
        |_: &[f64]| f64::NAN,
        x.as_ref(),
        &y,
        |y| Gp::builder(kernel(1.0)).noise_variance(NOISE_VARIANCE).condition(x.as_ref(), y),
    );
    assert!(matches!(broken.unwrap_err(), GpError::NotFinite { what: "mean function", .. }));
}

fn parabola(x: &Mat<f64>, i: usize) -> f64 {
    let (a, b) = (x[(i, 0)], x[(i, 1)]);
    1.0 - 2.0 * a + 0.5 * b + 0.25 * a * a - 0.75 * a * b + 2.0 * b * b
}

/// On no curve of second degree.
fn scattered(n: usize, seed: f64) -> Mat<f64> {
    let turn = |i: usize, d: usize| 1.7 * (2 * i + d) as f64 + 0.9 * (i * i * (d + 1)) as f64;
    Mat::from_fn(n, 2, |i, d| 2.0 * (turn(i, d) + seed).sin() + 5.0)
}

#[test]
fn a_polynomial_is_found_exactly_and_continued_far_away() {
    let x = scattered(14, 0.0);
    let y: Vec<f64> = (0..14).map(|i| parabola(&x, i)).collect();
    let builder = Gp::builder(kernel(1.0)).noise_variance(NOISE_VARIANCE).mean(Mean::Polynomial(2));
    let gp = builder.condition(&x, &y).unwrap();
    assert!((gp.mean() - 1.0).abs() < 1e-7, "{}", gp.mean());
    let far = Mat::from_fn(4, 2, |i, d| 30.0 * (i + d) as f64 - 20.0);
    let mean = gp.predict_mean(far.as_ref()).unwrap();
    let slopes = gp.mean_gradient(far.as_ref()).unwrap();
    for (i, mean) in mean.iter().enumerate() {
        assert!((mean / parabola(&far, i) - 1.0).abs() < 1e-8, "{mean}");
        let slope = -2.0 + 0.5 * far[(i, 0)] - 0.75 * far[(i, 1)];
        assert!((slopes[(i, 0)] - slope).abs() < 1e-6, "{} {slope}", slopes[(i, 0)]);
    }
    let again: Gp = serde_json::from_str(&serde_json::to_string(&gp).unwrap()).unwrap();
    assert_eq!(again.predict_mean(far.as_ref()).unwrap(), mean);
    assert_eq!(gp.expansion().unwrap_err(), GpError::PolynomialMean);
}

#[test]
fn a_polynomial_is_the_limit_of_ever_wider_priors() {
    let (x, x_star) = (scattered(14, 0.0), scattered(6, 0.4));
    let y: Vec<f64> = (0..14).map(|i| (3.0 * x[(i, 0)]).sin() + x[(i, 1)]).collect();
    let polynomial = Gp::builder(kernel(1.0)).noise_variance(NOISE_VARIANCE);
    let gp = polynomial.mean(Mean::Polynomial(2)).condition(&x, &y).unwrap();
    let (mean, variance) = gp.predict(&x_star).unwrap();
    let off = |wide: f64| {
        let whole = kernel(1.0) + wide * Polynomial::isotropic(2, 1.0);
        let builder = Gp::builder(whole).noise_variance(NOISE_VARIANCE).mean(Mean::Fixed(0.0));
        let known = builder.condition(&x, &y).unwrap().predict(&x_star).unwrap();
        let apart = |(a, b): (&f64, &f64)| (a - b).abs();
        let means = mean.iter().zip(&known.0).map(apart).fold(0.0, f64::max);
        variance.iter().zip(&known.1).map(apart).fold(means, f64::max)
    };
    let (narrow, wide) = (off(1e2), off(1e5));
    assert!(wide < 0.01 * narrow && wide < 1e-3, "{narrow} {wide}");
}

#[test]
fn a_polynomial_that_rows_do_not_tell_is_an_error() {
    let x = scattered(5, 0.0);
    let fit = |mean: Mean| {
        let builder = Gp::builder(kernel(1.0)).noise_variance(NOISE_VARIANCE).mean(mean);
        builder.condition(&x, &outputs(&x)).unwrap_err()
    };
    let expected = GpError::UndeterminedSlope { input: 1, n_rows: 5 };
    assert_eq!(fit(Mean::Polynomial(2)), expected);
    assert!(matches!(fit(Mean::Polynomial(7)), GpError::OutOfRange { value: 7.0, .. }));
    assert_eq!(Mean::Polynomial(3).n_coefficients(4), 35);
}
