//! Hyperparameters by name: fixed, bounded, tied, with priors; means and noise that are asked for.

use faer::Mat;
use gp_core::{GpError, LogNormal, Mean, Posterior, Prior};
use gp_rff::{Hyperparameters, RffGp, RffGpBuilder, RffOptions, RffReport, Spectrum};

const FIRST: &str = "squared_exponential.lengthscale[0]";
const BOTH: &str = "squared_exponential.lengthscale";
const SIGNAL: &str = "squared_exponential.signal_variance";
const NOISE: &str = "noise_variance";

fn data() -> (Mat<f64>, Vec<f64>) {
    let x = Mat::from_fn(120, 2, |i, d| (1.7 * (2 * i + d) as f64 + 0.9 * (i * i) as f64).sin());
    let disturbance = |i: usize| 0.1 * (17.0 * (i * i) as f64).sin();
    let y = (0..120).map(|i| (2.0 * x[(i, 0)]).sin() + 0.4 * x[(i, 1)] + disturbance(i)).collect();
    (x, y)
}

fn builder() -> RffGpBuilder {
    let options =
        RffOptions { small_gp_rows: 40, gradient_tolerance: 1e-4, ..RffOptions::default() };
    RffGp::builder(Spectrum::SquaredExponential).options(options).n_features(40)
}

fn learn(builder: &RffGpBuilder) -> (RffGp, RffReport) {
    let (x, y) = data();
    let gp = builder.fit(&x, &y).unwrap();
    let report = gp.report().unwrap().clone();
    (gp, report)
}

fn slopes(gp: &RffGp) -> Vec<f64> {
    let (x, y) = data();
    gp.log_evidence_gradient(x.as_ref(), &y).unwrap()
}

#[test]
fn what_is_fixed_stays_and_the_rest_is_learnt() {
    let (gp, report) = learn(&builder().fix(FIRST, 0.9).fix(NOISE, 0.02));
    assert_eq!((gp.features().lengthscales()[0], gp.noise_variance()), (0.9, 0.02));
    assert_eq!(report.names[..2], [FIRST, "squared_exponential.lengthscale[1]"]);
    let slopes = slopes(&gp);
    assert!(slopes[1].abs() < 1e-3 && slopes[2].abs() < 1e-3, "{slopes:?}");
    assert!(slopes[0].abs() > 0.1 && slopes[3].abs() > 0.1, "{slopes:?}");
    let (x, y) = data();
    let all = builder().fix(BOTH, 0.9).fix(SIGNAL, 1.5).fix(NOISE, 0.02);
    let (fitted, kept) = (all.fit(&x, &y).unwrap(), all.condition(&x, &y).unwrap());
    assert_eq!(fitted.to_model(), kept.to_model());
    assert!(kept.report().is_none());
    let again = builder().features(kept.features().clone()).noise_variance(0.02).fix(SIGNAL, 1.5);
    assert_eq!(again.condition(&x, &y).unwrap().to_model(), kept.to_model());
}

#[test]
fn a_bound_is_never_left_and_reported_where_it_holds() {
    let (_, free) = learn(&builder());
    let first = free.parameters[0];
    assert!(free.at_bound.is_empty());
    let (_, short) = learn(&builder().bound(FIRST, ..0.5 * first));
    let ended = short.parameters[0];
    assert!(ended <= 0.5 * first && ended > 0.49 * first, "{ended} of {first}");
    assert_eq!(short.at_bound, [FIRST]);
    assert!(short.to_string().contains("(at its bound)"), "{short}");
}

#[test]
fn tied_hyperparameters_are_one() {
    let (gp, report) = learn(&builder().tie(BOTH, BOTH));
    assert_eq!(report.parameters[0], report.parameters[1]);
    let slopes = slopes(&gp);
    assert!((slopes[0] + slopes[1]).abs() < 1e-3 && slopes[0].abs() > 0.1, "{slopes:?}");
}

#[test]
fn at_the_optimum_the_slopes_of_evidence_and_priors_cancel() {
    let (_, free) = learn(&builder());
    let noise = LogNormal::new(-1.0, 0.02).unwrap();
    let (gp, report) = learn(&builder().prior(NOISE, noise));
    let own = slopes(&gp)[3];
    let of_prior = noise.log_density(gp.noise_variance()).1;
    assert!((own + of_prior).abs() < 1e-3 && of_prior.abs() > 0.1, "{own} {of_prior}");
    assert!(free.parameters[3] < 0.04, "{free}");
    assert!((report.parameters[3] / (-1f64).exp() - 1.0).abs() < 0.1, "{report}");
}

#[test]
fn learnt_frequencies_leave_what_is_fixed() {
    let options = RffOptions {
        hyperparameters: Hyperparameters::Frequencies,
        small_gp_rows: 40,
        ..RffOptions::default()
    };
    let (gp, report) = learn(&builder().options(options).n_features(10).fix(FIRST, 0.9));
    assert_eq!(gp.features().lengthscales()[0], 0.9);
    assert!(report.stop.unwrap().converged());
}

#[test]
fn a_linear_mean_and_noise_of_rows_are_learnt_with_the_rest() {
    let (x, mut y) = data();
    let noise: Vec<f64> = (0..120).map(|i| if i % 3 == 0 { 4.0 } else { 0.0 }).collect();
    for i in 0..120 {
        let wrong = if noise[i] > 0.0 { 2.0 * (3.3 * i as f64).sin() } else { 0.0 };
        y[i] = 3.0 * x[(i, 0)] + 0.1 * (9.7 * i as f64).sin() + wrong;
    }
    let learn = |noise: &[f64]| builder().mean(Mean::Linear).row_noise(noise).fit(&x, &y).unwrap();
    let (told, untold) = (learn(&noise), learn(&[]));
    // Far ahead the plane is left, and what rows leave open of its slopes.
    let (mean, variance) = told.predict(Mat::full(1, 2, 30.0).as_ref()).unwrap();
    assert!((mean[0] - 90.0).abs() < 3.0 * variance[0].sqrt(), "{mean:?} {variance:?}");
    assert!((mean[0] - 90.0).abs() < 20.0 && variance[0] > 10.0, "{mean:?} {variance:?}");
    assert!(told.noise_variance() < 0.03 && untold.noise_variance() > 0.3);
    assert_eq!(told.mean_choice(), Mean::Linear);
}

#[test]
fn wishes_that_cannot_be_met_are_errors() {
    let (x, y) = data();
    let refused = |builder: RffGpBuilder| {
        let error = builder.fit(&x, &y).unwrap_err();
        let kept = builder.noise_variance(0.1).condition(&x, &y).unwrap_err();
        assert_eq!(error, kept);
        error
    };
    let unknown = refused(builder().fix("lengthscale", 1.0));
    assert!(unknown.to_string().contains(FIRST) && unknown.to_string().contains(NOISE));
    assert!(matches!(refused(builder().fix(FIRST, 0.0)), GpError::NotPositive { .. }));
    let outside = refused(builder().bound(FIRST, 0.1..1.0).fix(FIRST, 2.0));
    assert!(matches!(outside, GpError::OutOfRange { value: 2.0, .. }));
    assert_eq!(builder().condition(&x, &y).unwrap_err(), GpError::NoNoiseVariance);
    assert!(matches!(refused(builder().row_noise(&[0.1])), GpError::ShapeMismatch { .. }));
}
