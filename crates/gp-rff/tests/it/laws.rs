//! Laws of random features and of the regression on them.

use faer::linalg::solvers::Llt;
use faer::{Mat, MatRef, Side};
use gp_core::{BayesianLinear, Gp, GpError, Mean, Posterior, SquaredExponential, Workspace, gram};
use gp_rff::{
    FeatureOptions, Form, RandomFeatures, RffGp, RffGpModel, Sampling, Spectrum,
    SufficientStatistics,
};
use proptest::collection::vec;
use proptest::prelude::{ProptestConfig, Strategy, prop_assert, prop_assert_eq, proptest};

const FORMS: [Form; 2] = [Form::Cosines, Form::Paired];
const SAMPLINGS: [Sampling; 3] =
    [Sampling::Independent, Sampling::Orthogonal, Sampling::LowDiscrepancy];
const SPECTRA: [Spectrum; 3] =
    [Spectrum::SquaredExponential, Spectrum::Matern32, Spectrum::Matern52];
const SIGNAL_VARIANCE: f64 = 1.7;
const NOISE_VARIANCE: f64 = 0.05;

#[derive(Clone, Debug)]
struct Case {
    x: Mat<f64>,
    y: Vec<f64>,
    x_star: Mat<f64>,
    lengthscales: Vec<f64>,
    form: Form,
    sampling: Sampling,
    spectrum: Spectrum,
}

impl Case {
    fn features(&self, n_features: usize) -> RandomFeatures {
        let (form, sampling) = (self.form, self.sampling);
        let options = FeatureOptions { n_features, form, sampling, seed: 3 };
        RandomFeatures::new(self.spectrum, &self.lengthscales, options).unwrap()
    }

    fn gp(&self) -> RffGp {
        let (features, x) = (self.features(20), self.x.as_ref());
        RffGp::fit(features, x, &self.y, SIGNAL_VARIANCE, NOISE_VARIANCE).unwrap()
    }
}

/// Fewer, as many, and more rows than features.
fn case() -> impl Strategy<Value = Case> {
    let kinds = (0_usize..2, 0_usize..3, 0_usize..3);
    (1_usize..4, 1_usize..41, kinds).prop_flat_map(|(d, n, (form, sampling, spectrum))| {
        let matrix = move |rows: usize| {
            vec(-2.0..2.0, rows * d)
                .prop_map(move |entries| Mat::from_fn(rows, d, |i, j| entries[i * d + j]))
        };
        (matrix(n), vec(-3.0..3.0, n), matrix(5), vec(0.3..3.0, d)).prop_map(
            move |(x, y, x_star, lengthscales)| Case {
                x,
                y,
                x_star,
                lengthscales,
                form: FORMS[form],
                sampling: SAMPLINGS[sampling],
                spectrum: SPECTRA[spectrum],
            },
        )
    })
}

fn close(actual: &[f64], expected: &[f64], tolerance: f64) -> bool {
    actual.len() == expected.len()
        && actual.iter().zip(expected).all(|(a, b)| (a - b).abs() <= tolerance * (1.0 + b.abs()))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn it_is_bayesian_linear_regression_on_its_features(case in case()) {
        let phi = case.gp().features().evaluate(case.x.as_ref()).unwrap();
        let phi_star = case.gp().features().evaluate(case.x_star.as_ref()).unwrap();
        let m = phi.ncols();
        let prior = Mat::<f64>::identity(m, m) * SIGNAL_VARIANCE;
        let linear =
            BayesianLinear::fit(phi.as_ref(), &case.y, prior.as_ref(), NOISE_VARIANCE).unwrap();
        let mut statistics = SufficientStatistics::new(&case.features(20), 0.0).unwrap();
        statistics.update(&case.features(20), case.x.as_ref(), &case.y).unwrap();
        let (features, mean) = (case.features(20), Mean::Fixed(0.0));
        let gp =
            RffGp::from_statistics(features, statistics, SIGNAL_VARIANCE, NOISE_VARIANCE, mean)
                .unwrap();
        prop_assert!(close(&[gp.log_evidence()], &[linear.log_evidence()], 1e-10));
        let (mean, variance) = gp.predict(case.x_star.as_ref()).unwrap();
        let (expected_mean, expected_variance) = linear.predict(phi_star.as_ref()).unwrap();
        prop_assert!(close(&mean, &expected_mean, 1e-10));
        prop_assert!(close(&variance, &expected_variance, 1e-10));
    }

    #[test]
    fn a_learnt_mean_is_one_more_feature_of_which_nothing_is_known(case in case()) {
        let gp = case.gp();
        let with_one = |x: &Mat<f64>| {
            let phi = gp.features().evaluate(x.as_ref()).unwrap();
            Mat::from_fn(x.nrows(), 21, |i, j| if j < 20 { phi[(i, j)] } else { 1.0 })
        };
        let off = |wide: f64| {
            let variance = |j: usize| if j < 20 { SIGNAL_VARIANCE } else { wide };
            let prior = Mat::from_fn(21, 21, |i, j| if i == j { variance(j) } else { 0.0 });
            let phi = with_one(&case.x);
            let linear = BayesianLinear::fit(phi.as_ref(), &case.y, prior.as_ref(), NOISE_VARIANCE);
            let linear = linear.unwrap();
            let expected = linear.predict_joint(with_one(&case.x_star).as_ref()).unwrap();
            let joint = gp.predict_joint(case.x_star.as_ref()).unwrap();
            let scale = 1.0 + expected.covariance().norm_max();
            let means = joint.mean().iter().zip(expected.mean()).map(|(a, b)| (a - b).abs());
            let touched = (std::f64::consts::TAU * wide * case.y.len() as f64).ln();
            let evidence = linear.log_evidence() + 0.5 * touched - gp.log_evidence();
            [
                means.fold(0.0, f64::max) / scale,
                (joint.covariance() - expected.covariance()).norm_max() / scale,
                evidence.abs(),
            ]
        };
        let [narrow, wide] = [1e3, 1e6].map(off);
        for (narrow, wide) in narrow.iter().zip(&wide) {
            prop_assert!(*wide < 0.01 * narrow + 1e-7 && *wide < 1e-3, "{narrow} {wide}");
        }
    }

    #[test]
    fn posterior_variance_lies_between_zero_and_the_prior(case in case()) {
        let mut statistics = SufficientStatistics::new(&case.features(20), 0.0).unwrap();
        statistics.update(&case.features(20), case.x.as_ref(), &case.y).unwrap();
        let (features, mean) = (case.features(20), Mean::Fixed(0.4));
        let gp =
            RffGp::from_statistics(features, statistics, SIGNAL_VARIANCE, NOISE_VARIANCE, mean);
        let (_, variance) = gp.unwrap().predict(case.x_star.as_ref()).unwrap();
        let phi = case.gp().features().evaluate(case.x_star.as_ref()).unwrap();
        for (i, variance) in variance.iter().enumerate() {
            let square: f64 = (0..phi.ncols()).map(|j| phi[(i, j)].powi(2)).sum();
            let prior = SIGNAL_VARIANCE * square;
            prop_assert!((0.0..=prior * (1.0 + 1e-12)).contains(variance));
        }
    }

    #[test]
    fn the_joint_covariance_is_positive_and_has_the_variances(case in case()) {
        let joint = case.gp().predict_joint(case.x_star.as_ref()).unwrap();
        let (mean, variance) = case.gp().predict(case.x_star.as_ref()).unwrap();
        prop_assert!(close(joint.mean(), &mean, 1e-12));
        prop_assert!(close(&case.gp().predict_mean(case.x_star.as_ref()).unwrap(), &mean, 1e-12));
        let mut covariance = joint.covariance().to_owned();
        for (i, variance) in variance.iter().enumerate() {
            prop_assert!((covariance[(i, i)] - variance).abs() < 1e-12);
            covariance[(i, i)] += 1e-9;
        }
        prop_assert!(Llt::new(covariance.as_ref(), Side::Lower).is_ok());
    }

    #[test]
    fn evidence_gradients_equal_finite_differences(case in case()) {
        let gp = case.gp();
        let gradient = gp.log_evidence_gradient(case.x.as_ref(), &case.y).unwrap();
        let d = case.lengthscales.len();
        let moved = |index: usize, h: f64| {
            let mut values = case.lengthscales.clone();
            values.extend([SIGNAL_VARIANCE, NOISE_VARIANCE]);
            values[index] *= h.exp();
            let features = case.features(20).with_lengthscales(&values[..d]).unwrap();
            RffGp::fit(features, case.x.as_ref(), &case.y, values[d], values[d + 1])
                .unwrap()
                .log_evidence()
        };
        for (index, slope) in gradient.iter().enumerate() {
            let h = 1e-4;
            let near = moved(index, h) - moved(index, -h);
            let far = moved(index, 2.0 * h) - moved(index, -2.0 * h);
            let expected = (8.0 * near - far) / (12.0 * h);
            let tolerance = 1e-6 * (1.0 + slope.abs() + gp.log_evidence().abs());
            prop_assert!((slope - expected).abs() < tolerance, "{index} {slope} {expected}");
        }
    }

    #[test]
    fn however_rows_are_split_the_result_is_the_same_to_rounding(
        case in case(),
        cut in 0.0..1.0,
    ) {
        let (n, features) = (case.y.len(), case.features(10));
        let cut = (cut * n as f64) as usize;
        let part = |from: usize, to: usize| {
            let mut part = SufficientStatistics::new(&features, 0.5).unwrap();
            if to > from {
                let x = case.x.subrows(from, to - from);
                part.update(&features, x, &case.y[from..to]).unwrap();
            }
            part
        };
        let fit = |statistics| {
            let mean = Mean::Estimated;
            RffGp::from_statistics(features.clone(), statistics, 1.0, 0.1, mean).unwrap()
        };
        let whole = fit(part(0, n));
        let mut merged = part(cut, n);
        merged.merge(&part(0, cut)).unwrap();
        let mut streamed = part(0, 1);
        for i in 1..n {
            streamed.update(&features, case.x.subrows(i, 1), &case.y[i..=i]).unwrap();
        }
        let expected = whole.predict(case.x_star.as_ref()).unwrap();
        for other in [fit(merged), fit(streamed)] {
            prop_assert_eq!(other.statistics().n_rows(), n as u64);
            let (mean, variance) = other.predict(case.x_star.as_ref()).unwrap();
            prop_assert!(close(&mean, &expected.0, 1e-11));
            prop_assert!(close(&variance, &expected.1, 1e-11));
            prop_assert!(close(&[other.log_evidence()], &[whole.log_evidence()], 1e-11));
        }
    }

    #[test]
    fn a_saved_model_predicts_the_same_bits_and_goes_on_learning(case in case()) {
        let gp = case.gp();
        let text = serde_json::to_string(&gp.to_model()).unwrap();
        let model: RffGpModel = serde_json::from_str(&text).unwrap();
        let mut loaded = RffGp::from_model(&model).unwrap();
        let x_star = case.x_star.as_ref();
        prop_assert_eq!(bits(gp.predict(x_star).unwrap()), bits(loaded.predict(x_star).unwrap()));
        let mut gp = gp;
        gp.update(x_star, &[0.5; 5]).unwrap();
        loaded.update(x_star, &[0.5; 5]).unwrap();
        prop_assert_eq!(gp.to_model(), loaded.to_model());
    }

    #[test]
    fn the_order_of_rows_does_not_matter(case in case()) {
        let n = case.y.len();
        let x = Mat::from_fn(n, case.x.ncols(), |i, j| case.x[(n - 1 - i, j)]);
        let y: Vec<f64> = case.y.iter().rev().copied().collect();
        let (features, x) = (case.features(20), x.as_ref());
        let reversed = RffGp::fit(features, x, &y, SIGNAL_VARIANCE, NOISE_VARIANCE).unwrap();
        let (mean, variance) = case.gp().predict(case.x_star.as_ref()).unwrap();
        let (other_mean, other_variance) = reversed.predict(case.x_star.as_ref()).unwrap();
        prop_assert!(close(&other_mean, &mean, 1e-10));
        prop_assert!(close(&other_variance, &variance, 1e-10));
    }

    #[test]
    fn a_repeated_row_counts_as_half_its_noise(case in case()) {
        let n = case.y.len();
        let x = Mat::from_fn(2 * n, case.x.ncols(), |i, j| case.x[(i % n, j)]);
        let y = case.y.repeat(2);
        let fit = |x, y: &[f64], noise_variance| {
            RffGp::fit(case.features(20), x, y, SIGNAL_VARIANCE, noise_variance).unwrap()
        };
        let twice = fit(x.as_ref(), &y, NOISE_VARIANCE);
        let once = fit(case.x.as_ref(), &case.y, 0.5 * NOISE_VARIANCE);
        let (mean, variance) = twice.predict(case.x_star.as_ref()).unwrap();
        let (once_mean, once_variance) = once.predict(case.x_star.as_ref()).unwrap();
        prop_assert!(close(&mean, &once_mean, 1e-10));
        prop_assert!(close(&variance, &once_variance, 1e-10));
    }

    #[test]
    fn an_update_equals_a_fit_to_all_rows(case in case()) {
        let mut gp = case.gp();
        let y_star = [1.0, -1.0, 0.5, 2.0, 0.0];
        gp.update(case.x_star.as_ref(), &y_star).unwrap();
        let (n, d) = (case.y.len(), case.lengthscales.len());
        let x = Mat::from_fn(n + 5, d, |i, j| {
            if i < n { case.x[(i, j)] } else { case.x_star[(i - n, j)] }
        });
        let y = [&case.y[..], &y_star].concat();
        let features = case.features(20);
        let all = RffGp::fit(features, x.as_ref(), &y, SIGNAL_VARIANCE, NOISE_VARIANCE).unwrap();
        let (mean, variance) = gp.predict(case.x.as_ref()).unwrap();
        let (all_mean, all_variance) = all.predict(case.x.as_ref()).unwrap();
        prop_assert!(close(&mean, &all_mean, 1e-10));
        prop_assert!(close(&variance, &all_variance, 1e-10));
    }
}

fn bits((mean, variance): (Vec<f64>, Vec<f64>)) -> Vec<u64> {
    mean.iter().chain(&variance).map(|value| value.to_bits()).collect()
}

/// Root mean squared error of φφᵀ against the kernel over a cloud of points.
fn kernel_error(spectrum: Spectrum, d: usize, options: FeatureOptions) -> f64 {
    let x = cloud(40, d);
    let lengthscales = vec![1.0 + 0.1 * d as f64; d];
    let phi = RandomFeatures::new(spectrum, &lengthscales, options).unwrap().evaluate(x.as_ref());
    let phi = phi.unwrap();
    let exact = gram(&*spectrum.kernel(&lengthscales, 1.0).unwrap(), x.as_ref()).unwrap();
    let difference = &phi * phi.transpose() - exact;
    difference.norm_l2() / 40.0
}

fn cloud(n: usize, d: usize) -> Mat<f64> {
    Mat::from_fn(n, d, |i, j| (1.7 * (i * (j + 2)) as f64 + j as f64).sin() * 1.5)
}

#[test]
fn more_features_come_closer_to_every_kernel_in_every_way() {
    for spectrum in SPECTRA {
        for form in FORMS {
            for sampling in SAMPLINGS {
                let error = |n_features| {
                    let average = |seed| {
                        kernel_error(
                            spectrum,
                            2,
                            FeatureOptions { n_features, form, sampling, seed },
                        )
                    };
                    (0..5).map(average).sum::<f64>() / 5.0
                };
                let (few, many) = (error(32), error(2048));
                // By 1/√M the error would fall by a factor of 8.
                assert!(many < few / 4.0, "{spectrum:?} {form:?} {sampling:?}: {few} {many}");
                assert!(many < 0.03, "{spectrum:?} {form:?} {sampling:?}: {many}");
            }
        }
    }
}

#[test]
fn better_frequencies_need_fewer_features() {
    let error = |form, sampling, d| {
        let average = |seed| {
            let options = FeatureOptions { n_features: 128, form, sampling, seed };
            kernel_error(Spectrum::SquaredExponential, d, options)
        };
        (0..20).map(average).sum::<f64>() / 20.0
    };
    let paired = |sampling, d| error(Form::Paired, sampling, d);
    let ratio = |sampling, d| paired(sampling, d) / paired(Sampling::Independent, d);
    let (even, orthogonal) = (ratio(Sampling::LowDiscrepancy, 2), ratio(Sampling::Orthogonal, 8));
    assert!(even < 0.6 && orthogonal < 0.95, "{even} {orthogonal}");
    let independent = |form| error(form, Sampling::Independent, 2);
    assert!(independent(Form::Paired) < independent(Form::Cosines));
}

#[test]
fn many_features_predict_as_the_exact_process() {
    let x = cloud(60, 2);
    let y: Vec<f64> = (0..60).map(|i| x[(i, 0)].sin() + 0.5 * x[(i, 1)]).collect();
    let options = FeatureOptions { n_features: 1024, ..FeatureOptions::default() };
    let features = RandomFeatures::new(Spectrum::default(), &[1.5, 2.0], options).unwrap();
    let rff = RffGp::fit(features, x.as_ref(), &y, 1.3, 0.01).unwrap();
    let kernel = SquaredExponential::new(&[1.5, 2.0], 1.3).unwrap();
    let exact = Gp::builder(kernel).noise_variance(0.01).condition(x.as_ref(), &y).unwrap();
    let x_star = cloud(75, 2);
    let (mean, variance) = rff.predict(x_star.as_ref()).unwrap();
    let (exact_mean, exact_variance) = exact.predict(x_star.as_ref()).unwrap();
    assert!(close(&mean, &exact_mean, 0.01));
    assert!(close(&variance, &exact_variance, 0.003));
    assert!((rff.log_evidence() - exact.log_marginal_likelihood()).abs() < 1.0);
}

#[test]
fn collinear_and_far_inputs_in_32_dimensions_are_fitted() {
    let x = Mat::from_fn(50, 32, |i, d| 1e7 + 0.1 * (i * (d + 1)) as f64);
    let y: Vec<f64> = (0..50).map(|i| (0.2 * i as f64).sin()).collect();
    let features =
        RandomFeatures::new(Spectrum::default(), &[100.0; 32], FeatureOptions::default()).unwrap();
    let gp = RffGp::fit(features, x.as_ref(), &y, 1.0, 1e-3).unwrap();
    let mean = gp.predict_mean(x.as_ref()).unwrap();
    assert!(mean.iter().zip(&y).all(|(mean, y)| (mean - y).abs() < 0.2), "{mean:?}");
}

#[test]
fn equal_outputs_and_a_single_row_are_predicted_everywhere() {
    for n in [1, 300] {
        let x = cloud(n, 2);
        let options = FeatureOptions::default();
        let features = RandomFeatures::new(Spectrum::default(), &[1.0; 2], options).unwrap();
        let gp = RffGp::fit(features, x.as_ref(), &vec![7.5; n], 1.0, 0.1).unwrap();
        assert!(close(&gp.predict_mean(cloud(9, 2).as_ref()).unwrap(), &[7.5; 9], 1e-13));
    }
}

#[test]
fn results_do_not_depend_on_the_number_of_threads() {
    let x = cloud(3000, 2);
    let y: Vec<f64> = (0..3000).map(|i| x[(i, 0)]).collect();
    let run = |n: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
        let options = FeatureOptions::default();
        let features = RandomFeatures::new(Spectrum::default(), &[1.0; 2], options).unwrap();
        pool.install(|| {
            let gp = RffGp::fit(features, x.as_ref(), &y, 1.0, 0.1).unwrap();
            let gradient = gp.log_evidence_gradient(x.as_ref(), &y).unwrap();
            let (mean, variance) = gp.predict(x.as_ref()).unwrap();
            bits(([mean, gradient].concat(), variance))
        })
    };
    assert_eq!(run(1), run(3));
}

/// A million additions of numbers with digits to lose: compensated sums keep them all.
#[test]
fn a_long_stream_loses_no_digits() {
    let options = FeatureOptions { n_features: 2, ..FeatureOptions::default() };
    let features = RandomFeatures::new(Spectrum::default(), &[1.0], options).unwrap();
    let x = Mat::from_fn(50, 1, |i, _| 0.1 * i as f64);
    let y: Vec<f64> = (0..50).map(|i| (0.1 * i as f64).sin() + 1000.0).collect();
    // With this noise the condition number is N/σₙ² = 50, so that sums show through.
    let fit = |statistics| {
        RffGp::from_statistics(features.clone(), statistics, 1.0, 1e3, Mean::Estimated).unwrap()
    };
    let stream = |rows: usize, times: usize| {
        let mut statistics = SufficientStatistics::new(&features, 1000.0).unwrap();
        let take = |x: MatRef<'_, f64>, y: &[f64], statistics: &mut SufficientStatistics| {
            statistics.update(&features, x, y).unwrap();
        };
        for _ in 0..times {
            for start in (0..50).step_by(rows) {
                take(x.subrows(start, rows), &y[start..start + rows], &mut statistics);
            }
        }
        fit(statistics)
    };
    let (singles, blocks) = (stream(1, 1000), stream(50, 1000));
    assert_eq!(singles.statistics().n_rows(), 50_000);
    let difference = singles.mean() - blocks.mean();
    assert!(difference.abs() < 1e-11, "{difference:e}");
    let relative = singles.log_evidence() / blocks.log_evidence() - 1.0;
    assert!(relative.abs() < 1e-14, "{relative:e}");
}

#[test]
fn predictions_in_memory_that_is_there_are_the_same_bits() {
    let x = Mat::from_fn(30, 1, |i, _| 0.2 * i as f64);
    let y: Vec<f64> = (0..30).map(|i| (0.2 * i as f64).sin()).collect();
    let options = FeatureOptions::default();
    let features = RandomFeatures::new(Spectrum::default(), &[1.0], options).unwrap();
    let gp = RffGp::fit(features, x.as_ref(), &y, 1.0, 1e-3).unwrap();
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
