//! Laws that every kernel obeys, on random inputs.

use faer::linalg::solvers::Llt;
use faer::{Mat, Side};
use gp_core::{
    Constant, Coregionalization, Cosine, Kernel, KernelSpec, Linear, Matern12, Matern32, Matern52,
    Periodic, Polynomial, RationalQuadratic, Role, SquaredExponential, White, cross, gram,
};
use proptest::collection::vec;
use proptest::prelude::{Just, ProptestConfig, Strategy, prop_assert, prop_assert_eq, proptest};

/// One of each kernel; a new kernel is added here.
fn kernels(n_inputs: usize, scales: &[f64]) -> Vec<Box<dyn Kernel>> {
    let (lengthscales, variance) = (&scales[..n_inputs], scales[n_inputs]);
    let squared = SquaredExponential::new(lengthscales, variance).unwrap();
    let matern = Matern52::new(lengthscales, variance).unwrap();
    let widths: Vec<f64> = lengthscales.iter().map(|scale| scale + 0.5).collect();
    let periodic = Periodic::ard(lengthscales, &widths);
    let product = squared.clone() * periodic.clone();
    let linear = Linear::ard(lengthscales);
    let offset = Constant::new(variance);
    let last = Matern32::new(&lengthscales[..1], variance).unwrap();
    let active = last.active(&[n_inputs - 1]);
    let all: Vec<usize> = (0..n_inputs).rev().collect();
    let reversed = squared.clone().active(&all);
    vec![
        Box::new(offset.clone() + linear.clone()),
        Box::new((linear.clone() + squared.clone()) * active.clone()),
        Box::new(variance * (Matern12::isotropic(scales[0]) + White::new(variance))),
        Box::new(Matern12::new(lengthscales, variance).unwrap()),
        Box::new(variance * RationalQuadratic::ard(lengthscales, scales[0])),
        Box::new(RationalQuadratic::isotropic(scales[0], variance)),
        Box::new(variance * Polynomial::ard(3, lengthscales)),
        Box::new(Polynomial::isotropic(2, scales[0])),
        Box::new(variance * Cosine::ard(lengthscales)),
        Box::new(Cosine::isotropic(scales[0])),
        Box::new(Periodic::new(scales[0], widths[0])),
        Box::new(outputs(scales).active(&[0]) * linear.clone()),
        Box::new(variance * Linear::isotropic(scales[0])),
        Box::new(variance * SquaredExponential::isotropic(scales[0])),
        Box::new(variance * Matern52::isotropic(scales[0])),
        Box::new(linear),
        Box::new(offset),
        Box::new(active),
        Box::new(reversed),
        Box::new(Matern32::new(lengthscales, variance).unwrap()),
        Box::new(product.clone() * matern.clone()),
        Box::new(product),
        Box::new(squared),
        Box::new(matern),
        Box::new(periodic),
    ]
}

/// Three outputs that are correlated.
fn outputs(scales: &[f64]) -> Coregionalization {
    let values = [0.7, scales[0], 1.3, scales[1], 0.4, scales[0] * scales[1]];
    Coregionalization::from_odds(&values[..3], &values[3..])
}

/// Inputs, N×D by rows, and D + 1 positive scales.
fn case() -> impl Strategy<Value = (usize, Vec<f64>, Vec<f64>)> {
    (1_usize..4, 2_usize..9).prop_flat_map(|(n_inputs, n_rows)| {
        (Just(n_inputs), vec(-2.0..2.0, n_inputs * n_rows), vec(0.3..3.0, n_inputs + 1))
    })
}

fn inputs(n_inputs: usize, entries: &[f64]) -> Mat<f64> {
    Mat::from_fn(entries.len() / n_inputs, n_inputs, |i, d| entries[i * n_inputs + d])
}

/// The slope at 0 by four points; its own error is of order h⁴ and ε/h.
fn finite_difference(function: impl Fn(f64) -> f64) -> f64 {
    let h = 1e-4;
    let near = function(h) - function(-h);
    let far = function(2.0 * h) - function(-2.0 * h);
    (8.0 * near - far) / (12.0 * h)
}

/// The fastest oscillation here, 50 a unit, leaves h⁴·50⁵/30 ≈ 1e-9 to the finite difference.
const SLOPE_TOLERANCE: f64 = 2e-8;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn gram_matrices_are_symmetric_and_positive_semi_definite((d, entries, scales) in case()) {
        let x = inputs(d, &entries);
        for kernel in kernels(d, &scales) {
            let mut matrix = gram(&kernel, x.as_ref()).unwrap();
            prop_assert_eq!(&matrix, &matrix.transpose().to_owned());
            let rounding = 1e-12 * (1.0 + matrix[(0, 0)]);
            (0..x.nrows()).for_each(|i| matrix[(i, i)] += rounding);
            prop_assert!(Llt::new(matrix.as_ref(), Side::Lower).is_ok(), "{kernel:?}");
        }
    }

    #[test]
    fn blocks_equal_pairwise_values((d, entries, scales) in case()) {
        let x = inputs(d, &entries);
        for kernel in kernels(d, &scales) {
            let (square, block) = (gram(&kernel, x.as_ref()), cross(&kernel, x.as_ref(), x.as_ref()));
            let (square, block) = (square.unwrap(), block.unwrap());
            for (i, a) in entries.chunks(d).enumerate() {
                for (j, b) in entries.chunks(d).enumerate() {
                    let value = kernel.value(a, b);
                    let rounding = 1e-14 * (1.0 + value.abs());
                    prop_assert!((square[(i, j)] - value).abs() <= rounding);
                    prop_assert!((block[(i, j)] - value).abs() <= rounding);
                    prop_assert!((value - kernel.value(b, a)).abs() <= rounding);
                }
            }
        }
    }

    #[test]
    fn row_major_inputs_give_the_same_blocks((d, entries, scales) in case()) {
        let x = inputs(d, &entries);
        let rows = faer::MatRef::from_row_major_slice(&entries, x.nrows(), d);
        for kernel in kernels(d, &scales) {
            prop_assert_eq!(gram(&kernel, rows).unwrap(), gram(&kernel, x.as_ref()).unwrap());
        }
    }

    #[test]
    fn parameter_gradients_equal_finite_differences((d, entries, scales) in case()) {
        let (a, b) = (&entries[..d], &entries[d..2 * d]);
        for kernel in kernels(d, &scales) {
            let values: Vec<f64> = kernel.parameters().iter().map(|p| p.value).collect();
            let mut gradient = vec![f64::NAN; values.len()];
            kernel.parameter_gradient(a, b, &mut gradient);
            for (p, slope) in gradient.iter().enumerate() {
                let expected = finite_difference(|h| {
                    let mut moved = values.clone();
                    moved[p] *= h.exp();
                    kernel.with_parameters(&moved).unwrap().value(a, b)
                });
                let scale = 1.0 + slope.abs();
                prop_assert!((slope - expected).abs() < SLOPE_TOLERANCE * scale, "{kernel:?} {p}");
            }
        }
    }

    #[test]
    fn input_gradients_equal_finite_differences((d, entries, scales) in case()) {
        let (a, b) = (&entries[..d], &entries[d..2 * d]);
        for kernel in kernels(d, &scales) {
            let mut gradient = vec![f64::NAN; d];
            kernel.input_gradient(a, b, &mut gradient);
            for (input, slope) in gradient.iter().enumerate() {
                let expected = finite_difference(|h| {
                    let mut moved = a.to_vec();
                    moved[input] += h;
                    kernel.value(&moved, b)
                });
                let scale = 1.0 + slope.abs();
                prop_assert!((slope - expected).abs() < SLOPE_TOLERANCE * scale, "{kernel:?}");
            }
        }
    }

    #[test]
    fn column_gradients_are_weighted_sums_of_pairwise_ones((d, entries, scales) in case()) {
        let x = inputs(d, &entries);
        let b = &entries[..d];
        let weights: Vec<f64> = (0..x.nrows()).map(|i| (i as f64 + 0.5).sin()).collect();
        for kernel in kernels(d, &scales) {
            let n_parameters = kernel.parameters().len();
            let mut values = vec![0.0; x.nrows()];
            kernel.column(x.as_ref(), b, &mut values);
            let mut actual = vec![1.0; n_parameters];
            kernel.column_gradient(x.as_ref(), b, &values, &weights, &mut actual, &mut []);
            let mut expected = vec![1.0; n_parameters];
            for (a, weight) in entries.chunks(d).zip(&weights) {
                let mut slope = vec![0.0; n_parameters];
                kernel.parameter_gradient(a, b, &mut slope);
                expected.iter_mut().zip(&slope).for_each(|(sum, slope)| *sum += weight * slope);
            }
            for (actual, expected) in actual.iter().zip(&expected) {
                prop_assert!((actual - expected).abs() < 1e-12 * (1.0 + expected.abs()));
            }
            let (mut together, mut by_input) = (vec![1.0; n_parameters], vec![0.5; d]);
            let mut alone = vec![0.5; d];
            let slopes = (&mut together[..], &mut by_input[..]);
            kernel.column_gradient(x.as_ref(), b, &values, &weights, slopes.0, slopes.1);
            kernel.column_gradient(x.as_ref(), b, &values, &weights, &mut [], &mut alone);
            prop_assert_eq!((together, by_input), (actual, alone));
        }
    }

    #[test]
    fn columns_have_the_slopes_by_their_input_and_diagonals_those_of_the_values(
        (d, entries, scales) in case(),
    ) {
        let x = inputs(d, &entries);
        let b = &entries[..d];
        let n = x.nrows();
        let weights: Vec<f64> = (0..n).map(|i| (i as f64 + 0.5).sin()).collect();
        for kernel in kernels(d, &scales) {
            let n_parameters = kernel.parameters().len();
            let (mut values, mut diagonal) = (vec![0.0; n], vec![0.0; n]);
            kernel.column(x.as_ref(), b, &mut values);
            kernel.diagonal(x.as_ref(), &mut diagonal);
            let (mut by_input, mut by_parameters) = (vec![1.0; d], vec![1.0; n_parameters]);
            kernel.column_gradient(x.as_ref(), b, &values, &weights, &mut [], &mut by_input);
            kernel.diagonal_gradient(x.as_ref(), &weights, &mut by_parameters);
            let (mut input, mut parameters) = (vec![1.0; d], vec![1.0; n_parameters]);
            for (i, a) in entries.chunks(d).enumerate() {
                prop_assert!((diagonal[i] - kernel.value(a, a)).abs() < 1e-13);
                let (mut slope, mut other) = (vec![0.0; d], vec![0.0; n_parameters]);
                kernel.input_gradient(b, a, &mut slope);
                kernel.parameter_gradient(a, a, &mut other);
                input.iter_mut().zip(&slope).for_each(|(sum, slope)| *sum += weights[i] * slope);
                parameters.iter_mut().zip(&other).for_each(|(sum, s)| *sum += weights[i] * s);
            }
            let pairs = by_input.iter().zip(&input).chain(by_parameters.iter().zip(&parameters));
            for (actual, expected) in pairs {
                prop_assert!((actual - expected).abs() < 1e-12 * (1.0 + expected.abs()));
            }
        }
    }

    #[test]
    fn specs_rebuild_the_same_kernel((d, entries, scales) in case()) {
        let (a, b) = (&entries[..d], &entries[d..2 * d]);
        for kernel in kernels(d, &scales) {
            let text = serde_json::to_string(&kernel.spec().unwrap()).unwrap();
            let spec: KernelSpec = serde_json::from_str(&text).unwrap();
            let rebuilt = spec.build();
            prop_assert_eq!(rebuilt.parameters(), kernel.parameters());
            prop_assert_eq!(rebuilt.value(a, b).to_bits(), kernel.value(a, b).to_bits());
        }
    }
}

#[test]
fn values_known_by_hand() {
    let (a, b) = ([0.0], [2.0]);
    let squared = SquaredExponential::new(&[2.0], 3.0).unwrap();
    assert!((squared.value(&a, &b) - 3.0 * (-0.5_f64).exp()).abs() < 1e-15);
    let root = 3f64.sqrt();
    let matern = Matern32::new(&[2.0], 1.0).unwrap();
    assert!((matern.value(&a, &b) - (1.0 + root) * (-root).exp()).abs() < 1e-15);
    let root = 5f64.sqrt();
    let matern = Matern52::new(&[2.0], 1.0).unwrap();
    assert!((matern.value(&a, &b) - (1.0 + root + 5.0 / 3.0) * (-root).exp()).abs() < 1e-15);
    let periodic = Periodic::new(4.0, 1.0);
    assert!((periodic.value(&a, &b) - (-2f64).exp()).abs() < 1e-15);
    let rough = Matern12::isotropic(2.0);
    assert!((rough.value(&a, &b) - (-1f64).exp()).abs() < 1e-15);
    // r² = 1, so (1 + 1/(2·2))⁻² = 16/25.
    let rational = 3.0 * RationalQuadratic::isotropic(2.0, 2.0);
    assert!((rational.value(&a, &b) - 3.0 * 0.64).abs() < 1e-14);
    // A third of a turn.
    let cosine = 3.0 * Cosine::isotropic(6.0);
    assert!((cosine.value(&a, &b) + 1.5).abs() < 1e-14);
    // (1 + 3·2/2²)² = 6.25.
    let polynomial = 2.0 * Polynomial::isotropic(2, 2.0);
    assert!((polynomial.value(&[3.0], &b) - 12.5).abs() < 1e-14);
    let white = 2.0 * White::new(1.5);
    assert_eq!((white.value(&a, &b), white.value(&b, &b)), (0.0, 3.0));
}

#[test]
fn kernels_that_are_another_in_disguise_equal_it() {
    let (a, b) = ([0.3, -1.2], [0.9, 0.4]);
    let lines = Constant::new(0.7) + Linear::ard(&[0.7 / 4.0, 0.7 / 9.0]);
    let polynomial = 0.7 * Polynomial::ard(1, &[2.0, 3.0]);
    assert!((polynomial.value(&a, &b) - lines.value(&a, &b)).abs() < 1e-15);
    let many = RationalQuadratic::ard(&[0.8, 1.5], 1e8).value(&a, &b);
    let one = SquaredExponential::new(&[0.8, 1.5], 1.0).unwrap().value(&a, &b);
    assert!((many - one).abs() < 1e-7, "{many} {one}");
    let same = 2.0 * Matern52::isotropic(0.8);
    let each = Matern52::new(&[0.8; 2], 2.0).unwrap();
    assert_eq!(same.value(&a, &b).to_bits(), each.value(&a, &b).to_bits());
}

#[test]
fn parameters_have_names_and_kernels_of_a_kind_are_numbered() {
    let names = |kernel: &dyn Kernel| -> Vec<String> {
        kernel.parameters().into_iter().map(|parameter| parameter.name).collect()
    };
    let kernel = (Matern52::isotropic(1.0) + Constant::new(0.5)) * Periodic::new(1.0, 2.0);
    assert_eq!(
        names(&kernel),
        [
            "matern52.lengthscale",
            "matern52.signal_variance",
            "constant.variance",
            "periodic.period",
            "periodic.lengthscale"
        ]
    );
    let smooth = || SquaredExponential::unit(2).unwrap();
    let two = || White::new(1.0) + White::new(1.0);
    let names = names(&((two() + smooth()) * (two() * smooth()).active(&[1, 0])));
    assert_eq!(names[0..2], ["white.variance", "white_2.variance"]);
    assert_eq!(names[2], "squared_exponential.lengthscale[0]");
    assert_eq!(names[5..7], ["white_3.variance", "white_4.variance"]);
    assert_eq!(names[7], "squared_exponential_2.lengthscale[0]");
}

#[test]
fn one_parameter_of_several_inputs_scales_with_all_that_are_active() {
    let kernel = Matern52::isotropic(1.0).active(&[2, 0]) + Linear::ard(&[1.0; 2]).active(&[1, 3]);
    let roles: Vec<Role> = kernel.parameters().into_iter().map(|p| p.role).collect();
    assert_eq!(
        roles,
        [
            Role::Lengthscale { inputs: vec![2, 0] },
            Role::Variance,
            Role::SlopeVariance { inputs: vec![1] },
            Role::SlopeVariance { inputs: vec![3] },
        ]
    );
}

#[test]
fn a_product_has_one_variance_with_the_unit_of_the_output() {
    let roles = |kernel: &dyn Kernel| -> Vec<Role> {
        kernel.parameters().into_iter().map(|p| p.role).collect()
    };
    let product = roles(&(Constant::new(1.0) * White::new(1.0)));
    assert_eq!(product, [Role::Variance, Role::Shape]);
    let product = roles(&(Periodic::new(1.0, 1.0) * White::new(1.0)));
    assert_eq!(product, [Role::Period { inputs: vec![] }, Role::Shape, Role::Variance]);
}

#[test]
fn a_periodic_kernel_repeats_after_its_period() {
    let periodic = Periodic::new(1.5, 0.7);
    assert!((periodic.value(&[0.2], &[0.2 + 3.0 * 1.5]) - 1.0).abs() < 1e-14);
}

#[test]
fn far_apart_inputs_have_no_covariance() {
    for kernel in [
        Box::new(SquaredExponential::unit(1).unwrap()) as Box<dyn Kernel>,
        Box::new(Matern32::unit(1).unwrap()),
        Box::new(Matern52::unit(1).unwrap()),
    ] {
        assert_eq!(kernel.value(&[-1e200], &[1e200]), 0.0);
    }
}
