//! Hyperparameters by name: fixed, bounded, tied, with priors; fitted or kept; saved.

use faer::{Mat, Side};
use gp_core::{
    Constant, Constraints, Gamma, Gp, GpBuilder, GpError, HyperPrior, InverseGamma, Kernel,
    LogNormal, Matern52, Mean, Parameter, Periodic, Prior, SearchSpace, SquaredExponential, gram,
    hyperparameter_names,
};

/// A wave of two inputs with a little disturbance that looks like noise.
fn data() -> (Mat<f64>, Vec<f64>) {
    let x: Mat<f64> = Mat::from_fn(40, 2, |i, d| [0.37 * i as f64 % 2.0, 0.61 * i as f64 % 3.0][d]);
    let disturbance = |i: usize| 0.1 * (17.0 * (i * i) as f64).sin();
    let y = (0..40).map(|i| (2.0 * x[(i, 0)]).sin() + 0.4 * x[(i, 1)] + disturbance(i));
    let y = y.collect();
    (x, y)
}

fn smooth() -> GpBuilder {
    Gp::builder(SquaredExponential::unit(2).unwrap())
}

fn value(gp: &Gp, name: &str) -> f64 {
    gp.hyperparameters().into_iter().find(|(known, _)| known == name).unwrap().1
}

const FIRST: &str = "squared_exponential.lengthscale[0]";
const SECOND: &str = "squared_exponential.lengthscale[1]";
const BOTH: &str = "squared_exponential.lengthscale";
const SIGNAL: &str = "squared_exponential.signal_variance";

#[test]
fn the_report_tells_what_was_learnt() {
    let (x, y) = data();
    let gp = smooth().fit(&x, &y).unwrap();
    let report = gp.report().unwrap();
    let best = report.best.log_marginal_likelihood;
    assert!((gp.log_marginal_likelihood() - best).abs() < 1e-9);
    let values: Vec<f64> = gp.hyperparameters().into_iter().map(|(_, value)| value).collect();
    assert_eq!(report.best.parameters, values);
    assert_eq!(report.names, [FIRST, SECOND, SIGNAL, "noise_variance"]);
    let text = report.to_string();
    assert!(text.contains("noise_variance = ") && text.contains("start 3: ln p"), "{text}");
}

#[test]
fn what_is_fixed_stays_and_the_rest_is_learnt() {
    let (x, y) = data();
    let gp = smooth().fix(FIRST, 0.9).fix("noise_variance", 0.02).fit(&x, &y).unwrap();
    assert_eq!((value(&gp, FIRST), gp.noise_variance()), (0.9, 0.02));
    let slopes = gp.log_marginal_likelihood_gradient().unwrap();
    assert!(slopes[1].abs() < 2e-3 && slopes[2].abs() < 2e-3, "{slopes:?}");
    assert!(slopes[0].abs() > 0.1 && slopes[3].abs() > 0.1, "{slopes:?}");
    let all = smooth().fix(BOTH, 0.9).fix(SIGNAL, 1.5).fix("noise_variance", 0.02);
    let (fitted, kept) = (all.fit(&x, &y).unwrap(), all.condition(&x, &y).unwrap());
    assert_eq!(fitted.log_marginal_likelihood(), kept.log_marginal_likelihood());
    assert!(kept.report().is_none());
}

#[test]
fn a_bound_is_never_left_and_reported_where_it_holds() {
    let (x, y) = data();
    let free = smooth().fit(&x, &y).unwrap();
    let (first, second) = (value(&free, FIRST), value(&free, SECOND));
    let wide = smooth().bound(BOTH, 0.01 * first..100.0 * second).fit(&x, &y).unwrap();
    assert!((value(&wide, FIRST) / first - 1.0).abs() < 1e-3);
    assert!((value(&wide, SECOND) / second - 1.0).abs() < 1e-3);
    assert!(wide.report().unwrap().at_bound.is_empty());
    let short = smooth().bound(FIRST, ..0.5 * first).fit(&x, &y).unwrap();
    let ended = value(&short, FIRST);
    assert!(ended <= 0.5 * first && ended > 0.49 * first, "{ended} of {first}");
    assert_eq!(short.report().unwrap().at_bound, [FIRST]);
    let slopes = short.log_marginal_likelihood_gradient().unwrap();
    assert!(slopes[0] > 0.1 && slopes[1..].iter().all(|s| s.abs() < 2e-3), "{slopes:?}");
    let long = smooth().bound(FIRST, 2.0 * first..).fit(&x, &y).unwrap();
    assert!(value(&long, FIRST) >= 2.0 * first && value(&long, FIRST) < 2.05 * first);
    assert!(long.report().unwrap().to_string().contains("(at its bound)"));
}

#[test]
fn tied_hyperparameters_are_one() {
    let (x, y) = data();
    let tied = smooth().tie(FIRST, SECOND).fit(&x, &y).unwrap();
    assert_eq!(value(&tied, FIRST), value(&tied, SECOND));
    let slopes = tied.log_marginal_likelihood_gradient().unwrap();
    assert!((slopes[0] + slopes[1]).abs() < 2e-3 && slopes[0].abs() > 0.1, "{slopes:?}");
    let all = smooth().tie(BOTH, BOTH).fit(&x, &y).unwrap();
    assert_eq!(all.log_marginal_likelihood(), tied.log_marginal_likelihood());
    // One lengthscale for both inputs is the same model by another name.
    let isotropic = Gp::builder(SquaredExponential::isotropic(1.0)).fit(&x, &y).unwrap();
    let difference = isotropic.log_marginal_likelihood() - tied.log_marginal_likelihood();
    assert!(difference.abs() < 1e-5, "{difference}");
    let kept = smooth().fix(FIRST, 0.7).tie(FIRST, SECOND).noise_variance(0.1);
    let kept = kept.condition(&x, &y).unwrap();
    let values: Vec<f64> = kept.kernel().parameters().iter().map(|p| p.value).collect();
    assert_eq!(values, [0.7, 0.7, 1.0]);
}

#[test]
fn at_the_optimum_the_slopes_of_likelihood_and_priors_cancel() {
    let (x, y) = data();
    let noise = LogNormal::new(-4.0, 0.3).unwrap();
    let (first, second) = (Gamma::new(4.0, 2.0).unwrap(), InverseGamma::new(3.0, 1.5).unwrap());
    let builder = smooth().prior("noise_variance", noise).prior(FIRST, first);
    let gp = builder.prior(SECOND, second).bound(SECOND, 0.01..100.0).fit(&x, &y).unwrap();
    let slopes = gp.log_marginal_likelihood_gradient().unwrap();
    let of_priors = [
        first.log_density(value(&gp, FIRST)).1,
        second.log_density(value(&gp, SECOND)).1,
        0.0,
        noise.log_density(gp.noise_variance()).1,
    ];
    assert!(of_priors.iter().filter(|slope| slope.abs() > 0.1).count() >= 2, "{of_priors:?}");
    for (slope, of_prior) in slopes.iter().zip(of_priors) {
        assert!((slope + of_prior).abs() < 5e-3, "{slopes:?} {of_priors:?}");
    }
}

#[test]
fn slopes_of_priors_equal_finite_differences() {
    let priors: [Box<dyn Prior>; 3] = [
        Box::new(LogNormal::new(-1.0, 0.7).unwrap()),
        Box::new(Gamma::new(2.5, 3.0).unwrap()),
        Box::new(InverseGamma::new(2.5, 3.0).unwrap()),
    ];
    for prior in priors {
        for value in [0.2_f64, 1.0, 4.0] {
            let at = |h: f64| prior.log_density(value * h.exp()).0;
            let expected = (at(1e-5) - at(-1e-5)) / 2e-5;
            let slope = prior.log_density(value).1;
            assert!((slope - expected).abs() < 1e-8 * (1.0 + slope.abs()), "{prior:?} {value}");
        }
    }
    // The mode of ln θ is where the slope vanishes: the median, a/b, and b/a.
    assert!(LogNormal::new(0.3, 2.0).unwrap().log_density(0.3_f64.exp()).1.abs() < 1e-12);
    assert!(Gamma::new(3.0, 6.0).unwrap().log_density(0.5).1.abs() < 1e-12);
    assert!(InverseGamma::new(3.0, 6.0).unwrap().log_density(2.0).1.abs() < 1e-12);
}

#[test]
fn the_noise_variance_is_kept_by_condition_and_a_start_for_fit() {
    let (x, y) = data();
    let builder = smooth().noise_variance(0.3);
    assert_eq!(builder.condition(&x, &y).unwrap().noise_variance(), 0.3);
    let gp = builder.fit(&x, &y).unwrap();
    let start = &gp.report().unwrap().starts[0].as_ref().unwrap().start;
    assert!((start[3] / 0.3 - 1.0).abs() < 1e-12 && gp.noise_variance() < 0.1);
    let start = smooth().start(SIGNAL, 7.0).fit(&x, &y).unwrap();
    let first = start.report().unwrap().starts[0].as_ref().unwrap();
    assert!((first.start[2] / 7.0 - 1.0).abs() < 1e-12);
}

#[test]
fn wishes_that_cannot_be_met_are_errors() {
    let (x, y) = data();
    let refused = |builder: GpBuilder| {
        let error = builder.fit(&x, &y).unwrap_err();
        let kept = builder.noise_variance(0.1).condition(&x, &y).unwrap_err();
        assert_eq!(error.to_string(), kept.to_string());
        error
    };
    let error = refused(smooth().fix("lengthscale", 1.0));
    assert!(matches!(&error, GpError::UnknownParameter { name, .. } if name == "lengthscale"));
    assert!(error.to_string().contains(FIRST), "{error}");
    // A beginning of a name is none.
    assert!(matches!(refused(smooth().fix("squared_exp", 1.0)), GpError::UnknownParameter { .. }));
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(refused(smooth().fix(FIRST, bad)), GpError::NotPositive { .. }));
        assert!(matches!(refused(smooth().start(FIRST, bad)), GpError::NotPositive { .. }));
    }
    for (low, high) in [(2.0, 1.0), (1.0, 1.0), (-1.0, 1.0), (f64::NAN, 1.0), (1.0, f64::NAN)] {
        let error = refused(smooth().bound(FIRST, low..high));
        assert!(matches!(error, GpError::OutOfRange { .. }), "{error}");
    }
    let outside = refused(smooth().bound(FIRST, 0.1..1.0).fix(FIRST, 2.0));
    assert!(matches!(outside, GpError::OutOfRange { value: 2.0, .. }));
    let contradiction = smooth().fix(FIRST, 1.0).fix(SECOND, 2.0).tie(FIRST, SECOND);
    assert!(matches!(refused(contradiction), GpError::Incompatible { .. }));
    let apart = smooth().bound(FIRST, ..1.0).bound(SECOND, 2.0..).tie(FIRST, SECOND);
    assert!(matches!(refused(apart), GpError::Incompatible { .. }));
    let kept = smooth().bound(FIRST, 2.0..3.0).noise_variance(0.1).condition(&x, &y);
    assert!(matches!(kept, Err(GpError::OutOfRange { value: 1.0, .. })));
    assert_eq!(smooth().condition(&x, &y).unwrap_err(), GpError::NoNoiseVariance);
    let noise = smooth().row_noise(&[0.1]).noise_variance(0.1);
    assert!(matches!(noise.condition(&x, &y), Err(GpError::ShapeMismatch { .. })));
    for result in [LogNormal::new(f64::NAN, 1.0).err(), LogNormal::new(0.0, 0.0).err()] {
        assert!(result.is_some());
    }
    assert!(Gamma::new(1.0, -1.0).is_err() && InverseGamma::new(0.0, 1.0).is_err());
}

#[test]
fn inputs_come_as_matrices_rows_or_numbers() {
    let (x, y) = data();
    let rows: Vec<[f64; 2]> = (0..40).map(|i| [x[(i, 0)], x[(i, 1)]]).collect();
    let builder = smooth().noise_variance(0.1);
    let (by_matrix, by_rows) = (builder.condition(&x, &y), builder.condition(&rows, &y));
    let (by_matrix, by_rows) = (by_matrix.unwrap(), by_rows.unwrap());
    assert_eq!(by_matrix.predict(&x).unwrap(), by_rows.predict(&rows).unwrap());
    assert_eq!(by_matrix.predict(&rows[..3]).unwrap(), by_rows.predict(x.subrows(0, 3)).unwrap());
    let one = Gp::builder(Matern52::isotropic(1.0)).noise_variance(0.1);
    let times: Vec<f64> = (0..40).map(|i| 0.1 * i as f64).collect();
    let column = Mat::from_fn(40, 1, |i, _| times[i]);
    let (by_numbers, by_column) = (one.condition(&times, &y), one.condition(&column, &y));
    let (by_numbers, by_column) = (by_numbers.unwrap(), by_column.unwrap());
    assert_eq!(by_numbers.predict(&[0.5, 0.7]).unwrap(), by_column.predict(&[0.5, 0.7]).unwrap());
    assert!(matches!(builder.condition(&times, &y), Err(GpError::ShapeMismatch { .. })));
}

#[test]
fn a_process_is_saved_and_read_as_it_was() {
    let (x, y) = data();
    let kernel = (Matern52::isotropic(1.0) + Constant::new(0.5)) * Periodic::new(1.3, 2.0);
    let builder = Gp::builder(kernel).noise_variance(0.02).mean(Mean::Linear);
    let gp = builder.condition(&x, &y).unwrap();
    let text = serde_json::to_string(&gp).unwrap();
    let read: Gp = serde_json::from_str(&text).unwrap();
    assert_eq!(read.predict(&x).unwrap(), gp.predict(&x).unwrap());
    assert_eq!(serde_json::to_string(&read).unwrap(), text);
    assert!(serde_json::from_str::<Gp>(&text.replace("0.02", "-1.0")).is_err());

    /// A kernel without plain data.
    #[derive(Debug)]
    struct Own;
    impl Kernel for Own {
        fn value(&self, a: &[f64], b: &[f64]) -> f64 {
            a[0] * b[0]
        }
        fn parameters(&self) -> Vec<Parameter> {
            Vec::new()
        }
        fn with_values(&self, _values: &[f64]) -> Box<dyn Kernel> {
            Box::new(Self)
        }
        fn parameter_gradient(&self, _a: &[f64], _b: &[f64], _gradient: &mut [f64]) {}
        fn input_gradient(&self, _a: &[f64], b: &[f64], gradient: &mut [f64]) {
            gradient.copy_from_slice(&[b[0], 0.0]);
        }
    }
    let own = Gp::builder(Constant::new(1.0) + Own).noise_variance(0.1).condition(&x, &y).unwrap();
    let error = serde_json::to_string(&own).unwrap_err().to_string();
    assert!(error.contains("no `KernelSpec`"), "{error}");
}

#[test]
fn the_condition_number_is_that_of_the_covariance() {
    let (x, y) = data();
    for noise_variance in [1e-4, 0.1, 10.0] {
        let gp = smooth().noise_variance(noise_variance).condition(&x, &y).unwrap();
        let mut covariance = gram(gp.kernel(), x.as_ref()).unwrap();
        (0..40).for_each(|i| covariance[(i, i)] += noise_variance);
        let eigenvalues = covariance.self_adjoint_eigenvalues(Side::Lower).unwrap();
        let exact = eigenvalues[39] / eigenvalues[0];
        let ratio = gp.condition_number() / exact;
        assert!(ratio > 0.5 && ratio < 1.0 + 1e-9, "{ratio} of {exact}");
    }
}

#[test]
fn what_is_asked_enters_objectives_with_the_slopes_of_differences() {
    let (x, y) = data();
    let kernel = SquaredExponential::unit(2).unwrap();
    let names = hyperparameter_names(&kernel);
    let mut asked = Constraints::default();
    asked.bound(FIRST, 0.3..4.0);
    asked.prior(FIRST, Gamma::new(4.0, 2.0).unwrap());
    asked.prior("noise_variance", LogNormal::new(-4.0, 0.3).unwrap());
    asked.tie(FIRST, SECOND);
    asked.fix(SIGNAL, 1.5);
    let prior = HyperPrior::LogNormal { lengthscale_sd: 0.7, scale_sd: 0.5 };
    let space = SearchSpace::new(&kernel, x.as_ref(), &y, prior);
    let space = space.constrained(&names, &asked).unwrap();
    assert_eq!(space.n_coordinates(), 2);
    // ln θ of all, weighed, stands for a likelihood.
    let weights = [0.3, -1.2, 0.7, 2.0];
    let objective = |point: &[f64], gradient: &mut [f64]| {
        space.by_coordinates(point, &weights, gradient);
        let values = space.parameters(point);
        assert!(values[0] == values[1] && values[2] == 1.5, "{values:?}");
        let sum: f64 = weights.iter().zip(&values).map(|(w, value)| w * value.ln()).sum();
        space.penalty(point, gradient) + sum
    };
    for point in [[0.3, -1.0], [-2.0, 0.4], [1.7, -30.0]] {
        let mut gradient = [0.0; 2];
        objective(&point, &mut gradient);
        for c in 0..2 {
            let at = |step: f64| {
                let mut moved = point;
                moved[c] += step;
                objective(&moved, &mut [0.0; 2])
            };
            let numeric = (at(1e-5) - at(-1e-5)) / 2e-5;
            let close = (gradient[c] - numeric).abs() < 1e-6 * (1.0 + numeric.abs());
            assert!(close, "{point:?} {c}: {} {numeric}", gradient[c]);
        }
    }
}
