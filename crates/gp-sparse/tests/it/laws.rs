//! Laws of the sparse processes, on random data.

use faer::linalg::solvers::{Llt, Solve};
use faer::{Mat, Side};
use gp_core::{
    Gp, GpError, Kernel, Matern32, Matern52, Mean, Periodic, Posterior, SquaredExponential,
    Workspace,
};
use gp_sparse::{Approximation, SparseGp, SparseGpModel, SparseSettings};
use proptest::collection::vec;
use proptest::prelude::{ProptestConfig, Strategy, prop_assert, prop_assert_eq, proptest};

const ALL: [Approximation; 4] = [
    Approximation::Fitc,
    Approximation::Vfe,
    Approximation::Dtc,
    Approximation::PowerEp { alpha: 0.4 },
];
const NOISE_VARIANCE: f64 = 0.05;
const SIGNAL_VARIANCE: f64 = 1.7;

#[derive(Clone, Debug)]
struct Case {
    x: Mat<f64>,
    y: Vec<f64>,
    z: Mat<f64>,
    x_star: Mat<f64>,
    lengthscales: Vec<f64>,
}

impl Case {
    fn kernel(&self) -> SquaredExponential {
        SquaredExponential::new(&self.lengthscales, SIGNAL_VARIANCE).unwrap()
    }

    fn fit(&self, approximation: Approximation) -> SparseGp {
        self.fit_rows(self.x.as_ref(), &self.y, approximation)
    }

    /// Rows at least 0.8 lengthscales apart, so that K_uu without jitter keeps nine digits.
    fn spaced_rows(&self) -> (Mat<f64>, Vec<f64>) {
        let distance = |i: usize, j: usize| -> f64 {
            let scaled =
                |d: usize| ((self.x[(i, d)] - self.x[(j, d)]) / self.lengthscales[d]).powi(2);
            (0..self.x.ncols()).map(scaled).sum::<f64>().sqrt()
        };
        let mut kept: Vec<usize> = Vec::new();
        for i in 0..self.y.len() {
            if kept.iter().all(|&j| distance(i, j) > 0.8) {
                kept.push(i);
            }
        }
        let x = Mat::from_fn(kept.len(), self.x.ncols(), |i, d| self.x[(kept[i], d)]);
        (x, kept.iter().map(|&i| self.y[i]).collect())
    }

    fn fit_rows(
        &self,
        x: faer::MatRef<'_, f64>,
        y: &[f64],
        approximation: Approximation,
    ) -> SparseGp {
        let settings = settings(approximation);
        SparseGp::fit(self.kernel(), x, y, self.z.as_ref(), NOISE_VARIANCE, settings).unwrap()
    }
}

fn settings(approximation: Approximation) -> SparseSettings {
    SparseSettings { approximation, ..SparseSettings::default() }
}

/// Up to 30 rows and 12 pseudo-inputs: fewer, as many, and more than rows.
fn case() -> impl Strategy<Value = Case> {
    (1_usize..4, 1_usize..31, 1_usize..13).prop_flat_map(|(d, n, m)| {
        let matrix = move |rows: usize| {
            vec(-2.0..2.0, rows * d)
                .prop_map(move |entries| Mat::from_fn(rows, d, |i, j| entries[i * d + j]))
        };
        (matrix(n), vec(-3.0..3.0, n), matrix(m), matrix(5), vec(0.3..3.0, d))
            .prop_map(|(x, y, z, x_star, lengthscales)| Case { x, y, z, x_star, lengthscales })
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
        for approximation in ALL {
            let settings = SparseSettings { mean: Mean::Fixed(0.4), ..settings(approximation) };
            let (x, z) = (case.x.as_ref(), case.z.as_ref());
            let gp = SparseGp::fit(case.kernel(), x, &case.y, z, NOISE_VARIANCE, settings).unwrap();
            let (_, variance) = gp.predict(case.x_star.as_ref()).unwrap();
            let prior = SIGNAL_VARIANCE * (1.0 + 1e-12);
            prop_assert!(variance.iter().all(|variance| (0.0..=prior).contains(variance)));
        }
    }

    #[test]
    fn the_joint_covariance_is_positive_and_has_the_variances(case in case()) {
        for approximation in ALL {
            let gp = case.fit(approximation);
            let joint = gp.predict_joint(case.x_star.as_ref()).unwrap();
            let (mean, variance) = gp.predict(case.x_star.as_ref()).unwrap();
            prop_assert!(close(joint.mean(), &mean, 1e-13));
            let mut covariance = joint.covariance().to_owned();
            for (i, variance) in variance.iter().enumerate() {
                prop_assert!((covariance[(i, i)] - variance).abs() < 1e-8);
                covariance[(i, i)] += 1e-7;
            }
            prop_assert!(Llt::new(covariance.as_ref(), Side::Lower).is_ok());
        }
    }

    #[test]
    fn gradients_equal_finite_differences(case in case()) {
        let d = case.lengthscales.len();
        let product = case.kernel() * Periodic::ard(&vec![1.3; d], &vec![0.9; d]);
        let kernels: [Box<dyn Kernel>; 4] = [
            Box::new(case.kernel()),
            Box::new(Matern32::new(&case.lengthscales, 0.8).unwrap()),
            Box::new(Matern52::new(&case.lengthscales, 0.8).unwrap()),
            Box::new(product),
        ];
        for (kernel, approximation) in kernels.iter().zip(ALL) {
            let values: Vec<f64> = kernel.parameters().iter().map(|p| p.value).collect();
            // A jitter that keeps rounding out of the differences; its own slope is in them.
            let settings = SparseSettings { jitter: 1e-3, ..settings(approximation) };
            let fit = |values: &[f64], noise_variance: f64, z: &Mat<f64>| {
                let moved = kernel.with_parameters(values).unwrap();
                let x = case.x.as_ref();
                SparseGp::fit(moved, x, &case.y, z.as_ref(), noise_variance, settings).unwrap()
            };
            let gp = fit(&values, NOISE_VARIANCE, &case.z);
            let (value, gradient) = gp.objective_and_gradient(case.x.as_ref(), &case.y).unwrap();
            prop_assert_eq!(value, gp.objective());
            let moved = |index: usize, h: f64| {
                let (mut values, mut noise, mut z) =
                    (values.clone(), NOISE_VARIANCE, case.z.clone());
                if index < values.len() {
                    values[index] *= h.exp();
                } else if index == values.len() {
                    noise *= h.exp();
                } else {
                    let entry = index - values.len() - 1;
                    z[(entry / d, entry % d)] += h;
                }
                fit(&values, noise, &z).objective()
            };
            for (index, slope) in gradient.iter().enumerate() {
                let h = 1e-4;
                let near = moved(index, h) - moved(index, -h);
                let far = moved(index, 2.0 * h) - moved(index, -2.0 * h);
                let expected = (8.0 * near - far) / (12.0 * h);
                let tolerance = 1e-6 * (1.0 + value.abs() + slope.abs());
                prop_assert!((slope - expected).abs() < tolerance, "{index} {slope} {expected}");
            }
        }
    }

    #[test]
    fn a_learnt_mean_is_as_unsure_as_with_that_covariance_of_the_data(case in case()) {
        let known = |z: &Mat<f64>, x: &Mat<f64>| {
            gp_core::cross(&case.kernel(), z.as_ref(), x.as_ref()).unwrap()
        };
        let mut prior = known(&case.z, &case.z);
        (0..prior.nrows()).for_each(|a| prior[(a, a)] *= 1.0 + 1e-4);
        let prior = Llt::new(prior.as_ref(), Side::Lower).unwrap();
        let (of_x, of_star) = (known(&case.z, &case.x), known(&case.z, &case.x_star));
        let (q, q_star) = (of_x.transpose() * prior.solve(&of_x), of_x.transpose() * prior.solve(&of_star));
        for approximation in ALL {
            let jitter = 1e-4;
            let fit = |mean| {
                let settings = SparseSettings { mean, jitter, ..settings(approximation) };
                let (x, z) = (case.x.as_ref(), case.z.as_ref());
                SparseGp::fit(case.kernel(), x, &case.y, z, NOISE_VARIANCE, settings).unwrap()
            };
            let (learnt, about_zero) = (fit(Mean::Estimated), fit(Mean::Fixed(0.0)));
            let mut covariance = q.clone();
            for i in 0..case.y.len() {
                covariance[(i, i)] +=
                    NOISE_VARIANCE + approximation.alpha() * (SIGNAL_VARIANCE - q[(i, i)]).max(0.0);
            }
            let precision = Llt::new(covariance.as_ref(), Side::Lower).unwrap();
            let of_one = precision.solve(&Mat::full(case.y.len(), 1, 1.0));
            let told = of_one.sum();
            let joint = learnt.predict_joint(case.x_star.as_ref()).unwrap();
            let (known, plain) = (
                about_zero.predict_joint(case.x_star.as_ref()).unwrap(),
                learnt.predict(case.x_star.as_ref()).unwrap().1,
            );
            let rest = q_star.transpose() * &of_one;
            let moved = |s: usize| (1.0 - rest[(s, 0)]) / told.sqrt();
            for (s, plain) in plain.iter().enumerate() {
                let found = joint.covariance()[(s, s)];
                prop_assert!((found - plain).abs() < 1e-9 * (1.0 + plain));
                for t in 0..5 {
                    let found = joint.covariance()[(s, t)] - known.covariance()[(s, t)];
                    let expected = moved(s) * moved(t);
                    prop_assert!((found - expected).abs() < 1e-7 * (1.0 + expected.abs()));
                }
            }
        }
    }

    #[test]
    fn with_pseudo_inputs_at_the_data_it_is_the_exact_process(case in case()) {
        let (x, y) = case.spaced_rows();
        let exact = Gp::builder(case.kernel()).noise_variance(NOISE_VARIANCE).condition(x.as_ref(), &y).unwrap();
        let (mean, variance) = exact.predict(case.x_star.as_ref()).unwrap();
        for approximation in ALL {
            let settings = SparseSettings { jitter: 0.0, ..settings(approximation) };
            let (x, y) = (x.as_ref(), &y);
            let sparse = SparseGp::fit(case.kernel(), x, y, x, NOISE_VARIANCE, settings).unwrap();
            let (sparse_mean, sparse_variance) = sparse.predict(case.x_star.as_ref()).unwrap();
            prop_assert!(close(&sparse_mean, &mean, 1e-9));
            prop_assert!(close(&sparse_variance, &variance, 1e-9));
            let likelihood = exact.log_marginal_likelihood();
            prop_assert!(close(&[sparse.objective()], &[likelihood], 1e-9));
            prop_assert!(close(&[sparse.mean()], &[exact.mean()], 1e-9));
        }
    }

    #[test]
    fn the_variational_objective_is_a_lower_bound(case in case()) {
        let exact = Gp::builder(case.kernel()).noise_variance(NOISE_VARIANCE).condition(case.x.as_ref(), &case.y).unwrap();
        // With a common mean, since each process estimates its own.
        let mean = Mean::Fixed(exact.mean());
        let settings = SparseSettings { mean, ..settings(Approximation::Vfe) };
        let (x, z) = (case.x.as_ref(), case.z.as_ref());
        let sparse = SparseGp::fit(case.kernel(), x, &case.y, z, NOISE_VARIANCE, settings).unwrap();
        prop_assert!(sparse.objective() <= exact.log_marginal_likelihood() + 1e-7);
    }

    #[test]
    fn one_more_pseudo_input_never_lowers_the_bound(case in case()) {
        let settings =
            SparseSettings { mean: Mean::Fixed(0.3), ..settings(Approximation::Vfe) };
        let bound = |z: faer::MatRef<'_, f64>| {
            let x = case.x.as_ref();
            SparseGp::fit(case.kernel(), x, &case.y, z, NOISE_VARIANCE, settings)
                .unwrap()
                .objective()
        };
        let bounds: Vec<f64> =
            (1..=case.z.nrows()).map(|m| bound(case.z.subrows(0, m))).collect();
        prop_assert!(bounds.windows(2).all(|pair| pair[1] >= pair[0] - 1e-7), "{bounds:?}");
    }

    #[test]
    fn power_ep_goes_from_one_end_to_the_other(case in case()) {
        let value = |approximation| case.fit(approximation).objective();
        let near = |alpha| value(Approximation::PowerEp { alpha });
        prop_assert!(close(&[near(1.0)], &[value(Approximation::Fitc)], 1e-12));
        prop_assert!(close(&[near(1e-9)], &[value(Approximation::Vfe)], 1e-5));
    }

    #[test]
    fn the_order_of_rows_does_not_matter(case in case()) {
        let n = case.y.len();
        let x = Mat::from_fn(n, case.x.ncols(), |i, j| case.x[(n - 1 - i, j)]);
        let y: Vec<f64> = case.y.iter().rev().copied().collect();
        for approximation in ALL {
            let (gp, reversed) =
                (case.fit(approximation), case.fit_rows(x.as_ref(), &y, approximation));
            let (mean, variance) = gp.predict(case.x_star.as_ref()).unwrap();
            let (other_mean, other_variance) = reversed.predict(case.x_star.as_ref()).unwrap();
            prop_assert!(close(&other_mean, &mean, 1e-7));
            prop_assert!(close(&other_variance, &variance, 1e-7));
        }
    }

    #[test]
    fn a_repeated_row_counts_as_half_its_noise(case in case()) {
        // Not so for `Fitc`, whose leftover variance repeats as if it were noise.
        let n = case.y.len();
        let x = Mat::from_fn(2 * n, case.x.ncols(), |i, j| case.x[(i % n, j)]);
        let y: Vec<f64> = (0..2 * n).map(|i| case.y[i % n]).collect();
        let (settings, z) = (settings(Approximation::Vfe), case.z.as_ref());
        let twice =
            SparseGp::fit(case.kernel(), x.as_ref(), &y, z, 2.0 * NOISE_VARIANCE, settings);
        let (mean, variance) =
            case.fit(Approximation::Vfe).predict(case.x_star.as_ref()).unwrap();
        let (other_mean, other_variance) = twice.unwrap().predict(case.x_star.as_ref()).unwrap();
        prop_assert!(close(&other_mean, &mean, 1e-7));
        prop_assert!(close(&other_variance, &variance, 1e-7));
    }

    #[test]
    fn a_saved_model_predicts_the_same_bits(case in case()) {
        for approximation in ALL {
            let gp = case.fit(approximation);
            let text = serde_json::to_string(&gp.to_model().unwrap()).unwrap();
            let model: SparseGpModel = serde_json::from_str(&text).unwrap();
            let loaded = SparseGp::from_model(&model).unwrap();
            let x_star = case.x_star.as_ref();
            prop_assert_eq!(bits(gp.predict(x_star).unwrap()), bits(loaded.predict(x_star).unwrap()));
            prop_assert_eq!(gp.to_model().unwrap(), loaded.to_model().unwrap());
        }
    }
}

fn bits((mean, variance): (Vec<f64>, Vec<f64>)) -> Vec<u64> {
    mean.iter().chain(&variance).map(|value| value.to_bits()).collect()
}

#[test]
fn equal_outputs_are_predicted_everywhere() {
    let x = Mat::from_fn(300, 2, |i, d| ((i * (d + 3)) % 17) as f64);
    let z = Mat::from_fn(5, 2, |i, d| (i + d) as f64);
    for approximation in ALL {
        let kernel = SquaredExponential::unit(2).unwrap();
        let (settings, y) = (settings(approximation), [7.5; 300]);
        let gp = SparseGp::fit(kernel, x.as_ref(), &y, z.as_ref(), 0.1, settings).unwrap();
        assert!(close(&gp.predict_mean(z.as_ref()).unwrap(), &[7.5; 5], 1e-13));
    }
}

/// One row, one pseudo-input on it: the exact process on that row, whose mean is its output.
#[test]
fn a_single_row_is_remembered_there_and_forgotten_far_away() {
    let x = Mat::from_fn(1, 2, |_, d| d as f64);
    let x_star = Mat::from_fn(2, 2, |i, d| (100 * i + d) as f64);
    for approximation in ALL {
        let kernel = SquaredExponential::new(&[1.0; 2], SIGNAL_VARIANCE).unwrap();
        let settings = settings(approximation);
        let noise = NOISE_VARIANCE;
        let gp = SparseGp::fit(kernel, x.as_ref(), &[3.0], x.as_ref(), noise, settings).unwrap();
        let (mean, variance) = gp.predict(x_star.as_ref()).unwrap();
        let posterior = SIGNAL_VARIANCE * noise / (SIGNAL_VARIANCE + noise);
        assert!(close(&mean, &[3.0; 2], 1e-12), "{mean:?}");
        // On the row the mean adds what it leaves of the noise, and far away what it knows itself.
        let (known, open) = (SIGNAL_VARIANCE + noise, noise / (SIGNAL_VARIANCE + noise));
        let expected = [posterior + open * open * known, SIGNAL_VARIANCE + known];
        assert!(close(&variance, &expected, 1e-6), "{variance:?}");
        let (value, gradient) = gp.objective_and_gradient(x.as_ref(), &[3.0]).unwrap();
        assert!(value.is_finite() && gradient.iter().all(|slope| slope.is_finite()));
    }
}

#[test]
fn far_offsets_of_the_outputs_cost_no_digits() {
    let x = Mat::from_fn(60, 1, |i, _| 0.1 * i as f64);
    let z = Mat::from_fn(8, 1, |i, _| 0.75 * i as f64);
    let fit = |offset: f64| {
        let y: Vec<f64> = (0..60).map(|i| (0.1 * i as f64).sin() + offset).collect();
        let kernel = SquaredExponential::unit(1).unwrap();
        SparseGp::fit(kernel, x.as_ref(), &y, z.as_ref(), 1e-2, SparseSettings::default()).unwrap()
    };
    let (near, far) = (fit(0.0), fit(1e6));
    assert!((near.objective() - far.objective()).abs() < 1e-6);
    assert!((near.mean() + 1e6 - far.mean()).abs() < 1e-8);
}

#[test]
fn collinear_inputs_in_32_dimensions_are_fitted() {
    let x = Mat::from_fn(50, 32, |i, d| 0.1 * (i * (d + 1)) as f64);
    let y: Vec<f64> = (0..50).map(|i| (0.2 * i as f64).sin()).collect();
    let kernel = SquaredExponential::new(&[100.0; 32], 1.0).unwrap();
    let z = x.subrows(0, 20);
    let gp = SparseGp::fit(kernel, x.as_ref(), &y, z, 1e-3, SparseSettings::default()).unwrap();
    let (value, gradient) = gp.objective_and_gradient(x.as_ref(), &y).unwrap();
    assert!(value.is_finite() && gradient.iter().all(|slope| slope.is_finite()));
    assert_eq!(gradient.len(), 32 + 1 + 1 + 20 * 32);
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let x = Mat::from_fn(1000, 1, |i, _| 0.01 * i as f64);
    let y: Vec<f64> = (0..1000).map(|i| (0.01 * i as f64).sin()).collect();
    let z = Mat::from_fn(10, 1, |i, _| i as f64);
    let run = |n: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        pool.install(|| {
            let kernel = SquaredExponential::unit(1).unwrap();
            let settings = SparseSettings::default();
            let gp = SparseGp::fit(kernel, x.as_ref(), &y, z.as_ref(), 0.1, settings).unwrap();
            let (_, gradient) = gp.objective_and_gradient(x.as_ref(), &y).unwrap();
            let (mean, variance) = gp.predict(x.as_ref()).unwrap();
            bits((gradient, [mean, variance].concat()))
        })
    };
    assert_eq!(run(1), run(3));
}

#[test]
fn predictions_in_memory_that_is_there_are_the_same_bits() {
    let x = Mat::from_fn(30, 1, |i, _| 0.2 * i as f64);
    let y: Vec<f64> = (0..30).map(|i| (0.2 * i as f64).sin()).collect();
    let (kernel, z) = (SquaredExponential::unit(1).unwrap(), x.subrows(0, 9));
    let gp = SparseGp::fit(kernel, x.as_ref(), &y, z, 1e-3, SparseSettings::default()).unwrap();
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
