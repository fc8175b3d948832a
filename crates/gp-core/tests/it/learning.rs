//! Learning hyperparameters: recovery, equivariance, determinism, hard cases.

use faer::{Mat, MatRef};
use gp_core::{
    Gp, GpError, HyperPrior, JointGaussian, LearnOptions, LearnReport, Matern52, Mean, Periodic,
    Posterior, SquaredExponential, scores,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

fn uniform(n: usize, d: usize, seed: u64) -> Mat<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    Mat::from_fn(n, d, |_, _| rng.random_range(-1.0..1.0))
}

fn noisy(mut values: Vec<f64>, sd: f64, seed: u64) -> Vec<f64> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    values.iter_mut().for_each(|value| *value += sd * rng.sample::<f64, _>(StandardNormal));
    values
}

fn by_row(x: &Mat<f64>, function: impl Fn(&dyn Fn(usize) -> f64) -> f64) -> Vec<f64> {
    (0..x.nrows()).map(|i| function(&|d| x[(i, d)])).collect()
}

fn learn(x: MatRef<'_, f64>, y: &[f64]) -> (Gp, LearnReport) {
    let kernel = SquaredExponential::unit(x.ncols()).unwrap();
    with_report(Gp::builder(kernel).fit(x, y).unwrap())
}

fn with_report(gp: Gp) -> (Gp, LearnReport) {
    let report = gp.report().unwrap().clone();
    (gp, report)
}

fn parameters(gp: &Gp) -> Vec<f64> {
    gp.kernel().parameters().iter().map(|parameter| parameter.value).collect()
}

#[test]
fn parameters_of_a_drawn_function_are_recovered() {
    let x = uniform(300, 2, 1);
    let truth = SquaredExponential::new(&[0.3, 0.8], 4.0).unwrap();
    let drawn = JointGaussian::prior(&truth, x.as_ref()).unwrap().sample(1, 2).unwrap();
    let y = noisy((0..300).map(|i| 10.0 + drawn[(i, 0)]).collect(), 0.1, 3);
    let (gp, report) = learn(x.as_ref(), &y);
    let learnt = parameters(&gp);
    assert!((learnt[0] / 0.3).ln().abs() < 0.2, "{learnt:?}");
    assert!((learnt[1] / 0.8).ln().abs() < 0.2, "{learnt:?}");
    assert!((learnt[2] / 4.0).ln().abs() < 1.0, "{learnt:?}");
    assert!((gp.noise_variance() / 0.01).ln().abs() < 0.25);
    assert!(report.at_bound.is_empty());
    let exact = Gp::builder(truth).noise_variance(0.01).condition(x.as_ref(), &y).unwrap();
    assert!(gp.log_marginal_likelihood() > exact.log_marginal_likelihood());
}

#[test]
fn a_converged_start_is_a_stationary_point_of_the_likelihood() {
    let x = uniform(60, 1, 4);
    let y = noisy(by_row(&x, |x| (3.0 * x(0)).sin()), 0.1, 5);
    let (gp, report) = learn(x.as_ref(), &y);
    let best = &report.best;
    assert!(best.stop.converged() && best.gradient_norm <= 1e-3);
    let gradient = gp.log_marginal_likelihood_gradient().unwrap();
    assert!(gradient.iter().all(|slope| slope.abs() <= 1.1e-3), "{gradient:?}");
    assert!((best.log_marginal_likelihood - gp.log_marginal_likelihood()).abs() < 1e-9);
    assert_eq!(report.starts.len(), LearnOptions::default().n_starts);
    let converged = report.starts.iter().flatten().filter(|start| start.stop.converged());
    let most_likely = converged.map(|start| start.log_marginal_likelihood);
    assert_eq!(most_likely.fold(f64::NEG_INFINITY, f64::max), best.log_marginal_likelihood);
}

#[test]
fn other_units_change_nothing_but_the_units() {
    let x = uniform(50, 2, 6);
    let y = noisy(by_row(&x, |x| (2.0 * x(0)).sin() * x(1)), 0.05, 7);
    let (x_unit, x_origin, y_unit, y_origin) = ([1e3, 1e-4], [5e3, -0.2], 1e-5, 0.3);
    let scaled_x = Mat::from_fn(50, 2, |i, d| x_origin[d] + x_unit[d] * x[(i, d)]);
    let scaled_y: Vec<f64> = y.iter().map(|y| y_origin + y_unit * y).collect();
    let (gp, _) = learn(x.as_ref(), &y);
    let (scaled, _) = learn(scaled_x.as_ref(), &scaled_y);
    // The optimum is known to the square root of rounding in the likelihood.
    let close = |actual: f64, expected: f64| (actual / expected - 1.0).abs() < 1e-4;
    let (learnt, expected) = (parameters(&scaled), parameters(&gp));
    assert!(close(learnt[0], 1e3 * expected[0]), "{learnt:?} {expected:?}");
    assert!(close(learnt[1], 1e-4 * expected[1]), "{learnt:?} {expected:?}");
    assert!(close(learnt[2], 1e-10 * expected[2]), "{learnt:?} {expected:?}");
    assert!(close(scaled.noise_variance(), 1e-10 * gp.noise_variance()));
    // One of fifty numbers tells the mean.
    let jacobian = 49.0 * y_unit.ln();
    let shifted = gp.log_marginal_likelihood() - jacobian;
    assert!((scaled.log_marginal_likelihood() - shifted).abs() < 1e-6);
    let mean = gp.predict_mean(x.as_ref()).unwrap();
    for (scaled, mean) in scaled.predict_mean(scaled_x.as_ref()).unwrap().iter().zip(mean) {
        assert!(((scaled - y_origin) / y_unit - mean).abs() < 1e-5);
    }
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let x = uniform(80, 2, 8);
    let y = noisy(by_row(&x, |x| x(0) * x(1)), 0.1, 9);
    let with_threads = |n: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        pool.install(|| {
            let (gp, report) = learn(x.as_ref(), &y);
            (serde_json::to_string(&gp.to_model().unwrap()).unwrap(), report)
        })
    };
    assert_eq!(with_threads(1), with_threads(3));
}

#[test]
fn a_function_of_three_in_thirty_two_inputs_is_found() {
    let x = uniform(200, 32, 10);
    let surface = |x: &dyn Fn(usize) -> f64| (2.0 * x(0)).sin() + x(5) * x(5) - 0.5 * x(31);
    let y = noisy(by_row(&x, surface), 0.05, 11);
    let (gp, report) = learn(x.as_ref(), &y);
    let x_test = uniform(200, 32, 12);
    let truth = by_row(&x_test, surface);
    let nmse = scores::nmse(&truth, &gp.predict_mean(x_test.as_ref()).unwrap()).unwrap();
    assert!(nmse < 0.02, "{nmse}");
    let learnt = parameters(&gp);
    let relevant = [0, 5, 31].map(|d| learnt[d]).into_iter().fold(0.0, f64::max);
    let irrelevant = (0..32).filter(|d| ![0, 5, 31].contains(d)).map(|d| learnt[d]);
    assert!(irrelevant.fold(f64::INFINITY, f64::min) > relevant, "{learnt:?}");
    assert!(report.best.stop.converged());
}

#[test]
fn outputs_without_noise_stop_at_the_noise_wall() {
    let x = Mat::from_fn(25, 1, |i, _| i as f64 / 24.0);
    let y = by_row(&x, |x| (6.0 * x(0)).sin());
    let (gp, report) = learn(x.as_ref(), &y);
    assert_eq!(report.at_bound, ["noise_variance"]);
    let mean = gp.predict_mean(x.as_ref()).unwrap();
    assert!(scores::rmse(&y, &mean).unwrap() < 1e-4);
}

#[test]
fn an_input_that_never_varies_is_harmless() {
    let x = uniform(40, 2, 13);
    let x = Mat::from_fn(40, 2, |i, d| if d == 0 { x[(i, 0)] } else { 3.0 });
    let y = noisy(by_row(&x, |x| x(0).sin()), 0.02, 14);
    let (gp, _) = learn(x.as_ref(), &y);
    let (only, _) = learn(x.subcols(0, 1), &y);
    assert!((gp.log_marginal_likelihood() - only.log_marginal_likelihood()).abs() < 1e-6);
}

#[test]
fn collinear_and_repeated_inputs_are_learnt() {
    let base = uniform(30, 1, 15);
    let x = Mat::from_fn(60, 2, |i, d| base[(i % 30, 0)] * [1.0, -2.0][d]);
    let y = noisy(by_row(&x, |x| (3.0 * x(0)).cos()), 0.1, 16);
    let (gp, _) = learn(x.as_ref(), &y);
    assert!((gp.noise_variance().sqrt() / 0.1).ln().abs() < 0.4);
}

#[test]
fn periodic_products_and_matern_kernels_are_learnt_too() {
    let x = Mat::from_fn(80, 1, |i, _| 0.1 * i as f64);
    let y = noisy(by_row(&x, |x| (4.0 * x(0)).sin()), 0.1, 17);
    let slow = SquaredExponential::unit(1).unwrap();
    let kernel = slow * Periodic::new(1.4, 1.0);
    let gp = Gp::builder(kernel).fit(x.as_ref(), &y).unwrap();
    let period = parameters(&gp)[2];
    assert!((period - std::f64::consts::FRAC_PI_2).abs() < 0.02, "{period}");
    let options = LearnOptions { mean: Mean::Fixed(0.0), ..LearnOptions::default() };
    let gp = Gp::builder(Matern52::unit(1).unwrap())
        .options(options.clone())
        .fit(x.as_ref(), &y)
        .unwrap();
    assert_eq!(gp.mean(), 0.0);
    assert!((gp.noise_variance().sqrt() / 0.1).ln().abs() < 0.4);
}

#[test]
fn too_few_iterations_are_an_error() {
    let x = uniform(30, 1, 18);
    let y = noisy(by_row(&x, |x| x(0)), 0.1, 19);
    let options = LearnOptions { max_iterations: 1, n_starts: 2, ..LearnOptions::default() };
    let kernel = SquaredExponential::unit(1).unwrap();
    let result = Gp::builder(kernel).options(options.clone()).fit(x.as_ref(), &y);
    assert!(
        matches!(result, Err(GpError::NotConverged { n_starts: 2, iterations: 1, .. })),
        "{result:?}"
    );
}

/// The first `n` rows of pure noise over two inputs.
fn noise_alone(n: usize) -> (Mat<f64>, Vec<f64>) {
    (uniform(n, 2, 11), noisy(vec![0.0; n], 1.0, 12))
}

fn learn_with(prior: HyperPrior, x: &Mat<f64>, y: &[f64]) -> (Gp, LearnReport) {
    let kernel = SquaredExponential::unit(2).unwrap();
    let options = LearnOptions { prior, mean: Mean::Fixed(0.0), ..LearnOptions::default() };
    with_report(Gp::builder(kernel).options(options).fit(x, y).unwrap())
}

fn log_normal(sd: f64) -> HyperPrior {
    HyperPrior::LogNormal { lengthscale_sd: sd, scale_sd: 2.0 * sd }
}

/// Where a prior is centered: the usual start, with noise that makes half of the outputs' variance.
fn medians(report: &LearnReport, y: &[f64]) -> Vec<f64> {
    let mean = y.iter().sum::<f64>() / y.len() as f64;
    let variance = y.iter().map(|y| (y - mean).powi(2)).sum::<f64>() / y.len() as f64;
    let mut medians = report.starts[0].as_ref().unwrap().start.clone();
    *medians.last_mut().unwrap() = 0.5 * variance;
    medians
}

#[test]
fn a_prior_weaker_than_anything_changes_nothing_and_a_strong_one_wins() {
    let (x, y) = noise_alone(30);
    let flat = learn_with(HyperPrior::Flat, &x, &y).1.best;
    let weak = learn_with(log_normal(1e6), &x, &y).1.best;
    for (flat, weak) in flat.parameters.iter().zip(&weak.parameters) {
        assert!((flat / weak - 1.0).abs() < 1e-6, "{flat} {weak}");
    }
    let strong = learn_with(log_normal(1e-4), &x, &y).1;
    for start in strong.starts.iter().flatten() {
        for (median, end) in medians(&strong, &y).iter().zip(&start.parameters) {
            assert!((end / median - 1.0).abs() < 1e-3, "{median} {end}");
        }
    }
}

#[test]
fn under_a_prior_the_slope_of_the_likelihood_is_that_of_the_prior() {
    let (x, y) = noise_alone(30);
    let (gp, report) = learn_with(log_normal(0.5), &x, &y);
    let slope = gp.log_marginal_likelihood_gradient().unwrap();
    let median = medians(&report, &y);
    // A variance is a square: its logarithm has twice the standard deviation.
    for (i, sd) in [0.5, 0.5, 2.0, 2.0].into_iter().enumerate() {
        let expected = (report.best.parameters[i] / median[i]).ln() / (sd * sd);
        assert!((slope[i] - expected).abs() < 2e-3, "{i}: {} {expected}", slope[i]);
    }
    let difference = report.best.log_marginal_likelihood - gp.log_marginal_likelihood();
    assert!(difference.abs() < 1e-9, "the prior is no part of what is reported");
}

/// What the prior is for: twelve rows of noise look like a function to some likelihood maximum.
#[test]
fn a_weak_prior_keeps_few_noisy_rows_from_being_explained_away() {
    let noise_of = |prior: HyperPrior| -> Vec<f64> {
        let sd = |seed: u64| {
            let (x, y) = (uniform(12, 2, seed), noisy(vec![0.0; 12], 1.0, seed + 100));
            learn_with(prior, &x, &y).0.noise_variance().sqrt()
        };
        (0..10).map(sd).collect()
    };
    let vanished = |sds: &[f64]| sds.iter().filter(|sd| **sd < 0.1).count();
    let (flat, weak) = (noise_of(HyperPrior::Flat), noise_of(log_normal(0.5)));
    assert!(vanished(&flat) >= 2, "{flat:?}");
    assert_eq!(vanished(&weak), 0, "{weak:?}");
}
