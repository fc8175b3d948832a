//! Hyperparameters by name: fixed, bounded, tied, with priors.

use faer::Mat;
use gp_core::{GpError, LogNormal, Posterior, Prior, SquaredExponential};
use gp_sparse::{
    GridGp, GridGpBuilder, GridOptions, Placement, PseudoInputs, SparseGp, SparseGpBuilder,
    SparseOptions, SparseReport,
};

const FIRST: &str = "squared_exponential.lengthscale[0]";
const SECOND: &str = "squared_exponential.lengthscale[1]";
const BOTH: &str = "squared_exponential.lengthscale";
const NOISE: &str = "noise_variance";

fn data() -> (Mat<f64>, Vec<f64>) {
    let x = Mat::from_fn(120, 2, |i, d| (1.7 * (2 * i + d) as f64 + 0.9 * (i * i) as f64).sin());
    let disturbance = |i: usize| 0.1 * (17.0 * (i * i) as f64).sin();
    let y = (0..120).map(|i| (2.0 * x[(i, 0)]).sin() + 0.4 * x[(i, 1)] + disturbance(i)).collect();
    (x, y)
}

fn kernel() -> SquaredExponential {
    SquaredExponential::unit(2).unwrap()
}

fn builder() -> SparseGpBuilder {
    let pseudo_inputs = PseudoInputs::Placed { count: 12, placement: Placement::default() };
    let options = SparseOptions {
        pseudo_inputs,
        warm_start_rows: 40,
        progress_tolerance: 1e-9,
        gradient_tolerance: 1e-4,
        ..SparseOptions::default()
    };
    SparseGp::builder(kernel()).options(options)
}

fn learn(builder: &SparseGpBuilder) -> (SparseGp, SparseReport) {
    let (x, y) = data();
    let gp = builder.fit(&x, &y).unwrap();
    let report = gp.report().unwrap().clone();
    (gp, report)
}

/// Slopes of the objective by the log-hyperparameters where learning ended.
fn slopes(gp: &SparseGp) -> Vec<f64> {
    let (x, y) = data();
    gp.objective_and_gradient(x.as_ref(), &y).unwrap().1[..4].to_vec()
}

#[test]
fn what_is_fixed_stays_and_the_rest_is_learnt() {
    let (gp, report) = learn(&builder().fix(FIRST, 0.9).fix(NOISE, 0.02));
    assert_eq!((report.best.parameters[0], gp.noise_variance()), (0.9, 0.02));
    let slopes = slopes(&gp);
    assert!(slopes[1].abs() < 1e-3 && slopes[2].abs() < 1e-3, "{slopes:?}");
    assert!(slopes[0].abs() > 0.1 && slopes[3].abs() > 0.1, "{slopes:?}");
    let (x, y) = data();
    let all = builder().fix(BOTH, 0.9).fix("squared_exponential.signal_variance", 1.5);
    let all = all.fix(NOISE, 0.02);
    let (fitted, kept) = (all.fit(&x, &y).unwrap(), all.condition(&x, &y).unwrap());
    assert_eq!(fitted.objective(), kept.objective());
    assert!(kept.report().is_none());
}

#[test]
fn pseudo_inputs_move_beside_what_is_fixed() {
    let pseudo_inputs = PseudoInputs::Learnt { count: 5, placement: Placement::default() };
    let still = builder().fix(FIRST, 0.9).fix(NOISE, 0.02);
    let (placed, _) = learn(
        &still
            .clone()
            .pseudo_inputs(PseudoInputs::Placed { count: 5, placement: Placement::default() }),
    );
    let (moved, report) = learn(&still.pseudo_inputs(pseudo_inputs));
    assert_eq!((report.best.parameters[0], moved.noise_variance()), (0.9, 0.02));
    assert!(moved.objective() > placed.objective() + 1.0);
}

#[test]
fn a_bound_is_never_left_and_reported_where_it_holds() {
    let (_, free) = learn(&builder());
    let first = free.best.parameters[0];
    assert!(free.at_bound.is_empty());
    let (_, wide) = learn(&builder().bound(FIRST, 0.01 * first..100.0 * first));
    assert!((wide.best.parameters[0] / first - 1.0).abs() < 1e-3);
    let (_, short) = learn(&builder().bound(FIRST, ..0.5 * first));
    let ended = short.best.parameters[0];
    assert!(ended <= 0.5 * first && ended > 0.49 * first, "{ended} of {first}");
    assert_eq!(short.at_bound, [FIRST]);
    assert!(short.to_string().contains("(at its bound)"), "{short}");
}

#[test]
fn tied_hyperparameters_are_one() {
    let (gp, report) = learn(&builder().tie(BOTH, BOTH));
    assert_eq!(report.best.parameters[0], report.best.parameters[1]);
    let slopes = slopes(&gp);
    assert!((slopes[0] + slopes[1]).abs() < 1e-3 && slopes[0].abs() > 0.1, "{slopes:?}");
}

#[test]
fn at_the_optimum_the_slopes_of_objective_and_priors_cancel() {
    let (_, free) = learn(&builder());
    let noise = LogNormal::new(-1.0, 0.02).unwrap();
    let (gp, report) = learn(&builder().prior(NOISE, noise));
    let own = slopes(&gp)[3];
    let of_prior = noise.log_density(gp.noise_variance()).1;
    assert!((own + of_prior).abs() < 1e-3 && of_prior.abs() > 0.1, "{own} {of_prior}");
    // So strong a prior pulls from a tenth of its median nearly all the way.
    assert!(free.best.parameters[3] < 0.04, "{free}");
    assert!((report.best.parameters[3] / (-1f64).exp() - 1.0).abs() < 0.1, "{report}");
    assert!((report.best.objective - gp.objective()).abs() < 1e-9);
}

#[test]
fn wishes_that_cannot_be_met_are_errors() {
    let (x, y) = data();
    let refused = |builder: SparseGpBuilder| {
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
    let elsewhere = PseudoInputs::Given(Mat::zeros(2, 3));
    let elsewhere = refused(builder().pseudo_inputs(elsewhere));
    assert!(matches!(elsewhere, GpError::ShapeMismatch { expected: 2, actual: 3, .. }));
}

fn grid() -> GridGpBuilder {
    let options =
        GridOptions { most_nodes: 100, gradient_tolerance: 1e-3, ..GridOptions::default() };
    GridGp::builder(kernel()).options(options)
}

#[test]
fn a_grid_takes_the_same_wishes() {
    let (x, y) = data();
    let free = grid().fit(&x, &y).unwrap();
    let first = free.report().unwrap().parameters[0];
    let gp = grid().bound(FIRST, ..0.5 * first).tie(FIRST, SECOND).fix(NOISE, 0.02);
    let gp = gp.fit(&x, &y).unwrap();
    let report = gp.report().unwrap();
    assert_eq!(report.parameters[0], report.parameters[1]);
    assert!(report.parameters[0] <= 0.5 * first && gp.noise_variance() == 0.02);
    assert_eq!(report.at_bound, [FIRST, SECOND]);
    assert!(report.to_string().contains("(at its bound)"), "{report}");
    let strong = LogNormal::new(-1.0, 0.02).unwrap();
    let pulled = grid().prior(NOISE, strong).fit(&x, &y).unwrap();
    assert!(free.noise_variance() < 0.04);
    assert!((pulled.noise_variance() / (-1f64).exp() - 1.0).abs() < 0.1);
    let kept = grid().noise_variance(0.02).condition(&x, &y).unwrap();
    assert!(kept.report().is_none() && kept.predict_mean(x.as_ref()).is_ok());
    let unknown = grid().fix("lengthscale", 1.0).fit(&x, &y).unwrap_err();
    assert!(unknown.to_string().contains(FIRST));
}
