//! Scores against values known by hand and against numerical integration.

use gp_core::GpError;
use gp_core::scores::{
    calibration_curve, calibration_error, coverage, crps, msll, nlpd, nmse, rmse,
};

const Y: [f64; 4] = [1.0, 2.0, 3.0, 4.0];
const MEAN: [f64; 4] = [1.0, 2.0, 3.0, 6.0];

#[test]
fn errors_known_by_hand() {
    assert_eq!(rmse(&Y, &MEAN).unwrap(), 1.0);
    assert_eq!(nmse(&Y, &MEAN).unwrap(), 1.0 / 1.25);
    assert_eq!(nmse(&Y, &[2.5; 4]).unwrap(), 1.0);
}

#[test]
fn densities_known_by_hand() {
    let expected = 0.5 * ((2.0 * std::f64::consts::PI * 0.25).ln() + 4.0 / 0.25 / 4.0);
    assert!((nlpd(&Y, &MEAN, &[0.25; 4]).unwrap() - expected).abs() < 1e-14);
}

#[test]
fn the_trivial_model_has_no_standardised_loss() {
    assert!(msll(&Y, &[2.5; 4], &[1.25; 4], &Y).unwrap().abs() < 1e-15);
    assert!(msll(&Y, &Y, &[0.1; 4], &Y).unwrap() < -1.0);
}

#[test]
fn the_ranked_score_equals_its_integral() {
    // CRPS = ∫ (F(t) − 1{t ≥ y})² dt by the midpoint rule, with F from the error function.
    let (y, mean, sd) = (0.7, -0.4, 1.3_f64);
    let n = 400_000;
    let (from, to) = (-15.0, 15.0);
    let width = (to - from) / n as f64;
    let term = |i: usize| {
        let t = from + (i as f64 + 0.5) * width;
        let below = 0.5 * (1.0 + libm::erf((t - mean) / (sd * std::f64::consts::SQRT_2)));
        (below - if t >= y { 1.0 } else { 0.0 }).powi(2) * width
    };
    let expected: f64 = (0..n).map(term).sum();
    assert!((crps(&[y], &[mean], &[sd * sd]).unwrap() - expected).abs() < 1e-4);
}

#[test]
fn the_ranked_score_of_a_sharp_prediction_is_the_absolute_error() {
    let score = crps(&[1.5], &[1.0], &[1e-12]).unwrap();
    assert!((score - 0.5).abs() < 1e-6);
}

#[test]
fn coverage_counts_what_lies_within_the_interval() {
    let y = [0.0, 0.9, 1.1, 1.9, 2.1];
    let found = coverage(&y, &[0.0; 5], &[1.0; 5], &[0.6827, 0.9545]).unwrap();
    assert_eq!(found, [0.4, 0.8]);
}

#[test]
fn the_calibration_curve_of_the_truth_is_the_diagonal() {
    // Quantiles of the normal distribution, so that every interval holds what it says.
    let quantile = |p: f64| {
        let below = |x: f64| 0.5 * (1.0 + libm::erf(x * std::f64::consts::FRAC_1_SQRT_2));
        let halve = |(low, high): (f64, f64), _| {
            let middle = 0.5 * (low + high);
            if below(middle) < p { (middle, high) } else { (low, middle) }
        };
        (0..60).fold((-9.0, 9.0), halve).0
    };
    let y: Vec<f64> = (0..1000).map(|i| quantile((f64::from(i) + 0.5) / 1000.0)).collect();
    let curve = calibration_curve(&y, &[0.0; 1000], &[1.0; 1000], 10).unwrap();
    assert_eq!(curve.len(), 10);
    assert!(curve.iter().all(|(level, fraction)| (level - fraction).abs() < 2e-3), "{curve:?}");
    assert!(calibration_error(&y, &[0.0; 1000], &[1.0; 1000]).unwrap() < 2e-3);
    let sharp = calibration_error(&y, &[0.0; 1000], &[1e-12; 1000]).unwrap();
    assert!((sharp - 0.5).abs() < 2e-3, "{sharp}");
    assert!(matches!(calibration_curve(&y, &y, &y, 0), Err(GpError::NotPositive { .. })));
}

#[test]
fn bad_arguments_are_errors() {
    assert_eq!(rmse(&[], &[]), Err(GpError::Empty { what: "observations" }));
    assert_eq!(
        rmse(&Y, &MEAN[..3]),
        Err(GpError::ShapeMismatch { what: "predicted means", expected: 4, actual: 3 })
    );
    assert!(matches!(rmse(&[f64::NAN], &[0.0]), Err(GpError::NotFinite { row: 0, .. })));
    assert_eq!(nmse(&[2.0; 3], &[2.0; 3]), Err(GpError::ConstantOutputs { value: 2.0, n_rows: 3 }));
    assert!(matches!(nlpd(&[1.0], &[1.0], &[0.0]), Err(GpError::NotPositive { .. })));
    assert!(matches!(crps(&[1.0], &[1.0], &[-1.0]), Err(GpError::NotPositive { .. })));
    assert_eq!(coverage(&[1.0], &[1.0], &[1.0], &[1.0]), Err(GpError::InvalidLevel { level: 1.0 }));
    assert!(matches!(msll(&Y, &MEAN, &[1.0; 4], &[]), Err(GpError::Empty { .. })));
    assert!(matches!(msll(&Y, &MEAN, &[1.0; 4], &[3.0; 2]), Err(GpError::ConstantOutputs { .. })));
}
