//! Several outputs together, and outputs on another scale.

use faer::{Mat, Side};
use gp_core::{
    Coregionalization, Gp, GpBuilder, GpError, Kernel, LearnOptions, Mean, Posterior,
    SquaredExponential, Transform, Warped, White, gram,
};

fn line(n: usize) -> Vec<f64> {
    (0..n).map(|i| 0.1 * i as f64).collect()
}

fn disturbance(i: usize) -> f64 {
    0.05 * (17.0 * (i * i) as f64).sin()
}

#[test]
fn covariances_of_outputs_are_those_of_their_odds() {
    // ρ = (4 − 1)/(4 + 1).
    let two = Coregionalization::from_odds(&[4.0, 9.0], &[4.0]);
    assert!((two.covariance(0, 1) - 6.0 * 0.6).abs() < 1e-14);
    assert!((two.covariance(1, 1) - 9.0).abs() < 1e-14);
    assert_eq!(two.value(&[0.2], &[1.4]), two.covariance(0, 1));
    // Of three outputs the third's row is (ρ₂₀, ρ₂₁ √(1 − ρ₂₀²), …).
    let three = Coregionalization::from_odds(&[1.0; 3], &[4.0, 1.0 / 3.0, 9.0]);
    let expected = -0.5 * 0.6 + 0.8 * (0.75_f64.sqrt() * 0.8);
    assert!((three.covariance(2, 1) - expected).abs() < 1e-14, "{}", three.covariance(2, 1));
    let extreme = Coregionalization::from_odds(&[1.0; 4], &[1e30, 1e-30, 1e9, 1e-9, 1.0, 1e300]);
    let numbers = Mat::from_fn(4, 1, |i, _| i as f64);
    let covariance = gram(&extreme, numbers.as_ref()).unwrap();
    let eigenvalues = covariance.self_adjoint_eigenvalues(Side::Lower).unwrap();
    assert!(eigenvalues[0] > -1e-14, "{eigenvalues:?}");
    assert!((0..4).all(|i| (covariance[(i, i)] - 1.0).abs() < 1e-14));
}

#[test]
fn outputs_that_share_nothing_are_processes_of_their_own() {
    let x = line(15);
    let outputs: Vec<Vec<Option<f64>>> = [1.0, 2.5]
        .map(|rate| x.iter().map(|x| (x * rate < 3.0).then(|| (rate * x).sin())).collect())
        .to_vec();
    let (stacked, y) = Coregionalization::stack(&x, &outputs).unwrap();
    assert_eq!(y.len(), 15 + 12);
    let smooth = || SquaredExponential::isotropic(0.7);
    let kernel = smooth().active(&[0]) * Coregionalization::independent(2).active(&[1]);
    let known =
        |kernel: Box<dyn Kernel>| Gp::builder(kernel).noise_variance(0.01).mean(Mean::Fixed(0.0));
    let together = known(Box::new(kernel)).condition(&stacked, &y).unwrap();
    let alone = |k: usize| {
        let (x, y): (Vec<f64>, Vec<f64>) =
            x.iter().zip(&outputs[k]).filter_map(|(x, y)| Some((*x, (*y)?))).unzip();
        known(Box::new(smooth())).condition(&x, &y).unwrap()
    };
    let sum = alone(0).log_marginal_likelihood() + alone(1).log_marginal_likelihood();
    assert!((together.log_marginal_likelihood() - sum).abs() < 1e-10);
    let places = [0.33, 1.41];
    let (mean, variance) = together.predict(&Coregionalization::inputs_of(&places, 1)).unwrap();
    let (own_mean, own_variance) = alone(1).predict(&places).unwrap();
    for i in 0..2 {
        assert!((mean[i] - own_mean[i]).abs() < 1e-12);
        assert!((variance[i] - own_variance[i]).abs() < 1e-12);
    }
}

#[test]
fn an_output_is_predicted_where_only_its_sibling_was_seen() {
    let x = line(60);
    let wave = |x: f64| (2.0 * x).sin() + 0.3 * x;
    let first = |i: usize| Some(wave(x[i]) + disturbance(i));
    // The second output is minus twice the first, and was seen on the left alone.
    let second = |i: usize| (i < 25).then(|| -2.0 * wave(x[i]) + disturbance(3 * i + 1));
    let outputs = [(0..60).map(first).collect(), (0..60).map(second).collect()];
    let (stacked, y) = Coregionalization::stack(&x, &outputs).unwrap();
    let kernel = SquaredExponential::isotropic(1.0).active(&[0])
        * Coregionalization::new(2).active(&[1])
        + Coregionalization::independent(2).active(&[1]) * White::new(1.0);
    let builder = Gp::builder(kernel).mean(Mean::Fixed(0.0)).fix("white.variance", 1.0);
    let builder = builder.fix("squared_exponential.signal_variance", 1.0);
    let gp = builder.fix("noise_variance", 1e-5).fit(&stacked, &y).unwrap();
    let right = Coregionalization::inputs_of(&x[30..], 1);
    let (mean, variance) = gp.predict(&right).unwrap();
    let truth: Vec<f64> = x[30..].iter().map(|x| -2.0 * wave(*x)).collect();
    let error = gp_core::scores::rmse(&truth, &mean).unwrap();
    assert!(error < 0.1, "{error}");
    let inside = (0..30).filter(|&i| (truth[i] - mean[i]).powi(2) < 4.0 * variance[i]).count();
    assert!(inside >= 25, "{inside} of 30");
    // Its own rows alone tell nothing there.
    let own: Vec<f64> = (0..25).map(|i| second(i).unwrap()).collect();
    let alone = Gp::builder(SquaredExponential::isotropic(1.0)).mean(Mean::Fixed(0.0));
    let alone = alone.fit(&x[..25], &own).unwrap().predict_mean(right.subcols(0, 1)).unwrap();
    assert!(gp_core::scores::rmse(&truth, &alone).unwrap() > 10.0 * error);
    let odds = gp.hyperparameters().into_iter().find(|(name, _)| name.contains("odds")).unwrap();
    assert_eq!(odds.0, "coregionalization.odds[1,0]");
    assert!(odds.1 < 0.02, "outputs of opposite signs: {odds:?}");
}

#[test]
fn stacks_and_kernels_of_outputs_that_do_not_fit() {
    let stack = |outputs: &[Vec<Option<f64>>]| Coregionalization::stack(&line(2), outputs);
    let short = stack(&[vec![Some(1.0)]]).unwrap_err();
    assert_eq!(short, GpError::ShapeMismatch { what: "outputs", expected: 2, actual: 1 });
    assert_eq!(stack(&[vec![None; 2]]).unwrap_err(), GpError::Empty { what: "outputs" });
    assert!(matches!(stack(&[vec![Some(f64::NAN), None]]), Err(GpError::NotFinite { .. })));
    let one = Mat::zeros(1, 1);
    let refused = |kernel: Coregionalization| gram(&kernel, one.as_ref()).unwrap_err();
    assert!(matches!(refused(Coregionalization::new(0)), GpError::Empty { .. }));
    let odd = Coregionalization::from_odds(&[1.0; 3], &[1.0; 2]);
    assert!(matches!(refused(odd), GpError::ShapeMismatch { expected: 3, actual: 2, .. }));
    let bad = Coregionalization::from_odds(&[1.0; 2], &[-1.0]);
    assert!(matches!(refused(bad), GpError::NotPositive { .. }));
    assert_eq!(Coregionalization::new(0).value(&[0.0], &[0.0]), 0.0);
}

fn growing() -> (Vec<f64>, Vec<f64>) {
    let x = line(60);
    let y = (0..60).map(|i| (x[i].sin() + disturbance(i)).exp()).collect();
    (x, y)
}

fn warped(transform: Transform) -> Warped<Gp> {
    let (x, y) = growing();
    let builder = Gp::builder(SquaredExponential::isotropic(1.0)).noise_variance(0.002);
    Warped::fit(transform, &y, |z| builder.condition(&x, z)).unwrap()
}

#[test]
fn a_log_warped_process_is_log_normal() {
    let gp = warped(Transform::Log);
    let places = [1.23, 7.0];
    let (mean, variance) = {
        let column = Mat::from_fn(2, 1, |i, _| places[i]);
        gp.latent().predict_observation(column.as_ref()).unwrap()
    };
    let quantiles = gp.quantiles(&places, &[0.5, 0.975]).unwrap();
    let moments = gp.moments(&places).unwrap();
    for i in 0..2 {
        assert!((quantiles[(i, 0)] / mean[i].exp() - 1.0).abs() < 1e-12);
        let upper = (mean[i] + 1.959_963_984_540_054 * variance[i].sqrt()).exp();
        assert!((quantiles[(i, 1)] / upper - 1.0).abs() < 1e-12);
        let center = (mean[i] + 0.5 * variance[i]).exp();
        assert!((moments.0[i] / center - 1.0).abs() < 1e-12);
        assert!((moments.1[i] / (center * center * variance[i].exp_m1()) - 1.0).abs() < 1e-12);
    }
    // The numerical moments of a power next to 0 are those of the logarithm.
    let almost = warped(Transform::BoxCox(1e-7)).moments(&places).unwrap();
    for i in 0..2 {
        assert!((almost.0[i] / moments.0[i] - 1.0).abs() < 1e-5, "{almost:?} {moments:?}");
        assert!((almost.1[i] / moments.1[i] - 1.0).abs() < 1e-4, "{almost:?} {moments:?}");
    }
}

#[test]
fn densities_of_warped_observations_integrate_to_one() {
    for transform in [Transform::Log, Transform::BoxCox(0.5), Transform::BoxCox(1.0)] {
        let gp = warped(transform);
        let step = 0.002;
        let outputs: Vec<f64> = (1..5000).map(|i| step * f64::from(i)).collect();
        let place = vec![1.23; outputs.len()];
        let densities = gp.log_density(&place, &outputs).unwrap();
        let total: f64 = densities.iter().map(|log| step * log.exp()).sum();
        assert!((total - 1.0).abs() < 1e-6, "{transform:?} {total}");
        let mean: f64 = densities.iter().zip(&outputs).map(|(log, y)| step * y * log.exp()).sum();
        assert!((mean - gp.moments(&[1.23]).unwrap().0[0]).abs() < 1e-5, "{transform:?}");
    }
}

#[test]
fn the_power_that_made_the_outputs_is_found() {
    let x = line(80);
    let process = Gp::builder(SquaredExponential::isotropic(1.0));
    let process = process.options(gp_core::LearnOptions { n_starts: 1, ..Default::default() });
    for power in [0.0, 0.5, 1.0] {
        let y: Vec<f64> = (0..80)
            .map(|i| Transform::BoxCox(power).inverse(3.0 + 2.0 * x[i].sin() + disturbance(i)))
            .collect();
        let likelihood = |z: &[f64]| Ok(process.fit(&x, z)?.log_marginal_likelihood());
        let found = Transform::box_cox(&y, likelihood).unwrap();
        let Transform::BoxCox(found) = found else { panic!("{found:?}") };
        assert!((found - power).abs() < 0.15, "{found} instead of {power}");
    }
}

#[test]
fn transforms_and_what_they_refuse() {
    for transform in [Transform::Log, Transform::BoxCox(0.0), Transform::BoxCox(0.3)] {
        for y in [1e-3, 0.7, 20.0] {
            let z = transform.forward(&[y]).unwrap()[0];
            assert!((transform.inverse(z) / y - 1.0).abs() < 1e-13, "{transform:?} {y}");
        }
    }
    assert_eq!(Transform::BoxCox(0.5).inverse(-2.5), 0.0);
    let refused = |y: &[f64]| Transform::Log.forward(y).unwrap_err();
    assert!(matches!(refused(&[1.0, 0.0]), GpError::NotPositive { value: 0.0, .. }));
    assert!(matches!(refused(&[1.0, f64::NAN]), GpError::NotFinite { row: 1, .. }));
    assert!(matches!(refused(&[]), GpError::Empty { .. }));
    for power in [-0.1, 2.1, f64::NAN] {
        let error = Transform::BoxCox(power).forward(&[1.0]).unwrap_err();
        assert!(matches!(error, GpError::OutOfRange { .. }), "{error}");
    }
    let gp = warped(Transform::Log);
    assert!(matches!(gp.quantiles(&[1.0], &[1.0]), Err(GpError::InvalidLevel { .. })));
    assert!(matches!(gp.log_density(&[1.0], &[]), Err(GpError::ShapeMismatch { .. })));
    assert!(matches!(gp.moments(&[f64::NAN]), Err(GpError::NotFinite { .. })));
    let text = serde_json::to_string(&gp).unwrap();
    let read: Warped<Gp> = serde_json::from_str(&text).unwrap();
    assert_eq!(read.moments(&[1.0]).unwrap(), gp.moments(&[1.0]).unwrap());
}

#[test]
fn outputs_of_a_rank_are_sums_of_so_many_functions_and_their_own() {
    let kernel = Coregionalization::with_rank(4, 2);
    let names: Vec<String> = kernel.parameters().into_iter().map(|p| p.name).collect();
    assert_eq!(names.len(), 4 + 7);
    assert_eq!(names[4..6], ["coregionalization.odds[0,0]", "coregionalization.odds[1,0]"]);
    // Less the part of each output alone, the covariance has the rank.
    let numbers = Mat::from_fn(4, 1, |i, _| i as f64);
    let odds = [2.0, 3.0, 0.5, 0.25, 4.0, 5.0, 1.5];
    let values: Vec<f64> = [1.0, 2.0, 0.5, 3.0].into_iter().chain(odds).collect();
    let moved = kernel.with_parameters(&values).unwrap();
    let rho = |odds: f64| (odds - 1.0) / (odds + 1.0);
    let row = |i: usize| match i {
        0 => (rho(2.0), 0.0),
        _ => {
            let (a, b) = (rho(odds[2 * i - 1]), rho(odds[2 * i]));
            (a, b * (1.0 - a * a).sqrt())
        }
    };
    let covariance = gram(&*moved, numbers.as_ref()).unwrap();
    for i in 0..4 {
        assert!((covariance[(i, i)] - values[i]).abs() < 1e-14);
        for j in 0..i {
            let shared = row(i).0 * row(j).0 + row(i).1 * row(j).1;
            let expected = (values[i] * values[j]).sqrt() * shared;
            assert!((covariance[(i, j)] - expected).abs() < 1e-14, "{i} {j}");
        }
    }
    // Its slopes are those of differences.
    let mut slopes = vec![0.0; 11];
    for (i, j) in [(0, 0), (1, 0), (3, 1), (3, 2)] {
        moved.parameter_gradient(&[i as f64], &[j as f64], &mut slopes);
        for (k, slope) in slopes.iter().enumerate() {
            let at = |step: f64| {
                let mut values = values.clone();
                values[k] *= step.exp();
                let kernel = moved.with_parameters(&values).unwrap();
                kernel.value(&[i as f64], &[j as f64])
            };
            let numeric = (at(1e-5) - at(-1e-5)) / 2e-5;
            assert!((slope - numeric).abs() < 1e-9, "{i} {j} {k} {slope} {numeric}");
        }
    }
    let again = moved.spec().unwrap().build();
    assert_eq!(again.value(&[3.0], &[1.0]), moved.value(&[3.0], &[1.0]));
    assert!(Coregionalization::with_rank(3, 4).check(1).is_err());
    assert!(Coregionalization::with_rank(3, 0).check(1).is_err());
}

#[test]
fn the_rank_of_outputs_is_learnt() {
    let x = line(14);
    let (first, second) = (|x: f64| (3.0 * x).sin(), |x: f64| (2.0 * x + 1.0).cos());
    let weights = [[1.0, 0.0], [0.8, 0.0], [-1.2, 0.0], [0.5, 0.0]];
    let outputs = |share: f64| -> Vec<Vec<Option<f64>>> {
        let output = |k: usize| {
            let value = move |(i, x): (usize, &f64)| {
                let other = share * [0.9, -0.7, 0.4, 1.1][k];
                let noise = 0.02 * (17.0 * (i * i + 31 * k) as f64).sin();
                Some(weights[k][0] * first(*x) + other * second(*x) + noise)
            };
            x.iter().enumerate().map(value).collect()
        };
        (0..4).map(output).collect()
    };
    let chosen = |share: f64| {
        let (stacked, y) = Coregionalization::stack(&x, &outputs(share)).unwrap();
        let setting = |rank: usize| {
            let smooth = SquaredExponential::isotropic(1.0).active(&[0]);
            let kernel = smooth * Coregionalization::with_rank(4, rank).active(&[1]);
            // More functions than there are lie in a flat valley.
            let options =
                LearnOptions { n_starts: 1, max_iterations: 500, ..LearnOptions::default() };
            Gp::builder(kernel)
                .fix("squared_exponential.signal_variance", 1.0)
                .options(LearnOptions { mean: Mean::Fixed(0.0), ..options })
        };
        let settings = [setting(1), setting(2)];
        GpBuilder::fit_best(&settings, &stacked, &y).unwrap()
    };
    assert_eq!(chosen(0.0).0, 0);
    let (place, gp) = chosen(1.0);
    assert_eq!(place, 1);
    assert!(gp.noise_variance() < 0.01, "{}", gp.noise_variance());
}

#[test]
fn settings_that_cannot_be_compared_are_an_error() {
    let x = line(8);
    let y: Vec<f64> = x.iter().map(|x| x.sin()).collect();
    let smooth = || Gp::builder(SquaredExponential::isotropic(1.0));
    let error = GpBuilder::fit_best(&[], &x, &y).unwrap_err();
    assert_eq!(error, GpError::Empty { what: "settings" });
    let error = GpBuilder::fit_best(&[smooth(), smooth().mean(Mean::Linear)], &x, &y).unwrap_err();
    assert_eq!(error, GpError::Incompatible { what: "means of the settings" });
}
