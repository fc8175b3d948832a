//! Bayesian linear regression against the Gaussian process that it equals.

use faer::Mat;
use gp_core::{BayesianLinear, Gp, GpError, Kernel, Mean, Parameter, Posterior};
use proptest::collection::vec;
use proptest::prelude::{Just, ProptestConfig, Strategy, prop_assert, proptest};

/// k(φ, φ') = φᵀ Σp φ', eq. 3.9 of the thesis; also an example of a user's own kernel.
#[derive(Debug)]
struct FeatureKernel {
    prior_covariance: Mat<f64>,
}

impl Kernel for FeatureKernel {
    fn value(&self, a: &[f64], b: &[f64]) -> f64 {
        let term = |(i, a): (usize, &f64)| {
            b.iter().enumerate().map(|(j, b)| a * self.prior_covariance[(i, j)] * b).sum::<f64>()
        };
        a.iter().enumerate().map(term).sum()
    }

    fn parameters(&self) -> Vec<Parameter> {
        Vec::new()
    }

    fn with_values(&self, _values: &[f64]) -> Box<dyn Kernel> {
        Box::new(Self { prior_covariance: self.prior_covariance.clone() })
    }

    fn parameter_gradient(&self, _a: &[f64], _b: &[f64], _gradient: &mut [f64]) {}

    fn input_gradient(&self, _a: &[f64], b: &[f64], gradient: &mut [f64]) {
        for (i, slope) in gradient.iter_mut().enumerate() {
            *slope = b.iter().enumerate().map(|(j, b)| self.prior_covariance[(i, j)] * b).sum();
        }
    }
}

/// Features N×M, outputs, a positive definite Σp and features to predict at.
fn case() -> impl Strategy<Value = (Mat<f64>, Vec<f64>, Mat<f64>, Mat<f64>)> {
    (1_usize..5, 1_usize..12).prop_flat_map(|(m, n)| {
        let matrix = move |rows: usize| {
            vec(-2.0..2.0, rows * m)
                .prop_map(move |entries| Mat::from_fn(rows, m, |i, j| entries[i * m + j]))
        };
        let covariance = matrix(m).prop_map(|root| {
            let identity = Mat::<f64>::identity(root.nrows(), root.nrows());
            &root * root.transpose() + 0.5 * &identity
        });
        (Just(n), matrix(n), vec(-3.0..3.0, n), covariance, matrix(4))
            .prop_map(|(_, features, y, covariance, x_star)| (features, y, covariance, x_star))
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn it_equals_the_gaussian_process_on_the_feature_kernel(
        (features, y, prior_covariance, x_star) in case()
    ) {
        let noise_variance = 0.3;
        let linear =
            BayesianLinear::fit(features.as_ref(), &y, prior_covariance.as_ref(), noise_variance)
                .unwrap();
        let kernel = FeatureKernel { prior_covariance };
        let mean = Mean::Fixed(0.0);
        let gp = Gp::builder(kernel).noise_variance(noise_variance).mean(mean).condition(features.as_ref(), &y).unwrap();
        let evidence = (linear.log_evidence(), gp.log_marginal_likelihood());
        prop_assert!((evidence.0 - evidence.1).abs() < 1e-9 * (1.0 + evidence.1.abs()));
        let posteriors: [&dyn Posterior; 2] = [&linear, &gp];
        let [a, b] = posteriors.map(|posterior| posterior.predict_observation(x_star.as_ref()).unwrap());
        let [c, d] = posteriors.map(|posterior| posterior.predict_joint(x_star.as_ref()).unwrap());
        for i in 0..4 {
            prop_assert!((a.0[i] - b.0[i]).abs() < 1e-9 * (1.0 + b.0[i].abs()));
            prop_assert!((a.1[i] - b.1[i]).abs() < 1e-9 * (1.0 + b.1[i].abs()));
            for j in 0..4 {
                prop_assert!((c.covariance()[(i, j)] - d.covariance()[(i, j)]).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn weights_solve_the_normal_equations((features, y, prior_covariance, _) in case()) {
        let noise_variance = 0.3;
        let linear =
            BayesianLinear::fit(features.as_ref(), &y, prior_covariance.as_ref(), noise_variance)
                .unwrap();
        // Σp (ΦᵀΦ w − Φᵀy) + σₙ² w = 0 is A w = σₙ⁻² Φᵀy without an inverse.
        let weights = Mat::from_fn(features.ncols(), 1, |i, _| linear.weights()[i]);
        let outputs = Mat::from_fn(y.len(), 1, |i, _| y[i]);
        let misfit = features.transpose() * (&features * &weights - &outputs);
        let residual = &prior_covariance * &misfit + noise_variance * &weights;
        prop_assert!(residual.norm_max() < 1e-8, "{residual:?}");
        // A⁻¹ (ΦᵀΦ Σp + σₙ² I) = σₙ² Σp.
        let precision = features.transpose() * &features * &prior_covariance
            + noise_variance * &Mat::<f64>::identity(weights.nrows(), weights.nrows());
        let residual = linear.weight_covariance() * precision - noise_variance * &prior_covariance;
        prop_assert!(residual.norm_max() < 1e-8, "{residual:?}");
    }
}

#[test]
fn one_observation_halves_the_variance_of_an_equally_uncertain_weight() {
    let one = Mat::from_fn(1, 1, |_, _| 1.0);
    let linear = BayesianLinear::fit(one.as_ref(), &[2.0], one.as_ref(), 1.0).unwrap();
    assert!((linear.weights()[0] - 1.0).abs() < 1e-15);
    assert!((linear.weight_covariance()[(0, 0)] - 0.5).abs() < 1e-15);
    let expected = -0.5 * (4.0 / 2.0 + (2.0 * std::f64::consts::PI * 2.0).ln());
    assert!((linear.log_evidence() - expected).abs() < 1e-14);
}

#[test]
fn a_user_kernel_without_spec_cannot_be_saved() {
    let one = Mat::from_fn(1, 1, |_, _| 1.0);
    let kernel = FeatureKernel { prior_covariance: one.clone() };
    let gp = Gp::builder(kernel).noise_variance(1.0).condition(one.as_ref(), &[2.0]).unwrap();
    assert!(matches!(gp.to_model(), Err(GpError::NotSerializable { .. })));
}
