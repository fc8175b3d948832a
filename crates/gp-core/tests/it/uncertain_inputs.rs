//! Laws of the moments at inputs that are Gaussian themselves.

use faer::{Mat, MatRef};
use gp_core::cholesky::pivoted_factor;
use gp_core::{
    Expansion, GaussianInput, Gp, GpError, Matern52, Mean, SquaredExponential,
    SquaredExponentialBasis, UncertainOutputs,
};
use proptest::collection::vec;
use proptest::prelude::{ProptestConfig, Strategy, prop_assert, proptest};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::StandardNormal;

/// Two processes of other data and lengthscales, one about a plane, and a Gaussian input.
#[derive(Clone, Debug)]
struct Case {
    processes: [Gp; 2],
    mean: Vec<f64>,
    /// A with S = A Aᵀ.
    root: Mat<f64>,
}

impl Case {
    fn new(d: usize, numbers: &[f64]) -> Self {
        let mut numbers = numbers.iter().copied();
        let mut number = || numbers.next().unwrap();
        let mut process = |n: usize, mean: Mean| {
            // Never all in a plane, so that every mean is determined.
            let x = Mat::from_fn(n, d, |i, k| ((2 + k) as f64 * i as f64).sin() + number());
            let y: Vec<f64> = (0..n).map(|_| 3.0 * number()).collect();
            let lengthscales: Vec<f64> = (0..d).map(|_| 1.2 + 0.8 * number()).collect();
            let kernel = SquaredExponential::new(&lengthscales, 1.7).unwrap();
            Gp::builder(kernel).noise_variance(0.05).mean(mean).condition(x.as_ref(), &y).unwrap()
        };
        let processes = [process(12, Mean::Estimated), process(9, Mean::Linear)];
        let mean = (0..d).map(|_| number()).collect();
        let root = Mat::from_fn(d, d, |_, _| 0.8 * number());
        Self { processes, mean, root }
    }

    fn input(&self, scale: f64) -> GaussianInput {
        let covariance = scale * scale * (&self.root * self.root.transpose());
        GaussianInput::new(self.mean.clone(), covariance).unwrap()
    }

    fn moments(&self, scale: f64) -> UncertainOutputs {
        let [a, b] = self.processes.each_ref().map(|one| one.expansion().unwrap());
        Expansion::<SquaredExponentialBasis>::at(&[&a, &b], &self.input(scale)).unwrap()
    }

    /// The moments as sums over points m + A z with weights.
    fn sums(&self, points: &[(Vec<f64>, f64)]) -> Sums {
        let d = self.mean.len();
        let x = Mat::from_fn(points.len(), d, |i, k| {
            self.mean[k] + (0..d).map(|l| self.root[(k, l)] * points[i].0[l]).sum::<f64>()
        });
        let said = self.processes.each_ref().map(|one| one.predict(x.as_ref()).unwrap());
        let over = |f: &dyn Fn(usize) -> f64| -> f64 {
            points.iter().enumerate().map(|(i, (_, weight))| weight * f(i)).sum()
        };
        let mean = [0, 1].map(|a| over(&|i| said[a].0[i]));
        let off = |a: usize, i: usize| said[a].0[i] - mean[a];
        let covariance = Mat::from_fn(2, 2, |a, b| {
            let own = if a == b { over(&|i| said[a].1[i]) } else { 0.0 };
            over(&|i| off(a, i) * off(b, i)) + own
        });
        let with_input =
            Mat::from_fn(d, 2, |k, a| over(&|i| (x[(i, k)] - self.mean[k]) * off(a, i)));
        Sums { mean, covariance, with_input }
    }
}

struct Sums {
    mean: [f64; 2],
    covariance: Mat<f64>,
    with_input: Mat<f64>,
}

impl Sums {
    /// The largest difference of any moment.
    fn off(&self, moments: &UncertainOutputs, input: &GaussianInput) -> f64 {
        let with_input = input.covariance() * &moments.slopes;
        let means = self.mean.iter().zip(&moments.mean).map(|(a, b)| (a - b).abs());
        means
            .fold(0.0, f64::max)
            .max((&self.covariance - &moments.covariance).norm_max())
            .max((&self.with_input - &with_input).norm_max())
    }
}

fn numbers(d: usize) -> usize {
    21 * d + 21 + 2 * d + d + d * d
}

fn case(d: usize) -> impl Strategy<Value = Case> {
    vec(-1.0..1.0, numbers(d)).prop_map(move |numbers| Case::new(d, &numbers))
}

fn any_case() -> impl Strategy<Value = Case> {
    (1_usize..4).prop_flat_map(case)
}

/// Points of the trapezoidal rule in standard deviations: for what is smooth and falls as a Gaussian
/// its error falls faster than any power of the spacing.
fn grid(d: usize) -> Vec<(Vec<f64>, f64)> {
    let n = 91_usize;
    let place = |k: usize| (k as f64 - 45.0) * 0.2;
    let point = |index: usize| {
        let z: Vec<f64> =
            (0..d).map(|axis| place(index / n.pow(u32::try_from(axis).unwrap()) % n)).collect();
        let square: f64 = z.iter().map(|z| z * z).sum();
        let size = 0.2 / std::f64::consts::TAU.sqrt();
        (z, size.powi(i32::try_from(d).unwrap()) * (-0.5 * square).exp())
    };
    (0..n.pow(u32::try_from(d).unwrap())).map(point).collect()
}

fn row(of: &[f64]) -> MatRef<'_, f64> {
    MatRef::from_row_major_slice(of, 1, of.len())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn a_known_input_gets_the_prediction_and_its_slope(case in any_case()) {
        let moments = case.moments(0.0);
        for (a, process) in case.processes.iter().enumerate() {
            let (mean, variance) = process.predict(row(&case.mean)).unwrap();
            let slope = process.mean_gradient(row(&case.mean)).unwrap();
            prop_assert!((moments.mean[a] - mean[0]).abs() < 1e-11);
            prop_assert!((moments.covariance[(a, a)] - variance[0]).abs() < 1e-12);
            for k in 0..case.mean.len() {
                prop_assert!((moments.slopes[(k, a)] - slope[(0, k)]).abs() < 1e-10);
            }
        }
        prop_assert!(moments.covariance[(0, 1)] == 0.0);
    }

    #[test]
    fn moments_are_the_integrals_over_one_input(case in case(1)) {
        let off = case.sums(&grid(1)).off(&case.moments(1.0), &case.input(1.0));
        prop_assert!(off < 1e-11, "{off}");
    }

    #[test]
    fn all_together_have_a_covariance_whatever_the_spread(case in any_case(), scale in 0.0..6.0) {
        let (moments, input) = (case.moments(scale), case.input(scale));
        let (d, s) = (case.mean.len(), input.covariance());
        let with_input = s * &moments.slopes;
        let joint = Mat::from_fn(d + 2, d + 2, |i, j| match (i.checked_sub(d), j.checked_sub(d)) {
            (None, None) => s[(i, j)],
            (None, Some(b)) => with_input[(i, b)],
            (Some(a), None) => with_input[(j, a)],
            (Some(a), Some(b)) => moments.covariance[(a, b)],
        });
        prop_assert!(pivoted_factor("joint", joint.as_ref()).is_ok(), "{joint:?}");
    }

    #[test]
    fn a_little_spread_moves_outputs_along_their_slopes(case in any_case()) {
        // Covariances of the means are ten digits below those of the functions, and lose none.
        let (scale, known) = (1e-5, case.moments(0.0));
        let (little, input) = (case.moments(scale), case.input(scale));
        let linear = known.slopes.transpose() * input.covariance() * &known.slopes;
        let off = (linear[(0, 1)] - little.covariance[(0, 1)]).abs();
        // The rest is of second order in S.
        prop_assert!(off < 1e-6 * scale * scale, "{off}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]

    #[test]
    fn moments_are_the_integrals_over_two_inputs(case in case(2)) {
        let off = case.sums(&grid(2)).off(&case.moments(1.0), &case.input(1.0));
        prop_assert!(off < 1e-11, "{off}");
    }
}

#[test]
fn moments_are_those_of_a_million_draws() {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let d = 3;
    let numbers: Vec<f64> = (0..numbers(d)).map(|_| random.random_range(-1.0..1.0)).collect();
    let case = Case::new(d, &numbers);
    let n = 1_000_000;
    let mut draw = |_| ((0..d).map(|_| random.sample(StandardNormal)).collect(), 1.0 / n as f64);
    let draws: Vec<(Vec<f64>, f64)> = (0..n).map(&mut draw).collect();
    let (moments, input) = (case.moments(1.0), case.input(1.0));
    let off = case.sums(&draws).off(&moments, &input);
    // Five standard errors of a product of two numbers of such variances.
    let largest = moments.covariance.norm_max().max(input.covariance().norm_max());
    assert!(off < 5.0 * (2.0 * largest * largest / n as f64).sqrt(), "{off}");
    assert!(moments.covariance[(0, 1)].abs() > 10.0 * off, "{moments:?}");
}

#[test]
fn a_plane_is_propagated_as_the_kalman_filter_does() {
    // Lengthscales a thousand times the data's extent leave planes.
    let x = Mat::from_fn(30, 2, |i, k| ((i * (3 + 4 * k)) as f64).sin());
    let slopes = [[0.7, -1.1], [0.2, 0.5]];
    let process = |slope: [f64; 2]| {
        let y: Vec<f64> =
            (0..30).map(|i| 0.3 + slope[0] * x[(i, 0)] + slope[1] * x[(i, 1)]).collect();
        let kernel = SquaredExponential::new(&[1e3, 1e3], 1e6).unwrap();
        let process = Gp::builder(kernel).noise_variance(1e-6).condition(x.as_ref(), &y).unwrap();
        process.expansion().unwrap()
    };
    let [a, b] = slopes.map(process);
    let covariance = Mat::from_fn(2, 2, |i, j| [[0.04, 0.01], [0.01, 0.09]][i][j]);
    let input = GaussianInput::new(vec![0.4, -0.3], covariance.clone()).unwrap();
    let moments = Expansion::at(&[&a, &b], &input).unwrap();
    let known = Mat::zeros(2, 2);
    let known = GaussianInput::new(vec![0.4, -0.3], known).unwrap();
    let own = Expansion::at(&[&a, &b], &known).unwrap();
    for i in 0..2 {
        let mean = 0.3 + slopes[i][0] * 0.4 - slopes[i][1] * 0.3;
        assert!((moments.mean[i] - mean).abs() < 1e-4, "{moments:?}");
        for j in 0..2 {
            let kalman: f64 = (0..4)
                .map(|k| slopes[i][k / 2] * covariance[(k / 2, k % 2)] * slopes[j][k % 2])
                .sum();
            let found = moments.covariance[(i, j)] - own.covariance[(i, j)];
            assert!((found - kalman).abs() < 1e-4 * kalman.abs(), "{found} {kalman}");
            assert!((moments.slopes[(i, j)] - slopes[j][i]).abs() < 1e-4);
        }
    }
}

#[test]
fn an_input_that_may_be_anywhere_returns_to_the_prior() {
    let x = Mat::from_fn(20, 1, |i, _| 0.2 * i as f64);
    let y: Vec<f64> = (0..20).map(|i| (0.7 * f64::from(i)).sin()).collect();
    let kernel = SquaredExponential::new(&[0.5], 1.7).unwrap();
    let process = Gp::builder(kernel).noise_variance(1e-4).condition(x.as_ref(), &y).unwrap();
    let input = GaussianInput::new(vec![1.0], Mat::full(1, 1, 1e12)).unwrap();
    let moments = Expansion::at(&[&process.expansion().unwrap()], &input).unwrap();
    assert!((moments.mean[0] - process.mean()).abs() < 1e-5, "{moments:?}");
    // Beside the prior's there is what the rows leave open of the mean, as far from all of them.
    let far = process.predict(row(&[1e3])).unwrap().1[0];
    assert!(far > 1.8 && (moments.covariance[(0, 0)] - far).abs() < 1e-4, "{moments:?} {far}");
}

#[test]
fn what_has_no_closed_form_is_refused() {
    let x = Mat::from_fn(3, 1, |i, _| i as f64);
    let process = Gp::builder(Matern52::new(&[1.0], 1.0).unwrap())
        .noise_variance(0.1)
        .condition(x.as_ref(), &[0.0, 1.0, 0.5])
        .unwrap();
    assert!(matches!(process.expansion(), Err(GpError::NoClosedForm { .. })));
    let process = Gp::builder(SquaredExponential::new(&[1.0], 1.0).unwrap())
        .noise_variance(0.1)
        .condition(x.as_ref(), &[0.0, 1.0, 0.5]);
    let plane = GaussianInput::new(vec![0.0; 2], Mat::zeros(2, 2)).unwrap();
    let expected = GpError::ShapeMismatch { what: "inputs of a function", expected: 2, actual: 1 };
    let found = Expansion::at(&[&process.unwrap().expansion().unwrap()], &plane);
    assert_eq!(found.map(|_| ()), Err(expected));
    let nothing = Expansion::<SquaredExponentialBasis>::at(&[], &plane).map(|_| ());
    assert_eq!(nothing, Err(GpError::Empty { what: "functions" }));
}
