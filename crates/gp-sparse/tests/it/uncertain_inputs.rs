//! The moments of a sparse process at inputs that are Gaussian themselves.

use faer::{Mat, MatRef};
use gp_core::{Expansion, GaussianInput, Gp, GpError, Matern32, Posterior, SquaredExponential};
use gp_sparse::{Approximation, SparseGp, SparseSettings};

const N: usize = 40;

fn data() -> (Mat<f64>, Vec<f64>) {
    let x = Mat::from_fn(N, 2, |i, k| 2.0 * (((3 + 4 * k) * i) as f64).sin());
    let y = (0..N).map(|i| x[(i, 0)].sin() + 0.3 * x[(i, 1)] * x[(i, 0)]).collect();
    (x, y)
}

fn kernel() -> SquaredExponential {
    SquaredExponential::new(&[0.9, 1.3], 1.7).unwrap()
}

fn sparse(n_pseudo_inputs: usize, approximation: Approximation) -> SparseGp {
    let (x, y) = data();
    let settings = SparseSettings { approximation, ..SparseSettings::default() };
    let z = x.subrows(0, n_pseudo_inputs);
    SparseGp::fit(kernel(), x.as_ref(), &y, z, 0.05, settings).unwrap()
}

fn input(scale: f64) -> GaussianInput {
    let covariance = Mat::from_fn(2, 2, |i, j| scale * [[0.3, 0.1], [0.1, 0.2]][i][j]);
    GaussianInput::new(vec![0.4, -0.3], covariance).unwrap()
}

#[test]
fn a_known_input_gets_the_prediction_of_every_approximation() {
    let known = MatRef::from_row_major_slice(&[0.4, -0.3], 1, 2);
    for approximation in [Approximation::Fitc, Approximation::Vfe, Approximation::Dtc] {
        let process = sparse(12, approximation);
        let (mean, variance) = process.predict(known).unwrap();
        let moments = Expansion::at(&[&process.expansion().unwrap()], &input(0.0)).unwrap();
        assert!((moments.mean[0] - mean[0]).abs() < 1e-12);
        assert!((moments.covariance[(0, 0)] - variance[0]).abs() < 1e-12);
    }
}

#[test]
fn moments_are_the_integrals_over_the_input() {
    // The trapezoidal rule along both axes of a root of the covariance.
    let process = sparse(12, Approximation::Fitc);
    let root = [[0.3_f64.sqrt(), 0.0], [0.1 / 0.3_f64.sqrt(), (0.2 - 0.1 * 0.1 / 0.3_f64).sqrt()]];
    let n = 91_usize;
    let z = |index: usize| [index / n, index % n].map(|k| (k as f64 - 45.0) * 0.2);
    let weight = |index: usize| {
        let [a, b] = z(index);
        0.04 / std::f64::consts::TAU * (-0.5 * (a * a + b * b)).exp()
    };
    let x = Mat::from_fn(n * n, 2, |i, k| {
        let [a, b] = z(i);
        [0.4, -0.3][k] + root[k][0] * a + root[k][1] * b
    });
    let (mean, variance) = process.predict(x.as_ref()).unwrap();
    let over = |f: &dyn Fn(usize) -> f64| (0..n * n).map(|i| weight(i) * f(i)).sum::<f64>();
    let expected = over(&|i| mean[i]);
    let spread = over(&|i| variance[i] + (mean[i] - expected).powi(2));
    let moments = Expansion::at(&[&process.expansion().unwrap()], &input(1.0)).unwrap();
    assert!((moments.mean[0] - expected).abs() < 1e-11, "{moments:?} {expected}");
    assert!((moments.covariance[(0, 0)] - spread).abs() < 1e-11, "{moments:?} {spread}");
}

#[test]
fn pseudo_inputs_at_all_inputs_say_what_the_exact_process_says() {
    let (x, y) = data();
    let exact = Gp::builder(kernel()).noise_variance(0.05).condition(x.as_ref(), &y).unwrap();
    let exact = Expansion::at(&[&exact.expansion().unwrap()], &input(1.0)).unwrap();
    let process = sparse(N, Approximation::Fitc).expansion().unwrap();
    let moments = Expansion::at(&[&process], &input(1.0)).unwrap();
    // The jitter is 1e-8 of the prior variance.
    assert!((moments.mean[0] - exact.mean[0]).abs() < 1e-5, "{moments:?} {exact:?}");
    assert!((&moments.covariance - &exact.covariance).norm_max() < 1e-5, "{moments:?} {exact:?}");
}

#[test]
fn other_kernels_are_refused() {
    let (x, y) = data();
    let kernel = Matern32::new(&[0.9, 1.3], 1.7).unwrap();
    let settings = SparseSettings::default();
    let process = SparseGp::fit(kernel, x.as_ref(), &y, x.subrows(0, 9), 0.05, settings).unwrap();
    assert!(matches!(process.expansion(), Err(GpError::NoClosedForm { .. })));
}
