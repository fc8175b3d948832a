//! A surface that is known, which Gaussian processes are timed on and held against.

use faer::Mat;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// Standard deviation of the noise.
pub const NOISE_SD: f64 = 0.02;

/// Points in [−1, 1]² and a surface shaped like the turn of a pushed slider, with noise.
///
/// x₀ is the contact's place on the edge, x₁ the direction of the push in rad; the lever arm of the
/// push about the center is bounded by the friction limit.
pub fn surface(n: usize, seed: u64) -> (Mat<f64>, Vec<f64>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let x: Mat<f64> = Mat::from_fn(n, 2, |_, _| rng.random_range(-1.0..1.0));
    let y = (0..n).map(|i| {
        let noise: f64 = rng.sample(StandardNormal);
        turn(x[(i, 0)], x[(i, 1)]) + NOISE_SD * noise
    });
    let y = y.collect();
    (x, y)
}

fn turn(p: f64, beta: f64) -> f64 {
    let arm = p * beta.cos() - 0.4 * beta.sin();
    let saturated = 0.6 * (2.2 * arm).tanh() * (1.0 - 0.25 * p * p);
    saturated + 0.1 * p * (3.0 * beta).sin() + 0.03 * (4.0 * p - beta).cos()
}
