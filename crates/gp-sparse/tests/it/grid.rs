//! Processes on a grid beside exact ones.

use faer::Mat;
use gp_core::{Gp, GpError, Matern52, Mean, Posterior, SquaredExponential};
use gp_sparse::{GridGp, GridGpModel, GridOptions};

const NOISE_VARIANCE: f64 = 4e-4;

fn kernel() -> SquaredExponential {
    SquaredExponential::new(&[0.9, 1.1], 0.4).unwrap()
}

/// Points that fill [−1, 1]², and a smooth function with noise.
fn data(n: usize) -> (Mat<f64>, Vec<f64>) {
    let golden = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2];
    let x = Mat::from_fn(n, 2, |i, d| 2.0 * ((i + 1) as f64 * golden[d]).fract() - 1.0);
    let noise = |i: usize| 0.02 * 2_f64.sqrt() * (37.7 * (i * i) as f64).sin();
    let y = (0..n).map(|i| (2.0 * x[(i, 0)]).sin() * (x[(i, 1)] + 0.5).cos() + noise(i)).collect();
    (x, y)
}

fn options(mean: Mean) -> GridOptions {
    GridOptions { mean, most_nodes: 500, finest_spacing: 0.12, ..GridOptions::default() }
}

fn far() -> Mat<f64> {
    Mat::from_fn(7, 2, |i, d| 0.45 * (i as f64 - 3.0) + 0.1 * d as f64)
}

#[test]
fn it_is_the_exact_process_as_far_as_cubes_reach() {
    let (x, y) = data(300);
    for mean in [Mean::Fixed(0.1), Mean::Estimated, Mean::Linear, Mean::Polynomial(2)] {
        let exact = Gp::builder(kernel()).noise_variance(NOISE_VARIANCE).mean(mean);
        let exact = exact.condition(&x, &y).unwrap();
        let gp = GridGp::fit(kernel(), x.as_ref(), &y, NOISE_VARIANCE, &options(mean)).unwrap();
        let likelihood = exact.log_marginal_likelihood();
        let found = gp.log_marginal_likelihood();
        assert!((found - likelihood).abs() < 0.3, "{mean:?} {found} {likelihood}");
        let at = far();
        let [a, b] =
            [&gp as &dyn Posterior, &exact].map(|one| one.predict_joint(at.as_ref()).unwrap());
        for i in 0..7 {
            let sd = b.covariance()[(i, i)].sqrt();
            let apart = a.mean()[i] - b.mean()[i];
            assert!(apart.abs() < 0.1 * sd, "{mean:?} {i} {apart} {sd}");
            let ratio = a.covariance()[(i, i)].sqrt() / sd;
            assert!((0.98..1.02).contains(&ratio), "{mean:?} {i} {ratio}");
        }
        let (means, variances) = gp.predict(at.as_ref()).unwrap();
        for i in 0..7 {
            assert!((means[i] - a.mean()[i]).abs() < 1e-12);
            assert!((variances[i] - a.covariance()[(i, i)]).abs() < 1e-12);
        }
        assert_eq!(gp.predict_mean(at.as_ref()).unwrap(), means);
    }
}

#[test]
fn far_from_the_nodes_the_prior_returns() {
    let (x, y) = data(300);
    let mean = Mean::Fixed(0.1);
    let gp = GridGp::fit(kernel(), x.as_ref(), &y, NOISE_VARIANCE, &options(mean)).unwrap();
    let (mean, variance) = gp.predict(Mat::from_fn(1, 2, |_, _| 30.0).as_ref()).unwrap();
    assert!((mean[0] - 0.1).abs() < 1e-9 && (variance[0] - 0.4).abs() < 1e-9);
}

#[test]
fn it_learns_what_the_exact_process_learns() {
    let (x, y) = data(500);
    let exact = Gp::builder(Matern52::unit(2).unwrap()).fit(&x, &y).unwrap();
    let options = GridOptions { most_nodes: 500, ..GridOptions::default() };
    let (gp, report) = GridGp::learn(Matern52::unit(2).unwrap(), x.as_ref(), &y, &options).unwrap();
    assert!(report.n_nodes <= 500 && report.stop.converged() && report.widest_spacing < 0.5);
    assert!((gp.noise_variance() / exact.noise_variance() - 1.0).abs() < 0.1);
    let [a, b] = [&gp as &dyn Posterior, &exact].map(|one| one.predict(far().as_ref()).unwrap());
    for i in 1..6 {
        assert!((a.0[i] - b.0[i]).abs() < 0.5 * b.1[i].sqrt(), "{i}: {} {}", a.0[i], b.0[i]);
    }
}

#[test]
fn the_same_bytes_come_from_any_number_of_threads_and_from_a_file() {
    let (x, y) = data(12_000);
    let fit = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let fit = || GridGp::fit(kernel(), x.as_ref(), &y, NOISE_VARIANCE, &GridOptions::default());
        pool.install(|| serde_json::to_string(&fit().unwrap()).unwrap())
    };
    let text = fit(1);
    assert_eq!(text, fit(2));
    let read: GridGp = serde_json::from_str(&text).unwrap();
    let made = GridGp::fit(kernel(), x.as_ref(), &y, NOISE_VARIANCE, &GridOptions::default());
    let at = far();
    assert_eq!(read.predict(at.as_ref()).unwrap(), made.unwrap().predict(at.as_ref()).unwrap());
}

#[test]
fn what_no_grid_can_do_is_an_error() {
    let (x, y) = data(30);
    let fit = |x: &Mat<f64>, options: &GridOptions| {
        let kernel = SquaredExponential::isotropic(1.0);
        GridGp::fit(kernel, x.as_ref(), &y, NOISE_VARIANCE, options).unwrap_err()
    };
    let wide = Mat::from_fn(30, 5, |i, d| (i * d) as f64);
    let error = fit(&wide, &GridOptions::default());
    assert!(matches!(error, GpError::OutOfRange { value: 5.0, highest: 4.0, .. }), "{error}");
    let error = fit(&x, &options(Mean::Polynomial(3)));
    assert!(matches!(error, GpError::OutOfRange { value: 3.0, highest: 2.0, .. }), "{error}");
    let few = GridOptions { most_nodes: 9, ..GridOptions::default() };
    assert!(matches!(fit(&x, &few), GpError::ShapeMismatch { expected: 16, actual: 9, .. }));
    let spacing = GridOptions { finest_spacing: 0.0, ..GridOptions::default() };
    assert!(matches!(fit(&x, &spacing), GpError::NotPositive { .. }));
    let gp =
        GridGp::fit(kernel(), x.as_ref(), &y, NOISE_VARIANCE, &GridOptions::default()).unwrap();
    let model = gp.to_model().unwrap();
    let refused = |model: GridGpModel| GridGp::from_model(&model).unwrap_err();
    let newer = GridGpModel { version: 2, ..model.clone() };
    assert_eq!(refused(newer), GpError::UnsupportedVersion { found: 2, supported: 1 });
    let mixed = GridGpModel { nodes: model.nodes.iter().rev().copied().collect(), ..model.clone() };
    assert!(matches!(refused(mixed), GpError::OutOfRange { .. }));
    let mut elsewhere = model.clone();
    elsewhere.columns[0] = u32::MAX;
    let expected = GpError::Incompatible { what: "nodes and sums of the model" };
    assert_eq!(refused(elsewhere), expected);
    let short = GridGpModel { of_y: vec![0.0], ..model };
    assert!(matches!(refused(short), GpError::ShapeMismatch { .. }));
}
