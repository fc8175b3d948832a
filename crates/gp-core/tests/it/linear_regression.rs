//! Bayesian linear regression against the Gaussian process that it equals.

use faer::Mat;
use gp_core::{
    BayesianLinear, BayesianLinearModel, Gp, GpError, Kernel, LinearStatistics, Mean, Mergeable,
    Parameter, Parts, Posterior,
};
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

/// Statistics of rows in calls of so many.
fn in_batches(features: &Mat<f64>, y: &[f64], n: usize) -> LinearStatistics {
    let mut statistics = LinearStatistics::new(features.ncols()).unwrap();
    for (batch, y) in y.chunks(n).enumerate() {
        statistics.update(features.as_ref().subrows(batch * n, y.len()), y).unwrap();
    }
    statistics
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn sums_over_rows_are_all_that_it_needs_of_the_data(
        (features, y, prior_covariance, x_star) in case(), n in 1_usize..5
    ) {
        let fit = BayesianLinear::fit(features.as_ref(), &y, prior_covariance.as_ref(), 0.1).unwrap();
        let statistics = in_batches(&features, &y, n);
        let sums = BayesianLinear::from_statistics(&statistics, prior_covariance.as_ref(), 0.1).unwrap();
        let (mean, variance) = fit.predict(x_star.as_ref()).unwrap();
        let (other_mean, other_variance) = sums.predict(x_star.as_ref()).unwrap();
        for (a, b) in mean.iter().chain(&variance).zip(other_mean.iter().chain(&other_variance)) {
            prop_assert!((a - b).abs() < 1e-9 * (1.0 + a.abs()), "{a} {b}");
        }
        prop_assert!((fit.log_evidence() - sums.log_evidence()).abs() < 1e-8);
    }
}

#[test]
fn statistics_of_many_rows_are_exact_and_come_back_from_a_file() {
    // Sums of whole numbers are exact, and 5000 rows take several groups and parts.
    let features = Mat::from_fn(5000, 3, |i, j| ((i * (j + 3)) % 11) as f64 - 5.0);
    let y: Vec<f64> = (0..5000).map(|i| (i % 7) as f64).collect();
    let statistics = in_batches(&features, &y, 5000);
    assert_eq!(statistics.n_rows(), 5000);
    assert_eq!(statistics, in_batches(&features, &y, 123));
    let square = features.transpose() * &features;
    assert_eq!(statistics.square(), square);
    let of_y = |j: usize| (0..5000).map(|i| features[(i, j)] * y[i]).sum::<f64>();
    assert_eq!(statistics.of_y(), [of_y(0), of_y(1), of_y(2)]);
    assert_eq!(statistics.y_y(), y.iter().map(|y| y * y).sum::<f64>());
    let text = serde_json::to_string(&statistics).unwrap();
    assert_eq!(serde_json::from_str::<LinearStatistics>(&text).unwrap(), statistics);
    let short = text.replacen("\"n_features\":3", "\"n_features\":4", 1);
    assert!(serde_json::from_str::<LinearStatistics>(&short).is_err());
}

#[test]
fn merged_parts_have_the_same_bits_whatever_came_first() {
    let features = Mat::from_fn(900, 2, |i, j| (1.3 * i as f64 + j as f64).sin());
    let y: Vec<f64> = (0..900).map(|i| (0.7 * i as f64).cos()).collect();
    let part = |k: usize| {
        let mut own = LinearStatistics::new(2).unwrap();
        own.update(features.as_ref().subrows(100 * k, 100), &y[100 * k..100 * (k + 1)]).unwrap();
        own
    };
    let merged = |order: [usize; 9]| {
        let mut parts = Parts::new(9);
        order.iter().for_each(|k| parts.add(*k as u64, part(*k)).unwrap());
        parts.finish().unwrap()
    };
    let statistics = merged([0, 1, 2, 3, 4, 5, 6, 7, 8]);
    assert_eq!(statistics, merged([8, 3, 1, 0, 7, 2, 6, 4, 5]));
    assert_eq!(statistics.n_rows(), 900);
    let other = LinearStatistics::new(3).unwrap();
    let what = "numbers of features of the statistics";
    assert_eq!(part(0).merge(&other), Err(GpError::Incompatible { what }));
    assert_eq!(LinearStatistics::new(0), Err(GpError::Empty { what: "features" }));
}

fn regression() -> (BayesianLinear, Mat<f64>) {
    let features = Mat::from_fn(20, 3, |i, j| (1.3 * (i * (j + 1)) as f64 + 0.2).sin());
    let y: Vec<f64> = (0..20).map(|i| (0.7 * i as f64).cos()).collect();
    let prior = Mat::from_fn(3, 3, |i, j| if i == j { 1.7 } else { 0.3 });
    (BayesianLinear::fit(features.as_ref(), &y, prior.as_ref(), 0.1).unwrap(), features)
}

#[test]
fn a_regression_is_saved_and_read_as_it_was() {
    let (linear, features) = regression();
    let text = serde_json::to_string(&linear).unwrap();
    let read: BayesianLinear = serde_json::from_str(&text).unwrap();
    let at = features.subrows(3, 5);
    assert_eq!(read.predict(at).unwrap(), linear.predict(at).unwrap());
    let [a, b] = [&read, &linear].map(|one| one.predict_joint(at).unwrap());
    assert_eq!(a.covariance(), b.covariance());
    assert_eq!(read.log_evidence(), linear.log_evidence());
    assert_eq!(read.weight_covariance(), linear.weight_covariance());
    assert_eq!(serde_json::to_string(&read).unwrap(), text);
}

#[test]
fn a_damaged_regression_is_an_error_that_says_why() {
    let (linear, _) = regression();
    let model = linear.to_model();
    let refused = |change: &dyn Fn(&mut BayesianLinearModel)| {
        let mut model = model.clone();
        change(&mut model);
        BayesianLinear::from_model(&model).unwrap_err()
    };
    let version = refused(&|model| model.version = 7);
    assert_eq!(version, GpError::UnsupportedVersion { found: 7, supported: 1 });
    assert_eq!(refused(&|model| model.weights.clear()), GpError::Empty { what: "weights" });
    let short = refused(&|model| model.weights.truncate(2));
    assert_eq!(short, GpError::ShapeMismatch { what: "prior factor", expected: 3, actual: 6 });
    let infinite = refused(&|model| model.precision_factor[1] = f64::INFINITY);
    assert!(matches!(infinite, GpError::NotFinite { what: "precision factor", .. }), "{infinite}");
    for zero in [0, 1] {
        let flat = refused(&|model| match zero {
            0 => model.prior_factor[2] = 0.0,
            _ => model.precision_factor[5] = -1.0,
        });
        assert!(matches!(flat, GpError::NotPositive { .. }), "{flat}");
    }
    assert!(matches!(refused(&|m| m.noise_variance = 0.0), GpError::NotPositive { .. }));
    let text = serde_json::to_string(&linear).unwrap();
    let cut = text.replace("\"noise_variance\":0.1", "\"noise_variance\":-0.1");
    let error = serde_json::from_str::<BayesianLinear>(&cut).unwrap_err().to_string();
    assert!(error.contains("noise variance must be positive"), "{error}");
    for end in [1, text.len() / 2, text.len() - 1] {
        assert!(serde_json::from_str::<BayesianLinear>(&text[..end]).is_err());
    }
}
