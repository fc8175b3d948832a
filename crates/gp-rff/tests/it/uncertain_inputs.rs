//! The moments of random features at inputs that are Gaussian themselves.

use faer::{Mat, MatRef};
use gp_core::{Expansion, GaussianInput, Posterior};
use gp_rff::{FeatureOptions, Form, RandomFeatures, RffGp, Spectrum};

fn process(form: Form, spectrum: Spectrum, shift: f64) -> RffGp {
    let x = Mat::from_fn(40, 2, |i, k| 2.0 * (((3 + 4 * k) * i) as f64).sin());
    let y: Vec<f64> = (0..40).map(|i| (x[(i, 0)] + shift).sin() + 0.3 * x[(i, 1)]).collect();
    let options = FeatureOptions { n_features: 30, form, ..FeatureOptions::default() };
    let features = RandomFeatures::new(spectrum, &[0.9, 1.3], options).unwrap();
    RffGp::fit(features, x.as_ref(), &y, 1.7, 0.05).unwrap()
}

fn input(scale: f64) -> GaussianInput {
    let covariance = Mat::from_fn(2, 2, |i, j| scale * [[0.3, 0.1], [0.1, 0.2]][i][j]);
    GaussianInput::new(vec![0.4, -0.3], covariance).unwrap()
}

#[test]
fn a_known_input_gets_the_prediction() {
    let known = MatRef::from_row_major_slice(&[0.4, -0.3], 1, 2);
    for form in [Form::Cosines, Form::Paired] {
        let process = process(form, Spectrum::SquaredExponential, 0.0);
        let (mean, variance) = process.predict(known).unwrap();
        let moments = Expansion::at(&[&process.expansion().unwrap()], &input(0.0)).unwrap();
        assert!((moments.mean[0] - mean[0]).abs() < 1e-12);
        assert!((moments.covariance[(0, 0)] - variance[0]).abs() < 1e-12);
    }
}

#[test]
fn moments_are_the_integrals_over_the_input_whatever_the_kernel() {
    // The trapezoidal rule along both axes of a root of the covariance.
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
    let over = |f: &dyn Fn(usize) -> f64| (0..n * n).map(|i| weight(i) * f(i)).sum::<f64>();
    for (form, spectrum) in [
        (Form::Cosines, Spectrum::SquaredExponential),
        (Form::Paired, Spectrum::SquaredExponential),
        (Form::Paired, Spectrum::Matern32),
    ] {
        let processes = [0.0, 1.0].map(|shift| process(form, spectrum, shift));
        let said = processes.each_ref().map(|one| one.predict(x.as_ref()).unwrap());
        let mean = said.each_ref().map(|(mean, _)| over(&|i| mean[i]));
        let off = |a: usize, i: usize| said[a].0[i] - mean[a];
        let [a, b] = processes.each_ref().map(|one| one.expansion().unwrap());
        let moments = Expansion::at(&[&a, &b], &input(1.0)).unwrap();
        let with_input = input(1.0).covariance() * &moments.slopes;
        for k in 0..2 {
            assert!((moments.mean[k] - mean[k]).abs() < 1e-11);
            let own = over(&|i| said[k].1[i] + off(k, i).powi(2));
            assert!((moments.covariance[(k, k)] - own).abs() < 1e-11);
            for d in 0..2 {
                let with = over(&|i| (x[(i, d)] - [0.4, -0.3][d]) * off(k, i));
                assert!((with_input[(d, k)] - with).abs() < 1e-11);
            }
        }
        let both = over(&|i| off(0, i) * off(1, i));
        assert!((moments.covariance[(1, 0)] - both).abs() < 1e-11, "{moments:?} {both}");
        assert!(both.abs() > 1e-2);
    }
}

#[test]
fn an_input_that_may_be_anywhere_leaves_the_constant_and_no_infinity() {
    let process = process(Form::Paired, Spectrum::SquaredExponential, 0.0);
    let moments = Expansion::at(&[&process.expansion().unwrap()], &input(1e9)).unwrap();
    assert!((moments.mean[0] - process.mean()).abs() < 1e-9, "{moments:?}");
    assert!(moments.covariance[(0, 0)].is_finite() && moments.covariance[(0, 0)] > 0.1);
}
