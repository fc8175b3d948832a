//! Values computed with 60-digit arithmetic, from `fixtures/reference/gp-40-points.json`.
//!
//! The tolerance is 1e-9: K_uu has a condition number of about 1e3 there, so double precision keeps
//! some twelve digits.

use faer::Mat;
use gp_core::{Mean, Posterior, SquaredExponential};
use gp_sparse::{Approximation, SparseGp, SparseSettings};
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

    fn gp(&self, approximation: Approximation) -> SparseGp {
        let settings = SparseSettings { approximation, mean: Mean::Fixed(0.0), jitter: 0.0 };
        let kernel = SquaredExponential::new(&[self.number("/l")], self.number("/sf2")).unwrap();
        let (x, z, y) = (self.column("/x"), self.column("/Z"), self.numbers("/y"));
        SparseGp::fit(kernel, x.as_ref(), &y, z.as_ref(), self.number("/sn2"), settings).unwrap()
    }

    fn check_predictions(&self, name: &str, gp: &SparseGp) {
        let (mean, variance) = gp.predict(self.column("/x_test").as_ref()).unwrap();
        close(&mean, &self.numbers(&format!("/{name}/mean")));
        close(&variance, &self.numbers(&format!("/{name}/var_f")));
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
fn fitc_equals_the_reference() {
    let reference = Reference::read();
    let gp = reference.gp(Approximation::Fitc);
    close(&[gp.objective()], &[reference.number("/fitc/lml")]);
    reference.check_predictions("fitc", &gp);
}

#[test]
fn vfe_equals_the_reference() {
    let reference = Reference::read();
    let gp = reference.gp(Approximation::Vfe);
    close(&[gp.objective()], &[reference.number("/vfe/bound")]);
    reference.check_predictions("vfe", &gp);
}

#[test]
fn dtc_equals_the_reference() {
    let reference = Reference::read();
    let gp = reference.gp(Approximation::Dtc);
    close(&[gp.objective()], &[reference.number("/dtc/lml")]);
    // Its posterior over f is that of `Vfe`, from which it differs by the penalty alone.
    reference.check_predictions("vfe", &gp);
}

#[test]
fn power_ep_equals_the_reference() {
    let reference = Reference::read();
    let gp = reference.gp(Approximation::PowerEp { alpha: 0.5 });
    close(&[gp.objective()], &[reference.number("/power_ep_0.5/energy")]);
}
