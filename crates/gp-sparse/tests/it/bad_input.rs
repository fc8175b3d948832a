//! Every error that bad data or parameters can cause.

use faer::Mat;
use gp_core::{GpError, Mean, Posterior, SquaredExponential};
use gp_sparse::{
    Approximation, Placement, PseudoInputs, SparseGp, SparseGpModel, SparseOptions, SparseSettings,
};

fn kernel() -> SquaredExponential {
    SquaredExponential::unit(1).unwrap()
}

fn line(n: usize) -> Mat<f64> {
    Mat::from_fn(n, 1, |i, _| i as f64)
}

fn waves(n: usize) -> Vec<f64> {
    (0..n).map(|i| (0.7 * i as f64).sin()).collect()
}

fn fit(y: &[f64], z: &Mat<f64>, noise: f64, settings: SparseSettings) -> GpError {
    SparseGp::fit(kernel(), line(5).as_ref(), y, z.as_ref(), noise, settings).unwrap_err()
}

fn learn(n: usize, options: &SparseOptions) -> GpError {
    SparseGp::learn(kernel(), line(n).as_ref(), &waves(n), options).unwrap_err()
}

fn with_count(count: usize) -> SparseOptions {
    let pseudo_inputs = PseudoInputs::Learnt { count, placement: Placement::default() };
    SparseOptions { pseudo_inputs, ..SparseOptions::default() }
}

#[test]
fn arguments_that_do_not_fit_together() {
    let settings = SparseSettings::default();
    let expected = GpError::ShapeMismatch { what: "outputs", expected: 5, actual: 4 };
    assert_eq!(fit(&waves(4), &line(2), 0.1, settings), expected);
    let expected = GpError::ShapeMismatch { what: "columns of the inputs", expected: 1, actual: 2 };
    assert_eq!(fit(&waves(5), &Mat::zeros(2, 2), 0.1, settings), expected);
    let expected = GpError::Empty { what: "pseudo-inputs" };
    assert_eq!(fit(&waves(5), &line(0), 0.1, settings), expected);
    let gp = SparseGp::fit(kernel(), line(5).as_ref(), &waves(5), line(2).as_ref(), 0.1, settings);
    let gp = gp.unwrap();
    assert!(matches!(gp.predict(Mat::zeros(1, 2).as_ref()), Err(GpError::ShapeMismatch { .. })));
    assert!(matches!(gp.predict_noise(line(0).as_ref()), Err(GpError::Empty { .. })));
    let result = gp.objective_and_gradient(line(3).as_ref(), &waves(2));
    assert!(matches!(result, Err(GpError::ShapeMismatch { .. })));
}

#[test]
fn values_that_mean_nothing() {
    let settings = SparseSettings::default();
    let error = fit(&waves(5), &line(2), 0.0, settings);
    assert!(matches!(error, GpError::NotPositive { name, .. } if name == "noise variance"));
    let error = fit(&[0.0, 1.0, f64::NAN, 0.0, 0.0], &line(2), 0.1, settings);
    assert!(matches!(error, GpError::NotFinite { what: "outputs", row: 2, .. }));
    for alpha in [0.0, 1.5, f64::NAN] {
        let approximation = Approximation::PowerEp { alpha };
        let error = fit(&waves(5), &line(2), 0.1, SparseSettings { approximation, ..settings });
        assert!(matches!(error, GpError::OutOfRange { .. }));
        assert!(error.to_string().contains("must lie between 0 and 1"));
    }
    let error = fit(&waves(5), &line(2), 0.1, SparseSettings { jitter: -1.0, ..settings });
    assert_eq!(error, GpError::Negative { name: "jitter".to_owned(), value: -1.0 });
    let mean = Mean::Fixed(f64::INFINITY);
    let error = fit(&waves(5), &line(2), 0.1, SparseSettings { mean, ..settings });
    assert!(matches!(error, GpError::NotFinite { what: "mean", .. }));
}

#[test]
fn pseudo_inputs_at_the_same_place_without_jitter() {
    let settings = SparseSettings { jitter: 0.0, ..SparseSettings::default() };
    let error = fit(&waves(5), &Mat::zeros(2, 1), 0.1, settings);
    let what = "covariance of the pseudo-outputs";
    assert_eq!(error, GpError::NotPositiveDefinite { what, size: 2, pivot: 1 });
}

#[test]
fn data_from_which_nothing_can_be_learnt() {
    assert_eq!(learn(1, &with_count(1)), GpError::TooFewRows { needed: 2, actual: 1 });
    for count in [0, 9] {
        let error = learn(8, &with_count(count));
        assert!(matches!(error, GpError::OutOfRange { value, .. } if value == count as f64));
    }
    let constant = SparseGp::learn(kernel(), line(5).as_ref(), &[1.0; 5], &with_count(2));
    assert_eq!(constant.unwrap_err(), GpError::ConstantOutputs { value: 1.0, n_rows: 5 });
    let options = SparseOptions { max_iterations: 1, ..with_count(6) };
    assert!(matches!(learn(30, &options), GpError::NotConverged { iterations: 1, .. }));
    let options = SparseOptions { progress_tolerance: 0.0, ..with_count(3) };
    assert!(matches!(learn(8, &options), GpError::NotPositive { .. }));
}

#[test]
fn sizes_that_cannot_be_chosen() {
    let choose = |n: usize, counts: &[usize], options: &SparseOptions| {
        let (x, y) = (line(n), waves(n));
        SparseGp::choose_size(kernel(), x.as_ref(), &y, counts, options).unwrap_err()
    };
    let options = SparseOptions::default();
    assert_eq!(choose(20, &[], &options), GpError::Empty { what: "counts" });
    assert_eq!(choose(9, &[2], &options), GpError::TooFewRows { needed: 10, actual: 9 });
    let options = SparseOptions { pseudo_inputs: PseudoInputs::Given(line(2)), ..options };
    assert!(matches!(choose(20, &[3], &options), GpError::ShapeMismatch { .. }));
}

/// Version 1 did not keep what the data leave open of a learnt mean.
#[test]
fn older_models_are_read_where_nothing_is_missing_from_them() {
    let saved = |mean| {
        let settings = SparseSettings { mean, ..SparseSettings::default() };
        let (x, z) = (line(5), line(2));
        let gp = SparseGp::fit(kernel(), x.as_ref(), &waves(5), z.as_ref(), 0.1, settings).unwrap();
        let model =
            SparseGpModel { version: 1, deviation: None, rows: None, ..gp.to_model().unwrap() };
        let text = serde_json::to_string(&model).unwrap();
        assert!(!text.contains("deviation"));
        (gp, SparseGp::from_model(&serde_json::from_str(&text).unwrap()))
    };
    let (gp, loaded) = saved(Mean::Fixed(0.2));
    let at = line(7);
    assert_eq!(loaded.unwrap().predict(at.as_ref()).unwrap(), gp.predict(at.as_ref()).unwrap());
    let error = saved(Mean::Estimated).1.unwrap_err();
    assert_eq!(error, GpError::NoMeanUncertainty { found: 1 });
    assert!(error.to_string().contains("learn it again"), "{error}");
}

#[test]
fn saved_models_that_were_edited() {
    let settings = SparseSettings::default();
    let gp = SparseGp::fit(kernel(), line(5).as_ref(), &waves(5), line(2).as_ref(), 0.1, settings);
    let model = gp.unwrap().to_model().unwrap();
    let refused = |model: SparseGpModel| SparseGp::from_model(&model).unwrap_err();
    assert_eq!(
        refused(SparseGpModel { version: 4, ..model.clone() }),
        GpError::UnsupportedVersion { found: 4, supported: 3 }
    );
    let sure = SparseGpModel { deviation: None, ..model.clone() };
    let what = "deviations of the mean";
    assert_eq!(refused(sure), GpError::ShapeMismatch { what, expected: 1, actual: 0 });
    let mut short = model.clone();
    short.deviation.as_mut().unwrap().weights.pop();
    assert!(matches!(refused(short), GpError::ShapeMismatch { .. }));
    let short = SparseGpModel { weights: vec![1.0], ..model.clone() };
    assert!(matches!(refused(short), GpError::ShapeMismatch { what: "weights", .. }));
    let ragged = SparseGpModel { pseudo_inputs: vec![vec![0.0], vec![]], ..model.clone() };
    assert!(matches!(refused(ragged), GpError::ShapeMismatch { .. }));
    let bent = SparseGpModel { precision_factor: vec![1.0, 0.0, -1.0], ..model.clone() };
    assert!(matches!(refused(bent), GpError::NotPositive { .. }));
    let silent = SparseGpModel { noise_variance: 0.0, ..model };
    assert!(matches!(refused(silent), GpError::NotPositive { .. }));
}
