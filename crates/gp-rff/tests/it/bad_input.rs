//! Every error that bad data or parameters can cause.

use faer::Mat;
use gp_core::{GpError, Mean, Posterior};
use gp_rff::{
    FeatureOptions, RandomFeatures, RffGp, RffGpModel, RffOptions, Spectrum, SufficientStatistics,
};

fn features(n_features: usize, lengthscale: f64) -> Result<RandomFeatures, GpError> {
    let options = FeatureOptions { n_features, ..FeatureOptions::default() };
    RandomFeatures::new(Spectrum::default(), &[lengthscale], options)
}

fn line(n: usize) -> Mat<f64> {
    Mat::from_fn(n, 1, |i, _| i as f64)
}

fn fit(y: &[f64], signal: f64, noise: f64) -> GpError {
    RffGp::fit(features(4, 1.0).unwrap(), line(3).as_ref(), y, signal, noise).unwrap_err()
}

#[test]
fn features_that_cannot_be() {
    assert!(matches!(features(0, 1.0), Err(GpError::NotPositive { .. })));
    let what = "paired features, two a frequency";
    let expected = GpError::ShapeMismatch { what, expected: 8, actual: 7 };
    assert_eq!(features(7, 1.0), Err(expected));
    assert!(matches!(features(4, -1.0), Err(GpError::NotPositive { .. })));
    let nothing = RandomFeatures::new(Spectrum::default(), &[], FeatureOptions::default());
    assert_eq!(nothing, Err(GpError::Empty { what: "lengthscales" }));
    let features = features(4, 1.0).unwrap();
    assert!(matches!(features.with_lengthscales(&[1.0; 2]), Err(GpError::ShapeMismatch { .. })));
    assert!(matches!(features.evaluate(line(0).as_ref()), Err(GpError::Empty { .. })));
}

#[test]
fn arguments_that_mean_nothing() {
    let expected = GpError::ShapeMismatch { what: "outputs", expected: 3, actual: 2 };
    assert_eq!(fit(&[1.0; 2], 1.0, 0.1), expected);
    assert!(matches!(fit(&[1.0, f64::NAN, 0.0], 1.0, 0.1), GpError::NotFinite { row: 1, .. }));
    assert!(matches!(fit(&[1.0; 3], 0.0, 0.1), GpError::NotPositive { .. }));
    assert!(matches!(fit(&[1.0; 3], 1.0, 0.0), GpError::NotPositive { .. }));
    assert!(matches!(fit(&[1.0; 3], 1.0, 1e-18), GpError::NotPositiveDefinite { .. }));
    let gp = RffGp::fit(features(4, 1.0).unwrap(), line(3).as_ref(), &[1.0; 3], 1.0, 0.1).unwrap();
    let wide = Mat::zeros(2, 2);
    assert!(matches!(gp.predict(wide.as_ref()), Err(GpError::ShapeMismatch { .. })));
    assert!(matches!(gp.predict_joint(wide.as_ref()), Err(GpError::ShapeMismatch { .. })));
    assert!(matches!(gp.predict_noise(wide.as_ref()), Err(GpError::ShapeMismatch { .. })));
    assert!(matches!(
        gp.log_evidence_gradient(line(2).as_ref(), &[1.0]),
        Err(GpError::ShapeMismatch { .. })
    ));
}

#[test]
fn a_failed_update_leaves_the_process_as_it_was() {
    let features = features(4, 1.0).unwrap();
    let mut gp = RffGp::fit(features, line(3).as_ref(), &[1.0, 2.0, 0.0], 1.0, 0.1).unwrap();
    let before = gp.to_model();
    assert!(gp.update(line(2).as_ref(), &[1.0, f64::NAN]).is_err());
    assert_eq!(gp.to_model(), before);
}

#[test]
fn statistics_that_do_not_fit_together() {
    let (one, other) = (features(4, 1.0).unwrap(), features(4, 2.0).unwrap());
    let statistics = |features: &RandomFeatures, origin: f64| {
        let mut statistics = SufficientStatistics::new(features, origin).unwrap();
        statistics.update(features, line(3).as_ref(), &[1.0, 2.0, 0.0]).unwrap();
        statistics
    };
    let mut sums = statistics(&one, 0.0);
    assert_eq!(
        sums.merge(&statistics(&other, 0.0)),
        Err(GpError::Incompatible { what: "features of the statistics" })
    );
    assert_eq!(
        sums.merge(&statistics(&one, 1.0)),
        Err(GpError::Incompatible { what: "output origins of the statistics" })
    );
    let mixed = RffGp::from_statistics(other.clone(), sums.clone(), 1.0, 0.1, Mean::Estimated);
    assert!(matches!(mixed, Err(GpError::Incompatible { .. })));
    assert!(matches!(
        sums.update(&other, line(3).as_ref(), &[0.0; 3]),
        Err(GpError::Incompatible { .. })
    ));
    let nothing = SufficientStatistics::new(&one, 0.0).unwrap();
    let empty = RffGp::from_statistics(one.clone(), nothing, 1.0, 0.1, Mean::Estimated);
    assert_eq!(empty.unwrap_err(), GpError::TooFewRows { needed: 1, actual: 0 });
    assert!(matches!(SufficientStatistics::new(&one, f64::NAN), Err(GpError::NotFinite { .. })));
    let linear = RffGp::from_statistics(one.clone(), sums.clone(), 1.0, 0.1, Mean::Linear);
    let what = "degrees of the mean and of the statistics";
    assert_eq!(linear.unwrap_err(), GpError::Incompatible { what });
    let fixed = Mean::Fixed(f64::INFINITY);
    assert!(matches!(
        RffGp::from_statistics(one, sums, 1.0, 0.1, fixed),
        Err(GpError::NotFinite { what: "mean", .. })
    ));
}

#[test]
fn data_from_which_nothing_can_be_learnt() {
    let learn =
        |y: &[f64]| RffGp::learn(line(y.len()).as_ref(), y, &RffOptions::default()).unwrap_err();
    assert_eq!(learn(&[1.0]), GpError::TooFewRows { needed: 2, actual: 1 });
    assert_eq!(learn(&[1.0; 4]), GpError::ConstantOutputs { value: 1.0, n_rows: 4 });
}

#[test]
fn saved_models_that_were_edited() {
    let features = features(4, 1.0).unwrap();
    let gp = RffGp::fit(features, line(3).as_ref(), &[1.0, 2.0, 0.0], 1.0, 0.1).unwrap();
    let model = gp.to_model();
    let refused = |model: RffGpModel| RffGp::from_model(&model).unwrap_err();
    assert_eq!(
        refused(RffGpModel { version: 2, ..model.clone() }),
        GpError::UnsupportedVersion { found: 2, supported: 1 }
    );
    let short = RffGpModel { phases: vec![0.0], ..model.clone() };
    assert!(matches!(refused(short), GpError::ShapeMismatch { what: "phases", .. }));
    let ragged = RffGpModel { frequencies: vec![vec![1.0], vec![]], ..model.clone() };
    assert!(matches!(refused(ragged), GpError::ShapeMismatch { .. }));
    let none = RffGpModel { frequencies: vec![], ..model.clone() };
    assert!(matches!(refused(none), GpError::Empty { .. }));
    let other = RffGpModel { lengthscales: vec![2.0], ..model.clone() };
    assert!(matches!(refused(other), GpError::Incompatible { .. }));
    let text = serde_json::to_string(&model).unwrap();
    let cut = text.replace("\"n_features\":4", "\"n_features\":5");
    let cut: RffGpModel = serde_json::from_str(&cut).unwrap();
    assert!(matches!(refused(cut), GpError::ShapeMismatch { .. }));
}
