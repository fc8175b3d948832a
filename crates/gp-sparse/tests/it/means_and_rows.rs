//! Learnt polynomials as means, and rows that come and go.

use faer::Mat;
use gp_core::{Gp, GpError, Mean, Posterior, SquaredExponential};
use gp_sparse::{Approximation, Placement, PseudoInputs, SparseGp, SparseOptions, SparseSettings};

const ALL: [Approximation; 4] = [
    Approximation::Fitc,
    Approximation::Vfe,
    Approximation::Dtc,
    Approximation::PowerEp { alpha: 0.4 },
];
const MEANS: [Mean; 4] = [Mean::Fixed(0.3), Mean::Estimated, Mean::Linear, Mean::Polynomial(2)];
const NOISE_VARIANCE: f64 = 0.03;

fn kernel() -> SquaredExponential {
    SquaredExponential::new(&[0.7, 0.9], 1.3).unwrap()
}

fn data(n: usize, scale: f64) -> (Mat<f64>, Vec<f64>) {
    // On no curve of second degree.
    let turn = |i: usize, d: usize| 1.7 * (2 * i + d) as f64 + 0.9 * (i * i * (d + 1)) as f64;
    let x = Mat::from_fn(n, 2, |i, d| scale * (turn(i, d) + 0.3).sin() + 4.0);
    let y = (0..n).map(|i| (1.3 * x[(i, 0)]).sin() + 2.0 * x[(i, 1)] - 0.3 * x[(i, 0)].powi(2));
    let y = y.collect();
    (x, y)
}

fn process(x: &Mat<f64>, y: &[f64], z: &Mat<f64>, settings: SparseSettings) -> SparseGp {
    SparseGp::fit(kernel(), x.as_ref(), y, z.as_ref(), NOISE_VARIANCE, settings).unwrap()
}

fn far() -> Mat<f64> {
    Mat::from_fn(6, 2, |i, d| 2.0 * (i + d) as f64 - 3.0)
}

/// The largest difference of two processes' joint beliefs.
fn difference(a: &dyn Posterior, b: &dyn Posterior) -> f64 {
    let [a, b] = [a, b].map(|one| one.predict_joint(far().as_ref()).unwrap());
    let means = a.mean().iter().zip(b.mean()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    means.max((a.covariance() - b.covariance()).norm_max())
}

#[test]
fn with_pseudo_inputs_at_the_data_every_mean_is_that_of_the_exact_process() {
    let (x, y) = data(14, 3.0);
    for mean in MEANS {
        let exact = Gp::builder(kernel()).noise_variance(NOISE_VARIANCE).mean(mean);
        let exact = exact.condition(&x, &y).unwrap();
        for approximation in ALL {
            let gp = process(&x, &y, &x, SparseSettings { approximation, mean, jitter: 0.0 });
            let likelihood = gp.objective() - exact.log_marginal_likelihood();
            assert!(likelihood.abs() < 1e-8, "{mean:?} {approximation:?} {likelihood}");
            let difference = difference(&gp, &exact);
            // Variances of an extrapolated parabola are up to a thousand.
            assert!(difference < 1e-7, "{mean:?} {approximation:?} {difference}");
            assert!((gp.mean() - exact.mean()).abs() < 1e-7, "{mean:?} {approximation:?}");
            let (mean, variance) = gp.predict(far().as_ref()).unwrap();
            let joint = gp.predict_joint(far().as_ref()).unwrap();
            for i in 0..6 {
                assert!((mean[i] - joint.mean()[i]).abs() < 1e-9);
                assert!((variance[i] / joint.covariance()[(i, i)] - 1.0).abs() < 1e-9);
            }
        }
    }
}

#[test]
fn the_gradient_beside_a_polynomial_is_that_of_differences() {
    let (x, y) = data(60, 2.0);
    let z = data(5, 1.7).0;
    for approximation in ALL {
        let settings = SparseSettings { approximation, mean: Mean::Polynomial(2), jitter: 1e-6 };
        let gp = process(&x, &y, &z, settings);
        let (_, gradient) = gp.objective_and_gradient(x.as_ref(), &y).unwrap();
        let at = |step: f64| {
            let mut z = z.clone();
            z[(2, 1)] += step;
            process(&x, &y, &z, settings).objective()
        };
        let numeric = (at(1e-5) - at(-1e-5)) / 2e-5;
        assert!((gradient[4 + 2 * 2 + 1] - numeric).abs() < 1e-5 * (1.0 + numeric.abs()));
        let with_noise = |step: f64| {
            let noise = NOISE_VARIANCE * step.exp();
            let gp = SparseGp::fit(kernel(), x.as_ref(), &y, z.as_ref(), noise, settings);
            gp.unwrap().objective()
        };
        let numeric = (with_noise(1e-5) - with_noise(-1e-5)) / 2e-5;
        assert!((gradient[3] - numeric).abs() < 1e-5 * (1.0 + numeric.abs()), "{approximation:?}");
    }
}

#[test]
fn rows_that_come_later_are_as_if_they_had_been_there() {
    let (x, y) = data(700, 2.0);
    let z = data(9, 1.7).0;
    let noise: Vec<f64> = (0..700).map(|i| 0.01 * (i % 4) as f64).collect();
    for (mean, approximation) in MEANS.into_iter().zip(ALL) {
        let settings = SparseSettings { approximation, mean, jitter: 1e-8 };
        let fit = |n: usize| {
            let (x, z) = (x.subrows(0, n), z.as_ref());
            let noise = &noise[..n];
            SparseGp::fit_with_row_noise(kernel(), x, &y[..n], noise, z, NOISE_VARIANCE, settings)
        };
        let (first, whole) = (fit(300).unwrap(), fit(700).unwrap());
        let mut grown = first.clone();
        grown.add_rows(x.subrows(300, 400), &y[300..], &noise[300..]).unwrap();
        assert_eq!(grown.n_rows(), Some(700));
        assert!((grown.objective() - whole.objective()).abs() < 1e-6, "{mean:?}");
        assert!(difference(&grown, &whole) < 1e-7, "{}", difference(&grown, &whole));
        grown.remove_rows(x.subrows(300, 400), &y[300..], &noise[300..]).unwrap();
        assert!(difference(&grown, &first) < 1e-6, "{}", difference(&grown, &first));
        // A saved process goes on.
        let text = serde_json::to_string(&first).unwrap();
        let mut read: SparseGp = serde_json::from_str(&text).unwrap();
        assert_eq!(difference(&read, &first), 0.0);
        read.add_rows(x.subrows(300, 400), &y[300..], &noise[300..]).unwrap();
        assert!(difference(&read, &whole) < 1e-7, "{mean:?}");
    }
}

#[test]
fn a_linear_mean_is_learnt_with_the_rest() {
    let (x, mut y) = data(300, 1.0);
    y.iter_mut().enumerate().for_each(|(i, y)| *y = 3.0 * x[(i, 0)] + 0.1 * (9.7 * i as f64).sin());
    let options = SparseOptions {
        settings: SparseSettings { mean: Mean::Linear, ..SparseSettings::default() },
        pseudo_inputs: PseudoInputs::Placed { count: 8, placement: Placement::default() },
        warm_start_rows: 60,
        ..SparseOptions::default()
    };
    let (gp, _) =
        SparseGp::learn(SquaredExponential::unit(2).unwrap(), x.as_ref(), &y, &options).unwrap();
    let ahead = gp.predict_mean(Mat::from_fn(1, 2, |_, _| 30.0).as_ref()).unwrap();
    assert!((ahead[0] - 90.0).abs() < 3.0, "{ahead:?}");
}

#[test]
fn rows_that_cannot_be_taken_leave_the_process_as_it_was() {
    let (x, y) = data(20, 2.0);
    let mut gp = process(&x, &y, &data(4, 1.7).0, SparseSettings::default());
    let before = gp.clone();
    let wrong = gp.add_rows(Mat::zeros(1, 3).as_ref(), &[0.0], &[]).unwrap_err();
    assert!(matches!(wrong, GpError::ShapeMismatch { expected: 2, actual: 3, .. }), "{wrong}");
    let none_left = gp.remove_rows(x.as_ref(), &y, &[]).unwrap_err();
    assert_eq!(none_left, GpError::TooFewRows { needed: 21, actual: 20 });
    let strange = Mat::from_fn(15, 2, |_, _| 4.0);
    let never_there = gp.remove_rows(strange.as_ref(), &[0.0; 15], &[]).unwrap_err();
    assert!(matches!(never_there, GpError::NotPositiveDefinite { .. }), "{never_there}");
    assert_eq!(difference(&gp, &before), 0.0);
    let mut model = gp.to_model().unwrap();
    model.rows = None;
    let mut old = SparseGp::from_model(&model).unwrap();
    assert_eq!(old.add_rows(x.as_ref(), &y, &[]).unwrap_err(), GpError::NoRowSums);
    assert_eq!(old.n_rows(), None);
    let same = Mat::from_fn(9, 2, |i, d| if d == 0 { i as f64 } else { 1.0 });
    let settings = SparseSettings { mean: Mean::Linear, ..SparseSettings::default() };
    let flat = SparseGp::fit(kernel(), same.as_ref(), &y[..9], x.subrows(0, 3), 0.1, settings);
    assert_eq!(flat.unwrap_err(), GpError::UndeterminedSlope { input: 1, n_rows: 9 });
}
