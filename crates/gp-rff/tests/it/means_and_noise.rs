//! Learnt polynomials as means, and rows with noise of their own.

use faer::linalg::solvers::{DenseSolveCore, Llt};
use faer::{Mat, Side};
use gp_core::{GpError, Mean, Monomials, Posterior};
use gp_rff::{
    FeatureOptions, Form, RandomFeatures, RffGp, RffGpModel, Spectrum, SufficientStatistics,
};

const MEANS: [Mean; 4] = [Mean::Fixed(0.3), Mean::Estimated, Mean::Linear, Mean::Polynomial(2)];
const SIGNAL_VARIANCE: f64 = 1.7;
const NOISE_VARIANCE: f64 = 0.05;

fn data(n: usize) -> (Mat<f64>, Vec<f64>, Vec<f64>) {
    let turn = |i: usize, d: usize| 1.7 * (2 * i + d) as f64 + 0.9 * (i * i * (d + 1)) as f64;
    let x = Mat::from_fn(n, 2, |i, d| 1.5 * (turn(i, d) + 0.3).sin() + 1.0);
    let y = (0..n).map(|i| (1.3 * x[(i, 0)]).sin() + 2.0 * x[(i, 1)] - 0.3 * x[(i, 0)].powi(2));
    let y = y.collect();
    (x, y, (0..n).map(|i| 0.04 * (i % 4) as f64).collect())
}

fn features(form: Form) -> RandomFeatures {
    let options = FeatureOptions { n_features: 20, form, ..FeatureOptions::default() };
    RandomFeatures::new(Spectrum::Matern52, &[0.7, 0.9], options).unwrap()
}

fn process(n: usize, noise: &[f64], mean: Mean) -> RffGp {
    let (x, y, _) = data(n);
    let data = (x.as_ref(), &*y, noise);
    RffGp::fit_with(features(Form::Paired), data, SIGNAL_VARIANCE, NOISE_VARIANCE, mean).unwrap()
}

fn far() -> Mat<f64> {
    Mat::from_fn(6, 2, |i, d| 2.0 * (i + d) as f64 - 3.0)
}

/// Means, covariance and ln p(y) by matrices written out: y = H β + s Φ w + noise.
fn written_out(n: usize, noise: &[f64], mean: Mean) -> (Mat<f64>, Mat<f64>, f64) {
    let (x, y, _) = data(n);
    let features = features(Form::Paired);
    let (phi, phi_star) = (features.evaluate(x.as_ref()), features.evaluate(far().as_ref()));
    let (phi, phi_star) = (phi.unwrap(), phi_star.unwrap());
    let mut covariance = SIGNAL_VARIANCE * &(&phi * phi.transpose());
    for i in 0..n {
        covariance[(i, i)] += NOISE_VARIANCE + noise.get(i).copied().unwrap_or(0.0);
    }
    let llt = |matrix: &Mat<f64>| Llt::new(matrix.as_ref(), Side::Lower).unwrap();
    let log_determinant = |matrix: &Mat<f64>| {
        let factor = llt(matrix);
        (0..matrix.nrows()).map(|i| 2.0 * factor.L()[(i, i)].ln()).sum::<f64>()
    };
    let precision = llt(&covariance).inverse();
    let cross = SIGNAL_VARIANCE * &(&phi_star * phi.transpose());
    let gain = &cross * &precision;
    let prior = SIGNAL_VARIANCE * &(&phi_star * phi_star.transpose());
    let mut spread = prior - &gain * cross.transpose();
    let outputs = Mat::from_fn(n, 1, |i, _| y[i]);
    let tau = std::f64::consts::TAU.ln();
    let density = |residual: &Mat<f64>, told: usize| {
        let quadratic = (residual.transpose() * &precision * residual)[(0, 0)];
        -0.5 * (quadratic + log_determinant(&covariance) + told as f64 * tau)
    };
    let Some(degree) = mean.degree() else {
        let Mean::Fixed(value) = mean else { unreachable!() };
        let residual = Mat::from_fn(n, 1, |i, _| y[i] - value);
        let means = &gain * &residual + Mat::full(6, 1, value);
        return (means, spread, density(&residual, n));
    };
    let monomials = Monomials::new(degree, &[0.0, 0.0]);
    let basis = |x: &Mat<f64>| {
        let columns = monomials.columns(x.as_ref());
        Mat::from_fn(x.nrows(), columns.len(), |i, k| columns[k][i])
    };
    let (h, h_star) = (basis(&x), basis(&far()));
    let told = h.transpose() * &precision * &h;
    let of_told = llt(&told).inverse();
    let beta = &of_told * (h.transpose() * &precision * &outputs);
    let residual = &outputs - &h * &beta;
    let left = &h_star - &gain * &h;
    spread += &left * &of_told * left.transpose();
    let p = monomials.count();
    let of_mean = log_determinant(&told) - log_determinant(&(h.transpose() * &h));
    let value = density(&residual, n - p) - 0.5 * of_mean;
    (&h_star * &beta + &gain * &residual, spread, value)
}

#[test]
fn every_mean_and_noise_is_the_linear_model_written_out() {
    for mean in MEANS {
        for noise in [Vec::new(), data(40).2] {
            let gp = process(40, &noise, mean);
            let (means, covariance, value) = written_out(40, &noise, mean);
            let joint = gp.predict_joint(far().as_ref()).unwrap();
            let scale = 1.0 + covariance.norm_max();
            let apart = (joint.covariance() - &covariance).norm_max() / scale;
            assert!(apart < 1e-9, "{mean:?} {apart}");
            let (predicted, variance) = gp.predict(far().as_ref()).unwrap();
            for i in 0..6 {
                let size = 1.0 + means[(i, 0)].abs();
                assert!((joint.mean()[i] - means[(i, 0)]).abs() < 1e-9 * size, "{mean:?} {i}");
                assert!((predicted[i] - means[(i, 0)]).abs() < 1e-9 * size, "{mean:?} {i}");
                assert!((variance[i] - covariance[(i, i)]).abs() < 1e-9 * scale, "{mean:?} {i}");
            }
            let apart = gp.log_evidence() - value;
            assert!(apart.abs() < 1e-9 * (1.0 + value.abs()), "{mean:?} {apart}");
        }
    }
}

#[test]
fn gradients_beside_noise_of_rows_and_polynomials_are_those_of_differences() {
    let (x, y, noise) = data(300);
    for (mean, form) in MEANS.into_iter().zip([Form::Paired, Form::Cosines].into_iter().cycle()) {
        let fit = |values: [f64; 4]| {
            let features = features(form).with_lengthscales(&values[..2]).unwrap();
            RffGp::fit_with(features, (x.as_ref(), &y, &noise), values[2], values[3], mean).unwrap()
        };
        let values = [0.7, 0.9, SIGNAL_VARIANCE, NOISE_VARIANCE];
        let mut evaluator = fit(values).evaluator_with_row_noise(x.as_ref(), &y, &noise).unwrap();
        let value = evaluator.evaluate().unwrap();
        assert!((value - fit(values).log_evidence()).abs() < 1e-9 * value.abs());
        for (index, slope) in evaluator.gradient().iter().enumerate() {
            let at = |step: f64| {
                let mut values = values;
                values[index] *= step.exp();
                fit(values).log_evidence()
            };
            let numeric = (at(1e-5) - at(-1e-5)) / 2e-5;
            let close = (slope - numeric).abs() < 1e-5 * (1.0 + numeric.abs());
            assert!(close, "{mean:?} {form:?} {index} {slope} {numeric}");
        }
    }
}

#[test]
fn noise_that_is_the_same_of_all_rows_is_common_noise() {
    let (x, y, _) = data(40);
    for mean in MEANS {
        let split = (x.as_ref(), &*y, &[0.03; 40][..]);
        let paired = || features(Form::Paired);
        let split = RffGp::fit_with(paired(), split, SIGNAL_VARIANCE, 0.02, mean).unwrap();
        let common = process(40, &[], mean);
        let [a, b] = [&split, &common].map(|one| one.predict_joint(far().as_ref()).unwrap());
        let scale = 1.0 + b.covariance().norm_max();
        assert!((a.covariance() - b.covariance()).norm_max() < 1e-9 * scale, "{mean:?}");
        assert!((split.log_evidence() - common.log_evidence()).abs() < 1e-8, "{mean:?}");
    }
}

#[test]
fn rows_that_come_later_are_as_if_they_had_been_there() {
    let (x, y, noise) = data(400);
    for mean in MEANS {
        let whole = process(400, &noise, mean);
        let mut statistics = whole.statistics().clone();
        let features = features(Form::Paired);
        let fit = |statistics: &SufficientStatistics| {
            let features = features.clone();
            let (signal, noise) = (SIGNAL_VARIANCE, NOISE_VARIANCE);
            RffGp::from_statistics(features, statistics.clone(), signal, noise, mean).unwrap()
        };
        assert_eq!(bits(&fit(&statistics)), bits(&whole));
        // Half of the rows on another machine.
        let part = |rows: std::ops::Range<usize>| {
            let own = SufficientStatistics::new(&features, 0.5).unwrap();
            let own = own.with_mean(&features, mean, &[1.0, 1.0]).unwrap();
            let mut own = own.with_row_noise(NOISE_VARIANCE).unwrap();
            let x = x.subrows(rows.start, rows.len());
            own.update_with_row_noise(&features, x, &y[rows.clone()], &noise[rows]).unwrap();
            own
        };
        let mut merged = part(0..150);
        merged.merge(&part(150..400)).unwrap();
        close(&fit(&merged), &whole);
        // The first rows without noise, so that the statistics learn late that there is any.
        let plain = SufficientStatistics::new(&features, 0.5).unwrap();
        let mut plain = plain.with_mean(&features, mean, &[1.0, 1.0]).unwrap();
        plain.update(&features, x.subrows(0, 100), &y[..100]).unwrap();
        let mut late = fit(&plain);
        late.update_with_row_noise(x.subrows(100, 300), &y[100..], &noise[100..]).unwrap();
        let mut own_noise = noise.clone();
        own_noise[..100].fill(0.0);
        close(&late, &process(400, &own_noise, mean));
        let clash = statistics.merge(&plain).unwrap_err();
        assert!(matches!(clash, GpError::Incompatible { .. }), "{clash}");
    }
}

fn bits(gp: &RffGp) -> Vec<u64> {
    let (mean, variance) = gp.predict(far().as_ref()).unwrap();
    mean.iter().chain(&variance).map(|value| value.to_bits()).collect()
}

fn close(a: &RffGp, b: &RffGp) {
    let [c, d] = [a, b].map(|one| one.predict_joint(far().as_ref()).unwrap());
    let scale = 1.0 + d.covariance().norm_max();
    assert!((c.covariance() - d.covariance()).norm_max() < 1e-8 * scale);
    assert!(c.mean().iter().zip(d.mean()).all(|(c, d)| (c - d).abs() < 1e-8 * (1.0 + d.abs())));
    assert!((a.log_evidence() - b.log_evidence()).abs() < 1e-7);
    assert!((a.mean() - b.mean()).abs() < 1e-7);
}

#[test]
fn a_saved_model_predicts_the_same_bits_and_goes_on_learning() {
    let (x, y, noise) = data(60);
    for mean in MEANS {
        let mut gp = process(60, &noise, mean);
        let text = serde_json::to_string(&gp).unwrap();
        let mut read: RffGp = serde_json::from_str(&text).unwrap();
        assert_eq!(bits(&read), bits(&gp));
        for one in [&mut gp, &mut read] {
            one.update_with_row_noise(x.subrows(0, 9), &y[..9], &noise[..9]).unwrap();
        }
        assert_eq!(gp.to_model(), read.to_model());
    }
    let text = serde_json::to_string(&process(60, &noise, Mean::Linear)).unwrap();
    for (from, to, what) in [
        ("\"degree\":1", "\"degree\":2", "sums of the statistics"),
        ("\"degree\":1", "\"degree\":99", "degree of the mean"),
        ("\"weighed_beside\":0.05", "\"weighed_beside\":0.06", "noise variances"),
        ("\"weighed_beside\":0.05", "\"weighed_beside\":-1.0", "noise variance"),
        ("\"mean\":\"linear\"", "\"mean\":{\"polynomial\":2}", "degrees of the mean"),
    ] {
        let damaged = text.replace(from, to);
        assert_ne!(damaged, text);
        let error = serde_json::from_str::<RffGp>(&damaged).unwrap_err().to_string();
        assert!(error.contains(what), "{error}");
    }
    let mut model: RffGpModel = serde_json::from_str(&text).unwrap();
    model.lengthscales[0] = 0.8;
    assert!(matches!(RffGp::from_model(&model), Err(GpError::Incompatible { .. })));
}

#[test]
fn what_does_not_go_together_is_an_error() {
    let (x, y, noise) = data(20);
    let features = features(Form::Paired);
    let mut plain = SufficientStatistics::new(&features, 0.0).unwrap();
    let refused = plain.update_with_row_noise(&features, x.as_ref(), &y, &noise).unwrap_err();
    assert!(matches!(refused, GpError::Incompatible { .. }), "{refused}");
    plain.update(&features, x.as_ref(), &y).unwrap();
    let late = plain.clone().with_mean(&features, Mean::Linear, &[0.0; 2]).unwrap_err();
    assert!(matches!(late, GpError::Incompatible { .. }), "{late}");
    let mut weighed = plain.with_row_noise(0.1).unwrap();
    weighed.update_with_row_noise(&features, x.as_ref(), &y, &noise).unwrap();
    let other = weighed.clone().with_row_noise(0.2).unwrap_err();
    assert!(matches!(other, GpError::Incompatible { .. }), "{other}");
    let mean = Mean::Estimated;
    let other = RffGp::from_statistics(features.clone(), weighed, 1.0, 0.2, mean).unwrap_err();
    assert!(matches!(other, GpError::Incompatible { .. }), "{other}");
    let fit = |noise: &[f64], mean| {
        RffGp::fit_with(features.clone(), (x.as_ref(), &y, noise), 1.0, 0.1, mean).unwrap_err()
    };
    assert!(matches!(fit(&[0.1], mean), GpError::ShapeMismatch { .. }));
    assert!(matches!(fit(&[-0.1; 20], mean), GpError::Negative { .. }));
    assert!(matches!(fit(&[], Mean::Polynomial(9)), GpError::OutOfRange { .. }));
    let flat = Mat::from_fn(9, 2, |i, d| if d == 0 { i as f64 } else { 1.0 });
    let data = (flat.as_ref(), &y[..9], &[][..]);
    let flat = RffGp::fit_with(features.clone(), data, 1.0, 0.1, Mean::Linear).unwrap_err();
    assert_eq!(flat, GpError::UndeterminedSlope { input: 1, n_rows: 9 });
    let curved = process(40, &[], Mean::Polynomial(2));
    assert_eq!(curved.expansion().unwrap_err(), GpError::PolynomialMean);
}
