//! Every error that bad data or parameters can cause.

use faer::Mat;
use gp_core::{
    BayesianLinear, Constant, Gp, GpError, GpModel, HyperPrior, JointGaussian, Kernel,
    LearnOptions, Linear, Matern32, Mean, Periodic, Posterior, RationalQuadratic,
    SquaredExponential, White, gram,
};

fn kernel() -> SquaredExponential {
    SquaredExponential::unit(1).unwrap()
}

fn line(n: usize) -> Mat<f64> {
    Mat::from_fn(n, 1, |i, _| i as f64)
}

fn fit(x: &Mat<f64>, y: &[f64], noise_variance: f64) -> GpError {
    Gp::builder(kernel()).noise_variance(noise_variance).condition(x.as_ref(), y).unwrap_err()
}

fn learn(x: &Mat<f64>, y: &[f64], options: &LearnOptions) -> GpError {
    Gp::builder(kernel()).options(options.clone()).fit(x.as_ref(), y).unwrap_err()
}

#[test]
fn shapes_that_do_not_fit() {
    let expected = GpError::ShapeMismatch { what: "outputs", expected: 3, actual: 2 };
    assert_eq!(fit(&line(3), &[1.0, 2.0], 0.1), expected);
    assert_eq!(learn(&line(3), &[1.0, 2.0], &LearnOptions::default()), expected);
    let expected = GpError::ShapeMismatch { what: "columns of the inputs", expected: 1, actual: 2 };
    assert_eq!(fit(&Mat::zeros(3, 2), &[1.0; 3], 0.1), expected);
    let gp =
        Gp::builder(kernel()).noise_variance(0.1).condition(line(2).as_ref(), &[1.0, 2.0]).unwrap();
    let wide = Mat::zeros(3, 2);
    assert_eq!(gp.predict(wide.as_ref()).unwrap_err(), expected);
    assert_eq!(gp.predict_mean(wide.as_ref()).unwrap_err(), expected);
    assert_eq!(gp.predict_joint(wide.as_ref()).unwrap_err(), expected);
    assert_eq!(gp.predict_noise(wide.as_ref()).unwrap_err(), expected);
    assert_eq!(gp.mean_gradient(wide.as_ref()).unwrap_err(), expected);
    let refused = |kernel: &dyn Kernel| gram(kernel, line(2).as_ref()).unwrap_err();
    let expected = GpError::ShapeMismatch { what: "columns of the inputs", expected: 2, actual: 1 };
    assert_eq!(refused(&(kernel() * Matern32::unit(2).unwrap())), expected);
    assert_eq!(refused(&(Matern32::unit(2).unwrap() + kernel())), expected);
    assert_eq!(refused(&Periodic::ard(&[1.0], &[1.0, 2.0])), expected);
    assert_eq!(refused(&Linear::ard(&[1.0, 2.0])), expected);
    assert_eq!(refused(&Matern32::unit(2).unwrap().active(&[0])), expected);
    let absent = refused(&kernel().active(&[1]));
    assert!(matches!(absent, GpError::OutOfRange { value: 1.0, highest: 0.0, .. }), "{absent}");
    assert!(matches!(
        JointGaussian::new(vec![0.0], Mat::zeros(2, 1)),
        Err(GpError::ShapeMismatch { .. })
    ));
}

#[test]
fn nothing_at_all() {
    assert_eq!(fit(&line(0), &[], 0.1), GpError::Empty { what: "inputs" });
    assert_eq!(learn(&line(0), &[], &LearnOptions::default()), GpError::Empty { what: "inputs" });
    assert!(matches!(SquaredExponential::unit(0), Err(GpError::Empty { .. })));
    for kernel in [
        Box::new(Periodic::ard(&[], &[])) as Box<dyn Kernel>,
        Box::new(SquaredExponential::isotropic(1.0).active(&[])),
    ] {
        let refused = gram(&kernel, line(1).as_ref());
        assert!(matches!(refused, Err(GpError::Empty { .. })), "{refused:?}");
    }
    assert!(matches!(
        JointGaussian::prior(&kernel(), line(0).as_ref()),
        Err(GpError::Empty { .. })
    ));
    assert!(matches!(JointGaussian::new(vec![], Mat::zeros(0, 0)), Err(GpError::Empty { .. })));
}

#[test]
fn values_that_are_no_numbers_are_named_by_row_and_column() {
    let mut x = Mat::from_fn(3, 2, |i, d| (i + d) as f64);
    x[(2, 1)] = f64::INFINITY;
    let expected = GpError::NotFinite { what: "inputs", row: 2, column: 1, value: f64::INFINITY };
    let wide = SquaredExponential::unit(2).unwrap();
    assert_eq!(
        Gp::builder(wide).noise_variance(0.1).condition(x.as_ref(), &[1.0; 3]).unwrap_err(),
        expected
    );
    let error = fit(&line(3), &[1.0, f64::NAN, 2.0], 0.1);
    assert!(matches!(error, GpError::NotFinite { what: "outputs", row: 1, column: 0, .. }));
    assert!(error.to_string().contains("row 1, column 0 is NaN"));
    let mean = Mean::Fixed(f64::NAN);
    let result = Gp::builder(kernel())
        .noise_variance(0.1)
        .mean(mean)
        .condition(line(2).as_ref(), &[1.0, 2.0]);
    assert!(matches!(result, Err(GpError::NotFinite { what: "mean", .. })));
}

#[test]
fn parameters_that_are_not_positive() {
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let refused = |result: Result<(), GpError>| {
            assert!(matches!(result, Err(GpError::NotPositive { .. })), "{result:?}");
        };
        refused(SquaredExponential::new(&[1.0, bad], 1.0).map(|_| ()));
        refused(SquaredExponential::new(&[1.0], bad).map(|_| ()));
        let bad_kernels: [Box<dyn Kernel>; 7] = [
            Box::new(Periodic::new(bad, 1.0)),
            Box::new(Periodic::new(1.0, bad)),
            Box::new(SquaredExponential::isotropic(bad)),
            Box::new(Constant::new(bad) + kernel()),
            Box::new(kernel() * White::new(bad)),
            Box::new(bad * kernel().active(&[0])),
            Box::new(RationalQuadratic::isotropic(1.0, bad)),
        ];
        for kernel in bad_kernels {
            refused(gram(&kernel, line(2).as_ref()).map(|_| ()));
            refused(JointGaussian::prior(&kernel, line(2).as_ref()).map(|_| ()));
            let gp =
                Gp::builder(kernel).noise_variance(0.1).condition(line(2).as_ref(), &[0.0, 1.0]);
            refused(gp.map(|_| ()));
        }
        let one = line(1);
        refused(BayesianLinear::fit(one.as_ref(), &[1.0], one.as_ref(), bad).map(|_| ()));
    }
    assert_eq!(
        fit(&line(2), &[1.0, 2.0], -0.5),
        GpError::Negative { name: "noise variance".to_owned(), value: -0.5 }
    );
    let options = LearnOptions { n_starts: 0, ..LearnOptions::default() };
    assert!(matches!(learn(&line(3), &[1.0, 2.0, 0.0], &options), GpError::NotPositive { .. }));
    for (lengthscale_sd, scale_sd, name) in
        [(0.0, 1.0, "lengthscale_sd of the prior"), (1.0, f64::NAN, "scale_sd of the prior")]
    {
        let prior = HyperPrior::LogNormal { lengthscale_sd, scale_sd };
        let options = LearnOptions { prior, ..LearnOptions::default() };
        let error = learn(&line(3), &[1.0, 2.0, 0.0], &options);
        assert!(matches!(error, GpError::NotPositive { name: named, .. } if named == name));
    }
    let gp =
        Gp::builder(kernel()).noise_variance(0.0).condition(line(2).as_ref(), &[1.0, 2.0]).unwrap();
    assert!(matches!(gp.log_marginal_likelihood_gradient(), Err(GpError::NotPositive { .. })));
}

#[test]
fn data_from_which_nothing_can_be_learnt() {
    assert_eq!(
        learn(&line(1), &[1.0], &LearnOptions::default()),
        GpError::TooFewRows { needed: 2, actual: 1 }
    );
    assert_eq!(
        learn(&line(4), &[0.5; 4], &LearnOptions::default()),
        GpError::ConstantOutputs { value: 0.5, n_rows: 4 }
    );
}

#[test]
fn repeated_rows_without_noise_are_named() {
    let x = Mat::from_fn(4, 1, |i, _| [0.0, 2.0, 1.0, 2.0][i]);
    let expected = GpError::DuplicateRows { first: 1, second: 3 };
    assert_eq!(fit(&x, &[1.0, 2.0, 3.0, 4.0], 0.0), expected);
    assert!(
        Gp::builder(kernel())
            .noise_variance(1e-6)
            .condition(x.as_ref(), &[1.0, 2.0, 3.0, 4.0])
            .is_ok()
    );
}

#[test]
fn a_singular_covariance_is_an_error_with_its_pivot() {
    let x = Mat::from_fn(40, 1, |i, _| 0.01 * i as f64);
    let error = fit(&x, &[1.0; 40], 0.0);
    let GpError::NotPositiveDefinite { size: 40, pivot, .. } = error else {
        panic!("{error}");
    };
    assert!((3..15).contains(&pivot), "{pivot}");
    assert!(error.to_string().contains("raise the noise variance"));
    let indefinite = Mat::from_fn(2, 2, |i, j| if i == j { 1.0 } else { 2.0 });
    let result = JointGaussian::new(vec![0.0; 2], indefinite.clone()).unwrap().sample(1, 0);
    assert!(matches!(result, Err(GpError::NotPositiveDefinite { .. })));
    let result = BayesianLinear::fit(line(2).as_ref(), &[1.0, 2.0], Mat::zeros(1, 1).as_ref(), 1.0);
    assert!(matches!(result, Err(GpError::NotPositiveDefinite { pivot: 0, .. })));
}

#[test]
fn saved_models_that_were_edited() {
    let gp =
        Gp::builder(kernel()).noise_variance(0.1).condition(line(2).as_ref(), &[1.0, 2.0]).unwrap();
    let model = gp.to_model().unwrap();
    let newer = GpModel { version: 2, ..model.clone() };
    assert_eq!(
        Gp::from_model(&newer).unwrap_err(),
        GpError::UnsupportedVersion { found: 2, supported: 1 }
    );
    let ragged = GpModel { inputs: vec![vec![0.0], vec![0.0, 1.0]], ..model.clone() };
    assert!(matches!(Gp::from_model(&ragged), Err(GpError::ShapeMismatch { .. })));
    let empty = GpModel { inputs: vec![], outputs: vec![], ..model };
    assert!(matches!(Gp::from_model(&empty), Err(GpError::Empty { .. })));
    let text = r#"{"kind":"squared_exponential","lengthscales":[1.0],"signal_variance":1.0,"x":1}"#;
    assert!(serde_json::from_str::<gp_core::KernelSpec>(text).is_err());
}
