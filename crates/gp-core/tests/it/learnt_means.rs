//! A learnt mean is integrated out: laws of its uncertainty, brute force, and coverage.

use faer::linalg::solvers::Llt;
use faer::{Mat, Side};
use gp_core::scores::coverage;
use gp_core::{
    Constant, Gp, GpError, HeteroscedasticGp, HeteroscedasticGpModel, JointGaussian, Kernel,
    LearnOptions, Linear, Mean, Posterior, SquaredExponential, StudentTGp, Sum,
};
use proptest::collection::vec;
use proptest::prelude::{ProptestConfig, Strategy, prop_assert, prop_assert_eq, proptest};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

const NOISE_VARIANCE: f64 = 0.05;
const SIGNAL_VARIANCE: f64 = 0.7;
const LEARNT: [Mean; 2] = [Mean::Estimated, Mean::Linear];

fn kernel() -> SquaredExponential {
    SquaredExponential::new(&[0.8, 1.1], SIGNAL_VARIANCE).unwrap()
}

fn fit(x: &Mat<f64>, y: &[f64], mean: Mean) -> Gp {
    Gp::builder(kernel())
        .noise_variance(NOISE_VARIANCE)
        .mean(mean)
        .condition(x.as_ref(), y)
        .unwrap()
}

/// Rows that are never all in a line, and inputs near and far.
#[derive(Clone, Debug)]
struct Case {
    x: Mat<f64>,
    y: Vec<f64>,
    x_star: Mat<f64>,
}

fn case() -> impl Strategy<Value = Case> {
    (4_usize..14).prop_flat_map(|n| {
        let numbers = (vec(-0.3..0.3, 2 * n), vec(-3.0..3.0, n), vec(-6.0..6.0, 10));
        numbers.prop_map(move |(shifts, y, far)| {
            let grid = |i: usize, d: usize| 2.0 * ((2 * i + 3 * d + i * d) as f64).sin();
            let x = Mat::from_fn(n, 2, |i, d| grid(i, d) + shifts[2 * i + d]);
            Case { x, y, x_star: Mat::from_fn(5, 2, |i, d| far[2 * i + d]) }
        })
    })
}

/// The process whose coefficients have priors of variance `wide`, as a kernel about zero.
fn integrated(x: &Mat<f64>, y: &[f64], mean: Mean, wide: f64) -> Gp {
    let constant = Constant::new(wide);
    let basis: Box<dyn Kernel> = match mean {
        Mean::Linear => Box::new(constant + Linear::isotropic(wide)),
        _ => Box::new(constant),
    };
    let whole = Sum::new(basis, kernel());
    Gp::builder(whole)
        .noise_variance(NOISE_VARIANCE)
        .mean(Mean::Fixed(0.0))
        .condition(x.as_ref(), y)
        .unwrap()
}

/// How far predictions, covariances and the likelihood are from those of the wide prior.
fn off(case: &Case, mean: Mean, wide: f64) -> [f64; 3] {
    let (gp, wider) = (fit(&case.x, &case.y, mean), integrated(&case.x, &case.y, mean, wide));
    let [found, expected] =
        [&gp, &wider].map(|one| one.predict_joint(case.x_star.as_ref()).unwrap());
    let scale = 1.0 + expected.covariance().norm_max();
    let means = found.mean().iter().zip(expected.mean()).map(|(a, b)| (a - b).abs() / scale);
    let covariance = (found.covariance() - expected.covariance()).norm_max() / scale;
    // ln p(y) under the prior is less by that of the combinations that the mean touches.
    let p = mean.n_coefficients(2);
    let basis = Mat::from_fn(case.y.len(), p, |i, k| match k {
        0 => 1.0,
        _ => case.x[(i, k - 1)],
    });
    let llt = Llt::new((basis.transpose() * &basis).as_ref(), Side::Lower).unwrap();
    let spread: f64 = (0..p).map(|k| 2.0 * llt.L()[(k, k)].ln()).sum();
    let touched = 0.5 * (spread + p as f64 * (std::f64::consts::TAU * wide).ln());
    let evidence = wider.log_marginal_likelihood() + touched - gp.log_marginal_likelihood();
    [means.fold(0.0, f64::max), covariance, evidence.abs()]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn it_is_the_limit_of_ever_wider_priors(case in case()) {
        for mean in LEARNT {
            let [narrow, wide] = [1e3, 1e6].map(|wide| off(&case, mean, wide));
            for (k, (narrow, wide)) in narrow.iter().zip(&wide).enumerate() {
                // The difference falls as the inverse of the prior's variance, down to rounding.
                prop_assert!(*wide < 0.01 * narrow + 1e-7, "{mean:?} {k}: {narrow} {wide}");
                prop_assert!(*wide < 1e-3, "{mean:?} {k}: {narrow} {wide}");
            }
        }
    }

    #[test]
    fn what_is_left_open_of_it_is_never_negative_and_the_same_in_every_prediction(case in case()) {
        for mean in LEARNT {
            let gp = fit(&case.x, &case.y, mean);
            let joint = gp.predict_joint(case.x_star.as_ref()).unwrap();
            let (found, variance) = gp.predict(case.x_star.as_ref()).unwrap();
            let known = fit(&case.x, &case.y, Mean::Fixed(0.0));
            let known = known.predict(case.x_star.as_ref()).unwrap().1;
            let mut covariance = joint.covariance().to_owned();
            prop_assert_eq!(joint.mean(), &found[..]);
            for i in 0..5 {
                prop_assert!(variance[i] >= known[i], "{} {}", variance[i], known[i]);
                prop_assert!((covariance[(i, i)] - variance[i]).abs() < 1e-10 * variance[i]);
                covariance[(i, i)] *= 1.0 + 1e-9;
            }
            prop_assert!(Llt::new(covariance.as_ref(), Side::Lower).is_ok());
        }
    }

    #[test]
    fn slopes_of_the_variance_equal_finite_differences(case in case()) {
        for mean in LEARNT {
            let gp = fit(&case.x, &case.y, mean);
            let gradient = gp.variance_gradient(case.x_star.as_ref()).unwrap();
            for d in 0..2 {
                let moved = |h: f64| {
                    let shift = |i: usize, j: usize| case.x_star[(i, j)] + if j == d { h } else { 0.0 };
                    gp.predict(Mat::from_fn(5, 2, shift).as_ref()).unwrap().1
                };
                for (i, (above, below)) in moved(1e-4).iter().zip(moved(-1e-4)).enumerate() {
                    let expected = (above - below) / 2e-4;
                    let off = (gradient[(i, d)] - expected).abs();
                    prop_assert!(off < 1e-6 * (1.0 + expected.abs()), "{off}");
                }
            }
        }
    }

    #[test]
    fn slopes_of_the_likelihood_equal_finite_differences(case in case()) {
        for mean in LEARNT {
            let values = [0.8, 1.1, SIGNAL_VARIANCE, NOISE_VARIANCE];
            let at = |values: [f64; 4]| {
                let kernel = SquaredExponential::new(&values[..2], values[2]).unwrap();
                Gp::builder(kernel).noise_variance(values[3]).mean(mean).condition(case.x.as_ref(), &case.y).unwrap()
            };
            let gradient = at(values).log_marginal_likelihood_gradient().unwrap();
            for (p, slope) in gradient.iter().enumerate() {
                let moved = |h: f64| {
                    let mut values = values;
                    values[p] *= h.exp();
                    at(values).log_marginal_likelihood()
                };
                let expected = (moved(1e-5) - moved(-1e-5)) / 2e-5;
                prop_assert!((slope - expected).abs() < 1e-6 * (1.0 + slope.abs()), "{p} {slope}");
            }
        }
    }

    #[test]
    fn leaving_one_out_leaves_it_out_of_the_mean_too(case in case()) {
        let rest = case.x.subrows(1, case.y.len() - 1).to_owned();
        for mean in LEARNT {
            // With three rows left a plane is just determined.
            let left_out = fit(&case.x, &case.y, mean).leave_one_out().unwrap();
            let without = fit(&rest, &case.y[1..], mean);
            let (mean, variance) = without.predict_observation(case.x.subrows(0, 1)).unwrap();
            prop_assert!((left_out.mean[0] - mean[0]).abs() < 1e-7 * (1.0 + mean[0].abs()));
            prop_assert!((left_out.variance[0] / variance[0] - 1.0).abs() < 1e-7);
        }
    }
}

/// Twelve rows about the origin.
fn cloud() -> (Mat<f64>, Vec<f64>) {
    let x = Mat::from_fn(12, 2, |i, d| (1.7 * (2 * i + d) as f64).sin());
    let y = (0..12).map(|i| x[(i, 0)] + 0.2 * (5.0 * i as f64).cos()).collect();
    (x, y)
}

#[test]
fn away_from_the_data_a_constant_is_as_unsure_as_ever_and_a_plane_more_and_more() {
    let (x, y) = cloud();
    let far = Mat::from_fn(3, 2, |i, _| 20.0 * 10_f64.powi(i as i32));
    let variance = |mean| fit(&x, &y, mean).predict(far.as_ref()).unwrap().1;
    let constant = variance(Mean::Estimated);
    assert_eq!(constant[1], constant[2]);
    // The variance of the mean of twelve values of such correlations.
    assert!((SIGNAL_VARIANCE + 0.1..2.0 * SIGNAL_VARIANCE).contains(&constant[0]), "{constant:?}");
    let plane = variance(Mean::Linear);
    assert!((plane[2] / plane[1] / 100.0 - 1.0).abs() < 0.01 && plane[1] > 50.0, "{plane:?}");
    assert_eq!(variance(Mean::Fixed(0.3)), [SIGNAL_VARIANCE; 3]);
}

#[test]
fn one_row_tells_a_constant_as_well_as_a_row_can() {
    let x = Mat::from_fn(1, 2, |_, d| d as f64);
    let gp = fit(&x, &[4.0], Mean::Estimated);
    let far = Mat::from_fn(1, 2, |_, _| 1e3);
    let (mean, variance) = gp.predict(far.as_ref()).unwrap();
    assert_eq!(mean, [4.0]);
    assert!((variance[0] - (2.0 * SIGNAL_VARIANCE + NOISE_VARIANCE)).abs() < 1e-14);
    assert_eq!(gp.leave_one_out().unwrap_err(), GpError::UndeterminedWithout { row: 0 });
    // Of one number that any mean explains there is no density.
    assert!(gp.log_marginal_likelihood().abs() < 1e-14);
}

#[test]
fn what_rows_do_not_tell_of_a_plane_is_named() {
    let fit = |x: &Mat<f64>| {
        Gp::builder(kernel())
            .noise_variance(0.1)
            .mean(Mean::Linear)
            .condition(x.as_ref(), &vec![1.0; x.nrows()])
            .map(|_| ())
    };
    let undetermined = |input, n_rows| Err(GpError::UndeterminedSlope { input, n_rows });
    let constant = Mat::from_fn(6, 2, |i, d| if d == 0 { i as f64 } else { 3.0 });
    assert_eq!(fit(&constant), undetermined(1, 6));
    let in_a_line = Mat::from_fn(6, 2, |i, d| (i * (d + 2)) as f64 + 7.0);
    assert_eq!(fit(&in_a_line), undetermined(1, 6));
    let few = Mat::from_fn(2, 2, |i, d| (i * (d + 1)) as f64);
    assert_eq!(fit(&few), undetermined(1, 2));
    let message = undetermined(1, 2).unwrap_err().to_string();
    assert!(message.contains("2 rows") && message.contains("input 1"), "{message}");
    let options = LearnOptions { mean: Mean::Linear, ..LearnOptions::default() };
    let (x, y) = cloud();
    let learnt = Gp::builder(kernel()).options(options.clone()).fit(x.subrows(0, 3), &y[..3]);
    assert_eq!(learnt.unwrap_err(), GpError::TooFewRows { needed: 4, actual: 3 });
}

#[test]
fn a_row_that_the_plane_needs_stays() {
    let x = Mat::from_fn(5, 2, |i, d| if d == 0 { i as f64 } else { f64::from(i == 2) });
    let y = [0.0, 1.0, 5.0, 2.0, 4.0];
    let mut gp = fit(&x, &y, Mean::Linear);
    let before = gp.predict(x.as_ref()).unwrap();
    assert_eq!(gp.leave_one_out().unwrap_err(), GpError::UndeterminedWithout { row: 2 });
    assert_eq!(gp.remove_row(2), Err(GpError::UndeterminedSlope { input: 1, n_rows: 4 }));
    assert_eq!(gp.predict(x.as_ref()).unwrap(), before);
    gp.remove_row(0).unwrap();
}

/// Draws of the prior about a constant, of which six rows are told, and predictions away from them.
#[test]
fn intervals_hold_as_often_as_they_say_where_few_rows_tell_the_mean() {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let (n_sets, n, n_star) = (400, 6, 10);
    let (mut y_star, mut learnt, mut known) = (Vec::new(), [vec![], vec![]], [vec![], vec![]]);
    let kernel = || SquaredExponential::new(&[1.0], 1.0).unwrap();
    for set in 0..n_sets {
        let x = Mat::from_fn(n + n_star, 1, |i, _| match i < n {
            true => random.random_range(0.0..2.0),
            false => random.random_range(4.0..9.0),
        });
        let draw = JointGaussian::prior(&kernel(), x.as_ref()).unwrap().sample(1, set).unwrap();
        let mut value =
            |i: usize| draw[(i, 0)] + 50.0 + 0.1 * random.sample::<f64, _>(StandardNormal);
        let y: Vec<f64> = (0..n + n_star).map(&mut value).collect();
        let (rows, rest) = (x.subrows(0, n), x.subrows(n, n_star));
        y_star.extend_from_slice(&y[n..]);
        let gp = Gp::builder(kernel()).noise_variance(0.01).condition(rows, &y[..n]).unwrap();
        let at_its_best = Mean::Fixed(gp.mean());
        let taken = Gp::builder(kernel())
            .noise_variance(0.01)
            .mean(at_its_best)
            .condition(rows, &y[..n])
            .unwrap();
        for (gp, into) in [(&gp, &mut learnt), (&taken, &mut known)] {
            let (mean, variance) = gp.predict_observation(rest).unwrap();
            into[0].extend(mean);
            into[1].extend(variance);
        }
    }
    let inside =
        |[mean, variance]: &[Vec<f64>; 2]| coverage(&y_star, mean, variance, &[0.95]).unwrap()[0];
    let (learnt, known) = (inside(&learnt), inside(&known));
    assert!((learnt - 0.95).abs() < 0.02, "{learnt}");
    assert!(known < 0.90, "the mean as if it were known: {known}, not {learnt}");
}

/// Of planes with noise most rows go into the coefficients; what is left of them is the noise.
#[test]
fn learnt_noise_is_not_too_small_where_few_rows_tell_many_slopes() {
    let (n, d) = (20, 8);
    let learnt = |seed: u64| {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let x = Mat::from_fn(n, d, |_, _| random.random_range(-1.0..1.0));
        let plane = |i: usize| (0..d).map(|k| (k as f64 - 3.0) * x[(i, k)]).sum::<f64>();
        let y: Vec<f64> =
            (0..n).map(|i| plane(i) + random.sample::<f64, _>(StandardNormal)).collect();
        let options = LearnOptions { mean: Mean::Linear, ..LearnOptions::default() };
        // A process that can say nothing but noise: one constant for all, which the mean takes.
        let kernel = Constant::new(1.0);
        Gp::builder(kernel).options(options.clone()).fit(x.as_ref(), &y).unwrap().noise_variance()
    };
    let average = (0..40).map(learnt).sum::<f64>() / 40.0;
    // Its standard error is √(2/11/40) = 0.07; at the most likely coefficients it would be 11/20.
    assert!((average - 1.0).abs() < 0.2, "{average}");
}

#[test]
fn processes_with_other_noise_leave_the_same_open() {
    let (x, y) = cloud();
    let near_and_far = Mat::from_fn(6, 2, |i, d| 0.7 * (i * i) as f64 - d as f64);
    let expected = fit(&x, &y, Mean::Estimated);
    let robust = StudentTGp::fit(kernel(), x.as_ref(), &y, NOISE_VARIANCE, 1e9, Mean::Estimated);
    let model = HeteroscedasticGpModel {
        version: HeteroscedasticGpModel::VERSION,
        kernel: kernel().spec().unwrap(),
        noise_kernel: SquaredExponential::new(&[1.0, 1.0], 1e-12).unwrap().spec().unwrap(),
        mean: Mean::Estimated,
        log_noise_mean: NOISE_VARIANCE.ln(),
        precisions: vec![0.5; 12],
        inputs: (0..12).map(|i| vec![x[(i, 0)], x[(i, 1)]]).collect(),
        outputs: y.clone(),
    };
    let changing = HeteroscedasticGp::from_model(&model).unwrap();
    assert!((changing.bound() - expected.log_marginal_likelihood()).abs() < 1e-8);
    let expected = expected.predict_joint(near_and_far.as_ref()).unwrap();
    let others: [&dyn Posterior; 2] = [&robust.unwrap(), &changing];
    for posterior in others {
        let joint = posterior.predict_joint(near_and_far.as_ref()).unwrap();
        let (_, variance) = posterior.predict(near_and_far.as_ref()).unwrap();
        for i in 0..6 {
            let found = joint.covariance()[(i, i)];
            assert!((found - variance[i]).abs() < 1e-12, "{found} {variance:?}");
            for j in 0..6 {
                let off = (joint.covariance()[(i, j)] - expected.covariance()[(i, j)]).abs();
                assert!(off < 1e-6, "{i} {j} {off}");
            }
        }
    }
}
