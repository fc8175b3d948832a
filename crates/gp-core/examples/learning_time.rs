//! Times `GpBuilder::fit` on a smooth surface of two inputs with noise:
//! `cargo run --release -p pushlab-gp-core --example learning_time`.

use std::error::Error;
use std::time::Instant;

use faer::Mat;
use gp_core::{Gp, SquaredExponential};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

fn main() -> Result<(), Box<dyn Error>> {
    println!(
        "rows  seconds  evaluations  log likelihood  noise sd  lengthscales and signal variance"
    );
    for n in [100, 200, 500] {
        let (x, y) = surface(n, 7);
        let begin = Instant::now();
        let kernel = SquaredExponential::unit(2)?;
        let gp = Gp::builder(kernel).fit(&x, &y)?;
        let seconds = begin.elapsed().as_secs_f64();
        let evaluations: Vec<usize> = gp
            .report()
            .into_iter()
            .flat_map(|report| &report.starts)
            .flatten()
            .map(|start| start.evaluations)
            .collect();
        println!(
            "{n:4} {seconds:8.3}  {evaluations:?}  {:.4}  {:.5}  {:?}",
            gp.log_marginal_likelihood(),
            gp.noise_variance().sqrt(),
            gp.kernel().parameters().iter().map(|parameter| parameter.value).collect::<Vec<_>>(),
        );
        for start in gp.report().into_iter().flat_map(|report| &report.starts) {
            println!("      {start:?}");
        }
    }
    Ok(())
}

/// Points in [−1, 1]² and a surface like the rotation of a pushed slider, with noise of sd 0.02.
fn surface(n: usize, seed: u64) -> (Mat<f64>, Vec<f64>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let x: Mat<f64> = Mat::from_fn(n, 2, |_, _| rng.random_range(-1.0..1.0));
    let y = (0..n).map(|i| {
        let (p, b) = (x[(i, 0)], x[(i, 1)]);
        let arm: f64 = p * b.cos() - 0.4 * b.sin();
        let bend = 0.1 * p * (3.0 * b).sin() + 0.03 * (4.0 * p - b).cos();
        let noise: f64 = rng.sample(StandardNormal);
        0.6 * (2.2 * arm).tanh() * (1.0 - 0.25 * p * p) + bend + 0.02 * noise
    });
    let y = y.collect();
    (x, y)
}
