//! `model.toml` of models that have no weights.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use anyhow::Result;
use dataset::SupportSpec;
use effects::{Rig, Setting, Surface};
use models::{
    Analytical, Base, Calibration, CharacteristicLength, ContactGap, Description, Estimate,
    ModelEffect, ModelFile, Noise, StepCorrelation, StepInput, SurfaceKind,
};
use nalgebra::Matrix3;
use planar::Shape;

use super::super::reader::{Reader, Verdict, not_finite};

/// Models in mechanics, with every effect.
pub(super) struct Models;

/// What models are built on.
pub(super) const SUPPORT: SupportSpec = SupportSpec { friction: 0.25, gravity: 9.81 };

impl Reader for Models {
    fn name(&self) -> &'static str {
        "model"
    }

    fn corpus(&self, dir: &Path) -> Result<Vec<Vec<u8>>> {
        let nominal = Analytical::nominal(0.25)?;
        let length =
            CharacteristicLength::Given(Estimate { se: 0.001, ..Estimate::exact(0.035, "a") });
        let given = Analytical::new(Estimate::exact(0.2, "b"), length, 1e-4 * Matrix3::identity())?;
        let rig = Rig::new(Surface::Ellipsoid, 0.25, 0.25)?;
        let mut inputs = Vec::new();
        let mut add = |analytical: Analytical, effects: Vec<ModelEffect>| -> Result<()> {
            let base = Base::Analytical(analytical);
            let description = Description { base, effects, weights: None };
            let path = dir.join("model.toml");
            let calibration = Some(calibration());
            ModelFile { calibration, ..ModelFile::new("a model", description) }.write(&path)?;
            inputs.push(fs::read(path)?);
            Ok(())
        };
        add(nominal.clone(), Vec::new())?;
        add(given, Vec::new())?;
        add(nominal.clone().with_surface(SurfaceKind::Points { n_points: 9 })?, Vec::new())?;
        for effects in effects::all().chunks(4) {
            let one = |effect: &Arc<dyn effects::Effect>| {
                let about = effect.info();
                ModelEffect::from(Setting::new(about, &about.typical(&rig)))
            };
            add(nominal.clone(), effects.iter().map(one).collect())?;
        }
        Ok(inputs)
    }

    fn tokens(&self) -> &'static [&'static str] {
        &[
            "kind = \"hybrid\"",
            "limit_surface = \"quartic\"",
            "\"uniform-patch\"",
            "\"points\"",
            "n_points = 10000",
            "se = -1e9",
            "unit = \"rad\"",
            "[[effects]]",
            "[learned]",
            "scatter_per_m",
            "[split]",
            "[calibration]",
            "characteristic_length",
            "id = \"inertia\"",
        ]
    }

    fn read(&self, dir: &Path, input: &[u8]) -> Verdict {
        let path = dir.join("model.toml");
        match fs::write(&path, input) {
            Ok(()) => Verdict::of(ModelFile::read(&path), wrong),
            Err(error) => Verdict::Wrong(format!("scratch is not usable: {error}")),
        }
    }
}

/// How sure a model may be of whole pushes.
fn calibration() -> Calibration {
    let correlation = StepCorrelation {
        held: [0.5, 0.25, 1.0],
        length: 0.05,
        own: [0.125, 0.0, 0.5],
        freedom: 5.0,
        measured: [0.0; 3],
        gap: ContactGap::default(),
        n_pushes: 9,
        n_steps: 90,
        ends: None,
    };
    Calibration {
        n_pushes: 9,
        widened: Some(1.5),
        scatter_per_m: Some([[0.5, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 8.0]]),
        correlation: Some(correlation),
    }
}

/// What is wrong with a file, and with what its model says of a step.
pub(super) fn wrong(file: &ModelFile) -> Option<String> {
    let Description { base, effects, .. } = &file.description;
    if let Base::Analytical(model) | Base::Hybrid(model) = base {
        let Estimate { value, se, .. } = model.pusher_friction();
        let numbers = [*value, *se];
        if let Some(wrong) = not_finite([("pusher friction", &numbers[..])]) {
            return Some(wrong);
        }
    }
    for effect in effects {
        let numbers: Vec<_> = effect.parameters.values().flat_map(|e| [e.value, e.se]).collect();
        if let Some(wrong) = not_finite([("a parameter", &numbers[..])]) {
            return Some(wrong);
        }
    }
    let calibrated = file.calibration.as_ref().map(|of| file.description.with(of)).transpose();
    let calibrated = calibrated.ok().flatten();
    predicted(&file.description).or_else(|| predicted(&calibrated?))
}

/// What is wrong with predictions, where the model gives some.
fn predicted(description: &Description) -> Option<String> {
    let model = description.build_in(SUPPORT, &[]).ok()?;
    let shape = Arc::new(Shape::square(0.09).ok()?);
    let step = StepInput::on_edge(shape, 0.00475, 1, 0.3, 0.2, 0.004).ok()?;
    let step = step.clone().lasting(0.2).unwrap_or(step);
    let said = model.predict(&[step], Noise::Included).ok()?;
    let numbers: Vec<f64> =
        said.iter().flat_map(|one| one.mean.iter().chain(one.covariance.iter()).copied()).collect();
    not_finite([("a prediction", &numbers[..])])
}
