//! Effects of one's own that carry data, in fits to the recorded fixture pushes.

use std::sync::Arc;

use diagnosis::{Fit, FitSettings, NoiseModel, Observations, fit};
use effects::{
    Channel, Effect, EffectInfo, MeasurementModel, Nuisance, Origin, Parameter, Stage, StepInput,
};
use models::{Analytical, PushModel};
use nalgebra::Vector2;

use crate::screen_laws::recorded;

/// A cable that pulls at the force sensor along a known direction.
#[derive(Debug)]
struct CablePull {
    direction_w: Vector2<f64>,
    info: EffectInfo,
}

const INFO: EffectInfo = EffectInfo {
    id: "cable-pull",
    title: "Pull of a cable",
    physics: "A cable pulls at the force sensor.",
    equation: "f_measured = f + c d, with d the direction",
    source: "made up",
    stages: &[Stage::Measurement],
    origin: Origin::Measurement,
    reaches: &[Channel::Force],
    parameters: &[Parameter::number("pull", "N", "Along the direction", (0.0, 0.1), (-5.0, 5.0))],
    confounders: &[],
    nuisance: Nuisance::No,
    shown_by: &[],
};

impl Effect for CablePull {
    fn info(&self) -> &EffectInfo {
        &self.info
    }

    fn measurement(&self, values: &[f64], _: &StepInput, measurement: &mut MeasurementModel) {
        measurement.force_bias_w += values[0] * self.direction_w;
    }
}

/// The nominal model with a cable of this direction.
fn fitted(asked: &[&str], x: f64, nuisance: Nuisance) -> Fit {
    let (table, manifest) = recorded();
    let observations = Observations::steady(&table, &manifest).unwrap();
    let model = Analytical::nominal(manifest.pusher.friction).unwrap().describe().unwrap();
    let info = EffectInfo { nuisance, ..INFO };
    let cable = CablePull { direction_w: Vector2::new(x, 0.0), info };
    let noise = NoiseModel::learn(&model, &[], &observations).unwrap();
    let whitening = noise.whitening(&model, &[], &observations).unwrap();
    let own: Vec<Arc<dyn Effect>> = vec![Arc::new(cable)];
    let settings = FitSettings { own, ..FitSettings::default() };
    fit(&observations, &model, asked, &whitening, &settings).unwrap()
}

#[test]
fn a_fit_goes_by_the_data_of_an_effect() {
    let pull = |x: f64| fitted(&[INFO.id], x, Nuisance::No).effects[0].parameters[0].value;
    let (along, back) = (pull(1.0), pull(-2.0));
    assert!(along.abs() > 1e-4, "{along}");
    assert!((back + 0.5 * along).abs() < 0.02 * along.abs(), "{along} {back}");
}

#[test]
fn a_fit_leaves_an_effect_open_that_says_it_is_a_nuisance() {
    let is_open = |nuisance| {
        let found = fitted(&["table-tilt"], 1.0, nuisance);
        found.coordinates.iter().any(|name| name == "cable-pull pull")
    };
    assert!(!is_open(Nuisance::No));
    assert!(is_open(Nuisance::Free { nominal_within: 0.1 }));
}
