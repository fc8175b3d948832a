//! Laws of the exact Gaussian process, on random data.

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use gp_core::{
    Gp, GpError, GpModel, JointGaussian, Kernel, Matern32, Mean, Periodic, Posterior,
    SquaredExponential, Workspace, gram,
};
use proptest::collection::vec;
use proptest::prelude::{Just, ProptestConfig, Strategy, prop_assert, prop_assert_eq, proptest};

#[derive(Clone, Debug)]
struct Case {
    x: Mat<f64>,
    y: Vec<f64>,
    x_star: Mat<f64>,
    lengthscales: Vec<f64>,
}

impl Case {
    fn kernel(&self) -> SquaredExponential {
        SquaredExponential::new(&self.lengthscales, 1.7).unwrap()
    }

    fn gp(&self) -> Gp {
        Gp::builder(self.kernel())
            .noise_variance(NOISE_VARIANCE)
            .condition(self.x.as_ref(), &self.y)
            .unwrap()
    }
}

const NOISE_VARIANCE: f64 = 0.05;

fn case() -> impl Strategy<Value = Case> {
    (1_usize..4, 1_usize..13).prop_flat_map(|(d, n)| {
        let matrix = |rows: usize| {
            vec(-2.0..2.0, rows * d)
                .prop_map(move |entries| Mat::from_fn(rows, d, |i, j| entries[i * d + j]))
        };
        let data = (matrix(n), vec(-3.0..3.0, n), matrix(5), vec(0.3..3.0, d));
        (Just(()), data).prop_map(|((), (x, y, x_star, lengthscales))| Case {
            x,
            y,
            x_star,
            lengthscales,
        })
    })
}

fn close(actual: &[f64], expected: &[f64], tolerance: f64) -> bool {
    actual.len() == expected.len()
        && actual.iter().zip(expected).all(|(a, b)| (a - b).abs() <= tolerance * (1.0 + b.abs()))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn posterior_variance_lies_between_zero_and_the_prior(case in case()) {
        let (x, mean) = (case.x.as_ref(), Mean::Fixed(0.4));
        let gp = Gp::builder(case.kernel()).noise_variance(NOISE_VARIANCE).mean(mean).condition(x, &case.y).unwrap();
        let (_, variance) = gp.predict(case.x_star.as_ref()).unwrap();
        prop_assert!(variance.iter().all(|&variance| (0.0..=1.7).contains(&variance)));
    }

    #[test]
    fn predictions_equal_a_direct_solve(case in case()) {
        let gp = case.gp();
        let (n, m) = (case.y.len(), case.x_star.nrows());
        let mut k = gram(&case.kernel(), case.x.as_ref()).unwrap();
        (0..n).for_each(|i| k[(i, i)] += NOISE_VARIANCE);
        let k_star = gp_core::cross(&case.kernel(), case.x.as_ref(), case.x_star.as_ref()).unwrap();
        let llt = k.llt(Side::Lower).unwrap();
        let solved = llt.solve(&Mat::from_fn(n, 2, |i, j| if j == 0 { case.y[i] } else { 1.0 }));
        let total = |j: usize| (0..n).map(|i| solved[(i, j)]).sum::<f64>();
        let constant = total(0) / total(1);
        let mean: Vec<f64> = (0..m).map(|s| {
            let term = |i: usize| k_star[(i, s)] * (solved[(i, 0)] - constant * solved[(i, 1)]);
            constant + (0..n).map(term).sum::<f64>()
        }).collect();
        let half = llt.solve(&k_star);
        // What the rows leave open of the constant: 1 − 1ᵀK⁻¹k*, over the root of 1ᵀK⁻¹1.
        let moved = |s: usize| {
            (1.0 - (0..n).map(|i| k_star[(i, s)] * solved[(i, 1)]).sum::<f64>()) / total(1).sqrt()
        };
        let covariance = |s: usize, t: usize| {
            case.kernel().value(&row(&case.x_star, s), &row(&case.x_star, t))
                - (0..n).map(|i| k_star[(i, s)] * half[(i, t)]).sum::<f64>()
                + moved(s) * moved(t)
        };
        prop_assert!(close(&[gp.mean()], &[constant], 1e-10));
        let joint = gp.predict_joint(case.x_star.as_ref()).unwrap();
        let (predicted, variance) = gp.predict(case.x_star.as_ref()).unwrap();
        prop_assert!(close(&predicted, &mean, 1e-10));
        for (s, variance) in variance.iter().enumerate() {
            prop_assert!((variance - covariance(s, s)).abs() < 1e-11);
            for t in 0..m {
                prop_assert!((joint.covariance()[(s, t)] - covariance(s, t)).abs() < 1e-11);
            }
        }
        let (mean_y, variance_y) = gp.predict_observation(case.x_star.as_ref()).unwrap();
        prop_assert_eq!(&mean_y, &predicted);
        prop_assert_eq!(&gp.predict_mean(case.x_star.as_ref()).unwrap(), &predicted);
        prop_assert!(variance_y.iter().zip(&variance).all(|(y, f)| *y == f + NOISE_VARIANCE));
    }

    #[test]
    fn likelihood_gradients_equal_finite_differences(case in case()) {
        let factors = |d: usize| SquaredExponential::new(&case.lengthscales, 1.7).unwrap()
            * Periodic::ard(&vec![1.3; d], &vec![0.9; d]);
        let kernels: [Box<dyn Kernel>; 3] = [
            Box::new(case.kernel()),
            Box::new(Matern32::new(&case.lengthscales, 0.8).unwrap()),
            Box::new(factors(case.lengthscales.len())),
        ];
        for kernel in kernels {
            let mut values: Vec<f64> = kernel.parameters().iter().map(|p| p.value).collect();
            values.push(NOISE_VARIANCE);
            let fit = |values: &[f64]| {
                let (noise_variance, parameters) = values.split_last().unwrap();
                let moved = kernel.with_parameters(parameters).unwrap();
                Gp::builder(moved).noise_variance(*noise_variance).condition(case.x.as_ref(), &case.y).unwrap()
            };
            let gradient = fit(&values).log_marginal_likelihood_gradient().unwrap();
            for (p, slope) in gradient.iter().enumerate() {
                let moved = |h: f64| {
                    let mut moved = values.clone();
                    moved[p] *= h.exp();
                    fit(&moved).log_marginal_likelihood()
                };
                let h = 1e-5;
                let expected = (moved(h) - moved(-h)) / (2.0 * h);
                prop_assert!((slope - expected).abs() < 1e-6 * (1.0 + slope.abs()));
            }
        }
    }

    #[test]
    fn mean_gradients_equal_finite_differences(case in case()) {
        let gp = case.gp();
        let gradient = gp.mean_gradient(case.x_star.as_ref()).unwrap();
        for d in 0..case.x.ncols() {
            let moved = |h: f64| {
                let shift = |i: usize, j: usize| if j == d { h } else { 0.0 } + case.x_star[(i, j)];
                let x = Mat::from_fn(case.x_star.nrows(), case.x.ncols(), shift);
                gp.predict_mean(x.as_ref()).unwrap()
            };
            let h = 1e-5;
            for (i, (above, below)) in moved(h).iter().zip(moved(-h)).enumerate() {
                let expected = (above - below) / (2.0 * h);
                prop_assert!((gradient[(i, d)] - expected).abs() < 1e-6 * (1.0 + expected.abs()));
            }
        }
    }

    #[test]
    fn the_order_of_rows_does_not_matter(case in case()) {
        let n = case.y.len();
        let x = Mat::from_fn(n, case.x.ncols(), |i, j| case.x[(n - 1 - i, j)]);
        let y: Vec<f64> = case.y.iter().rev().copied().collect();
        let reversed = Gp::builder(case.kernel()).noise_variance(NOISE_VARIANCE).condition(x.as_ref(), &y).unwrap();
        let (mean, variance) = case.gp().predict(case.x_star.as_ref()).unwrap();
        let (reversed_mean, reversed_variance) = reversed.predict(case.x_star.as_ref()).unwrap();
        prop_assert!(close(&reversed_mean, &mean, 1e-10));
        prop_assert!(close(&reversed_variance, &variance, 1e-10));
    }

    #[test]
    fn a_repeated_row_counts_as_half_its_noise(case in case()) {
        let n = case.y.len();
        let twice = |i: usize| i % n;
        let x = Mat::from_fn(2 * n, case.x.ncols(), |i, j| case.x[(twice(i), j)]);
        let y: Vec<f64> = (0..2 * n).map(|i| case.y[twice(i)]).collect();
        let double = Gp::builder(case.kernel()).noise_variance(2.0 * NOISE_VARIANCE).condition(x.as_ref(), &y).unwrap();
        let (mean, variance) = case.gp().predict(case.x_star.as_ref()).unwrap();
        let (double_mean, double_variance) = double.predict(case.x_star.as_ref()).unwrap();
        prop_assert!(close(&double_mean, &mean, 1e-9));
        prop_assert!(close(&double_variance, &variance, 1e-9));
    }

    #[test]
    fn leaving_one_out_equals_fitting_without_it(case in case()) {
        let n = case.y.len();
        if n > 1 {
            let gp = case.gp();
            let left_out = gp.leave_one_out().unwrap();
            let x = case.x.subrows(1, n - 1);
            let rest = Gp::builder(case.kernel()).noise_variance(NOISE_VARIANCE).condition(x, &case.y[1..]);
            let first = case.x.subrows(0, 1);
            let (mean, variance) = rest.unwrap().predict_observation(first).unwrap();
            prop_assert!(close(&left_out.mean[..1], &mean, 1e-9));
            prop_assert!(close(&left_out.variance[..1], &variance, 1e-9));
        }
    }

    #[test]
    fn a_saved_model_predicts_the_same_bits(case in case()) {
        let gp = case.gp();
        let text = serde_json::to_string(&gp.to_model().unwrap()).unwrap();
        let model: GpModel = serde_json::from_str(&text).unwrap();
        let loaded = Gp::from_model(&model).unwrap();
        let x_star = case.x_star.as_ref();
        prop_assert_eq!(bits(gp.predict(x_star).unwrap()), bits(loaded.predict(x_star).unwrap()));
        prop_assert_eq!(
            gp.log_marginal_likelihood().to_bits(),
            loaded.log_marginal_likelihood().to_bits()
        );
    }
}

fn bits((mean, variance): (Vec<f64>, Vec<f64>)) -> Vec<u64> {
    mean.iter().chain(&variance).map(|value| value.to_bits()).collect()
}

fn row(x: &Mat<f64>, i: usize) -> Vec<f64> {
    (0..x.ncols()).map(|d| x[(i, d)]).collect()
}

#[test]
fn one_row_without_noise_is_interpolated_and_forgotten_far_away() {
    let x = Mat::from_fn(1, 1, |_, _| 0.5);
    let kernel = SquaredExponential::new(&[0.3], 2.0).unwrap();
    let mean = Mean::Fixed(1.0);
    let gp =
        Gp::builder(kernel).noise_variance(0.0).mean(mean).condition(x.as_ref(), &[4.0]).unwrap();
    let x_star = Mat::from_fn(2, 1, |i, _| [0.5, 50.0][i]);
    let (mean, variance) = gp.predict(x_star.as_ref()).unwrap();
    assert!((mean[0] - 4.0).abs() < 1e-14 && variance[0] < 1e-14);
    assert_eq!((mean[1], variance[1]), (1.0, 2.0));
}

#[test]
fn equal_outputs_are_predicted_everywhere() {
    let x = Mat::from_fn(6, 2, |i, d| (i * (d + 1)) as f64);
    let gp = Gp::builder(SquaredExponential::unit(2).unwrap())
        .noise_variance(0.1)
        .condition(x.as_ref(), &[7.5; 6])
        .unwrap();
    let x_star = Mat::from_fn(3, 2, |i, _| i as f64 - 20.0);
    assert_eq!(gp.predict_mean(x_star.as_ref()).unwrap(), vec![7.5; 3]);
}

#[test]
fn many_test_rows_equal_single_ones_for_any_number_of_threads() {
    let x = Mat::from_fn(30, 1, |i, _| 0.2 * i as f64);
    let y: Vec<f64> = (0..30).map(|i| (0.2 * i as f64).sin()).collect();
    let gp = Gp::builder(SquaredExponential::unit(1).unwrap())
        .noise_variance(1e-3)
        .condition(x.as_ref(), &y)
        .unwrap();
    let x_star = Mat::from_fn(300, 1, |i, _| 0.02 * i as f64);
    let with_threads = |n: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        bits(pool.install(|| gp.predict(x_star.as_ref()).unwrap()))
    };
    assert_eq!(with_threads(1), with_threads(3));
    let (mean, variance) = gp.predict(x_star.as_ref()).unwrap();
    for i in [0, 63, 64, 299] {
        let (one_mean, one_variance) = gp.predict(x_star.subrows(i, 1)).unwrap();
        assert!((one_mean[0] - mean[i]).abs() < 1e-13);
        assert!((one_variance[0] - variance[i]).abs() < 1e-13);
    }
}

#[test]
fn samples_have_the_mean_and_covariance_of_the_posterior() {
    let x = Mat::from_fn(3, 1, |i, _| i as f64);
    let gp = Gp::builder(SquaredExponential::unit(1).unwrap())
        .noise_variance(0.1)
        .condition(x.as_ref(), &[0.0, 1.0, 0.5]);
    let x_star = Mat::from_fn(3, 1, |i, _| 0.5 + i as f64);
    let joint = gp.unwrap().predict_joint(x_star.as_ref()).unwrap();
    let n = 20_000;
    let samples = joint.sample(n, 3).unwrap();
    let average = |f: &dyn Fn(usize) -> f64| (0..n).map(f).sum::<f64>() / n as f64;
    for i in 0..3 {
        let mean = average(&|s| samples[(i, s)]);
        let error = (joint.covariance()[(i, i)] / n as f64).sqrt();
        assert!((mean - joint.mean()[i]).abs() < 4.0 * error);
        for j in 0..3 {
            let centered = |k: usize, s: usize| samples[(k, s)] - joint.mean()[k];
            let covariance = average(&|s| centered(i, s) * centered(j, s));
            let scale = (joint.covariance()[(i, i)] * joint.covariance()[(j, j)]).sqrt();
            let error = scale * (2.0 / n as f64).sqrt();
            assert!((covariance - joint.covariance()[(i, j)]).abs() < 4.0 * error);
        }
    }
}

#[test]
fn prior_samples_are_seeded_and_smooth_although_their_covariance_is_singular() {
    let x = Mat::from_fn(200, 1, |i, _| 0.01 * i as f64);
    let kernel = SquaredExponential::new(&[0.5], 1.0).unwrap();
    let prior = JointGaussian::prior(&kernel, x.as_ref()).unwrap();
    let (few, many) = (prior.sample(1, 9).unwrap(), prior.sample(3, 9).unwrap());
    assert_eq!(few.col(0), many.col(0));
    assert_ne!(few.col(0), prior.sample(1, 10).unwrap().col(0));
    let step = |i: usize| (many[(i + 1, 1)] - many[(i, 1)]).abs();
    assert!((0..199).map(step).fold(0.0, f64::max) < 0.1);
}

#[test]
fn samples_of_a_periodic_product_nearly_repeat() {
    let x = Mat::from_fn(121, 1, |i, _| 0.05 * i as f64);
    let slow = SquaredExponential::new(&[50.0], 1.0).unwrap();
    let kernel = slow * Periodic::new(2.0, 1.0);
    let samples = JointGaussian::prior(&kernel, x.as_ref()).unwrap().sample(4, 1).unwrap();
    for s in 0..4 {
        let difference = (0..81).map(|i| (samples[(i, s)] - samples[(i + 40, s)]).abs());
        assert!(difference.fold(0.0, f64::max) < 0.25);
        let spread = (0..40).map(|i| (samples[(i, s)] - samples[(0, s)]).abs());
        assert!(spread.fold(0.0, f64::max) > 0.5);
    }
}

#[test]
fn predictions_in_memory_that_is_there_are_the_same_bits() {
    let x = Mat::from_fn(30, 1, |i, _| 0.2 * i as f64);
    let y: Vec<f64> = (0..30).map(|i| (0.2 * i as f64).sin()).collect();
    let gp = Gp::builder(SquaredExponential::unit(1).unwrap())
        .noise_variance(1e-3)
        .condition(x.as_ref(), &y)
        .unwrap();
    let mut workspace = Workspace::new();
    for n in [1, 1000, 7] {
        let x_star = Mat::from_fn(n, 1, |i, _| 0.01 * i as f64);
        let (mut mean, mut variance) = (vec![f64::NAN; n], vec![f64::NAN; n]);
        gp.predict_into(x_star.as_ref(), &mut workspace, &mut mean, &mut variance).unwrap();
        assert_eq!(bits((mean, variance)), bits(gp.predict(x_star.as_ref()).unwrap()));
    }
    let mut one = [0.0];
    let error = gp.predict_into(x.subrows(0, 2), &mut workspace, &mut one, &mut [0.0; 2]);
    assert!(matches!(error, Err(GpError::ShapeMismatch { .. })), "{error:?}");
}
