//! How the error falls with the number of features, for each way to choose them:
//! `cargo run --release -p pushlab-gp-rff --example error_by_features`.

use std::error::Error;

use faer::Mat;
use gp_core::scores::rmse;
use gp_core::{Gp, Posterior, SquaredExponential};
use gp_rff::{FeatureOptions, Form, RandomFeatures, RffGp, Sampling, Spectrum};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

const LENGTHSCALES: [f64; 2] = [0.5, 0.7];
const SIGNAL_VARIANCE: f64 = 0.07;
const NOISE_VARIANCE: f64 = 4e-4;
const N_SEEDS: u64 = 10;

fn main() -> Result<(), Box<dyn Error>> {
    let (x, y, _) = surface(1000, 7);
    let (x_test, _, truth) = surface(1000, 8);
    let kernel = SquaredExponential::new(&LENGTHSCALES, SIGNAL_VARIANCE)?;
    let exact = Gp::builder(kernel).noise_variance(NOISE_VARIANCE).condition(x.as_ref(), &y)?;
    let floor = rmse(&truth, &exact.predict_mean(x_test.as_ref())?)?;
    println!("RMSE of the noiseless surface, mean of {N_SEEDS} draws; exact process {floor:.5}");
    println!("form     sampling            M = 26        50       100       200       400");
    for form in [Form::Cosines, Form::Paired] {
        for sampling in [Sampling::Independent, Sampling::Orthogonal, Sampling::LowDiscrepancy] {
            print!("{:8} {:16}", format!("{form:?}"), format!("{sampling:?}"));
            for n_features in [26, 50, 100, 200, 400] {
                let mut total = 0.0;
                for seed in 0..N_SEEDS {
                    let options = FeatureOptions { n_features, form, sampling, seed };
                    let features =
                        RandomFeatures::new(Spectrum::default(), &LENGTHSCALES, options)?;
                    let gp = RffGp::fit(features, x.as_ref(), &y, SIGNAL_VARIANCE, NOISE_VARIANCE)?;
                    total += rmse(&truth, &gp.predict_mean(x_test.as_ref())?)?;
                }
                print!(" {:9.5}", total / N_SEEDS as f64);
            }
            println!();
        }
    }
    Ok(())
}

/// Points in [−1, 1]², observations of a surface like the turn of a pushed slider, and the surface.
fn surface(n: usize, seed: u64) -> (Mat<f64>, Vec<f64>, Vec<f64>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let x: Mat<f64> = Mat::from_fn(n, 2, |_, _| rng.random_range(-1.0..1.0));
    let value = |i: usize| {
        let (p, beta) = (x[(i, 0)], x[(i, 1)]);
        let arm: f64 = p * beta.cos() - 0.4 * beta.sin();
        let bend = 0.1 * p * (3.0 * beta).sin() + 0.03 * (4.0 * p - beta).cos();
        0.6 * (2.2 * arm).tanh() * (1.0 - 0.25 * p * p) + bend
    };
    let truth: Vec<f64> = (0..n).map(value).collect();
    let noise_sd = NOISE_VARIANCE.sqrt();
    let y = truth.iter().map(|f| f + noise_sd * rng.sample::<f64, _>(StandardNormal)).collect();
    (x, y, truth)
}
