//! What each approximation takes for noise, on data whose noise is known:
//! `cargo run --release -p pushlab-gp-sparse --example noise_estimates`.
//!
//! FITC may explain noise by the variance that its pseudo-inputs leave over, and does so the more,
//! the longer pseudo-inputs are free to move; VFE cannot.

use std::error::Error;
use std::time::Instant;

use faer::Mat;
use gp_core::scores::{coverage, nlpd, rmse};
use gp_core::{Posterior, SquaredExponential};
use gp_sparse::{Approximation, Placement, PseudoInputs, SparseGp, SparseOptions, SparseSettings};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

const NOISE_SD: f64 = 0.02;

fn main() -> Result<(), Box<dyn Error>> {
    let (x, y) = surface(2000, 7);
    let (x_test, y_test) = surface(2000, 8);
    println!("the noise has a standard deviation of {NOISE_SD}");
    println!("approximation            M  noise sd      NLPD     RMSE  95 %  iterations  seconds");
    for approximation in
        [Approximation::Fitc, Approximation::PowerEp { alpha: 0.5 }, Approximation::Vfe]
    {
        for count in [10, 20, 50] {
            let options = SparseOptions {
                settings: SparseSettings { approximation, ..SparseSettings::default() },
                pseudo_inputs: PseudoInputs::Learnt { count, placement: Placement::default() },
                ..SparseOptions::default()
            };
            let begin = Instant::now();
            let kernel = SquaredExponential::unit(2)?;
            let (gp, report) = SparseGp::learn(kernel, x.as_ref(), &y, &options)?;
            let seconds = begin.elapsed().as_secs_f64();
            let (mean, variance) = gp.predict_observation(x_test.as_ref())?;
            println!(
                "{:22} {count:3}  {:8.5} {:9.4} {:8.5} {:5.3} {:11} {seconds:8.3}",
                format!("{approximation:?}"),
                gp.noise_variance().sqrt(),
                nlpd(&y_test, &mean, &variance)?,
                rmse(&y_test, &mean)?,
                coverage(&y_test, &mean, &variance, &[0.95])?[0],
                report.best.iterations,
            );
        }
    }
    Ok(())
}

/// Points in [−1, 1]² and a surface like the turn of a pushed slider, with noise.
fn surface(n: usize, seed: u64) -> (Mat<f64>, Vec<f64>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let x: Mat<f64> = Mat::from_fn(n, 2, |_, _| rng.random_range(-1.0..1.0));
    let y = (0..n).map(|i| {
        let (p, beta) = (x[(i, 0)], x[(i, 1)]);
        let arm: f64 = p * beta.cos() - 0.4 * beta.sin();
        let bend = 0.1 * p * (3.0 * beta).sin() + 0.03 * (4.0 * p - beta).cos();
        let noise: f64 = rng.sample(StandardNormal);
        0.6 * (2.2 * arm).tanh() * (1.0 - 0.25 * p * p) + bend + NOISE_SD * noise
    });
    let y = y.collect();
    (x, y)
}
