//! Learning hyperparameters, on data whose truth is known.

use faer::Mat;
use gp_core::scores::nlpd;
use gp_core::{Gp, GpError, Kernel, Matern12, Posterior, RationalQuadratic, SquaredExponential};
use gp_rff::{
    FeatureOptions, Form, Hyperparameters, RandomFeatures, RffGp, RffOptions, Sampling, Spectrum,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

const NOISE_SD: f64 = 0.1;

/// sin(3a) + b² on [−1, 1]² with noise.
fn data(n: usize, seed: u64) -> (Mat<f64>, Vec<f64>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let x: Mat<f64> = Mat::from_fn(n, 2, |_, _| rng.random_range(-1.0..1.0));
    let mut noise = || NOISE_SD * rng.sample::<f64, _>(StandardNormal);
    let y = (0..n).map(|i| (3.0 * x[(i, 0)]).sin() + x[(i, 1)].powi(2) + noise()).collect();
    (x, y)
}

fn density(gp: &dyn Posterior) -> f64 {
    let (x, y) = data(1000, 2);
    let (mean, variance) = gp.predict_observation(x.as_ref()).unwrap();
    nlpd(&y, &mean, &variance).unwrap()
}

fn options(form: Form, sampling: Sampling, hyperparameters: Hyperparameters) -> RffOptions {
    let features = FeatureOptions { n_features: 200, form, sampling, seed: 1 };
    RffOptions { features, hyperparameters, small_gp_rows: 300, ..RffOptions::default() }
}

#[test]
fn two_hundred_features_of_any_kind_are_as_good_as_the_exact_process() {
    let (x, y) = data(500, 1);
    let kernel = SquaredExponential::unit(2).unwrap();
    let exact = Gp::builder(kernel).fit(x.as_ref(), &y).unwrap();
    for form in [Form::Cosines, Form::Paired] {
        for sampling in [Sampling::Independent, Sampling::Orthogonal, Sampling::LowDiscrepancy] {
            // What suits the exact kernel suits its features less well.
            let limits = [(Hyperparameters::SmallGp, 0.1), (Hyperparameters::OwnLikelihood, 0.03)];
            for (from, most) in limits {
                let (gp, _) = RffGp::learn(x.as_ref(), &y, &options(form, sampling, from)).unwrap();
                let loss = density(&gp) - density(&exact);
                assert!(loss < most, "{form:?} {sampling:?} {from:?}: {loss}");
            }
        }
    }
}

#[test]
fn the_own_likelihood_is_maximal_where_it_stops() {
    let (x, y) = data(300, 1);
    let options = options(Form::Paired, Sampling::LowDiscrepancy, Hyperparameters::OwnLikelihood);
    let (gp, report) = RffGp::learn(x.as_ref(), &y, &options).unwrap();
    assert!(report.stop.is_some_and(|stop| stop.converged()) && report.at_bound.is_empty());
    let gradient = gp.log_evidence_gradient(x.as_ref(), &y).unwrap();
    assert!(gradient.iter().all(|slope| slope.abs() < 0.02), "{gradient:?}");
    assert!((gp.noise_variance().sqrt() / NOISE_SD - 1.0).abs() < 0.1);
    let small = RffOptions { hyperparameters: Hyperparameters::SmallGp, ..options };
    let (small, _) = RffGp::learn(x.as_ref(), &y, &small).unwrap();
    assert!(gp.log_evidence() > small.log_evidence());
}

#[test]
fn the_same_seed_learns_the_same_bits_on_any_number_of_threads() {
    let (x, y) = data(600, 1);
    let options = options(Form::Cosines, Sampling::Independent, Hyperparameters::OwnLikelihood);
    let run = |n: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        pool.install(|| RffGp::learn(x.as_ref(), &y, &options).unwrap())
    };
    let ((one, one_report), (three, three_report)) = (run(1), run(3));
    assert_eq!(one.to_model(), three.to_model());
    assert_eq!(one_report, three_report);
}

#[test]
fn a_few_learnt_frequencies_follow_tones_that_drawn_ones_miss() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let x: Mat<f64> = Mat::from_fn(300, 1, |_, _| rng.random_range(-3.0..3.0));
    let tones = |x: f64| (3.0 * x).sin() + 0.5 * (7.3 * x + 1.0).cos();
    let y: Vec<f64> = (0..300)
        .map(|i| tones(x[(i, 0)]) + NOISE_SD * rng.sample::<f64, _>(StandardNormal))
        .collect();
    let learn = |hyperparameters| {
        let features = FeatureOptions { n_features: 16, seed: 1, ..FeatureOptions::default() };
        let options = RffOptions { features, hyperparameters, ..RffOptions::default() };
        RffGp::learn(x.as_ref(), &y, &options).unwrap()
    };
    let error = |gp: &RffGp| {
        let at = Mat::from_fn(200, 1, |i, _| 0.028 * i as f64 - 2.8);
        let mean = gp.predict_mean(at.as_ref()).unwrap();
        let squares = (0..200).map(|i| (mean[i] - tones(at[(i, 0)])).powi(2)).sum::<f64>();
        (squares / 200.0).sqrt()
    };
    let (drawn, _) = learn(Hyperparameters::OwnLikelihood);
    let (learnt, report) = learn(Hyperparameters::Frequencies);
    assert!(report.stop.unwrap().converged() && learnt.log_evidence() > drawn.log_evidence());
    assert!(error(&learnt) < 0.5 * error(&drawn), "{} {}", error(&learnt), error(&drawn));
    assert!((learnt.noise_variance() / NOISE_SD.powi(2) - 1.0).abs() < 0.3);
    let read: RffGp = serde_json::from_str(&serde_json::to_string(&learnt).unwrap()).unwrap();
    assert_eq!(error(&read), error(&learnt));
}

#[test]
fn frequencies_of_any_spectrum_make_its_kernel() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let n = 20_000;
    let options = FeatureOptions { n_features: 2 * n, ..FeatureOptions::default() };
    let drawn = RandomFeatures::new(Spectrum::SquaredExponential, &[0.7, 1.3], options).unwrap();
    // A rational quadratic of α = 1 is a squared exponential of a precision that is drawn from Exp(1).
    let scale: Vec<f64> = (0..n).map(|_| (-rng.random::<f64>().ln()).sqrt()).collect();
    let normal = Mat::from_fn(n, 2, |_, _| rng.sample::<f64, _>(StandardNormal));
    let frequencies = Mat::from_fn(n, 2, |j, d| normal[(j, d)] * scale[j]);
    let own = drawn.with_frequencies(frequencies.as_ref()).unwrap();
    assert_eq!(own.frequencies()[(7, 1)], frequencies[(7, 1)]);
    let expected = RationalQuadratic::ard(&[0.7, 1.3], 1.0);
    let x = Mat::from_fn(4, 2, |i, d| 0.6 * (i * (d + 1)) as f64);
    let check = |features: &RandomFeatures, kernel: &dyn Kernel| {
        let phi = features.evaluate(x.as_ref()).unwrap();
        for i in 0..4 {
            let found: f64 = (0..2 * n).map(|j| phi[(0, j)] * phi[(i, j)]).sum();
            let [a, b] = [0, i].map(|i| [x[(i, 0)], x[(i, 1)]]);
            assert!((found - kernel.value(&a, &b)).abs() < 0.02, "{i} {found}");
        }
    };
    check(&own, &expected);
    let rough = RandomFeatures::new(Spectrum::Matern12, &[0.7, 1.3], options).unwrap();
    check(&rough, &Matern12::new(&[0.7, 1.3], 1.0).unwrap());
    let (x, y) = data(200, 1);
    let few = FeatureOptions { n_features: 40, ..options };
    let few = RandomFeatures::new(Spectrum::Matern32, &[1.0, 1.0], few).unwrap();
    let options = RffOptions { small_gp_rows: 100, ..RffOptions::default() };
    let (gp, _) = RffGp::learn_with(few.clone(), x.as_ref(), &y, &options).unwrap();
    assert_eq!(gp.features().frequencies(), few.frequencies());
    assert!(density(&gp) < -0.7, "{}", density(&gp));
    let short = few.with_frequencies(frequencies.as_ref()).unwrap_err();
    assert!(
        matches!(short, GpError::ShapeMismatch { expected: 20, actual: 20_000, .. }),
        "{short}"
    );
}
