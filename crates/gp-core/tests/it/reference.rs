//! Values computed with 60-digit arithmetic, from `fixtures/reference/gp-40-points.json`.
//!
//! The tolerance is 1e-9: the covariance has a condition number of about 1e2, so double precision
//! keeps some thirteen digits.

use faer::Mat;
use gp_core::{Gp, Kernel, Matern32, Matern52, Mean, SquaredExponential};
use serde_json::Value;

const TOLERANCE: f64 = 1e-9;

struct Reference {
    values: Value,
}

impl Reference {
    fn read() -> Self {
        let path =
            concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/reference/gp-40-points.json");
        let text = std::fs::read_to_string(path).unwrap();
        Self { values: serde_json::from_str(&text).unwrap() }
    }

    fn number(&self, pointer: &str) -> f64 {
        parse(self.values.pointer(pointer).unwrap())
    }

    fn numbers(&self, pointer: &str) -> Vec<f64> {
        self.values.pointer(pointer).unwrap().as_array().unwrap().iter().map(parse).collect()
    }

    fn column(&self, pointer: &str) -> Mat<f64> {
        let values = self.numbers(pointer);
        Mat::from_fn(values.len(), 1, |i, _| values[i])
    }

    fn gp(&self, kernel: impl Kernel + 'static) -> Gp {
        let (x, y) = (self.column("/x"), self.numbers("/y"));
        let noise_variance = self.number("/sn2");
        Gp::builder(kernel)
            .noise_variance(noise_variance)
            .mean(Mean::Fixed(0.0))
            .condition(x.as_ref(), &y)
            .unwrap()
    }

    fn check(&self, name: &str, gp: &Gp) {
        let at = |field: &str| format!("/{name}/{field}");
        close(&[gp.log_marginal_likelihood()], &[self.number(&at("lml"))]);
        let gradient = ["dlml_dlog_l", "dlml_dlog_sf2", "dlml_dlog_sn2"];
        let gradient: Vec<f64> = gradient.iter().map(|field| self.number(&at(field))).collect();
        close(&gp.log_marginal_likelihood_gradient().unwrap(), &gradient);
        let (mean, variance) = gp.predict(self.column("/x_test").as_ref()).unwrap();
        close(&mean, &self.numbers(&at("mean")));
        close(&variance, &self.numbers(&at("var_f")));
        let left_out = gp.leave_one_out().unwrap();
        close(&[left_out.total_log_density()], &[self.number(&at("loo_log_pred_density_sum"))]);
        close(&[left_out.mean[0]], &[self.number(&at("loo_mean_0"))]);
        close(&[left_out.variance[0]], &[self.number(&at("loo_var_y_0"))]);
    }
}

fn parse(value: &Value) -> f64 {
    value.as_str().unwrap().parse().unwrap()
}

fn close(actual: &[f64], expected: &[f64]) {
    assert_eq!(actual.len(), expected.len());
    for (actual, expected) in actual.iter().zip(expected) {
        assert!((actual - expected).abs() < TOLERANCE, "{actual} instead of {expected}");
    }
}

#[test]
fn the_squared_exponential_process_equals_the_reference() {
    let reference = Reference::read();
    let (l, variance) = (reference.number("/l"), reference.number("/sf2"));
    let gp = reference.gp(SquaredExponential::new(&[l], variance).unwrap());
    reference.check("se", &gp);
    let slope = gp.mean_gradient(reference.column("/x_test").as_ref()).unwrap();
    let slope: Vec<f64> = (0..slope.nrows()).map(|i| slope[(i, 0)]).collect();
    close(&slope, &reference.numbers("/se/dmean_dx"));
}

#[test]
fn the_matern_processes_equal_the_reference() {
    let reference = Reference::read();
    let (l, variance) = (reference.number("/l"), reference.number("/sf2"));
    reference.check("matern52", &reference.gp(Matern52::new(&[l], variance).unwrap()));
    reference.check("matern32", &reference.gp(Matern32::new(&[l], variance).unwrap()));
}
