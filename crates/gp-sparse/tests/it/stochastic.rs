//! Steps on batches of rows.

use faer::Mat;
use gp_core::{GpError, Posterior, SquaredExponential, StopReason};
use gp_sparse::{
    Approximation, Batches, Optimizer, Placement, PseudoInputs, SparseGp, SparseGpBuilder,
    SparseOptions,
};

const FIRST: &str = "squared_exponential.lengthscale[0]";

fn data(n: usize) -> (Mat<f64>, Vec<f64>) {
    let turn = |i: usize, d: usize| 1.7 * (2 * i + d) as f64 + 0.9 * ((i * i) % 9973) as f64;
    let x = Mat::from_fn(n, 2, |i, d| turn(i, d).sin());
    let disturbance = |i: usize| 0.5 * (17.0 * ((i * i) % 7919) as f64).sin();
    let y = (0..n)
        .map(|i| (5.0 * x[(i, 0)]).sin() * (3.0 * x[(i, 1)]).cos() + disturbance(i))
        .collect();
    (x, y)
}

fn builder(pseudo_inputs: PseudoInputs, optimizer: Optimizer) -> SparseGpBuilder {
    let options = SparseOptions {
        pseudo_inputs,
        optimizer,
        warm_start_rows: 60,
        progress_tolerance: 1e-3,
        ..SparseOptions::default()
    };
    SparseGp::builder(SquaredExponential::unit(2).unwrap()).options(options)
}

fn learnt(count: usize) -> PseudoInputs {
    PseudoInputs::Learnt { count, placement: Placement::KMeans }
}

#[test]
fn on_all_rows_with_whole_natural_steps_it_ends_at_the_optimum_of_vfe() {
    let (x, y) = data(200);
    let placed = PseudoInputs::Placed { count: 8, placement: Placement::KMeans };
    let whole = Batches { rows: 200, steps: 4000, step_size: 0.1, natural_step: 1.0 };
    let [best, stepped] = [Optimizer::QuasiNewton, Optimizer::Stochastic(whole)]
        .map(|optimizer| builder(placed.clone(), optimizer).fit(&x, &y).unwrap());
    let behind = best.objective() - stepped.objective();
    assert!(behind.abs() < 1e-3, "{behind}");
    let report = stepped.report().unwrap();
    assert_eq!(report.best.stop, StopReason::StepsTaken);
    assert!((report.best.objective - stepped.objective()).abs() < 1e-9);
}

#[test]
fn a_few_hundred_batches_come_near_the_bound_of_all_rows() {
    let (x, y) = data(6000);
    let batches = Batches { rows: 240, steps: 400, ..Batches::default() };
    let bound = |pseudo_inputs, optimizer| {
        builder(pseudo_inputs, optimizer).fit(&x, &y).unwrap().objective() / 6000.0
    };
    let first = Batches { steps: 1, ..batches };
    let [first, stepped] =
        [first, batches].map(|one| bound(learnt(20), Optimizer::Stochastic(one)));
    let best = bound(learnt(20), Optimizer::QuasiNewton);
    assert!(stepped > first + 0.01 && best - stepped < 0.003, "{first} {stepped} {best}");
}

#[test]
fn what_is_asked_by_name_holds_and_threads_change_no_bit() {
    let (x, y) = data(1500);
    let batches = Batches { rows: 500, steps: 30, ..Batches::default() };
    let asked = builder(learnt(6), Optimizer::Stochastic(batches)).fix(FIRST, 0.9);
    let run = |n: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        pool.install(|| asked.fit(&x, &y).unwrap())
    };
    let (one, three) = (run(1), run(3));
    assert_eq!(one.to_model().unwrap(), three.to_model().unwrap());
    assert_eq!(one.report(), three.report());
    assert_eq!(one.report().unwrap().best.parameters[0], 0.9);
}

#[test]
fn rows_with_much_noise_of_their_own_count_little() {
    let (x, mut y) = data(600);
    let noise: Vec<f64> = (0..600).map(|i| if i % 2 == 0 { 9.0 } else { 0.0 }).collect();
    y.iter_mut().step_by(2).enumerate().for_each(|(i, y)| *y += 3.0 * (3.3 * i as f64).sin());
    let batches = Batches { rows: 200, steps: 100, ..Batches::default() };
    let asked = builder(learnt(8), Optimizer::Stochastic(batches));
    let told = asked.clone().row_noise(&noise).fit(&x, &y).unwrap();
    let untold = asked.fit(&x, &y).unwrap();
    assert!(told.noise_variance() < 0.5 && untold.noise_variance() > 1.0);
    assert!(told.predict_mean(x.subrows(0, 3)).is_ok());
}

#[test]
fn settings_that_mean_nothing_are_errors() {
    let (x, y) = data(50);
    let refused = |batches| {
        let asked = builder(learnt(4), Optimizer::Stochastic(batches));
        asked.fit(&x, &y).unwrap_err()
    };
    let usual = Batches::default();
    assert!(matches!(refused(Batches { rows: 0, ..usual }), GpError::NotPositive { .. }));
    assert!(matches!(refused(Batches { steps: 0, ..usual }), GpError::NotPositive { .. }));
    assert!(matches!(
        refused(Batches { step_size: f64::NAN, ..usual }),
        GpError::NotPositive { .. }
    ));
    for natural_step in [0.0, 1.5, f64::NAN] {
        let error = refused(Batches { natural_step, ..usual });
        assert!(matches!(error, GpError::OutOfRange { .. }), "{error}");
    }
    let fitc = builder(learnt(4), Optimizer::Stochastic(usual)).approximation(Approximation::Fitc);
    assert!(matches!(fitc.fit(&x, &y).unwrap_err(), GpError::Incompatible { .. }));
}
