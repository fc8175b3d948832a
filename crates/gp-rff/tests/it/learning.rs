//! Learning hyperparameters, on data whose truth is known.

use faer::Mat;
use gp_core::scores::nlpd;
use gp_core::{Gp, Posterior, SquaredExponential};
use gp_rff::{FeatureOptions, Form, Hyperparameters, RffGp, RffOptions, Sampling};
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
